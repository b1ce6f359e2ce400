# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
`inspect SCENE`: what a scene holds, before it runs.

Mass, centre of mass, inertia tensor and principal axes of every body; what the scene asks of an
integrator; and what each of them may do at its dt: refused and why, or within which limits.
"""

from __future__ import annotations

import argparse
import json
import re
from collections.abc import Iterator
from dataclasses import asdict, replace
from itertools import groupby
from typing import Any

from rigid_body_sim.analysis.scene_facts import (
    BodyFacts,
    IntegratorFacts,
    able_integrator,
    bodies_of,
    integrators_of,
    moment_of,
    needs_of,
)
from rigid_body_sim.command_line import decimal
from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.diagnostics.numerical_damping import NumericalDamping
from rigid_body_sim.physics.diagnostics.step_limits import StabilityWatch
from rigid_body_sim.physics.integration.integrators import INTEGRATORS
from rigid_body_sim.physics.model.rotation import IDENTITY
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.model.tick_length import tick_nanoseconds
from rigid_body_sim.physics.state.layout import Layout
from rigid_body_sim.physics.state.snapshot import State, StateReader
from rigid_body_sim.runs.simulation_of_scene import simulation_of
from rigid_body_sim.scene import load_scene
from rigid_body_sim.scene.shipped_scenes import find_scene

SUMMARY = 'mass, inertia and axes of every body; what each integrator may do at this dt'
NUMBER = re.compile(r'-[\d.]')
STEPS = {'rotation': 'h|w|', 'oscillation': 'h w', 'relaxation': 'h k'}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command line."""
    parser._negative_number_matcher = NUMBER  # argparse's own takes -1e-3 for an option
    parser.add_argument(
        'scene', help='scene file (YAML), URDF file of one link, or the name of a shipped scene'
    )
    parser.add_argument(
        '--dt', type=float, metavar='S', help='tick length [s], default: of the scene'
    )
    parser.add_argument(
        '--axis',
        nargs=4,
        metavar=('BODY', 'X', 'Y', 'Z'),
        help='moment of inertia of a body about an axis along (X, Y, Z), body axes',
    )
    parser.add_argument(
        '--point',
        nargs=3,
        type=float,
        metavar=('X', 'Y', 'Z'),
        help='a point of that axis [m], shape coordinates; default: the centre of mass',
    )
    parser.add_argument('--json', action='store_true', help='print one JSON object')


def run(arguments: argparse.Namespace) -> int:
    """Print what is known; exit code 0."""
    scene = load_scene(find_scene(arguments.scene))
    # what cannot run is refused here as it is by `simulate`, but for its integrator
    warnings = simulation_of(scene, integrator=able_integrator(scene)).scene_warnings
    dt_ns = scene.dt_ns if arguments.dt is None else tick_nanoseconds(arguments.dt)
    facts = {
        'scene': scene.name,
        'dt': dt_ns / 1e9,
        'bodies': [asdict(facts) for facts in bodies_of(scene)],
        'needs': needs_of(scene),
        'integrator': scene.integrator,
        'integrators': _integrators(scene, dt=dt_ns / 1e9),
        'warnings': list(warnings),
    }
    if arguments.point is not None and arguments.axis is None:
        raise UserError('--point is a point of an axis; give --axis BODY X Y Z too')
    if arguments.axis is not None:
        body, *direction = arguments.axis
        facts['axis'] = moment_of(
            scene, body, direction=_numbers(direction), point=arguments.point
        )
    if arguments.json:
        print(json.dumps(facts))
        return 0
    for line in _lines(scene, facts):
        print(line)
    return 0


def _integrators(scene: Scene, *, dt: float) -> list[dict[str, Any]]:
    """
    Give the facts of every integrator; one that damps the springs of a scene is not recommended.

    damping : what its steps take from a swing, as `NumericalDamping`; None: nothing worth a word
    """
    found = integrators_of(scene, dt=dt)
    layout = Layout(scene)
    begin = StateReader(layout).read(layout.translation(), layout.rotation(), 0.0)
    damping = {facts.name: _damping(scene, facts, dt, layout, begin) for facts in found}
    able = [f for f in found if not (f.refused or f.beyond or f.is_reference)]
    keeping = [f for f in able if damping[f.name] is None]
    good = [f for f in keeping if f.recommended] or keeping or [f for f in able if f.recommended]
    return [
        asdict(replace(facts, recommended=facts in good))
        | {'damping': None if (told := damping[facts.name]) is None else _as_numbers(told)}
        for facts in found
    ]


def _damping(
    scene: Scene, facts: IntegratorFacts, dt: float, layout: Layout, begin: State
) -> NumericalDamping | None:
    """Find what the steps of a method that may be taken take from an oscillation."""
    if facts.refused or facts.beyond or facts.is_reference:
        return None
    given = scene.integrator_options if facts.name == scene.integrator else {}
    integrator = INTEGRATORS[facts.name].configured(given)
    return StabilityWatch(scene, layout, integrator, dt).damping(begin)


def _as_numbers(damping: NumericalDamping) -> dict[str, Any]:
    return {
        'body': damping.body,
        'rate': damping.rate,
        'product': damping.product,
        'per_period': damping.per_period,
        'per_second': damping.per_second,
        'text': damping.text,
    }


def _numbers(words: list[str]) -> list[float]:
    try:
        return [decimal(word) for word in words]
    except argparse.ArgumentTypeError as error:
        raise UserError(f'--axis: {error}; three numbers are needed') from error


