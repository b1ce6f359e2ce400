# `make demo` and `make test` need nothing but a Python; `make help` lists the rest.

ROOT := $(patsubst %/,%,$(dir $(abspath $(lastword $(MAKEFILE_LIST)))))
PYTHON := $(ROOT)/.venv/bin/python
PYTEST_ARGS ?=
# Three workers for two cores: some wait for nodes and browsers. Which tests each of them gets says test/conftest.py.
WORKERS := -p hypothesispytest -p xdist -n 3
REPORT_ARGS ?=
BENCH_ARGS ?=

# The package is run from this tree. A foreign PYTHONPATH counts only where a ROS 2 is sourced.
export PYTHONPATH := $(ROOT)$(if $(ROS_DISTRO),:$(PYTHONPATH))
# The ROS wheels restart Python once; a parent's mark would keep them from doing so.
unexport _ROS_WHEELS_BOOTSTRAP_COMPLETE PYTHONHOME
# Each of some hundred processes of the tests would compile all modules again.
unexport PYTHONDONTWRITEBYTECODE
# Whatever is cached or logged stays in .venv, also where HOME is not writable.
export RIGID_BODY_SIM_CACHE := $(ROOT)/.venv/cache
export NUMBA_CACHE_DIR := $(RIGID_BODY_SIM_CACHE)
export HYPOTHESIS_STORAGE_DIRECTORY := $(ROOT)/.venv/cache/hypothesis
export MPLCONFIGDIR := $(ROOT)/.venv/cache/matplotlib
export ROS_LOG_DIR := $(ROOT)/.venv/log
# Nobody outside this machine, and no other run on it, is heard (ports of domains above 101 are not safe).
export ROS_AUTOMATIC_DISCOVERY_RANGE := LOCALHOST
export ROS_DOMAIN_ID := $(shell echo $$((1 + $$$$ % 100)))
# Plugins of a sourced ROS belong to another pytest.
export PYTEST_DISABLE_PLUGIN_AUTOLOAD := 1

.PHONY: help venv demo test test-long test-stability test-bounds coverage lint bench bench-all docs report report-peers document wheel clean
help:  ## this list
	@sed -n 's/^\([a-z-]*\):.*## /\1\t/p' $(ROOT)/Makefile

venv:  ## make .venv with the pinned requirements, if it is not complete
	@sh $(ROOT)/tools/make_venv.sh

demo:  ## node, commands from a second process, bag, replay, picture
	@sh $(ROOT)/tools/make_venv.sh demo
	@cd $(ROOT) && $(PYTHON) tools/demo.py

test: venv  ## the whole test suite; PYTEST_ARGS='-k name' for a part
	@cd $(ROOT) && $(PYTHON) -m pytest -q $(WORKERS) $(PYTEST_ARGS)

test-long: venv  ## what `make test` leaves out: a law on every method that may obey it, long runs; some minutes
	@cd $(ROOT) && $(PYTHON) -m pytest -q $(WORKERS) -m long $(PYTEST_ARGS)

test-stability: venv  ## the hard cases in full: 1e7 ticks, 1e4 s, every method; some minutes
	@cd $(ROOT) && $(PYTHON) -m pytest -q $(WORKERS) -m 'long or not long' $(PYTEST_ARGS) test/stability

# Lines and branches of Python; kernels are left out, see pyproject.toml. On a full disk coverage cannot write either.
coverage: venv  ## the whole test suite, and which lines it runs; fails below the floor
	@cd $(ROOT) && $(PYTHON) -m pytest -q $(WORKERS) -p pytest_cov --cov --cov-report=term:skip-covered --deselect test/ros/test_recording.py::test_a_full_disk_ends_the_run_with_1_and_says_what_is_safe $(PYTEST_ARGS)

# Compiled anew into a folder of its own, with every index checked against its array.
test-bounds: venv  ## the tests of what is compiled, each index of each array checked; half an hour
	@cd $(ROOT) && NUMBA_BOUNDSCHECK=1 RIGID_BODY_SIM_CACHE=$(ROOT)/.venv/cache/bounds $(PYTHON) -m pytest -q $(WORKERS) $(PYTEST_ARGS) test/contact test/integrators test/laws test/stability

lint: venv  ## ruff and pyright
	@cd $(ROOT) && .venv/bin/ruff check && .venv/bin/ruff format --check && .venv/bin/pyright

docs: venv  ## the pages as a site that needs no network: docs/_build/index.html; a warning is an error
	@cd $(ROOT) && $(PYTHON) -m sphinx -W --keep-going -q -b html docs docs/_build
	@echo "$(ROOT)/docs/_build/index.html"

# `report` replaces none: the one before goes aside, and the one before that goes.
ASIDE = if [ -e report_output/report.json ]; then rm -rf report_output.before && mv report_output report_output.before; fi

report: venv  ## speed against error of every method: report_output/report.html, some minutes
	@cd $(ROOT) && $(ASIDE) && $(PYTHON) -m rigid_body_sim report -o report_output $(REPORT_ARGS)

report-peers: venv  ## the same beside MuJoCo, Drake, DART, Pinocchio and Rapier: installs them, 1 GB
	@cd $(ROOT) && sed -n 's/^\([a-z].*\)/\1/p' benchmark/peers.txt | while read -r peer; do \
		$(PYTHON) -m pip install --quiet --disable-pip-version-check -c requirements/runtime.txt "$$peer" || \
		echo "$$peer could not be installed: the report goes on without it"; done
	@cd $(ROOT) && $(ASIDE) && $(PYTHON) -m rigid_body_sim report --peers --starts -o report_output $(REPORT_ARGS)

wheel: venv  ## a wheel with machine code and bitcode of all shipped scenes: its first start compiles nothing; some minutes
	@cd $(ROOT) && $(PYTHON) -m rigid_body_sim warm_up --bitcode -j 2
	@cd $(ROOT) && $(PYTHON) -m pip wheel --no-deps --wheel-dir dist .

document: report-peers  ## docs/speed_against_error.md anew, from a report beside other engines
	@cd $(ROOT) && $(PYTHON) -m rigid_body_sim.report.markdown report_output docs/speed_against_error.md

bench: venv  ## has anything become slower than in the commit before? BENCH_ARGS=REVISION for another one
	@cd $(ROOT) && $(PYTHON) benchmark/two_checkouts.py $(BENCH_ARGS)

bench-all: venv  ## the figures that tests must not judge: costs, start-up, real-time behaviour
	@cd $(ROOT) && $(PYTHON) benchmark/run.py

clean:  ## remove .venv and everything built
	@cd $(ROOT) && rm -rf .venv build dist rigid_body_sim/physics/compile/shipped install log .pytest_cache .hypothesis .ruff_cache *.egg-info
