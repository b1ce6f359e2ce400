# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Transforms: the frames of the bodies in the world, and their named frames in them."""

from __future__ import annotations

from rigid_body_sim.recording.batch import Batch
from rigid_body_sim.recording.view_packing import TransformPacker
from rigid_body_sim.runs.view import Instant, View, ViewedRun, ViewPacker


class TransformView(ViewPacker):
    """Packs the transforms of all bodies."""

    def __init__(self, run: ViewedRun, first_channel_id: int) -> None:
        self._packer = TransformPacker(
            run.names,
            [
                {
                    name: (*frame.position, *frame.orientation)
                    for name, frame in body.frames.items()
                }
                for body in run.simulation.scene.bodies
            ],
            frame_id=run.world_frame,
            frame_prefix=run.settings.frame_prefix,
            first_channel_id=first_channel_id,
        )
        self.topics = self._packer.topics

    def pack(self, now: Instant) -> tuple[Batch, ...]:
        """Pack the poses of an instant."""
        return (self._packer.pack(now.tick, now.time_ns, now.motions),)


VIEW = View(
    name='transforms',
    switch='tf',
    topics={'/tf': 'world frame to each body, body to each of its named frames'},
    make=TransformView,
)
