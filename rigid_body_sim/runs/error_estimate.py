# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
How wrong a run is, estimated while it runs by two finer runs beside it.

A finer run y1 and a still finer one y2 begin with the run y0, are given the same commands at the
same ticks, and are never set back: differences are those of the whole trajectories, grown as the
motion makes errors grow. With r = |y2 - y1| / |y1 - y0|, by how much an error shrinks from one run
to the next (2^-p for a method of order p), Aitken's limit of the three gives

    e = |y0 - y2| / (1 - r^2)

so that the order is seen, and not taken from a table: on stiff scenes and at long steps it is not
what the table says.

The finer runs are of the same method in a half and a quarter of its steps. A method that controls
its error has half and quarter ticks, so that it cannot take the same steps, and tolerances TIGHTER
as well. Where the step does not resolve the motion, all steps of an implicit method lose it in the
same way and agree with one another, not with the truth: the finer runs of an implicit method are
of `rk8`, and so are those of any method where a step is long beside the fastest spring, damper,
pendulum and spin, in as many substeps as resolve these (RESOLVED). What is left below the rounding
of the state is given as that rounding, never as nothing.

Limits: an estimate is not `reliable`, and says why (`doubt`), where the finer runs do not settle
(r > SETTLED, SETTLED_RK8: chaotic motion, or a step far too long), or where the motion is faster
than MOST_SUBSTEPS resolve. It costs six times the run, where the step resolves nothing more.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.integration.integrators import INTEGRATORS
from rigid_body_sim.physics.integration.orientation import ORIENTATION
from rigid_body_sim.physics.model.pivot import arm_of, inertia_of
from rigid_body_sim.physics.model.rotation import angle_between
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.physics.state.snapshot import State

Array = NDArray[np.float64]

TIGHTER = (30.0, 1000.0)  # [-] by how much the tolerances of the finer runs are tighter
FINER = (2, 4)  # substeps of the finer runs for one of the run
FINER_RK8 = (2, 3)  # the same of `rk8`, for half of what resolves the motion
RK8_ORDER = 8
UNRESOLVED = 0.5  # [-] h times a rate from which on a step is not trusted to see the motion
RESOLVED = {'rotation': 0.25, 'oscillation': 1.0, 'relaxation': 2.0}  # [-] h times rate for rk8
MOST_SUBSTEPS = 3000  # of rk8 in a step of the run
LEAST_SUBSTEPS = 2  # of rk8 beside an implicit method, which hides what it does not resolve
SETTLED = 0.75  # [-] largest r; the least order, one, has 0.5
SETTLED_RK8 = 0.3  # [-] the same of `rk8` beside another method: it has 0.04 where it resolves
ROUNDING = float(np.finfo(np.float64).eps)


@dataclass(frozen=True)
class ErrorEstimate:
    """
    Estimated error of the body that errs most.

    position [m], angle [rad], velocity [m/s], angular_velocity [rad/s]
    doubt : why the numbers are not reliable; empty where they are
    """

    position: float
    angle: float
    velocity: float
    angular_velocity: float
    doubt: str = ''

    @property
    def reliable(self) -> bool:
        """Whether the truth is expected within a factor of three."""
        return not self.doubt

    def figures(self) -> dict[str, Any]:
        """Give the numbers by name, `reliable`, and the doubt if there is one."""
        return {
            'position': self.position,
            'angle': self.angle,
            'velocity': self.velocity,
            'angular_velocity': self.angular_velocity,
            'reliable': self.reliable,
            **({'doubt': self.doubt} if self.doubt else {}),
        }


