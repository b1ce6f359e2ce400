# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A simulation as Python users hold it: it runs into arrays, and is saved and loaded."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from rigid_body_sim.library.run import Run
from rigid_body_sim.library.stretch import Controller, follow
from rigid_body_sim.physics import simulation as physics
from rigid_body_sim.physics.compile.kernels import warn_if_plain
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.scene import load_scene

AnyScene = Scene | str | Path | Mapping[str, Any] | bytes


class Simulation(physics.Simulation):
    """
    One run of one scene: `physics.simulation.Simulation`, and what keeps its history.

    scene : a Scene, or whatever `load_scene` takes: the name of a shipped scene, a path, a mapping
    """

    def __init__(
        self,
        scene: AnyScene,
        *,
        integrator: str | Mapping[str, Any] | None = None,
        integrator_options: Mapping[str, Any] | None = None,
        dt: float | None = None,
        progress: Callable[[str], None] | None = None,
    ) -> None:
        warn_if_plain()  # of the line that calls this
        if not isinstance(scene, Scene):
            scene = load_scene(scene)
        super().__init__(
            scene,
            integrator=integrator,
            integrator_options=integrator_options,
            dt=dt,
            progress=progress,
        )

    __init__.__doc__ = physics.Simulation.__doc__

    def run(
        self,
        duration: float,
        *,
        every: float | None = None,
        controller: Controller | None = None,
        progress: bool = False,
    ) -> Run:
        """
        Advance by a time and keep what happens as arrays.

        duration   : [s] a whole number of ticks (within 1e-6 of it); 0: the present state alone
        every      : [s] between rows, and between two questions to the controller: a whole number
                     of ticks; None: about 0.01 s
        controller : f(t, state) -> {'box': Wrench(force=…)} or None, see `library.stretch`: asked
                     at the start and every `every` seconds; its answer is held until the next
        progress   : whether a bar shows how far it is

        The rows begin with the present state; `run.time` is the time of the simulation. Stretch
        by stretch gives the same bits as one run.

        A run that diverges comes back with what was reached: `run.end_reason`, and a RunWarning.
        What a controller raises, and KeyboardInterrupt, goes on to the caller, and what was
        reached is its attribute `run`.

        Raises InvalidModel for a duration or `every` that is no whole number of ticks, for an
        answer that is none, and for what `set_wrench` refuses.
        """
        return follow(self, duration, every=every, controller=controller, progress=progress)

    def save(self, path: str | os.PathLike[str]) -> None:
        """
        Write a checkpoint: a file from which `Simulation.load` goes on bit for bit.

        It holds the scene with its files, the state, what contacts and integrator remember, and
        what is held; an energy balance is not in it, and is begun anew by `keep_energy_balance`. A
        file that exists is replaced, as a whole or not at all. Raises UserError
        where it cannot be written, RunError where there is no room, InvalidModel for a scene made
        in Python that no scene file can say.
        """
        from rigid_body_sim.library.checkpoint import write

        write(self, path)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Simulation:
        """
        Read a checkpoint of `save`.

        Raises UserError for what is none, is damaged, or is of another version.
        """
        from rigid_body_sim.library.checkpoint import read

        kept = read(path)
        simulation = cls.__new__(cls)
        simulation.__setstate__(kept)
        return simulation

    def _repr_html_(self) -> str:
        from rigid_body_sim.library.notebook import html_of_simulation

        return html_of_simulation(self)


def simulate(
    scene: AnyScene,
    duration: float = 10.0,
    *,
    every: float | None = None,
    controller: Controller | None = None,
    integrator: str | Mapping[str, Any] | None = None,
    integrator_options: Mapping[str, Any] | None = None,
    dt: float | None = None,
    progress: bool = False,
) -> Run:
    """
    Simulate a scene from its start and give the run as arrays.

    scene      : name of a shipped scene, path of a scene or URDF file, mapping, or Scene
    duration   : [s], default 10
    integrator, integrator_options, dt : as of `Simulation`; None: the scene's
    every, controller, progress        : as of `Simulation.run`
    """
    warn_if_plain()
    simulation = Simulation(
        scene, integrator=integrator, integrator_options=integrator_options, dt=dt
    )
    return follow(simulation, duration, every=every, controller=controller, progress=progress)
