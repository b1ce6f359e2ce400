# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""`make bench`: two checkouts beside each other."""

import importlib.util
import random
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
# the package of a small repository: reading a scene takes as long as one wants
SLOW_READER = """
def load_scene(text):
    total = 0
    for i in range({work}):
        total += i & 3
    return total
"""


@pytest.fixture(scope='module')
def bench():
    spec = importlib.util.spec_from_file_location(
        'two_checkouts', ROOT / 'benchmark' / 'two_checkouts.py'
    )
    module = importlib.util.module_from_spec(spec)
    sys.modules['two_checkouts'] = module  # where its dataclasses look for their names
    spec.loader.exec_module(module)
    module.LASTS = 0.01  # [s] a turn: twice the work is seen in that too
    return module


@pytest.fixture
def repository(tmp_path):
    """Make a repository; give what commits a package whose `load_scene` works so much."""
    folder = tmp_path / 'repository'
    package = folder / 'rigid_body_sim'
    package.mkdir(parents=True)

    def git(*words):
        identity = ('-c', 'user.name=a', '-c', 'user.email=a@example.org')
        done = subprocess.run(
            ['git', *identity, *words], cwd=folder, capture_output=True, text=True, check=True
        )
        return done.stdout

    def commit(work, *, save=True):
        (package / '__init__.py').write_text(SLOW_READER.format(work=work))
        if save:
            git('add', '.')
            git('commit', '-q', '-m', f'work {work}')
        return git

    git('init', '-q')
    commit.folder = folder
    return commit


LOADING = ('--only', 'load_scene, 100 bodies', '--rounds', '8', '--visits', '2')


def test_what_became_slower_is_named_with_how_much_and_the_worktree_is_gone(
    bench, repository, capfd
):
    repository(20_000)
    git = repository(40_000)
    assert bench.main(LOADING, folder=repository.folder) == 1
    out, err = capfd.readouterr()
    assert 'HEAD~1' in out and 'work 20000' in out and 'SLOWER' in out
    (line,) = err.splitlines()
    assert line.startswith('bench: slower: load_scene, 100 bodies: ')
    # twice the same loop; a third of it for the weather
    assert 70.0 < float(line.split(': ')[3].split(' %')[0]) < 130.0
    assert len(git('worktree', 'list').splitlines()) == 1


@pytest.mark.long
def test_a_faster_commit_passes_and_what_is_not_committed_is_compared_with_it(
    bench, repository, capfd
):
    repository(40_000)
    repository(20_000)
    assert bench.main(LOADING, folder=repository.folder) == 0
    assert 'faster' in capfd.readouterr().out
    repository(40_000, save=False)
    assert bench.main(LOADING, folder=repository.folder) == 1
    assert 'other: HEAD (' in capfd.readouterr().out


def test_what_an_older_checkout_cannot_do_is_left_out_with_its_reason(bench, repository, capfd):
    repository(1000)
    git = repository(1001)
    cases = ('--only', 'one free body', 'load_scene, 100 bodies', *LOADING[2:])
    assert bench.main(cases, folder=repository.folder) in (0, 1)
    out = capfd.readouterr().out
    assert "not compared: ImportError: cannot import name 'Simulation'" in out
    assert 'load_scene, 100 bodies  ' in out
    assert bench.main(('nowhere', *LOADING), folder=repository.folder) == 2
    assert 'bench: error: git rev-parse' in capfd.readouterr().err
    assert len(git('worktree', 'list').splitlines()) == 1


def drawn(seed, *, slower, noise=0.02, layout=0.0, visits=3, rounds=7):
    """Ratios of two checkouts; layout: what the processes of a visit differ by."""
    rng = random.Random(seed)
    return [
        [(1.0 + slower) * shift * rng.lognormvariate(0.0, noise) for _ in range(rounds)]
        for shift in (rng.lognormvariate(0.0, layout) for _ in range(visits))
    ]


def test_equal_checkouts_are_not_called_slower_and_ten_per_cent_are_found(bench):
    """2 % of noise in a round, 4 % by where the memory of a process lies."""
    equal = [bench.verdict(drawn(i, slower=0.0, layout=0.04)) for i in range(1000)]
    slower = [bench.verdict(drawn(i, slower=0.1, layout=0.02)) for i in range(1000)]
    assert sum(v.slower for v in equal) < 60  # and in both of two opinions: fewer than 4
    assert sum(v.slower for v in slower) > 950
    assert not any(v.faster for v in slower)


def test_bound_of_the_median_is_that_of_the_binomial_law(bench):
    # 2^-8 = 0.004: of eight ratios the least is above the median by that chance
    assert bench.rank_of_bound(7) == -1
    assert bench.rank_of_bound(8) == 0
    assert bench.rank_of_bound(21) == 4  # P(at most 4 of 21) = 0.0036, of 5: 0.013
    assert bench.verdict([[1.02] * 10] * 2).slower is False, 'less than is tolerated'
    assert bench.verdict([[1.2] * 10, [0.99] * 3]).slower is False, 'one visit says otherwise'
    assert bench.verdict([[1.2] * 10, [1.1] * 3]).slower is True


def test_cases_cover_what_people_wait_for(bench):
    names = ' '.join(bench.CASES)
    ticks = ('free', 'stack', 'boxes', 'spheres', 'hulls', 'loop')
    for part in (*ticks, 'load_scene', 'closing a bag', 'replay', 'start'):
        assert part in names
