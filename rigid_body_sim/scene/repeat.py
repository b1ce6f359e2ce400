# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Copies of one body on a grid: rows of dominoes, stacks, piles.

    repeat: {count: [10, 10, 5], spacing: [0.3, 0.3, 0.4], jitter: 0.02}

makes 500 bodies alike but for name and position. `box` becomes box_1, box_2, …, x running fastest,
then y, then z; the first stands at `initial.position`. `jitter` shifts the n-th copy along each
axis by less than so much, so that a pile does not fall as columns:

    x_n = x_1 + (i, j, k) * spacing + jitter (2 frac(n g) - 1),   g = (1/p, 1/p^2, 1/p^3)
        p : 1.2207440846..., the root of p^4 = p + 1

The sequence frac(n g) fills the cube evenly, needs no seed and is the same everywhere (M. Roberts,
"The unreasonable effectiveness of quasirandom sequences", 2018).
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from rigid_body_sim.physics.model.scene import Body
from rigid_body_sim.physics.model.shapes import Plane
from rigid_body_sim.scene.grammar import MOST_COPIES, REPEAT
from rigid_body_sim.scene.values import Value

P = 1.2207440846057596
EVENLY = np.array([1.0 / P, 1.0 / P**2, 1.0 / P**3])


def repeated(body: Body, value: Value) -> tuple[Body, ...]:
    """Return the copies of a body that a `repeat` asks for."""
    value.need_mapping('a mapping such as {count: [10, 1, 1], spacing: [0.2, 0, 0]}')
    value.need_known(REPEAT.keys)
    if isinstance(body.shape, Plane):
        raise value.error('a plane is one plane wherever its body stands; remove repeat')
    counts = _counts(value.at('count', what='a list of three whole numbers'))
    spacing = np.array(value.at('spacing', what='a list of three lengths [m]').vector(unit='m'))
    jitter_value = value.find('jitter')
    jitter = 0.0 if jitter_value is None else jitter_value.number(unit='m', minimum=0.0)
    copies = []
    for n in range(math.prod(counts)):
        i, rest = n % counts[0], n // counts[0]
        cell = np.array((i, rest % counts[1], rest // counts[1]))
        off = jitter * (2.0 * np.modf((n + 1) * EVENLY)[0] - 1.0)
        with np.errstate(over='ignore', invalid='ignore'):  # beyond the numbers: refused by name
            x, y, z = np.array(body.initial.position) + cell * spacing + off
        initial = replace(body.initial, position=(float(x), float(y), float(z)))
        copies.append(replace(body, name=f'{body.name}_{n + 1}', initial=initial))
    return tuple(copies)


def _counts(value: Value) -> tuple[int, ...]:
    numbers = value.numbers(3, unit='-')
    counts = tuple(int(number) for number in numbers)
    if any(count != number or count < 1 for count, number in zip(counts, numbers)):
        raise value.error(f'got {value.content}; three whole numbers of at least 1 are needed')
    if math.prod(counts) > MOST_COPIES:
        raise value.error(f'{math.prod(counts)} copies; at most {MOST_COPIES} are allowed')
    return counts
