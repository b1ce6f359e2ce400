# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a run publishes beyond its states, for viewers and controllers that want them in another form:
the views of `runs/views`. Each is off until asked for.

Their records lie between the wrenches of a published tick and its states, stamped as the states:
a tick that is whole has them.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.model.named_frames import frame_names, full_name
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.recording.batch import Batch
from rigid_body_sim.recording.marker_packing import Shown
from rigid_body_sim.recording.topics import Topic
from rigid_body_sim.recording.view_packing import Motions
from rigid_body_sim.runs.view import Instant, ViewedRun, ViewPacker, ViewSettings
from rigid_body_sim.runs.views import VIEWS
from rigid_body_sim.runs.views.markers import MarkerView

if TYPE_CHECKING:
    from rigid_body_sim.physics.state.contacts import Contacts

Array = NDArray[np.float64]

MARKER_RATE = 25.0  # [Hz] that eyes take for motion
NO_BODY = 'none'  # which is easier to write on a command line than an empty text
LARGEST_SCALE = 1e9  # [m/N] of arrows


def marker_every(rate_hz: float, publish_every: int, dt_ns: int) -> int:
    """Count the published ticks between two messages of markers."""
    return max(1, round(1e9 / rate_hz / (publish_every * dt_ns)))


def bodies_with_topics(scene: Scene, wanted: str) -> NDArray[np.int64]:
    """
    Find the bodies (their places in the scene) that have topics of their own.

    wanted : names or patterns with * and ?, separated by commas; `none` or nothing: no body;
             UserError for a pattern that fits none
    """
    names = [body.name for body in scene.bodies]
    chosen = np.zeros(len(names), dtype=bool)
    if wanted.strip() == NO_BODY:
        return np.flatnonzero(chosen)
    for pattern in filter(None, map(str.strip, wanted.split(','))):
        fits = [fnmatchcase(name, pattern) for name in names]
        if not any(fits):
            raise UserError(
                f'body_topics: no body of the scene {scene.name!r} is called {pattern!r}; '
                'allowed: names or patterns with * and ?, separated by commas, or none'
            )
        chosen |= fits
    return np.flatnonzero(chosen)


def check_frames(scene: Scene, settings: ViewSettings, world_frame: str) -> None:
    """Refuse names of frames that nobody could use, or that mean two things; UserError."""
    prefix = settings.frame_prefix
    if prefix.startswith('/') or '\0' in prefix:
        raise UserError(
            f'frame_prefix: got {prefix!r}; allowed: a text without / at its start, such as lab/'
        )
    names = {name for body in scene.bodies for name in frame_names(body)}
    twice = sorted(prefix + name for name in names if prefix and prefix + name in names)
    if twice:
        raise UserError(
            f'frame_prefix: got {prefix!r}, with which {twice[0]!r} would be two frames of the '
            'scene; choose another'
        )
    if 'transforms' in settings.views and world_frame.startswith('/'):
        raise UserError(
            f'world_frame: got {world_frame!r}; allowed with publish_tf: a name without / at its '
            'start, because tf2 refuses it'
        )


def check_world_frame(scene: Scene, settings: ViewSettings, world_frame: str) -> None:
    """
    Refuse a name of the world axes that is also that of a body, or in full of a frame of one; with
    the prefix or without, as a frame_id may have it; UserError.
    """
    prefix = settings.frame_prefix
    for body in scene.bodies:
        for name in (body.name, *(full_name(body, frame) for frame in body.frames)):
            if world_frame in (name, prefix + name):
                said = f' and frame_prefix {prefix!r}' if prefix else ''
                raise UserError(
                    f'world_frame: got {world_frame!r}{said}; that names {name!r} of the scene '
                    'too, and a frame_id could mean either; allowed: a name that is no frame of '
                    'a body, such as world; set another, or rename the body'
                )


def check_view(scene: Scene, settings: ViewSettings, world_frame: str) -> list[str]:
    """
    Refuse settings that do not fit a scene, before anything is compiled for it; UserError.

    returns : names of the bodies that have topics of their own
    """
    check_frames(scene, settings, world_frame)
    for name, value in (('frame_prefix', settings.frame_prefix), ('world_frame', world_frame)):
        if any(letter.isspace() or not letter.isprintable() for letter in value):
            raise UserError(
                f'{name}: got {value!r}; allowed: a text without blanks and control characters, '
                'which no name of a frame has'
            )
    check_world_frame(scene, settings, world_frame)
    for view in VIEWS.values():
        if (
            view.name in settings.views
            and view.needs_contact
            and scene.contact.get('mode', 'none') == 'none'
        ):
            raise UserError(
                f'{view.name.replace("_", " ")} of the scene {scene.name!r}: asked for, but its '
                'bodies do not meet; give the scene contact: {mode: timestep}, or do not ask'
            )
    own = bodies_with_topics(scene, settings.body_topics)
    return [scene.bodies[place].name for place in own]


