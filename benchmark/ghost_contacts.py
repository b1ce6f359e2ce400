# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Ghost contacts: bodies that slide or roll over random flush floors, and bodies that pass by.

    python benchmark/ghost_contacts.py --cases 40 --seed 1
    python benchmark/ghost_contacts.py --only misses --cases 200

Floors: boxes in a row or a grid, hulls of boxes, triangular prisms, parts of one union, a plane
flush with boxes; tiles of random size, the floor and the mover at random yaw, the heading random,
0.1 to 10 m/s; movers without friction slide, those with friction 0.3 roll. The law: the velocity
stays what it is, to 1e-3 of the speed, and the body rises by no more than 1e-5 m.

Misses: two random bodies, one of them standing or moving, one of them spinning or not, pass each
other with a clearance of 1e-4 to 1e-2 m at 0.3 to 30 m/s. The law: to the last bit the velocity of
the same body alone. Printed are the worst figures of each kind; --each prints every case.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections import defaultdict
from typing import Any

import numpy as np

from rigid_body_sim import Simulation, load_scene

Array = np.ndarray
MOVERS = ('box', 'hull', 'ball', 'capsule', 'cylinder', 'disc', 'puck')
FLOORS = ('row', 'grid', 'hulls', 'prisms', 'union', 'plane')
ROLLS = ('ball', 'capsule', 'cylinder', 'disc')
APART = 14.0  # [m] between the tracks of one scene
PATH = 1.6  # [m]
LONGEST = 1.5  # [s]
ROUNDING = 1e-11  # [m/s, rad/s]
SPEED_LAW, HOP_LAW = 1e-3, 1e-5  # [-], [m]


def turn(axis: Any, angle: float) -> list[float]:
    """Quaternion (x, y, z, w) of a turn about a unit axis."""
    return [*(math.sin(0.5 * angle) * np.asarray(axis)).tolist(), math.cos(0.5 * angle)]


def product(p: list[float], q: list[float]) -> list[float]:
    """Quaternion of the turn q followed by p."""
    a, b = np.array(p[:3]), np.array(q[:3])
    vector = p[3] * b + q[3] * a + np.cross(a, b)
    return [*vector.tolist(), p[3] * q[3] - float(a @ b)]


def rotate(q: list[float], v: Any) -> Array:
    """Turn a vector by a quaternion."""
    u, v = np.array(q[:3]), np.asarray(v, dtype=float)
    return v + 2.0 * np.cross(u, np.cross(u, v) + q[3] * v)


def corners(size: Any) -> list[list[float]]:
    """Corners of a box."""
    half = 0.5 * np.asarray(size)
    return [
        [x * half[0], y * half[1], z * half[2]] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)
    ]


def mover(kind: str, rng: np.random.Generator, rolls: bool) -> tuple[dict[str, Any], float, Any]:
    """Give a shape that stands on its floor, its height [m] and its orientation at heading 0."""
    yaw = turn([0, 0, 1], float(rng.uniform(-3, 3)))
    r, length = float(rng.uniform(0.05, 0.15)), float(rng.uniform(0.1, 0.4))
    lying = turn([1, 0, 0], 0.5 * math.pi)  # the axis across the heading
    if not rolls:
        lying = product(yaw, lying)
    match kind:
        case 'box' | 'hull':
            size = rng.uniform(0.1, 0.4, 3).tolist()
            shape = {'type': 'box', 'size': size}
            if kind == 'hull':
                shape = {'type': 'convex_hull', 'vertices': corners(size)}
            return shape, 0.5 * size[2], yaw
        case 'ball':
            return {'type': 'sphere', 'radius': r}, r, yaw
        case 'capsule':
            return {'type': 'capsule', 'radius': r, 'length': length}, r, lying
        case 'cylinder':
            return {'type': 'cylinder', 'radius': r, 'length': length}, r, lying
        case 'disc':
            return {'type': 'cylinder', 'radius': r, 'length': 0.3 * r}, r, lying
        case _:
            return {'type': 'cylinder', 'radius': r, 'length': 0.6 * r}, 0.3 * r, yaw


