# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Energy, momentum and angular momentum of a scene, and how far a run has let them drift.

    E = sum p^2 / 2m + L . omega / 2 - m g . r + what the force elements store       [J]
    P = sum p                                                                         [kg m/s]
    L = sum r x p + L_i, about the origin of the world                                [kg m^2/s]

Fixed bodies have none. Under uniform gravity and forces between the bodies alone, P - P0 = M g t,
and the angular momentum about the common centre of mass stays.

Where bodies meet (contact by time stepping), friction and inelastic impacts take energy: it is not
conserved, but it must not rise. Contacts between movable bodies keep P and L; those with a fixed
body or a plane do not. What falls asleep (`contact.sleeping`) rests on something fixed; it loses
what was left of its momentum and kinetic energy.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.forces.element import BodyState
from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.model.inertia_over_time import changing
from rigid_body_sim.physics.model.numbers import exact_sum
from rigid_body_sim.physics.model.place import WORLD
from rigid_body_sim.physics.model.plain_products import cross
from rigid_body_sim.physics.model.scene import Body, Scene
from rigid_body_sim.physics.model.shapes import Particles
from rigid_body_sim.physics.model.variable_mass import flow_of
from rigid_body_sim.physics.state.snapshot import State

Array = NDArray[np.float64]


class Invariants:
    """
    The conserved quantities of one scene.

    energy_is_conserved   : no force of the scene takes or gives energy, and no bodies meet
    energy_must_not_rise  : bodies meet, and no force of the scene takes or gives energy
    is_driven             : a force of the scene, or a flow of mass, brings energy in
    momentum_is_conserved : no force but gravity comes from outside, a pivot's neither
    """

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._moving = np.array([not body.fixed for body in scene.bodies], dtype=bool)
        self._masses = np.array([body.mass if not body.fixed else 0.0 for body in scene.bodies])
        self._inverse = np.divide(
            1.0, self._masses, where=self._moving, out=np.zeros(len(self._masses))
        )
        self._gravity = np.asarray(scene.gravity)
        anchored = {WORLD} | {body.name for body in scene.bodies if body.fixed}
        steady = all(flow_of(body) is None for body in scene.bodies)
        held = any(body.pivot is not None for body in scene.bodies)
        flows = not steady or bool(changing(scene))
        meet = scene.contact.get('mode', 'none') != 'none'
        told = meet and any(moves_others(body) for body in scene.bodies)
        self.is_driven = (
            flows
            or told
            or any(
                getattr(force, 'brings_energy', lambda of=force: _unknown(of))()
                for force in scene.forces
            )
        )
        no_source = not flows and all(f.conserves_energy() for f in scene.forces)
        self.energy_is_conserved = no_source and not meet
        self.energy_must_not_rise = no_source and meet and not told
        obstacles = meet and any(_is_obstacle(body) for body in scene.bodies)
        self.momentum_is_conserved = (
            steady
            and not obstacles
            and not held
            and all(
                len(force.bodies()) > 1 and not anchored & set(force.bodies())
                for force in scene.forces
            )
        )

    @np.errstate(all='ignore')
    def kinetic_energy(self, state: State) -> float:
        """Of translation and rotation [J]."""
        inverse = self._inverse
        if state.masses is not None:
            inverse = np.divide(1.0, state.masses, where=self._moving, out=np.zeros(len(inverse)))
        moving = 0.5 * np.sum(state.momentum**2 * inverse[:, None])
        turning = 0.5 * np.sum(state.angular_momentum * state.angular_velocity)
        return float(moving + turning)

    @np.errstate(all='ignore')
    def kinetic_energy_of(self, state: State, index: int) -> float:
        """Of one body, by its scene index [J]."""
        moving = state.momentum[index] @ state.velocity[index]
        return float(
            0.5 * (moving + state.angular_momentum[index] @ state.angular_velocity[index])
        )

    @np.errstate(all='ignore')
    def potential_energy(self, state: State) -> float:
        """Of gravity, from the origin of the world, and of the force elements [J]."""
        masses = self._masses if state.masses is None else state.masses
        weight = -float(masses @ (state.position @ self._gravity))
        return weight + self.stored_energy(state) if self._scene.forces else weight

    def stored_energy(self, state: State) -> float:
        """Of the force elements alone [J]."""
        matrices = so3.matrix_from_quaternion(state.orientation)
        bodies = {
            body.name: (body, state.position[i], matrices[i])
            for i, body in enumerate(self._scene.bodies)
        }
        view = BodyState(bodies, self._changing_masses(state))
        return exact_sum([force.potential_energy(view) for force in self._scene.forces])

    def _changing_masses(self, state: State) -> dict[str, float]:
        if state.masses is None:
            return {}
        return {
            body.name: float(mass)
            for body, mass in zip(self._scene.bodies, state.masses, strict=True)
            if flow_of(body) is not None
        }

    def energy(self, state: State) -> float:
        """Kinetic and potential [J]."""
        return self.kinetic_energy(state) + self.potential_energy(state)

    @np.errstate(all='ignore')
    def momentum(self, state: State) -> Array:
        """Total momentum (3,) [kg m/s]."""
        return state.momentum.sum(axis=0)

    @np.errstate(all='ignore')
    def angular_momentum(self, state: State) -> Array:
        """Total angular momentum about the origin of the world (3,) [kg m^2/s]."""
        return _orbital(state.position, state.momentum) + state.angular_momentum.sum(axis=0)

    @np.errstate(all='ignore')
    def angular_momentum_about_center(self, state: State) -> Array:
        """Total angular momentum about the common centre of mass (3,) [kg m^2/s]."""
        masses = self._masses if state.masses is None else state.masses
        center = masses @ state.position / (masses.sum() or 1.0)
        velocity = self.momentum(state) / (masses.sum() or 1.0)
        momentum = state.momentum - masses[:, None] * velocity
        return _orbital(state.position - center, momentum) + state.angular_momentum.sum(axis=0)

    @np.errstate(all='ignore')
    def weight(self) -> Array:
        """Total weight (3,) [N]: what changes the momentum of a scene left to itself."""
        return self._masses.sum() * self._gravity

    @np.errstate(all='ignore')
    def scales(self, state: State) -> tuple[float, float, float]:
        """Sizes that drifts of energy, momentum and angular momentum are relative to."""
        energy = self.kinetic_energy(state) + abs(self.potential_energy(state))
        momentum = float(np.sum(np.linalg.norm(state.momentum, axis=1)))
        angular = float(np.sum(np.linalg.norm(state.angular_momentum, axis=1))) + float(
            np.sum(np.linalg.norm(state.position, axis=1) * np.linalg.norm(state.momentum, axis=1))
        )
        return energy, momentum, angular


