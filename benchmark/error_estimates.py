# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Whether a run tells how wrong it is: random scenes, methods and steps, against an own integration.

Scenes: one to three bodies, rigid or points; springs on and off centres of mass with and without
rest length and damper, drag, uniform gravity, tables over time with rows off the ticks, held
commands in world and body axes; a third of them free bodies, a third with stiff springs. Steps
over decades: from h omega = 0.003 to 300 (stiff), for adaptive methods tolerances from 1e-3 to
1e-9. The truth: the equations of motion written down here again, DOP853 of scipy from break to
break at rtol 1e-13. Numbers that the truth itself does not resolve are left out.

    python benchmark/error_estimates.py [--triples 500] [--seed 1] [--kinds free soft stiff]
                                        [--methods NAME …] [--most-ticks 1500]

Prints, for each kind, the share of estimates within a factor of three, quantiles of estimate over
truth, and every miss; estimates that say of themselves that they are not reliable stand apart.
With RIGID_BODY_SIM_COMPILE=0 and few ticks no kernel is compiled, and all methods take minutes.
"""

from __future__ import annotations

import argparse
import itertools
import math
import time
from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.physics.errors import InvalidModel, SimulationDiverged
from rigid_body_sim.physics.integration.integrators import INTEGRATORS
from rigid_body_sim.physics.model.rotation import angle_between
from rigid_body_sim.runs.commands import Command
from rigid_body_sim.runs.run import Run, RunSettings

Array = NDArray[np.float64]

FACTOR = 3.0
KINDS = ('free', 'soft', 'stiff')
STIFF = ('implicit_euler', 'implicit_midpoint', 'sdirk2', 'linearly_implicit', 'rk45')
SLOW = tuple(name for name in INTEGRATORS if name.startswith('scipy_'))
RTOL = 1e-13  # of the truth
RESOLVED = 1e-9  # [of the size of the motion] errors below it are not judged
MOST_PERIODS = 1e3  # [rad] of the fastest spring, or the truth takes minutes


def triples(
    kind: str, count: int, rng: np.random.Generator, names: Sequence[str], most_ticks: int
):
    """Draw scenes, and methods and steps for each: scene, commands, method, options, ticks."""
    drawn = 0
    while drawn < count:
        document, rate = scene(kind, rng)
        low, high = {'free': (0.01, 2.0), 'soft': (0.003, 1.2), 'stiff': (1.0, 300.0)}[kind]
        methods = names or (STIFF if kind == 'stiff' else sorted(set(INTEGRATORS) - set(SLOW)))
        for _ in range(min(8, count - drawn)):
            slow = not names and rng.random() < 0.06
            name = str(rng.choice(SLOW if slow else methods))
            dt = max(1e-6, round(10 ** rng.uniform(math.log10(low), math.log10(high)) / rate, 7))
            ticks = int(rng.integers(20, 60 if slow else 1500))
            ticks = max(2, min(ticks, most_ticks, int(MOST_PERIODS / (rate * dt))))
            options = {}
            if 'rtol' in INTEGRATORS[name].options:
                rtol = 10 ** rng.uniform(-9, -3)
                options = {'rtol': rtol, 'atol': 1e-3 * rtol}
            commands = drawn_commands(document, ticks, rng) if rng.random() < 0.5 else {}
            yield document | {'dt': dt}, commands, name, options, ticks
            drawn += 1


def scene(kind: str, rng: np.random.Generator) -> tuple[dict[str, Any], float]:
    """Draw a scene; give it and its fastest rate [rad/s]."""
    count = int(rng.integers(1, 4))
    bodies = [body(f'b{i}', kind, rng) for i in range(count)]
    forces: list[dict[str, Any]] = []
    if kind != 'free':
        forces = drawn_forces(bodies, kind, rng)
    document = {
        'version': 1,
        'name': 'drawn',
        'dt': 1e-3,
        'gravity': [0.0, 0.0, float(rng.choice([0.0, -9.81]))],
        'bodies': bodies,
        'forces': forces,
    }
    simulation = Simulation(load_scene(document), integrator='rk8')
    rates = simulation.stability.rates(simulation.state)
    names = ('rotation', 'oscillation', 'relaxation') if kind != 'stiff' else ('oscillation',)
    return document, max(0.3, *(float(np.max(rates[name], initial=0.0)) for name in names))


def vector(rng: np.random.Generator, size: float) -> list[float]:
    return (size * rng.normal(size=3)).tolist()


def body(name: str, kind: str, rng: np.random.Generator) -> dict[str, Any]:
    mass = float(10 ** rng.uniform(-1, 1))
    made: dict[str, Any] = {
        'name': name,
        'mass': mass,
        'initial': {'position': vector(rng, 1.0), 'velocity': vector(rng, 1.0)},
    }
    if kind != 'free' and rng.random() < 0.25:
        return made | {'shape': {'type': 'particle'}}
    a, b, c = 10 ** rng.uniform(-2 if kind == 'free' else -0.7, 0, size=3)
    moments = 0.2 * mass * rng.permutation([a + b, b + c, c + a])
    made['inertia'] = dict(zip(('ixx', 'iyy', 'izz'), moments.tolist(), strict=True))
    made['initial']['angular_velocity_body'] = vector(rng, 1.0)
    return made


def drawn_forces(bodies: list, kind: str, rng: np.random.Generator) -> list[dict[str, Any]]:
    """Springs along a chain, drag of all, a table over time for the last."""
    forces: list[dict[str, Any]] = []
    stiffness = 10 ** (rng.uniform(4, 8) if kind == 'stiff' else rng.uniform(0, 3))
    # light dampers leave fast oscillations, heavy ones none
    damping = rng.choice([0.0, 0.02, 0.5, 3.0]) if kind == 'stiff' else rng.choice([0.0, 0.1])
    settled = kind == 'stiff' and rng.random() < 0.7
    for i, each in enumerate(bodies):
        spring = {'type': 'spring', 'a': each['name'], 'stiffness': float(stiffness)}
        spring['b'] = bodies[i - 1]['name'] if i else 'world'
        for end, one in (('a_point', each), ('b_point', bodies[i - 1] if i else None)):
            off = one is not None and 'inertia' in one and rng.random() < 0.6
            spring[end] = vector(rng, 0.3) if off else [0.0, 0.0, 0.0]
        if one_is_point(each):
            del spring['a_point']
        if i and one_is_point(bodies[i - 1]):
            del spring['b_point']
        spring['damping'] = float(damping * math.sqrt(stiffness * each['mass']))
        if settled:  # begins without tension and at rest
            where = np.array(bodies[i - 1]['initial']['position'] if i else np.zeros(3))
            where = where + np.array(spring.get('b_point', np.zeros(3)))
            rest = rng.choice([0.0, 1.0])
            gap = rng.normal(size=3)
            gap *= rest / np.linalg.norm(gap)
            arm = np.array(spring.get('a_point', np.zeros(3)))
            each['initial']['position'] = (where + gap - arm).tolist()
            each['initial']['velocity'] = [0.0, 0.0, 0.0]
            if 'inertia' in each:
                each['initial']['angular_velocity_body'] = [0.0, 0.0, 0.0]
            spring['rest_length'] = float(np.linalg.norm(gap))
        else:
            spring['rest_length'] = float(rng.choice([0.0, rng.uniform(0.2, 1.0)]))
        forces.append(spring)
        drag = {'type': 'drag', 'body': each['name'], 'linear': float(rng.choice([0.0, 0.2]))}
        drag['quadratic'] = float(rng.choice([0.0, 0.1]))
        if 'inertia' in each:
            drag['angular'] = 0.01
        forces.append(drag)
    times = np.cumsum(rng.uniform(0.01, 0.5, size=12)).round(6)
    rows = [[float(t), *vector(rng, 1.0)] for t in times]
    forces.append(
        {
            'type': 'time',
            'body': bodies[-1]['name'],
            'table': rows,
            'interpolation': str(rng.choice(['linear', 'cubic'])),
        }
    )
    return forces


def one_is_point(body: Mapping[str, Any]) -> bool:
    return 'inertia' not in body


def drawn_commands(
    document: Mapping[str, Any], ticks: int, rng: np.random.Generator
) -> dict[int, list[Command]]:
    """Held wrenches, in world or body axes."""
    commands: dict[int, list[Command]] = {}
    for tick in sorted({int(t) for t in rng.integers(0, max(1, ticks - 1), size=3)}):
        each = document['bodies'][int(rng.integers(len(document['bodies'])))]
        rigid = not one_is_point(each)
        torque = tuple(vector(rng, 0.1)) if rigid else (0.0, 0.0, 0.0)
        frame = each['name'] if rigid and rng.random() < 0.5 else ''
        command = Command(
            each['name'], 'wrench', force=tuple(vector(rng, 1.0)), torque=torque, frame_id=frame
        )
        commands[tick] = [command]
    return commands


class Truth:
    """The equations of motion of a document, written down for scipy: r, v, q xyzw, omega body."""

    def __init__(self, document: Mapping[str, Any]) -> None:
        self.bodies = document['bodies']
        self.names = [each['name'] for each in self.bodies]
        self.n = len(self.bodies)
        self.mass = np.array([each['mass'] for each in self.bodies])
        self.rigid = np.array([not one_is_point(each) for each in self.bodies])
        moments = [
            list(each.get('inertia', {'x': 1.0, 'y': 1.0, 'z': 1.0}).values())
            for each in self.bodies
        ]
        self.moments = np.array(moments)
        self.gravity = np.array(document['gravity'])
        forces = document['forces']
        springs = [self._spring(f) for f in forces if f['type'] == 'spring']
        drags = [self._drag(f) for f in forces if f['type'] == 'drag']
        self.springs = np.array(springs, dtype=np.float64).reshape(-1, 11)
        self.drags = np.array(drags, dtype=np.float64).reshape(-1, 4)
        self.tables = [self._table(f) for f in forces if f['type'] == 'time']

    def _index(self, name: str) -> int:
        return -1 if name == 'world' else self.names.index(name)

    def _spring(self, f: Mapping[str, Any]) -> tuple[Any, ...]:
        points = [x for key in ('a_point', 'b_point') for x in f.get(key, (0.0, 0.0, 0.0))]
        numbers = f['stiffness'], f['damping'], f['rest_length']
        return self._index(f['a']), self._index(f['b']), *points, *numbers

    def _drag(self, f: Mapping[str, Any]) -> tuple[Any, ...]:
        return self._index(f['body']), f['linear'], f['quadratic'], f.get('angular', 0.0)

    def _table(self, f: Mapping[str, Any]) -> tuple[Any, ...]:
        """Body, times, and the cubics between them: (m, 4, 3), c0 first."""
        rows = np.array(f['table'])
        t, values = rows[:, 0], rows[:, 1:]
        found = np.zeros((len(t) - 1, 4, 3))
        if f['interpolation'] == 'cubic':
            found[:] = CubicSpline(t, values).c[::-1].transpose(1, 0, 2)
        else:
            found[:, 0] = values[:-1]
            found[:, 1] = np.diff(values, axis=0) / np.diff(t)[:, None]
        return self._index(f['body']), t, found

    def start(self) -> Array:
        rows = [
            np.concatenate(
                (
                    each['initial']['position'],
                    each['initial']['velocity'],
                    (0.0, 0.0, 0.0, 1.0),
                    each['initial'].get('angular_velocity_body', (0.0, 0.0, 0.0)),
                )
            )
            for each in self.bodies
        ]
        return np.concatenate(rows)

    def matrices(self, q: Array) -> Array:
        return np.array([matrix(*row) for row in q])

    def _waves(self, begin: float, end: float) -> Array:
        """Cubics (m, 2 + 12) of the tables that act between two breaks: body, t0, c0 to c3."""
        rows = []
        for i, t, coefficients in self.tables:
            k = int(np.searchsorted(t, 0.5 * (begin + end))) - 1
            if 0 <= k < len(t) - 1:
                rows.append([i, t[k], *coefficients[k].ravel()])
        return np.array(rows, dtype=np.float64).reshape(-1, 14)

    def end(self, dt: float, ticks: int, commands: Mapping[int, list[Command]]) -> Array:
        """State (n, 13) at the end, from break to break."""
        duration = dt * ticks
        breaks = {0.0, duration, *(dt * tick for tick in commands)}
        for _, times, _ in self.tables:
            breaks |= {float(t) for t in times if 0.0 < t < duration}
        at = {round(dt * tick, 12): given for tick, given in commands.items()}
        y, instants = self.start(), sorted(breaks)
        held = np.zeros((self.n, 7))  # force, torque, 1 in body axes
        for begin, end in itertools.pairwise(instants):
            for command in at.get(round(begin, 12), ()):
                turns = float(command.frame_id not in ('', 'world'))
                held[self._index(command.body)] = *command.force, *command.torque, turns
            if end - begin < 1e-12:
                continue
            constants = (
                self.mass, self.moments, self.rigid, self.gravity, self.springs, self.drags, held,
                self._waves(begin, end),
            )  # fmt: skip
            solution = solve_ivp(
                slope, (begin, end), y, method='DOP853', rtol=RTOL, atol=1e-15, args=constants
            )
            y = solution.y[:, -1].copy()
        return y.reshape(self.n, 13)


@njit
def cross(a, b):
    return np.array(
        (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
    )


@njit
def matrix(x, y, z, w):
    s = 1.0 / math.sqrt(x * x + y * y + z * z + w * w)
    x, y, z, w = s * x, s * y, s * z, s * w
    return np.array(
        (
            (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
            (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
            (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
        )
    )


@njit
def slope(t, flat, mass, moments, rigid, gravity, springs, drags, held, waves):
    """y' of the whole scene: r, v, q xyzw, omega in body axes of each body."""
    n = len(mass)
    y = flat.reshape(n, 13)
    turn, force, torque, spin = (
        np.empty((n, 3, 3)),
        np.empty((n, 3)),
        np.zeros((n, 3)),
        np.empty((n, 3)),
    )
    for i in range(n):
        turn[i] = matrix(y[i, 6], y[i, 7], y[i, 8], y[i, 9])
        spin[i] = turn[i] @ y[i, 10:].copy()
        force[i] = mass[i] * gravity + held[i, :3]
        torque[i] = held[i, 3:6]
        if held[i, 6] != 0.0:
            force[i] = mass[i] * gravity + turn[i] @ held[i, :3].copy()
            torque[i] = turn[i] @ held[i, 3:6].copy()
    for f in springs:
        a, b, k, c, rest = int(f[0]), int(f[1]), f[8], f[9], f[10]
        arm_a, arm_b = turn[a] @ f[2:5].copy(), f[5:8].copy()
        end_b, rate_b = arm_b, np.zeros(3)
        if b >= 0:
            arm_b = turn[b] @ arm_b
            end_b, rate_b = y[b, :3] + arm_b, y[b, 3:6] + cross(spin[b], arm_b)
        d = end_b - (y[a, :3] + arm_a)
        u = rate_b - (y[a, 3:6] + cross(spin[a], arm_a))
        push = k * d + c * u
        if rest != 0.0:
            length = math.sqrt(np.sum(d * d))
            normal = d / length
            push = (k * (length - rest) + c * np.sum(u * normal)) * normal
        force[a] += push
        torque[a] += cross(arm_a, push)
        if b >= 0:
            force[b] -= push
            torque[b] -= cross(arm_b, push)
    for f in drags:
        i, v = int(f[0]), y[int(f[0]), 3:6]
        force[i] -= (f[1] + f[2] * math.sqrt(np.sum(v * v))) * v
        torque[i] -= f[3] * spin[i]
    for f in waves:
        s, i = t - f[1], int(f[0])
        force[i] += f[2:5] + s * (f[5:8] + s * (f[8:11] + s * f[11:14]))
    out = np.zeros((n, 13))
    for i in range(n):
        out[i, :3] = y[i, 3:6]
        out[i, 3:6] = force[i] / mass[i]
        if rigid[i]:
            w, x, s = y[i, 10:], y[i, 6:9], y[i, 9]
            out[i, 6:9] = 0.5 * (s * w + cross(x, w))
            out[i, 9] = -0.5 * np.sum(x * w)
            turned = turn[i].T.copy() @ torque[i]
            out[i, 10:] = (turned - cross(w, moments[i] * w)) / moments[i]
    return out.ravel()