def tiles(kind: str, rng: np.random.Generator, reach: float, length: float) -> list[Any]:
    """Give the tiles of a floor along x: (middle, shape); the top is at z = 0."""
    size = rng.uniform(0.1, 0.5, 2)
    if kind == 'row':
        size[1] = 6.0
    deep = 0.1
    lead = rng.uniform(0.0, 1.0, 2) * (size if kind != 'row' else [size[0], 1.0])
    angle = 0.0 if kind == 'row' else float(rng.uniform(-0.8, 0.8))
    c, s = math.cos(angle), math.sin(angle)
    found = []
    count = np.ceil((length + 2.0 * reach) / np.min(size)) + 3
    for i in np.arange(-count, count + 1):
        for j in [0.0] if kind == 'row' else np.arange(-count, count + 1):
            x, y = np.array([i, j]) * size + lead
            middle = np.array([c * x - s * y, s * x + c * y, -0.5 * deep])
            near = reach + 0.5 * math.hypot(*size)
            wide = 9.0 if kind == 'row' else near
            if not (-near < middle[0] < length + near and abs(middle[1]) < wide):
                continue
            box = [*size.tolist(), deep]
            if kind == 'prisms':
                a, b, h = 0.5 * size[0], 0.5 * size[1], 0.5 * deep
                for flat in ([[-a, -b], [a, -b], [a, b]], [[-a, -b], [a, b], [-a, b]]):
                    center = np.mean(flat, axis=0)  # a body is where its centre of mass is
                    turned = rotate(turn([0, 0, 1], angle), [*center, 0.0])
                    vertices = [[*(p - center), z] for p in np.array(flat) for z in (-h, h)]
                    found.append((middle + turned, {'type': 'convex_hull', 'vertices': vertices}))
            elif kind == 'hulls':
                found.append((middle, {'type': 'convex_hull', 'vertices': corners(box)}))
            else:
                found.append((middle, {'type': 'box', 'size': box}))
    return [(middle, shape, turn([0, 0, 1], angle)) for middle, shape in found]


def track(
    number: int, kind: str, floor: str, rolls: bool, speed: float, rng: np.random.Generator
) -> tuple[list[dict[str, Any]], Array]:
    """Give the bodies of one track, the mover last, and its velocity."""
    heading = turn([0, 0, 1], float(rng.uniform(-3, 3)))
    origin = np.array([0.0, APART * number, 0.0])
    shape, height, orientation = mover(kind, rng, rolls)
    reach = 0.45
    length = min(PATH, speed * LONGEST)
    friction = 0.3 if rolls else 0.0
    bodies, parts, middles = [], [], []
    for index, (middle, tile, yaw) in enumerate(tiles(floor, rng, reach, length)):
        placed = rotate(heading, middle)
        if floor == 'union':
            parts.append({'shape': tile, 'position': placed.tolist(),
                          'orientation': product(heading, yaw), 'mass': 1.0})  # fmt: skip
            middles.append(placed)
            continue
        bodies.append({
            'name': f'tile_{number}_{index}', 'fixed': True, 'friction': friction, 'shape': tile,
            'initial': {'position': (origin + placed).tolist(),
                        'orientation': product(heading, yaw)},
        })  # fmt: skip
    if parts:
        bodies.append({
            'name': f'floor_{number}', 'fixed': True, 'friction': friction,
            'shape': {'type': 'union', 'parts': parts},
            'initial': {'position': (origin + np.mean(middles, axis=0)).tolist()},
        })  # fmt: skip
    velocity = rotate(heading, [speed, 0.0, 0.0])
    initial = {
        'position': (origin + [0.0, 0.0, height]).tolist(),
        'orientation': product(heading, orientation),
        'velocity': velocity.tolist(),
    }
    if rolls:
        initial['angular_velocity'] = rotate(heading, [0.0, speed / height, 0.0]).tolist()
    bodies.append({'name': f'mover_{number}', 'mass': float(rng.uniform(0.3, 5.0)),
                   'friction': friction, 'shape': shape, 'initial': initial})  # fmt: skip
    return bodies, velocity


