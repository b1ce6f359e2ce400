# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Contact wrenches: what all contacts exert on each body, the mean over the last tick."""

from __future__ import annotations

from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.batch import Batch
from rigid_body_sim.recording.packing import BodyPacker
from rigid_body_sim.runs.view import Instant, View, ViewedRun, ViewPacker


class ContactWrenchView(ViewPacker):
    """Packs the wrenches of contacts on the bodies that have topics of their own."""

    def __init__(self, run: ViewedRun, first_channel_id: int) -> None:
        self._own = run.own
        self._dt = run.simulation.dt
        self._packer = BodyPacker(
            run.own_names,
            leaf='contact_wrench',
            kind=cdr.WrenchStamped,
            namespace=run.namespace,
            frame_id=run.world_frame,
            first_channel_id=first_channel_id,
        )
        self.topics = self._packer.topics

    def needs_contacts(self, tick: int) -> bool:
        """It does at every published tick."""
        return True

    def pack(self, now: Instant) -> tuple[Batch, ...]:
        """Pack the wrenches over the last tick; before the first there are none."""
        if now.contacts is None:
            return ()
        of_all = now.contacts.wrenches(now.motions.position, self._dt)
        own = (wrench[self._own] for wrench in of_all)
        return (self._packer.pack(now.tick, now.time_ns, *own),)


VIEW = View(
    name='contact_wrenches',
    topics={
        '<body>/contact_wrench': 'force and torque of all contacts of the body about its centre '
        'of mass, world axes, mean over the last tick'
    },
    make=ContactWrenchView,
    needs_contact=True,
)
