# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Same bits: digests of what many runs come to, to compare two checkouts of the package.

    python tools/digest.py -o before.txt               this checkout, compiled
    python tools/digest.py --plain --only stack        as plain Python, keys with `stack` alone
    python tools/digest.py --against before.txt        has a bit changed since?
    python tools/digest.py --compare DIR_A DIR_B       the same of two checkouts
    python tools/digest.py --portable --against tools/portable_digest.txt
                                                       what every machine must come to, as plain
                                                       Python, in seconds

A line is `key digest`. The key ends with the tick; the digest has three parts (sha256, 16 digits)

    state    : position, orientation and velocities of every body
    memory   : `Simulation.state_bytes`: also what the integrator and the contacts remember
    contacts : every array of `Simulation.contacts`

so that a difference tells where it is. In place of a digest stands `refused` where an integrator
refuses a scene, `diverged` with the tick where it ends so, and `failed` with the error where the
package breaks; then the exit code is 2.

What runs: every scene of `config/scenes` under every integrator that takes it, and scenes of this
file with contact: every pair of shapes, sleep, saved and restored runs, unions, changing mass,
forces and commands beside contact, fast bodies. Keys that plain and compiled runs share have the
same ticks, and the same digest. Plain runs stop earlier where a tick is slow. Compiled runs leave
out what compiles long and adds little, unless `--full` is given: contact under other integrators
than that of the scene, pairs of shapes one by one, some forces and pivots under most integrators.