def run_floors(floor: str, kinds: Any, cases: int, options: Any) -> list[Any]:
    """Run tracks of one kind of floor in one scene; (label, speed error, hop) of each."""
    rng = np.random.default_rng([options.seed, FLOORS.index(floor)])
    bodies, law, labels, heights = [], [], [], []
    for number in range(cases):
        kind = kinds[number % len(kinds)]
        rolls = kind in ROLLS and bool(rng.random() < 0.5)
        speed = float(10.0 ** rng.uniform(*np.log10(options.speed)))
        of_track, velocity = track(number, kind, floor, rolls, speed, rng)
        bodies += of_track
        law.append(velocity)
        heights.append(of_track[-1]['initial']['position'][2])
        labels.append((kind, 'rolls' if rolls else 'slides', speed, number))
    if floor == 'plane':
        bodies.insert(0, {'name': 'ground', 'friction': 0.3,
                          'shape': {'type': 'plane', 'normal': [0, 0, 1]}})  # fmt: skip
    scene = {'name': f'ghosts_{floor}', 'dt': options.dt, 'gravity': [0, 0, -9.81],
             'contact': {'mode': 'timestep', 'substeps': options.substeps},
             'bodies': bodies}  # fmt: skip
    simulation = Simulation(load_scene(scene))
    movers = [i for i, body in enumerate(bodies) if body['name'].startswith('mover')]
    speeds = np.array([label[2] for label in labels])
    until = np.minimum(LONGEST, PATH / speeds)
    error, hop = np.zeros(cases), np.full(cases, -np.inf)
    while simulation.time < until.max():
        simulation.step(1)
        state = simulation.state
        running = simulation.time < until
        away = np.linalg.norm((state.velocity[movers] - np.array(law))[:, :2], axis=1) / speeds
        error = np.where(running, np.maximum(error, away), error)
        rise = state.position[movers, 2] - np.array(heights)
        hop = np.where(running, np.maximum(hop, rise), hop)
    return [(*label, e, h) for label, e, h in zip(labels, error, hop, strict=True)]


def reach_along(shape: dict[str, Any], q: list[float], e: Array) -> float:
    """Support function of a shape about its middle [m]."""
    local = rotate([-q[0], -q[1], -q[2], q[3]], e)
    match shape['type']:
        case 'sphere':
            return shape['radius']
        case 'capsule':
            return shape['radius'] + 0.5 * shape['length'] * abs(local[2])
        case 'cylinder':
            return 0.5 * shape['length'] * abs(local[2]) + shape['radius'] * math.hypot(*local[:2])
        case 'box':
            return float(0.5 * np.abs(local) @ np.array(shape['size']))
        case _:
            return float(np.max(np.array(shape['vertices']) @ local))


