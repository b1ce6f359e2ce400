# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Read the `pivot` of a body: the point about which it turns, and where that is.

`{point: [0, 0, -0.5]}`, in shape coordinates, is where the body at its `initial.position` and
orientation has that point; `{point: …, at: [0, 0, 1]}` puts it there, and then the position
follows. The velocity follows in any case: given, it must be the right one.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rigid_body_sim.physics.model import rotation
from rigid_body_sim.physics.model.pivot import arm_of, check_given, check_pivot
from rigid_body_sim.physics.model.scene import Body, Pivot, Vector
from rigid_body_sim.physics.state.layout import as_vector
from rigid_body_sim.scene.grammar import PIVOT
from rigid_body_sim.scene.values import Value


def with_pivot(body: Body, value: Value | None, initial: Value | None) -> Body:
    """Return the body with its pivot, and with the motion at the start that goes with it."""
    if value is None:
        return body
    value.need_mapping('a mapping such as {point: [0, 0, -0.5]}')
    value.need_known(PIVOT.keys)
    point = value.at('point', what='a list of three numbers [m], shape coordinates,').vector(
        unit='m'
    )
    at_value = value.find('at')
    start = body.initial
    pivoted = replace(body, pivot=Pivot(point, (0.0, 0.0, 0.0)))
    with value.blamed():
        check_pivot(pivoted)
    arm = rotation.rotate(start.orientation, arm_of(pivoted))
    with np.errstate(over='ignore', invalid='ignore'):  # beyond the numbers: refused by name
        velocity = as_vector(np.cross(start.angular_velocity, arm))
    at = as_vector(start.position - arm)
    position = start.position
    if at_value is not None:
        at = at_value.vector(unit='m')
        position = as_vector(at + arm)
        _agree(initial, 'position', position, unit='m', why='the pivot is at `at`')
    _agree(initial, 'velocity', velocity, unit='m/s', why='it is angular_velocity x arm')
    return replace(
        pivoted,
        pivot=Pivot(point, at),
        initial=replace(start, position=position, velocity=velocity),
    )


def _agree(initial: Value | None, key: str, wanted: Vector, *, unit: str, why: str) -> None:
    """Refuse what is given and cannot be."""
    given = None if initial is None else initial.find(key)
    if given is None:
        return
    vector = given.vector(unit=unit)
    with given.blamed():
        check_given(vector, wanted, what=key, unit=unit, why=why)
