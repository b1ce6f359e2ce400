# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The verbs: `python -m rigid_body_sim VERB …`, each also an executable of its own for `ros2 run
rigid_body_sim VERB`.

Exit codes: 0 done; 1 failed while running; 2 bad scene, parameter or argument; 3 replay differs;
130, 143, 129 stopped by SIGINT, SIGTERM, SIGHUP (`stop_signals`).
"""

from __future__ import annotations

import signal
import sys

# A signal may come at any moment: Ctrl-C ends all at once until it is listened to.
if __name__ == '__main__':
    signal.signal(signal.SIGINT, signal.SIG_DFL)

from rigid_body_sim.stop_signals import STOP, WORKING, Stopped, say
from rigid_body_sim.terminal import (
    OutputFull,
    clean_output,
    not_written,
    open_closed_streams,
    printable,
    take_any_terminal,
)

if __name__ == '__main__':
    open_closed_streams()
    STOP.listen(owns_process=True)
    STOP.quits = 0 if sys.argv[1:2] == ['sim_node'] else None

import importlib
import os
from collections.abc import Sequence

from rigid_body_sim import __version__
from rigid_body_sim.command_line import CommandLine
from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.missing_packages import missing

NODE = 'sim_node'  # whose normal end is a signal
VERBS = {
    'sim_node': 'the ROS 2 node: wrenches in, poses and twists out, a bag on request',
    'simulate': 'run a scene without ROS, as fast as possible, into a bag',
    'inspect': 'mass, inertia and axes of every body; what each integrator may do at this dt',
    'replay': 're-run a bag from its own scene and commands and compare bit by bit',
    'bag': 'look after recordings: info, check, recover, diff',
    'view': 'draw a run: trajectories, energy, drift, contact forces (PNG); or play it (HTML)',
    'sweep': 'run a scene many times with keys that differ; one row of a table a run',
    'report': 'speed against error of every method: tables, plots, one HTML page',
    'export': 'poses, twists, wrenches and energies of a bag as one table: CSV or Parquet',
    'inverse': 'from positions to velocities, accelerations and the wrench that explains them',
    'list': 'what there is: scenes, integrators, forces, shapes, problems, a line each',
    'warm_up': 'compile beforehand what scenes will need',
    'wrench_pub': 'publish commands to a body, or those of a bag',
}


def main(argv: Sequence[str] | None = None) -> int:
    """Run one verb; return its exit code."""
    take_any_terminal()
    words = list(sys.argv[1:] if argv is None else argv)
    if not words or words[0] in ('-h', '--help'):
        return _show(_overview()) or (0 if words else 2)
    if words[0] == '--version':
        return _show(__version__)
    if words[0].replace('-', '_') in VERBS:  # warm-up is warm_up
        words[0] = words[0].replace('-', '_')
    if words[0] not in VERBS:
        from rigid_body_sim.physics.errors import choose_from
        from rigid_body_sim.physics.model.numbers import shown

        cure = choose_from(words[0], VERBS)
        say(f'rigid_body_sim: error: unknown verb {shown(words[0])}{cure}')
        return 2
    return run_verb(words[0], words[1:])


@clean_output()
def run_verb(verb: str, words: Sequence[str]) -> int:
    """Run one verb with its own words; turn what it raises into one line and an exit code."""
    listens = STOP.listen(owns_process=False)
    STOP.verb, STOP.quits = verb, 0 if verb == NODE else None
    try:
        return _run_verb(verb, words)
    finally:
        if listens:
            STOP.restore()


def _run_verb(verb: str, words: Sequence[str]) -> int:
    try:
        module = importlib.import_module(f'rigid_body_sim.verbs.{verb}')
    except ModuleNotFoundError as error:
        return _fail_without(verb, error)
    parser = CommandLine(prog=f'rigid_body_sim {verb}', description=module.__doc__)
    module.add_arguments(parser)
    own, for_ros = list(words), []
    if getattr(module, 'TAKES_ROS_ARGUMENTS', False):
        own, for_ros = _split(words)
    from rigid_body_sim.physics.errors import InvalidModel, SimulationDiverged

    try:
        known = parser.parse_args(own)
        known.ros_arguments = for_ros
        STOP.stage = WORKING
        code = module.run(known)
        sys.stdout.flush()  # where it is full, that is said here, and not when Python ends
        return code
    except OutputFull as error:
        _leave_output()
        return _fail(verb, str(error), 1)
    except (UserError, RunError) as error:
        return _fail(verb, str(error), error.exit_code)
    except InvalidModel as error:
        return _fail(verb, str(error), 2)
    except ModuleNotFoundError as error:  # of what is imported where it is needed
        return _fail_without(verb, error)
    except BrokenPipeError:  # whoever read our output has seen enough
        _leave_output()
        return 0
    except Stopped as stopped:
        say(f'rigid_body_sim {verb}: stopped by {STOP.name} {stopped}')
        return STOP.exit_code
    except SimulationDiverged as error:
        return _fail(verb, str(error), 1)
    except OSError as error:
        named = error.filename is not None and error.strerror
        return _fail(verb, f'{error.filename}: {error.strerror}' if named else str(error), 1)
    except MemoryError:
        return _fail(verb, 'out of memory; take fewer bodies, or a shorter or rarer output', 1)


def _leave_output() -> None:
    """Let nothing more be written to standard output, not even when the process ends."""
    sys.stdout = open(os.devnull, 'w')  # noqa: PTH123, SIM115  (until the process ends)


def _show(text: str) -> int:
    """Print what was asked for; returns the exit code."""
    try:
        print(text, flush=True)
    except BrokenPipeError:
        _leave_output()
    except OSError as error:
        _leave_output()
        say(f'rigid_body_sim: error: {not_written(error)}')
        return 1
    return 0


def _fail_without(verb: str, error: ModuleNotFoundError) -> int:
    """Name the package that is missing; one of our own is an error of ours."""
    if error.name is None or error.name.partition('.')[0] == 'rigid_body_sim':
        raise error
    return _fail(verb, missing(error.name), 2)


def _split(words: Sequence[str]) -> tuple[list[str], list[str]]:
    """Part a verb's own words from those between `--ros-args` and `--`, which are for ROS."""
    own: list[str] = []
    for_ros: list[str] = []
    target = own
    for word in words:
        if word == '--ros-args':
            target = for_ros
        elif word == '--' and target is for_ros:
            target = own
            continue
        target.append(word)
    return own, for_ros


def _fail(verb: str, message: str, code: int) -> int:
    """Say on one line what went wrong; what is not printable, as in a foreign name, is escaped."""
    say(f'rigid_body_sim {verb}: error: {printable(message.strip())}')
    return code


def _overview() -> str:
    width = max(map(len, VERBS))
    lines = [f'  {verb:{width}}  {summary}' for verb, summary in VERBS.items()]
    return '\n'.join(
        [
            'usage: python -m rigid_body_sim VERB …      (or: ros2 run rigid_body_sim VERB …)',
            '',
            *lines,
            '',
            'VERB --help tells the rest.',
        ]
    )


def command() -> int:
    """Entry point of the executable `rigid_body_sim` that pip installs: `rigid_body_sim VERB`."""
    open_closed_streams()
    STOP.listen(owns_process=True)
    code = main()
    STOP.ignore()
    return code


def _process(verb: str) -> int:
    """Run one verb as all that this process does."""
    open_closed_streams()
    STOP.listen(owns_process=True)
    code = run_verb(verb, sys.argv[1:])
    STOP.ignore()
    return code


def sim_node() -> int:
    """Entry point of the executable `sim_node`."""
    return _process('sim_node')


def simulate() -> int:
    """Entry point of the executable `simulate`."""
    return _process('simulate')


def replay() -> int:
    """Entry point of the executable `replay`."""
    return _process('replay')


def bag() -> int:
    """Entry point of the executable `bag`."""
    return _process('bag')


def inspect() -> int:
    """Entry point of the executable `inspect`."""
    return _process('inspect')


def view() -> int:
    """Entry point of the executable `view`."""
    return _process('view')


def report() -> int:
    """Entry point of the executable `report`."""
    return _process('report')


def export() -> int:
    """Entry point of the executable `export`."""
    return _process('export')


def list_what_there_is() -> int:
    """Entry point of the executable `list`."""
    return _process('list')


def sweep() -> int:
    """Entry point of the executable `sweep`."""
    return _process('sweep')


def inverse() -> int:
    """Entry point of the executable `inverse`."""
    return _process('inverse')


def warm_up() -> int:
    """Entry point of the executable `warm_up`."""
    return _process('warm_up')


def wrench_pub() -> int:
    """Entry point of the executable `wrench_pub`."""
    return _process('wrench_pub')


if __name__ == '__main__':
    exit_code = main()
    STOP.ignore()
    sys.exit(exit_code)