def _unknown(force: object) -> bool:
    """Whether an element that does not say whether it brings energy in must be taken for one."""
    return not hasattr(force, 'power') and not getattr(force, 'conserves_energy', bool)()


def moves_others(body: Body) -> bool:
    """Whether a body brings energy to those that it touches: it is moved, or its surface."""
    return body.motion is not None or any(body.surface_velocity)


def _is_obstacle(body: Body) -> bool:
    """Whether others bounce off a body that takes no momentum."""
    return body.fixed and not (body.shape is None or isinstance(body.shape, Particles))


def _orbital(position: Array, momentum: Array) -> Array:
    """Sum of r x p."""
    return cross(position, momentum).sum(axis=0)


@dataclass(frozen=True)
class Drift:
    """
    Relative change of what should have stayed the same; None where no conservation law holds.

    energy, momentum, angular_momentum : [-]
    energy_rise : [-]  where bodies meet: how far the energy ever rose above its lowest value
                  before, relative to the largest energy; None elsewhere
    energy_rise_joules : [J] the same
    """

    energy: float | None
    momentum: float | None
    angular_momentum: float | None
    energy_rise: float | None = None
    energy_rise_joules: float | None = None


class DriftMeter:
    """
    Adds up the drift over the stretches of a run in which a conservation law holds.

    A command works on the bodies, so a stretch with a command does not count; nor, for energy, any
    stretch of a scene with drag or dampers.
    """

    def __init__(self, invariants: Invariants, state: State, *, time: float) -> None:
        self._of = invariants
        self._last = self._measure(state, time)
        self._drift = [0.0, np.zeros(3), np.zeros(3)]
        self._worst = np.zeros(3)
        self._lowest = 0.0  # of the energy drift, so far
        self._rise = 0.0
        self._scales = np.array(invariants.scales(state))

    def _measure(self, state: State, time: float) -> tuple[float, Array, Array]:
        momentum = self._of.momentum(state) - time * self._of.weight()
        return self._of.energy(state), momentum, self._of.angular_momentum_about_center(state)

    def sample(self, state: State, *, time: float, commanded: bool) -> None:
        """
        Take the state at a later time [s]; `commanded`: whether a command acted since the last
        one.
        """
        with np.errstate(
            over='ignore', invalid='ignore'
        ):  # a run about to diverge squares to infinity
            self._take(state, time, commanded)

    def _take(self, state: State, time: float, commanded: bool) -> None:
        now = self._measure(state, time)
        if not commanded:
            self._drift = [
                total + (new - old)
                for total, new, old in zip(self._drift, now, self._last, strict=True)
            ]
        self._worst = np.maximum(self._worst, [np.linalg.norm(total) for total in self._drift])
        energy = float(self._drift[0])
        self._lowest = min(self._lowest, energy)
        self._rise = max(self._rise, energy - self._lowest)
        self._scales = np.maximum(self._scales, self._of.scales(state))
        self._last = now

    def drift(self) -> Drift:
        """Give the worst drift met at any sample, relative to the largest values met."""
        energy, momentum, angular = map(_relative, self._worst, self._scales)
        return Drift(
            energy if self._of.energy_is_conserved else None,
            momentum if self._of.momentum_is_conserved else None,
            angular if self._of.momentum_is_conserved else None,
            _relative(self._rise, self._scales[0]) if self._of.energy_must_not_rise else None,
            self._rise if self._of.energy_must_not_rise else None,
        )


def _relative(worst: float, scale: float) -> float:
    if scale == 0.0:
        return 0.0
    return float(worst) / float(scale) if scale < math.inf else math.inf
