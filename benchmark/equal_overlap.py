# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a small overlap costs: stack and wall at rest, beside MuJoCo and Rapier at many settings.

    stack  10 cubes of 0.2 m and 1 kg, touching at the start, friction 0.5
    wall   95 such cubes, ten rows of 14 to 5, a centimetre apart, each over two of the row below

At rest each row stands 0.2 m above the one below, so the overlap is known from the heights alone:
the largest by which a row is nearer to the one below it. Each setting of each engine gives a point
(overlap, CPU seconds per simulated second); one thread, engines in turns, medians. Printed are all
points, and for each of ours the cheapest setting of a peer that overlaps no more.

MuJoCo: 2 to 50 ms, both cones, its default stiffness and the stiffest that it allows at that step
(time constant of two steps, impedance 0.9999). Rapier: f32, 1/60 to 1/960 s, 4 and 16 iterations,
its default softness and 120 Hz.

    python benchmark/equal_overlap.py [--scenes stack wall] [--repeat 3]
"""

from __future__ import annotations

import argparse
import importlib.util
import itertools
import os
import statistics
import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim import Simulation, load_scene

Array = NDArray[np.float64]

HALF = 0.1  # [m] half the edge of a cube
GRAVITY = -9.81  # [m/s^2]
FRICTION = 0.5
BEFORE, TIMED = 4.0, 2.0  # [s] before the clock runs, and while it does


def stack() -> Array:
    """Centres of ten cubes, (10, 3) [m]."""
    return np.array([[0.0, 0.0, HALF + 2 * HALF * row] for row in range(10)])


def wall() -> Array:
    """Centres of a wall, row after row, (95, 3) [m]."""
    places = [(row, i) for row in range(10) for i in range(14 - row)]
    return np.array([[2.1 * HALF * (i + 0.5 * row), 0, HALF * (1 + 2 * row)] for row, i in places])


def overlap(heights: Array, centres: Array) -> float:
    """
    Largest overlap of a row with the one below it [m]; NaN where somebody has fallen.

    heights : of the centres [m]
    centres : where they started, row after row (n, 3) [m]
    """
    rows = np.rint((centres[:, 2] / HALF - 1) / 2).astype(int)
    extremes = [(heights[rows == row].min(), heights[rows == row].max()) for row in range(10)]
    highest_below = [-HALF, *(highest for _, highest in extremes[:-1])]
    depths = [
        2 * HALF - (lowest - below)
        for (lowest, _), below in zip(extremes, highest_below, strict=True)
    ]
    return float('nan') if np.abs(depths).max() > HALF else float(max(depths))


class Ours:
    """This package, through the public `Simulation`; setting: (dt [s], substeps)."""

    name = 'rigid_body_sim'
    settings = ((0.02, 4), (0.016, 4), (0.01, 4), (0.004, 4), (0.002, 4), (0.001, 4), (0.016, 16))

    def __init__(self, setting: Any, centres: Array) -> None:
        self._dt, substeps = setting
        bodies: list[dict] = [
            {
                'name': 'floor',
                'shape': {'type': 'plane', 'normal': [0, 0, 1]},
                'friction': FRICTION,
            }
        ]
        bodies += [
            {
                'name': f'b{i}',
                'shape': {'type': 'box', 'size': [2 * HALF] * 3},
                'mass': 1.0,
                'friction': FRICTION,
                'initial': {'position': centre},
            }
            for i, centre in enumerate(centres.tolist())
        ]
        contact = {'mode': 'timestep', 'substeps': substeps}
        gravity = [0, 0, GRAVITY]
        scene = {'version': 1, 'name': 'rest', 'dt': self._dt, 'gravity': gravity}
        self._simulation = Simulation(load_scene(scene | {'contact': contact, 'bodies': bodies}))
        self._simulation.prepare()

    def advance(self, seconds: float) -> None:
        """Step on, all ticks in one call."""
        self._simulation.step(round(seconds / self._dt))

    def heights(self) -> Array:
        """Of the centres [m]."""
        return self._simulation.state.position[1:, 2]


class MuJoCo:
    """MuJoCo, f64, Newton; setting: (dt [s], cone, stiff)."""

    name = 'MuJoCo'
    settings = tuple(
        itertools.product((0.05, 0.02, 0.01, 0.002), ('pyramidal', 'elliptic'), (False, True))
    )

    def __init__(self, setting: Any, centres: Array) -> None:
        import mujoco

        self._mujoco = mujoco
        self._dt, cone, stiff = setting
        soft = f'solref="{2 * self._dt} 1" solimp="0.9999 0.9999 0.001"' if stiff else ''
        form = f'mass="1" friction="{FRICTION} 0 0" {soft}'
        bodies = ''.join(
            f'<body pos="{x} {y} {z}"><freejoint/>'
            f'<geom type="box" size="{HALF} {HALF} {HALF}" {form}/></body>'
            for x, y, z in centres.tolist()
        )
        self._model = mujoco.MjModel.from_xml_string(
            f'<mujoco><option timestep="{self._dt}" gravity="0 0 {GRAVITY}" cone="{cone}"/>'
            f'<size memory="1G"/><worldbody><geom type="plane" size="50 50 1" {soft} '
            f'friction="{FRICTION} 0 0"/>{bodies}</worldbody></mujoco>'
        )
        self._data = mujoco.MjData(self._model)

    def advance(self, seconds: float) -> None:
        """Step on, all steps in one call."""
        self._mujoco.mj_step(self._model, self._data, nstep=round(seconds / self._dt))

    def heights(self) -> Array:
        """Of the centres [m]."""
        return self._data.qpos.reshape(-1, 7)[:, 2]


class Rapier:
    """Rapier, f32; setting: (steps a second, iterations, contact frequency [Hz] or None)."""

    name = 'Rapier'
    settings = tuple(itertools.product((60, 240, 960), (4, 16), (None, 120.0)))

    def __init__(self, setting: Any, centres: Array) -> None:
        import rapier3d as rapier

        rate, iterations, frequency = setting
        self._rate = rate
        self._world = world = rapier.PhysicsWorld(gravity=(0.0, 0.0, GRAVITY))
        world.set_num_threads(1)
        parameters = world.integration_parameters
        parameters.dt = 1 / rate
        parameters.num_solver_iterations = iterations
        parameters.length_unit = 2 * HALF
        if frequency is not None:
            for name in ('contact_softness', 'static_contact_softness'):
                softness = getattr(parameters, name)
                softness.natural_frequency = frequency
                setattr(parameters, name, softness)
        floor = rapier.Collider.cuboid(50.0, 50.0, 0.5)
        world.add_collider(floor.translation((0.0, 0.0, -0.5)).friction(FRICTION))
        self._handles = []
        for centre in centres.tolist():
            form = rapier.Collider.cuboid(HALF, HALF, HALF)
            body = rapier.RigidBody.dynamic().translation(tuple(centre)).can_sleep(False)
            collider = form.mass(1.0).friction(FRICTION)
            self._handles.append(world.add_body(body, [collider]))

    def advance(self, seconds: float) -> None:
        """Step on in a Python loop."""
        for _ in range(round(seconds * self._rate)):
            self._world.step()

    def heights(self) -> Array:
        """Of the centres [m]."""
        bodies = self._world.rigid_bodies
        return np.array([bodies.get(handle).translation.z for handle in self._handles])


SCENES = {'stack': stack, 'wall': wall}
PEERS = {'mujoco': MuJoCo, 'rapier3d': Rapier}


def measure(scene: str, repeat: int, engines: list[Any]) -> dict[Any, tuple[float, float, float]]:
    """Give of each setting the overlap [m], and median and largest cost [CPU-s/s]."""
    centres = SCENES[scene]()
    costs: dict[Any, list[float]] = {}
    depths: dict[Any, float] = {}
    for _ in range(repeat):
        for engine in engines:
            for setting in engine.settings:
                found = engine(setting, centres)
                found.advance(BEFORE)
                start = time.process_time()
                found.advance(TIMED)
                cost = (time.process_time() - start) / TIMED
                costs.setdefault((engine, setting), []).append(cost)
                depths[engine, setting] = overlap(found.heights(), centres)
    return {
        key: (depths[key], statistics.median(found), max(found)) for key, found in costs.items()
    }


def main() -> None:
    """Print the points of each scene, and the ratios at equal overlap."""
    os.environ.setdefault('RIGID_BODY_SIM_THREADS', '1')
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--scenes', nargs='+', choices=SCENES, default=list(SCENES))
    parser.add_argument('--repeat', type=int, default=3)
    arguments = parser.parse_args()
    engines: list[Any] = [Ours]
    for module, engine in PEERS.items():
        if importlib.util.find_spec(module):
            engines.append(engine)
        else:
            print(f'{module}: left out; install the extra `peers` to compare with it')
    for scene in arguments.scenes:
        points = measure(scene, arguments.repeat, engines)
        print(f'\n{scene}')
        for (engine, setting), (depth, cost, worst) in points.items():
            said = ' '.join(str(part) for part in setting)
            print(
                f'  {engine.name:15s} {said:22s} overlap {1e3 * depth:9.5f} mm  '
                f'{1e3 * cost:9.3f} (to {1e3 * worst:.3f}) CPU-ms/s'
            )
        for setting in Ours.settings:
            depth, cost, _ = points[Ours, setting]
            for engine in engines[1:]:
                as_good = {
                    key: found
                    for key, found in points.items()
                    if key[0] is engine and found[0] <= depth
                }
                said = 'no setting overlaps as little'
                if as_good:
                    best = min(as_good, key=lambda key: as_good[key][1])
                    said = f'{as_good[best][1] / cost:.2f} x ours, with {best[1]}'
                print(f'  at {1e3 * depth:.5f} mm, {setting}: {engine.name} {said}')


if __name__ == '__main__':
    main()
