# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Cost at equal error beside MuJoCo's RK4, its only integrator that is accurate: four motions with a
closed form, and one without.

Both run in this one process, on one thread, and take turns; medians of the repetitions are
compared. The clock counts the processor time of the process, so that other processes, which
interrupt long runs rather than short ones, favour nobody; on an idle machine it is the wall time.
A run is the stepping alone, in one call: `mj_step(m, d, nstep=n)` and `Simulation.step(n)`. For
each step of MuJoCo stands the cheapest of ours whose error
is not larger: once among the methods for any forces, once among those that know the closed form of
the problem (a free top, a linear spring).

    a   top thrown near its middle axis, I = (1, 2, 3) kg m^2, w = (0.01, 1, 0.01) rad/s, 100 s
    b   needle, I = (0.001, 1, 1) kg m^2, w = (60, 80, 0) rad/s, 10 s
    c2  mass of 1 kg on a spring, 1 Hz, 100 periods
    g   heavy top in steady precession at 2 rad/s, tilted by 30 degrees, 10 s
    s   body on a spring off its centre with linear and angular drag, 10 s; the reference is DOP853
        of scipy on equations of its own

Error: angle of the final attitude [rad]; for c2 the distance in phase space [m].
    pip install mujoco; python benchmark/against_mujoco.py [--cases a b c2 g s] [--repeat 9]
"""

from __future__ import annotations

import argparse
import dataclasses
import math
import os
import platform
import statistics
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.exact import attitude, free_asymmetric_top, heavy_top
from rigid_body_sim.physics.compile import kernels

RATE = 2.0 * math.pi  # [rad/s] of the oscillator
TILT, PRECESSION, ARM, WEIGHT = math.pi / 6.0, 2.0, 0.5, 9.81  # [rad] [rad/s] [m] [N]
SPIN = heavy_top.spin_for(
    PRECESSION, inertia_across=0.35, inertia_axial=0.15, weight_moment=WEIGHT * ARM, tilt=TILT
)
SHORTEST = 2e-3  # [s] a repetition lasts at least that long, so that the clock is fine enough

OFF = (
    '<flag contact="disable" constraint="disable" limit="disable" frictionloss="disable" '
    'equality="disable" sensor="disable" actuation="disable"/>'
)
FREE_TOP = """
<mujoco><option timestep="{dt}" integrator="RK4" gravity="0 0 0">{off}</option>
  <worldbody><body><freejoint/><inertial pos="0 0 0" mass="1" diaginertia="{inertia}"/></body>
