# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A run in memory, made again from its start with its commands at their ticks: bit for bit the same.

That is how it becomes a bag (`to_bag`), and how what nobody kept on the way is found (`account`).
"""

from __future__ import annotations

from collections.abc import Iterator

from rigid_body_sim.errors import RunError
from rigid_body_sim.library.run_arrays import Origin, RunArrays
from rigid_body_sim.physics.model.named_frames import SEPARATOR
from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.runs import run as runs
from rigid_body_sim.runs.commands import Command
from rigid_body_sim.scene.writing import with_text


class MadeAgain:
    """
    The run, standing at its start.

    run : takes commands and packs messages
    """

    def __init__(self, run: RunArrays) -> None:
        assert run._origin is not None and run._ticks is not None, 'it came from a bag'
        self._origin: Origin = run._origin
        first, self._last, per = run._ticks
        simulation = Simulation.__new__(Simulation)
        start = self._origin.start
        simulation.__setstate__({**start, 'scene': with_text(start['scene'])})
        if simulation.watch is not None:  # what `auto` did is done again, not chosen again
            simulation.follow_choices(self._origin.choices)
        settings = runs.RunSettings(
            command_timeout_ns=0, publish_every=per, publish_phase=first % per
        )
        self.run = runs.Run(simulation, settings)

    def follow(self) -> Iterator[tuple[int, runs.TickOutput]]:
        """Advance to the end, see `runs.run.Run.follow`."""
        dt_ns = self.run.simulation.dt_ns
        commands: dict[int, list[Command]] = {}
        for tick, body, force, torque, frame in self._origin.commands:
            x = Command(
                body,
                'wrench',
                (force[0], force[1], force[2]),
                (torque[0], torque[1], torque[2]),
                frame_id=_frame_id(body, frame),
                stamp_ns=tick * dt_ns,
            )
            commands.setdefault(tick, []).append(x)
        yield from self.run.follow(commands, self._last)

    def check(self, what: str) -> None:
        """Refuse where it came out otherwise; RunError that begins with `what` is not done."""
        if self.run.simulation.state_bytes() != self._origin.final:
            raise RunError(
                f'{what}: made again, the run ends in another state; something else than its '
                'controller changed the simulation on the way (set_wrench, apply_impulse or '
                'set_state from inside the controller); answer wrenches in place of that'
            )


def _frame_id(body: str, frame: str) -> str:
    """Name a frame as a message does."""
    if frame in ('world', 'body'):
        return {'world': '', 'body': body}[frame]
    return f'{body}{SEPARATOR}{frame.removeprefix(body + SEPARATOR)}'