class ReferenceRun:
    """
    Two finer runs beside a simulation.

    simulations : give them the same commands and steps
    """

    def __init__(self, of: Simulation) -> None:
        self._of = of
        self._began = of.tick
        self._doubt = ''
        self._swings = swing_rate(of.scene)
        self._turns = any(
            not body.is_point and (body.motion is not None or not body.fixed)
            for body in of.scene.bodies
        )
        self._spread = _spread_of_moments(of)
        self._method = of.integrator
        self._made = name, settings = self._finer()
        self.simulations = tuple(self._beside(name, options, of) for options in settings)

    def step(self, ticks: int) -> None:
        """Advance both; SimulationDiverged where one leaves the finite numbers."""
        if self._of.integrator is not self._method:
            self._follow_the_method()
        for simulation in self.simulations:
            simulation.step(ticks)

    def _finer(self) -> tuple[str, list[dict[str, Any]]]:
        """Choose the method of the finer runs and the options of each."""
        integrator = self._of.integrator
        same = dict(integrator.settings)
        if integrator.controls_its_error:
            return integrator.name, [
                same
                | {
                    'substeps': finer * integrator.substeps,
                    'rtol': max(same['rtol'] / tighter, 1e-13),
                    'atol': max(same['atol'] / tighter, 1e-300),
                }
                for finer, tighter in zip(FINER, TIGHTER, strict=True)
            ]
        parts = self._parts_for_rk8()
        if parts:
            attitude = {key: same[key] for key in ORIENTATION if key in same}  # what is remembered
            name = 'rk8'
            if INTEGRATORS[name].configured(attitude).refuses(self._of.scene) is not None:
                name, attitude = integrator.name, same
            return name, [
                attitude | {'substeps': math.ceil(finer * parts / 2) * integrator.substeps}
                for finer in FINER_RK8
            ]
        return integrator.name, [
            same | {'substeps': finer * integrator.substeps} for finer in FINER
        ]

    def _rates(self) -> dict[str, float]:
        """Largest h times rate of the bodies, by kind, at this instant [-]."""
        of, h = self._of, self._of.dt / self._of.integrator.substeps
        rates = of.stability.rates(of.state)
        found = {kind: h * float(np.max(rates[kind], initial=0.0)) for kind in RESOLVED}
        found['oscillation'] = max(found['oscillation'], h * self._swings)
        return found

    def _parts_for_rk8(self) -> int:
        """
        Count the parts of a step in which rk8 resolves what the step does not; 0 where the step
        does, or the method is exact.
        """
        rates = self._rates()
        integrator, free = self._of.integrator, self._nothing_acts()
        if (integrator.free_order if free else integrator.order) > RK8_ORDER:
            return 0
        if max(rates.values()) <= UNRESOLVED:
            hides = integrator.wants_derivatives and not free
            return LEAST_SUBSTEPS if hides else 0
        parts = max(2, *(math.ceil(rate / RESOLVED[kind]) for kind, rate in rates.items()))
        if parts > MOST_SUBSTEPS:
            kind = max(rates, key=lambda each: rates[each] / RESOLVED[each])
            self._doubt = (
                f'its {kind} is {rates[kind]:.2g} rad a step, more than a finer run can resolve'
            )
            return 0
        return parts

    def _nothing_acts(self) -> bool:
        scene = self._of.scene
        steady = not any(body.pivot for body in scene.bodies) or not any(scene.gravity)
        return steady and not scene.forces and not self._of.held_slots

    def follow_the_state(self) -> None:
        """
        Go on with what resolves the motion, after a body was put elsewhere; the finer runs were
        given the same.
        """
        method = self._finer()
        if method != self._made:
            self._follow_the_method()

    def _follow_the_method(self) -> None:
        """Go on from the finer states with what is finer than the method that `auto` took."""
        self._method = self._of.integrator
        self._made = name, settings = self._finer()
        self.simulations = tuple(
            self._beside(name, options, before)
            for options, before in zip(settings, self.simulations, strict=True)
        )

    def _beside(self, name: str, options: dict[str, Any], of: Simulation) -> Simulation:
        """Make a simulation that goes on from the state of another."""
        simulation = Simulation(of.scene, integrator=name, integrator_options=options, dt=of.dt)
        simulation.prepare(commands_in_body_axes=True)
        state = of.state_bytes()
        simulation.restore(tick=of.tick, state=state, slots=of.held_slots, of_another=True)
        return simulation

    def estimate(self) -> ErrorEstimate:
        """Compare the three at the present tick."""
        states = [self._of.state, *(each.state for each in self.simulations)]
        floors = self._floors(states[0])
        found: dict[str, float] = {}
        settled = True
        most = SETTLED if self._made[0] == self._of.integrator.name else SETTLED_RK8
        for name, floor in floors.items():
            first, second, whole = (_apart(name, *pair) for pair in _pairs(states))
            found[name], good = _limit(first, second, whole, floor, most=most)
            settled = settled and good
        doubt = self._doubt
        if not doubt and not settled:
            doubt = (
                'finer steps do not settle it: what is left is rounding that the motion '
                'magnifies, as chaos does, or the step is too long'
            )
        return ErrorEstimate(**found, doubt=doubt)

    def _floors(self, state: State) -> dict[str, tuple[float, float]]:
        """
        By quantity, the rounding of the state, and what a run may gather of it: errors below that
        need not shrink.
        """
        finest = self.simulations[-1]
        steps = (finest.tick - self._began) * finest.integrator.substeps
        spin = float(np.max(np.abs(state.angular_velocity), initial=0.0))
        turned = 1.0 + spin * (finest.tick - self._began) * self._of.dt
        sizes = {
            'position': float(np.max(np.abs(state.position), initial=0.0)),
            'angle': 1.0 if self._turns else 0.0,
            'velocity': float(np.max(np.abs(state.velocity), initial=0.0)),
            'angular_velocity': spin,
        }
        gathered = 8.0 * ROUNDING * math.sqrt(1.0 + steps) * self._spread * turned
        return {name: (0.5 * ROUNDING * x, gathered * x) for name, x in sizes.items()}


