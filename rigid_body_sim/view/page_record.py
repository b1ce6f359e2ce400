# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What the page of a run holds: the record that its scripts read (`page/run.js`), and its numbers.

    series : per instant, first axis the time; a run that goes on sends more of them
        time                       (k,)      f8 [s]
        position                   (k, n, 3) f4 [m]  centre of mass, from the origin of the body;
                                   f8 where it goes far, and of a run that goes on
        orientation                (k, n, 4) f4 [-]      xyzw
        velocity, angular_velocity (k, n, 3) f4 [m/s], [rad/s], world axes
        angular_momentum           (k, n, 3) f4 [kg m^2/s]  about the centre of mass, world
        force, torque              (k, n, 3) f4 [N], [N m]  commanded, world axes
        arrows_0, ...              (k, m, 3) f4  of each set of arrows
        kinetic, potential, total  (k,)      f8 [J], of a run that goes on
    bodies, forms, planes, ties    what is drawn, see `drawn_shapes` and `drawn_forces`
    arrows, contacts               which vectors are drawn, how long, and where
    curves                         plots of all bodies together: energies and drifts

The origin of a body is its first position, in double precision: single precision of what is left
is enough, unless the body goes farther than `page_numbers.SINGLE` sizes. The same holds of points
of contacts and impacts.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.model import shapes
from rigid_body_sim.physics.model.scene import Body, Scene
from rigid_body_sim.physics.model.variable_mass import flow_of
from rigid_body_sim.physics.state.impacts import Impacts, hardest
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.view.contact_arrows import arrows_of, read_arrows
from rigid_body_sim.view.drawn_forces import ArrowSet, RecordedStates, drawn_ties, force_arrows
from rigid_body_sim.view.drawn_shapes import DrawnShapes, drawn_bounds, drawn_planes, drawn_reach
from rigid_body_sim.view.energy_history import EnergyHistory, energies_of, spin_of
from rigid_body_sim.view.line_styles import COLORS, color_places
from rigid_body_sim.view.page_numbers import PageNumbers
from rigid_body_sim.view.recorded_motion import RecordedMotion, Track

Array = NDArray[np.float64]

LARGEST = 10_000_000  # [byte] of motion in one page; more instants are left out evenly
MOST_SPINS = 100  # bodies whose angular momentum is told
BALL = 0.012  # [-] radius of a point, of the size of the scene at the start
ARROW, ARROW_OF_BODY = 0.18, 1.5  # [-] usual arrow at most: of the scene, of the largest reach
AXES, AXES_OF_BALL = 1.15, 1.4  # [-] length of body axes, of the reach of the body
BACKGROUND = 8.0  # [-] a fixed body that is so much larger than the scene need not be seen whole
USUAL = 0.9  # [-] share of the vectors that are no longer than the usual arrow
LEAST = 1e-12  # [m] a scene has some size
ON_REQUEST = {
    'velocity': 'velocity',
    'angular_velocity': 'angular_velocity',
    'angular_momentum': 'angular_momentum',
}
COMMANDS = {'force': 'command_force', 'torque': 'command_torque'}
MOST_IMPACTS = 100_000  # marks: 3 MB of the page


@dataclass(frozen=True, eq=False)
class Look:
    """
    What of a page stays while its run goes on.

    names   : of the bodies, in the order of the bag
    origins : (n, 3) [m]
    scene   : None where nobody knows it
    spins   : whether angular momenta are told
    wrenches : whether commands are
    energies, contacts, impacts : whether they are
    """

    names: list[str]
    origins: Array
    scene: Scene | None
    spins: bool
    wrenches: bool
    energies: bool = False
    contacts: bool = False
    impacts: bool = False


