# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Where and how a body may be, so that its energy is a number.

    w |x| <= LARGEST,   |x| <= LARGEST
        x : position [m] of the centre of mass, its velocity [m/s], angular velocity [rad/s]
        w : mass [kg], or the largest moment of inertia [kg m^2]

Momenta are squared; energies add, and gravity and springs multiply what stands here: LARGEST
leaves them room, but for a spring that is itself beyond all measure. A state that a run comes to
is not judged here: it is warned of when its energy has no numbers any more.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from rigid_body_sim.physics.errors import InvalidModel

LARGEST = 1e150  # [-] its square, 1e300, leaves 1e8 for sums and factors; larger gives infinities
CURE = 'check the units (m, kg, s)'


def need_finite_energy(said: str, values: Sequence[float], *, unit: str, weight: float) -> None:
    """
    Refuse numbers that square beyond the largest one; InvalidModel, which begins with `said`.

    weight : [kg] or [kg m^2], which makes a momentum of them
    """
    size, most = math.hypot(*values), LARGEST / max(1.0, weight)
    if not size <= most:
        raise InvalidModel(
            f'{said} of {size:.3g} {unit} has no finite energy, for its square is beyond the '
            f'numbers; allowed: up to {most:.3g} {unit}; {CURE}'
        )


def need_square(size: float, *, unit: str) -> None:
    """Refuse what pushes bodies and squares beyond the largest number."""
    if not size <= LARGEST:
        raise InvalidModel(
            f'got {size:.3g} {unit}, whose square is beyond the numbers; allowed: up to '
            f'{LARGEST:.3g} {unit}; {CURE}'
        )


def need_finite_weight(mass: float, gravity: Sequence[float], position: Sequence[float]) -> None:
    """Refuse a body whose weight, or energy in gravity, is beyond the largest number."""
    pull, height = math.hypot(*gravity), max(1.0, math.hypot(*position))
    if not mass * pull * height <= LARGEST**2:
        raise InvalidModel(
            f'{mass:.3g} kg in a gravity of {pull:.3g} m/s^2, {height:.3g} m from the origin, has '
            f'no finite energy; allowed: a product up to {LARGEST**2:.3g} J; {CURE}'
        )