</worldbody></mujoco>"""
OSCILLATOR = """
<mujoco><option timestep="{dt}" integrator="RK4" gravity="0 0 0">{off}</option>
  <worldbody><body><joint type="slide" axis="1 0 0" stiffness="{stiffness}"/>
    <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body></worldbody></mujoco>"""
HEAVY_TOP = """
<mujoco><option timestep="{dt}" integrator="RK4" gravity="0 0 -9.81">{off}</option>
  <worldbody><body><joint type="ball"/>
    <inertial pos="0 0 0.5" mass="1" diaginertia="0.1 0.1 0.15"/></body></worldbody></mujoco>"""

MOMENTS = (0.1, 0.2, 0.25)  # [kg m^2] of the body on a spring, a mass of 1 kg
END_OF_SPRING, STIFFNESS = (0.2, 0.1, 0.3), 40.0  # [m] body axes, [N/m]
DRAG = (0.3, 0.02)  # [N s/m] [N m s]
SPRING_WITH_DRAG = """
<mujoco><option timestep="{dt}" integrator="RK4" gravity="0 0 -9.81">{off}</option>
  <worldbody><site name="o"/><body>
    <joint type="slide" axis="1 0 0" damping="0.3"/>
    <joint type="slide" axis="0 1 0" damping="0.3"/>
    <joint type="slide" axis="0 0 1" damping="0.3"/>
    <joint type="ball" damping="0.02"/>
    <inertial pos="0 0 0" mass="1" diaginertia="0.1 0.2 0.25"/><site name="s" pos="0.2 0.1 0.3"/>
  </body></worldbody>
  <tendon><spatial stiffness="40" springlength="0"><site site="o"/><site site="s"/></spatial>
  </tendon></mujoco>"""


@dataclass(frozen=True)
class Case:
    """
    One motion, for both.

    duration   : [s]
    xml        : MuJoCo's model, with places for dt and `off`
    start      : (qpos, qvel) of MuJoCo
    scene      : mapping for `load_scene`
    reference  : attitude xyzw (4,), or position and velocity over rate (2,), at the end
    peer_steps : dt [s] of MuJoCo's RK4
    ours       : integrator (with an option) and dt [s], methods for any forces
    closed     : the same, methods that know the closed form of this problem
    """

    name: str
    duration: float
    xml: str
    start: tuple[Any, Any]
    scene: dict[str, Any]
    reference: Any
    peer_steps: tuple[float, ...]
    ours: tuple[tuple[str, float], ...]
    closed: tuple[tuple[str, float], ...] = ()


@dataclass
class Runner:
    """A way to run a case: `prepare` is not timed, `run` is."""

    label: str
    steps: int
    duration: float
    prepare: Callable[[], None]
    run: Callable[[], None]
    end: Callable[[], Any]
    group: str
    error: float = math.nan
    costs: list[float] = field(default_factory=list)  # [s per simulated s]

    @property
    def cost(self) -> float:
        """Median cost [s per simulated s]."""
        return statistics.median(self.costs)


def one_body(initial: dict[str, Any], **body: Any) -> dict[str, Any]:
    """Make a scene of one body of 1 kg without gravity."""
    record = {'name': 'body', 'mass': 1.0, 'initial': initial, **body}
    return {'version': 1, 'name': 'case', 'dt': 0.001, 'gravity': [0, 0, 0], 'bodies': [record]}


def free_top(
    name: str, inertia: tuple[float, ...], spin: tuple[float, ...], duration: float, **points: Any
) -> Case:
    """Make a case of a rigid body without forces."""
    moments = dict(zip(('ixx', 'iyy', 'izz'), inertia))
    return Case(
        name=name,
        duration=duration,
        xml=FREE_TOP.replace('{inertia}', ' '.join(map(str, inertia))),
        start=((0, 0, 0, 1, 0, 0, 0), (0, 0, 0, *spin)),
        scene=one_body({'angular_velocity_body': list(spin)}, inertia=moments),
        reference=free_asymmetric_top.rotation(
            duration, inertia=inertia, angular_velocity_body=spin
        ).orientation,
        **points,
    )


def oscillator() -> Case:
    """Make the case of a point mass on a spring."""
    spring = {'type': 'spring', 'a': 'body', 'b': 'world', 'stiffness': RATE**2}
    scene = one_body({'position': [1, 0, 0]}, shape={'type': 'particle'})
    return Case(
        name='c2',
        duration=100.0,
        xml=OSCILLATOR.replace('{stiffness}', repr(RATE**2)),
        start=((1.0,), (0.0,)),
        scene={**scene, 'forces': [spring]},
        reference=np.array([1.0, 0.0]),
        peer_steps=(0.01, 0.005, 0.002, 0.001),
        ours=tuple(('blanes_moan4', dt) for dt in (0.05, 0.02, 0.0125, 0.01, 0.005))
        + tuple(('rk8', dt) for dt in (0.1, 0.05, 0.025)),
        closed=(('linear_propagator', 0.1), ('linear_propagator', 100.0)),
    )


def top_on_pivot() -> Case:
    """Make the case of the heavy top."""
    duration = 10.0
    start = heavy_top.steady(0.0, precession=PRECESSION, spin=SPIN, tilt=TILT)
    x, y, z, w = start.orientation.tolist()
    spin = start.angular_velocity_body.tolist()
    scene = one_body(
        {'orientation': [x, y, z, w], 'angular_velocity_body': spin},
        inertia={'ixx': 0.1, 'iyy': 0.1, 'izz': 0.15},
        pivot={'point': [0, 0, -ARM], 'at': [0, 0, 0]},
    )
    return Case(
        name='g',
        duration=duration,
        xml=HEAVY_TOP,
        start=((w, x, y, z), spin),
        scene={**scene, 'gravity': [0, 0, -WEIGHT]},
        reference=heavy_top.steady(
            duration, precession=PRECESSION, spin=SPIN, tilt=TILT
        ).orientation,
        peer_steps=(0.01, 0.004, 0.002, 0.001),
        ours=tuple(
            ('blanes_moan4:drift=exact', dt) for dt in (0.2, 0.125, 0.1, 0.0625, 0.05, 0.04, 0.025)
        )
        + tuple(('rk8', dt) for dt in (0.05, 0.04, 0.025, 0.02)),
    )


def pulled(_t: float, y: Any) -> Any:
    """Equations of the body on a spring with drag: y = (r, v, q xyzw, w_B)."""
    r, v, axis, w, spin = y[:3], y[3:6], y[6:9], y[9], y[10:]
    moments = np.array(MOMENTS)

    def turned(vector: Any, sign: float) -> Any:
        across = 2.0 * np.cross(sign * axis, vector)
        return vector + w * across + np.cross(sign * axis, across)

    arm = turned(np.array(END_OF_SPRING), 1.0)
    pull = -STIFFNESS * (r + arm)
    torque = turned(np.cross(arm, pull), -1.0) - DRAG[1] * spin
    return np.concatenate(
        [
            v,
            pull - DRAG[0] * v + np.array([0.0, 0.0, -9.81]),
            0.5 * (w * spin + np.cross(axis, spin)),
            [-0.5 * axis @ spin],
            (torque - np.cross(spin, moments * spin)) / moments,
        ]
    )


def spring_with_drag() -> Case:
    """Make the case of the body on a spring off its centre, with drag."""
    place, velocity, spin = [0.3, 0.1, -0.5], [0.5, 0.0, 0.2], [1.0, 2.0, -1.5]
    duration = 10.0
    start = [*place, *velocity, 0.0, 0.0, 0.0, 1.0, *spin]
    end = solve_ivp(pulled, (0.0, duration), start, method='DOP853', rtol=1e-13, atol=1e-15).y
    spring = {'type': 'spring', 'a': 'body', 'b': 'world', 'a_point': list(END_OF_SPRING)}
    drag = {'type': 'drag', 'body': 'body', 'linear': DRAG[0], 'angular': DRAG[1]}
    scene = one_body(
        {'position': place, 'velocity': velocity, 'angular_velocity_body': spin},
        inertia=dict(zip(('ixx', 'iyy', 'izz'), MOMENTS)),
    )
    forces = [spring | {'stiffness': STIFFNESS}, drag]
    return Case(
        name='s',
        duration=duration,
        xml=SPRING_WITH_DRAG,
        start=([*place, 1, 0, 0, 0], [*velocity, *spin]),
        scene={**scene, 'gravity': [0, 0, -9.81], 'forces': forces},
        reference=end[6:10, -1] / np.linalg.norm(end[6:10, -1]),
        peer_steps=(0.01, 0.005, 0.002, 0.001, 0.0005),
        ours=tuple(('rk8', dt) for dt in (0.125, 0.1, 0.08, 0.0625, 0.05, 0.04, 0.03125, 0.025))
        + tuple(('force_gradient4', dt) for dt in (0.05, 0.025, 0.02, 0.0125, 0.01)),
    )


def cases() -> list[Case]:
    """Return the cases."""
    return [
        free_top(
            'a',
            (1.0, 2.0, 3.0),
            (0.01, 1.0, 0.01),
            100.0,
            peer_steps=(0.1, 0.025, 0.01, 0.005),
            ours=(
                ('rk8', 1.0),
                ('rk8', 0.8),
                ('rk8', 0.5),
                ('rk8', 0.25),
                ('taylor16', 1.0),
                ('taylor16', 0.5),
            ),
            closed=(('exact_rotor', 100.0),),
        ),
        free_top(
            'b',
            (0.001, 1.0, 1.0),
            (60.0, 80.0, 0.0),
            10.0,
            peer_steps=(0.001, 0.0005, 0.00025, 0.0001),
            ours=(('rk8', 0.01), ('rk8', 0.005), ('taylor16', 0.02), ('taylor16', 0.01)),
            closed=(('exact_rotor', 10.0),),
        ),
        oscillator(),
        top_on_pivot(),
        spring_with_drag(),
    ]


def peer_runner(mujoco: Any, case: Case, dt: float) -> Runner:
    """MuJoCo's RK4, the whole run in one call."""
    steps = round(case.duration / dt)
    model = mujoco.MjModel.from_xml_string(case.xml.format(dt=dt, off=OFF))
    data = mujoco.MjData(model)

    def prepare() -> None:
        mujoco.mj_resetData(model, data)
        data.qpos[:], data.qvel[:] = case.start

    def end() -> Any:
        if model.nq == 1:
            return np.array([data.qpos[0], data.qvel[0] / RATE])
        w, x, y, z = data.qpos[-4:]
        return np.array([x, y, z, w])

    def run() -> None:
        mujoco.mj_step(model, data, nstep=steps)

    return Runner(f'MuJoCo RK4 {dt:g}', steps, case.duration, prepare, run, end, 'peer')