Only public names are used (`Simulation`, `load_scene`, the registry of integrators), so that this
file runs on checkouts whose modules stand elsewhere: it starts itself anew for each, with
PYTHONPATH set to it. The bits of sine, cosine and their like are those of the C library, and the
methods that ask LAPACK for something have its bits: digests of two machines need not agree. Those
of `--portable` must: they take nothing but + - * / and sqrt from the setting up of a scene to its
last tick, whatever Python, numpy and processor. After a change that is meant to change bits, write
them anew: `--portable -o tools/portable_digest.txt`, and say so.
"""

from __future__ import annotations

import argparse
import dataclasses
import hashlib
import os
import platform
import subprocess
import sys
import time
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from itertools import combinations_with_replacement
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
CHILD = 'RIGID_BODY_SIM_DIGEST_OF'  # set for the process that runs a checkout
REGISTRIES = (
    'rigid_body_sim.physics.integrators',
    'rigid_body_sim.physics.integration.integrators',
)
DIGITS = 16  # [-] hexadecimal, of each part
FAILED, DIFFERS = 2, 1  # exit codes

# What `--portable` runs: parts of keys. No method with sine (exact_rotor), a power (rk45)
# or a library (linear_propagator, the references).
PORTABLE = (
    'aslant/', 'contact/pair/box_hull_free', 'scene/demo/dmv6', 'scene/heavy_top/rk8',
    'scene/rocket/dmv6', 'scene/satellite/dmv10', 'scene/spring_ball/implicit_midpoint',
    'scene/symmetric_top/sdirk2', 'scene/tumbling_box/dmv8',
)  # fmt: skip
PORTABLE_UNTIL = 60  # [tick]

FREE = (1, 5, 60)  # [tick] looked at where nothing touches
REFERENCE = (1, 5)  # [tick] of methods that run in Python, slowly
TOUCHING = (2, 20, 60, 200)  # [tick] looked at with contact
# [tick] last one of plain runs: under the integrator of the scene, and under others
SLOW = {'domino_row': (200, 20), 'stack': (200, 20), 'pyramid': (60, 2), 'pile_of_1000': (60, 2)}
# with forces or a pivot each method compiles anew: unless full, `demo` under all, these under few
ALIKE = (
    'elastic_push', 'heavy_top', 'hovering_drone', 'oscillator', 'pendulum', 'rocket',
    'spring_ball', 'two_bodies',
)  # fmt: skip
FEW = ('dmv6', 'rk4', 'implicit_midpoint')

Bodies = list[dict[str, Any]]
Act = Callable[[Any], Any]  # on a simulation; may return another one to go on with


@dataclass(frozen=True)
class Case:
    """
    One run.

    key         : of its lines, without the tick
    scene       : path or mapping
    ticks       : those after which a line is written
    integrator  : None: that of the scene
    options     : of the integrator; None: those of the scene, or the defaults
    plain_until : [tick] last one of a plain run
    full_only   : left out of compiled runs, unless they are full
    acts        : tick -> what happens then, after the line of that tick
    """

    key: str
    scene: Path | Mapping[str, Any]
    ticks: Sequence[int]
    integrator: str | None = None
    options: Mapping[str, Any] | None = None
    plain_until: int = 10**9
    full_only: bool = False
    acts: Mapping[int, Act] = field(default_factory=dict)


# ----- scenes of the package


def registry() -> Mapping[str, Any]:
    """Find the integrators by name."""
    for place in REGISTRIES:
        try:
            return import_module(place).INTEGRATORS
        except ModuleNotFoundError:
            continue
    raise SystemExit(f'digest: no registry of integrators in any of {", ".join(REGISTRIES)}')


def shipped(folder: Path) -> Iterator[Case]:
    """Every scene of the package under every integrator."""
    from rigid_body_sim import load_scene

    integrators = registry()
    for path in sorted(folder.glob('*.yaml')):
        scene = load_scene(path)
        own, touches = scene.integrator, scene.contact.get('mode', 'none') != 'none'
        few = {own, 'dmv6'} if touches else {own, *FEW} if path.stem in ALIKE else {*integrators}
        until, until_other = SLOW.get(path.stem, (200, 200))
        for name in sorted(integrators):
            ticks = REFERENCE if integrators[name].is_reference else FREE
            yield Case(
                f'scene/{path.stem}/{name}',
                path,
                TOUCHING if touches else ticks,
                integrator=name,
                options=scene.integrator_options if name == own else None,
                plain_until=until if name == own else until_other,
                full_only=name not in few,
            )


def optioned(folder: Path) -> Iterator[Case]:
    """Options of integrators, and the choice of `auto`."""
    wanted = {
        'rk4/matrix': ('rk4', {'orientation': 'matrix', 'reorthonormalise': True}),
        'rk45/loose': ('rk45', {'rtol': 1e-4, 'atol': 1e-6}),
        'dmv6/substeps': ('dmv6', {'substeps': 3}),
        'blanes_moan4/exact': ('blanes_moan4', {'drift': 'exact'}),
    }
    for scene in ('demo', 'heavy_top', 'rocket'):
        for key, (name, options) in wanted.items():
            yield Case(
                f'option/{scene}/{key}', folder / f'{scene}.yaml', FREE,
                integrator=name, options=options, full_only=scene != 'demo',
            )  # fmt: skip
    for scene in ('satellite', 'stack'):
        yield Case(f'option/{scene}/auto', folder / f'{scene}.yaml', (5,), integrator='auto')


# ----- scenes of contact


def body(name: str, shape: Mapping[str, Any], at: Sequence[float], **more: Any) -> dict[str, Any]:
    """
    Describe one body.

    at   : (3,) [m] position
    more : keys of its initial motion, and any other key of a body
    """
    motion = ('orientation', 'velocity', 'angular_velocity')
    initial = {'position': list(at)} | {key: more.pop(key) for key in motion if key in more}
    mass = {} if more.keys() & {'mass', 'density', 'fixed'} else {'mass': 1.0}
    mass = {} if shape['type'] == 'union' else mass
    return {'name': name, 'shape': dict(shape), 'initial': initial, **mass, **more}


def ground(
    normal: Sequence[float] = (0, 0, 1), name: str = 'ground', **more: Any
) -> dict[str, Any]:
    """Describe a plane through the origin."""
    return {'name': name, 'shape': {'type': 'plane', 'normal': list(normal)}, **more}


def experiment(bodies: Bodies, *, forces: Bodies | None = None, **contact: Any) -> dict[str, Any]:
    """Describe a scene with contact; `dt` and `gravity` may be among the settings."""
    dt, gravity = contact.pop('dt', 0.004), contact.pop('gravity', [0.0, 0.0, -9.81])
    scene = {'name': 'case', 'dt': dt, 'gravity': gravity, 'bodies': bodies}
    scene['contact'] = {'mode': 'timestep', **contact}
    return scene if forces is None else {**scene, 'forces': forces}


KINDS: dict[str, dict[str, Any]] = {
    'sphere': {'type': 'sphere', 'radius': 0.06},
    'box': {'type': 'box', 'size': [0.14, 0.1, 0.08]},
    'capsule': {'type': 'capsule', 'radius': 0.04, 'length': 0.1},
    'cylinder': {'type': 'cylinder', 'radius': 0.06, 'length': 0.08},
    'hull': {
        'type': 'convex_hull',
        'vertices': [
            [0.08, 0, 0], [-0.05, 0.07, 0], [-0.06, -0.06, 0.01],
            [0, 0.02, 0.09], [0, 0, -0.06], [0.04, 0.05, 0.04],
        ],
    },
}  # fmt: skip
ROUGH = {
    'friction': 0.6, 'restitution': 0.5, 'rolling_friction': 0.002, 'torsional_friction': 0.003,
}  # fmt: skip
FUNNEL = ((1, 0, 1), (-1, 0, 1), (0, 1, 1.5), (0, -1, 1.5))  # normals of its walls
HEADS = ([0.1, 0.2, 0.3, 0.9], [0.5, -0.1, 0.2, 0.8], [0, 0, 0, 1], [-0.3, 0.6, 0.1, 0.7])


def thrown(**more: Any) -> Bodies:
    """Four bodies of each kind above a funnel of planes and a floor: all pairs of shapes meet."""
    bodies = [ground(**more)]
    bodies += [ground(n, name=f'wall_{i}', **more) for i, n in enumerate(FUNNEL)]
    for i in range(20):
        kind = list(KINDS)[i // 3 if i < 15 else 3 * i % 5]
        x, y, z = 0.19 * (i % 3 - 1), 0.17 * (i // 3 % 3 - 1), 0.35 + 0.1 * (i // 5) + 0.013 * i
        bodies.append(
            body(
                f'{kind}_{i}', KINDS[kind], (x, y, z),
                orientation=HEADS[i % 4], velocity=[-2 * x, -2 * y, -1.0 - 0.1 * i],
                angular_velocity=[0.7 * i - 3, 2.0, 1.0 - 0.3 * i], **more,
            )
        )  # fmt: skip
    return bodies


def mixed() -> Iterator[Case]:
    """Every kind of body thrown together, rough and smooth, in one substep and in sixteen."""
    smooth = thrown(friction=0.3)
    yield Case('contact/mixed/rough', experiment(thrown(**ROUGH)), TOUCHING)
    yield Case('contact/mixed/smooth', experiment(smooth), TOUCHING)
    for substeps in (1, 16):
        scene = experiment(smooth, substeps=substeps)
        key, until = f'contact/mixed/substeps_{substeps}', 200 if substeps == 1 else 60
        yield Case(key, scene, TOUCHING, plain_until=until)
    settings = {'damping_ratio': 1.0, 'relaxations': 1, 'slop': 0.001, 'push_out_speed': 1.0}
    scene = experiment(smooth, **settings, margin=0.003, restitution_threshold=0.1)
    yield Case('contact/mixed/settings', scene, TOUCHING, plain_until=60)


def pairs() -> Iterator[Case]:
    """Two bodies of each two kinds meet aslant on a floor, one of them at rest or fixed."""
    for a, b in combinations_with_replacement(KINDS, 2):
        for fixed in (False, True):
            more = {'fixed': True} if fixed else {}
            bodies = [
                ground(**ROUGH),
                body('rests', KINDS[a], (0, 0, 0.07), **more, **ROUGH),
                body(
                    'comes', KINDS[b], (0.02, 0.01, 0.3), orientation=HEADS[0],
                    velocity=[0, 0, -1.0], angular_velocity=[3, 1, 2], **ROUGH,
                ),
            ]  # fmt: skip
            key = f'contact/pair/{a}_{b}_{"fixed" if fixed else "free"}'
            yield Case(key, experiment(bodies), (30, 100), full_only=True)


CUBE = {'type': 'box', 'size': [0.2, 0.2, 0.2]}
BALL = {'type': 'sphere', 'radius': 0.1}


def heap() -> Bodies:
    """A stack of three cubes, a cube on its edge and two balls, on the ground."""
    bodies = [ground()] + [body(f'cube_{i}', CUBE, (0, 0, 0.1 + 0.2 * i)) for i in range(3)]
    bodies.append(body('aslant', CUBE, (0.6, 0, 0.2), orientation=[0.2, 0.1, 0, 0.97]))
    bodies.append(body('ball', BALL, (0.65, 0.02, 0.45), restitution=0.4))
    return [*bodies, body('roller', BALL, (-0.9, 0, 0.1), velocity=[2.0, 0, 0])]


def struck(simulation: Any) -> None:
    """Strike a cube in its axes and lift the other."""
    simulation.apply_impulse('cube_2', linear=(0.5, 0, 0), angular=(0, 0.02, 0), frame='body')
    simulation.apply_impulse('aslant', linear=(0, 0, 2.0))


def restored(simulation: Any) -> Any:
    """Give a fresh simulation that goes on from where one stands."""
    from rigid_body_sim import Simulation

    other = Simulation(simulation.scene)
    other.restore(tick=simulation.tick, state=simulation.state_bytes(), slots={})
    return other


def reset(simulation: Any) -> None:
    """Begin anew."""
    simulation.reset()


def sleeping() -> Iterator[Case]:
    """Heaps that fall asleep, are woken by a hit, and go on from a saved state."""
    calm = {'sleeping': True, 'sleep_time': 0.08, 'sleep_speed': 0.02}
    bodies = [ground()] + [body(f'cube_{i}', CUBE, (0, 0, 0.1 + 0.2 * i)) for i in range(3)]
    bodies.append(body('aslant', CUBE, (0.9, 0, 0.1)))
    bodies.append(body('roller', BALL, (-1.5, 0, 0.1), velocity=[2.0, 0, 0]))
    asleep = experiment(bodies, **calm)
    ticks = (40, 60, 100, 160, 240)
    yield Case('contact/sleep/woken_by_a_ball', asleep, (*ticks, 400), plain_until=240)
    yield Case('contact/sleep/woken_by_an_impulse', asleep, ticks, acts={60: struck})
    yield Case('contact/sleep/restored', asleep, ticks, acts={60: restored, 200: restored})
    yield Case('contact/sleep/heap', experiment(heap(), **calm), (*TOUCHING, 400), plain_until=200)


def saved() -> Iterator[Case]:
    """Runs that are saved and restored, or reset: beside one that is not."""
    ticks, scene = (40, 41, 120), experiment(heap())
    yield Case('contact/heap/run', scene, ticks)
    yield Case('contact/heap/struck', scene, ticks, acts={40: struck})
    yield Case('contact/heap/restored', scene, ticks, acts={40: restored, 60: restored})
    yield Case('contact/heap/reset', scene, ticks, acts={41: reset})


def part(shape: Mapping[str, Any], at: Sequence[float], mass: float = 0.2) -> dict[str, Any]:
    """Describe a part of a union."""
    return {'shape': dict(shape), 'mass': mass, 'position': list(at)}


def unions() -> Iterator[Case]:
    """A cup with balls, a dumb-bell, and a hammer fall on the ground."""
    wall, end = (
        {'type': 'box', 'size': [0.02, 0.3, 0.2]},
        {'type': 'box', 'size': [0.3, 0.02, 0.2]},
    )
    base = {'type': 'box', 'size': [0.3, 0.3, 0.02]}
    cup = [part(wall, (x, 0, 0.1)) for x in (-0.15, 0.15)]
    cup += [part(end, (0, y, 0.1)) for y in (-0.15, 0.15)] + [part(base, (0, 0, 0))]
    bell = [part(BALL, (0, 0, -0.2)), part(BALL, (0, 0, 0.2))]
    bell.append(part({'type': 'cylinder', 'radius': 0.02, 'length': 0.4}, (0, 0, 0), 0.1))
    hammer = [part({'type': 'capsule', 'radius': 0.02, 'length': 0.3}, (0, 0, 0))]
    hammer.append(part(KINDS['hull'], (0, 0, 0.2), 0.5))
    bodies = [
        ground(),
        body('cup', {'type': 'union', 'parts': cup}, (0, 0, 0.1)),
        body('in_it', KINDS['sphere'], (0.05, 0, 0.5), restitution=0.3),
        body('beside', KINDS['sphere'], (-0.05, 0.03, 0.4), velocity=[1.0, 0.3, 0]),
        body('bell', {'type': 'union', 'parts': bell}, (0.1, 0.1, 0.9), orientation=HEADS[1]),
        body(
            'hammer', {'type': 'union', 'parts': hammer}, (0.6, 0, 0.3),
            angular_velocity=[2, 5, 1], friction=0.5,
        ),
    ]  # fmt: skip
    yield Case('contact/union', experiment(bodies), TOUCHING)


def flowing() -> Iterator[Case]:
    """Bodies that lose and gain mass carry, slide and hit."""
    bodies = [
        ground(),
        body('leaks', CUBE, (0, 0, 0.1), mass_rate=-0.3, final_mass=0.8),
        body('on_it', CUBE, (0, 0, 0.3), mass_rate=0.4, final_mass=1.5),
        body('slides', CUBE, (1, 0, 0.1), velocity=[-2, 0, 0], mass_rate=-0.5),
        body(
            'rocket', CUBE, (0, 1, 0.12), mass_rate=-0.6, exhaust_velocity=15.0, final_mass=0.7,
        ),
    ]  # fmt: skip
    yield Case('contact/changing_mass', experiment(bodies), TOUCHING)


def pushed(simulation: Any) -> None:
    """Hold wrenches in the axes of bodies and of the world, some for a while."""
    simulation.set_wrench('cube_0', force=(3.0, 0, 0.5), torque=(0, 0, 0.3), frame='body')
    simulation.hold('aslant', 'torque', torque=(0, 0.5, 0.1), frame='body', until=90)
    simulation.hold('roller', 'force', force=(-2.0, 0.5, 0), until=75)


def forces() -> Iterator[Case]:
    """Force elements and commands beside contact."""
    elements = [
        {'type': 'spring', 'a': 'cube_2', 'a_point': [0.1, 0, 0.1], 'b': 'ball', 'stiffness': 40,
         'damping': 0.2, 'rest_length': 0.4},
        {'type': 'drag', 'body': 'roller', 'linear': 0.2, 'angular': 0.001},
        {'type': 'constant', 'body': 'aslant', 'force': [0.5, 0, 1], 'frame': 'body'},
        {'type': 'gravity', 'constant': 0.5, 'among': ['cube_0', 'roller', 'ball']},
    ]  # fmt: skip
    yield Case('contact/forces/elements', experiment(heap(), forces=elements), TOUCHING)
    scene, ticks = experiment(heap()), (20, 60, 80, 120)
    yield Case('contact/forces/commands', scene, ticks, acts={20: pushed})
    scene = experiment(heap(), forces=elements[:1], sleeping=True, sleep_time=0.08)
    yield Case('contact/forces/sleeping', scene, ticks, acts={80: pushed})


def fast() -> Iterator[Case]:
    """Bodies faster than their size in a tick meet thin and turning ones: their ticks are cut."""
    thin = {'type': 'box', 'size': [0.02, 0.5, 0.5]}
    bullet = {'type': 'sphere', 'radius': 0.01}
    bodies = [
        ground(),
        body('sheet', thin, (0.5, 0, 0.25)),
        body('wall', thin, (1.5, 0, 0.25), fixed=True),
        body('bullet', bullet, (0, 0.02, 0.3), velocity=[150, 0, 0], mass=0.05, restitution=0.5),
        body(
            'brick', KINDS['box'], (-1, 0.1, 0.8), orientation=HEADS[1],
            velocity=[20, 0, -120], angular_velocity=[30, 50, 10], restitution=0.3,
        ),
        body('spins', KINDS['box'], (0.9, 0, 0.6), angular_velocity=[0, 200, 5]),
    ]  # fmt: skip
    yield Case('contact/fast', experiment(bodies), (1, *TOUCHING))


def aslant() -> Iterator[Case]:
    """Bodies that are not diagonal in their axes, some of them symmetric, pushed and pulled."""
    tilt, plate = {'orientation': [0.1, -0.2, 0.3, 0.9]}, {'type': 'box', 'size': [0.3, 0.3, 0.02]}
    inner = {'type': 'union', 'parts': [part(CUBE, (0.2, 0.1, 0)) | tilt, part(BALL, (0, 0.3, 0))]}
    square = {'type': 'union', 'parts': [part(plate, (0, 0, 0), 1.0) | tilt]}
    points = [[0.3, 0, 0.1], [0, 0.2, -0.1], [-0.1, 0, 0.2], [0.1, -0.3, 0]]
    dots = [{'mass': 0.2 + 0.1 * i, 'position': x} for i, x in enumerate(points)]
    nested = {'type': 'union', 'parts': [{'shape': inner, 'position': [0, 0, 0.1]} | tilt,
                                         part(KINDS['hull'], (0, 0, 0.2))]}  # fmt: skip
    spin = {'angular_velocity': [1.0, 4.0, -2.0]}
    bodies = [
        body('square', square, (0, 0, 0), **spin),
        body('nested', nested, (2, 0, 0), **spin),
        body('hull', KINDS['hull'], (0, 2, 0), orientation=HEADS[1], **spin),
        {'name': 'dots', 'shape': {'type': 'particles', 'particles': dots}, 'initial': spin},
        body('stated', CUBE, (0, 0, 2), **spin, inertia={
            'ixx': 0.02, 'iyy': 0.02, 'izz': 0.025, 'ixy': 0.001, 'ixz': -0.002, 'iyz': 0.003,
        }),
    ]  # fmt: skip
    forces = [
        {'type': 'spring', 'a': 'square', 'a_point': [0.1, 0, 0], 'b': 'nested', 'stiffness': 20,
         'damping': 0.1, 'rest_length': 1.0},
        {'type': 'constant', 'body': 'hull', 'torque': [0.01, 0, 0.02], 'frame': 'body'},
    ]  # fmt: skip
    scene = experiment(bodies, forces=forces, mode='none')
    turned = {5: lambda simulation: simulation.set_wrench(
        'stated', force=(0.1, 0, 0), torque=(0, 0.02, 0), frame='body')}  # fmt: skip
    for name in ('dmv6', 'rk4', 'implicit_midpoint'):
        yield Case(f'aslant/{name}', scene, FREE, integrator=name, acts=turned)


def cases(folder: Path) -> Iterator[Case]:
    """Give all runs."""
    for group in (mixed, sleeping, saved, unions, flowing, forces, fast, aslant):
        yield from group()
    yield from optioned(folder)
    yield from shipped(folder)
    yield from pairs()


# ----- running


def digest(*arrays: Any) -> str:
    """Shorten the bytes of arrays."""
    whole = hashlib.sha256()
    for array in arrays:
        whole.update(array if isinstance(array, bytes) else array.tobytes())
    return whole.hexdigest()[:DIGITS]


def reading(simulation: Any) -> str:
    """Shorten state, memory and contacts of a simulation."""
    state, contacts = simulation.state, simulation.contacts()
    of_state = (state.position, state.orientation, state.velocity, state.angular_velocity)
    of_contacts = [getattr(contacts, item.name) for item in dataclasses.fields(contacts)]
    parts = digest(*of_state), digest(simulation.state_bytes()), digest(*of_contacts)
    return '.'.join(parts)


def lines(case: Case, *, plain: bool, until: int) -> Iterator[str]:
    """Run a case."""
    from rigid_body_sim import Simulation, load_scene

    simulation = None
    try:
        scene = load_scene(case.scene)
        simulation = Simulation(scene, integrator=case.integrator, integrator_options=case.options)
        until = min(until, case.plain_until if plain else max(case.ticks))
        done = 0
        for tick in sorted({*case.ticks, *case.acts}):
            if tick > until:
                break
            simulation.step(tick - done)
            done = tick
            if tick in case.ticks:
                yield f'{case.key}@{tick} {reading(simulation)}'
            if tick in case.acts:
                simulation = case.acts[tick](simulation) or simulation
    except Exception as error:
        kind = type(error).__name__
        if kind == 'SimulationDiverged' and simulation is not None:
            yield f'{case.key} diverged@{simulation.tick}.{reading(simulation)}'
        elif kind == 'InvalidModel' and simulation is None:
            yield f'{case.key} refused'
        else:
            traceback.print_exc()
            yield f'{case.key} failed.{kind}'


def header(options: argparse.Namespace) -> str:
    """Say how digests were made: those of equal headers have the same keys."""
    mode = 'plain' if options.plain else 'compiled, full' if options.full else 'compiled'
    software = [f'python {platform.python_version()}']
    for name in ('numpy', 'numba', 'scipy'):
        try:
            software.append(f'{name} {version(name)}')
        except PackageNotFoundError:
            software.append(f'no {name}')
    return f'# {mode}; {", ".join(software)}; key@tick state.memory.contacts'


def run(options: argparse.Namespace) -> int:
    """Print the digest of the package that is imported here."""
    import rigid_body_sim

    checkout = Path(os.environ[CHILD])
    if Path(rigid_body_sim.__file__).resolve().parents[1] != checkout:
        raise SystemExit(f'digest: the package came from {rigid_body_sim.__file__}')
    wanted = [
        case
        for case in cases(checkout / 'config' / 'scenes')
        if matches(case.key, options.only)
        and (not options.portable or matches(case.key, PORTABLE))
        and (options.plain or options.full or not case.full_only)
    ]
    until = PORTABLE_UNTIL if options.portable else 10**9
    failed, begin = False, time.monotonic()
    for number, case in enumerate(wanted, 1):
        start = time.monotonic()
        for line in lines(case, plain=options.plain, until=until):
            print(line, flush=True)
            failed |= ' failed.' in line
        spent = time.monotonic() - start
        if spent > options.slower_than:
            text = f'{number}/{len(wanted)} {case.key}: {spent:.1f} s'
            print(f'{text}, {time.monotonic() - begin:.0f} s in all', file=sys.stderr, flush=True)
    return FAILED if failed else 0


def matches(key: str, only: Sequence[str]) -> bool:
    """Tell whether a key is asked for."""
    return not only or any(piece in key for piece in only)


# ----- comparing


def digest_of(checkout: Path, options: argparse.Namespace) -> tuple[str, dict[str, str], int]:
    """Run this file on a checkout: header, digests by key, exit code."""
    checkout = checkout.resolve()
    if not (checkout / 'rigid_body_sim' / '__init__.py').is_file():
        raise SystemExit(
            f'digest: {checkout} holds no rigid_body_sim; give the root of a checkout'
        )
    command = [sys.executable, __file__, '--slower-than', str(options.slower_than)]
    command += ['--plain'] * options.plain + ['--full'] * options.full
    command += ['--portable'] * options.portable
    if options.only:
        command += ['--only', *options.only]
    environment = {**os.environ, 'PYTHONPATH': str(checkout), CHILD: str(checkout)}
    environment['RIGID_BODY_SIM_COMPILE'] = '0' if options.plain else '1'
    print(f'digest of {checkout}', file=sys.stderr, flush=True)
    done = subprocess.run(command, env=environment, stdout=subprocess.PIPE, text=True, check=False)
    found = read(done.stdout)
    if done.returncode not in (0, FAILED) or (done.returncode and not found):
        raise SystemExit(f'digest: the run of {checkout} ended with exit code {done.returncode}')
    return header(options), found, done.returncode


def read(text: str) -> dict[str, str]:
    """Give the digests of a text by key."""
    rows = (line.split() for line in text.splitlines() if line and line[0] != '#')
    return {row[0]: row[1] for row in rows}


def compare(one: Mapping[str, str], other: Mapping[str, str], *, same_keys: bool) -> int:
    """
    Print what differs, and how many lines agree.

    same_keys : a key that one of them lacks is a difference
    """
    differs = 0
    for key in dict.fromkeys([*one, *other]):
        a, b = one.get(key, 'absent'), other.get(key, 'absent')
        if a != b and (same_keys or 'absent' not in (a, b)):
            differs += 1
            print(f'{key} {a} {b}')
    agree = sum(one[key] == other.get(key) for key in one)
    alone = len(one.keys() ^ other.keys())
    print(f'{agree} lines agree, {differs} differ, {alone} stand in one alone')
    return DIFFERS if differs or not agree else 0


def main() -> int:
    """Run as asked; returns the exit code."""
    parser = argparse.ArgumentParser(description='digests of final states, to compare checkouts')
    parser.add_argument('--checkout', type=Path, default=ROOT, metavar='DIR')
    parser.add_argument('--compare', type=Path, nargs=2, metavar=('DIR_A', 'DIR_B'))
    parser.add_argument('--against', type=Path, metavar='FILE', help='a digest that was saved')
    parser.add_argument('--plain', action='store_true', help='without numba')
    parser.add_argument(
        '--portable',
        action='store_true',
        help='as plain Python, cases that every machine must agree on',
    )
    parser.add_argument('--full', action='store_true', help='compiled: every case; half an hour')
    parser.add_argument('--only', nargs='+', default=[], metavar='SUBSTRING', help='of keys')
    parser.add_argument('-o', '--output', type=Path, metavar='FILE')
    parser.add_argument(
        '--slower-than', type=float, default=1.0, metavar='S', help='cases that stderr names'
    )
    options = parser.parse_args()
    options.plain |= options.portable
    if CHILD in os.environ:
        return run(options)
    if options.compare:
        (_, one, failed), (_, other, failed_too) = (
            digest_of(checkout, options) for checkout in options.compare
        )
        return compare(one, other, same_keys=True) or failed or failed_too
    how, found, failed = digest_of(options.checkout, options)
    text = '\n'.join([how, *(f'{key} {value}' for key, value in found.items()), ''])
    if options.output:
        options.output.write_text(text)
    if options.against:
        saved_text = options.against.read_text()
        known = {k: v for k, v in read(saved_text).items() if matches(k, options.only)}
        return compare(known, found, same_keys=saved_text.startswith(how)) or failed
    if not options.output:
        print(text, end='')
    return failed


if __name__ == '__main__':
    raise SystemExit(main())
