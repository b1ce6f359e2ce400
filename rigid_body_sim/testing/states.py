# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Puts the messages of one instant together to what a test sees of the world.

Pose and twist of a body are different topics and come in any order; only whole instants are shown.
"""

from __future__ import annotations

from collections.abc import Sequence

from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.topics import body_topic
from rigid_body_sim.ros.partner import BodyState, States, stamp_of, states_of

LEAVES = {'pose': cdr.PoseStamped.TYPE, 'twist': cdr.TwistStamped.TYPE}
MOST_UNFINISHED = 1000  # [instants] of which some message is missing; older ones are given up
MOST_TOLD = 8  # [bodies] of a state in a message


class StateCollector:
    """
    Puts messages together by their stamp.

    bodies : those that are heard
    types  : absolute topic name -> type name, of what is needed
    """

    def __init__(self, bodies: Sequence[str], *, namespace: str) -> None:
        topics = {
            body_topic(namespace, body, leaf, kind): f'{body}/{leaf}'
            for body in bodies
            for leaf, kind in LEAVES.items()
        }
        self.types = {topic.name: topic.type for topic in topics}
        self._places = {topic.name: place for topic, place in topics.items()}
        self._bodies = tuple(bodies)
        self._unfinished: dict[int, dict[str, bytes]] = {}
        self._whole: list[States] = []

    def add(self, topic: str, data: bytes) -> None:
        """Take one message."""
        stamp = stamp_of(data)
        parts = self._unfinished.setdefault(stamp, {})
        parts[self._places[topic]] = data
        if len(parts) == len(self._places):
            del self._unfinished[stamp]
            self._whole.append(states_of(stamp, parts, self._bodies))
        elif len(self._unfinished) > MOST_UNFINISHED:
            del self._unfinished[min(self._unfinished)]

    def take(self) -> list[States]:
        """Take what is whole, in the order in which it became so."""
        taken, self._whole = self._whole, []
        return taken

    def forget(self) -> None:
        """Take nothing that came so far for a part of what will come."""
        self._unfinished.clear()
        self._whole.clear()


def told(states: States) -> str:
    """Tell time and bodies in lines."""
    lines = [f'    {name}: {_told(body)}' for name, body in list(states.items())[:MOST_TOLD]]
    more = [f'    and {len(states) - MOST_TOLD} more'] * (len(states) > MOST_TOLD)
    return '\n'.join([f't = {states.time:.9g} s', *lines, *more])


def _told(body: BodyState) -> str:
    named = ('position', 'orientation', 'velocity', 'angular_velocity')
    return ', '.join(
        f'{name} ({", ".join(f"{value:.6g}" for value in getattr(body, name))})' for name in named
    )