def our_runner(case: Case, integrator: str, dt: float, group: str) -> Runner:
    """Return the run of `Simulation`, in one call."""
    steps = round(case.duration / dt)
    name, _, option = integrator.partition(':')
    options = dict([option.split('=')]) if option else None
    scene = load_scene(case.scene)
    simulation = Simulation(scene, integrator=name, integrator_options=options, dt=dt)
    simulation.prepare()

    def end() -> Any:
        state = simulation.state
        if len(case.reference) == 2:
            return np.array([state.position[0, 0], state.velocity[0, 0] / RATE])
        return state.orientation[0]

    def run() -> None:
        simulation.step(steps)

    return Runner(f'{integrator} {dt:g}', steps, case.duration, simulation.reset, run, end, group)


def distance(end: Any, reference: Any) -> float:
    """Angle between attitudes [rad], or distance in phase space [m]."""
    if len(reference) == 2:
        return float(np.linalg.norm(end - reference))
    return float(attitude.angle_between(reference, end / np.linalg.norm(end)))


def measure(case: Case, runners: list[Runner], repeat: int) -> None:
    """Find the errors, then the costs: every runner once in each round, in turning order."""
    times = {}
    for runner in runners:
        runner.prepare()
        start = time.process_time()
        runner.run()
        times[runner.label] = time.process_time() - start
        runner.error = distance(runner.end(), case.reference)
    for round_number in range(repeat):
        for runner in runners if round_number % 2 else runners[::-1]:
            runs = max(1, math.ceil(SHORTEST / times[runner.label]))
            spent = 0.0
            for _ in range(runs):
                runner.prepare()
                start = time.process_time()
                runner.run()
                spent += time.process_time() - start
            runner.costs.append(spent / runs / case.duration)
            if sys.stderr.isatty():
                print(f'\r{case.name} {round_number + 1}/{repeat} ', end='', file=sys.stderr)


