# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Instants at which the motion of a recorded run is less smooth, told by its commands and its scene.

    set_state                                    the pose jumps, just after the sample there
    impulse, recorded impact                     the velocity jumps
    held command that begins, changes, runs out  the force jumps
    table over time that begins or ends; burnout the force jumps
    row of a linear table                        the rate of the force jumps
    row of a cubic table                         its third derivative jumps
    row of an inertia over time                  the angular acceleration or its rate jumps

A held command in body axes turns with the body: that is smooth. What jumps at one body is felt by
those that share a force with it, one derivative later where the force depends on velocity, two
where it depends on position; likewise by the turn of a body what its path does.

The ticks are those recorded with each command; when a held one runs out follows from the command
timeout of the run. Bodies that meet (contact, bumpers) push each other from instants that nobody
recorded, but for the impacts of event mode: those are not known, and the samples have to show them
(`analysis.kinks`). Nor are any in a bag of another recorder, or in a CSV file.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from rigid_body_sim.analysis.piecewise_spline import DEGREE, Break
from rigid_body_sim.analysis.recorded_impacts import read_impacts
from rigid_body_sim.physics.forces.elements.bumper import Bumper
from rigid_body_sim.physics.forces.elements.time import TimeTable
from rigid_body_sim.physics.forces.held_wrenches import FOREVER, HeldWrenches
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.model.variable_mass import end_of_flow, flow_of
from rigid_body_sim.physics.state.layout import Layout
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.runs.commands import Command, CommandRules, decode, topics_of
from rigid_body_sim.runs.manifest_values import (
    MOST_NS,
    MOST_TIMEOUT_NS,
    ManifestValues,
)
from rigid_body_sim.runs.reading_guard import interpreting

PATH, TURN = 'path', 'turn'  # of the centre of mass, of the orientation
POSE, IMPULSE, FORCE, RATE, CUBIC = -1, 0, 1, 2, 4  # derivatives of the position that do not jump

Place = tuple[str, str]  # body, PATH or TURN
Events = dict[int, dict[Place, int]]  # [ns] -> what jumps there, with its continuity


@dataclass
class Jumps:
    """
    Instants [ns] at which each body of a run is less smooth.

    paths, turns : body -> breaks, ascending
    tick         : [ns] in whose steps forces act at instants that are not known
    unknown      : what pushes from instants that are not known, a phrase each
    """

    paths: dict[str, list[Break]] = field(default_factory=dict)
    turns: dict[str, list[Break]] = field(default_factory=dict)
    unknown: list[str] = field(default_factory=list)
    tick: float = 0.0


def jumps_of(bag: Bag, scene: Scene, *, began: int = 0) -> Jumps:
    """
    Find the jumps in a run of this package; without commands where the bag holds none.

    began : [ns] when the scene began, see `scene_begin`

    Raises DamagedBag where a recorded command cannot be read, or is none that the scene takes.
    """
    events: Events = {}
    couplings = _couplings(scene)
    later = 0.0
    for instant, place, continuity in _of_scene(scene):
        _note(events, began + instant, place, continuity)
    if bag.holds_run:
        with interpreting(bag.path):
            for instant, place, continuity in _of_commands(bag, scene, couplings):
                _note(events, instant, place, continuity)
            for instant, place, continuity in _of_impacts(bag, scene):
                _note(events, instant, place, continuity)
            # the state that was published at the tick is that of before
            later = 0.5 * ManifestValues(bag.path, 'manifest', bag.manifest).integer(
                'dt_ns', 1, MOST_NS
            )
    found = Jumps(unknown=_unknown(scene))
    if found.unknown:
        found.tick = 2.0 * later
    for instant in sorted(events):
        for (body, part), continuity in _felt(events[instant], couplings).items():
            table = found.paths if part == PATH else found.turns
            at = instant + later if continuity == POSE else instant
            table.setdefault(body, []).append(Break(float(at), continuity))
    return found


def _note(events: Events, instant: int, place: Place, continuity: int) -> None:
    at = events.setdefault(instant, {})
    at[place] = min(continuity, at.get(place, DEGREE))


