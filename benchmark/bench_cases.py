# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What `two_checkouts.py` measures, and the process that does it for one checkout.

    PYTHONPATH=CHECKOUT python benchmark/bench_cases.py

A case gives a call that does its work so many times over. Requests come as lines of JSON on
standard input, [case, count]; each is answered by the processor time [s], or by the reason why
this checkout cannot do it. Only public names and the command line are used, so that older
checkouts can answer.
"""

from __future__ import annotations

import json
import os
import random
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

Call = Callable[[int], object]

SPHERE = {'type': 'sphere', 'radius': 0.1}
BOX = {'type': 'box', 'size': [0.2, 0.2, 0.2]}
TUMBLING = {
    'name': 'b',
    'shape': {'type': 'box', 'size': [0.4, 0.2, 0.1]},
    'mass': 2.0,
    'initial': {'angular_velocity': [0.3, 1.0, 0.5]},
}


def scene(bodies: list[dict[str, Any]], **keys: Any) -> dict[str, Any]:
    """Describe a scene."""
    return {'version': 1, 'name': 'bench', 'dt': 0.001, 'bodies': bodies, **keys}


def many(body: dict[str, Any], count: int) -> dict[str, Any]:
    """Describe bodies far from one another."""
    if count > 1:
        body = body | {'repeat': {'count': [count, 1, 1], 'spacing': [2.0, 0, 0]}}
    return scene([body])


def pulled() -> dict[str, Any]:
    """Describe a body on a spring off its centre, with drag."""
    body = {'name': 'b', 'mass': 1.0, 'inertia': {'ixx': 0.1, 'iyy': 0.2, 'izz': 0.25}}
    spring = {'type': 'spring', 'a': 'b', 'b': 'world', 'a_point': [0.2, 0.1, 0.3]}
    drag = {'type': 'drag', 'body': 'b', 'linear': 0.3, 'angular': 0.02}
    spring |= {'b_point': [1.0, 0, 0], 'stiffness': 40.0}
    return scene([body], forces=[spring, drag], gravity=[0, 0, -9.81])


def stiff() -> dict[str, Any]:
    """Describe a point on a stiff damped spring."""
    ball = {'name': 'b', 'shape': {'type': 'particle'}, 'mass': 1.0}
    spring = {'type': 'spring', 'a': 'b', 'b': 'world', 'b_point': [1.0, 0, 0]}
    return scene([ball], forces=[spring | {'stiffness': 1e6, 'damping': 2e3}])


def on_ground(body: dict[str, Any], **keys: Any) -> dict[str, Any]:
    """Describe what falls onto the ground, or stands on it."""
    ground = {'name': 'ground', 'shape': {'type': 'plane', 'normal': [0, 0, 1]}, 'friction': 0.4}
    body = {'name': 'body', 'density': 1000.0, 'friction': 0.4, **body}
    keys = {'gravity': [0, 0, -9.81], 'contact': {'mode': 'timestep'}, 'dt': 0.004} | keys
    return scene([ground, body], **keys)


def pile(shape: dict[str, Any], side: int, height: int) -> dict[str, Any]:
    """Describe bodies that fall onto the ground from a loose grid."""
    grid = {'count': [side, side, height], 'spacing': [0.25, 0.25, 0.25], 'jitter': 0.01}
    return on_ground({'shape': shape, 'initial': {'position': [0, 0, 0.2]}, 'repeat': grid})


def mixed_pile(side: int, height: int) -> dict[str, Any]:
    """Describe boxes, balls, capsules, cylinders and hulls that fall from a loose grid."""
    shapes = [
        BOX, SPHERE, hull(), {'type': 'capsule', 'radius': 0.06, 'length': 0.12},
        {'type': 'cylinder', 'radius': 0.1, 'length': 0.1},
        {'type': 'cylinder', 'radius': 0.06, 'length': 0.2},
    ]  # fmt: skip
    ground, body = on_ground({})['bodies']
    draw = random.Random(11)
    bodies = []
    for number in range(side * side * height):
        at = (number % side, number // side % side, number // (side * side))
        turn = [draw.gauss(0, 1) for _ in range(4)]
        size = sum(x * x for x in turn) ** 0.5
        initial = {
            'position': [0.25 * x + draw.uniform(-0.01, 0.01) + 0.2 * (k == 2)
                         for k, x in enumerate(at)],
            'orientation': [x / size for x in turn],
        }  # fmt: skip
        shape = shapes[draw.randrange(len(shapes))]
        bodies.append(body | {'name': f'b{number}', 'shape': shape, 'initial': initial})
    return on_ground({}) | {'bodies': [ground, *bodies]}


def stack() -> dict[str, Any]:
    """Describe ten boxes on each other."""
    column = {'count': [1, 1, 10], 'spacing': [1.0, 1.0, 0.2]}
    return on_ground({'shape': BOX, 'initial': {'position': [0, 0, 0.1]}, 'repeat': column})


def leaning_stack() -> dict[str, Any]:
    """Describe ten boxes on each other, each some millimetres beside the last."""
    draw = random.Random(3)
    described = on_ground({})
    ground, body = described['bodies']
    boxes = []
    for number in range(10):
        at = [draw.uniform(-0.005, 0.005), draw.uniform(-0.005, 0.005), 0.1 + 0.2 * number]
        boxes.append(body | {'name': f'b{number}', 'shape': BOX, 'initial': {'position': at}})
    return described | {'bodies': [ground, *boxes]}


def hull() -> dict[str, Any]:
    """Describe a convex hull of twenty points on a sphere."""
    draw = random.Random(7)
    points = [[draw.gauss(0, 1) for _ in range(3)] for _ in range(20)]
    sizes = [sum(x * x for x in point) ** 0.5 for point in points]
    vertices = [[0.1 * x / size for x in point] for point, size in zip(points, sizes)]
    return {'type': 'convex_hull', 'vertices': vertices}


def steps(described: dict[str, Any], integrator: str = 'dmv6', **options: Any) -> Call:
    """Advance by ticks in one call."""
    from rigid_body_sim import Simulation, load_scene

    simulation = Simulation(
        load_scene(described), integrator=integrator, integrator_options=options
    )
    simulation.prepare()
    return simulation.step


def steps_after(ticks: int, described: dict[str, Any]) -> Call:
    """Advance by ticks in one call, when so many are over: what stands has come to rest."""
    step = steps(described)
    step(ticks)
    return step


def single_steps(described: dict[str, Any]) -> Call:
    """Advance tick by tick."""
    step = steps(described)

    def work(count: int) -> None:
        for _ in range(count):
            step(1)

    return work


def closed_loop(described: dict[str, Any], *, all_bodies: bool = False) -> Call:
    """
    Read the state, command, advance by a tick.

    The commands are small: whoever repeats them a million times is to find bodies that still move.
    """
    from rigid_body_sim import Simulation, load_scene

    simulation = Simulation(load_scene(described))
    simulation.prepare()
    name = simulation.scene.bodies[-1].name

    def work(count: int) -> None:
        for k in range(count):
            state = simulation.state
            if all_bodies:
                simulation.set_wrenches(torque=-1e-6 * state.angular_velocity_body)
            else:
                lift = 1e-3 * float(state.position[-1, 2])
                simulation.set_wrench(name, force=(0.0, 1e-6 * k, lift))
            simulation.step(1)

    return work


def loading() -> Call:
    """Read a scene of a hundred bodies, listed one by one."""
    from rigid_body_sim import load_scene

    body = (
        '  - {name: b%d, shape: {type: box, size: [0.4, 0.2, 0.1]}, mass: 2.0, friction: 0.4, '
        'initial: {position: [%d.5, 0, 1], velocity: [0, 0.1, 0]}}\n'
    )
    text = 'version: 1\nname: bench\ndt: 0.001\nbodies:\n'
    text += ''.join(body % (k, k) for k in range(100))

    def work(count: int) -> None:
        for _ in range(count):
            load_scene(text.encode())

    return work


def verb(*words: str) -> None:
    """Do a verb of the command line in this process; RuntimeError unless its exit code is 0."""
    from rigid_body_sim.__main__ import main

    try:
        code = main(list(words))
    except SystemExit as end:
        code = end.code
    if code:
        raise RuntimeError(f'{words[0]}: exit code {code}')


def recorded(described: dict[str, Any], duration: float) -> tuple[Path, Callable[[Path], None]]:
    """Give a folder that goes with this process, and what records a scene into a bag."""
    folder = Path(tempfile.mkdtemp(dir=os.environ['BENCH_FOLDER']))
    path = folder / 'scene.yaml'
    path.write_text(json.dumps(described), encoding='utf-8')

    def record(bag: Path) -> None:
        verb('simulate', str(path), '-o', str(bag), '--duration', str(duration))

    return folder, record


def recording(described: dict[str, Any], duration: float) -> Call:
    """Simulate into a bag and close it."""
    folder, record = recorded(described, duration)
    number = iter(range(10**9))

    def work(count: int) -> None:
        for _ in range(count):
            record(folder / f'bag_{next(number)}')

    return work


def replaying() -> Call:
    """Run a bag again."""
    folder, record = recorded(many(TUMBLING, 10), 20.0)
    record(folder / 'bag')

    def work(count: int) -> None:
        for _ in range(count):
            verb('replay', str(folder / 'bag'))

    return work


START = (
    'from rigid_body_sim import Simulation, load_scene\n'
    'import json, sys\n'
    'Simulation(load_scene(json.loads(sys.argv[1]))).step(1)\n'
)


def starting(described: dict[str, Any]) -> Call:
    """Start Python, import the package, load a scene and make its first tick."""

    def work(count: int) -> None:
        for _ in range(count):
            subprocess.run([sys.executable, '-c', START, json.dumps(described)], check=True)

    return work


CASES: dict[str, Callable[[], Call]] = {
    'one free body': partial(steps, many(TUMBLING, 1)),
    '1000 free bodies': partial(steps, many(TUMBLING, 1000)),
    'spring and drag, dmv6': partial(steps, pulled()),
    'spring and drag, rk8': partial(steps, pulled(), 'rk8'),
    'stiff spring, sdirk2': partial(steps, stiff(), 'sdirk2'),
    'stack of ten boxes': partial(steps, stack()),
    'leaning stack, after 2 s': partial(steps_after, 500, leaning_stack()),
    '1000 boxes': partial(steps, pile(BOX, 10, 10)),
    '1000 boxes, after 2 s': partial(steps_after, 500, pile(BOX, 10, 10)),
    '1000 spheres': partial(steps, pile(SPHERE, 10, 10)),
    '200 hulls': partial(steps, pile(hull(), 7, 4)),
    '200 mixed shapes': partial(steps, mixed_pile(7, 4)),
    '200 mixed shapes, after 3 s': partial(steps_after, 750, mixed_pile(7, 4)),
    'step(1) of one body': partial(single_steps, many(TUMBLING, 1)),
    'loop: state, wrench, step(1)': partial(closed_loop, many(TUMBLING, 1)),
    'loop: 100 bodies commanded': partial(closed_loop, many(TUMBLING, 100), all_bodies=True),
    'loop: a box on the ground': partial(
        closed_loop, on_ground({'shape': BOX, 'initial': {'position': [0, 0, 0.1]}})
    ),
    'load_scene, 100 bodies': loading,
    'closing a bag, 300 bodies': partial(recording, many(TUMBLING, 300), 0.001),
    'simulate, 10 bodies, 20 s': partial(recording, many(TUMBLING, 10), 20.0),
    'replay, 10 bodies, 20 s': replaying,
    'start: a free body': partial(starting, many(TUMBLING, 1)),
    'start: stack of ten boxes': partial(starting, stack()),
}


def processor_time() -> float:
    """Processor time of this process and of those that it waited for [s]."""
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


def answers_to(requests: Any) -> Any:
    """Yield the answer to each request."""
    ready: dict[str, Call] = {}
    for line in requests:
        name, count = json.loads(line)
        try:
            if name not in ready:
                ready[name] = CASES[name]()
            began = processor_time()
            ready[name](count)
            yield processor_time() - began
        except Exception as error:  # whatever an older checkout says
            yield f'{type(error).__name__}: {error}'.splitlines()[0]


def main() -> None:
    """Answer until standard input ends; what the work prints goes nowhere."""
    out = os.fdopen(os.dup(1), 'w')
    quiet = os.open(os.devnull, os.O_WRONLY)
    for stream in (1, 2):
        os.dup2(quiet, stream)
    for answer in answers_to(sys.stdin):
        out.write(json.dumps(answer) + '\n')
        out.flush()


if __name__ == '__main__':
    main()
