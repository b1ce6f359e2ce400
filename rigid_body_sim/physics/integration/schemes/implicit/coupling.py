# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Which bodies feel which: the graph of the force elements, as implicit integrators need it.

groups  : bodies that forces connect; each is a system of equations of its own
order   : within a group, so that coupled bodies are close (Cuthill & McKee, 1969): a chain has a
          narrow band
colours : bodies of one colour neither touch nor share a partner, so that one evaluation of the
          forces tells the
          derivatives with respect to all of them (Curtis, Powell & Reid, 1974)

Plan, the numbers that the kernels read: a header, a table of groups, their members, a table of
bodies, the table of derivatives (`physics.derivatives`), the matrices (`physics.banded`), and two
vectors.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.forces.derivatives import BLOCK
from rigid_body_sim.physics.integration.schemes.implicit import banded
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.state.layout import Layout

# header: counts, the greatest length of the scene [m], then where the tables begin
GROUPS, COLOURS, LENGTH, MEMBERS_AT, BODIES_AT, TABLE_AT, MATRIX_AT, VECTOR_AT, FORCES_AT, END = (
    range(10)
)
HEADER = 10

# row of the table of groups
FIRST_MEMBER, MEMBERS, FIRST, UNKNOWNS, BAND, MATRIX, STATUS, CHANGE = range(8)
GROUP = 8

# row of the table of bodies: what belongs to the graph comes first, the rest is scratch of the
# integrator
UNKNOWN, COLOUR, OF_GROUP = range(3)
BODY = 72


def neighbours(scene: Scene, layout: Layout) -> list[set[int]]:
    """
    Find the moving bodies that each moving body is coupled to, itself among them; core indices.
    """
    found = [{i} for i in range(layout.n_moving)]
    cores = {int(scene_index): core for core, scene_index in enumerate(layout.moving)}
    for force in scene.forces:
        ends = {cores.get(layout.index(name)) for name in force.bodies() if name in layout.names}
        moving = {end for end in ends if end is not None}
        for end in moving:
            found[end] |= moving
    return found


def components(graph: list[set[int]]) -> Iterator[list[int]]:
    """Give the bodies of each group, reverse Cuthill–McKee order."""
    seen = [False] * len(graph)
    for root in sorted(range(len(graph)), key=lambda i: (len(graph[i]), i)):
        if seen[root]:
            continue
        order, queue = [], [root]
        seen[root] = True
        while queue:
            i = queue.pop(0)
            order.append(i)
            for j in sorted(graph[i], key=lambda j: (len(graph[j]), j)):
                if not seen[j]:
                    seen[j] = True
                    queue.append(j)
        yield order[::-1]


def colours(graph: list[set[int]]) -> list[int]:
    """Colour the bodies greedily: none has the colour of a partner, or of a partner's partner."""
    colour = [-1] * len(graph)
    for i in range(len(graph)):
        taken = {colour[k] for j in graph[i] for k in graph[j]}
        colour[i] = next(c for c in range(len(graph) + 1) if c not in taken)
    return colour


def length(scene: Scene) -> float:
    """
    Give the greatest coordinate that the scene names [m]: what rounding of positions goes with.
    """
    vectors = [body.initial.position for body in scene.bodies]
    for force in scene.forces:
        for field in fields(force):  # pyright: ignore[reportArgumentType]
            if field.metadata.get('kind') == 'point' and getattr(force, field.name) is not None:
                vectors.append(getattr(force, field.name))
    return max((float(np.max(np.abs(vector))) for vector in vectors), default=0.0)


def plan(scene: Scene, layout: Layout, h: float) -> NDArray[np.float64]:
    """Make the plan of a scene; it does not depend on h."""
    graph = neighbours(scene, layout)
    size = [6 if i < layout.n_rigid else 3 for i in range(layout.n_moving)]
    groups: list[list[float]] = []
    members: list[int] = []
    bodies = np.zeros((layout.n_moving, BODY))
    unknowns = matrices = 0
    bodies[:, COLOUR] = colours(graph)
    for number, order in enumerate(components(graph)):
        first = unknowns
        for i in order:
            bodies[i, UNKNOWN] = unknowns
            bodies[i, OF_GROUP] = number
            unknowns += size[i]
        band = max(
            int(bodies[j, UNKNOWN] - bodies[i, UNKNOWN]) + size[j] - 1
            for i in order
            for j in graph[i]
        )
        groups.append([len(members), len(order), first, unknowns - first, band, matrices, 0, 0])
        members += order
        matrices += banded.size(unknowns - first, band)
    table = _table(graph)
    parts = [
        np.array(groups, dtype=float).reshape(-1),
        np.array(members, dtype=float),
        bodies.reshape(-1),
        table,
        np.zeros(matrices),
        np.zeros(unknowns),
        np.zeros(12 * layout.n_moving),
    ]
    places = HEADER + np.cumsum([0, *[len(part) for part in parts]])
    count = 1 + max(bodies[:, COLOUR], default=-1.0)
    header = np.array([len(groups), count, length(scene), *places[1:]], dtype=float)
    return np.concatenate([header, *parts])


def _table(graph: list[set[int]]) -> NDArray[np.float64]:
    """Make an empty table of derivatives."""
    pairs = [sorted(partners) for partners in graph]
    starts = np.cumsum([0, *[len(partners) for partners in pairs]])
    flat = [j for partners in pairs for j in partners]
    blocks = np.zeros(BLOCK * (len(flat) + 1))
    return np.concatenate([[len(graph), len(flat)], starts, flat, blocks])