def _of_scene(scene: Scene) -> Iterator[tuple[int, Place, int]]:
    for element in scene.forces:
        if isinstance(element, TimeTable):
            turns = len(element.table[0]) > 4 or element.point is not None
            for instant, continuity in _of_table(element):
                yield instant, (element.body, PATH), continuity
                if turns:
                    yield instant, (element.body, TURN), continuity
    for body in scene.bodies:
        end = end_of_flow(body)
        if flow_of(body) is not None and math.isfinite(end):
            yield round(end * 1e9), (body.name, PATH), FORCE
            yield round(end * 1e9), (body.name, TURN), RATE
        if body.inertia_over_time is not None:  # omega' jumps with I', its rate with I''
            smooth = body.inertia_over_time.interpolation == 'smooth'
            for row in body.inertia_over_time.table:
                yield round(row[0] * 1e9), (body.name, TURN), RATE if smooth else FORCE


def _of_table(table: TimeTable) -> Iterator[tuple[int, int]]:
    """Jumps at the ends of a table, kinks at its rows."""
    rows = table.table
    for row in (rows[0], rows[-1]):
        jumps = table.outside == 'zero' and any(row[1:])
        yield round(row[0] * 1e9), FORCE if jumps else RATE
    if table.interpolation == 'cubic':
        for row in rows[2:-2]:  # not-a-knot: the second row and the last but one are none
            yield round(row[0] * 1e9), CUBIC
    else:
        for before, row, after in zip(rows, rows[1:], rows[2:]):
            slopes = [
                [(b - a) / (end[0] - start[0]) for a, b in zip(start[1:], end[1:])]
                for start, end in ((before, row), (row, after))
            ]
            if not all(math.isclose(a, b, rel_tol=1e-9, abs_tol=1e-12) for a, b in zip(*slopes)):
                yield round(row[0] * 1e9), RATE


