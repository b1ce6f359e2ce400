# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Attack what reads scenes: `python tools/fuzz_scenes.py [--cases 60000] [--seed 1]`.

Five kinds of cases, by turns: shipped scenes with damaged text; shipped scenes with damaged trees,
as mappings; trees of random structure, drawn from the schema of the scenes with junk here and
there; one number of a scene written in any way; records made in Python with junk in a field. A
third of the scenes whose bodies meet do so by `mode: event`. Each must be accepted, or refused by
one printable line of the package's own exceptions, within seconds of processor time and without a
warning; a number that is accepted must be what JSON and C call it. Every tenth scene that is
accepted is also made a simulation and stepped. A case is made of the seed and its number alone:
--only N repeats it and shows what failed. Exit code 1 where a case failed.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import random
import resource
import signal
import sys
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

os.environ.setdefault('RIGID_BODY_SIM_COMPILE', '0')  # few ticks of many scenes: do not compile
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import numpy as np
import yaml

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.errors import InvalidModel, SimulationDiverged
from rigid_body_sim.physics.forces.elements import FORCES
from rigid_body_sim.physics.model.scene import Body, MassFlow, Material, Motion, Pivot, Scene
from rigid_body_sim.physics.model.shapes import Box, Capsule, Particle, Plane, Sphere
from rigid_body_sim.scene.shipped_scenes import schema_path, shipped_scenes

PATIENCE = 20  # [s] of processor time for one case
WAITING = 6  # times that: a busy machine is no failure
MEMORY = 6 << 30  # [bytes] of address space
STEPPED = 10  # every so many accepted scenes are stepped
LARGE = 3000  # [byte] larger scenes come in a tenth of the cases
MANY = 60  # [-] bodies; scenes of more are read only
MEETING = 6  # [-] the same where they meet
DEEP = 7  # levels of a drawn tree; further in everything is short

JUNK: tuple[Any, ...] = (
    None, True, False, 0, -1, 1, 2.5, -0.0, 1e308, -1e308, 5e-324, 1e-9, 10**400, -(10**20),
    math.inf, -math.inf, math.nan, '', 'x', 'box', 'world', 'clock', '010', '1:30', '0x1F', '1_0',
    'a' * 5000, '\x1b[2J', '$x_{', 'é…\U0001f600', '\n', [], [1], [0, 0, 1], [1, 2, 3, 4],
    [[1, 2], [3]], ['a', 'b', 'c'], {}, {'type': 'box'}, {'a': {'b': {}}}, [[[[]]]],
    {'type': 'sphere', 'radius': 1e-160}, {'count': [1000, 1000, 1000], 'spacing': [1, 1, 1]},
)  # fmt: skip
ODD: tuple[Any, ...] = (
    b'x', 1j, {1}, object(), np.array([1.0, 2.0]), np.float32(2.0), np.int64(3), np.array(2.0),
    np.full((3, 3), np.nan), np.diag([1.0, 1.0, 5.0]), np.eye(2), (0, 0, 0), (1, math.nan, 0),
    ('1', '2', '3'), range(3), len, int,
)  # fmt: skip
WORDS = (
    b'bodies', b'forces', b'mass', b'- ', b': ', b'{', b'}', b'[', b']', b'&a ', b'*a', b'<<: ',
    b'!!int ', b'!!python/object:os.system ', b'"', b"'", b'\n', b'\t', b'\x00', b'\xff', b'#',
    b'|', b'>', b'%', b'@', b'? ', b'.inf', b'.nan', b'010', b'1e400', b'-', b'~', b'null', b'yes',
    b'\xe2\x80\xa8', b'\x1b', b'...', b'---',
)  # fmt: skip
DIGITS = '0123456789'


class TooLong(BaseException):
    """A case took longer than PATIENCE; no Exception, which some parsers swallow."""


