# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a run publishes beyond its states, for viewers and controllers that want them in another form:
odometry, transforms, markers, arrays of all bodies, what contacts exert on each body. Each is off
until asked for.

Their records lie between the wrenches of a published tick and its states, stamped as the states:
a tick that is whole has them.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.model import rotation
from rigid_body_sim.physics.model.named_frames import frame_names, full_name
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.batch import Batch
from rigid_body_sim.recording.marker_packing import Arrows, MarkerPacker, Shown
from rigid_body_sim.recording.packing import WrenchPacker
from rigid_body_sim.recording.topics import Topic, node_topic
from rigid_body_sim.recording.view_packing import (
    ArrayPacker,
    Motions,
    OdometryPacker,
    TransformPacker,
)
from rigid_body_sim.runs.scene_markers import MarkerPlaces, forms_of, scale_of

if TYPE_CHECKING:
    from rigid_body_sim.physics.state.contacts import Contacts

Array = NDArray[np.float64]

CONTACT_WRENCH = 'contact_wrench'  # leaf of a topic
MARKER_RATE = 25.0  # [Hz] that eyes take for motion
NODE_NAME = 'rigid_body_sim'
EVERY_BODY = '*'
NO_BODY = 'none'  # which is easier to write on a command line than an empty text
LARGEST_SCALE = 1e9  # [m/N] of arrows


@dataclass(frozen=True)
class ViewSettings:
    """
    What is published beside the states; recorded in the manifest.

    odometry, transforms, markers, arrays, contact_wrenches : whether they are
    marker_every : published ticks between two messages of markers
    arrow_scale  : [m/N] length of arrows; 0: of the scene
    frame_prefix : before the names of frames of bodies, as robot_state_publisher has it
    node_name    : under which the topic of the markers stands
    body_topics  : which bodies have topics of their own: names or patterns, separated by commas
    """

    odometry: bool = False
    transforms: bool = False
    markers: bool = False
    arrays: bool = False
    contact_wrenches: bool = False
    marker_every: int = 1
    arrow_scale: float = 0.0
    frame_prefix: str = ''
    node_name: str = NODE_NAME
    body_topics: str = EVERY_BODY

    def as_text(self) -> str:
        """Give them as a manifest keeps them."""
        return json.dumps(asdict(self))

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> ViewSettings:
        """Take them as `as_text` wrote them; ValueError for anything else."""
        defaults = asdict(cls())
        for name, value in values.items():
            if name not in defaults or type(value) is not type(defaults[name]):
                raise ValueError(f'{name}: {value!r}')
        settings = cls(**values)
        if settings.marker_every < 1 or not 0.0 <= settings.arrow_scale <= LARGEST_SCALE:
            raise ValueError('marker_every or arrow_scale out of range')
        return settings


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
    if settings.transforms and world_frame.startswith('/'):
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
    if settings.contact_wrenches and scene.contact.get('mode', 'none') == 'none':
        raise UserError(
            f'contact wrenches of the scene {scene.name!r}: asked for, but its bodies do not '
            'meet; give the scene contact: {mode: timestep}, or do not ask'
        )
    own = bodies_with_topics(scene, settings.body_topics)
    return [scene.bodies[place].name for place in own]