def _lines(scene: Scene, facts: dict[str, Any]) -> Iterator[str]:
    yield f'{scene.name}: dt {facts["dt"]:g} s, integrator {scene.integrator}'
    yield ''
    yield from _of_bodies(bodies_of(scene))
    if 'axis' in facts:
        yield ''
        yield from _of_axis(facts['axis'])
    yield ''
    yield from _of_needs(facts['needs'])
    yield ''
    yield from _of_integrators(facts)
    for warning in facts['warnings']:
        yield f'  warning: {warning}'


def _of_bodies(bodies: list[BodyFacts]) -> Iterator[str]:
    yield 'bodies (moments about the centre of mass; axes in body axes)'
    for _, alike in groupby(bodies, key=lambda body: repr({**asdict(body), 'name': ''})):
        body, *more = alike
        also = f' … {more[-1].name} ({len(more) + 1} alike)' if more else ''
        shape = body.kind if body.shape is None else f'{body.shape}, {body.kind}'
        yield f'  {body.name}{also}: {shape}'
        if body.kind == 'fixed' and body.mass is None:
            continue
        yield f'    mass {body.mass:.6g} kg, centre of mass {_vector(body.center_of_mass)} m'
        if body.inertia is None or body.principal_moments is None or body.principal_axes is None:
            continue
        if body.kind == 'point mass':
            yield '    no inertia: where it is takes 3 numbers, and it does not turn'
            continue
        for row, text, unit in zip(
            body.inertia, ('inertia', '', ''), (' kg m^2', '', ''), strict=True
        ):
            yield f'    {text:8}[' + '  '.join(f'{x + 0.0:12.6g}' for x in row) + f']{unit}'
        for i, moment in enumerate(body.principal_moments):
            axis = [row[i] for row in body.principal_axes]
            yield f'    principal moment {moment:.6g} kg m^2 about {_vector(axis)}'
        yield f'    {_freedom(body)}'
        for name, frame in body.frames.items():
            turned = frame['orientation'] != list(IDENTITY)
            also = f', turned by {_vector(frame["orientation"])}' if turned else ''
            yield f'    frame {name} {_vector(frame["position"])} m from the centre of mass{also}'


def _freedom(body: BodyFacts) -> str:
    said = f'{body.degrees_of_freedom} degrees of freedom'
    if body.points is None:
        return f'{said} in place of three for each of its points'
    return (
        f'{said}: {body.points} points have {body.coordinates} coordinates, and rigidity takes '
        f'{body.constraints} of them'
    )


def _of_axis(axis: dict[str, Any]) -> Iterator[str]:
    yield f'axis along {_vector(axis["direction"])} through {_vector(axis["point"])} m'
    yield (
        f'  moment of inertia of {axis["body"]}: {axis["moment"]:.9g} kg m^2 '
        f'({axis["moment_through_center"]:.9g} through its centre of mass), radius of gyration '
        f'{axis["radius_of_gyration"]:.6g} m'
    )


def _of_needs(needs: dict[str, Any]) -> Iterator[str]:
    yield 'what it needs'
    yield (
        f'  {needs["moving"]} moving bodies, {needs["rotation"]} of them turn: '
        f'{needs["degrees_of_freedom"]} degrees of freedom'
    )
    contact = needs['contact']
    page = 'event_contact' if contact == 'event' else 'contact'
    yield '  contact: ' + ('none' if contact == 'none' else f'{contact}; see docs/{page}.md')
    if needs['coupled']:
        on = ', '.join(needs['on_velocity'])
        yield (
            f'  forces that depend on the state: {", ".join(needs["coupled"])}'
            + (f' (on velocities: {on})' if on else '')
        )
    if needs['is_free']:
        yield '  nothing acts but gravity and commands: centres of mass move on parabolas'
    if needs['timed'] is not None:
        instants = ', '.join(f'{t:g}' for t in needs['timed'][:8]) or 'none'
        yield f'  something depends on time; it begins, ends or bends at [s]: {instants}'
    if needs['inertia_over_time']:
        names = ', '.join(needs['inertia_over_time'][:8])
        yield f'  the inertia changes over time of: {names}'
    if needs['pivots']:
        yield f'  turn about a fixed point: {", ".join(needs["pivots"][:8])}'


def _of_integrators(facts: dict[str, Any]) -> Iterator[str]:
    found = [
        (IntegratorFacts(**{**row, 'steps': []}), damping)
        for row, damping in map(_without_damping, facts['integrators'])
    ]
    rates = next((row['steps'] for row in facts['integrators'] if row['steps']), [])
    now = ', '.join(
        f'{s["kind"]} {STEPS[s["kind"]]} = {s["product"]:.3g}' for s in rates if s['product']
    )
    yield f'integrators at dt {facts["dt"]:g} s' + (f'; at the start {now}' if now else '')
    width = max(len(row.name) for row, _ in found)
    for row, damping in found:
        order = 'exact' if row.order is None else f'order {row.order:g}'
        if row.refused is not None:
            said = f'refused: {row.refused}'
        elif row.beyond:
            said = f'beyond its limits: {"; ".join(row.beyond)}'
        elif row.is_reference:
            said = 'for comparison: slow'
        else:
            said = 'recommended' if row.recommended else 'within its limits'
            said += f', but {damping["text"]}' if damping else ''
        yield f'  {row.name:{width}}  {order:8}  {said}'
    yield '  (limits are those of a step, not of its error: `integrator: auto` measures that)'


def _without_damping(row: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any] | None]:
    own = dict(row)
    return own, own.pop('damping')


def _vector(values: list[float]) -> str:
    return '(' + ', '.join(f'{x + 0.0:.6g}' for x in values) + ')'
