# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Reads the values of a recorded manifest that only a run can judge."""

from __future__ import annotations

import json
import sys
from dataclasses import fields

import numpy as np

from rigid_body_sim.physics.forces.held_wrenches import FOREVER, Slot, is_source
from rigid_body_sim.physics.state.impacts import KINDS, NO_IMPACTS, Impacts
from rigid_body_sim.recording.marker_packing import Shown
from rigid_body_sim.recording.record_values import RecordValues
from rigid_body_sim.runs.view import ViewSettings
from rigid_body_sim.runs.viewing import shown_of, view_settings_of

IMPACTS_AT_START = 'impacts_at_start'  # key; bags without it end with their last published tick
MOST_TICKS = 2**32 - 1  # a sequence number has 32 bits
MOST_NS = 2**31 * 10**9  # [ns] a ROS stamp counts 2^31 s
MOST_TIMEOUT_NS = 10**30  # [ns]
IMPACT_TYPES = (int, float, int, float, float, float, float, int)  # of the fields of `Impacts`


class ManifestValues(RecordValues):
    """The values of a manifest."""

    def places(self, key: str, count: int, default: str) -> frozenset[int]:
        """Return a set of places in a list of so many."""
        value = self.json(key, default)
        if not isinstance(value, list) or not all(_is_place(each, count) for each in value):
            raise self.refusal(key, value, f'a list of whole numbers from 0 to {count - 1}')
        return frozenset(value)

    def held(self, key: str, bodies: int) -> dict[tuple[int, str], Slot]:
        """Return the commands that held, as `recorder.held_as_json` wrote them."""
        value = self.json(key)
        if not isinstance(value, list) or not all(_is_slot(each, bodies) for each in value):
            raise self.refusal(
                key, value, 'a list of (place, source, force, torque, turns with the body, until)'
            )
        return {
            (core, source): Slot(tuple(force), tuple(torque), turns, until)
            for core, source, force, torque, turns, until in value
        }

    def view(self, key: str) -> ViewSettings:
        """Return what was published beside the states; nothing in old recordings."""
        value = self.mapping(key, '{}')
        try:
            return view_settings_of(value)
        except ValueError as error:
            raise self.refusal(key, value, f'settings of a view; not {error}') from error

    def shown(self, key: str, bodies: int) -> Shown:
        """Return the arrows of the markers before, as `viewing.shown_text` wrote them."""
        value = self.json(key, '[[], [], 0]')
        try:
            return shown_of(value, bodies)
        except ValueError as error:
            raise self.refusal(key, value, 'two lists of bodies and a count') from error

    def impacts(self, key: str, bodies: int) -> Impacts:
        """Return impacts, as `impacts_text` wrote them; none in old recordings."""
        rows = self.json(key, '[]')
        if not isinstance(rows, list) or not all(_is_impact(row, bodies) for row in rows):
            raise self.refusal(
                key,
                rows,
                'a list of (start of the tick [ns], remainder, two places, point, normal, '
                'impulse, approach, kind)',
            )
        if not rows:
            return NO_IMPACTS
        columns = zip(*rows, strict=True)
        return Impacts(
            *(np.array(column, kind) for column, kind in zip(columns, IMPACT_TYPES, strict=True))
        )


def impacts_text(found: Impacts) -> str:
    """Write impacts for a manifest: a row each; floats survive JSON to the bit."""
    columns = [getattr(found, each.name).tolist() for each in fields(found)]
    return json.dumps(list(zip(*columns, strict=True)))


def _is_place(value: object, count: int) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < count


def _is_slot(value: object, bodies: int) -> bool:
    if not isinstance(value, list) or len(value) != 6:
        return False
    core, source, force, torque, turns, until = value
    return (
        _is_place(core, bodies)
        and isinstance(source, str)
        and is_source(source)
        and _is_vector(force)
        and _is_vector(torque)
        and isinstance(turns, bool)
        and _is_place(until, max(FOREVER, MOST_TIMEOUT_NS) + 1)
    )


def _is_impact(value: object, bodies: int) -> bool:
    if not isinstance(value, list) or len(value) != len(IMPACT_TYPES):
        return False
    tick_ns, remainder, pair, *vectors, approach, kind = value
    return (
        _is_place(tick_ns, MOST_NS)
        and isinstance(pair, list)
        and len(pair) == 2
        and all(_is_place(place, bodies) for place in pair)
        and all(map(_is_vector, vectors))
        and _is_vector([remainder, approach, 0.0])
        and _is_place(kind, len(KINDS))
    )


def _is_vector(value: object) -> bool:
    return (
        isinstance(value, list)
        and len(value) == 3
        and all(isinstance(x, int | float) and not isinstance(x, bool) for x in value)
        and all(abs(x) <= sys.float_info.max for x in value)
    )
