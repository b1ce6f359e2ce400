# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The energy balance of random scenes against an independent quadrature.

    RIGID_BODY_SIM_COMPILE=0 python benchmark/energy_balance.py --scenes 100 --seed 1

Each scene has two or three bodies, springs with and without dampers, drag, constant wrenches,
forces over time, a flow of mass, commands in world and body axes, impulses. It is run with a
method at dt, dt/2 and dt/4. The other side knows nothing of the package but its states: with
equations of its own it integrates from each state of the run over one tick (DOP853, 1e-12), the
power of all that has no potential with it, and takes

    defect = sum over ticks [E(t_k+1) - E(t_k) - work from the state at t_k over the tick]

Printed are the ratio of the two defects in quantiles, and how the defect goes to zero beside the
order of the method. The two differ by one order more than the defect: one takes the work along the
run, the other along the exact motion from each of its states. Compiled kernels give the same bits;
plain ones need no 10 s of compiling for each kind of scene.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.physics.errors import InvalidModel, SimulationDiverged

Array = np.ndarray
METHODS = ('dmv6', 'rk4', 'semi_implicit_euler', 'rk8', 'midpoint', 'blanes_moan4', 'sdirk2',
           'explicit_euler', 'implicit_midpoint', 'lie_rk4', 'exact_rotor', 'rk45',
           'linearly_implicit', 'implicit_euler')  # fmt: skip
TICKS = 24  # of the coarse run
FLOOR = 1e-12  # [-] of the turnover: smaller defects are rounding on both sides
G = np.array([0.0, 0.0, -9.81])


def random_scene(rng: np.random.Generator, dt: float, end: float) -> dict[str, Any]:
    """Draw a scene; instants are multiples of dt but for the ends of tables."""
    names = ['a', 'b', 'c'][: rng.integers(2, 4)]
    bodies = []
    for i, name in enumerate(names):
        size = rng.uniform(0.1, 0.5, 3)
        body = {
            'name': name,
            'shape': {'type': 'box', 'size': size.tolist()},
            'mass': float(rng.uniform(0.5, 3.0)),
            'initial': {
                'position': [1.2 * i, 0.0, 0.0],
                'velocity': rng.normal(0.0, 1.0, 3).tolist(),
                'angular_velocity': rng.normal(0.0, 2.0, 3).tolist(),
            },
        }
        if rng.random() < 0.2:
            body['mass_rate'] = float(rng.uniform(-0.3, 0.3) * body['mass'] / end)
            body['exhaust_velocity'] = rng.normal(0.0, 3.0, 3).tolist()
        bodies.append(body)
    forces: list[dict[str, Any]] = []
    for _ in range(rng.integers(1, 4)):
        a, b = rng.choice([*names, 'world'], 2, replace=False)
        stiffness = float(10 ** rng.uniform(0.0, 2.0))
        forces.append(
            {
                'type': 'spring', 'a': str(a), 'b': str(b), 'stiffness': stiffness,
                'damping': float(rng.choice([0.0, 0.1 * math.sqrt(stiffness)])),
                'rest_length': float(rng.choice([0.0, 0.7])),
                'a_point': rng.uniform(-0.1, 0.1, 3).tolist(),
                'b_point': rng.uniform(-0.1, 0.1, 3).tolist(),
            }
        )  # fmt: skip
    for name in names:
        if rng.random() < 0.5:
            drag = {k: float(rng.uniform(0.0, 0.3)) for k in ('linear', 'quadratic')}
            turn = {k: float(rng.uniform(0.0, 0.01)) for k in ('angular', 'angular_quadratic')}
            forces.append({'type': 'drag', 'body': name, **drag, **turn})
        if rng.random() < 0.3:
            wrench = {
                k: rng.normal(0.0, s, 3).tolist() for k, s in (('force', 2), ('torque', 0.05))
            }
            frame = str(rng.choice(['world', 'body']))
            forces.append(
                {'type': 'constant', 'body': name, 'frame': frame, **wrench,
                 'point': rng.uniform(-0.1, 0.1, 3).tolist()}
            )  # fmt: skip
        if rng.random() < 0.3:
            ticks = np.sort(rng.choice(np.arange(1, TICKS), 4, replace=False))
            cubic = bool(rng.random() < 0.5)
            t = ticks * dt + (rng.uniform(0.0, 0.9, 4) * dt if cubic else 0.0)
            table = np.column_stack([t, rng.normal(0, 3, (4, 3)), rng.normal(0, 0.05, (4, 3))])
            forces.append(
                {'type': 'time', 'body': name, 'table': table.tolist(),
                 'interpolation': 'cubic' if cubic else 'linear',
                 'frame': str(rng.choice(['world', 'body']))}
            )  # fmt: skip
    return {'version': 1, 'name': 'random', 'dt': dt, 'gravity': G.tolist(), 'bodies': bodies,
            'forces': forces}  # fmt: skip


