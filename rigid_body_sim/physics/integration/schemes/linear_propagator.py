# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The exact propagator of linear systems of point masses: a product of a matrix and a vector in place
of a step.

    (s, v) <- Phi (s, v) + Psi F / m
        s : place relative to where the springs hold the point
        F : what is constant

Springs without rest length act alike along x, y and z, so one matrix serves the three axes. Phi
and Psi depend on masses, springs, drag and h alone and are computed once: see
`linear_motion`. A group of n connected points costs 18 n^2 multiplications a tick,
whatever h is.

Plan of a scene: number of groups; for each its size n and kind, then of its bodies the indices,
the centres (3), the constant accelerations (3), and the MATRICES row by row; room for the state of
a group. An anchored group
is set anew each tick, so that a decay goes on below the rounding of the start; the others are
moved by compensated changes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.integration.schemes import linear_motion
from rigid_body_sim.physics.integration.schemes.implicit import coupling
from rigid_body_sim.physics.integration.schemes.steps import finite
from rigid_body_sim.physics.model.place import WORLD
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.state.blocks import (
    HELD_FORCE,
    INVERSE_MASS,
    LANES,
    MOMENTUM,
    MOMENTUM_RESIDUAL,
    POSITION,
    POSITION_RESIDUAL,
    TRANSLATION,
    add_compensated,
    at,
)
from rigid_body_sim.physics.state.layout import Layout

Array = NDArray[np.float64]

PARTLY_HELD, ANCHORED, DRIFTING = 0.0, 1.0, 2.0  # kinds of groups

N_GROUPS = 0  # head of the plan
HEAD = 1
BODIES, KIND, MEMBERS = 0, 1, 2  # head of a group; its members begin there
AXES = 3
# matrices of a group: Phi_rr, Phi_rv, Phi_vr, Phi_vv, Psi_r, Psi_v
PHI_RR, PHI_RV, PHI_VR, PHI_VV, PSI_R, PSI_V = range(6)
MATRICES = 6
PLACES, VELOCITIES, ACCELERATIONS = 0, 1, 2  # parts of the state of a group along one axis
STATE = 3

USE_INSTEAD = 'use sdirk2 or linearly_implicit for stiff forces, dmv6 for others'


def refuses(scene: Scene) -> str | None:
    """Tell what in a scene is not linear, or None."""
    for body in scene.bodies:
        if not body.fixed and not body.is_point:
            return (
                f'the body {body.name!r} can turn, and the propagator moves point masses only;'
                f' {USE_INSTEAD}'
            )
        if getattr(body, 'mass_flow', None) is not None:
            return f'the mass of {body.name!r} changes, so its motion is not linear; {USE_INSTEAD}'
    for force in scene.forces:
        kind = force.TYPE
        if kind == 'spring' and force.rest_length != 0.0:
            return (
                f'a spring of rest length {force.rest_length:g} m is not linear in space; '
                f'{USE_INSTEAD}'
            )
        if kind == 'drag' and force.quadratic != 0.0:
            return f'drag quadratic in velocity is not linear; {USE_INSTEAD}'
        if kind not in ('spring', 'drag', 'constant'):
            return (
                f'a force of type {kind!r} is not a linear spring, linear drag or constant '
                f'force; {USE_INSTEAD}'
            )
    return None


def _matrices(scene: Scene, layout: Layout) -> tuple[Array, Array, Array, Array]:
    """
    Collect stiffness and damping (n, n), what anchors pull with at the origin (n, 3), and constant
    forces (n, 3).
    """
    n = layout.n_moving
    stiffness, damping = np.zeros((n, n)), np.zeros((n, n))
    anchored, constant = np.zeros((n, 3)), np.zeros((n, 3))
    for force in scene.forces:
        if force.TYPE == 'spring':
            ends = [layout.place(force.a, force.a_point), layout.place(force.b, force.b_point)]
            for one, other in (ends, ends[::-1]):
                if one.index < 0:
                    continue
                for matrix, value in ((stiffness, force.stiffness), (damping, force.damping)):
                    matrix[one.index, one.index] += value
                    if other.index >= 0:
                        matrix[one.index, other.index] -= value
                if other.index < 0:
                    anchored[one.index] += force.stiffness * np.asarray(other.offset)
        else:
            index = layout.place(force.body, None).index
            if index >= 0 and force.TYPE == 'drag':
                damping[index, index] += force.linear
            elif index >= 0:
                constant[index] += force.force
    return stiffness, damping, anchored, constant


def _groups(scene: Scene, layout: Layout, h: float) -> Iterator[Array]:
    stiffness, damping, anchored, constant = _matrices(scene, layout)
    for members in coupling.components(coupling.neighbours(scene, layout)):
        pick = np.array(members)
        k, c, m = stiffness[np.ix_(pick, pick)], damping[np.ix_(pick, pick)], layout.masses[pick]
        kind = _kind(scene, {layout.body(i).name for i in members})
        centre = (
            np.linalg.solve(k, anchored[pick]) if kind == ANCHORED else np.zeros((len(pick), 3))
        )
        rr, rv, vr, vv, psi_r, psi_v, rr_change, vv_change = linear_motion.system(
            m, k, c, h, drifts=kind == DRIFTING
        )
        if kind != ANCHORED:
            rr, vv = rr_change, vv_change
        yield np.concatenate(
            [
                [len(pick), kind],
                pick,
                centre.reshape(-1),
                (constant[pick] / m[:, None]).reshape(-1),
                np.concatenate([rr, rv, vr, vv, psi_r, psi_v]).reshape(-1),
            ]
        )


