# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Is the error that `inverse` tells the error that it makes?

    python benchmark/inverse_estimates.py --cases 200 --seed 1
    python benchmark/inverse_estimates.py --cases 40 --seed 11 --sampling two_rates

Draws bodies at random: mass and inertia, smooth forces and torques of several frequencies,
wrenches in world and body axes that begin and end between or at samples, impulses; integrates them
with scipy's DOP853 at 1e-13, samples them at 20 Hz to 1 kHz, adds white noise from none to 1 mm
(and mrad), evenly or not, and compares force and torque found with those applied. Prints quantiles
of estimated by true error (rms over the samples), and every case beyond a factor of three. Below
them the share of all single numbers within two of their standard deviations, and the farthest.
"""

from __future__ import annotations

import argparse
import sys
from collections import defaultdict
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from rigid_body_sim.analysis.inverse_dynamics import derive
from rigid_body_sim.analysis.piecewise_spline import Break
from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.model.scene import Body

Array = NDArray[np.float64]

RATES = (20.0, 50.0, 100.0, 200.0, 1000.0)  # [Hz]
NOISES = (0.0, 1e-9, 1e-6, 1e-5, 1e-4, 1e-3)  # [m], [rad]
GRAVITY = np.array([0.0, 0.0, -9.81])
SAMPLINGS = ('even', 'two_rates', 'random', 'dropped', 'gap')
TICK = 1e-3  # [s]: wrenches begin and end at ticks
FACTOR = 3.0


@dataclass
class Push:
    """A wrench that acts from one instant to another [s], in world or body axes."""

    begin: float
    end: float
    force: Array
    torque: Array
    turns: bool


@dataclass
class Case:
    """A body, what acts on it, and how it is looked at."""

    mass: float
    inertia: Array
    start: Array
    rates: Array
    waves: Array
    pushes: list[Push] = field(default_factory=list)
    strikes: dict[float, tuple[Array, Array]] = field(default_factory=dict)

    def wrench(self, t: float, q: Array, *, among: list[Push]) -> tuple[Array, Array]:
        """Force and torque in world axes."""
        wave = np.sin(self.rates * t)
        force, torque = wave @ self.waves[:, 0], wave @ self.waves[:, 1]
        for push in among:
            f, m = push.force, push.torque
            if push.turns:
                f, m = so3.rotate(q, np.array([f, m]))
            force, torque = force + f, torque + m
        return force, torque


def draw(random: np.random.Generator, duration: float, *, jumps: int, strikes: int) -> Case:
    """Draw a case."""
    mass = float(np.exp(random.uniform(-1, 2)))
    moments = mass * 0.1 * random.uniform(0.6, 1.0, 3)
    turn = so3.matrix_from_quaternion(so3.normalise(random.standard_normal(4)))
    inertia = turn @ np.diag(moments) @ turn.T
    size = np.exp(random.uniform(-1, 1.5))
    case = Case(
        mass,
        inertia,
        np.concatenate(
            (
                random.standard_normal(3),
                so3.normalise(random.standard_normal(4)),
                random.standard_normal(3),
                np.exp(random.uniform(-2, 1)) * random.standard_normal(3),
            )
        ),
        np.exp(random.uniform(-1, 1.5, 3)),
        size * random.standard_normal((3, 2, 3)) * np.array([1.0, 0.03])[:, None],
    )
    for _ in range(jumps):
        begin = round(random.uniform(0.05, 0.95) * duration / TICK) * TICK
        end = begin + random.choice([0.2, 0.2, 0.5, 1.0])
        case.pushes.append(
            Push(
                begin,
                end,
                size * random.standard_normal(3),
                0.03 * size * random.standard_normal(3),
                bool(random.integers(2)),
            )
        )
    for _ in range(strikes):
        at = round(random.uniform(0.1, 0.9) * duration / TICK) * TICK
        case.strikes[at] = (
            0.2 * size * random.standard_normal(3),
            0.01 * size * random.standard_normal(3),
        )
    return case


def motion(case: Case, time: Array) -> tuple[Array, Array, Array]:
    """States (n, 13), forces and torques (n, 3) at samples; what begins at a sample acts there."""
    instants = {0.0, float(time[-1]) + 1e-6}
    for push in case.pushes:
        instants |= {push.begin, push.end}
    edges = sorted(t for t in instants | set(case.strikes) if t <= time[-1] + 1e-6)
    state, states, forces = case.start.copy(), [], []
    for begin, end in pairwise(edges):
        if begin in case.strikes:
            linear, angular = case.strikes[begin]
            state[7:10] += linear / case.mass
            state[10:] += np.linalg.solve(case.inertia, so3.rotate_back(state[3:7], angular))
        among = [p for p in case.pushes if p.begin <= begin + 1e-9 and p.end > begin + 1e-9]

        def rate(t: float, x: Array, among: list[Push] = among) -> Array:
            q, w = x[3:7], x[10:]
            force, torque = case.wrench(t, q / np.linalg.norm(q), among=among)
            spin = so3.multiply(q, np.append(w, 0.0)) * 0.5
            turning = np.linalg.solve(
                case.inertia,
                so3.rotate_back(q / np.linalg.norm(q), torque) - np.cross(w, case.inertia @ w),
            )
            return np.concatenate((x[7:10], spin, force / case.mass + GRAVITY, turning))

        own = time[(time >= begin - 1e-9) & (time < end - 1e-9)]
        wanted = np.append(np.maximum(own, begin), end)
        found = solve_ivp(
            rate, (begin, end), state, 'DOP853', t_eval=wanted, rtol=1e-13, atol=1e-14
        )
        for t, x in zip(own, found.y.T):
            states.append(x)
            forces.append(case.wrench(t, so3.normalise(x[3:7]), among=among))
        state = found.y[:, -1].copy()
        state[3:7] /= np.linalg.norm(state[3:7])
    pairs = np.array(forces)
    return np.array(states), pairs[:, 0], pairs[:, 1]


def instants(random: np.random.Generator, rate: float, duration: float, sampling: str) -> Array:
    """
    Sample times [s] of a mean rate.

    two_rates : a tenth of the rate up to the middle      random : drawn evenly
    dropped   : one of five is missing                    gap    : a tenth of the time is missing
    """
    time = np.arange(1, duration * rate + 1) / rate
    if sampling == 'two_rates':
        time = np.concatenate((time[: len(time) // 2 : 10], time[len(time) // 2 :]))
    elif sampling == 'random':
        time = np.unique(random.uniform(0.0, duration, len(time)))
    elif sampling == 'dropped':
        time = time[random.uniform(size=len(time)) > 0.2]
    elif sampling == 'gap':
        time = time[(time < 0.45 * duration) | (time > 0.55 * duration)]
    return np.unique(np.round(time, 9))


def rms(vectors: Array) -> float:
    """Root of the mean square of lengths."""
    return float(np.sqrt(np.mean(np.sum(np.square(vectors), axis=1))))


def main() -> int:
    """Draw, judge, print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--cases', type=int, default=100)
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--duration', type=float, default=3.0, help='[s]')
    parser.add_argument('--sampling', choices=SAMPLINGS, default='even')
    parser.add_argument('--only', type=int, help='one case, by its number')
    options = parser.parse_args()
    ratios: dict[tuple[str, str], list[float]] = defaultdict(list)
    outside = count = 0
    apart: list[Array] = []
    for number in range(options.cases) if options.only is None else [options.only]:
        random = np.random.default_rng([options.seed, number])
        rate = float(random.choice(RATES))
        noise = float(random.choice(NOISES))
        jumps, strikes = int(random.choice([0, 1, 3, 5])), int(random.choice([0, 0, 0, 2]))
        case = draw(random, options.duration, jumps=jumps, strikes=strikes)
        time = instants(random, rate, options.duration, options.sampling)
        states, force, torque = motion(case, time)
        position = states[:, :3] + noise * random.standard_normal((len(time), 3))
        shake = so3.from_rotation_vector(noise * random.standard_normal((len(time), 3)))
        orientation = so3.multiply(shake, states[:, 3:7])
        breaks = [Break(t, 1) for p in case.pushes for t in (p.begin, p.end)]
        breaks += [Break(t, 0) for t in case.strikes]
        found, told = derive(
            time,
            position,
            orientation,
            body=Body('body', None, case.mass, inertia=case.inertia),
            gravity=tuple(GRAVITY.tolist()),
            breaks=breaks,
        )
        for name, true in (('force', force), ('torque', torque)):
            error = rms(getattr(found, name) - true)
            if name not in told:
                print(f'case {number}: {name}: no estimate')
                continue
            ratio = told[name].rms / error
            apart.append((np.abs(getattr(found, name) - true) / found.deviation[name]).ravel())
            kind = f'{rate:g} Hz' if noise == 0.0 else f'noise {noise:g}'
            ratios[name, kind].append(ratio)
            count += 1
            wrong = not 1.0 / FACTOR < ratio < FACTOR
            outside += wrong
            if wrong or options.only is not None:
                smoothing = found.smoothing['position' if name == 'force' else 'orientation']
                print(
                    f'case {number}: {rate:g} Hz, noise {noise:g}, {jumps} wrenches, {strikes} '
                    f'impulses: {name} error {error:.2e}, estimated {told[name].rms:.2e} '
                    f'(of {rms(true):.2g}); noise found {smoothing.noise:.1e}, '
                    f'{smoothing.bandwidth:.3g} Hz, {len(smoothing.dropped)} dropped'
                )
    print(f'{"":28} cases     5 %    50 %    95 %  (estimated / true error)')
    for (name, kind), values in sorted(ratios.items()):
        low, middle, high = np.quantile(values, [0.05, 0.5, 0.95])
        print(f'{name:8} {kind:19} {len(values):5} {low:7.2f} {middle:7.2f} {high:7.2f}')
    print(f'{count - outside} of {count} within a factor of {FACTOR:g}')
    numbers = np.concatenate(apart)
    print(
        f'{100.0 * np.mean(numbers < 2.0):.1f} % of {len(numbers)} numbers within two standard '
        f'deviations, {100.0 * np.mean(numbers < 5.0):.2f} % within five, the farthest at '
        f'{np.max(numbers):.3g}'
    )
    return 0


if __name__ == '__main__':
    sys.exit(main())