def random_commands(rng: np.random.Generator, names: list[str], dt: float) -> list[tuple]:
    """Draw (time, kind, body, force, torque, frame)."""
    found = []
    for tick in np.sort(rng.choice(TICKS, rng.integers(0, 6), replace=False)):
        kind = str(rng.choice(['wrench', 'wrench', 'impulse']))
        scale = 3.0 if kind == 'wrench' else 0.3
        found.append(
            (tick, kind, str(rng.choice(names)), rng.normal(0, scale, 3),
             rng.normal(0, 0.02 * scale, 3), str(rng.choice(['world', 'body'])))
        )  # fmt: skip
    return found


def matrix(q: Array) -> Array:
    """Rotation matrix of a quaternion xyzw."""
    x, y, z, w = q / np.linalg.norm(q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


class Model:
    """The equations of a scene, written anew: y = (r, v, q, w_B) of each body, and the work."""

    def __init__(self, scene: dict[str, Any]) -> None:
        self.scene = scene
        self.names = [body['name'] for body in scene['bodies']]
        self.mass0 = np.array([body['mass'] for body in scene['bodies']])
        self.rate = np.array([body.get('mass_rate', 0.0) for body in scene['bodies']])
        self.exhaust = [np.array(b.get('exhaust_velocity', (0, 0, 0))) for b in scene['bodies']]
        sizes = [np.array(body['shape']['size']) for body in scene['bodies']]
        self.per_mass = [(np.sum(s * s) - s * s) / 12.0 for s in sizes]  # moments over mass
        self.held: dict[str, tuple[Array, Array, str]] = {}
        self.tables = {}
        for i, f in enumerate(scene['forces']):
            if f['type'] == 'time':
                rows = np.array(f['table'])
                if f['interpolation'] == 'cubic':
                    self.tables[i] = CubicSpline(rows[:, 0], rows[:, 1:], axis=0)
                else:
                    self.tables[i] = linear(rows)
                self.tables[i].ends = rows[0, 0], rows[-1, 0]

    def instants(self) -> list[float]:
        """Begin and end of the tables, and their rows."""
        return sorted({row[0] for f in self.scene['forces'] if f['type'] == 'time'
                       for row in f['table']})  # fmt: skip

    def point(self, y: Array, name: str, arm: Any) -> tuple[Array, Array, Array]:
        """Position, velocity and arm of a point."""
        if name == 'world':
            return np.array(arm), np.zeros(3), np.zeros(3)
        s = y[13 * self.names.index(name) :]
        turned = matrix(s[6:10])
        a = turned @ np.array(arm)
        return s[:3] + a, s[3:6] + np.cross(turned @ s[10:13], a), a

    def wrenches(self, t: float, middle: float, y: Array) -> tuple[Array, Array, float]:
        """Forces (n, 3) and torques (n, 3) but weight and thrust, and the power of the rest."""
        n = len(self.names)
        force, torque, power = np.zeros((n, 3)), np.zeros((n, 3)), 0.0
        for number, f in enumerate(self.scene['forces']):
            if f['type'] == 'spring':
                xa, va, aa = self.point(y, f['a'], f['a_point'])
                xb, vb, ab = self.point(y, f['b'], f['b_point'])
                d, u = xb - xa, vb - va
                if f['rest_length'] == 0.0:
                    damper = f['damping'] * u
                    pull = f['stiffness'] * d + damper
                else:
                    along = d / np.linalg.norm(d)
                    damper = f['damping'] * (u @ along) * along
                    pull = f['stiffness'] * (np.linalg.norm(d) - f['rest_length']) * along + damper
                power -= damper @ u
                for name, arm, sign in ((f['a'], aa, 1.0), (f['b'], ab, -1.0)):
                    if name != 'world':
                        i = self.names.index(name)
                        force[i] += sign * pull
                        torque[i] += sign * np.cross(arm, pull)
                continue
            i = self.names.index(f['body'])
            v, turned = y[13 * i + 3 : 13 * i + 6], matrix(y[13 * i + 6 : 13 * i + 10])
            w = turned @ y[13 * i + 10 : 13 * i + 13]
            if f['type'] == 'drag':
                F = -(f['linear'] + f['quadratic'] * np.linalg.norm(v)) * v
                T = -(f['angular'] + f['angular_quadratic'] * np.linalg.norm(w)) * w
            elif f['type'] == 'constant':
                F, T = np.array(f['force']), np.array(f['torque'])
                if f['frame'] == 'body':
                    F, T = turned @ F, turned @ T
                T = T + np.cross(turned @ np.array(f['point']), F)
            else:
                table = self.tables[number]
                if not table.ends[0] < middle < table.ends[1]:
                    continue
                F, T = np.split(table(t), 2)
                if f['frame'] == 'body':
                    F, T = turned @ F, turned @ T
            force[i] += F
            torque[i] += T
            power += F @ v + T @ w
        for name, (held_force, held_torque, frame) in self.held.items():
            i = self.names.index(name)
            F, T = held_force, held_torque
            v, turned = y[13 * i + 3 : 13 * i + 6], matrix(y[13 * i + 6 : 13 * i + 10])
            if frame == 'body':
                F, T = turned @ F, turned @ T
            force[i] += F
            torque[i] += T
            power += F @ v + T @ (turned @ y[13 * i + 10 : 13 * i + 13])
        return force, torque, power

    def masses(self, t: float) -> Array:
        """Masses now."""
        return self.mass0 + self.rate * t

    def rates(self, middle: float) -> Callable[[float, Array], Array]:
        """The equations between two instants."""

        def f(t: float, y: Array) -> Array:
            m = self.masses(t)
            force, torque, power = self.wrenches(t, middle, y)
            out = np.zeros_like(y)
            for i in range(len(self.names)):
                s = y[13 * i :]
                v, q, w = s[3:6], s[6:10], s[10:13]
                turned = matrix(q)
                thrust = self.rate[i] * (turned @ self.exhaust[i])
                moments = self.per_mass[i] * m[i]
                o = out[13 * i :]
                o[:3] = v
                o[3:6] = G + (force[i] + thrust) / m[i]
                x, y_, z, c = q
                o[6:10] = 0.5 * np.array(
                    [
                        c * w[0] + y_ * w[2] - z * w[1],
                        c * w[1] + z * w[0] - x * w[2],
                        c * w[2] + x * w[1] - y_ * w[0],
                        -x * w[0] - y_ * w[1] - z * w[2],
                    ]
                )
                o[10:13] = (turned.T @ torque[i] - np.cross(w, moments * w)) / moments
                kinetic = 0.5 * (v @ v) + 0.5 * (w @ (self.per_mass[i] * w)) - G @ s[:3]
                power += thrust @ v + self.rate[i] * kinetic
            out[-1] = power
            return out

        return f

    def energy(self, t: float, y: Array) -> float:
        """Kinetic and potential."""
        total = 0.0
        for i, m in enumerate(self.masses(t)):
            s = y[13 * i :]
            v, w = s[3:6], s[10:13]
            total += m * (0.5 * (v @ v) + 0.5 * (w @ (self.per_mass[i] * w)) - G @ s[:3])
        for f in self.scene['forces']:
            if f['type'] == 'spring':
                d = self.point(y, f['b'], f['b_point'])[0] - self.point(y, f['a'], f['a_point'])[0]
                total += 0.5 * f['stiffness'] * (np.linalg.norm(d) - f['rest_length']) ** 2
        return total


def linear(rows: Array) -> Any:
    """Straight lines from row to row."""

    class Line:
        ends = (0.0, 0.0)

        def __call__(self, t: float) -> Array:
            return np.array([np.interp(t, rows[:, 0], column) for column in rows[:, 1:].T])

    return Line()


def vector_of(sim: Simulation) -> Array:
    """State of the run as the model has it."""
    s = sim.state
    parts = (s.position, s.velocity, s.orientation, s.angular_velocity_body)
    return np.concatenate([np.concatenate(parts, axis=1).ravel(), [0.0]])


def work_of_tick(model: Model, t: float, h: float, y: Array) -> float:
    """Integrate over one tick, between its instants."""
    cuts = [t, *(x for x in model.instants() if t + 1e-12 < x < t + h - 1e-12), t + h]
    y = y.copy()
    y[-1] = 0.0
    for begin, end in pairwise(cuts):
        f = model.rates(0.5 * (begin + end))
        y = solve_ivp(f, (begin, end), y, method='DOP853', rtol=1e-12, atol=1e-13).y[:, -1]
    return float(y[-1])


def compare(scene: dict, method: str, dt: float, refine: int, commands: list) -> tuple:
    """Run and follow; the two defects, the uncertainty and the turnover."""
    sim = Simulation(load_scene({**scene, 'dt': dt / refine}), integrator=method)
    sim.keep_energy_balance()
    model, theirs = Model(scene), 0.0
    due: dict[int, list] = {}
    for command in commands:
        due.setdefault(int(command[0]) * refine, []).append(command)
    for tick in range(TICKS * refine):
        for _, kind, body, force, torque, frame in due.get(tick, ()):
            if kind == 'impulse':
                sim.apply_impulse(body, linear=force, angular=torque, frame=frame)
            else:
                sim.set_wrench(body, force=force, torque=torque, frame=frame)
                model.held[body] = (force, torque, frame)
        t, h, y = tick * dt / refine, dt / refine, vector_of(sim)
        before = model.energy(t, y)
        sim.step()
        sim.look_at_energy()
        theirs += model.energy(t + h, vector_of(sim)) - before - work_of_tick(model, t, h, y)
    balance = sim.energy_balance()
    return balance.defect, theirs, balance.uncertainty, balance.turnover, sim.integrator.order


def main() -> None:
    """Draw, compare, print."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n\n')[0])
    parser.add_argument('--scenes', type=int, default=100)
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--methods', nargs='*', default=METHODS)
    arguments = parser.parse_args()
    ratios, slopes, outside = [], {}, []
    for number in range(arguments.scenes):
        rng = np.random.default_rng([arguments.seed, number])
        dt = round(float(10 ** rng.uniform(-2.7, -1.7)), 6)
        scene = random_scene(rng, dt, TICKS * dt)
        commands = random_commands(rng, [b['name'] for b in scene['bodies']], dt)
        method = arguments.methods[number % len(arguments.methods)]
        try:
            found = [compare(scene, method, dt, refine, commands) for refine in (1, 2, 4)]
        except (InvalidModel, SimulationDiverged) as error:
            print(f'{number:4} {method}: left out: {error}', file=sys.stderr)
            continue
        line = []
        for ours, theirs, uncertainty, turnover, _ in found:
            rounding = FLOOR * turnover
            line.append(f'{ours:10.2e} {theirs:10.2e} ({uncertainty:.0e})')
            if abs(theirs) > rounding:
                ratios.append(ours / theirs)
                if not 0.5 <= ratios[-1] <= 2.0:
                    outside.append((number, method))
        defects, order = [f[0] for f in found], found[0][4]
        if all(abs(f[0]) > 100 * FLOOR * f[3] for f in found):
            slopes.setdefault((method, order), []).append(
                (math.log2(abs(defects[0] / defects[1])), math.log2(abs(defects[1] / defects[2])))
            )
        print(f'{number:4} {method:20} dt {dt:.5f}  ' + ' '.join(line), flush=True)
    quantiles = np.quantile(ratios, (0.0, 0.01, 0.05, 0.5, 0.95, 0.99, 1.0))
    good = [0.5 <= r <= 2.0 for r in ratios]
    print(f'{len(ratios)} defects above rounding: within a factor of two {sum(good)}')
    print('  ratio, quantiles 0 1 5 50 95 99 100 %:', ' '.join(f'{q:.3f}' for q in quantiles))
    print('  outside:', outside or 'none')
    for (method, order), pairs in sorted(slopes.items()):
        fine = np.array([pair[1] for pair in pairs])
        middle = np.median(fine)
        print(f'  {method:20} order {order:g}: observed, median of {len(fine)} {middle:.2f}')


if __name__ == '__main__':
    main()
