# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Markers: shapes as they collide, named frames, arrows of commands and of contact forces."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.batch import Batch
from rigid_body_sim.recording.marker_packing import Arrows, MarkerPacker, Shown
from rigid_body_sim.recording.topics import node_topic
from rigid_body_sim.runs.scene_markers import MarkerPlaces, forms_of, scale_of
from rigid_body_sim.runs.view import Instant, View, ViewedRun, ViewPacker

if TYPE_CHECKING:
    from rigid_body_sim.physics.state.contacts import Contacts

Array = NDArray[np.float64]


class MarkerView(ViewPacker):
    """Packs markers at a rate of their own."""

    def __init__(self, run: ViewedRun, first_channel_id: int) -> None:
        scene, settings = run.simulation.scene, run.settings
        self._dt = run.simulation.dt
        self._every = settings.marker_every * run.publish_every
        self._fixed = np.array([body.fixed for body in scene.bodies], dtype=bool)
        with np.errstate(all='ignore'):
            forms, scale = forms_of(scene), scale_of(scene, settings.arrow_scale)
        self._places = MarkerPlaces(forms)
        self._packer = MarkerPacker(
            forms,
            topic=node_topic(run.namespace, f'{settings.node_name}/markers', cdr.MARKERS),
            frame_id=run.world_frame,
            scale=scale,
            first_channel_id=first_channel_id,
        )
        self.topics = self._packer.topics

    @property
    def shown(self) -> Shown:
        """The arrows of the last markers; what is written next depends on it."""
        return self._packer.shown

    @shown.setter
    def shown(self, shown: Shown) -> None:
        self._packer.shown = shown

    def needs_contacts(self, tick: int) -> bool:
        """It does where it is due."""
        return tick % self._every == 0

    def pack(self, now: Instant) -> tuple[Batch, ...]:
        """Pack the start, and what is due."""
        if now.force is None or now.torque is None:
            poses = self._places.poses(now.motions.position, now.motions.orientation)
            return (self._packer.pack_start(now.tick, now.time_ns, poses),)
        if now.tick % self._every:
            return ()
        poses = self._places.poses(now.motions.position, now.motions.orientation)
        touching = self._contact_arrows(now.contacts)
        arrows = Arrows(now.motions.position, now.force, now.torque, *touching)
        return (self._packer.pack(now.tick, now.time_ns, poses, arrows),)

    def _contact_arrows(self, contacts: Contacts | None) -> tuple[Array, Array]:
        """Points of contact and forces on the body found second, or on the one that can move."""
        if contacts is None:
            return np.zeros((0, 3)), np.zeros((0, 3))
        force = contacts.impulse / self._dt
        held = self._fixed[contacts.bodies[:, 1]]
        return contacts.point, np.where(held[:, None], -force, force)


VIEW = View(
    name='markers',
    topics={
        '~/markers': 'shapes as they collide, named frames, arrows of commands and of contact '
        'forces; every message is whole'
    },
    make=MarkerView,
    packed_last=True,
)