def passing(number: int, rng: np.random.Generator, options: Any) -> tuple[list[Any], Any]:
    """Give two bodies that pass each other, and a label of the case."""
    q = rng.normal(size=4)
    e, u = np.linalg.qr(rng.normal(size=(3, 2)))[0].T
    kinds = rng.choice(MOVERS, 2)
    shapes = [mover(str(kind), rng, False)[0] for kind in kinds]
    turns = [(q / np.linalg.norm(q)).tolist(), rng.normal(size=4)]
    turns[1] = (turns[1] / np.linalg.norm(turns[1])).tolist()
    speed = float(10.0 ** rng.uniform(math.log10(0.3), math.log10(30.0)))
    clearance = float(10.0 ** rng.uniform(-4.0, -2.0))
    clearance *= 1.0 + 1e-9
    spin = 0.0
    if (
        options.spin
        and rng.random() < 0.5
        and shapes[1]['type'] in ('sphere', 'cylinder', 'capsule')
    ):
        spin = float(10.0 ** rng.uniform(0.0, 2.5))
        axis = rotate(turns[1], [1.0, 0.0, 0.0])  # lies across: the shape turns about e
        bend = np.cross(axis, e)
        angle = math.atan2(float(np.linalg.norm(bend)), float(axis @ e))
        turns[1] = product(turn(bend / np.linalg.norm(bend), angle), turns[1])
    apart = reach_along(shapes[0], turns[0], e) + reach_along(shapes[1], turns[1], -e) + clearance
    aside = np.cross(e, u) * float(rng.uniform(-0.1, 0.1))
    way = 0.6 + 4.0 * options.dt * speed * float(rng.random())
    origin = np.array([0.0, 30.0 * number, 0.0])
    moves = bool(rng.random() < 0.5) or options.gravity  # what falls past what stands may hit
    drift = rng.normal(size=3) if moves else np.zeros(3)
    first = {'name': f'first_{number}', 'shape': shapes[0],
             'initial': {'position': origin.tolist(), 'orientation': turns[0]}}  # fmt: skip
    first |= {'mass': 2.0} if moves else {'fixed': True}
    if moves:
        first['initial']['velocity'] = drift.tolist()
    second = {
        'name': f'second_{number}', 'shape': shapes[1], 'mass': 1.0,
        'initial': {'position': (origin + apart * e + aside - way * u).tolist(),
                    'orientation': turns[1], 'velocity': (drift + speed * u).tolist(),
                    'angular_velocity': (spin * e).tolist()},
    }  # fmt: skip
    label = (*(str(kind) for kind in kinds), moves, spin, speed, clearance)
    return [first, second], (label, 2.0 * way / speed)


def passing_above(number: int, rng: np.random.Generator, options: Any) -> tuple[list[Any], Any]:
    """Do the same for two that stand or lie level, one of them mostly a cylinder that stands."""
    kinds = [str(kind) for kind in rng.choice(MOVERS, 2)]
    if rng.random() < 0.7:
        kinds[int(rng.integers(2))] = 'puck'
    (low, below, q_low), (high, above, q_high) = (mover(kind, rng, False) for kind in kinds)
    speed = float(10.0 ** rng.uniform(math.log10(0.3), math.log10(30.0)))
    clearance = float(10.0 ** rng.uniform(-4.0, -2.0)) * (1.0 + 1e-9)
    way = 0.6 + 4.0 * options.dt * speed * float(rng.random())
    origin = np.array([0.0, 30.0 * number, 0.0])
    moves = bool(rng.random() < 0.5) or options.gravity
    first = {'name': f'first_{number}', 'shape': low,
             'initial': {'position': origin.tolist(), 'orientation': q_low}}  # fmt: skip
    first |= {'mass': 2.0} if moves else {'fixed': True}
    if moves:
        first['initial']['velocity'] = [-0.3 * speed, 0.0, 0.0]
    place = [-way, float(rng.uniform(-0.1, 0.1)), below + above + clearance]
    second = {
        'name': f'second_{number}', 'shape': high, 'mass': 1.0,
        'initial': {'position': (origin + place).tolist(), 'orientation': q_high,
                    'velocity': [speed, 0.0, 0.0]},
    }  # fmt: skip
    return [first, second], ((*kinds, moves, 0.0, speed, clearance), 2.0 * way / speed)


