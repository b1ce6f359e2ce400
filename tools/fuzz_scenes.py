# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Attack what reads scenes: `python tools/fuzz_scenes.py [--cases 60000] [--seed 1]`.

Four kinds of cases, by turns: shipped scenes with damaged text; shipped scenes with damaged trees,
as mappings; one number of a scene written in any way; records made in Python with junk in a field.
Each must be accepted, or refused by one printable line of the package's own exceptions, within
seconds and without a warning; a number that is accepted must be what JSON and C call it. Every
tenth scene that is accepted is also made a simulation and stepped. A case is made of the seed and
its number alone: --only N repeats it and shows what failed. Exit code 1 where a case failed.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import random
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
from rigid_body_sim.scene.shipped_scenes import shipped_scenes

PATIENCE = 20  # [s] for one case
STEPPED = 10  # every so many accepted scenes are stepped
LARGE = 3000  # [byte] larger scenes come in a tenth of the cases
MANY = 60  # [-] bodies; scenes of more are read only

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
        self._kinds: tuple[Callable[[random.Random], Any], ...] = (
            self._damaged_text,
            self._damaged_tree,
            self._number,
            self._record,
        )

    def run(self, case: int) -> str:
        """Return 'accepted', 'refused', or what went wrong, after 'failed: '."""
        chance = random.Random(f'{self._seed} {case}')
        kind = self._kinds[case % len(self._kinds)]
        signal.alarm(PATIENCE)
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
            signal.alarm(0)

    def _pick(self, chance: random.Random) -> int:
        anywhere = chance.random() < 0.1
        return chance.choice(range(len(self._texts)) if anywhere else self._small)

    def _damaged_text(self, chance: random.Random) -> str:
        scene = self._pick(chance)
        text = bytearray(self._texts[scene])
        for _ in range(chance.choice((1, 1, 1, 2, 3, 8))):
            _damage(text, chance)
        return self._take(bytes(text), chance, folder=self._folders[scene])

    def _damaged_tree(self, chance: random.Random) -> str:
        scene = self._pick(chance)
        tree = yaml.safe_load(self._texts[scene])
        for _ in range(chance.choice((1, 1, 1, 2, 3))):
            _graft(tree, chance)
        return self._take(tree, chance, folder=self._folders[scene])

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
        is_small = len(scene.bodies) <= MANY and scene.contact['mode'] == 'none'
        if is_small and chance.randrange(STEPPED) == 0:
            Simulation(scene, integrator='rk4').step(2)
        return 'accepted'


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
    fuzz = Fuzz(arguments.seed)
    if arguments.only is not None:
        print(fuzz.run(arguments.only))
        return 0
    ended: Counter[str] = Counter()
    started, slowest = time.monotonic(), (0.0, 0)
    for case in range(arguments.first, arguments.first + arguments.cases):
        begun = time.monotonic()
        said = fuzz.run(case)
        slowest = max(slowest, (time.monotonic() - begun, case))
        ended[said.partition(':')[0]] += 1
        if said.startswith('failed'):
            print(f'seed {arguments.seed} case {case}: {said}', flush=True)
    wall = time.monotonic() - started
    counts = ', '.join(f'{ended[kind]} {kind}' for kind in ('accepted', 'refused', 'failed'))
    print(f'{arguments.cases} cases: {counts}; {wall:.0f} s')
    print(f'the slowest took {slowest[0]:.1f} s: case {slowest[1]}')
    return 1 if ended['failed'] else 0


if __name__ == '__main__':
    sys.exit(main())
