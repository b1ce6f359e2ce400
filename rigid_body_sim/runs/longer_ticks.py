# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Ticks longer than the scene's dt, for `auto` with `longer_steps: true`, where nobody listens in
between.

Only `simulate` knows all that listens before it begins: the published states, the commands with
the ticks on which they end, and the end of the run. All of them are counted in ticks of the scene,
so the longest tick that meets each is their greatest common divisor. `auto` then divides it again,
as far as its tolerance asks. The run has that tick in all that it says and records, so a replay,
an interrupt or `step` know of nothing special.

Not where bodies meet (contact wants its own tick), where a --dt was asked for, nor elsewhere than
in `simulate`: the node takes commands at every tick, and `Simulation.step` may be read after each.
Between the states of a run with longer steps there is nothing: no look at limits or drift either.
"""

from __future__ import annotations

import math
from pathlib import Path

from rigid_body_sim.physics.integration.choose import NAME, configured
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.runs.commands import read_csv
from rigid_body_sim.runs.run import publish_every

LONGEST = 0.1  # [s] a tick is not made longer than that


def wants_longer(scene: Scene, integrator: str | None) -> bool:
    """Whether the scene asks `auto` for longer steps, and none of its bodies meet."""
    if (integrator or scene.integrator) != NAME or scene.integrator != NAME:
        return False
    if scene.contact.get('mode', 'none') != 'none':
        return False
    return bool(configured(scene.integrator_options)['longer_steps'])


def longer_dt(
    scene: Scene,
    integrator: str | None,
    *,
    duration: float,
    rate_hz: float,
    timeout: float,
    commands: Path | None,
) -> float | None:
    """
    Length of the longest tick [s] that meets all that listens; None: the scene's.

    duration : [s] of the run
    rate_hz  : of published states
    timeout  : [s] after which a command ends; 0: never
    commands : CSV file of `runs.commands.read_csv`
    """
    if not wants_longer(scene, integrator):
        return None
    if not (0.0 < duration < 2.0**31 and 0.0 <= timeout <= 1e9):
        return None  # which is refused where they are read
    listened = [publish_every(rate_hz, scene.dt_ns), round(duration * 1e9 / scene.dt_ns)]
    if commands is not None:
        listened += [tick for tick, _ in read_csv(commands, scene, dt_ns=scene.dt_ns)]
        listened.append(-(-round(timeout * 1e9) // scene.dt_ns))
    times = math.gcd(*listened)
    most = max(1, int(LONGEST * 1e9) // scene.dt_ns)
    while times > most:  # by its smallest divisor
        times //= next(d for d in range(2, times + 1) if times % d == 0)
    return times * scene.dt_ns / 1e9 if times > 1 else None


def said(scene: Scene, dt_ns: int) -> str:
    """Say that the ticks of a run are longer than the scene's."""
    return (
        f'ticks of {dt_ns * 1e-9:g} s in place of {scene.dt_ns * 1e-9:g} s, as nobody listens in '
        'between (longer_steps)'
    )