class Fuzz:
    """Makes and judges the cases of one seed."""

    def __init__(self, seed: int) -> None:
        self._seed = seed
        paths = sorted(shipped_scenes().values())
        self._texts = [path.read_bytes() for path in paths]
        self._folders = [path.parent for path in paths]
        self._small = [i for i, text in enumerate(self._texts) if len(text) < LARGE]
        self._schema = json.loads(schema_path().read_text())
        self._kinds: tuple[Callable[[random.Random], Any], ...] = (
            self._damaged_text,
            self._damaged_tree,
            self._drawn_tree,
            self._number,
            self._record,
        )

    def run(self, case: int) -> str:
        """Return 'accepted', 'refused', or what went wrong, after 'failed: '."""
        chance = random.Random(f'{self._seed} {case}')
        kind = self._kinds[case % len(self._kinds)]
        signal.setitimer(signal.ITIMER_PROF, PATIENCE)
        signal.alarm(WAITING * PATIENCE)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter('error')
                return kind(chance)
        except (UserError, InvalidModel) as error:
            return _judged(str(error))
        except SimulationDiverged:
            return 'accepted'
        except TooLong:
            return f'failed: longer than {PATIENCE} s'
        except Exception as error:  # what a fuzz looks for
            place = traceback.extract_tb(error.__traceback__)[-1]
            where = f'{Path(place.filename).name}:{place.lineno}'
            return f'failed: {type(error).__name__} at {where}: {str(error)[:200]}'
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0.0)
            signal.alarm(0)

    def _pick(self, chance: random.Random) -> int:
        anywhere = chance.random() < 0.1
        return chance.choice(range(len(self._texts)) if anywhere else self._small)

    def _damaged_text(self, chance: random.Random) -> str:
        scene = self._pick(chance)
        text = bytearray(_by_events(self._texts[scene], chance))
        for _ in range(chance.choice((1, 1, 1, 2, 3, 8))):
            _damage(text, chance)
        return self._take(bytes(text), chance, folder=self._folders[scene])

    def _damaged_tree(self, chance: random.Random) -> str:
        scene = self._pick(chance)
        tree = yaml.safe_load(_by_events(self._texts[scene], chance))
        for _ in range(chance.choice((1, 1, 1, 2, 3))):
            _graft(tree, chance)
        return self._take(tree, chance, folder=self._folders[scene])

    def _drawn_tree(self, chance: random.Random) -> str:
        tree = _drawn(
            self._schema, self._schema, chance, junk=chance.choice((0.0, 0.0, 0.01, 0.1))
        )
        if isinstance(tree, dict):
            _tidy(tree, chance)
        return self._take(tree, chance, folder=self._folders[self._pick(chance)])

    def _number(self, chance: random.Random) -> str:
        text = _number_text(chance)
        scene = (
            f'dt: 0.001\nbodies: [{{name: a, shape: {{type: particle}}, mass: 1, '
            f'initial: {{position: [{text}, 0, 0]}}}}]'
        )
        found = load_scene(scene.encode()).bodies[0].initial.position[0]
        bare = text.removeprefix('!!float ').removeprefix('!!int ').strip('"\'')
        if not _is_decimal(bare):
            return f'failed: {text!r} was read as {found}'
        try:
            said = float(json.loads(bare))
        except ValueError:
            said = float(bare)  # JSON has no +1 and no .5
        return 'accepted' if found == said else f'failed: {text!r} was read as {found}'

    def _record(self, chance: random.Random) -> str:
        scene = _scene(chance)
        simulation = Simulation(scene)
        _use(simulation, chance)
        return 'accepted'

    def _take(self, source: Any, chance: random.Random, *, folder: Path) -> str:
        os.chdir(folder)  # where the files lie that the scene names
        scene = load_scene(source)
        is_small = len(scene.bodies) <= (MANY if scene.contact['mode'] == 'none' else MEETING)
        if is_small and chance.randrange(STEPPED) == 0:
            Simulation(scene, integrator='rk4').step(2)
        return 'accepted'


def _by_events(text: bytes, chance: random.Random) -> bytes:
    return text.replace(b'mode: timestep', b'mode: event') if chance.random() < 0.3 else text