def _of_commands(
    bag: Bag, scene: Scene, couplings: list[tuple[frozenset[Place], int]]
) -> Iterator[tuple[int, Place, int]]:
    """Follow what is held, as the run did."""
    values = ManifestValues(bag.path, 'manifest', bag.manifest)
    dt_ns = values.integer('dt_ns', 1, MOST_NS)
    timeout_ns = values.integer('command_timeout_ns', 0, MOST_TIMEOUT_NS)
    lasts = FOREVER if timeout_ns == 0 else -(-timeout_ns // dt_ns)
    rules = CommandRules(
        scene,
        world_frame=values.text('world_frame'),
        frame_prefix=values.view('view').frame_prefix,
    )
    layout = Layout(scene)
    held = HeldWrenches(layout, scene.gravity)
    held.slots |= values.held('held_at_start', layout.n_moving)
    turned: set[str] = set()
    for tick, commands in _by_tick(bag, scene):
        while held.next_expiry() < tick:
            yield from _changed(held, layout, held.next_expiry(), (), rules, lasts, dt_ns)
        yield from _changed(held, layout, tick, commands, rules, lasts, dt_ns)
        turned |= {layout.body(core).name for core, _ in _turning(held)}
    while held.next_expiry() < FOREVER:
        yield from _changed(held, layout, held.next_expiry(), (), rules, lasts, dt_ns)
    couplings += [(frozenset({(body, PATH), (body, TURN)}), 2) for body in sorted(turned)]


def _turning(held: HeldWrenches) -> list[tuple[int, str]]:
    return [key for key, slot in held.slots.items() if slot.turns_with_body]


def _by_tick(bag: Bag, scene: Scene) -> Iterator[tuple[int, list[Command]]]:
    topics = topics_of([b.name for b in scene.bodies], namespace=bag.manifest['namespace'])
    now, commands = None, []
    for message in bag.messages_by_time(topics):
        if message.sequence != now and now is not None:
            yield now, commands
            commands = []
        now = message.sequence
        commands.append(decode(*topics[message.topic], message.data))
    if now is not None:
        yield now, commands


def _changed(
    held: HeldWrenches,
    layout: Layout,
    tick: int,
    commands: Iterable[Command],
    rules: CommandRules,
    lasts: int,
    dt_ns: int,
) -> Iterator[tuple[int, Place, int]]:
    """Take the commands of a tick; yield what jumps."""
    before = _asked(held)
    instant = tick * dt_ns
    for command in commands:
        reason = rules.refusal(command)
        if reason is not None:
            raise ValueError(f'command of tick {tick}: {reason}')
        if command.state is not None:
            yield instant, (command.body, PATH), POSE
            yield instant, (command.body, TURN), POSE
            continue
        if command.kind == 'impulse':
            asked = command.body, command.force, command.torque, rules.frame(command)
            _, linear, angular, _ = held.checked(*asked)
            for part, vector in ((PATH, linear), (TURN, angular)):
                if any(vector):
                    yield instant, (command.body, part), IMPULSE
            continue
        held.put(
            command.body,
            command.kind,
            force=command.force,
            torque=command.torque,
            frame=rules.frame(command),
            until=FOREVER if lasts == FOREVER else tick + lasts,
        )
    held.drop_expired(tick)
    after = _asked(held)
    for core in before.keys() | after.keys():
        for part in (PATH, TURN):
            if before.get(core, {}).get(part) != after.get(core, {}).get(part):
                yield instant, (layout.body(core).name, part), FORCE


def _of_impacts(bag: Bag, scene: Scene) -> Iterator[tuple[int, Place, int]]:
    """Recorded impacts: of both bodies, the path and the turn."""
    impacts = read_impacts(bag)
    instants = impacts.tick_ns + np.round(impacts.remainder * 1e9).astype(np.int64)
    for instant, pair in zip(instants.tolist(), impacts.bodies.tolist(), strict=True):
        for place in pair:
            body = scene.bodies[place]
            if not body.fixed:
                yield instant, (body.name, PATH), IMPULSE
                if not body.is_point:
                    yield instant, (body.name, TURN), IMPULSE


def _asked(held: HeldWrenches) -> dict[int, dict[str, Any]]:
    """What each body is asked for now, of the path and of the turn; nothing where it is zero."""
    found: dict[int, dict[str, Any]] = {}
    for (core, source), slot in sorted(held.slots.items()):
        for part, vector in ((PATH, slot.force), (TURN, slot.torque)):
            if any(vector):
                asked = (source, vector, slot.turns_with_body)
                found.setdefault(core, {}).setdefault(part, []).append(asked)
    return found


def _couplings(scene: Scene) -> list[tuple[frozenset[Place], int]]:
    """Who feels whom, and how many derivatives later."""
    movable = {body.name: body for body in scene.bodies if not body.fixed}
    found = []
    for element in scene.forces:
        places = [
            (name, part)
            for name in dict.fromkeys(element.bodies())
            if name in movable
            for part in ((PATH,) if movable[name].is_point else (PATH, TURN))
        ]
        if isinstance(element, TimeTable) and element.frame == 'world' and element.point is None:
            continue
        if len(places) > 1:
            found.append((frozenset(places), 1 if element.depends_on_velocity() else 2))
    found += [
        (frozenset({(body.name, PATH), (body.name, TURN)}), 0)
        for body in movable.values()
        if body.pivot is not None
    ]
    return found


def _felt(
    struck: Mapping[Place, int], couplings: list[tuple[frozenset[Place], int]]
) -> dict[Place, int]:
    """Spread jumps to all that feel them, as far as a spline can tell."""
    smooth = DEGREE - 1  # a jump of such a derivative is that of an ordinary knot
    found = dict(struck)
    frontier = list(struck)
    while frontier:
        reached: set[Place] = set()
        for places, later in couplings:
            for place in places.intersection(frontier):
                continuity = found[place] + later
                if later and found[place] == POSE:  # where, or how fast: a force jumps, no more
                    continuity = FORCE
                for other in places:
                    if continuity < min(smooth, found.get(other, smooth)):
                        found[other] = continuity
                        reached.add(other)
        frontier = list(reached)
    return found


def _unknown(scene: Scene) -> list[str]:
    found = []
    if scene.contact.get('mode', 'none') != 'none':
        found.append('contacts')
    if any(isinstance(element, Bumper) for element in scene.forces):
        found.append('bumpers')
    return found