def swing_rate(scene: Scene) -> float:
    """
    Fastest spin of any pendulum of a scene that falls from above under its weight [rad/s].

    2 sqrt(m g l / I),  l = |a|,  I = l^2 / max_u u ([a] I_O^-1 [a]^T) u: the least inertia across
    the arm a
    """
    fastest, g = 0.0, math.hypot(*scene.gravity)
    for body in scene.bodies:
        if body.pivot is not None and body.inertia is not None and g > 0.0:
            x, y, z = arm = arm_of(body)
            cross = np.array(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)))
            yields = cross @ np.linalg.inv(inertia_of(body)) @ cross.T  # [1/kg]
            length = float(np.linalg.norm(arm))
            if length > 0.0:
                largest = float(np.linalg.eigvalsh(0.5 * (yields + yields.T))[-1])
                fastest = max(fastest, 2.0 * math.sqrt(body.mass * g * largest / length))
    return fastest


def _spread_of_moments(simulation: Simulation) -> float:
    """
    Largest ratio of two moments that a body ever has [-]: what the rounding of an attitude is
    worth.
    """
    tensors = []
    for body in simulation.scene.bodies:
        if body.inertia is not None and not body.fixed:
            law = body.inertia_over_time
            rows = () if law is None else law.table
            tensors += [body.inertia, *(np.diag(row[1:]) for row in rows)]
    if not tensors:
        return 1.0
    moments = np.linalg.eigvalsh(np.array(tensors, dtype=np.float64))
    return float(np.max(moments[:, -1] / moments[:, 0]))


def _pairs(states: list[State]) -> tuple[tuple[State, State], ...]:
    """The run and the finer one, the finer and the finest, the run and the finest."""
    run, finer, finest = states
    return (run, finer), (finer, finest), (run, finest)


def _apart(name: str, a: State, b: State) -> Array:
    """Distance of every body in one quantity (n,)."""
    if name == 'angle':
        return angle_between(a.orientation, b.orientation)
    return np.linalg.norm(getattr(a, name) - getattr(b, name), axis=1)


def _limit(
    first: Array, second: Array, whole: Array, floor: tuple[float, float], *, most: float
) -> tuple[float, bool]:
    """
    Error of the body that errs most, and whether the differences shrink: Aitken's limit, not below
    the rounding of the state.

    first, second, whole : |y1 - y0|, |y2 - y1|, |y2 - y0| of each body
    floor                : rounding of the state, and what a run may gather of it
    most                 : largest r of what settles
    """
    rounding, gathered = floor
    largest = float(np.max(whole, initial=0.0))
    before, after = float(np.max(first, initial=0.0)), float(np.max(second, initial=0.0))
    shrinks = after / before if before > 0.0 else (0.0 if after == 0.0 else math.inf)
    settled = shrinks <= most or max(before, after) <= gathered
    settled = settled and largest < math.inf
    factor = 1.0 / (1.0 - min(shrinks, SETTLED) ** 2)
    if not shrinks <= SETTLED:
        largest, factor = max(largest, before, after), 1.0
    return max(factor * largest, rounding), settled
