# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Stacks and piles beside other engines: the error first, then CPU seconds per simulated second.

    stack          10 cubes of 0.2 m and 1 kg, touching at the start, friction 0.5; 10 s
    boxes          1000 such cubes fall from a loose grid of ten layers; 2 s
    boxes_settled  the same pile, 1 s more after those 2 s
    spheres        1000 spheres of radius 0.1 m and 1 kg from a loose grid of ten layers; 2 s

Every engine uses one thread. Ours: 1/240 s in 4 substeps, and the stack, which hardly moves, also
1/60 s in 16. MuJoCo: 2 ms, pyramidal cone, Newton (CG for the spheres), many steps a call. Rapier:
1/240 s in 4 substeps, f32, a Python loop of `step()`, sleeping off. Engines take turns, so that a
busy moment hits them alike; medians and extremes of the repetitions are printed. A peer that is
not installed is left out and named.

    python benchmark/contact_against_peers.py [--scenes stack boxes …] [--repeat 3]
"""

from __future__ import annotations

import argparse
import importlib.util
import itertools
import os
import statistics
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim import Simulation, load_scene

Array = NDArray[np.float64]

HALF = 0.1  # [m] half the edge of a cube, radius of a sphere
DT = 0.004166667  # [s]
MUJOCO_DT = 0.002  # [s]
GRAVITY = -9.81  # [m/s^2]
FRICTION = 0.5


def stack() -> Array:
    """Centres of ten cubes that touch, (10, 3) [m]."""
    return np.array([[0.0, 0.0, HALF + 2 * HALF * layer] for layer in range(10)])


def loose_grid() -> Array:
    """Centres of a thousand bodies in ten layers, a little apart and disturbed, (1000, 3) [m]."""
    cells = np.array(list(itertools.product(range(10), repeat=3)), dtype=float)
    cells = cells[np.argsort(cells[:, 2], kind='stable')]
    shift = np.random.default_rng(7).uniform(-0.005, 0.005, size=cells.shape)
    return (cells - [4.5, 4.5, 0.0]) * 0.22 + [0.0, 0.0, 0.12] + shift


class Ours:
    """This package, through the public `Simulation`."""

    name = 'rigid_body_sim 1/240 x 4'
    dt, substeps = DT, 4

    def __init__(self, shape: str, centres: Array) -> None:
        form = (
            {'type': 'box', 'size': [2 * HALF] * 3}
            if shape == 'box'
            else {'type': 'sphere', 'radius': HALF}
        )
        bodies = [{'name': 'floor', 'shape': {'type': 'plane', 'normal': [0, 0, 1]}}]
        bodies += [
            {
                'name': f'b{i}',
                'shape': form,
                'mass': 1.0,
                'friction': FRICTION,
                'initial': {'position': centre},
            }
            for i, centre in enumerate(centres.tolist())
        ]
        bodies[0]['friction'] = FRICTION
        scene = {
            'version': 1,
            'name': shape,
            'dt': self.dt,
            'gravity': [0, 0, GRAVITY],
            'contact': {'mode': 'timestep', 'substeps': self.substeps},
            'bodies': bodies,
        }
        self._simulation = Simulation(load_scene(scene))
        self._simulation.prepare()

    def advance(self, seconds: float) -> None:
        """Step on, all ticks in one call."""
        self._simulation.step(round(seconds / self.dt))

    def poses(self) -> tuple[Array, Array, Array]:
        """Positions (n, 3), quaternions (n, 4) xyzw, velocities (n, 3)."""
        state = self._simulation.state
        return state.position[1:], state.orientation[1:], state.velocity[1:]


class OursInLongTicks(Ours):
    """The same substeps in ticks four times as long: for what hardly moves."""

    name = 'rigid_body_sim 1/60 x 16'
    dt, substeps = 4 * DT, 16


class MuJoCo:
    """MuJoCo, f64, its defaults but for the solver of the spheres."""

    name = 'MuJoCo 2 ms'

    def __init__(self, shape: str, centres: Array) -> None:
        import mujoco

        self._mujoco = mujoco
        size = f'{HALF} {HALF} {HALF}' if shape == 'box' else f'{HALF}'
        bodies = ''.join(
            f'<body pos="{x} {y} {z}"><freejoint/>'
            f'<geom type="{shape}" size="{size}" mass="1" friction="{FRICTION} 0 0"/></body>'
            for x, y, z in centres.tolist()
        )
        solver = 'Newton' if shape == 'box' else 'CG'
        self._model = mujoco.MjModel.from_xml_string(
            f'<mujoco><option timestep="{MUJOCO_DT}" gravity="0 0 {GRAVITY}" solver="{solver}"/>'
            '<size memory="1G"/><worldbody><geom type="plane" size="50 50 1" '
            f'friction="{FRICTION} 0 0"/>{bodies}</worldbody></mujoco>'
        )
        self._data = mujoco.MjData(self._model)
        mujoco.mj_forward(self._model, self._data)

    def advance(self, seconds: float) -> None:
        """Step on, all steps in one call."""
        self._mujoco.mj_step(self._model, self._data, nstep=round(seconds / MUJOCO_DT))

    def poses(self) -> tuple[Array, Array, Array]:
        """Positions (n, 3), quaternions (n, 4) xyzw, velocities (n, 3)."""
        q = self._data.qpos.reshape(-1, 7)
        return q[:, :3], q[:, [4, 5, 6, 3]], self._data.qvel.reshape(-1, 6)[:, :3]


class Rapier:
    """Rapier, f32, its default softness with a length unit of one cube."""

    name = 'Rapier f32 1/240 x 4'

    def __init__(self, shape: str, centres: Array) -> None:
        import rapier3d as rapier

        self._world = world = rapier.PhysicsWorld(gravity=(0.0, 0.0, GRAVITY))
        world.set_num_threads(1)
        world.integration_parameters.dt = DT
        world.integration_parameters.num_solver_iterations = 4
        world.integration_parameters.length_unit = 2 * HALF
        floor = rapier.Collider.cuboid(50.0, 50.0, 0.5)
        world.add_collider(floor.translation((0.0, 0.0, -0.5)).friction(FRICTION))
        self._handles = []
        for centre in centres.tolist():
            body = rapier.RigidBody.dynamic()
            form = (
                rapier.Collider.cuboid(HALF, HALF, HALF)
                if shape == 'box'
                else rapier.Collider.ball(HALF)
            )
            self._handles.append(
                world.add_body(
                    body.translation(tuple(centre)).can_sleep(False),
                    [form.mass(1.0).friction(FRICTION)],
                )
            )

    def advance(self, seconds: float) -> None:
        """Step on in a Python loop."""
        for _ in range(round(seconds / DT)):
            self._world.step()

    def poses(self) -> tuple[Array, Array, Array]:
        """Positions (n, 3), quaternions (n, 4) xyzw, velocities (n, 3)."""
        found = [self._world.rigid_bodies.get(handle) for handle in self._handles]
        return (
            np.array([[*body.translation] for body in found]),
            np.array([[b.rotation.i, b.rotation.j, b.rotation.k, b.rotation.w] for b in found]),
            np.array([[*body.linvel] for body in found]),
        )


def of_stack(position: Array, _orientation: Array, velocity: Array) -> str:
    """Say how far the top is from where it started, and what still moves."""
    top = position[-1]
    return (
        f'top {1e3 * (top[2] - 19 * HALF):+.3f} mm, '
        f'drift {1e3 * np.hypot(top[0], top[1]):.3f} mm, '
        f'speed {np.abs(velocity).max():.1e} m/s'
    )


def of_boxes(position: Array, orientation: Array, _velocity: Array) -> str:
    """Say how deep the lowest corner lies below the plane."""
    x, y, z, w = orientation.T
    row = np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], axis=1)
    lowest = position[:, 2] - HALF * np.abs(row).sum(axis=1)
    return f'lowest corner {1e3 * lowest.min():+.4f} mm'


def of_spheres(position: Array, _orientation: Array, _velocity: Array) -> str:
    """Say how far touching spheres overlap."""
    from scipy.spatial import cKDTree

    pairs = cKDTree(position).query_pairs(2 * HALF, output_type='ndarray')
    if not len(pairs):
        return 'no overlap'
    apart = np.linalg.norm(position[pairs[:, 0]] - position[pairs[:, 1]], axis=1)
    depth = 1e3 * (2 * HALF - apart)
    return f'overlap mean {depth.mean():.4f} mm, largest {depth.max():.3f} mm'


Judge = Callable[[Array, Array, Array], str]
SCENES: dict[str, tuple[str, Callable[[], Array], float, float, Judge]] = {
    # shape, centres, [s] before the clock runs, [s] timed, error
    'stack': ('box', stack, 0.0, 10.0, of_stack),
    'boxes': ('box', loose_grid, 0.0, 2.0, of_boxes),
    'boxes_settled': ('box', loose_grid, 2.0, 1.0, of_boxes),
    'spheres': ('sphere', loose_grid, 0.0, 2.0, of_spheres),
}
PEERS = {'mujoco': MuJoCo, 'rapier3d': Rapier}


def cpu_seconds(engine, before: float, timed: float) -> float:
    """CPU time [s] per simulated second."""
    engine.advance(before)
    start = time.process_time()
    engine.advance(timed)
    return (time.process_time() - start) / timed


def main() -> None:
    """Print one table per scene."""
    os.environ.setdefault('RIGID_BODY_SIM_THREADS', '1')
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--scenes', nargs='+', choices=SCENES, default=list(SCENES))
    parser.add_argument('--repeat', type=int, default=3)
    parser.add_argument('--without-peers', action='store_true')
    arguments = parser.parse_args()
    engines = [Ours, OursInLongTicks]
    for module, engine in PEERS.items():
        if not arguments.without_peers and importlib.util.find_spec(module):
            engines.append(engine)
        else:
            print(f'{module}: left out; install the extra `peers` to compare with it')
    for name in arguments.scenes:
        shape, centres, before, timed, judge = SCENES[name]
        times: dict[str, list[float]] = {engine.name: [] for engine in engines}
        errors: dict[str, str] = {}
        for _ in range(arguments.repeat):
            for kind in engines:
                if kind is OursInLongTicks and name != 'stack':
                    continue
                engine = kind(shape, centres())
                times[kind.name].append(cpu_seconds(engine, before, timed))
                errors[kind.name] = judge(*engine.poses())
        ours = statistics.median(times[Ours.name])
        print(f'\n{name}')
        for engine, costs in times.items():
            if not costs:
                continue
            median = statistics.median(costs)
            print(
                f'  {engine:26s} {median:8.4f} CPU-s/s ({min(costs):.4f}..{max(costs):.4f})'
                f'  {median / ours:6.2f} x ours   {errors[engine]}'
            )


if __name__ == '__main__':
    main()
