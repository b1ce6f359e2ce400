# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
How wrong a run is, estimated while it runs by step doubling: a reference run takes every tick in
twice as many steps.

A method of order p with step h errs by e = c h^p, and with h/2 by c (h/2)^p, so that

    e = d 2^p / (2^p - 1),   d : difference between the run and its reference

(Richardson). The reference begins with the run, is given the same commands at the same ticks, and
is never set back: the difference is that of the whole trajectories, grown as the motion makes
errors grow. The reference of a method that controls its error has tolerances ten times as tight;
one that is exact differs from its reference by round-off alone.

Limits: while the step is so long that the error does not follow h^p, the estimate has the right
size at best; on chaotic motion both lose the truth together and the difference saturates. It costs
twice the run.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from rigid_body_sim.physics.integration.choose import Choice
from rigid_body_sim.physics.integration.integrator import Integrator
from rigid_body_sim.physics.model.rotation import angle_between
from rigid_body_sim.physics.simulation import Simulation

TIGHTER = 10.0  # [-] by how much the tolerances of the reference are tighter


@dataclass(frozen=True)
class ErrorEstimate:
    """
    Estimated error of the body that errs most.

    position [m], angle [rad], velocity [m/s], angular_velocity [rad/s]
    """

    position: float
    angle: float
    velocity: float
    angular_velocity: float


def _half_steps(integrator: Integrator) -> dict[str, Any]:
    """Options of the same method in half steps."""
    options = dict(integrator.settings)
    if integrator.controls_its_error:
        options['rtol'] = max(options['rtol'] / TIGHTER, 1e-13)
        options['atol'] = options['atol'] / TIGHTER
    else:
        options['substeps'] = 2 * integrator.substeps
    return options


class ReferenceRun:
    """
    The same simulation in half steps.

    simulation : give it the same commands and steps
    """

    def __init__(self, of: Simulation) -> None:
        self._of = of
        self._half_of = integrator = of.integrator
        self.simulation = Simulation(
            of.scene,
            integrator=integrator.name,
            integrator_options=_half_steps(integrator),
            dt=of.dt,
        )
        self.simulation.prepare(commands_in_body_axes=True)
        self.simulation.restore(tick=of.tick, state=of.state_bytes(), slots=of.held_slots)

    def step(self, ticks: int) -> None:
        """Do the ticks that the run has done; where `auto` changed its method, change too."""
        integrator = self._of.integrator
        if integrator is not self._half_of:
            self._half_of = integrator
            changed = Choice(
                integrator.name,
                integrator.substeps,
                math.nan,
                'half of what the run takes',
                options=_half_steps(integrator),
                tick=self.simulation.tick,
            )
            self.simulation.follow_choices([changed])
        self.simulation.step(ticks)

    def _factor(self) -> float:
        integrator = self._of.integrator
        if integrator.controls_its_error:
            return 1.0 / (1.0 - 1.0 / TIGHTER)
        scene = self._of.scene
        steady = not any(body.pivot for body in scene.bodies) or not any(scene.gravity)
        nothing_acts = steady and not scene.forces and not self._of.held_slots
        order = integrator.free_order if nothing_acts else integrator.order
        if math.isinf(order):
            return 1.0
        return 2.0**order / (2.0**order - 1.0)

    def estimate(self) -> ErrorEstimate:
        """Compare the two at the present tick."""
        coarse, fine = self._of.state, self.simulation.state
        factor = self._factor()

        def worst(difference: np.ndarray) -> float:
            return factor * float(np.max(np.linalg.norm(difference, axis=1), initial=0.0))

        angles = angle_between(coarse.orientation, fine.orientation)
        return ErrorEstimate(
            position=worst(coarse.position - fine.position),
            angle=factor * float(np.max(angles, initial=0.0)),
            velocity=worst(coarse.velocity - fine.velocity),
            angular_velocity=worst(coarse.angular_velocity - fine.angular_velocity),
        )
