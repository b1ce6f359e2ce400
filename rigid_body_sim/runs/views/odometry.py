# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Odometry of each body: pose in the world frame, twist in the axes of the body, v_B = R^T v."""

from __future__ import annotations

from rigid_body_sim.physics.model import rotation
from rigid_body_sim.recording.batch import Batch
from rigid_body_sim.recording.view_packing import OdometryPacker
from rigid_body_sim.runs.view import Instant, View, ViewedRun, ViewPacker


class OdometryView(ViewPacker):
    """Packs odometry of the bodies that have topics of their own."""

    def __init__(self, run: ViewedRun, first_channel_id: int) -> None:
        self._own = run.own
        self._packer = OdometryPacker(
            run.own_names,
            namespace=run.namespace,
            frame_id=run.world_frame,
            frame_prefix=run.settings.frame_prefix,
            first_channel_id=first_channel_id,
        )
        self.topics = self._packer.topics

    def pack(self, now: Instant) -> tuple[Batch, ...]:
        """Pack the poses and twists of an instant."""
        own = now.motions.of(self._own)
        batch = self._packer.pack(
            now.tick,
            now.time_ns,
            own,
            velocity_body=rotation.rotate_back(own.orientation, own.velocity),
            angular_velocity_body=now.state.angular_velocity_body[self._own],
        )
        return (batch,)


VIEW = View(
    name='odometry',
    topics={'<body>/odom': 'pose in the world frame, twist in the axes of the body'},
    make=OdometryView,
)