def _drawn(schema: Any, whole: Any, chance: random.Random, *, junk: float, depth: int = 0) -> Any:
    """Draw what a schema allows, but for junk: mappings, lists, words, numbers of any size."""
    if chance.random() < junk:
        return chance.choice(JUNK)
    while '$ref' in schema:
        schema = whole['definitions'][schema['$ref'].rpartition('/')[2]]
    if 'const' in schema:
        return schema['const']
    if 'enum' in schema:
        return chance.choice(schema['enum'])
    if 'anyOf' in schema:
        return _drawn(chance.choice(schema['anyOf']), whole, chance, junk=junk, depth=depth)
    kinds = schema.get('type', 'object')
    kind = kinds if isinstance(kinds, str) else kinds[0]
    if kind == 'object':
        return _drawn_mapping(schema, whole, chance, junk=junk, depth=depth)
    if kind == 'array':
        low = schema.get('minItems', 0)
        high = min(schema.get('maxItems', low + 3), low + 3) if depth < DEEP else low
        items = schema.get('items', {'type': 'number'})
        if isinstance(items, dict):
            items = [items] * chance.randint(low, max(low, high))
        return [_drawn(item, whole, chance, junk=junk, depth=depth + 1) for item in items]
    if kind == 'null':
        return None
    if kind == 'boolean':
        return chance.random() < 0.5
    if kind in ('number', 'integer'):
        return _drawn_number(schema, chance, whole=kind == 'integer')
    return chance.choice(('a', 'b', 'c', 'a', 'b', 'world', 'x', 'ring.stl', '1.5', ''))


def _drawn_mapping(
    schema: Any, whole: Any, chance: random.Random, *, junk: float, depth: int
) -> dict[Any, Any]:
    found: dict[Any, Any] = {}
    rules = [schema]
    keys = schema.get('properties', {})
    if 'type' in keys and isinstance(keys['type'], dict):  # of which kind, then its own keys
        kind = _drawn(keys['type'], whole, chance, junk=junk, depth=depth)
        found['type'] = kind
        for rule in schema.get('allOf', ()):
            said = rule.get('if', {}).get('properties', {}).get('type', {})
            if kind in (said.get('const'), *said.get('enum', ())):
                rules.append(rule['then'])
    for rule in rules:
        needed = rule.get('required', ())
        for key, value in rule.get('properties', {}).items():
            wanted = 0.99 if key in needed else (0.1 if depth < DEEP else 0.0)
            if isinstance(value, dict) and key not in found and chance.random() < wanted:
                found[key] = _drawn(value, whole, chance, junk=junk, depth=depth + 1)
    return found


def _tidy(tree: dict[Any, Any], chance: random.Random) -> None:
    """Give a drawn scene what would otherwise keep nearly all from being accepted."""
    tree.update(version=1, dt=chance.choice((1e-3, 0.004, 1e-9, 0.5)))
    bodies = tree.get('bodies')
    for name, body in zip('abcd', bodies if isinstance(bodies, list) else (), strict=False):
        if isinstance(body, dict) and chance.random() < 0.95:
            body['name'] = name
            mass = chance.choice((0.5, 1.0, 20.0))
            if chance.random() < 0.7:
                body.pop('urdf', None)
                body.setdefault('shape', {'type': 'box', 'size': [0.1, 0.2, 0.3]})
            if 'density' not in body and 'motion' not in body and chance.random() < 0.8:
                body['mass'] = mass


def _drawn_number(schema: Any, chance: random.Random, *, whole: bool) -> float:
    low = schema.get('minimum', schema.get('exclusiveMinimum', -math.inf))
    high = schema.get('maximum', schema.get('exclusiveMaximum', math.inf))
    if whole:
        return chance.randint(int(max(low, -5)), int(min(high, max(low, 0) + 20)))
    size = 10.0 ** (chance.uniform(-3, 3) if chance.random() < 0.9 else chance.uniform(-320, 308))
    return min(high, max(low, chance.choice((1, 1, 1, -1, 0)) * size))


def _judged(message: str) -> str:
    if not message or not message.isprintable():
        return f'failed: message {message!r}'
    return 'refused'


def _damage(text: bytearray, chance: random.Random) -> None:
    at = chance.randrange(len(text) + 1)
    match chance.randrange(7):
        case 0:
            del text[at : at + chance.choice((1, 1, 3, 20))]
        case 1:
            text[at:at] = chance.choice(WORDS)
        case 2 if at < len(text):
            text[at] ^= 1 << chance.randrange(8)
        case 3:
            lines = bytes(text).splitlines(keepends=True)
            chance.shuffle(lines)
            text[:] = b''.join(lines[: chance.randrange(1, len(lines) + 1)]) if lines else b''
        case 4:
            start = chance.randrange(len(text) + 1)
            text[at:at] = text[start : start + chance.choice((5, 40, 200))]
        case 5:
            places = [i for i, letter in enumerate(text) if letter in b'0123456789']
            if places:
                i = chance.choice(places)
                text[i : i + 1] = _number_text(chance).encode()
        case _:
            text[at:] = b''