def _kind(scene: Scene, names: set[str]) -> float:
    """
    Tell whether springs hold every body of a group to the world, directly or through others, or
    none.
    """
    springs = [force for force in scene.forces if force.TYPE == 'spring']
    fixed = {WORLD, *(body.name for body in scene.bodies if body.fixed)}
    if not any(set(s.bodies()) & fixed and set(s.bodies()) & names for s in springs):
        return DRIFTING
    held, grown = set(fixed), True
    while grown:
        grown = False
        for spring in springs:
            ends = set(spring.bodies())
            if spring.stiffness > 0.0 and ends & held and not ends <= held:
                held |= ends
                grown = True
    return ANCHORED if names <= held else PARTLY_HELD


def plan(scene: Scene, layout: Layout, h: float) -> Array:
    """Compute the propagators of a scene for one h."""
    groups = list(_groups(scene, layout, h))
    largest = max((int(group[0]) for group in groups), default=0)
    return np.concatenate([[len(groups)], *groups, np.zeros(STATE * largest)])


@kernel
def _read(axis, n, kind, group, state, translation):
    """Read the state of a group along one axis, and its constant accelerations."""
    centres = MEMBERS + n + axis
    constants = centres + AXES * n
    origin = 0.0  # of a drifting group: its first body
    if kind == DRIFTING:
        origin = translation[at(int(group[MEMBERS]), TRANSLATION) + LANES * axis + POSITION]
    for i in range(n):
        place = at(int(group[MEMBERS + i]), TRANSLATION)
        over_mass = translation[place + INVERSE_MASS]
        place += LANES * axis
        centre, constant = group[centres + AXES * i], group[constants + AXES * i]
        state[PLACES * n + i] = translation[place + POSITION] - origin - centre
        state[VELOCITIES * n + i] = translation[place + MOMENTUM] * over_mass
        acceleration = translation[place + HELD_FORCE] * over_mass + constant
        state[ACCELERATIONS * n + i] = acceleration


@kernel
def _move(axis, n, kind, group, state, translation):
    """Move a group along one axis by the product of its matrices and its state."""
    centres = MEMBERS + n + axis
    matrices = MEMBERS + n + 2 * AXES * n
    square = n * n
    for i in range(n):
        place = at(int(group[MEMBERS + i]), TRANSLATION)
        over_mass = translation[place + INVERSE_MASS]
        place += LANES * axis
        displacement = velocity = 0.0
        for j in range(n):
            entry = matrices + n * i + j
            r, v = state[PLACES * n + j], state[VELOCITIES * n + j]
            acceleration = state[ACCELERATIONS * n + j]
            displacement += (
                group[entry + PHI_RR * square] * r
                + group[entry + PHI_RV * square] * v
                + group[entry + PSI_R * square] * acceleration
            )
            velocity += (
                group[entry + PHI_VR * square] * r
                + group[entry + PHI_VV * square] * v
                + group[entry + PSI_V * square] * acceleration
            )
        if kind == ANCHORED:
            translation[place + POSITION] = group[centres + AXES * i] + displacement
            translation[place + MOMENTUM] = velocity / over_mass
            translation[place + POSITION_RESIDUAL] = 0.0
            translation[place + MOMENTUM_RESIDUAL] = 0.0
        else:
            translation[place + POSITION], translation[place + POSITION_RESIDUAL] = (
                add_compensated(
                    translation[place + POSITION],
                    translation[place + POSITION_RESIDUAL],
                    displacement,
                )
            )
            translation[place + MOMENTUM], translation[place + MOMENTUM_RESIDUAL] = (
                add_compensated(
                    translation[place + MOMENTUM],
                    translation[place + MOMENTUM_RESIDUAL],
                    velocity / over_mass,
                )
            )


@kernel
def _advance(
    ticks, tick, h, n_bodies, n_rigid, translation, rotation, method, workspace, elements, ranges
):
    """Advance points. Return DONE, or NaN if a number left the finite ones."""
    start = HEAD
    for _group in range(int(workspace[N_GROUPS])):
        n, kind = int(workspace[start + BODIES]), workspace[start + KIND]
        end = start + MEMBERS + n + 2 * AXES * n + MATRICES * n * n
        group = workspace[start:end]
        state = workspace[len(workspace) - STATE * n : len(workspace)]
        for _tick in range(ticks):
            for axis in range(AXES):
                _read(axis, n, kind, group, state, translation)
                _move(axis, n, kind, group, state, translation)
        start = end
    return finite(n_bodies, n_rigid, translation, rotation)


@dataclass(frozen=True)
class LinearPropagator:
    """The scheme of the exact propagator; forces are in its matrices and are not evaluated."""

    def free(self, name: str) -> Callable[..., Any]:
        """Make the kernel, which is the same for all scenes."""
        return _advance

    def coupled(
        self, name: str, *, scene: str, evaluate: Callable[..., Any], velocity_dependent: bool
    ) -> Callable[..., Any]:
        """Make the kernel, which is the same for all scenes."""
        return _advance

    def workspace(self, blocks: int) -> int:
        """Count no numbers: the plan of the scene has room for all."""
        return 0
