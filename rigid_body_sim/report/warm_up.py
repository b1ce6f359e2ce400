# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Compile first, measure then: all kernels of a report, by two processes where they are not cached.

This process goes through the list from its start. If the first kernel has to be compiled, a second
process goes through it from its end and leaves what it made in the cache on disk; they meet. When
the clock runs, it is gone.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Sequence

from rigid_body_sim.physics.compile import kernels
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.report.measure import Progress
from rigid_body_sim.report.method import method
from rigid_body_sim.report.problems import PROBLEMS

COMPILED = 0.5  # [s] a kernel that takes longer to be ready was not in the cache


_helpers: list[subprocess.Popen[bytes]] = []


def warm_up(problems: Sequence[str], methods: Sequence[str], progress: Progress) -> None:
    """
    Make every kernel ready.

    methods : none: those of each problem
    """
    if not kernels.COMPILED:
        return
    work = [(name, text) for name in problems for text in methods or PROBLEMS[name].integrators]
    try:
        for done, (problem, text) in enumerate(work, 1):
            progress(f'kernels, {done} of {len(work)}: {text} for {problem}')
            begin = time.monotonic()
            make_ready(problem, text)
            is_new = time.monotonic() - begin > COMPILED
            if not _helpers and is_new and kernels.CACHE is not None:
                _helpers.append(_helper(work[done + 1 :]))
    finally:
        end_helpers()


def end_helpers() -> None:
    """End the second process, if there is one; also for a process that ends in the middle."""
    while _helpers:
        helper = _helpers.pop()
        helper.terminate()
        helper.wait()


def make_ready(problem: str, text: str) -> None:
    """Compile what one method needs on one problem, or find it in the cache."""
    of = PROBLEMS[problem]
    given = method(text)
    try:
        simulation = Simulation(
            given.scene_of(of.scene(1)),
            integrator=given.integrator,
            integrator_options=given.options,
            dt=of.steps[-1],
        )
    except InvalidModel:
        return
    simulation.prepare()
    simulation.accelerations()


def _helper(work: Sequence[tuple[str, str]]) -> subprocess.Popen[bytes]:
    """Start the second process; what it says is of no interest."""
    return subprocess.Popen(
        [sys.executable, '-m', __name__, json.dumps(work)],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )


def main() -> None:
    """Go through the list from its end."""
    for problem, text in reversed(json.loads(sys.argv[1])):
        make_ready(problem, text)


if __name__ == '__main__':
    main()