def _graft(tree: Any, chance: random.Random) -> None:
    """Change one place of a tree of mappings and lists."""
    places = list(_places(tree))
    if not places:
        return
    parent, key = chance.choice(places)
    match chance.randrange(6):
        case 0:
            del parent[key]
        case 1:
            other, at = chance.choice(places)
            parent[key] = other[at] if other is not parent else chance.choice(JUNK)
        case 2 if isinstance(parent, dict):
            parent[chance.choice(('x', 'mass', 'type', 'n' * 900, 3, None))] = parent[key]
        case 3 if isinstance(parent[key], int | float) and abs(parent[key]) < 1e300:
            value = parent[key]
            scale = 10.0 ** chance.uniform(-320, 308)
            parent[key] = chance.choice((-value, value * scale, value + 1, 0))
        case _:
            parent[key] = chance.choice(JUNK)


def _places(tree: Any, depth: int = 0) -> Any:
    if depth > 12:  # a graft may have made a circle
        return
    keys = tree.keys() if isinstance(tree, dict) else range(len(tree))
    for key in list(keys):
        yield tree, key
        if isinstance(tree[key], dict | list):
            yield from _places(tree[key], depth + 1)


def _number_text(chance: random.Random) -> str:
    """Write something that looks like a number to somebody."""
    digits = ''.join(chance.choice(DIGITS) for _ in range(chance.choice((1, 2, 3, 8, 400))))
    match chance.randrange(14):
        case 0:
            return digits
        case 1:
            return f'0{digits}'
        case 2:
            return chance.choice(('0x', '0o', '0b', '0X')) + digits
        case 3:
            return f'{digits[:2]}_{digits}'
        case 4:
            return ':'.join((digits, chance.choice(DIGITS), '30'))
        case 5:
            return f'{chance.choice("+-")}{digits}.{digits}'
        case 6:
            return f'{digits}{chance.choice(("e", "E", "e+", "e-", "d", "f"))}{digits[:3]}'
        case 7:
            return chance.choice(('.5', '5.', '-.5', '+.5', '.', '-', '+', '1.', '.e3', '1.e3'))
        case 8:
            return chance.choice(('.inf', 'inf', 'NaN', '.nan', '1/3', '1,5', '1 000', '½', '１'))
        case 9:
            return f'"{digits}"' if chance.random() < 0.5 else f"!!float '{digits}'"
        case 10:
            return f'{digits[:4]}-{digits[:2]}-{digits[:2]}'
        case 11:
            return repr(chance.uniform(-1, 1) * 10.0 ** chance.randrange(-300, 300))
        case 12:
            return f'!!int "{digits}"'
        case _:
            return ''.join(chance.choice(DIGITS + '+-.eE_:x') for _ in range(6))


def _is_decimal(text: str) -> bool:
    """Tell by hand, not by the pattern under test, whether JSON or C calls a text a number."""
    body = text.removeprefix('-' if text.startswith('-') else '+')
    mantissa, _, exponent = body.lower().partition('e')
    whole, _, rest = mantissa.partition('.')
    leads = len(whole) > 1 and whole.startswith('0')
    in_digits = set(whole + rest + exponent.lstrip('+-')) <= set(DIGITS)
    return bool(whole + rest) and in_digits and not leads


