# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
How much the energy of what touches rises in one tick, over the largest energy that the scene has
had (kinetic with rotation, potential above the ground, and of springs): contact may take energy,
or pass it on, and by this rule gives back no more than 1e-5 of the largest in a tick, 5e-6 for up
to three bodies, less in shorter ticks.

Kinds of scenes, each drawn from a seed (size, place, attitude, speed, material):

    corner   a cube that falls onto its corner
    tumble   a box that falls onto a plane, tumbling
    three    three boxes that fall onto each other
    pile     boxes that fall from a loose grid
    pyramid  a pyramid of boxes that begin to press in the first tick
    unlike   a stack of boxes of 1 to 100 kg, put down exactly, from 1 mm or from 5 cm
    heavy    a stack of two, 1:10, that begins to press in the first tick
    balls    a block of 5 x 5 x 5 balls that falls
    heap     mixed bodies that fall onto each other
    coin     a coin that rolls, leans and falls
    top      a cone that spins on its tip
    cradle   five balls in a row without friction, of which one or two hit the others
    floating boxes that meet without gravity
    edges    a mixed body that falls onto a fixed ball, capsule, ridge, block or drum, tumbling
    sprung   the same on a spring, beside one with drag
    pitching the same where the ball, capsule … pitches as told
    belt     mixed bodies that fall onto a belt
    deck     the same onto a deck that heaves and rolls

The work of belts and of what moves as told does not count.

    python benchmark/energy_of_contact.py [--kinds tumble pile …] [--seeds 3] [--ms 4 2 1]
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim import Simulation, load_scene

Array = NDArray[np.float64]
Bodies = list[dict[str, Any]]
Rng = np.random.Generator

G = 9.81  # [m/s^2]


def body(name: str, shape: dict[str, Any], position: Any, **more: Any) -> dict[str, Any]:
    """Describe a body of a scene; motion: keys of `initial`."""
    motion = more.pop('motion', {})
    position = [float(x) for x in position]
    return {'name': name, 'shape': shape, 'initial': {'position': position, **motion}, **more}


def cuboid(size: Any) -> dict[str, Any]:
    """Describe a box."""
    return {'type': 'box', 'size': [float(x) for x in np.broadcast_to(size, 3)]}


def sphere(radius: float) -> dict[str, Any]:
    """Describe a ball."""
    return {'type': 'sphere', 'radius': radius}


def material(friction: float, restitution: float) -> dict[str, float]:
    """Describe a material; the ground has none of its own: the larger, the geometric mean."""
    return {'friction': friction, 'restitution': restitution}


def attitude(rng: Rng) -> list[float]:
    """Draw an attitude, xyzw."""
    q = rng.normal(size=4)
    return (q / np.linalg.norm(q)).tolist()


def ground(friction: float = 0.5) -> dict[str, Any]:
    """Describe the plane z = 0."""
    return {
        'name': 'ground',
        'shape': {'type': 'plane', 'normal': [0, 0, 1]},
        'friction': friction,
    }


def corner(rng: Rng) -> tuple[Bodies, float]:
    """Let a cube fall exactly onto its corner."""
    tilt = math.atan(math.sqrt(2.0))  # a body diagonal is upright
    half, turn = 0.5 * tilt, math.pi / 8
    # about z by 45 degrees, then about x by the tilt
    q = [
        math.sin(half) * math.cos(turn), -math.sin(half) * math.sin(turn),
        math.cos(half) * math.sin(turn), math.cos(half) * math.cos(turn),
    ]  # fmt: skip
    size = float(rng.choice([0.1, 0.2, 0.4]))
    height = rng.uniform(0.3, 1.5)
    cube = body(
        'cube', cuboid(size), (0, 0, height), mass=1.0, motion={'orientation': q},
        **material(0.4, 0.0),
    )  # fmt: skip
    return [ground(0.4), cube], 2.0


