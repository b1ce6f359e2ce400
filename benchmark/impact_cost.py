# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The cost of the impulse of an impact: a ball, a box without friction, an eccentric one with it.

    python benchmark/impact_cost.py --count 2000

Random impacts, each repeated in one compiled call; printed are mean, median, 99 of 100, and the
worst [us of processor time].
"""

from __future__ import annotations

import argparse
import time
from typing import Any

import numpy as np

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.events.collision_matrix import StruckBody
from rigid_body_sim.physics.contact.events.point_impact import point_impact
from rigid_body_sim.physics.vectors import load, load_symmetric

REPEATS = 200
ROW = 28  # numbers of an impact


@kernel
def _repeat(row: Any, repeats: int) -> float:
    """Take the same impact many times."""
    total = 0.0
    for _ in range(repeats):
        a = StruckBody(row[0], load_symmetric(row, 1), load(row, 7))
        b = StruckBody(row[10], load_symmetric(row, 11), load(row, 17))
        total += point_impact(a, b, load(row, 20), load(row, 23), row[26], row[27])[0]
    return total


def _impact(rng: np.random.Generator, kind: str) -> np.ndarray:
    """Draw an impact with what cannot move: inverse mass, inertia, arm of both; n, v, e, mu."""
    row = np.zeros(ROW)
    normal = rng.normal(size=3)
    normal /= np.linalg.norm(normal)
    size = rng.uniform(0.1, 1.0, 3)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    arm, inverse = turn @ (size / 2), 12.0 / np.array([
        size[1] ** 2 + size[2] ** 2, size[0] ** 2 + size[2] ** 2, size[0] ** 2 + size[1] ** 2,
    ])  # fmt: skip
    world = turn @ np.diag(inverse) @ turn.T
    if kind == 'ball':
        world, arm = np.eye(3) * 2.5 / 0.1**2, -0.1 * normal
    velocity = rng.normal(size=3)
    velocity -= 2.0 * max(velocity @ normal, 0.0) * normal
    row[10], row[11:17], row[17:20] = 1.0, world[np.triu_indices(3)], arm
    row[20:23], row[23:26], row[26] = normal, velocity, rng.random()
    row[27] = 0.0 if kind == 'box, smooth' else rng.uniform(0.05, 1.5)
    return row


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--count', type=int, default=1000, help='impacts of each kind')
    parser.add_argument('--seed', type=int, default=1)
    arguments = parser.parse_args()
    rng = np.random.default_rng(arguments.seed)
    print(f'{"[us]":18} {"mean":>7} {"median":>7} {"99 %":>7} {"worst":>7}')
    for kind in ('ball', 'box, smooth', 'box, rough'):
        rows = [_impact(rng, kind) for _ in range(arguments.count)]
        _repeat(rows[0], 1)
        costs = []
        for row in rows:
            begin = time.process_time()
            _repeat(row, REPEATS)
            costs.append((time.process_time() - begin) / REPEATS * 1e6)
        told = (np.mean(costs), *np.percentile(costs, [50, 99, 100]))
        print(f'{kind:18} ' + ' '.join(f'{cost:7.2f}' for cost in told))


if __name__ == '__main__':
    main()
