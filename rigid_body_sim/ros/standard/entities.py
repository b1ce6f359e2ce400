# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The bodies of a scene as `simulation_interfaces` speaks of them: entities with a category, tags,
a description and bounds, which a client may filter. No message type is known here.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass, field
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.model.scene import Body, Scene
from rigid_body_sim.physics.model.variable_mass import flow_of
from rigid_body_sim.physics.state.snapshot import State
from rigid_body_sim.ros.standard.extents import Extent, Pose, extent_of
from rigid_body_sim.ros.standard.posix_expressions import BadExpression, Expression

Array = NDArray[np.float64]


class Category(Enum):
    """What moves, and what does not."""

    MOVABLE = 'movable'
    FIXED = 'fixed'


class Unsupported(Exception):
    """A wish that the standard knows and this simulator does not grant."""


class Refused(Exception):
    """A wish that makes no sense."""


@dataclass(frozen=True, eq=False)
class Ball:
    """Where a client looks: center (3,) [m], radius [m]."""

    center: Array
    radius: float


@dataclass(frozen=True, eq=False)
class Cuboid:
    """Where a client looks: center (3,) [m], half edges (3,) [m], axes of the world."""

    center: Array
    half: Array


@dataclass(frozen=True, eq=False)
class Wanted:
    """
    Which entities a client asks for: those that meet every wish.

    pattern    : regular expression (POSIX extended) that the whole name matches; '': any
    categories : one of them; empty: any
    tags       : that an entity must have; empty: any
    every_tag  : whether all of them, else one
    within     : which it overlaps; None: wherever it is
    """

    pattern: str = ''
    categories: Collection[Category | None] = ()
    tags: Collection[str] = ()
    every_tag: bool = False
    within: Ball | Cuboid | None = None


@dataclass(frozen=True, eq=False)
class Entity:
    """One body."""

    name: str
    category: Category
    tags: tuple[str, ...]
    description: str
    extent: Extent = field(repr=False)


class Entities:
    """The bodies of a scene, in its order."""

    def __init__(self, scene: Scene) -> None:
        self.all = tuple(_entity(body) for body in scene.bodies)
        self.index = {entity.name: i for i, entity in enumerate(self.all)}

    def find(self, wanted: Wanted, state: State) -> list[int]:
        """Return the indices of those that meet all wishes; Refused for a bad expression."""
        pattern = _expression(wanted.pattern) if wanted.pattern else None
        some_or_all = all if wanted.every_tag else any
        return [
            i
            for i, entity in enumerate(self.all)
            if (pattern is None or pattern.matches(entity.name))
            and (not wanted.categories or entity.category in wanted.categories)
            and (not wanted.tags or some_or_all(tag in entity.tags for tag in wanted.tags))
            and (wanted.within is None or _overlaps(entity, i, wanted.within, state))
        ]


def _expression(text: str) -> Expression:
    try:
        return Expression(text)
    except BadExpression as error:
        raise Refused(f'the filter {text[:100]!r} is no regular expression: {error}') from None


def _overlaps(entity: Entity, index: int, within: Ball | Cuboid, state: State) -> bool:
    pose = Pose.of(state.position[index], state.orientation[index])
    if isinstance(within, Ball):
        return entity.extent.meets_ball(pose, within.center, within.radius)
    return entity.extent.meets_box(pose, within.center, within.half)


def _entity(body: Body) -> Entity:
    shape = None if body.shape is None else _words(type(body.shape).__name__)
    kind = 'fixed' if body.fixed else 'point_mass' if body.is_point else 'rigid'
    said = {'fixed': 'fixed body', 'point_mass': 'point mass', 'rigid': 'rigid body'}[kind]
    if not body.fixed:
        said += f' of {body.mass:g} kg' + (' at the start' if flow_of(body) is not None else '')
    if shape is not None and not body.is_point:
        said += f', {shape.replace("_", " ")}'
    return Entity(
        name=body.name,
        category=Category.FIXED if body.fixed else Category.MOVABLE,
        tags=(kind,) if shape is None else (kind, shape),
        description=said,
        extent=extent_of(body),
    )


def _words(name: str) -> str:
    """Write a name as scene files write the type of a shape: ConvexHull -> convex_hull."""
    return re.sub(r'(?<=[a-z])(?=[A-Z])', '_', name).lower()
