# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Arrays: poses and twists of all bodies in one message each, whoever has topics of its own."""

from __future__ import annotations

from rigid_body_sim.recording.batch import Batch
from rigid_body_sim.recording.view_packing import ArrayPacker
from rigid_body_sim.runs.view import Instant, View, ViewedRun, ViewPacker


class ArrayView(ViewPacker):
    """Packs the arrays of all bodies."""

    def __init__(self, run: ViewedRun, first_channel_id: int) -> None:
        self._packer = ArrayPacker(
            run.names,
            namespace=run.namespace,
            frame_id=run.world_frame,
            first_channel_id=first_channel_id,
        )
        self.topics = self._packer.topics

    def pack(self, now: Instant) -> tuple[Batch, ...]:
        """Pack the poses and twists of an instant."""
        return self._packer.pack(now.tick, now.time_ns, now.motions)


VIEW = View(
    name='arrays',
    topics={
        'poses': 'every body in scene order',
        'twists': 'every body in scene order, with names',
    },
    make=ArrayView,
)
