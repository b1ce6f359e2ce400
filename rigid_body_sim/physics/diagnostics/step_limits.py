# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Whether the step of a run is within the limits of its integrator: rotation, springs, drag.

    rotation    : h |omega|  of each rigid body, at this instant; some methods have a limit that
                  falls with its I_max/I_min (`Limits.slender`)
    oscillation : h omega,   omega^2 <= S_a + S_b over the ties of a body, S_i = sum k w_i; some
                  methods have a limit of their own where a tie is bent: its force is not linear
                  in the state, because it has a rest length or holds a body off its centre
    relaxation  : h k,       k <= S_a + S_b with the dampings in place of the stiffnesses

        h   : [s]       step: tick / substeps, and over those of contact where bodies meet
        w_i : [1/kg]    largest eigenvalue of 1/m - [a] I^-1 [a], a the arm of the tie at body i:
                        by how much its end yields to an impulse, across the worst direction

The largest frequency of several springs is at most that of the bound (Gershgorin's, on the matrix
of the ties); for one spring it is exact, for a chain of equal masses nearly so, for springs that
pull in different directions up to sqrt 3 too high. Elements that name no `tie` do not count. Quick
enough to be asked whenever figures are read; nothing is asked in a tick.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.diagnostics.numerical_damping import (
    NumericalDamping,
    damps_no_spring,
    worst_damping,
)
from rigid_body_sim.physics.forces.element import Tie
from rigid_body_sim.physics.integration.integrator import Integrator
from rigid_body_sim.physics.integration.integrators import INTEGRATORS
from rigid_body_sim.physics.model.place import WORLD
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.state.layout import Layout
from rigid_body_sim.physics.state.snapshot import State

Array = NDArray[np.float64]

KINDS = ('rotation', 'oscillation', 'relaxation')
ROUNDING = 1.0 + 1e-9  # a step that is the limit itself, but for rounding, is within it
MOST_OF_CONTACT = 1000  # substeps of contact that a scene may have
KEEP = ('linear_propagator', 'implicit_midpoint', 'force_gradient4')  # the energy of springs
INSTEAD = ('dmv6', 'rk4', 'linearly_implicit', 'sdirk2', 'exact_rotor')  # in order of preference


@dataclass(frozen=True)
class StepLimitViolation:
    """
    A step limit that is violated.

    kind   : 'rotation', 'oscillation' or 'relaxation'
    bodies : scene indices, the worst first
    text   : one line: body, the product with the step, the limit, the cure
    """

    kind: str
    bodies: tuple[int, ...]
    text: str