class Viewing:
    """
    Packs what was asked for.

    topics : what it writes; the channel id of topics[i] is first_channel_id + i
    own    : places of the bodies that have topics of their own
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
        scene = simulation.scene
        check_frames(scene, settings, world_frame)
        names = [body.name for body in scene.bodies]
        self._simulation = simulation
        self._own = own
        self._marker_ticks = settings.marker_every * publish_every
        self._fixed = np.array([body.fixed for body in scene.bodies], dtype=bool)
        self.topics: tuple[Topic, ...] = ()
        self._odometry = self._transforms = self._arrays = self._markers = None
        self._wrenches: WrenchPacker | None = None
        if settings.odometry and own.size:
            self._odometry = OdometryPacker(
                [names[place] for place in own],
                namespace=namespace,
                frame_id=world_frame,
                frame_prefix=settings.frame_prefix,
                first_channel_id=first_channel_id,
            )
            self.topics += self._odometry.topics
        if settings.transforms:
            self._transforms = TransformPacker(
                names,
                [
                    {
                        name: (*frame.position, *frame.orientation)
                        for name, frame in body.frames.items()
                    }
                    for body in scene.bodies
                ],
                frame_id=world_frame,
                frame_prefix=settings.frame_prefix,
                first_channel_id=first_channel_id + len(self.topics),
            )
            self.topics += self._transforms.topics
        if settings.arrays:
            self._arrays = ArrayPacker(
                names,
                namespace=namespace,
                frame_id=world_frame,
                first_channel_id=first_channel_id + len(self.topics),
            )
            self.topics += self._arrays.topics
        if settings.contact_wrenches and own.size:
            self._wrenches = WrenchPacker(
                [names[place] for place in own],
                leaf=CONTACT_WRENCH,
                namespace=namespace,
                frame_id=world_frame,
                first_channel_id=first_channel_id + len(self.topics),
            )
            self.topics += self._wrenches.topics
        if settings.markers:
            with np.errstate(all='ignore'):
                forms, scale = forms_of(scene), scale_of(scene, settings.arrow_scale)
            self._marker_places = MarkerPlaces(forms)
            self._markers = MarkerPacker(
                forms,
                topic=node_topic(namespace, f'{settings.node_name}/markers', cdr.MARKERS),
                frame_id=world_frame,
                scale=scale,
                first_channel_id=first_channel_id + len(self.topics),
            )
            self.topics += self._markers.topics

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
        if not self.topics:
            return ()
        with np.errstate(all='ignore'):
            return self._packed_start()

    def _packed_start(self) -> tuple[Batch, ...]:
        tick, time_ns, motions = self._now()
        batches = self._states(tick, time_ns, motions)
        if self._markers is not None:
            poses = self._marker_places.poses(motions.position, motions.orientation)
            batches.append(self._markers.pack_start(tick, time_ns, poses))
        return tuple(batches)

    def shows_contacts(self, tick: int) -> bool:
        """Whether the contacts of a published tick are wanted, if bodies meet."""
        return self._wrenches is not None or (
            self._markers is not None and tick % self._marker_ticks == 0
        )

    def pack(self, force: Array, torque: Array, contacts: Contacts | None) -> tuple[Batch, ...]:
        """
        Pack a published tick.

        force, torque : (n, 3) [N], [N m]  commanded, over the last tick, world axes
        contacts      : of the last tick; needed where `shows_contacts` and bodies meet
        """
        if not self.topics:
            return ()
        with np.errstate(all='ignore'):  # where a run leaves the numbers, so does what is shown
            return self._packed(force, torque, contacts)

    def _packed(self, force: Array, torque: Array, contacts: Contacts | None) -> tuple[Batch, ...]:
        tick, time_ns, motions = self._now()
        batches = self._states(tick, time_ns, motions)
        if self._wrenches is not None and contacts is not None:
            of_all = contacts.wrenches(motions.position, self._simulation.dt)
            own = (wrench[self._own] for wrench in of_all)
            batches.append(self._wrenches.pack(tick, time_ns, *own))
        if self._markers is not None and tick % self._marker_ticks == 0:
            poses = self._marker_places.poses(motions.position, motions.orientation)
            touching = self._contact_arrows(contacts)
            arrows = Arrows(motions.position, force, torque, *touching)
            batches.append(self._markers.pack(tick, time_ns, poses, arrows))
        return tuple(batches)

    def _now(self) -> tuple[int, int, Motions]:
        simulation, state = self._simulation, self._simulation.state
        motions = Motions(
            state.position,
            state.orientation,
            state.velocity,
            state.angular_velocity,
        )
        return simulation.tick, simulation.tick * simulation.dt_ns, motions

    def _states(self, tick: int, time_ns: int, motions: Motions) -> list[Batch]:
        batches = []
        if self._odometry is not None:
            own = motions.of(self._own)
            spin = self._simulation.state.angular_velocity_body[self._own]
            velocity = rotation.rotate_back(own.orientation, own.velocity)
            batches.append(
                self._odometry.pack(
                    tick, time_ns, own, velocity_body=velocity, angular_velocity_body=spin
                )
            )
        if self._transforms is not None:
            batches.append(self._transforms.pack(tick, time_ns, motions))
        if self._arrays is not None:
            batches += self._arrays.pack(tick, time_ns, motions)
        return batches

    def _contact_arrows(self, contacts: Contacts | None) -> tuple[Array, Array]:
        """Points of contact and forces on the body found second, or on the one that can move."""
        if contacts is None:
            return np.zeros((0, 3)), np.zeros((0, 3))
        force = contacts.impulse / self._simulation.dt
        held = self._fixed[contacts.bodies[:, 1]]
        return contacts.point, np.where(held[:, None], -force, force)


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
