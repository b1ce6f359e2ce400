# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Every key of a scene: what it holds, its unit, default and limits, and what it means.

Readers take their lists of known keys from here; `tools/scene_reference.py` makes
docs/scene_reference.md and config/scene.schema.json of it. What records say of themselves is taken
from them: force elements (`physics.forces`), settings of contact, options of integrators, contact
material. `test/scene/test_scene_grammar.py` tries every unit, limit and default on the reader.
"""

from __future__ import annotations

import dataclasses
import inspect
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from rigid_body_sim.physics.model.density_laws import ALONG
from rigid_body_sim.physics.model.inertia_over_time import INTERPOLATIONS
from rigid_body_sim.physics.model.material import MATERIAL, USUAL
from rigid_body_sim.physics.model.prescribed_motion import LONG_ROW, SHORT_ROW, UNITS, WAYS
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.model.tick_length import LONGEST_NS
from rigid_body_sim.physics.validation import LONGEST_NAME, LONGEST_TITLE, RESERVED
from rigid_body_sim.scene.convex_parts import CONCAVITY, LEAST, MOST


@dataclass(frozen=True)
class Number:
    """One finite number [unit]; `positive`: zero is refused too."""

    unit: str
    minimum: float | None = None
    maximum: float | None = None
    positive: bool = False


@dataclass(frozen=True)
class Whole:
    """One whole number."""

    minimum: int
    maximum: int | None = None


@dataclass(frozen=True)
class Numbers:
    """A list of so many numbers, each as `each` says."""

    count: int
    each: Number | Whole


@dataclass(frozen=True)
class Rows:
    """
    A table: at least so many rows of numbers, all of one of these widths.

    columns : what each number of a row is, where there is one width
    """

    widths: tuple[int, ...]
    units: str
    least: int
    columns: tuple[Number, ...] = ()


@dataclass(frozen=True)
class Words:
    """One of these words."""

    choices: tuple[str, ...]


@dataclass(frozen=True)
class Text:
    """A text; `pattern` as JSON Schema writes one."""

    what: str
    pattern: str = ''
    longest: int | None = None


@dataclass(frozen=True)
class Truth:
    """The value true or false."""


@dataclass(frozen=True)
class Only:
    """This value and no other."""

    value: Any


@dataclass(frozen=True)
class ListOf:
    """A list of at least so many."""

    each: Any
    least: int = 0
    most: int | None = None


@dataclass(frozen=True)
class Either:
    """One of several kinds."""

    kinds: tuple[Any, ...]


@dataclass(frozen=True)
class Named:
    """A mapping of names to values of one kind, which may be empty."""

    each: Any
    pattern: str


@dataclass(frozen=True)
class Part:
    """A mapping described elsewhere in the grammar, by its name there."""

    name: str
    without: tuple[str, ...] = ()


@dataclass(frozen=True)
class Key:
    """
    One key of a mapping.

    default : what holds where the key is absent; None: nothing, or `otherwise` in words
    """

    kind: Any
    meaning: str
    required: bool = False
    default: Any = None
    otherwise: str = ''


@dataclass(frozen=True)
class Rule:
    """
    Something that keys say of each other, beside what each says of itself.

    A key is told as `mass`, one further in as `initial.orientation`, a value of it as `fixed=true`
    or `contact=none`, the type of a shape as `shape=box`.

    given, absent : when it is asked: where one of these is there, and none of those
    needs         : all of these must then be there
    any_of        : one of these must
    excludes      : none of these may
    positive      : this number must be positive, if it is there
    """

    sentence: str
    given: tuple[str, ...] = ()
    absent: tuple[str, ...] = ()
    needs: tuple[str, ...] = ()
    any_of: tuple[str, ...] = ()
    excludes: tuple[str, ...] = ()
    positive: str = ''


@dataclass(frozen=True)
class Mappings:
    """
    A mapping with these keys; or, with `variants`, one of several told apart by the key `tag`.

    default_tag : the variant where `tag` is absent; None: it must be there
    ignored     : how keys begin that nobody reads; empty: none do
    """

    about: str
    keys: Mapping[str, Key] = field(default_factory=dict)
    rules: tuple[Rule, ...] = ()
    tag: str = ''
    variants: Mapping[str, Mappings] = field(default_factory=dict)
    default_tag: str | None = None
    ignored: str = ''


LEAST_DT, LARGEST_DT = 1e-9, float(LONGEST_NS // 10**9)  # [s]
_reserved = '|'.join(RESERVED)
NAME_PATTERN = f'^(?!(?:{_reserved})$)(?!.*__)[A-Za-z][A-Za-z0-9_]*$'
NAME = Text('a letter, then letters, digits and single underscores', NAME_PATTERN, LONGEST_NAME)
BODY_NAME = Text('name of a body')
M, KG_M2 = Number('m'), Number('kg m^2')
MOMENT = Number('kg m^2', positive=True)
LENGTH = Number('m', positive=True)
POSITION, VELOCITY = Numbers(3, M), Numbers(3, Number('m/s'))
SPIN = Numbers(3, Number('rad/s'))
QUATERNION = Numbers(4, Number('-'))
NO_TURN, ZERO = [0, 0, 0, 1], [0, 0, 0]
MASS = ('mass', 'density', 'inertia', 'center_of_mass')
FLOW = ('mass_rate', 'exhaust_velocity', 'final_mass')
SOLIDS = ('sphere', 'box', 'cylinder', 'capsule', 'convex_hull', 'mesh')
WITH_VOLUME = (*SOLIDS, 'union', 'particles', 'plane', 'heightfield')
SPINS = ('angular_velocity', 'angular_velocity_body')
SAID_BY_URDF = ('shape', *MASS, *FLOW, 'inertia_over_time')
MOST_COPIES = 100_000  # [-] more is a slip of the pen, and would fill the memory

SCENE = Mappings(
    'One YAML file is one experiment. SI units, z up, quaternions xyzw.',
    {
        'version': Key(Only(1), 'version of this language of scenes', default=1),
        'name': Key(
            Text('one line of text', longest=LONGEST_TITLE),
            'what reports, pictures and bags call it',
            otherwise='the name of the file',
        ),
        'dt': Key(
            Number('s', minimum=LEAST_DT, maximum=LARGEST_DT),
            'length of a tick, a whole number of nanoseconds',
            required=True,
        ),
        'integrator': Key(
            Part('integrator'),
            'name of the method, or a mapping of its name and options',
            default=Scene.integrator,
        ),
        'orientation': Key(
            Either((Words(('quaternion', 'matrix')), Part('orientation'))),
            'how a Runge–Kutta method keeps orientation; short for its option of that name',
            default=None,
            otherwise='quaternion',
        ),
        'gravity': Key(
            Numbers(3, Number('m/s^2')), 'acceleration of free fall, world', default=ZERO
        ),
        'contact': Key(Part('contact'), 'whether bodies meet, and how', default={'mode': 'none'}),
        'bodies': Key(ListOf(Part('body'), least=1), 'the bodies', required=True),
        'forces': Key(ListOf(Part('force')), 'forces beside gravity and commands', default=[]),
    },
    ignored='x-',
)

ORIENTATION = Mappings(
    'How a Runge–Kutta method keeps orientation.',
    {
        'representation': Key(Words(('quaternion', 'matrix')), 'the state', required=True),
        'reorthonormalise': Key(
            Truth(), 'bring a matrix back to a rotation after each step', default=False
        ),
    },
)

INITIAL = Mappings(
    'Motion at t = 0.',
    {
        'position': Key(POSITION, 'of the centre of mass, world', default=ZERO),
        'orientation': Key(
            QUATERNION, 'xyzw, body to world; scaled to length one', default=NO_TURN
        ),
        'velocity': Key(
            VELOCITY,
            'of the centre of mass, world axes; with `motion` that of the point that follows the '
            'path, for the whole run, and waves and table come on top',
            default=ZERO,
        ),
        'angular_velocity': Key(
            SPIN,
            'world axes; with `motion` for the whole run, and roll, pitch and yaw come on top',
            default=ZERO,
        ),
        'angular_velocity_body': Key(SPIN, 'body axes', otherwise='angular_velocity counts'),
    },
    (Rule('one of the two angular velocities, not both', given=SPINS[:1], excludes=SPINS[1:]),),
)

INERTIA = Mappings(
    'Tensor about the centre of mass in body axes; ixy is minus the integral of x y dm.',
    {
        **{key: Key(MOMENT, 'moment of inertia', required=True) for key in ('ixx', 'iyy', 'izz')},
        **{key: Key(KG_M2, 'element of the tensor', default=0) for key in ('ixy', 'ixz', 'iyz')},
    },
)

INERTIA_OVER_TIME = Mappings(
    'Moments of inertia that change at constant mass; body axes are principal axes.',
    {
        'table': Key(
            Rows((4,), 's, kg m^2', least=2, columns=(Number('s'), MOMENT, MOMENT, MOMENT)),
            'rows [time, ixx, iyy, izz]',
            required=True,
        ),
        'interpolation': Key(
            Words(tuple(INTERPOLATIONS)),
            'smooth: each moment comes to rest at every row',
            default='smooth',
        ),
    },
)

FRAME = Mappings(
    'Axes fixed to a body, in which commands may be given.',
    {
        'position': Key(POSITION, 'from the centre of mass, body axes', default=ZERO),
        'orientation': Key(QUATERNION, 'xyzw, frame to body', default=NO_TURN),
    },
)

PIVOT = Mappings(
    'The point about which a body turns.',
    {
        'point': Key(POSITION, 'in shape coordinates', required=True),
        'at': Key(POSITION, 'where it is in the world', otherwise='where `initial` puts it'),
    },
)

REPEAT = Mappings(
    'Copies on a grid: box becomes box_1, box_2, …, x running fastest, then y, then z.',
    {
        'count': Key(
            Numbers(3, Whole(1)),
            f'copies along x, y, z; at most {MOST_COPIES} together',
            required=True,
        ),
        'spacing': Key(POSITION, 'between neighbours along x, y, z', required=True),
        'jitter': Key(
            Number('m', minimum=0.0),
            'shifts each copy by less than this along each axis, always alike',
            default=0,
        ),
    },
)


def _wave(unit: str) -> Mappings:
    return Mappings(
        'amplitude · sin(2π t / period + phase).',
        {
            'amplitude': Key(Number(unit), 'amplitude', required=True),
            'period': Key(Number('s', positive=True), 'period', required=True),
            'phase': Key(Number('rad'), 'phase at t = 0', default=0),
        },
    )


WAVE = {unit: _wave(unit) for unit in ('m', 'rad')}
WAY_MEANINGS = ('along x', 'along y', 'along z', 'about x', 'about y', 'about z')
MOTION = Mappings(
    'Moves a body as told, whatever acts on it; without keys it goes on as `initial` says.',
    {
        **{
            way: Key(
                Either((Part(f'wave [{unit}]'), ListOf(Part(f'wave [{unit}]')))),
                f'wave {meaning} of the world, or a list of waves that add',
            )
            for way, unit, meaning in zip(WAYS, UNITS, WAY_MEANINGS, strict=True)
        },
        'table': Key(
            Rows((SHORT_ROW, LONG_ROW), 's, m, rad', least=2),
            'rows [t, x, y, z] or [t, x, y, z, roll, pitch, yaw]; a smooth spline, at rest at '
            'both ends',
        ),
        'point': Key(
            POSITION,
            'follows the path, and about it the body turns; shape coordinates',
            otherwise='the centre of mass',
        ),
    },
)

BODY = Mappings(
    'One body. Its position is everywhere that of its centre of mass.',
    {
        'name': Key(NAME, 'first part of the names of its topics', required=True),
        'shape': Key(Part('shape'), 'what it looks like and collides as', otherwise='none'),
        'mass': Key(Number('kg', minimum=0.0), 'mass; of what moves positive'),
        'density': Key(
            Either((Number('kg/m^3', positive=True), Part('density'))),
            'in place of mass: a number, or a law over space',
        ),
        'inertia': Key(Part('inertia'), 'replaces that of the shape', otherwise='of the shape'),
        'center_of_mass': Key(
            POSITION,
            'replaces that of the shape, whose tensor about its own centre stays, not shifted, '
            'where no `inertia` is given; in shape coordinates',
            otherwise='of the shape',
        ),
        'mass_rate': Key(Number('kg/s'), 'rate of change of the mass; negative: it loses'),
        'exhaust_velocity': Key(
            Either((Number('m/s', minimum=0.0), VELOCITY)),
            'of the mass that leaves, relative to the body: in body axes, or its speed along -z',
            default=ZERO,
        ),
        'final_mass': Key(
            Number('kg', positive=True), 'at which the flow ends', otherwise='no end'
        ),
        'inertia_over_time': Key(
            Part('inertia_over_time'), 'in place of inertia; needs a method that follows it'
        ),
        'fixed': Key(Truth(), 'immovable', default=False),
        'motion': Key(Part('motion'), 'moves as told, whatever acts on it'),
        'surface_velocity': Key(
            VELOCITY, 'of the surface of a fixed body, body axes: a conveyor', default=ZERO
        ),
        'pivot': Key(Part('pivot'), 'the point about which it turns', otherwise='free'),
        'initial': Key(Part('initial'), 'motion at t = 0', default={}),
        'frames': Key(
            Named(Part('frame'), NAME_PATTERN),
            'axes fixed to the body by name: thrusters, rotors, sensors',
            default={},
        ),
        **{
            key: Key(
                Number(known.unit, minimum=known.least, maximum=known.most),
                f'{known.meaning}; of two bodies {known.of_two.said} counts',
                default=getattr(USUAL, key),
            )
            for key, known in MATERIAL.items()
        },
        'urdf': Key(Text('path of a URDF file'), 'says shape and mass properties in their place'),
        'repeat': Key(Part('repeat'), 'makes copies on a grid', otherwise='one body'),
    },
    (
        Rule(
            'it has a shape, an inertia or a URDF file, or is fixed',
            any_of=('shape', 'inertia', 'inertia_over_time', 'urdf', 'fixed=true', 'motion'),
        ),
        Rule(
            'what may move needs a mass, or a density; unions and `particles` have those of their '
            'parts, planes and ground none',
            given=tuple(f'shape={shape}' for shape in SOLIDS),
            absent=('fixed=true', 'motion'),
            any_of=('mass', 'density'),
        ),
        Rule(
            'what may move and has no volume needs a mass',
            absent=('urdf', 'fixed=true', 'motion', *(f'shape={shape}' for shape in WITH_VOLUME)),
            needs=('mass',),
        ),
        Rule(
            'the mass of what may move is positive',
            absent=('fixed=true', 'motion'),
            positive='mass',
        ),
        Rule(
            'a plane and a height field have no mass',
            given=('shape=plane', 'shape=heightfield'),
            excludes=MASS,
        ),
        Rule('a plane is one plane', given=('shape=plane',), excludes=('repeat',)),
        Rule(
            'a height field, and a mesh as triangles, is fixed',
            given=('shape=heightfield',),
            needs=('fixed=true',),
        ),
        Rule(
            'a particle is a point mass: it does not rotate',
            given=('shape=particle',),
            excludes=(
                'inertia',
                'center_of_mass',
                'inertia_over_time',
                'frames',
                'initial.orientation',
                *(f'initial.{spin}' for spin in SPINS),
            ),
        ),
        Rule(
            'the exhaust and the final mass of a flow need its rate',
            given=FLOW[1:],
            needs=('mass_rate',),
        ),
        Rule('a URDF file says what the body is', given=('urdf',), excludes=SAID_BY_URDF),
        Rule('what moves as told is not fixed', given=('motion',), excludes=('fixed',)),
        Rule(
            'one of inertia and inertia_over_time',
            given=('inertia_over_time',),
            excludes=('inertia',),
        ),
        Rule('copies cannot share a pivot', given=('pivot',), excludes=('repeat',)),
    ),
)

_ROUND = {
    'radius': Key(LENGTH, 'radius', required=True),
    'length': Key(LENGTH, 'along z; of a capsule between the centres of its caps', required=True),
}
FILE = Text('path, from the folder of the scene, or package://NAME/PATH')
PART_KEYS = {
    'shape': Key(Part('shape', without=('plane', 'heightfield')), 'of this part', required=True),
    'mass': Key(Number('kg', positive=True), 'of this part'),
    'density': Key(Number('kg/m^3', positive=True), 'in place of mass'),
    'position': Key(POSITION, 'of the origin of its shape', default=ZERO),
    'orientation': Key(QUATERNION, 'xyzw, of its axes', default=NO_TURN),
}
SHAPES = {
    'particle': Mappings('A point mass: no orientation, no contact.'),
    'sphere': Mappings('A ball about the origin.', {'radius': _ROUND['radius']}),
    'box': Mappings(
        'A box about the origin.',
        {'size': Key(Numbers(3, LENGTH), 'edge lengths along x, y, z', required=True)},
    ),
    'cylinder': Mappings('A cylinder along z about the origin.', _ROUND),
    'capsule': Mappings('A cylinder along z with a half ball at each end.', _ROUND),
    'convex_hull': Mappings(
        'The convex hull of points; its volume gives the mass properties.',
        {'vertices': Key(ListOf(POSITION, least=4), 'the points', required=True)},
    ),
    'mesh': Mappings(
        'A closed surface in a file; its volume gives the mass properties.',
        {
            'file': Key(FILE, 'an .off, .stl, .obj or .ply file', required=True),
            'as': Key(
                Words(('hull', 'parts', 'triangles')),
                'what collides: its convex hull, convex parts (CoACD), or, of what is fixed, its '
                'triangles',
                default='hull',
            ),
            'concavity': Key(
                Number('-', minimum=LEAST, maximum=MOST),
                'how near convex parts come',
                default=None,
                otherwise=f'{CONCAVITY:g}',
            ),
        },
    ),
    'heightfield': Mappings(
        'Ground over a grid, of a fixed body: rows along y, columns along x.',
        {
            'heights': Key(
                ListOf(ListOf(M, least=2), least=2), 'rows of as many heights',
                otherwise='of the file',
            ),
            'file': Key(Text('path of a .csv, .txt or .npy file'), 'heights in a table'),
            'spacing': Key(
                Either((LENGTH, Numbers(2, LENGTH))),
                'between points; two numbers: along x, along y',
                required=True,
            ),
            'origin': Key(POSITION, 'of the first point', default=ZERO),
        },
        (
            Rule('it has heights, or a file of them', any_of=('heights', 'file')),
            Rule('and not both', given=('heights',), excludes=('file',)),
        ),
    ),
    'particles': Mappings(
        'Point masses joined rigidly; mass, centre and inertia are sums.',
        {'particles': Key(ListOf(Part('point mass'), least=1), 'the masses', required=True)},
    ),
    'plane': Mappings(
        'The half space below a plane, always fixed and without mass.',
        {
            'normal': Key(Numbers(3, Number('-')), 'out of the solid', required=True),
            'offset': Key(M, 'of the plane along the normal', default=0),
        },
    ),
    'union': Mappings(
        'Several shapes joined; mass, centre and inertia are sums, and each part collides.',
        {'parts': Key(ListOf(Part('part'), least=1), 'the parts', required=True)},
    ),
}  # fmt: skip
DENSITIES = {
    'linear': Mappings(
        'A density that changes evenly over space, in shape coordinates.',
        {
            'at_origin': Key(Number('kg/m^3'), 'at the origin', required=True),
            'gradient': Key(Numbers(3, Number('kg/m^4')), 'its change', required=True),
        },
    ),
    'polynomial': Mappings(
        'A sum of c x^i y^j z^k.',
        {'terms': Key(ListOf(Part('term')), 'the terms', required=True)},
    ),
    'table': Mappings(
        'A density given along an axis or a radius; linear between the rows.',
        {
            'along': Key(
                Words(tuple(ALONG)),
                'x, y, z of a box, z of a cylinder, radius of a sphere',
                required=True,
            ),
            'rows': Key(
                Rows(
                    (2,),
                    'm, kg/m^3',
                    least=2,
                    columns=(M, Number('kg/m^3', minimum=0.0)),
                ),
                'rows [place, density]',
                required=True,
            ),
        },
    ),
}
TERM = Mappings(
    'c x^i y^j z^k.',
    {
        'coefficient': Key(Number('kg/m^(3 + i + j + k)'), 'c', required=True),
        'powers': Key(Numbers(3, Whole(0)), '[i, j, k]', required=True),
    },
)
POINT_MASS = Mappings(
    'A point mass of `particles`.',
    {
        'mass': Key(Number('kg', positive=True), 'mass', required=True),
        'position': Key(POSITION, 'in shape coordinates', required=True),
    },
)
PAIR = Mappings(
    'Material of a pair of bodies, in place of what theirs give.',
    {
        'bodies': Key(ListOf(BODY_NAME, least=2, most=2), 'the two', required=True),
        **{
            key: Key(BODY.keys[key].kind, 'of this pair', otherwise='of the two bodies')
            for key in MATERIAL
        },
    },
)

FORCE_MEANINGS = {
    'a': 'one end: a body, or world',
    'b': 'the other end: a body, or world',
    'body': 'on which it acts',
    'stiffness': 'k',
    'damping': 'c, along the line of the ends; without rest_length in every direction',
    'rest_length': 'length without force',
    'length': 'below which it pushes',
    'a_point': 'where it acts on a: shape coordinates, of the world in the world',
    'b_point': 'where it acts on b: shape coordinates, of the world in the world',
    'force': 'force',
    'torque': 'torque',
    'frame': 'axes of force and torque',
    'point': 'where the force acts, shape coordinates',
    'linear': 'force per speed',
    'quadratic': 'force per square of the speed',
    'angular': 'torque per angular velocity',
    'angular_quadratic': 'torque per square of the angular velocity',
    'among': 'bodies that attract each other',
    'constant': 'constant of gravity',
    'softening': 'length that keeps the force finite where bodies meet',
    'table': 'rows [t, fx, fy, fz] or [t, fx, fy, fz, tx, ty, tz]; times ascend',
    'interpolation': 'between the rows; cubic: the twice continuously differentiable spline that '
    'is not-a-knot, one cubic over the first two intervals and one over the last two; of three '
    'rows a parabola, of two a line',
    'outside': 'before the first row and after the last',
}
OTHERWISE = {'bodies': 'all', 'point': 'the centre of mass'}
OPTION_MEANINGS = {
    'substeps': 'steps of the method in a tick',
    'rtol': 'error allowed in a step, of the length of each vector of the state',
    'atol': 'error allowed in a step, in the SI unit of each vector',
    'orientation': 'the state of orientation',
    'reorthonormalise': 'bring a matrix back to a rotation after each step',
    'drift': 'free rotation between the kicks',
    'tolerance': 'error allowed at the end, of positions [m] and angles [rad]',
    'horizon': 'simulated time that a choice looks ahead [s]',
    'longer_steps': 'let `simulate` take longer ticks than the dt of the scene',
}


def forces() -> Mappings:
    """Describe the force elements by what their records say of their fields."""
    from rigid_body_sim.physics.forces.elements import FORCES

    variants = {}
    for name, found in FORCES.items():
        element: Any = found
        keys = {}
        for each in dataclasses.fields(element):
            missing, known = dataclasses.MISSING, each.metadata
            default = None if each.default in (missing, ()) else each.default
            keys[each.name] = Key(
                _force_kind(known),
                FORCE_MEANINGS[each.name],
                required=each.default is missing and known['kind'] != 'bodies',
                default=list(default) if isinstance(default, tuple) else default,
                otherwise=OTHERWISE.get(known['kind'], '') if default is None else '',
            )
        variants[name] = Mappings(_first_sentence(element), keys)
    return Mappings('One force; the key `type` says which.', tag='type', variants=variants)


def _force_kind(known: Mapping[str, Any]) -> Any:
    number = Number(known.get('unit') or '-', known.get('minimum'), None,
                    known.get('positive', False))  # fmt: skip
    kinds = {
        'body': BODY_NAME,
        'body_or_world': Text('name of a body, or world'),
        'bodies': ListOf(BODY_NAME),
        'table': Rows((4, 7), known.get('unit') or '-', least=2),
        'choice': Words(tuple(known.get('choices', ()))),
        'point': Numbers(3, number),
        'vector': Numbers(3, number),
        'number': number,
    }
    return kinds[known['kind']]


def _first_sentence(element: Any) -> str:
    return ' '.join((inspect.getdoc(element) or '').split('\n\n')[0].split())


def contact() -> Mappings:
    """Describe contact by the fields of its settings, and what their docstring says of them."""
    from rigid_body_sim.physics.contact.settings import MODES, ContactSettings

    said = _said_of_fields(ContactSettings)
    keys = {
        'mode': Key(
            Words(('none', *MODES)),
            'none: bodies pass through each other; timestep: they meet; event: they meet, and '
            'impacts come at their instants',
            required=True,
        )
    }
    for each in dataclasses.fields(ContactSettings):
        if each.name == 'mode':
            continue
        known = each.metadata
        if each.name == 'ignore':
            kind: Any = ListOf(ListOf(BODY_NAME, least=2))
        elif each.name == 'pairs':
            kind = ListOf(Part('pair'))
        elif isinstance(each.default, bool):
            kind = Truth()
        elif isinstance(each.default, int):
            kind = Whole(known['minimum'], known['maximum'])
        else:
            kind = Number(known['unit'], minimum=known['minimum'])
        default = list(each.default) if isinstance(each.default, tuple) else each.default
        keys[each.name] = Key(kind, said[each.name], default=default)
    settings = tuple(key for key in keys if key != 'mode')
    rule = Rule('settings are those of bodies that meet', given=('mode=none',), excludes=settings)
    return Mappings('Whether bodies meet, and how.', keys, (rule,))


CONTACT_MEANINGS = {
    'ignore': 'lists of bodies of which no two meet; copies of a repeated body by its name',
    'pairs': 'pairs with a material of their own',
}


def _said_of_fields(record: type) -> dict[str, str]:
    """Read what a docstring says of each field: `name : text`, continued further in."""
    said: dict[str, str] = dict(CONTACT_MEANINGS)
    name = ''
    for line in (inspect.getdoc(record) or '').splitlines():
        begun = re.match(r'(\w+)\s*: (.*)', line)
        if begun:
            name = begun.group(1)
            said[name] = re.sub(r'^\[[^]]*\] ', '', begun.group(2))
        elif name and line.startswith('    '):
            said[name] += f' {line.strip()}'
        else:
            name = ''
    return {key: re.sub(r', see\s+`[\w.]+`', '', text) for key, text in said.items()}


def integrators() -> Mappings:
    """Describe the integrators by their options."""
    from rigid_body_sim.physics.integration import choose
    from rigid_body_sim.physics.integration.integrators import INTEGRATORS

    variants = {}
    for name in (*INTEGRATORS, choose.NAME):
        options = choose.OPTIONS if name == choose.NAME else INTEGRATORS[name].options
        about = (
            'The cheapest method that meets a tolerance.'
            if name == choose.NAME
            else f'Order {INTEGRATORS[name].order}; keeps: {INTEGRATORS[name].keeps}.'
        )
        keys = {key: _option(key, option) for key, option in options.items()}
        variants[name] = Mappings(about, keys)
    return Mappings('One method; the key `name` says which.', tag='name', variants=variants)


def _option(name: str, option: Any) -> Key:
    if option.choices:
        kind: Any = Words(tuple(option.choices))
    elif isinstance(option.default, bool):
        kind = Truth()
    elif isinstance(option.default, int):
        kind = Whole(int(option.minimum), int(option.maximum))
    else:
        kind = Number('-', minimum=option.minimum, maximum=option.maximum)
    return Key(kind, OPTION_MEANINGS[name], default=option.default)


def grammar() -> dict[str, Mappings]:
    """Give every mapping of a scene by its name; that of the whole is `scene`."""
    return {
        'scene': SCENE,
        'integrator': integrators(),
        'orientation': ORIENTATION,
        'contact': contact(),
        'pair': PAIR,
        'body': BODY,
        'initial': INITIAL,
        'inertia': INERTIA,
        'inertia_over_time': INERTIA_OVER_TIME,
        'density': Mappings(
            'A law of density over space.',
            tag='type',
            variants=DENSITIES,
            default_tag='linear',
        ),
        'term': TERM,
        'pivot': PIVOT,
        'frame': FRAME,
        'motion': MOTION,
        'wave [m]': WAVE['m'],
        'wave [rad]': WAVE['rad'],
        'repeat': REPEAT,
        'shape': Mappings('One shape.', tag='type', variants=SHAPES),
        'part': Mappings(
            'A part of a `union`.',
            PART_KEYS,
            (Rule('mass or density, not both', given=('mass',), excludes=('density',)),),
        ),
        'point mass': POINT_MASS,
        'force': forces(),
    }