def page_record(
    motion: RecordedMotion,
    scene: Scene | None,
    *,
    energy: EnergyHistory | None = None,
    bag: Bag | None = None,
    live: bool = False,
) -> tuple[dict[str, Any], bytes, Look]:
    """
    Build the record, its numbers, and what stays while more is sent.

    scene  : shapes and forces come from it; None: every body is drawn as a small ball
    energy : None: masses are unknown
    bag    : contact forces come from it, where it holds them
    live   : more will be sent
    """
    numbers = PageNumbers()
    times = _instants(motion, BYTES_PER_BODY)
    bodies = {} if scene is None else {body.name: body for body in scene.bodies}
    names = [track.name for track in motion.tracks]
    places = {name: place for place, name in enumerate(names)}
    first = np.array([track.position[0] for track in motion.tracks])
    sizes = _Sizes.of(motion, bodies, first)
    wrenches = live or any(np.any(t.force) or np.any(t.torque) for t in motion.tracks)
    spins = bool(bodies) and len(names) <= MOST_SPINS and set(names) <= set(bodies)
    states = _states(motion, times)
    sets = force_arrows(scene, places, states, idle=live)
    energies = energies_of(scene, motion, times) if live and scene is not None else None
    told = _touching(motion, times) if live else None
    look = Look(
        *(names, first, scene, spins, wrenches, energies is not None),
        contacts=told is not None,
        impacts=live and motion.impacts is not None,
    )
    series = _series(motion, times, states, sets, look) | _energies(energies)
    drawn = DrawnShapes(numbers, ball=sizes.ball, meshes_collide=_collides(scene))
    colors = color_places(names, scene)
    record = {
        'bodies': [
            _body(track, bodies.get(track.name), drawn, sizes, place, colors)
            for place, track in enumerate(motion.tracks)
        ],
        'forms': drawn.forms,
        'planes': drawn_planes(scene),
        'ties': drawn_ties(scene, places, sizes.arrow),
        'arrow': sizes.arrow,
        'arrows': _arrows(series, sets, names, bodies, sizes.arrow),
        'contacts': _contacts(bag, times, bodies, numbers, sizes.arrow)
        if told is None
        else arrows_of(told, _places(scene)).drawn(numbers, sizes.arrow),
        'impacts': _impacts(motion.impacts, numbers, sizes.arrow, live=live),
        'curves': _live_curves(look) if energy is None else _curves(energy, numbers),
        'live': live,
        'series': _packed(series, numbers, 0.0 if live else sizes.arrow),
    }
    return record, numbers.joined(), look


def more_of(motion: RecordedMotion, look: Look) -> tuple[dict[str, Any], bytes]:
    """Give the series of what came after, for a page that is open."""
    numbers = PageNumbers()
    times = max((track.time for track in motion.tracks), key=len)
    states = _states(motion, times)
    places = {name: place for place, name in enumerate(look.names)}
    sets = force_arrows(look.scene, places, states, idle=True)
    series = _series(motion, times, states, sets, look)
    record: dict[str, Any] = {}
    if look.energies:
        assert look.scene is not None
        series |= _energies(energies_of(look.scene, motion, times))
    if look.contacts:
        arrows = arrows_of(motion.touching or (), _places(look.scene))
        record['contacts'] = arrows.drawn(numbers, 0.0)
    if look.impacts:
        record['impacts'] = _impacts(motion.impacts, numbers, 0.0)
    return record | {'series': _packed(series, numbers, 0.0)}, numbers.joined()


def _touching(motion: RecordedMotion, times: Array) -> list[Mapping[str, Array]] | None:
    """What bodies were told of contacts at some of the instants."""
    if motion.touching is None:
        return None
    return [motion.touching[k] for k in np.searchsorted(motion.tracks[0].time, times)]


def _places(scene: Scene | None) -> dict[str, int]:
    return {} if scene is None else {body.name: i for i, body in enumerate(scene.bodies)}


ENERGIES = {'kinetic': COLORS[0], 'potential': COLORS[1], 'total': 'var(--ink)'}


def _energies(energies: tuple[Array, Array] | None) -> dict[str, Array]:
    """Series of the energies."""
    if energies is None:
        return {}
    kinetic, potential = energies
    return {'kinetic': kinetic, 'potential': potential, 'total': kinetic + potential}


def _live_curves(look: Look) -> list[dict[str, Any]]:
    """Give the plots of series that grow."""
    if not look.energies:
        return []
    curves = [
        {'name': name, 'values': name, 'color': color, 'dash': [6, 4] * (name == 'total')}
        for name, color in ENERGIES.items()
    ]
    return [{'title': 'energy', 'unit': 'J', 'time': 'time', 'curves': curves}]


BYTES_PER_BODY = 4 * 22  # and instant, in one page