def cheapest(runners: list[Runner], group: str, error: float) -> Runner | None:
    """Return the cheapest of a group whose error is not larger."""
    good = [runner for runner in runners if runner.group == group and runner.error <= error]
    return min(good, key=lambda runner: runner.cost, default=None)


def line(runner: Runner, ratio: float | None = None) -> str:
    """Label, error, cost per simulated second with its spread, cost per step, ratio."""
    low, middle, high = min(runner.costs), runner.cost, max(runner.costs)
    text = f'{runner.label:32}{runner.error:9.1e}{middle:11.2e}  {low:.1e}…{high:.1e}'
    text += f'{middle * runner.duration / runner.steps * 1e9:10.0f}'
    return text if ratio is None else f'{text}{ratio:10.0f}'


def tell(case: Case, runners: list[Runner]) -> None:
    """Print for each step of MuJoCo the cheapest of ours that is at least as accurate."""
    print(f'\ncase {case.name}, {case.duration:g} s')
    print(f'{"":32}{"error":>9}{"s per s":>11}  {"spread":15}{"ns/step":>10}{"ratio":>10}')
    for peer in (runner for runner in runners if runner.group == 'peer'):
        print(line(peer))
        for group in ('any forces', 'closed form'):
            ours = cheapest(runners, group, peer.error)
            if ours is not None:
                shown = dataclasses.replace(ours, label=f'  {ours.label}')
                mark = '  closed form' if group == 'closed form' else ''
                print(line(shown, peer.cost / ours.cost) + mark)
            elif group == 'any forces':
                print('  none of ours in this list is as accurate')


def main() -> int:
    """Measure and print; without MuJoCo one line, and exit code 0."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--cases', nargs='+', default=['a', 'b', 'c2', 'g', 's'])
    parser.add_argument('--repeat', type=int, default=9)
    arguments = parser.parse_args()
    try:
        import mujoco
    except ImportError as missing:
        print(f'against_mujoco: skipped, MuJoCo is not here ({missing}); pip install mujoco')
        return 0
    print(
        f'MuJoCo {mujoco.__version__}, {platform.machine()}, {kernels.versions()}, '
        f'compiled: {kernels.COMPILED}, median of {arguments.repeat}, '
        f'load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores'
    )
    for case in cases():
        if case.name in arguments.cases:
            runners = [peer_runner(mujoco, case, dt) for dt in case.peer_steps]
            runners += [our_runner(case, *point, 'any forces') for point in case.ours]
            runners += [our_runner(case, *point, 'closed form') for point in case.closed]
            measure(case, runners, arguments.repeat)
            tell(case, runners)
    return 0


if __name__ == '__main__':
    sys.exit(main())
