# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Read the `motion` of a body that is moved as told, and the `surface_velocity` of a conveyor.

    motion: {heave: {amplitude: 0.5, period: 7}, roll: [{amplitude: 0.1, period: 9, phase: 1.57}]}
    motion: {table: [[0, 0, 0, 0], [2, 1, 0, 0.5]], point: [0, 0, -2]}
    motion: {}                                       goes on as `initial` says: a turntable

What the keys mean stands in `physics.model.prescribed_motion`; the fields of its record are they.
"""

from __future__ import annotations

from typing import Any

from rigid_body_sim.physics.model.prescribed_motion import (
    LONG_ROW,
    SHORT_ROW,
    UNITS,
    WAYS,
)
from rigid_body_sim.physics.model.scene import Oscillation, PrescribedMotion
from rigid_body_sim.scene.grammar import MOTION, WAVE
from rigid_body_sim.scene.values import Value


def read_motion(value: Value) -> PrescribedMotion:
    """Return what moves a body."""
    value.need_mapping('a mapping such as {heave: {amplitude: 0.5, period: 7}}')
    value.need_known(MOTION.keys)
    given: dict[str, Any] = {}
    for way, unit in zip(WAYS, UNITS, strict=True):
        item = value.find(way)
        if item is not None:
            several = item.items() if isinstance(item.content, list) else [item]
            given[way] = tuple(_oscillation(each, unit) for each in several)
    table, point = value.find('table'), value.find('point')
    if table is not None:
        given['table'] = tuple(_row(row) for row in table.items('a list of rows of numbers'))
    if point is not None:
        given['point'] = point.vector(unit='m')
    return PrescribedMotion(**given)


def _oscillation(value: Value, unit: str) -> Oscillation:
    value.need_mapping(f'a mapping {{amplitude: [{unit}], period: [s]}}')
    value.need_known(WAVE['m'].keys)
    phase = value.find('phase')
    return Oscillation(
        value.at('amplitude', what=f'a number [{unit}]').number(unit=unit),
        value.at('period', what='a positive number [s]').number(unit='s', positive=True),
        0.0 if phase is None else phase.number(unit='rad'),
    )


def _row(value: Value) -> tuple[float, ...]:
    width = len(value.items('a row of numbers'))
    if width not in (SHORT_ROW, LONG_ROW):
        raise value.error(
            f'got {width} numbers; a row is [t, x, y, z] or [t, x, y, z, roll, pitch, yaw] '
            '[s, m, rad]'
        )
    return value.numbers(width, unit='s, m, rad')
