# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a tick has: all arrays of a scene with contact, and the tick under way.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.contact.array_groups import Constraints, Forces, Motion
from rigid_body_sim.physics.contact.collision.collider import BroadPhase, ColliderArrays
from rigid_body_sim.physics.contact.crew import Crew
from rigid_body_sim.physics.contact.energy.scratch import EnergyScratch
from rigid_body_sim.physics.contact.events.flight import Flights
from rigid_body_sim.physics.contact.islands.sleep import SleepState
from rigid_body_sim.physics.contact.packed_bodies import PackedBodies
from rigid_body_sim.physics.contact.prescribed_bodies import PrescribedBodies

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


class Detection(NamedTuple):
    """
    What the detection of contacts needs beside the colliders.

    local_poses : of the shapes in the axes of their bodies: see `collision.pose`
    found       : what a pair kernel writes, and its scratch: see `geometry.manifold`
    ignored     : pairs that do not meet: see `collision.ignored_pairs`
    places      : of the records of pairs: see `collision.recycling`
    records     : of the tick under way: see there
    held        : what pairs have held: see `collision.held_features`
    of_parts    : how many manifolds each part of the narrow phase has found
    """

    local_poses: Array
    broad_phase: BroadPhase
    found: Array
    ignored: Indices
    places: Indices
    records: Array
    held: Array
    of_parts: Indices


class World(NamedTuple):
    """
    All arrays of a scene with contact: what Python hands over (`world_arrays`).

    settings, counts : see `tick_settings`, `tick_counts`; counts[DONE] tells how many ticks were
                       done, counts[STATUS] why no more
    materials        : see `model.material`
    bodies           : see `solver_bodies`
    touching, marks  : see `touching`
    flows            : bodies whose mass changes: see `solver.variable_mass`
    pair_materials   : pairs with a material of their own, the same
    driven           : see `prescribed_bodies`
    overlap_limits, overlaps : see `collision.deep_overlaps`
    flights          : of bodies between impacts: see `events.flight`
    packed           : room for the bodies of a group: see `packed_bodies`
    crew             : see `crew`

    Each thread has its own `found`, `packed` and `constraints.scratch`, and its place in the crew.
    """

    motion: Motion
    forces: Forces
    settings: Array
    counts: Indices
    colliders: ColliderArrays
    materials: Array
    detection: Detection
    bodies: Array
    constraints: Constraints
    touching: Indices
    marks: Indices
    energy: EnergyScratch
    sleep: SleepState
    flows: Array
    pair_materials: Array
    driven: PrescribedBodies
    overlap_limits: Array
    overlaps: Array
    flights: Flights
    packed: PackedBodies
    crew: Crew


class Tick(NamedTuple):
    """
    The tick under way.

    start     : [s] since the start of the scene
    end       : [s] where the next one begins, to the bit
    h         : [s] its length
    substep   : [s]
    substeps  : how many
    """

    start: float
    end: float
    h: float
    substep: float
    substeps: int
