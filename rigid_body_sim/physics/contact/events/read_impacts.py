# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Read the impacts of ticks from the list that the kernel writes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.contact.collision import collider_record
from rigid_body_sim.physics.contact.events import impact_list
from rigid_body_sim.physics.state.contacts import NO_CONTACTS, Contacts
from rigid_body_sim.physics.state.impacts import NO_IMPACTS, Impacts

Array = NDArray[np.float64]


def read_impacts(
    lists: Sequence[Array], *, dt_ns: int, start_ns: int, table: NDArray[np.int64], substeps: int
) -> Impacts:
    """
    Read the impacts of some calls of the kernel of the ticks, in the order of their instants.

    lists    : rows of `impact_list`
    dt_ns    : tick of the scene [ns]
    start_ns : where tick 0 of the kernel begins [ns]
    table    : of the colliders
    substeps : ticks of the kernel in one of the scene
    """
    if not lists:
        return NO_IMPACTS
    rows = np.concatenate(lists).reshape(-1, impact_list.SIZE)
    tick, step = np.divmod(np.floor(rows[:, impact_list.TICK]), substeps)
    part = step * (dt_ns * 1e-9 / substeps) + rows[:, impact_list.PART]
    order = np.lexsort((part, tick))
    rows, tick, part = rows[order], tick[order], part[order]
    colliders = rows[:, [impact_list.COLLIDER_A, impact_list.COLLIDER_B]].astype(np.int64)
    return Impacts(
        start_ns + tick.astype(np.int64) * dt_ns,
        part,
        table[colliders * collider_record.SIZE + collider_record.SCENE_INDEX],
        _vectors(rows, impact_list.POINT),
        _vectors(rows, impact_list.NORMAL),
        _vectors(rows, impact_list.IMPULSE),
        rows[:, impact_list.APPROACH],
        rows[:, impact_list.KIND].astype(np.int64),
    )


def of_last_tick(lists: Sequence[Array], tick: float, table: NDArray[np.int64]) -> Contacts:
    """Give the impacts of a tick of the kernel as contacts: points that touch, and impulses."""
    rows = [part.reshape(-1, impact_list.SIZE) for part in lists[-1:]]
    if not rows:
        return NO_CONTACTS
    found = rows[0][rows[0][:, impact_list.TICK] == tick]
    colliders = found[:, [impact_list.COLLIDER_A, impact_list.COLLIDER_B]].astype(np.int64)
    return Contacts(
        table[colliders * collider_record.SIZE + collider_record.SCENE_INDEX],
        _vectors(found, impact_list.POINT),
        _vectors(found, impact_list.NORMAL),
        np.zeros(len(found)),
        _vectors(found, impact_list.IMPULSE),
        np.zeros((len(found), 3)),
    )


def _vectors(rows: Array, field: int) -> Array:
    return rows[:, impact_list.impact.span(field)]