def _scene(chance: random.Random) -> Scene:
    """Make a sound scene of records, then spoil up to two fields."""
    spoilt = chance.randrange(3)

    def field(name: str, sound: Any) -> Any:
        nonlocal spoilt
        if spoilt and chance.random() < 0.05:
            spoilt -= 1
            return chance.choice(JUNK + ODD)
        return sound

    def made(kind: type, **given: Any) -> Any:
        return kind(**{name: field(name, value) for name, value in given.items()})

    def motion() -> Motion:
        return made(Motion, position=(0.0, chance.random(), 1.0), velocity=(0.0, 1.0, 0.0))

    shape = made(Box, size=(1.0, 2.0, 3.0))
    box = made(
        Body, name='box', shape=shape, mass=2.0, inertia=np.diag([1.0, 1.5, 2.0]),
        center_of_mass=(0.0, 0.0, 0.0), fixed=False, initial=motion(), material=made(Material),
        shape_position=(0.0, 0.0, 0.0), shape_orientation=(0.0, 0.0, 0.0, 1.0),
    )  # fmt: skip
    ball = made(
        Body, name='ball', shape=chance.choice((None, Particle())), mass=0.5, initial=motion(),
        mass_flow=made(MassFlow, rate=-0.01, exhaust_velocity=(0.0, 0.0, -1.0)),
    )  # fmt: skip
    wall = made(Body, name='wall', shape=made(Plane, normal=(0, 0, 1)), mass=0.0, fixed=True)
    top = made(
        Body, name='top', shape=made(Capsule, radius=0.1, length=1.0), mass=1.0,
        inertia=np.diag([1.0, 1.0, 0.5]),
        pivot=made(Pivot, point=(0.0, 0.0, -0.5), at=(0.0, 0.0, 0.0)),
    )  # fmt: skip
    ends = ('box', 'ball', 'top', 'world', 'wall')
    forces = (
        made(FORCES['spring'], a=chance.choice(ends), b=chance.choice(ends), stiffness=10.0),
        made(FORCES['bumper'], a='box', b='ball', stiffness=10.0, length=0.1),
        made(FORCES['drag'], body='box', linear=0.1, angular=0.1),
        made(FORCES['constant'], body='box', force=(0, 0, 1), torque=(0, 0, 0), frame='body'),
        made(FORCES['time'], body='ball', table=((0, 0, 0, 1), (1, 0, 0, 2))),
        made(FORCES['gravity'], among=('box', 'ball')),
    )
    bodies = [box, ball, wall, top, made(Sphere, radius=1.0)][: 4 + (chance.random() < 0.02)]
    return made(
        Scene, name='records', dt_ns=1_000_000, bodies=tuple(bodies), integrator='rk4',
        integrator_options={}, gravity=(0.0, 0.0, -9.81), contact={'mode': 'none'},
        forces=tuple(chance.sample(forces, chance.randrange(3))),
    )  # fmt: skip


def _use(simulation: Simulation, chance: random.Random) -> None:
    """Command and step it; a third of the arguments are junk."""

    def argument(sound: Any) -> Any:
        return chance.choice(JUNK + ODD) if chance.random() < 0.1 else sound

    if chance.random() < 0.3:
        simulation.set_wrench(argument('box'), force=argument((1, 0, 0)), frame=argument('body'))
        simulation.apply_impulse(
            argument('box'), linear=argument((0, 1, 0)), angular=argument((0, 0, 1))
        )
        simulation.hold(argument('box'), argument('force'), force=(1, 0, 0), until=argument(5))
    if chance.random() < 0.2:
        simulation.step(2)
        simulation.energy()
        simulation.angular_momentum()


def _too_long(*_: object) -> None:
    raise TooLong


def main() -> int:
    """Run the cases and print how they ended."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--cases', type=int, default=60_000)
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--first', type=int, default=0, help='number of the first case')
    parser.add_argument('--only', type=int, help='repeat this case')
    arguments = parser.parse_args()
    signal.signal(signal.SIGALRM, _too_long)
    signal.signal(signal.SIGPROF, _too_long)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    fuzz = Fuzz(arguments.seed)
    if arguments.only is not None:
        print(fuzz.run(arguments.only))
        return 0
    ended: Counter[str] = Counter()
    started, slowest = time.monotonic(), (0.0, 0)
    for case in range(arguments.first, arguments.first + arguments.cases):
        begun = time.process_time()
        said = fuzz.run(case)
        slowest = max(slowest, (time.process_time() - begun, case))
        ended[said.partition(':')[0]] += 1
        if said.startswith('failed'):
            print(f'seed {arguments.seed} case {case}: {said}', flush=True)
    wall = time.monotonic() - started
    counts = ', '.join(f'{ended[kind]} {kind}' for kind in ('accepted', 'refused', 'failed'))
    print(f'{arguments.cases} cases: {counts}; {wall:.0f} s')
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f'the slowest took {slowest[0]:.1f} s: case {slowest[1]}; {memory:.0f} MiB at most')
    return 1 if ended['failed'] else 0


if __name__ == '__main__':
    sys.exit(main())
