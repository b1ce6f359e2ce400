# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Numbers of bodies to and from the eight lanes of a batch: six or seven numbers that follow each
other in the record of a body, in as many rows of lanes that follow each other.

    places, place : where the row begins that tells where the record of each lane begins
    table, field  : the records, and where in one the numbers begin
    rows          : of lanes

A record has eight numbers from `field` on. What is written here is done eight numbers at a time by
`compile.lane_transfers`.
"""

from __future__ import annotations

from rigid_body_sim.physics.arrays import Array
from rigid_body_sim.physics.compile.kernels import transfer
from rigid_body_sim.physics.contact.solver.constraint import LANES


@transfer
def fetch_six(places: Array, place: int, table: Array, field: int, rows: Array, to: int) -> None:
    """Fetch six numbers of each lane into the rows from `to` on."""
    for lane in range(LANES):
        record = int(places[place + lane]) + field
        for number in range(6):
            rows[to + LANES * number + lane] = table[record + number]


@transfer
def fetch_seven(places: Array, place: int, table: Array, field: int, rows: Array, to: int) -> None:
    """Fetch seven numbers of each lane into the rows from `to` on."""
    for lane in range(LANES):
        record = int(places[place + lane]) + field
        for number in range(7):
            rows[to + LANES * number + lane] = table[record + number]


@transfer
def replace_on_a(
    places: Array, place: int, table: Array, field: int, rows: Array, linear: int, angular: int,
    visited: int,
) -> None:  # fmt: skip
    """
    Take three numbers from each lane where the row `visited` is above 0, those of the rows from
    `linear` on, and write the three behind them anew, from `angular` on.
    """
    for lane in range(LANES):
        if rows[visited + lane] > 0.0:
            record = int(places[place + lane]) + field
            for axis in range(3):
                table[record + axis] -= rows[linear + LANES * axis + lane]
                table[record + 3 + axis] = rows[angular + LANES * axis + lane]


@transfer
def replace_on_b(
    places: Array, place: int, table: Array, field: int, rows: Array, linear: int, angular: int,
    visited: int,
) -> None:  # fmt: skip
    """Do the same, but give the first three numbers."""
    for lane in range(LANES):
        if rows[visited + lane] > 0.0:
            record = int(places[place + lane]) + field
            for axis in range(3):
                table[record + axis] += rows[linear + LANES * axis + lane]
                table[record + 3 + axis] = rows[angular + LANES * axis + lane]


@transfer
def add_on_a(
    places: Array, place: int, table: Array, field: int, rows: Array, linear: int, angular: int,
    visited: int,
) -> None:  # fmt: skip
    """Take the first three numbers from each lane, and add the three behind them."""
    for lane in range(LANES):
        if rows[visited + lane] > 0.0:
            record = int(places[place + lane]) + field
            for axis in range(3):
                table[record + axis] -= rows[linear + LANES * axis + lane]
                table[record + 3 + axis] += rows[angular + LANES * axis + lane]


@transfer
def add_on_b(
    places: Array, place: int, table: Array, field: int, rows: Array, linear: int, angular: int,
    visited: int,
) -> None:  # fmt: skip
    """Give all six numbers to each lane."""
    for lane in range(LANES):
        if rows[visited + lane] > 0.0:
            record = int(places[place + lane]) + field
            for axis in range(3):
                table[record + axis] += rows[linear + LANES * axis + lane]
                table[record + 3 + axis] += rows[angular + LANES * axis + lane]