def errors(state: Any, truth: Array, rigid: Array, matrices: Array) -> dict[str, float]:
    """Error of the body that errs most, by quantity."""
    q = truth[:, 6:10] / np.linalg.norm(truth[:, 6:10], axis=1)[:, None]
    spin = np.einsum('nij,nj->ni', matrices, truth[:, 10:])
    return {
        'position': float(np.max(np.linalg.norm(state.position - truth[:, :3], axis=1))),
        'velocity': float(np.max(np.linalg.norm(state.velocity - truth[:, 3:6], axis=1))),
        'angle': float(np.max(angle_between(state.orientation, q)[rigid], initial=0.0)),
        'angular_velocity': float(
            np.max(np.linalg.norm(state.angular_velocity - spin, axis=1)[rigid], initial=0.0)
        ),
    }


def judge(
    kind: str,
    count: int,
    rng: np.random.Generator,
    *,
    patience: float,
    names: Sequence[str],
    most_ticks: int,
) -> None:
    """Run the triples of one kind and print what came of them."""
    ratios: dict[bool, list[float]] = defaultdict(list)
    skipped: dict[str, int] = defaultdict(int)
    took: dict[str, float] = defaultdict(float)
    misses, began, done = [], time.perf_counter(), 0
    for document, commands, name, options, ticks in triples(kind, count, rng, names, most_ticks):
        if time.perf_counter() - began > patience:
            break
        try:
            simulation = Simulation(
                load_scene(document), integrator=name, integrator_options=options
            )
        except InvalidModel:
            skipped['refused'] += 1
            continue
        now = time.perf_counter()
        run = Run(simulation, RunSettings(estimate_error=True, command_timeout_ns=0))
        try:
            for _ in run.follow(commands, ticks):
                pass
        except SimulationDiverged:
            skipped['diverged'] += 1
            continue
        estimate = run.error_estimate()
        if estimate is None:
            skipped['lost'] += 1
            continue
        took['run'] += time.perf_counter() - now
        now = time.perf_counter()
        truth = Truth(document)
        exact = truth.end(simulation.dt, ticks, commands)
        took['truth'] += time.perf_counter() - now
        found = errors(simulation.state, exact, truth.rigid, truth.matrices(exact[:, 6:10]))
        sizes = {
            'position': 1.0 + np.max(np.abs(exact[:, :3])),
            'velocity': 1.0 + np.max(np.abs(exact[:, 3:6])),
            'angle': 1.0,
            'angular_velocity': 1.0 + np.max(np.abs(exact[:, 10:])),
        }
        done += 1
        text = f'{name} {options.get("rtol", "")} dt {document["dt"]:g} x {ticks}'
        for quantity, error in found.items():
            said = getattr(estimate, quantity)
            if said == 0.0 and error > 0.0:
                misses.append(f'ZERO {quantity} {error:.2e}: {text}')
            if error < RESOLVED * sizes[quantity]:
                skipped['below the truth'] += 1
                continue
            ratio = said / error
            ratios[estimate.reliable].append(ratio)
            if estimate.reliable and not 1.0 / FACTOR <= ratio <= FACTOR:
                misses.append(
                    f'{quantity} said {said:.2e} is {error:.2e} ratio {ratio:.3g}: {text}, '
                    f'rates {rates_of(simulation)}'
                )
    print(
        f'{kind}: {done} triples, {time.perf_counter() - began:.0f} s, left out {dict(skipped)}; '
        + ', '.join(f'{name} {seconds:.0f} s' for name, seconds in took.items())
    )
    for reliable, of in sorted(ratios.items(), reverse=True):
        values = np.array(of)
        good = np.mean((values >= 1 / FACTOR) & (values <= FACTOR))
        quantiles = np.quantile(values, (0.0, 0.005, 0.05, 0.5, 0.95, 0.995, 1.0))
        print(
            f'  {"reliable" if reliable else "doubted "}: {len(of)} numbers, {100 * good:.2f} % '
            f'within {FACTOR:g}; quantiles {np.array2string(quantiles, precision=3)}'
        )
    for line in misses:
        print('   ', line)


def rates_of(simulation: Simulation) -> str:
    h = simulation.dt / simulation.integrator.substeps
    rates = simulation.stability.rates(Simulation(simulation.scene, integrator='rk8').state)
    return ', '.join(
        f'{kind} {h * float(np.max(values, initial=0.0)):.2g}' for kind, values in rates.items()
    )


def main() -> None:
    """Draw and judge."""
    parser = argparse.ArgumentParser(description=(__doc__ or '').split('\n\n')[0])
    parser.add_argument('--triples', type=int, default=500)
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--kinds', nargs='*', choices=KINDS, default=list(KINDS))
    parser.add_argument('--methods', nargs='*', choices=sorted(INTEGRATORS), default=[])
    parser.add_argument('--most-ticks', type=int, default=1500)
    parser.add_argument('--patience', type=float, default=600.0, help='[s] for each kind')
    given = parser.parse_args()
    for kind in given.kinds:
        rng = np.random.default_rng([given.seed, KINDS.index(kind)])
        judge(
            kind,
            given.triples // len(given.kinds),
            rng,
            patience=given.patience,
            names=given.methods,
            most_ticks=given.most_ticks,
        )


if __name__ == '__main__':
    main()