def tumble(rng: Rng) -> tuple[Bodies, float]:
    """Let a box fall, tumbling."""
    friction = float(rng.choice([0.0, 0.0, 0.3, 0.8]))
    size = [(0.2, 0.2, 0.2), (0.2, 0.3, 0.5), (0.5, 0.5, 0.2), (0.2, 0.2, 0.5)][rng.integers(4)]
    motion = {
        'orientation': attitude(rng),
        'velocity': rng.normal(size=3).tolist(),
        'angular_velocity': (8 * rng.normal(size=3)).tolist(),
    }
    thrown = body(
        'box', cuboid(size), (0, 0, 0.6), mass=1.0, motion=motion,
        **material(friction, float(rng.choice([0.0, 0.2, 0.5, 0.9]))),
    )  # fmt: skip
    return [ground(friction), thrown], 2.0


def three(rng: Rng) -> tuple[Bodies, float]:
    """Let three boxes fall onto each other."""
    bodies = [ground(0.5)]
    for i in range(3):
        size = rng.uniform(0.1, 0.4, size=3)
        motion = {'orientation': attitude(rng), 'velocity': rng.normal(size=3).tolist()}
        bodies.append(
            body(f'b{i}', cuboid(size), (0.05 * i, 0.02 * i, 0.4 + 0.5 * i),
                 mass=float(1000 * np.prod(size)), motion=motion, **material(0.5, 0.0))
        )  # fmt: skip
    return bodies, 2.0