def _instants(motion: RecordedMotion, size: int) -> Array:
    """Instants of the body with most of them, evenly thinned to what a page may hold."""
    longest = max(motion.tracks, key=lambda track: len(track.time))
    most = max(2, LARGEST // (size * len(motion.tracks)))
    every = -(-len(longest.time) // most)
    times = longest.time[::every]
    return times if times[-1] == longest.time[-1] else np.append(times, longest.time[-1])


def _at(times: Array, own: Array) -> NDArray[np.int64]:
    """Places of the first own instant that is not before each time, or the last."""
    return np.clip(np.searchsorted(own, times - 1e-9), 0, len(own) - 1)


def _states(motion: RecordedMotion, times: Array) -> RecordedStates:
    shape = (len(times), len(motion.tracks))
    orientation = np.empty((*shape, 4))
    velocity, angular_velocity = np.zeros((*shape, 3)), np.zeros((*shape, 3))
    for i, track in enumerate(motion.tracks):
        orientation[:, i] = track.orientation[_at(times, track.time)]
        if len(track.twist_time):
            nearest = _at(times, track.twist_time)
            velocity[:, i] = track.velocity[nearest]
            angular_velocity[:, i] = track.angular_velocity[nearest]
    return RecordedStates(motion.passed(times), orientation, velocity, angular_velocity)


def _series(
    motion: RecordedMotion,
    times: Array,
    states: RecordedStates,
    sets: list[ArrowSet],
    look: Look,
) -> dict[str, Array]:
    """All series by name; the first axis is the instant."""
    positions = [track.position[_at(times, track.time)] for track in motion.tracks]
    series = {
        'time': times,
        'position': np.stack(positions, axis=1) - look.origins,
        'orientation': states.orientation,
        'velocity': states.velocity,
        'angular_velocity': states.angular_velocity,
    }
    if look.spins:
        series['angular_momentum'] = _spins(states, look)
    if look.wrenches:
        wrenches = np.stack([_commands(track, times) for track in motion.tracks], axis=1)
        series['force'], series['torque'] = wrenches[:, :, :3], wrenches[:, :, 3:]
    for i, each in enumerate(sets):
        series[f'arrows_{i}'] = each.vectors
    return series


def _spins(states: RecordedStates, look: Look) -> Array:
    assert look.scene is not None
    bodies = {body.name: body for body in look.scene.bodies}
    spins = np.zeros_like(states.velocity)
    for i, name in enumerate(look.names):
        body = bodies[name]
        if body.inertia is not None and not body.fixed:
            turns, rates = states.orientation[:, i], states.angular_velocity[:, i]
            spins[:, i] = spin_of(body, states.time, turns, rates)
    return spins


def _commands(track: Track, times: Array) -> Array:
    """Command at each time (k, 6): the largest that began since the time before, else none."""
    wrench = np.hstack((track.force, track.torque))
    found = np.zeros((len(times), 6))
    if not len(wrench):
        return found
    size = np.sum(np.square(wrench), axis=1)
    ends = np.searchsorted(track.wrench_time, times - 1e-9)  # those that began before each time
    begin = 0
    for k, end in enumerate(ends.tolist()):
        if end > begin:
            found[k] = wrench[begin + int(np.argmax(size[begin:end]))]
        begin = end
    return found


def _packed(series: Mapping[str, Array], numbers: PageNumbers, length: float) -> dict[str, Any]:
    """Take all series; length: [m] of a usual arrow, 0 where it is not known how far they go."""
    kinds = dict.fromkeys(('time', *ENERGIES), 'f8')
    return {
        name: (
            numbers.add_places(values, length or -1.0)
            if name == 'position'
            else numbers.add(values, kinds.get(name, 'f4'))
        )
        | {'width': int(values[0].size)}
        for name, values in series.items()
    }


@dataclass(frozen=True, eq=False)
class _Sizes:
    """
    Lengths that suit a scene [m].

    ball, arrow : radius of a point, length of a usual arrow
    reach       : (n,)  how far what is drawn of each body goes from its centre of mass
    bounds      : of each body the lowest and highest corner of what is drawn, (3,) body axes
    watched     : (n,)  whether the camera has to have it in view
    """

    ball: float
    arrow: float
    reach: Array
    bounds: list[tuple[Array, Array]]
    watched: list[bool]

    @classmethod
    def of(cls, motion: RecordedMotion, bodies: Mapping[str, Body], first: Array) -> _Sizes:
        """Take them from where the bodies are first, and how large they are."""
        known = [bodies.get(track.name) for track in motion.tracks]
        bare = np.array([drawn_reach(body, 0.0) for body in known])
        moves = np.array(
            [body is None or not body.fixed or body.motion is not None for body in known]
        )
        chosen = moves if moves.any() else np.ones(len(known), dtype=bool)
        if not bare[chosen].any() and len(first[chosen]) < 2:
            size = _travel(motion) / 4.0
        else:
            low = (first - bare[:, None])[chosen].min(axis=0)
            high = (first + bare[:, None])[chosen].max(axis=0)
            size = float(np.linalg.norm(high - low))
        anchors = [tie for body in known if body and body.pivot for tie in [body.pivot.at]]
        if anchors:
            size = max(size, float(np.linalg.norm(np.ptp(np.vstack((first, anchors)), axis=0))))
        size = max(size, LEAST) if size > LEAST else 1.0
        largest = float(bare[chosen].max(initial=0.0))
        ball = min(BALL * size, 0.3 * largest or np.inf)
        arrow = min(ARROW * size, ARROW_OF_BODY * largest or np.inf)
        reach = np.where(bare > 0.0, bare, ball)
        flat = [body is not None and isinstance(body.shape, shapes.Plane) for body in known]
        watched = [
            not plane and bool(moving or r <= BACKGROUND * size)
            for plane, moving, r in zip(flat, chosen, reach, strict=True)
        ]
        bounds = [drawn_bounds(body, ball) for body in known]
        return cls(ball, arrow, reach, bounds, watched)


def _travel(motion: RecordedMotion) -> float:
    return max(float(np.linalg.norm(np.ptp(track.position, axis=0))) for track in motion.tracks)


def _body(
    track: Track,
    body: Body | None,
    drawn: DrawnShapes,
    sizes: _Sizes,
    place: int,
    colors: Mapping[str, int],
) -> dict[str, Any]:
    plane = body is not None and isinstance(body.shape, shapes.Plane)
    reach = float(sizes.reach[place])
    ball = body is not None and (body.shape is None or isinstance(body.shape, shapes.Sphere))
    ground = plane or bool(body and isinstance(body.shape, shapes.Surface))
    turns = body is not None and not ground and (body.fixed or body.inertia is not None)
    number = colors.get(track.name)
    return {
        'name': track.name,
        'color': None if number is None else COLORS[number % len(COLORS)],
        'fixed': number is None,
        'moved': bool(body and body.motion),
        'ground': ground,
        'parts': drawn.parts(body),
        'origin': track.position[0].tolist(),
        'extent': reach,
        'low': sizes.bounds[place][0].tolist(),
        'high': sizes.bounds[place][1].tolist(),
        'axes': (AXES_OF_BALL if ball else AXES) * reach if turns or body is None else 0.0,
        'watched': sizes.watched[place],
        'facts': _facts(body),
    }


def _facts(body: Body | None) -> str:
    """Say in a line what is known of a body."""
    if body is None:
        return 'the bag tells neither shape nor mass'
    shape = 'no shape' if body.shape is None else _words(type(body.shape).__name__)
    if body.motion is not None:
        return f'{shape}, moved as the scene tells'
    if body.fixed:
        return f'{shape}, fixed'
    mass = f'{body.mass:.5g} kg' + (' at the start' if flow_of(body) is not None else '')
    if body.inertia is None:
        return f'point mass, {mass}'
    if body.shape is None:
        return f'{mass}, drawn as what has its inertia: the scene gives no shape'
    return f'{shape}, {mass}'


def _words(name: str) -> str:
    """ConvexHull: convex hull."""
    return ''.join(f' {c.lower()}' if c.isupper() else c for c in name).strip()


def _collides(scene: Scene | None) -> bool:
    return scene is not None and scene.contact.get('mode', 'none') != 'none'


def _arrows(
    series: Mapping[str, Array],
    sets: list[ArrowSet],
    names: list[str],
    bodies: Mapping[str, Body],
    length: float,
) -> list[dict[str, Any]]:
    """Tell which vectors are drawn: commands, drag and drives, and on request those of motion."""
    free = [i for i, name in enumerate(names) if name not in bodies or not bodies[name].fixed]
    told = []
    for name, kind in (COMMANDS | ON_REQUEST).items():
        values = series.get(name)
        if values is not None and (np.any(values) or name in COMMANDS):
            told.append(_told(kind, free, [[0.0] * 3] * len(free), free, name, values, length))
    for i, each in enumerate(sets):
        columns = list(range(len(each.bodies)))
        told.append(
            _told(each.kind, each.bodies, each.at, columns, f'arrows_{i}', each.vectors, length)
        )
    return told


def _told(
    kind: str,
    bodies: list[int],
    at: list[list[float]],
    columns: list[int],
    series: str,
    values: Array,
    length: float,
) -> dict[str, Any]:
    """Give one set of arrows; `columns` are those of its bodies in the series."""
    sizes = np.linalg.norm(values, axis=2)
    some = sizes[sizes > 0.0]
    usual = float(np.quantile(some, USUAL)) if some.size else 1.0
    return {
        'kind': kind,
        'bodies': bodies,
        'at': at,
        'columns': columns,
        'width': values.shape[1],
        'series': series,
        'metres': length / usual,
    }


def _contacts(
    bag: Bag | None,
    times: Array,
    bodies: Mapping[str, Body],
    numbers: PageNumbers,
    length: float,
) -> dict[str, Any] | None:
    places = {name: place for place, name in enumerate(bodies)}
    touching = None if bag is None else read_arrows(bag, times, places)
    return None if touching is None else touching.drawn(numbers, length)


def _impacts(
    found: Impacts | None, numbers: PageNumbers, length: float, *, live: bool = False
) -> dict[str, Any] | None:
    """
    Give the marks of impacts at their instants; of more than a page holds, the hardest.

    length : [m] of a usual arrow
    live   : there may be some later, where there are none yet
    """
    if found is None or not (live or len(found)):
        return None
    found = hardest(found, MOST_IMPACTS)
    places = np.hstack((found.point, found.normal))
    return {'times': numbers.add(found.time, 'f8'), 'places': numbers.add_places(places, length)}


def _curves(energy: EnergyHistory, numbers: PageNumbers) -> list[dict[str, Any]]:
    """Give the plots of energies, and of what should not have changed."""
    time = numbers.add(energy.time, 'f8')

    def curve(name: str, values: Array, color: str, dash: tuple[int, ...] = ()) -> dict[str, Any]:
        return {
            'name': name,
            'values': numbers.add(values, 'f8'),
            'color': color,
            'dash': list(dash),
        }

    total = energy.kinetic + energy.potential
    curves = [
        curve('kinetic', energy.kinetic, COLORS[0]),
        curve('potential', energy.potential, COLORS[1]),
        curve('total', total, 'var(--ink)', (6, 4)),
    ]
    plots = [{'title': 'energy', 'unit': 'J', 'time': time, 'curves': curves}]
    balance = energy.balance
    if balance is not None:
        works = [
            curve(name, work, COLORS[color])
            for name, work, color in (
                ('of commands', balance.commands, 2),
                ('of drives', balance.drives, 3),
                ('dissipated', balance.dissipation, 5),
                ('taken by contact', balance.contact, 6),
            )
            if np.any(work)
        ]
        if works:
            own = numbers.add(balance.time, 'f8')
            plots.append({'title': 'work', 'unit': 'J', 'time': own, 'curves': works})
    drifts = [
        curve(name, np.abs(energy.drift[:, i]), COLORS[i])
        for i, name in enumerate(
            (
                'rise of energy' if energy.may_only_fall else 'energy',
                'momentum',
                'angular momentum',
            )
        )
        if np.isfinite(energy.drift[:, i]).all()
    ]
    log = {'unit': '–', 'logarithmic': True}
    if drifts:
        plots.append({'title': 'worst drift so far', 'time': time, 'curves': drifts} | log)
    if balance is not None and balance.turnover > 0.0:
        defect = np.abs(balance.defect) / balance.turnover
        curves = [curve('defect / turnover', defect, COLORS[3])]
        own = numbers.add(balance.time, 'f8')
        plots.append({'title': 'energy balance', 'time': own, 'curves': curves} | log)
    return plots