class StabilityWatch:
    """Compares the rates of a scene with the limits of one integrator at one tick length."""

    def __init__(self, scene: Scene, layout: Layout, integrator: Integrator, dt: float) -> None:
        self._scene = scene
        self._layout = layout
        self._integrator = integrator
        self._dt = dt
        self._of_contact = substeps_of_contact(scene)
        self._h = dt / (integrator.substeps * self._of_contact)

    def check(
        self, state: State, said: Mapping[str, Collection[int]] | None = None
    ) -> list[StepLimitViolation]:
        """
        Find the limits that a state violates.

        said : by kind, the bodies (scene indices) that need not be named again
        """
        found = []
        with np.errstate(all='ignore'):  # a run about to diverge squares to infinity
            rates, limits = self.rates(state), self._limits(state)
        for kind in KINDS:
            with np.errstate(invalid='ignore'):  # both may be infinite
                share = self._h * rates[kind] / (limits[kind] * ROUNDING)
            beyond = [int(core) for core in np.flatnonzero(share > 1.0)]
            known = (said or {}).get(kind, ())
            new = [core for core in beyond if int(self._layout.moving[core]) not in known]
            if new:
                new.sort(key=lambda core: (-share[core], self._layout.moving[core]))
                worst, more = new[0], len(new) - 1
                text = self._text(kind, worst, float(rates[kind][worst]), limits[kind][worst])
                text += f' ({more} bod{"y" if more == 1 else "ies"} more)' if more else ''
                bodies = tuple(int(self._layout.moving[core]) for core in new)
                found.append(StepLimitViolation(kind, bodies, text))
        return found

    @property
    def has_bent_ties(self) -> bool:
        """Whether a spring has a rest length, or holds a body off its centre (`Limits.bent`)."""
        return bool(self._ties.bent.any())

    def rates(self, state: State) -> dict[str, Array]:
        """Give the rates of all moving bodies, core order, (n_moving,) [rad/s], [rad/s], [1/s]."""
        n, rigid = self._layout.n_moving, self._layout.moving[: self._layout.n_rigid]
        rotation = np.zeros(n)
        rotation[: len(rigid)] = np.linalg.norm(state.angular_velocity_body[rigid], axis=1)
        ties = self._ties
        lighter = np.ones(n)  # mass and moments at the start over those of now
        if state.masses is not None:
            lighter = self._layout.masses / state.masses[self._layout.moving]
        for core, share in self._least_inertia.items():
            lighter[core] *= share
        speed = np.linalg.norm(state.velocity[self._layout.moving], axis=1)
        damping = ties.damping + ties.quadratic * speed[ties.a]
        turning = ties.angular + ties.angular_quadratic * rotation[ties.a]
        relaxation = np.maximum(
            ties.bound(damping, lighter), ties.largest(turning * ties.twist * lighter[ties.a])
        )
        return {
            'rotation': rotation,
            'oscillation': np.sqrt(ties.bound(ties.stiffness, lighter)),
            'relaxation': relaxation,
        }

    def damping(self, state: State) -> NumericalDamping | None:
        """
        Find the oscillation that the steps themselves damp most; None: none worth a word.

        Where the dampers of a scene take ten times as much, what the steps take is not told.
        """
        with np.errstate(all='ignore'):  # a run about to diverge squares to infinity
            rates = self.rates(state)
        found = worst_damping(
            self._integrator, self._h, rates['oscillation'], dampers=rates['relaxation']
        )
        if found is None:
            return None
        core, damping = found
        return replace(
            damping, body=self._layout.body(core).name, cure=self._cure_of_damping(damping)
        )

    def _cure_of_damping(self, damping: NumericalDamping) -> str:
        """Say what would hardly damp."""
        times = damping.product / damping.unnoticed
        cures = []
        shorter = _rounded_down(self._dt / times)
        if shorter >= 1e-9:
            cures.append(f'dt <= {shorter:g} s')
        for name in KEEP:
            other = INTEGRATORS[name]
            if (
                damps_no_spring(other)
                and other.limits.oscillation >= damping.product
                and (not self.has_bent_ties or other.limits.bent >= damping.product)
                and other.refuses(self._scene) is None
                and self._may_meet_contact(other)
            ):
                cures.append(f'the integrator {name}')
                break
        return f'take {", or ".join(cures)}' if cures else 'take another integrator'

    def _limits(self, state: State) -> dict[str, Array]:
        """Give the limits of all moving bodies, core order."""
        limits, n = self._integrator.limits, self._layout.n_moving
        rotation = np.full(n, limits.rotation)
        rotation[: self._layout.n_rigid] = limits.rotation_of(self._ratios)
        oscillation = np.full(n, self._oscillation)
        if limits.resists:
            rates = self.rates(state)
            damped = self._h * rates['oscillation'] ** 2 <= rates['relaxation'] * ROUNDING
            oscillation[damped] = math.inf
        oscillation[self._ties.bent] = np.minimum(oscillation[self._ties.bent], limits.bent)
        return {
            'rotation': rotation,
            'oscillation': oscillation,
            'relaxation': np.full(n, limits.relaxation),
        }

    @cached_property
    def _oscillation(self) -> float:
        """The limit of springs that are not bent."""
        limits = self._integrator.limits
        if any(force.depends_on_velocity() for force in self._scene.forces):
            return limits.oscillation_with_velocity or limits.oscillation
        return limits.oscillation

    @cached_property
    def _ratios(self) -> Array:
        """I_max/I_min of the rigid bodies, core order: the largest that each ever has."""
        moments = self._layout.moments
        ratios = moments.max(axis=1, initial=0.0) / moments.min(axis=1, initial=np.inf)
        for core in range(self._layout.n_rigid):
            law = self._layout.body(core).inertia_over_time
            if law is not None:
                rows = np.array(law.table)[:, 1:]  # between two the ratio is between theirs
                ratios[core] = max(np.max(rows.max(axis=1) / rows.min(axis=1)), ratios[core])
        return ratios

    @cached_property
    def _least_inertia(self) -> dict[int, float]:
        """Moments at the start over the least that a body ever has, by core index."""
        found = {}
        for core in range(self._layout.n_rigid):
            law = self._layout.body(core).inertia_over_time
            if law is not None:
                least = np.min(np.array(law.table)[:, 1:], axis=0)
                found[core] = float(np.max(self._layout.moments[core] / least))
        return found

    @cached_property
    def _ties(self) -> _Ties:
        found = [f.tie() for f in self._scene.forces if hasattr(f, 'tie')]
        return _Ties(found, self._layout)

    def _text(self, kind: str, core: int, rate: float, limit: float) -> str:
        name, body = self._integrator.name, self._layout.body(core).name
        product = f'{self._h * rate:.3g}'
        if kind == 'rotation':
            said = (
                f'{body!r} turns by h |omega| = {product} rad a step; {name} is sure to keep the '
                'energy and angular momentum of such a free body within 1 % over 5000 steps only '
                f'up to {limit:.3g}'
            )
        elif kind == 'oscillation':
            said = f'{body!r} may swing at {rate:.3g} rad/s, h omega = {product} a step; {name} '
            if limit == self._integrator.limits.bent:
                said += (
                    'is sure to keep the energy of springs that have a rest length or hold a body '
                    f'off its centre only up to {limit:g}'
                )
            elif self._integrator.limits.resists:
                said += f'lets it grow from {limit:g} on, unless damping c >= h k of its springs'
            else:
                said += f'is stable only up to {limit:g}'
        else:
            said = (
                f'{body!r} is braked at up to {rate:.3g} 1/s, h k = {product} a step; '
                f'{name} is stable only up to {limit:g}'
            )
        bent = kind == 'oscillation' and bool(self._ties.bent[core])
        return f'{said}; {self._cure(kind, self._h * rate, limit, bent=bent)}'

    def _may_meet_contact(self, integrator: Integrator) -> bool:
        if self._scene.contact.get('mode', 'none') == 'none':
            return True
        from rigid_body_sim.physics.contact.suited_integrators import unsuited  # where it is asked

        return unsuited(integrator) is None

    def _cure(self, kind: str, product: float, limit: float, *, bent: bool) -> str:
        """Say what would be within the limit."""
        times = product / limit
        cures = []
        shorter = _rounded_down(self._dt / times)
        if shorter >= 1e-9:
            cures.append(f'dt <= {shorter:g} s')
        substeps = math.ceil(times * self._integrator.substeps) if times < 1e6 else 10**7
        if substeps <= 1_000_000 and 'substeps' in self._integrator.options:
            cures.append(f'substeps: {substeps}')
        of_contact = math.ceil(times * self._of_contact) if times < 1e6 else 10**7
        if self._of_contact > 1 and of_contact <= MOST_OF_CONTACT:
            cures.append(f'contact.substeps: {of_contact}')
        for name in INSTEAD:
            other = INTEGRATORS[name]
            if (
                name != self._integrator.name
                and getattr(other.limits, kind) >= product
                and (not bent or other.limits.bent >= product)
                and other.refuses(self._scene) is None
                and self._may_meet_contact(other)
            ):
                cures.append(f'the integrator {name}')
                break
        return f'take {", or ".join(cures)}' if cures else 'no step or integrator resolves it'


