# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a user waits for before the first step: a process that reads a scene, makes one step and ends.

Ours in four ways: from source, with an empty cache of kernels; from what came with the package,
with an empty cache too: bitcode alone, for a processor of no known level, and images; and every
later start. Another engine takes part where its module has `start`, which gives a program and what
it reads. Costs are processor time of the process and of what it started, the import of Python
packages with it; how long that was on the clock depends on what else the machine does, and stands
beside it.
"""

from __future__ import annotations

import compileall
import os
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import yaml

from rigid_body_sim import __version__
from rigid_body_sim.errors import RunError
from rigid_body_sim.physics.compile import kernels
from rigid_body_sim.report import peers
from rigid_body_sim.report.entry import ENGINE
from rigid_body_sim.report.measure import Progress
from rigid_body_sim.report.problems import PROBLEMS

PROBLEMS_STARTED = ('throughput', 'stack')  # a free body; ten boxes in contact
SOURCE, BITCODE = 'from source', 'from shipped bitcode'
IMAGE, LATER = 'from shipped images', 'every later start'
FROM_SOURCE = 3  # starts from source at most: each takes long
STEP = 0.005  # [s]
OURS = """
import sys
from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.physics.compile import kernels
if kernels.IMAGES is not None:
    kernels.IMAGES.takes_level = sys.argv[2] == 'image'
Simulation(load_scene(sys.argv[1])).step(1)
"""


@dataclass(frozen=True)
class Start:
    """
    How long a start took; its fields are those of the report.

    scene          : title of the problem whose scene it is
    way            : SOURCE, BITCODE, IMAGE, LATER, or what the engine calls it
    cost           : [s] of processor time, median; cost_low, cost_high: least and most
    wall           : [s] on the clock, median
    runs           : starts
    """

    engine: str
    version: str
    scene: str
    way: str
    cost: float
    cost_low: float
    cost_high: float
    wall: float
    runs: int


def measure(
    engines: Sequence[str], *, repetitions: int, progress: Progress = lambda _text: None
) -> list[dict[str, Any]]:
    """
    Measure starts of ours, and of other engines by their names as modules of `report.peers`.

    returns : rows with the fields of `Start`
    """
    found: list[Start] = []
    for name in PROBLEMS_STARTED:
        found += _of_ours(name, repetitions, progress)
        for engine in engines:
            found += _of_peer(engine, name, repetitions, progress)
    return [asdict(start) for start in found]


def _of_ours(name: str, repetitions: int, progress: Progress) -> Iterator[Start]:
    problem = PROBLEMS[name]
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        scene = folder / f'{name}.yaml'
        scene.write_text(yaml.safe_dump({**_mapping(name), 'dt': STEP}))
        progress(f'{problem.title}: what is to be shipped')
        plain, shipped = (_package(folder / name) for name in ('plain', 'shipped'))
        make = [sys.executable, '-m', 'rigid_body_sim', 'warm_up', str(scene), '--bitcode']
        _run(make, _environment(shipped, folder / 'made'), folder=shipped)
        for way in (SOURCE, BITCODE, IMAGE, LATER):
            package = shipped if way in (BITCODE, IMAGE) else plain
            command = [sys.executable, '-c', OURS, str(scene), 'image' * (way == IMAGE)]
            taken = []
            for run in range(min(repetitions, FROM_SOURCE) if way == SOURCE else repetitions):
                progress(f'{problem.title}: {way}, {run + 1}')
                cache = 'made' if way == LATER else f'{way} {run}'
                environment = _environment(package, folder / cache)
                taken.append(_run(command, environment, folder=package))
            yield _start(ENGINE, __version__, problem.title, way, taken)


def _mapping(name: str) -> dict[str, Any]:
    document = PROBLEMS[name].document
    assert isinstance(document, Mapping)
    return dict(document)


def _of_peer(engine: str, name: str, repetitions: int, progress: Progress) -> Iterator[Start]:
    given = peers.start_of(engine, PROBLEMS[name], STEP)
    if given is None:
        return
    taken = []
    for run in range(repetitions):
        progress(f'{PROBLEMS[name].title}: {given.engine}, {run + 1}')
        taken.append(_run([sys.executable, '-c', given.program], os.environ, given.reads))
    yield _start(given.engine, given.version, PROBLEMS[name].title, 'every start', taken)


def _package(folder: Path) -> Path:
    """Copy this package, without what may have been shipped with it, compiled as it is used."""
    source = Path(__file__).parents[1]
    shutil.copytree(
        source, folder / source.name, ignore=shutil.ignore_patterns(kernels.SHIPPED.name)
    )
    compileall.compile_dir(folder / source.name, quiet=1)
    return folder


def _environment(package: Path, cache: Path) -> Mapping[str, str]:
    """Environment in which a copy of the package is found, with a kernel cache of its own."""
    own = {'RIGID_BODY_SIM_CACHE': str(cache), 'NUMBA_CACHE_DIR': str(cache)}
    path = [str(package), *filter(None, [os.environ.get('PYTHONPATH')])]
    return os.environ | own | {'PYTHONPATH': os.pathsep.join(path)}


def _run(
    command: Sequence[str],
    environment: Mapping[str, str],
    reads: str = '',
    *,
    folder: Path | None = None,
) -> tuple[float, float]:
    """
    Run a process: processor time and time on the clock [s]; RunError if it fails.

    folder : where it runs: Python looks there first for what it imports
    """
    before, begin = _children(), time.perf_counter()
    done = subprocess.run(
        command,
        env=environment,
        cwd=folder,
        input=reads,
        text=True,
        capture_output=True,
        check=False,
    )
    wall = time.perf_counter() - begin
    if done.returncode:
        raise RunError(f'a start to be measured failed ({done.returncode}): {done.stderr[-400:]}')
    return _children() - before, wall


def _children() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _start(
    engine: str, version: str, scene: str, way: str, taken: Sequence[tuple[float, float]]
) -> Start:
    costs, walls = zip(*taken, strict=True)
    middle = statistics.median(costs)
    wall = statistics.median(walls)
    return Start(engine, version, scene, way, middle, min(costs), max(costs), wall, len(taken))
