# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Which bodies feel which: the graph of the force elements, as implicit integrators need it.

groups  : bodies that forces connect; each is a system of equations of its own
order   : within a group, so that coupled bodies are close (Cuthill & McKee, 1969): a chain has a
          narrow band
colours : bodies of one colour neither touch nor share a partner, so that one evaluation of the
          forces tells the derivatives with respect to all of them (graph colouring; Curtis, Powell
          & Reid, 1974)

Plan, the numbers that the kernels read: a header, a table of groups, their members, a table of
bodies, the table of derivatives (`forces.derivatives`), the matrices (`banded`), and two vectors;
`opened` gives them their names.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline
from rigid_body_sim.physics.forces.derivatives import BLOCK
from rigid_body_sim.physics.integration.schemes.implicit import banded
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.state.layout import Layout

header = Record()
GROUPS = header.number('-', 'groups')
COLOURS = header.number('-', 'colours')
LENGTH = header.number('m', 'greatest coordinate that the scene names')
MEMBERS_AT = header.number('-', 'where the members of the groups begin')
BODIES_AT = header.number('-', 'where the table of bodies begins')
TABLE_AT = header.number('-', 'where the table of derivatives begins')
MATRIX_AT = header.number('-', 'where the matrices begin')
VECTOR_AT = header.number('-', 'where the right hand sides begin')
WRENCHES_AT = header.number('-', 'where the saved wrenches begin')
END = header.number('-', 'where they end')
HEADER = header.size

group = Record()
FIRST_MEMBER = group.number('-', 'place of its first body among the members')
MEMBERS = group.number('-', 'bodies')
FIRST = group.number('-', 'number of its first unknown')
UNKNOWNS = group.number('-', 'unknowns')
BAND = group.number('-', 'band of its matrix')
MATRIX = group.number('-', 'where its matrix begins')
STATUS = group.number('-', 'of the solution: scratch of the integrator')
CHANGE = group.number('-', 'relative size of the last Newton step: scratch of the integrator')
GROUP = group.size

body = Record()
UNKNOWN = body.number('-', 'number of its first unknown')
COLOUR = body.number('-', 'colour')
OF_GROUP = body.number('-', 'number of its group')
SCRATCH = body.size  # where the scratch of the integrator begins, see `stage`, `linearly_implicit`
BODY = 72  # numbers of a body, whole lines of the cache

POINT, RIGID = 3, 6  # unknowns of a point, of a rigid body
WRENCH = 6  # numbers of a saved wrench: force, torque


class Plan(NamedTuple):
    """
    The parts of a plan.

    n_groups, n_colours : groups, colours
    length   : [m] greatest coordinate that the scene names
    groups   : rows of GROUP
    members  : bodies of the groups
    bodies   : rows of BODY
    table    : derivatives, see `forces.derivatives`
    matrices : of the groups, see `banded`
    vector   : right hand sides of the groups
    wrenches : saved wrenches of the bodies, rows of WRENCH
    """

    n_groups: int
    n_colours: int
    length: float
    groups: Any
    members: Any
    bodies: Any
    table: Any
    matrices: Any
    vector: Any
    wrenches: Any


class System(NamedTuple):
    """
    The linear equations of a group: matrix x = rhs.

    first : number of the first unknown
    size  : unknowns
    """

    first: int
    size: int
    band: int
    matrix: Any
    rhs: Any


@inline
def opened(workspace):
    """Give the parts of a plan."""
    members_at, bodies_at = int(workspace[MEMBERS_AT]), int(workspace[BODIES_AT])
    table_at, matrix_at = int(workspace[TABLE_AT]), int(workspace[MATRIX_AT])
    vector_at, wrenches_at = int(workspace[VECTOR_AT]), int(workspace[WRENCHES_AT])
    return Plan(
        int(workspace[GROUPS]),
        int(workspace[COLOURS]),
        workspace[LENGTH],
        workspace[HEADER:members_at],
        workspace[members_at:bodies_at],
        workspace[bodies_at:table_at],
        workspace[table_at:matrix_at],
        workspace[matrix_at:vector_at],
        workspace[vector_at:wrenches_at],
        workspace[wrenches_at : int(workspace[END])],
    )


@inline
def status_of(plan, row):
    """Status of the group of a body, given by its row."""
    return plan.groups[GROUP * int(row[OF_GROUP]) + STATUS]


@inline
def members_of(row):
    """Places of the members of a group, given by its row."""
    first = int(row[FIRST_MEMBER])
    return range(first, first + int(row[MEMBERS]))


@inline
def system_of(plan, row):
    """Give the linear equations of a group, given by its row."""
    first, unknowns = int(row[FIRST]), int(row[UNKNOWNS])
    return System(
        first,
        unknowns,
        int(row[BAND]),
        plan.matrices[int(row[MATRIX]) :],
        plan.vector[first : first + unknowns],
    )


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
        points = [
            getattr(force, field.name)
            for field in fields(force)  # pyright: ignore[reportArgumentType]
            if field.metadata.get('kind') == 'point'
        ]
        vectors += [point for point in points if point is not None]
    return max((float(np.max(np.abs(vector))) for vector in vectors), default=0.0)


def plan(scene: Scene, layout: Layout, h: float) -> NDArray[np.float64]:
    """Make the plan of a scene; it does not depend on h."""
    graph = neighbours(scene, layout)
    size = [RIGID if i < layout.n_rigid else POINT for i in range(layout.n_moving)]
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
        np.zeros(WRENCH * layout.n_moving),
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
