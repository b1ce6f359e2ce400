# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
`warm_up [SCENE …]`: compile now what scenes will need, so that no run has to wait for it.

What is made lies in the cache of this user ($RIGID_BODY_SIM_CACHE or ~/.cache/rigid_body_sim),
for this processor, until the sources of the package or numba change: run it in the image of a
container, or once on a new machine. With --bitcode it also makes what a package can be shipped
with, so that a first start need not wait: machine code for two levels of x86-64, and bitcode, from
which that of any processor is made in seconds.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.physics.compile import kernels
from rigid_body_sim.physics.compile.kernels import warn_if_plain
from rigid_body_sim.recording.new_output import not_written
from rigid_body_sim.runs.simulation_of_scene import simulation_of
from rigid_body_sim.scene import load_scene
from rigid_body_sim.scene.shipped_scenes import find_scene, shipped_scenes
from rigid_body_sim.terminal import printable

SUMMARY = 'compile beforehand what scenes will need'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command line."""
    parser.add_argument(
        'scene', nargs='*', help='scene files or names of shipped scenes; default: all shipped'
    )
    parser.add_argument('--integrator', metavar='NAME', help='default: of each scene')
    parser.add_argument(
        '--bitcode',
        nargs='?',
        const=kernels.SHIPPED,
        type=Path,
        metavar='FOLDER',
        help='keep too what a package is shipped with, bitcode of no processor and images for '
        'the levels of x86-64; default: in this package, before it is built',
    )
    parser.add_argument(
        '-j', '--jobs', type=int, default=1, metavar='N', help='processes at once (1)'
    )


def run(arguments: argparse.Namespace) -> int:
    """Make the kernels of each scene ready; a line each."""
    warn_if_plain()
    if not kernels.COMPILED:
        raise UserError(
            'nothing is compiled here: '
            + (kernels.WITHOUT_NUMBA or 'RIGID_BODY_SIM_COMPILE=0 or NUMBA_DISABLE_JIT is set')
        )
    if kernels.CACHE is None and arguments.bitcode is None:
        raise UserError('no folder takes kernels: set RIGID_BODY_SIM_CACHE to one of your own')
    if arguments.bitcode is not None:
        _check_folder(arguments.bitcode)
    if arguments.jobs < 1:
        raise UserError(f'--jobs {arguments.jobs}: must be 1 or more')
    scenes = arguments.scene or sorted(shipped_scenes())
    if len(scenes) == 1:
        _make_ready(scenes[0], arguments.integrator, arguments.bitcode)
        return 0
    more = ['--integrator', arguments.integrator] if arguments.integrator else []
    if arguments.bitcode is not None:
        more += ['--bitcode', str(arguments.bitcode)]
    for scene in arguments.scene:
        find_scene(scene)  # who misspelt one learns it at once
    failed = _apart(scenes, more, arguments.jobs)
    if failed:
        raise RunError(f'not made ready: {", ".join(map(printable, failed))}')
    return 0


def _check_folder(folder: Path) -> None:
    """Refuse before minutes are spent: a scene in place of a folder, one that takes nothing."""
    if folder.is_file() or (str(folder) in shipped_scenes() and not folder.exists()):
        raise UserError(
            f'--bitcode {folder}: a folder is needed, and this is a scene; put the scene first: '
            f'warm_up {folder} --bitcode'
        )
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise not_written(folder, error, 'name a folder of your own: --bitcode FOLDER') from None


def _make_ready(asked: str, integrator: str | None, bitcode: Path | None) -> None:
    """Compile what `simulate` and the node call, or find it; one line says how long that took."""
    begin = time.monotonic()
    if bitcode is not None:
        if kernels.IMAGES is None:
            raise UserError('--bitcode: only with numba 0.68 on Linux and x86-64, and unset')
        kernels.IMAGES.save_to(bitcode / f'kernels-{kernels.digest_of_sources()}')
    if kernels.IMAGES is not None:
        kernels.IMAGES.takes_level = False  # who waits now gets what is made for this processor
    simulation = simulation_of(load_scene(find_scene(asked)), integrator=integrator)
    simulation.prepare(commands_in_body_axes=True)
    simulation.keep_energy_balance()
    simulation.step(1)
    simulation.energy_balance()
    simulation.accelerations()
    simulation.contacts()
    made = kernels.IMAGES.made if kernels.IMAGES is not None else []
    what = f'{len(made)} kernels made' if made else 'ready before'
    print(f'{printable(asked)}: {what}, {time.monotonic() - begin:.1f} s', flush=True)


def _apart(scenes: Sequence[str], more: Sequence[str], jobs: int) -> list[str]:
    """
    Make each scene ready in a process of its own, which gives back what compiling takes: 600 MB.

    returns : those that failed; why was said
    """
    waiting, failed = list(reversed(scenes)), []
    running: dict[str, subprocess.Popen[bytes]] = {}
    try:
        while waiting or running:
            while waiting and len(running) < jobs:
                command = [sys.executable, '-m', 'rigid_body_sim', 'warm_up', *more, waiting[-1]]
                running[waiting.pop()] = subprocess.Popen(command, stdin=subprocess.DEVNULL)
            for scene, process in list(running.items()):
                if process.poll() is not None:
                    failed += [scene] * (process.returncode != 0)
                    del running[scene]
            time.sleep(0.02)
    finally:
        for process in running.values():
            process.terminate()
            process.wait()
    return failed
