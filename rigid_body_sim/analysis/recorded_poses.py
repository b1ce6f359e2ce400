# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Poses over time from a bag or a CSV file, body by body, with nothing thinned out.

Bag : every topic of type geometry_msgs/msg/PoseStamped, of whatever recorder; times are those of
      the stamps, messages in the order of their log times
CSV : columns time [s], body, px, py, pz [m] and, for bodies that turn, qx, qy, qz, qw; rows of one
      body ascend in time
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.model.rotation import IDENTITY
from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.recording.columns import read_columns
from rigid_body_sim.recording.every_body import with_every_body
from rigid_body_sim.scene import numerals, regular_file

Array = NDArray[np.float64]

CSV_POSITION = ('px', 'py', 'pz')
CSV_ORIENTATION = ('qx', 'qy', 'qz', 'qw')
LATEST = 2**31  # [s] of a ROS stamp


@dataclass(frozen=True, eq=False)
class Poses:
    """
    One body through time.

    body        : name: the last part of the topic before `pose`
    prefix      : what its other topics begin with: the topic without `/pose`
    frame_id    : axes of the numbers
    time_ns     : (k,) int [ns]
    position    : (k, 3) [m]
    orientation : (k, 4) [-] xyzw
    """

    body: str
    prefix: str
    frame_id: str
    time_ns: NDArray[np.int64]
    position: Array
    orientation: Array


def from_bag(bag: Bag) -> list[Poses]:
    """Read every pose topic of a bag; UserError if there is none."""
    bag = with_every_body(bag)
    wanted = [
        t.name
        for t in bag.topics.values()
        if t.type == cdr.PoseStamped.TYPE and bag.counts[t.name]
    ]
    if not wanted:
        raise UserError(
            f'{bag.path}: holds no poses; expected messages of {cdr.PoseStamped.TYPE}, '
            'one topic for each body'
        )
    return [
        Poses(
            body=_prefix(topic).rsplit('/', 1)[-1],
            prefix=_prefix(topic),
            frame_id=columns.frame_id,
            time_ns=columns.stamp,
            position=np.ascontiguousarray(columns.numbers[:, :3]),
            orientation=np.ascontiguousarray(columns.numbers[:, 3:]),
        )
        for topic, columns in read_columns(bag, wanted).items()
    ]


def _prefix(topic: str) -> str:
    return topic.removesuffix('/pose') or topic


def from_csv(path: Path) -> list[Poses]:
    """Read every body of a CSV file; UserError with the line of what is wrong."""
    rows = regular_file.rows(path, _rows, wanted='a bag or a CSV file of poses')
    bodies: dict[str, list[tuple[float, ...]]] = {}
    for body, numbers in rows:
        bodies.setdefault(body, []).append(numbers)
    if not bodies:
        raise UserError(f'{path}: holds no rows; give a CSV file of poses')
    found = []
    for body, values in bodies.items():
        table = np.array(values)
        time_ns = np.round(table[:, 0] * 1e9).astype(np.int64)
        found.append(Poses(body, f'/{body}', 'world', time_ns, table[:, 1:4], table[:, 4:8]))
    return found


def _rows(path: Path, lines: Iterator[str]) -> Iterator[tuple[str, tuple[float, ...]]]:
    reader = csv.DictReader(lines, skipinitialspace=True)
    columns = tuple(reader.fieldnames or ())
    turning = set(CSV_ORIENTATION) <= set(columns)
    allowed = ('time', 'body', *CSV_POSITION, *(CSV_ORIENTATION if turning else ()))
    if set(columns) != set(allowed) or len(columns) != len(allowed):
        raise UserError(
            f'{path}: columns {", ".join(columns) or "none"}; needed: time, body, px, py, pz, '
            'and for bodies that turn all of qx, qy, qz, qw'
        )
    for row in reader:
        where = f'{path}: line {reader.line_num}'
        if None in row or None in row.values():
            raise UserError(f'{where}: has not as many values as the header has columns')
        body = row['body']
        if not body.isidentifier():
            raise UserError(
                f'{where}: body {body!r}; a name of letters, digits and underscores is needed'
            )
        time = _number(where, 'time', row['time'])
        if not 0.0 <= time < LATEST:
            raise UserError(f'{where}: time {time:g} s; allowed: 0 and more, below 2^31 s')
        orientation = IDENTITY
        if turning and any(row[name] for name in CSV_ORIENTATION):
            orientation = tuple(_number(where, name, row[name]) for name in CSV_ORIENTATION)
        yield (
            body,
            (time, *(_number(where, name, row[name]) for name in CSV_POSITION), *orientation),
        )


def _number(where: str, name: str, text: str) -> float:
    number = numerals.decimal(text.strip())
    if number is None or not math.isfinite(number):
        raise UserError(f'{where}: {name} {text!r}; allowed: a finite number{numerals.cure(text)}')
    return number