class Viewing:
    """
    Packs what was asked for.

    topics : what it writes; the channel id of topics[i] is first_channel_id + i
    """

    def __init__(
        self,
        simulation: Simulation,
        settings: ViewSettings,
        *,
        own: NDArray[np.int64],
        namespace: str,
        world_frame: str,
        publish_every: int,
        first_channel_id: int,
    ) -> None:
        """Make the packers; own : places of the bodies that have topics of their own."""
        check_frames(simulation.scene, settings, world_frame)
        run = ViewedRun(simulation, settings, own, namespace, world_frame, publish_every)
        self._simulation = simulation
        self._packers: list[ViewPacker] = []
        self.topics: tuple[Topic, ...] = ()
        order = list(VIEWS)
        for view in sorted(
            (VIEWS[name] for name in settings.views),
            key=lambda view: (view.packed_last, order.index(view.name)),
        ):
            if own.size or not view.of_bodies:
                packer = view.make(run, first_channel_id + len(self.topics))
                self._packers.append(packer)
                self.topics += packer.topics
        self._markers = next(
            (packer for packer in self._packers if isinstance(packer, MarkerView)), None
        )

    @property
    def shown(self) -> Shown:
        """The arrows of the last markers; what is written next depends on it."""
        return Shown() if self._markers is None else self._markers.shown

    @shown.setter
    def shown(self, shown: Shown) -> None:
        if self._markers is not None:
            self._markers.shown = shown

    def start(self) -> tuple[Batch, ...]:
        """Pack where the run stands, before anything acts."""
        return self._packed(None, None, None)

    def shows_contacts(self, tick: int) -> bool:
        """Whether the contacts of a published tick are wanted, if bodies meet."""
        return any(packer.needs_contacts(tick) for packer in self._packers)

    def pack(self, force: Array, torque: Array, contacts: Contacts | None) -> tuple[Batch, ...]:
        """
        Pack a published tick.

        force, torque : (n, 3) [N], [N m]  commanded, over the last tick, world axes
        contacts      : of the last tick; needed where `shows_contacts` and bodies meet
        """
        return self._packed(force, torque, contacts)

    def _packed(
        self, force: Array | None, torque: Array | None, contacts: Contacts | None
    ) -> tuple[Batch, ...]:
        if not self._packers:
            return ()
        simulation, state = self._simulation, self._simulation.state
        motions = Motions(
            state.position,
            state.orientation,
            state.velocity,
            state.angular_velocity,
        )
        tick, time_ns = simulation.tick, simulation.tick * simulation.dt_ns
        now = Instant(tick, time_ns, state, motions, force, torque, contacts)
        with np.errstate(all='ignore'):  # where a run leaves the numbers, so does what is shown
            return tuple(batch for packer in self._packers for batch in packer.pack(now))


def view_text(settings: ViewSettings) -> str:
    """Give the settings as a manifest keeps them: a flag for each view, and the rest."""
    rest = asdict(settings)
    views = rest.pop('views')
    return json.dumps({name: name in views for name in VIEWS} | rest)


def view_settings_of(values: Mapping[str, Any]) -> ViewSettings:
    """Take them as `view_text` wrote them; ValueError for anything else."""
    defaults = json.loads(view_text(ViewSettings()))
    for name, value in values.items():
        if name not in defaults or type(value) is not type(defaults[name]):
            raise ValueError(f'{name}: {value!r}')
    views = frozenset(name for name in VIEWS if values.get(name))
    rest = {name: value for name, value in values.items() if name not in VIEWS}
    settings = ViewSettings(views, **rest)
    if settings.marker_every < 1 or not 0.0 <= settings.arrow_scale <= LARGEST_SCALE:
        raise ValueError('marker_every or arrow_scale out of range')
    return settings


def shown_text(shown: Shown) -> str:
    """Give the arrows of the last markers as a manifest keeps them."""
    return json.dumps([sorted(shown.forces), sorted(shown.torques), shown.contacts])


def shown_of(value: object, bodies: int) -> Shown:
    """Take them as `shown_text` wrote them; ValueError for anything else."""
    if not isinstance(value, list) or len(value) != 3:
        raise ValueError(value)
    forces, torques, contacts = value
    for places in (forces, torques):
        if not isinstance(places, list) or not all(_is_whole(k, bodies) for k in places):
            raise ValueError(value)
    if not _is_whole(contacts, 2**31):
        raise ValueError(value)
    return Shown(frozenset(forces), frozenset(torques), contacts)


def _is_whole(value: object, below: int) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < below
