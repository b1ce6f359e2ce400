# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a small overlap costs: bodies at rest, beside MuJoCo and Rapier at many settings.

    stack  10 cubes of 0.2 m and 1 kg, touching at the start, friction 0.5
    wall   95 such cubes, ten rows of 14 to 5, a centimetre apart, each over two of the row below
    hulls  200 dodecahedra of 1 kg on a ball of 0.2 m, fallen into a pit of four walls

At rest each row of cubes stands 0.2 m above the one below, so the overlap is known from heights
alone: the largest by which a row is nearer to the one below it. Of hulls it is the median over the
points that touch, found in the poses that an engine has left by the detection of this package.
Each setting of each engine gives a point
(overlap, CPU seconds per simulated second); one thread, engines in turns, medians. Printed are all
points, and for each of ours the cheapest setting of a peer that overlaps no more.

MuJoCo: 2 to 50 ms, both cones, its default stiffness and the stiffest that it allows at that step
(time constant of two steps, impedance 0.9999). Rapier: f32, 1/60 to 1/960 s, 4 and 16 iterations,
its default softness, 120 and 480 Hz.

    python benchmark/equal_overlap.py [--scenes stack wall hulls] [--repeat 3]
"""

from __future__ import annotations

import argparse
import importlib.util
import itertools
import math
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


def hulls() -> Array:
    """Centres of loose layers of hulls, (200, 3) [m]."""
    jitter = np.random.default_rng(3).uniform(-0.01, 0.01, (200, 3)) * (1, 1, 0)
    places = [(0.23 * (k % 7) - 0.7, 0.23 * (k // 7 % 7) - 0.7, 0.15 + 0.23 * (k // 49))
              for k in range(200)]  # fmt: skip
    return np.array(places) + jitter


def dodecahedron() -> Array:
    """Corners on a ball of radius HALF, (20, 3) [m]."""
    golden = (1 + math.sqrt(5)) / 2
    corners = list(itertools.product((-1.0, 1.0), repeat=3))
    for a, b in itertools.product((-1.0, 1.0), repeat=2):
        corners += [(0, a / golden, b * golden), (a / golden, b * golden, 0),
                    (a * golden, 0, b / golden)]  # fmt: skip
    return HALF / math.sqrt(3) * np.array(corners)


CORNERS = dodecahedron()
# centre and size of the walls of the pit [m]
WALLS = tuple(
    ((x, y, 1.0), (0.2, 2.4, 2.0) if x else (2.4, 0.2, 2.0))
    for x, y in ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))
)


def our_scene(name: str, dt: float, position: Array, **keys: Any) -> dict[str, Any]:
    """
    Describe a scene for this package; keys: `gravity`, `contact`, `orientation` (n, 4).
    """
    orientation = keys.pop('orientation', np.tile((0.0, 0.0, 0.0, 1.0), (len(position), 1)))
    box = {'type': 'box', 'size': [2 * HALF] * 3}
    shape = {'type': 'convex_hull', 'vertices': CORNERS.tolist()} if name == 'hulls' else box
    rough = {'friction': FRICTION}
    bodies: list[dict] = [{'name': 'floor', 'shape': {'type': 'plane', 'normal': [0, 0, 1]}}]
    if name == 'hulls':
        bodies += [
            {'name': f'wall{i}', 'shape': {'type': 'box', 'size': list(size)}, 'fixed': True,
             'initial': {'position': list(centre)}}
            for i, (centre, size) in enumerate(WALLS)
        ]  # fmt: skip
    bodies += [
        {'name': f'b{i}', 'shape': shape, 'mass': 1.0,
         'initial': {'position': place, 'orientation': q}}
        for i, (place, q) in enumerate(zip(position.tolist(), orientation.tolist(), strict=True))
    ]  # fmt: skip
    bodies = [body | rough for body in bodies]
    usual = {'gravity': [0, 0, GRAVITY], 'contact': {'mode': 'timestep'}}
    return {'version': 1, 'name': name, 'dt': dt, 'bodies': bodies} | usual | keys


def overlap_of_hulls(position: Array, orientation: Array) -> float:
    """Median overlap of the points that touch [m]."""
    known = {'gravity': [0, 0, 0], 'orientation': orientation}
    simulation = Simulation(load_scene(our_scene('hulls', 1e-6, position, **known)))
    simulation.step()
    depth = -simulation.contacts().gap
    return float(np.median(depth[depth > 0.0]))


def overlap_of_rows(heights: Array, centres: Array) -> float:
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
    settings = (
        (0.02, 4),
        (0.016, 4),
        (0.01, 4),
        (0.004, 4),
        (0.002, 4),
        (0.001, 4),
        (0.016, 8),
        (0.016, 16),
    )

    def __init__(self, setting: Any, name: str) -> None:
        self._dt, substeps = setting
        contact = {'mode': 'timestep', 'substeps': substeps}
        scene = our_scene(name, self._dt, SCENES[name](), contact=contact)
        self._first = len(scene['bodies']) - len(SCENES[name]())
        self._simulation = Simulation(load_scene(scene))
        self._simulation.prepare()

    def advance(self, seconds: float) -> None:
        """Step on, all ticks in one call."""
        self._simulation.step(round(seconds / self._dt))

    def poses(self) -> tuple[Array, Array]:
        """Positions (n, 3) [m] and orientations (n, 4)."""
        state = self._simulation.state
        return state.position[self._first :], state.orientation[self._first :]


class MuJoCo:
    """MuJoCo, f64, Newton; setting: (dt [s], cone, stiff)."""

    name = 'MuJoCo'
    settings = tuple(
        itertools.product((0.05, 0.02, 0.01, 0.002), ('pyramidal', 'elliptic'), (False, True))
    )

    def __init__(self, setting: Any, name: str) -> None:
        import mujoco

        self._mujoco = mujoco
        self._dt, cone, stiff = setting
        soft = f'solref="{2 * self._dt} 1" solimp="0.9999 0.9999 0.001"' if stiff else ''
        rough = f'friction="{FRICTION} 0 0" {soft}'
        corners = ' '.join(map(str, CORNERS.ravel()))
        is_hull = name == 'hulls'
        shape = 'type="mesh" mesh="hull"' if is_hull else f'type="box" size="{HALF} {HALF} {HALF}"'
        bodies = ''.join(
            f'<body pos="{x} {y} {z}"><freejoint/><geom {shape} mass="1" {rough}/></body>'
            for x, y, z in SCENES[name]().tolist()
        )
        walls = ''.join(
            f'<geom type="box" pos="{x} {y} {z}" size="{a / 2} {b / 2} {c / 2}" {rough}/>'
            for (x, y, z), (a, b, c) in (WALLS if is_hull else ())
        )
        mesh = f'<asset><mesh name="hull" vertex="{corners}"/></asset>' if is_hull else ''
        self._model = mujoco.MjModel.from_xml_string(
            f'<mujoco><option timestep="{self._dt}" gravity="0 0 {GRAVITY}" cone="{cone}"/>'
            f'<size memory="1G"/>{mesh}<worldbody><geom type="plane" size="50 50 1" {rough}/>'
            f'{walls}{bodies}</worldbody></mujoco>'
        )
        self._data = mujoco.MjData(self._model)

    def advance(self, seconds: float) -> None:
        """Step on, all steps in one call."""
        self._mujoco.mj_step(self._model, self._data, nstep=round(seconds / self._dt))

    def poses(self) -> tuple[Array, Array]:
        """Positions (n, 3) [m] and orientations (n, 4)."""
        rows = self._data.qpos.reshape(-1, 7)
        return rows[:, :3], rows[:, [4, 5, 6, 3]]


class Rapier:
    """Rapier, f32; setting: (steps a second, iterations, contact frequency [Hz] or None)."""

    name = 'Rapier'
    settings = tuple(itertools.product((60, 240, 960), (4, 16), (None, 120.0, 480.0)))

    def __init__(self, setting: Any, name: str) -> None:
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
            for field in ('contact_softness', 'static_contact_softness'):
                softness = getattr(parameters, field)
                softness.natural_frequency = frequency
                setattr(parameters, field, softness)
        floor = rapier.Collider.cuboid(50.0, 50.0, 0.5)
        world.add_collider(floor.translation((0.0, 0.0, -0.5)).friction(FRICTION))
        for centre, size in WALLS if name == 'hulls' else ():
            wall = rapier.Collider.cuboid(*(0.5 * edge for edge in size))
            world.add_collider(wall.translation(centre).friction(FRICTION))
        corners = [tuple(corner) for corner in CORNERS.tolist()]
        self._handles = []
        for centre in SCENES[name]().tolist():
            form = rapier.Collider.cuboid(HALF, HALF, HALF)
            if name == 'hulls':
                form = rapier.Collider.convex_hull(corners)
            body = rapier.RigidBody.dynamic().translation(tuple(centre)).can_sleep(False)
            collider = form.mass(1.0).friction(FRICTION)
            self._handles.append(world.add_body(body, [collider]))

    def advance(self, seconds: float) -> None:
        """Step on in a Python loop."""
        for _ in range(round(seconds * self._rate)):
            self._world.step()

    def poses(self) -> tuple[Array, Array]:
        """Positions (n, 3) [m] and orientations (n, 4)."""
        found = [self._world.rigid_bodies.get(handle) for handle in self._handles]
        places, turns = [body.translation for body in found], [body.rotation for body in found]
        position = np.array([(r.x, r.y, r.z) for r in places])
        orientation = np.array([(q.i, q.j, q.k, q.w) for q in turns])  # of single precision
        return position, orientation / np.linalg.norm(orientation, axis=1, keepdims=True)


SCENES = {'stack': stack, 'wall': wall, 'hulls': hulls}
PEERS = {'mujoco': MuJoCo, 'rapier3d': Rapier}


def measure(scene: str, repeat: int, engines: list[Any]) -> dict[Any, tuple[float, float, float]]:
    """Give of each setting the overlap [m], and median and largest cost [CPU-s/s]."""
    costs: dict[Any, list[float]] = {}
    depths: dict[Any, float] = {}
    for _ in range(repeat):
        for engine in engines:
            for setting in engine.settings:
                found = engine(setting, scene)
                found.advance(BEFORE)
                start = time.process_time()
                found.advance(TIMED)
                cost = (time.process_time() - start) / TIMED
                costs.setdefault((engine, setting), []).append(cost)
                if (engine, setting) not in depths:
                    position, orientation = found.poses()
                    depths[engine, setting] = (
                        overlap_of_hulls(position, orientation)
                        if scene == 'hulls'
                        else overlap_of_rows(position[:, 2], SCENES[scene]())
                    )
    return {
        key: (depths[key], statistics.median(found), max(found)) for key, found in costs.items()
    }


def main() -> None:
    """Print the points of each scene, and the ratios at equal overlap."""
    os.environ.setdefault('RIGID_BODY_SIM_THREADS', '1')
    parser = argparse.ArgumentParser(description=(__doc__ or '').splitlines()[1])
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
