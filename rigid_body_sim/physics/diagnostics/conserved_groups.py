# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What keeps its momentum and angular momentum in a scene of which the whole does not.

A group is what forces and contacts between movable bodies tie together. Where nothing acts on it
from outside but uniform gravity,

    momentum         : sum p - M g t                                       [kg m/s]
    angular momentum : sum (r - c) x (p - m v_c) + L_i, about its centre of mass   [kg m^2/s]

stay. Of a body on which forces act, but at its centre of mass and without a torque, the own
angular momentum L stays; of one that turns about a pivot under gravity alone, its component along
gravity about the pivot (all of it where there is no gravity). A command on a body ends the law for
its group as long as it acts, not for the others.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.model.place import WORLD
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.model.shapes import Particles
from rigid_body_sim.physics.model.variable_mass import flow_of
from rigid_body_sim.physics.state.snapshot import State

Array = NDArray[np.float64]

MOMENTUM = 'momentum'
ANGULAR_MOMENTUM = 'angular momentum'
SPIN = 'own angular momentum'
ABOUT_PIVOT = 'angular momentum about the pivot'
ALONG_GRAVITY = 'angular momentum about the pivot along gravity'


@dataclass(frozen=True)
class KeptQuantity:
    """
    How well a group kept what it should have kept.

    bodies   : of the group
    quantity : 'momentum', 'angular momentum', 'own angular momentum', …
    drift    : [-] worst change at any look, relative to the largest value met
    """

    bodies: tuple[str, ...]
    quantity: str
    drift: float


class ConservedGroups:
    """The groups of one scene and their laws; `measure` gives a row for each law."""

    def __init__(self, scene: Scene) -> None:
        self._names = [body.name for body in scene.bodies]
        self._gravity = np.asarray(scene.gravity, dtype=np.float64)
        self._masses = np.array([0.0 if body.fixed else body.mass for body in scene.bodies])
        groups, outside = _tied(scene)
        free = [group for group in groups if not outside & set(group)]
        self._members = np.array([i for group in free for i in group], dtype=np.int64)
        self._group = np.array([g for g, group in enumerate(free) for _ in group], dtype=np.int64)
        self._count = len(free)
        mass = np.zeros(self._count)
        np.add.at(mass, self._group, self._masses[self._members])
        self._group_mass = mass
        meet = scene.contact.get('mode', 'none') != 'none'
        kept = {group[0] for group in free if len(group) == 1}
        self._spins = [
            i for i, _ in enumerate(scene.bodies)
            if i not in kept and not meet and _spins_freely(scene, i)
        ]  # fmt: skip
        self._pivots = [
            (i, np.asarray(body.pivot.at))
            for i, body in enumerate(scene.bodies)
            if body.pivot is not None and not any(body.name in f.bodies() for f in scene.forces)
        ]
        strength = float(np.linalg.norm(self._gravity))
        self._axis = self._gravity / strength if strength else None
        turning = ALONG_GRAVITY if strength else ABOUT_PIVOT
        self.laws: list[tuple[tuple[int, ...], str]] = [
            *((tuple(group), MOMENTUM) for group in free),
            *((tuple(group), ANGULAR_MOMENTUM) for group in free if _turns(scene, group)),
            *(((i,), SPIN) for i in self._spins),
            *(((i,), turning) for i, _ in self._pivots),
        ]
        self._turning = [g for g, group in enumerate(free) if _turns(scene, group)]

    def names(self, bodies: Sequence[int]) -> tuple[str, ...]:
        """Name bodies by their scene indices."""
        return tuple(self._names[i] for i in bodies)

    def measure(self, state: State, time: float) -> tuple[Array, Array]:
        """Give what each law says stays, (laws, 3), and its size, (laws,)."""
        m, g = self._members, self._group
        momentum, size = self._sums(state.momentum[m]), self._sizes(state.momentum[m])
        mass = np.maximum(self._group_mass, np.finfo(float).tiny)[:, None]
        center = self._sums(self._masses[m][:, None] * state.position[m]) / mass
        arm = state.position[m] - center[g]
        relative = state.momentum[m] - self._masses[m][:, None] * (momentum / mass)[g]
        orbital = np.cross(arm, relative)
        angular = self._sums(orbital + state.angular_momentum[m])
        angular_size = self._sizes(orbital) + self._sizes(state.angular_momentum[m])
        own = state.angular_momentum[self._spins]
        about = [
            state.angular_momentum[i] + np.cross(state.position[i] - at, state.momentum[i])
            for i, at in self._pivots
        ]
        sizes = np.array([np.linalg.norm(x) for x in about])
        if self._axis is not None:
            about = [self._axis * (self._axis @ x) for x in about]
        values = np.concatenate(
            [
                momentum - time * self._group_mass[:, None] * self._gravity,
                angular[self._turning],
                own.reshape(-1, 3),
                np.array(about).reshape(-1, 3),
            ]
        )
        return values, np.concatenate(
            [size, angular_size[self._turning], np.linalg.norm(own, axis=1), sizes]
        )

    def _sums(self, values: Array) -> Array:
        found = np.zeros((self._count, 3))
        np.add.at(found, self._group, values)
        return found

    def _sizes(self, values: Array) -> Array:
        found = np.zeros(self._count)
        np.add.at(found, self._group, np.linalg.norm(values, axis=1))
        return found