def pile(rng: Rng) -> tuple[Bodies, float]:
    """Let boxes fall from a loose grid."""
    bodies = [ground(0.5)]
    for i in range(100):
        place = np.array([i % 5, i // 5 % 5, i // 25], dtype=float) * 0.22 + (-0.44, -0.44, 0.15)
        place[:2] += rng.uniform(-0.01, 0.01, size=2)
        bodies.append(body(f'b{i}', cuboid(0.2), place, mass=1.0, **material(0.5, 0.0)))
    return bodies, 1.5


def pyramid(rng: Rng) -> tuple[Bodies, float]:
    """Build a pyramid of boxes that touch."""
    bodies = [ground(0.5)]
    rows = int(rng.integers(5, 9))
    for row in range(rows):
        for i in range(rows - row):
            place = (0.21 * (i + 0.5 * row), 0.0, 0.1 + 0.2 * row)
            bodies.append(body(f'b{row}_{i}', cuboid(0.2), place, mass=1.0, **material(0.5, 0.0)))
    return bodies, 1.0


def unlike(rng: Rng) -> tuple[Bodies, float]:
    """Put boxes of unlike mass down on each other."""
    bodies, top = [ground(0.5)], 0.0
    for i in range(int(rng.integers(2, 8))):
        size = rng.uniform(0.15, 0.3, size=3)
        middle = top + size[2] / 2 + float(rng.choice([0.0, 1e-3, 0.05]))
        place = (*(0.02 * rng.normal(size=2)), middle)
        mass = float(np.exp(rng.uniform(0, math.log(100))))
        bodies.append(body(f'b{i}', cuboid(size), place, mass=mass, **material(0.5, 0.0)))
        top = middle + size[2] / 2
    return bodies, 1.5


def heavy(rng: Rng) -> tuple[Bodies, float]:
    """Put a heavy cube on a light one."""
    ratio = float(rng.choice([3.0, 10.0, 30.0]))
    return [
        ground(0.5),
        body('light', cuboid(0.2), (0, 0, 0.1), mass=1.0, **material(0.5, 0.0)),
        body('heavy', cuboid(0.2), (0, 0, 0.3), mass=ratio, **material(0.5, 0.0)),
    ], 1.5


def balls(rng: Rng) -> tuple[Bodies, float]:
    """Let a block of balls fall."""
    restitution = float(rng.choice([0.0, 0.5, 1.0]))
    bodies = [ground(0.3)]
    for i in range(125):
        place = np.array([i % 5, i // 5 % 5, i // 25], dtype=float) * 0.21 + (0, 0, 0.3)
        place += rng.uniform(-0.001, 0.001, size=3)
        bodies.append(body(f'b{i}', sphere(0.1), place, mass=10.0, **material(0.3, restitution)))
    return bodies, 1.5


def heap(rng: Rng) -> tuple[Bodies, float]:
    """Let mixed bodies fall onto each other."""
    restitution = float(rng.choice([0.0, 0.5]))
    bodies = [ground(0.5)]
    shapes = [
        cuboid((0.2, 0.25, 0.15)), sphere(0.1), {'type': 'cylinder', 'radius': 0.1, 'length': 0.2},
        {'type': 'capsule', 'radius': 0.07, 'length': 0.2},
    ]  # fmt: skip
    for i in range(24):
        place = np.array([i % 2, i // 2 % 2, i // 4], dtype=float) * 0.35 + (0, 0, 0.4)
        place[:2] += rng.uniform(-0.1, 0.1, size=2)
        motion = {'orientation': attitude(rng), 'angular_velocity': rng.normal(size=3).tolist()}
        bodies.append(
            body(f'b{i}', shapes[i % 4], place, mass=float(rng.uniform(0.5, 2.0)), motion=motion,
                 **material(0.5, restitution))
        )  # fmt: skip
    return bodies, 2.0


def edges(rng: Rng) -> tuple[Bodies, float]:
    """Let a mixed body tumble over what is round or has edges."""
    lying = [0.0, math.sqrt(0.5), 0.0, math.sqrt(0.5)]
    corners = [[x, y, z] for x in (-1.0, 1.0) for y, z in ((-0.5, -0.3), (0.5, -0.3), (0.0, 0.0))]
    ground_shape, q, height = [
        (sphere(0.4), None, 0.4),
        ({'type': 'capsule', 'radius': 0.3, 'length': 0.6}, lying, 0.5),
        ({'type': 'convex_hull', 'vertices': corners}, None, 0.8),
        (cuboid((0.5, 0.5, 0.8)), None, 0.4),
        ({'type': 'cylinder', 'radius': 0.4, 'length': 0.8}, None, 0.4),
    ][rng.integers(5)]
    fixed = body(
        'fixed', ground_shape, (0, 0, height), fixed=True,
        motion={} if q is None else {'orientation': q}, **material(0.5, 0.0),
    )  # fmt: skip
    shares = rng.uniform(0.4, 1.0, 3)
    shape = [
        cuboid(0.2 * shares), sphere(0.1),
        {'type': 'cylinder', 'radius': 0.1 * shares[0], 'length': 0.2 * shares[1]},
        {'type': 'cylinder', 'radius': 0.1, 'length': 0.03 * shares[0]},
        {'type': 'capsule', 'radius': 0.07 * shares[0], 'length': 0.2 * shares[1]},
    ][rng.integers(5)]  # fmt: skip
    motion = {
        'orientation': attitude(rng), 'velocity': [0.0, 0.0, -1.0],
        'angular_velocity': (8 * rng.normal(size=3)).tolist(),
    }  # fmt: skip
    place = (*(0.05 * rng.normal(size=2)), 1.2)
    thrown = body('body', shape, place, mass=1.0, motion=motion, **material(0.5, 0.0))
    return [ground(0.5), fixed, thrown], 1.5


def sprung(rng: Rng) -> tuple[Bodies, float]:
    """Let a mixed body on a spring tumble over what is round or has edges."""
    bodies, seconds = edges(rng)
    return [*bodies, body('flyer', cuboid(0.2), (9, 0, 1), mass=1.0)], seconds


def pitching(rng: Rng) -> tuple[Bodies, float]:
    """Let a mixed body tumble over what pitches."""
    (plane, moved, thrown), seconds = edges(rng)
    del moved['fixed']
    moved['motion'] = {'pitch': {'amplitude': 0.3, 'period': float(rng.uniform(0.6, 1.2))}}
    return [plane, moved, thrown], seconds


def _heap_on(slab: dict[str, Any], rng: Rng) -> tuple[Bodies, float]:
    """Let mixed bodies fall onto a slab a metre above the ground."""
    (plane, *bodies), seconds = heap(rng)
    for fallen in bodies:
        fallen['initial']['position'][2] += 1.0
    slab = body('slab', cuboid((4, 4, 0.2)), (0, 0, 0.9), friction=0.5) | slab
    return [plane, slab, *bodies], seconds


def belt(rng: Rng) -> tuple[Bodies, float]:
    """Let mixed bodies fall onto a belt."""
    speed = float(rng.uniform(0.5, 3.0))
    return _heap_on({'fixed': True, 'surface_velocity': [speed, 0.0, 0.0]}, rng)


def deck(rng: Rng) -> tuple[Bodies, float]:
    """Let mixed bodies fall onto a deck that heaves and rolls."""
    waves = [{'amplitude': 0.1, 'period': float(rng.uniform(0.8, 2.0))} for _ in range(2)]
    return _heap_on({'motion': dict(zip(('heave', 'roll'), waves, strict=True))}, rng)


def coin(rng: Rng) -> tuple[Bodies, float]:
    """Let a coin roll, lean and fall."""
    lean = float(rng.uniform(0.05, 0.6))
    speed = float(rng.uniform(0.2, 1.0))
    radius, thickness = 0.05, 0.005
    half = 0.25 * math.pi + 0.5 * lean
    # axis of the coin along y, leaning about x; it rolls along x
    motion = {
        'orientation': [math.sin(half), 0.0, 0.0, math.cos(half)],
        'velocity': [speed, 0.0, 0.0],
        'angular_velocity': [0.0, speed / radius, 0.0],
    }
    height = radius * math.cos(lean) + 0.5 * thickness * math.sin(lean)
    shape = {'type': 'cylinder', 'radius': radius, 'length': thickness}
    return [
        ground(0.5),
        body('coin', shape, (0, 0, height), mass=0.3, motion=motion, **material(0.5, 0.0)),
    ], 2.0


def top(rng: Rng) -> tuple[Bodies, float]:
    """Let a top spin: a disc upon a ball."""
    lean = float(rng.uniform(0.1, 0.4))
    spin = float(rng.uniform(100, 250))
    axis = np.array([math.sin(lean), 0.0, math.cos(lean)])
    motion = {
        'orientation': [0.0, math.sin(0.5 * lean), 0.0, math.cos(0.5 * lean)],
        'angular_velocity': (spin * axis).tolist(),
    }
    shape = {
        'type': 'union',
        'parts': [
            {'shape': {'type': 'cylinder', 'radius': 0.05, 'length': 0.01}},
            {'shape': {'type': 'sphere', 'radius': 0.005}, 'position': [0.0, 0.0, -0.04]},
        ],
    }
    height = 0.005 + 0.04 * math.cos(lean)
    place = 0.04 * axis * (1, 1, 0)
    place[2] = height
    return [
        ground(0.5),
        body('top', shape, place, density=2530.0, motion=motion, **material(0.5, 0.0)),
    ], 2.0


def cradle(rng: Rng) -> tuple[Bodies, float]:
    """Let balls in a row be hit by one or two."""
    hitting = int(rng.integers(1, 3))
    gap = float(rng.choice([0.0, 1e-3]))
    bodies = [
        body(f'b{i}', sphere(0.1), ((0.2 + gap) * i - (0.3 if i < hitting else 0.0), 0, 0),
             mass=1.0, motion={'velocity': [1.0 if i < hitting else 0.0, 0, 0]},
             **material(0.0, float(rng.choice([1.0, 0.8]))))
        for i in range(5)
    ]  # fmt: skip
    return bodies, 1.0


def floating(rng: Rng) -> tuple[Bodies, float]:
    """Let boxes meet without gravity."""
    bodies = []
    shared = material(float(rng.choice([0.0, 0.5])), float(rng.choice([0.0, 0.5, 0.9])))
    for i in range(6):
        place = np.array([i % 3, i // 3, 0.0]) * 0.6
        motion = {
            'orientation': attitude(rng),
            'velocity': (np.array([0.6, 0.3, 0.0]) - place + 0.1 * rng.normal(size=3)).tolist(),
            'angular_velocity': (3 * rng.normal(size=3)).tolist(),
        }
        bodies.append(body(f'b{i}', cuboid((0.2, 0.3, 0.25)), place, mass=1.0, motion=motion,
                           **shared))  # fmt: skip
    return bodies, 2.0


WITHOUT_GRAVITY = (cradle, floating)
FORCES: dict[Any, list[dict[str, Any]]] = {
    sprung: [
        {'type': 'spring', 'a': 'body', 'b': 'world', 'stiffness': 20.0,
         'a_point': [0.05, 0.0, 0.0], 'b_point': [0.2, 0.1, 0.8]},
        {'type': 'drag', 'body': 'flyer', 'linear': 0.1},
    ]
}  # fmt: skip
KINDS: dict[str, Callable[[Rng], tuple[Bodies, float]]] = {
    kind.__name__: kind
    for kind in (
        corner, tumble, three, pile, pyramid, unlike, heavy, balls, heap, coin, top, cradle,
        floating, edges, sprung, pitching, belt, deck,
    )
}  # fmt: skip


def simulation(kind: str, seed: int, dt: float, **contact: Any) -> tuple[Simulation, float]:
    """Make a scene of a kind, and tell how long it is to run [s]."""
    make = KINDS[kind]
    bodies, seconds = make(np.random.default_rng(seed))
    gravity = [0, 0, 0] if make in WITHOUT_GRAVITY else [0, 0, -G]
    scene = {
        'version': 1,
        'name': kind,
        'dt': dt,
        'gravity': gravity,
        'contact': {'mode': 'timestep', **contact},
        'bodies': bodies,
        'forces': FORCES.get(make, []),
    }
    return Simulation(load_scene(scene)), seconds


def largest_rise(sim: Simulation, seconds: float) -> tuple[float, int]:
    """Largest rise in a tick over the largest energy, and in how many ticks it was over 1e-6."""
    driven = any(b.motion is not None or any(b.surface_velocity) for b in sim.scene.bodies)
    if driven:
        sim.keep_energy_balance()
    energy, works = [sim.energy()], [0.0]  # of weights above z = 0, the ground
    for _ in range(round(seconds / sim.dt)):
        sim.step()
        energy.append(sim.energy())
        works.append(sim.energy_balance().work_of_drives if driven else 0.0)
    rises = (np.diff(energy) - np.diff(works)) / max(energy)
    return float(rises.max()), int((rises > 1e-6).sum())


def main() -> None:
    """Print the largest rise of each scene, and the worst of each kind."""
    parser = argparse.ArgumentParser(description=(__doc__ or '').splitlines()[1])
    parser.add_argument('--kinds', nargs='+', choices=KINDS, default=list(KINDS))
    parser.add_argument('--seeds', type=int, default=3)
    parser.add_argument('--first', type=int, default=0, help='the first seed')
    parser.add_argument('--ms', type=float, nargs='+', default=[4.0, 2.0, 1.0])
    arguments = parser.parse_args()
    for kind in arguments.kinds:
        for ms in arguments.ms:
            start, found = time.process_time(), []
            for seed in range(arguments.first, arguments.first + arguments.seeds):
                sim, seconds = simulation(kind, seed, 1e-3 * ms)
                found.append((*largest_rise(sim, seconds), seed))
            rise, over, seed = max(found)
            print(
                f'{kind:9s} {ms:4.1f} ms: largest rise {rise:8.1e} of the largest energy '
                f'(seed {seed}; over 1e-6 in {over} ticks); {time.process_time() - start:.1f} s',
                flush=True,
            )


if __name__ == '__main__':
    main()
