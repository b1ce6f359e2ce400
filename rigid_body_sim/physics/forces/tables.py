# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""The rows of the force elements of a scene, stacked for the kernels."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.errors import InvalidModel, blaming
from rigid_body_sim.physics.forces.element import Places
from rigid_body_sim.physics.forces.schedule import Switch


def stacked(
    forces: Sequence[Any], kinds: Sequence[str], places: Places
) -> tuple[NDArray[np.float64], list[int], list[Switch]]:
    """
    Stack one table per type of force, end to end.

    kinds   : types in the order of their tables
    returns : numbers; start and count of each table; and what acts for a while only
    """
    numbers: list[float] = []
    ranges: list[int] = []
    switches: list[Switch] = []
    for kind in kinds:
        elements = [(i, force) for i, force in enumerate(forces) if force.TYPE == kind]
        ranges += [len(numbers), len(elements)]
        for i, element in elements:
            if hasattr(element, 'acts'):
                switches.append(Switch(len(numbers) + element.SWITCH, *element.acts()))
            with blaming('forces', i):
                numbers += _row(element, places)
    return np.array(numbers, dtype=np.float64), ranges, switches


def _row(element: Any, places: Places) -> tuple[float, ...]:
    row = element.row(places)
    wanted = int(row[0]) if element.COLUMNS is None else element.COLUMNS
    if len(row) != wanted:
        raise InvalidModel(f'force {element.TYPE!r}: a row of {len(row)} numbers, not {wanted}')
    return row
