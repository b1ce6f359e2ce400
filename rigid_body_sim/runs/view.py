# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a view is: topics that a run can publish beside its states, when they are asked for.

A view is a file of `runs/views`. What it says of itself makes the parameter of the node, the
option of `simulate`, the flag of the manifest and the rows of the documentation.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.physics.state.snapshot import State
from rigid_body_sim.recording.batch import Batch
from rigid_body_sim.recording.topics import Topic
from rigid_body_sim.recording.view_packing import Motions

if TYPE_CHECKING:
    from rigid_body_sim.physics.state.contacts import Contacts

Array = NDArray[np.float64]

OF_BODY = '<body>/'  # begins the name of a topic that each body has for itself
NODE_NAME = 'rigid_body_sim'
EVERY_BODY = '*'


@dataclass(frozen=True)
class ViewSettings:
    """
    What is published beside the states; recorded in the manifest.

    views        : names of those that are, of `VIEWS`
    marker_every : published ticks between two messages of markers
    arrow_scale  : [m/N] length of arrows; 0: of the scene
    frame_prefix : before the names of frames of bodies, as robot_state_publisher has it
    node_name    : under which the topic of the markers stands
    body_topics  : which bodies have topics of their own: names or patterns, separated by commas
    """

    views: frozenset[str] = frozenset()
    marker_every: int = 1
    arrow_scale: float = 0.0
    frame_prefix: str = ''
    node_name: str = NODE_NAME
    body_topics: str = EVERY_BODY


@dataclass(frozen=True)
class ViewedRun:
    """
    The run that a view belongs to.

    own           : places of the bodies that have topics of their own
    publish_every : [tick] between published states
    """

    simulation: Simulation
    settings: ViewSettings
    own: NDArray[np.int64]
    namespace: str
    world_frame: str
    publish_every: int

    @property
    def names(self) -> list[str]:
        """Names of all bodies, scene order."""
        return [body.name for body in self.simulation.scene.bodies]

    @property
    def own_names(self) -> list[str]:
        """Names of the bodies that have topics of their own."""
        names = self.names
        return [names[place] for place in self.own]


class Instant(NamedTuple):
    """
    What is known at a published tick; arrays hold all bodies, scene order.

    state         : what can be read of the bodies; `motions` are its poses and twists
    force, torque : (n, 3) [N], [N m]  commanded, over the last tick, world axes; None at the start
    contacts      : of the last tick; None at the start, where bodies do not meet, and where no
                    view needs them at this tick
    """

    tick: int
    time_ns: int
    state: State
    motions: Motions
    force: Array | None = None
    torque: Array | None = None
    contacts: Contacts | None = None


class ViewPacker(ABC):
    """
    Packs one view of a run.

    topics : what it writes; the channel id of topics[i] is first_channel_id + i
    """

    topics: tuple[Topic, ...]

    @abstractmethod
    def pack(self, now: Instant) -> tuple[Batch, ...]:
        """Pack a published tick, or the start, before anything acts; nothing is no batch."""

    def needs_contacts(self, tick: int) -> bool:
        """Whether it reads the contacts of a published tick, if bodies meet."""
        return False


@dataclass(frozen=True)
class View:
    """
    A view: what it is called, what it publishes, and what packs it.

    name          : its flag in the manifest
    topics        : name, as users write it -> what its messages say; `<body>/…` are those of
                    bodies, which not all need have
    make          : gives the packer: run, first channel id
    switch        : the word in its parameter and its option; empty: the name
    needs_contact : whether it is refused for a scene whose bodies do not meet
    packed_last   : whether it is packed behind the others, as what is large and has a rate of its
                    own; bags keep this order
    """

    name: str
    topics: Mapping[str, str]
    make: Callable[[ViewedRun, int], ViewPacker]
    switch: str = ''
    needs_contact: bool = False
    packed_last: bool = False

    @property
    def word(self) -> str:
        """The word by which it is asked for."""
        return self.switch or self.name

    @property
    def parameter(self) -> str:
        """Name of the parameter of the node."""
        return f'publish_{self.word}'

    @property
    def option(self) -> str:
        """The option of `simulate`."""
        return f'--{self.word.replace("_", "-")}'

    @property
    def description(self) -> str:
        """What it publishes, in a line."""
        said = '; '.join(f'{topic}: {meaning}' for topic, meaning in self.topics.items())
        return said + '; for scenes with contact' * self.needs_contact

    @property
    def of_bodies(self) -> bool:
        """Whether all its topics are those of single bodies."""
        return all(topic.startswith(OF_BODY) for topic in self.topics)