class GroupDrifts:
    """Adds up, law by law, the drift over the stretches in which no command acts on the group."""

    def __init__(self, groups: ConservedGroups, state: State, *, time: float) -> None:
        self._of = groups
        self._last, self._scales = groups.measure(state, time)
        self._drift = np.zeros_like(self._last)
        self._worst = np.zeros(len(self._last))

    def sample(self, state: State, *, time: float, commanded: Collection[int]) -> None:
        """
        Take the state at a later time [s]; `commanded`: scene indices of the bodies on which a
        command acted since the last one.
        """
        with np.errstate(over='ignore', invalid='ignore'):
            now, sizes = self._of.measure(state, time)
            change = now - self._last
            if commanded:
                touched = [not set(commanded).isdisjoint(bodies) for bodies, _ in self._of.laws]
                change[touched] = 0.0
            self._drift += change
            self._worst = np.maximum(self._worst, np.linalg.norm(self._drift, axis=1))
            self._scales = np.maximum(self._scales, sizes)
            self._last = now

    def kept(self) -> list[KeptQuantity]:
        """Give the worst drift of each law, relative to the largest values met."""
        relative = np.divide(
            self._worst, self._scales, where=self._scales > 0.0, out=np.zeros(len(self._worst))
        )
        return [
            KeptQuantity(self._of.names(bodies), quantity, float(drift))
            for (bodies, quantity), drift in zip(self._of.laws, relative, strict=True)
        ]


def _tied(scene: Scene) -> tuple[list[list[int]], set[int]]:
    """
    Find what ties movable bodies together, and the bodies on which something acts from outside.
    """
    index = {body.name: i for i, body in enumerate(scene.bodies)}
    movable = [i for i, body in enumerate(scene.bodies) if not body.fixed]
    root = {i: i for i in movable}

    def find(i: int) -> int:
        while root[i] != i:
            root[i] = root[root[i]]
            i = root[i]
        return i

    outside = {
        i for i in movable
        if scene.bodies[i].pivot is not None or flow_of(scene.bodies[i]) is not None
    }  # fmt: skip
    ties = [force.bodies() for force in scene.forces]
    if scene.contact.get('mode', 'none') != 'none':
        ties.append(tuple(b.name for b in scene.bodies if _may_touch(b)))
    for names in ties:
        of_scene = [index[name] for name in names if name != WORLD]
        held = [i for i in of_scene if i in root]
        if len(names) == 1 or len(held) < len(names):
            outside.update(held)
        for i in held[1:]:
            root[find(i)] = find(held[0])
    groups: dict[int, list[int]] = {}
    for i in movable:
        groups.setdefault(find(i), []).append(i)
    return list(groups.values()), outside


def _may_touch(body: object) -> bool:
    shape = getattr(body, 'shape', None)
    return shape is not None and not isinstance(shape, Particles)


def _turns(scene: Scene, group: Sequence[int]) -> bool:
    """Whether a group has an angular momentum about its centre at all."""
    return len(group) > 1 or not scene.bodies[group[0]].is_point


def _spins_freely(scene: Scene, index: int) -> bool:
    """Whether forces act on a rigid body, but no torque does."""
    body = scene.bodies[index]
    if body.fixed or body.is_point or body.pivot is not None or flow_of(body) is not None:
        return False
    return not any(
        getattr(force, 'turns', lambda _name: True)(body.name)
        for force in scene.forces
        if body.name in force.bodies()
    )