def run_misses(cases: int, options: Any, pair_of: Any = passing) -> list[Any]:
    """
    Run pairs that pass; (label, change of velocity) of each.

        pair_of : gives the pairs: `passing` or `passing_above`
    """
    rng = np.random.default_rng([options.seed, 99])
    bodies, labels = [], []
    for number in range(cases):
        pair, label = pair_of(number, rng, options)
        bodies += pair
        labels.append(label)
    gravity = [0, 0, -9.81] if options.gravity else [0, 0, 0]
    scene = {'name': 'misses', 'dt': options.dt, 'gravity': gravity,
             'contact': {'mode': 'timestep', 'substeps': options.substeps},
             'bodies': bodies}  # fmt: skip
    alone = [body | {'initial': dict(body['initial'])} for body in bodies]
    for body in alone[1::2]:
        body['initial']['position'] = (
            np.array(body['initial']['position']) + [0, 0, 1e3]
        ).tolist()
    free = dict(scene, bodies=alone)
    simulations = [Simulation(load_scene(one)) for one in (scene, free)]
    until = np.array([time for _, time in labels])
    worst = np.zeros(cases)
    for _ in range(math.ceil(min(until.max(), options.longest) / options.dt)):
        for simulation in simulations:
            simulation.step(1)
        a, b = (simulation.state for simulation in simulations)
        change = np.abs(a.velocity - b.velocity).max(axis=1)
        change += np.abs(a.angular_velocity - b.angular_velocity).max(axis=1)
        change = np.maximum(change[0::2], change[1::2])
        worst = np.where(simulations[0].time < until, np.maximum(worst, change), worst)
    return [(label, change) for (label, _), change in zip(labels, worst, strict=True)]


def main() -> None:
    """Run, print the worst of each kind, and leave with 1 if a law is broken."""
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[1])
    parser.add_argument('--cases', type=int, default=28, help='of each floor; misses: five times')
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--dt', type=float, default=0.004)
    parser.add_argument('--substeps', type=int, default=4)
    parser.add_argument('--speed', type=float, nargs=2, default=(0.1, 10.0))
    parser.add_argument('--only', choices=(*FLOORS, 'floors', 'misses'))
    parser.add_argument('--movers', nargs='*', choices=MOVERS, default=MOVERS)
    parser.add_argument('--spin', type=int, default=1)
    parser.add_argument('--gravity', action='store_true', help='misses fall together')
    parser.add_argument('--longest', type=float, default=4.0, help='[s] of a miss')
    parser.add_argument('--each', action='store_true')
    options = parser.parse_args()
    broken = 0
    for floor in FLOORS:
        if options.only not in (None, 'floors', floor):
            continue
        worst: dict[Any, list[Any]] = defaultdict(list)
        for kind, how, speed, number, error, hop in run_floors(
            floor, options.movers, options.cases, options
        ):
            worst[kind, how].append((error, hop, speed))
            fails = error > SPEED_LAW or hop > HOP_LAW
            broken += fails
            if options.each or fails:
                print(f'  {number:4} {kind:8} {how:6} {speed:7.3f} m/s  {error:8.1e} {hop:8.1e} m')
        for (kind, how), figures in sorted(worst.items()):
            print(f'{floor:7} {kind:8} {how:6} {len(figures):3} cases: speed changes by '
                  f'{max(f[0] for f in figures):8.1e} (law {SPEED_LAW:g}), '
                  f'rises {max(f[1] for f in figures):8.1e} m (law {HOP_LAW:g})')  # fmt: skip
    if options.only in (None, 'misses'):
        found = run_misses(5 * options.cases, options)
        found += run_misses(5 * options.cases, options, passing_above)
        # a hit cuts the tick of all: what spins is then integrated in other pieces
        least = 0.0 if all(change < ROUNDING for _, change in found) else ROUNDING
        touched = [(label, change) for label, change in found if change > least]
        broken += len(touched)
        for label, change in touched:
            print('  touched:', *label, f'{change:.1e} m/s')
        print(f'misses: {len(touched)} of {len(found)} touched (law 0)')
    sys.exit(1 if broken else 0)


if __name__ == '__main__':
    main()