def substeps_of_contact(scene: Scene) -> int:
    """Count the steps that contact makes of one of the method; 1 where no bodies meet."""
    if scene.contact.get('mode', 'none') == 'none':
        return 1
    from rigid_body_sim.physics.contact.settings import ContactSettings  # only what a scene needs

    return ContactSettings.of(scene.contact).substeps


def _rounded_down(value: float) -> float:
    """Keep two digits."""
    if not 0.0 < value < math.inf:
        return 0.0
    unit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return math.floor(value / unit * ROUNDING) * unit


class _Ties:
    """
    The ties of a scene as arrays, one entry each.

    a, b     : core index; -1: holds no moving body
    at_a, at_b : w of the two ends [1/kg], zero where nothing moves
    twist    : largest inverse moment of a [1/(kg m^2)]
    bent     : (n_moving,) whether a tie of a body is not linear in the state
    """

    def __init__(self, ties: list[Tie], layout: Layout) -> None:
        self._n = layout.n_moving
        ties = [tie if _moves(tie.a[0], layout) else _turned(tie) for tie in ties]
        ties = [tie for tie in ties if _moves(tie.a[0], layout)]
        ends = [[layout.place(*end) for end in (tie.a, tie.b)] for tie in ties]
        self.a, self.b = (np.array([e[i].index for e in ends], dtype=np.int64) for i in (0, 1))
        self._at_a, self._at_b = (_yielding([e[i] for e in ends], layout) for i in (0, 1))
        inverse = np.zeros(self._n)
        inverse[: layout.n_rigid] = 1.0 / layout.moments.min(axis=1, initial=np.inf)
        self.twist = inverse[self.a]
        self.bent = np.zeros(self._n, dtype=bool)
        for tie, both in zip(ties, ends, strict=True):
            moving = [end for end in both if end.index >= 0]
            off_centre = any(
                end.turns >= 0 and (any(end.offset) or layout.body(end.index).pivot is not None)
                for end in moving
            )
            if tie.stiffness and (off_centre or not tie.linear):
                self.bent[[end.index for end in moving]] = True
        for name in ('stiffness', 'damping', 'quadratic', 'angular', 'angular_quadratic'):
            setattr(self, name, np.array([getattr(tie, name) for tie in ties], dtype=np.float64))

    stiffness: Array
    damping: Array
    quadratic: Array
    angular: Array
    angular_quadratic: Array

    def bound(self, strength: Array, lighter: Array) -> Array:
        """Bound the eigenvalues of what ties of a strength do, for each moving body."""
        sums, two = np.zeros(self._n), self.b >= 0
        np.add.at(sums, self.a, strength * self._at_a)
        np.add.at(sums, self.b[two], (strength * self._at_b)[two])
        sums *= lighter
        of_ties = sums[self.a] + np.where(two, sums[self.b], 0.0)
        of_ties[strength == 0.0] = 0.0
        return self.largest(of_ties)

    def largest(self, of_ties: Array) -> Array:
        """Largest number of the ties of each body."""
        found, two = np.zeros(self._n), self.b >= 0
        np.maximum.at(found, self.a, of_ties)
        np.maximum.at(found, self.b[two], of_ties[two])
        return found


def _moves(body: str, layout: Layout) -> bool:
    return body != WORLD and layout.place(body, None).index >= 0


def _turned(tie: Tie) -> Tie:
    return replace(tie, a=tie.b, b=tie.a)


def _yielding(places: list, layout: Layout) -> Array:
    """Largest eigenvalue of 1/m - [a] I^-1 [a] at places of bodies, (n,) [1/kg]; else zero."""
    found = np.zeros(len(places))
    for i, place in enumerate(places):
        if place.index < 0:
            continue
        found[i] = 1.0 / layout.masses[place.index]
        if place.turns >= 0 and any(place.offset):
            arm = np.cross(place.offset, np.eye(3))  # rows a x e_i
            matrix = (arm / layout.moments[place.turns]) @ arm.T
            is_finite = bool(np.all(np.isfinite(matrix)))
            found[i] += np.linalg.eigvalsh(matrix)[-1] if is_finite else np.inf
    return found
