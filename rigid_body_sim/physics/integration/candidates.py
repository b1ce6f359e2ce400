# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What `auto` may choose from: methods with their fineness, and what a tick costs with each.

A setting is a method and how fine it is: a number of substeps, or for a method that controls its
error its tolerances. Costs are nominal, ns of one core, so that a choice depends on the scene
alone: the same scene gets the same method on every machine. `benchmark/step_cost.py` measures.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from rigid_body_sim.physics.integration.integrators import INTEGRATORS
from rigid_body_sim.physics.model.scene import Scene

MOST_SUBSTEPS = 64  # of a tick, that a pilot tries
LOOSEST, TIGHTEST = -2, -13  # powers of ten of the tolerances of a method that controls its error
LEVELS = 7  # powers of ten that a pilot tries of them
EVALUATION = 30.0  # [ns] of one force element


@dataclass(frozen=True)
class Price:
    """
    Nominal cost of one step.

    body        : [ns] of each body, beside the forces
    evaluations : of the forces
    with_velocity : the same where a force depends on velocity; 0: as many
    solves      : systems of linear equations, one unknown for each way a body can move
    """

    body: float
    evaluations: int
    solves: int = 0
    with_velocity: int = 0


SOLVE = 450.0  # [ns] of a body, one solution with its derivatives
PRICES = {
    'linear_propagator': Price(10.0, 0),
    'dmv6': Price(14.0, 1, with_velocity=2),
    'rk4': Price(17.0, 4),
    'dmv10': Price(18.0, 1, with_velocity=2),
    'force_gradient4': Price(35.0, 3, with_velocity=4),
    'rk45': Price(60.0, 6),
    'rk8': Price(110.0, 12),
    'blanes_moan4': Price(120.0, 6),
    'exact_rotor': Price(500.0, 1, with_velocity=2),
    'linearly_implicit': Price(100.0, 2, 1),
    'implicit_midpoint': Price(100.0, 6, 3),
    'sdirk2': Price(200.0, 12, 6),
    'lie_rk4': Price(150.0, 4),
}
ONLY_FOR_CHANGING_INERTIA = ('lie_rk4',)  # elsewhere rk4 has its order for less


@dataclass(frozen=True)
class Setting:
    """
    A method and how fine it is.

    fineness : substeps of a tick; of a method that controls its error, -log10 of its tolerances
    """

    name: str
    fineness: int

    @property
    def controls_its_error(self) -> bool:
        """Whether tolerances and not substeps set the error."""
        return INTEGRATORS[self.name].controls_its_error

    @property
    def options(self) -> Mapping[str, Any]:
        """The options of the integrator."""
        if self.controls_its_error:
            tolerance = float(f'1e{-self.fineness}')
            return {'rtol': tolerance, 'atol': tolerance}
        return {'substeps': self.fineness}

    @property
    def substeps(self) -> int:
        """Steps that make a tick; 1 of a method that chooses them itself."""
        return 1 if self.controls_its_error else self.fineness

    @property
    def text(self) -> str:
        """The setting in words."""
        if self.controls_its_error:
            return f'{self.name} with rtol and atol 1e-{self.fineness}'
        return f'{self.name} with {self.fineness} substep{"s" if self.fineness > 1 else ""} a tick'

    @property
    def shadow(self) -> tuple[str, Mapping[str, Any]]:
        """Name and options of the same method in half steps, which tells how wrong this one is."""
        if self.controls_its_error:
            tighter = float(f'1e{-min(self.fineness + 1, -TIGHTEST)}')
            return self.name, {'rtol': tighter, 'atol': tighter, 'substeps': 2}
        return self.name, {'substeps': 2 * self.fineness}

    @property
    def richardson(self) -> float:
        """Error of a run over its distance from its shadow."""
        if self.controls_its_error:
            return 1.0 / (1.0 - 0.1)
        order = INTEGRATORS[self.name].order
        return 1.0 if math.isinf(order) else 2.0**order / (2.0**order - 1.0)

    def finer(self, share: float) -> Setting:
        """
        Give the setting whose error is that share of this one's, at least one notch finer.

        share : [-] 0 to 1
        """
        if self.controls_its_error:
            notches = max(1, math.ceil(-math.log10(max(share, 1e-13))))
            return Setting(self.name, min(self.fineness + notches, -TIGHTEST))
        order = min(INTEGRATORS[self.name].order, 16.0)
        doublings = max(1, math.ceil(-math.log2(max(share, 1e-30)) / order))
        return Setting(self.name, self.fineness * 2 ** min(doublings, 10))

    def coarser(self) -> tuple[Setting, float]:
        """Give the setting a notch coarser, and how many times its error is this one's."""
        if self.controls_its_error:
            return Setting(self.name, max(self.fineness - 1, -LOOSEST)), 10.0
        order = min(INTEGRATORS[self.name].order, 16.0)
        return Setting(self.name, max(self.fineness // 2, 1)), 2.0**order


def settings_of(name: str, tolerance: float) -> Iterator[Setting]:
    """Yield what a pilot tries of a method, the coarsest first."""
    if INTEGRATORS[name].controls_its_error:
        first = min(max(round(-math.log10(tolerance)) - 2, -LOOSEST), -TIGHTEST)
        yield from (Setting(name, k) for k in range(first, min(first + LEVELS, 1 - TIGHTEST)))
        return
    yield from (Setting(name, 2**k) for k in range(MOST_SUBSTEPS.bit_length()))


def price_of_step(name: str, scene: Scene) -> float:
    """Nominal cost of one step of a scene [ns]."""
    price, bodies = PRICES[name], len(scene.bodies)
    terms = len(scene.forces) + sum(body.pivot is not None for body in scene.bodies)
    evaluations = price.evaluations
    if price.with_velocity and any(force.depends_on_velocity() for force in scene.forces):
        evaluations = price.with_velocity
    return price.body * bodies + EVALUATION * evaluations * terms + SOLVE * price.solves * bodies
