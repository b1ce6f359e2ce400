# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The contact of one scene: its arrays and its kernel, only what the scene needs, and who works with
them.

    ticks      let time pass             (`ticks`, and what is cut: `pieces`, `island_ticks`)
    memory     what the next tick starts from               (`world_memory`)
    readout    what can be read of ticks that have passed   (`world_readout`)
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.contact import step, tick_settings
from rigid_body_sim.physics.contact.collision import collider_record
from rigid_body_sim.physics.contact.collision.axis_of_symmetry import symmetry_features
from rigid_body_sim.physics.contact.collision.collider import SPHERE, SURFACE, Colliders
from rigid_body_sim.physics.contact.collision.collider_order import order
from rigid_body_sim.physics.contact.collision.convexity_defect import convexity_warnings
from rigid_body_sim.physics.contact.collision.held_features import KINDS as HELD_KINDS
from rigid_body_sim.physics.contact.collision.narrow_phase import manifold_finder
from rigid_body_sim.physics.contact.collision.pairs import collide_kernel
from rigid_body_sim.physics.contact.collision.recycling import RECYCLED_KINDS
from rigid_body_sim.physics.contact.collision.small_bodies import small_body_warnings
from rigid_body_sim.physics.contact.cut_ticks import CutTicks
from rigid_body_sim.physics.contact.island_ticks import IslandTicks
from rigid_body_sim.physics.contact.islands.groups import groups_of
from rigid_body_sim.physics.contact.islands.sleep import make_sleep_state
from rigid_body_sim.physics.contact.pair_rules import pair_rules
from rigid_body_sim.physics.contact.pieces import Pieces
from rigid_body_sim.physics.contact.settings import EVENT, ContactSettings
from rigid_body_sim.physics.contact.solver import contact_point, variable_mass
from rigid_body_sim.physics.contact.solver.iterations import solver
from rigid_body_sim.physics.contact.suited_integrators import unsuited
from rigid_body_sim.physics.contact.ticks import Ticks
from rigid_body_sim.physics.contact.unresolved_motions import unresolved_motion_warnings
from rigid_body_sim.physics.contact.world_arrays import WorldArrays
from rigid_body_sim.physics.contact.world_memory import WorldMemory
from rigid_body_sim.physics.contact.world_readout import WorldReadout, Written
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.integration.integrator import Integrator
from rigid_body_sim.physics.integration.schemes.splitting import Splitting
from rigid_body_sim.physics.model import material
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.state.layout import Layout


class ContactWorld:
    """
    What the contact of a scene needs beside the blocks.

    arrays   : of the kernel
    warnings : what the scene should know before it starts, a line each
    ticks    : let time pass;   pieces : of a tick;   islands : each in its own manner
    memory   : what the next tick starts from
    readout  : what can be read of ticks that have passed
    """

    def __init__(self, scene: Scene, layout: Layout, integrator: Integrator) -> None:
        reason = unsuited(integrator)
        if reason is not None:
            raise InvalidModel(
                f'integrator {integrator.name!r} refuses the scene {scene.name!r}: {reason}',
                at=('integrator',),
            )
        settings = ContactSettings.of(scene.contact)
        self._events = settings.mode == EVENT
        self._layout = layout
        self._integrator = integrator
        colliders = Colliders.of(scene, layout)
        self.warnings = (
            *convexity_warnings(scene),
            *small_body_warnings(scene, colliders),
            *unresolved_motion_warnings(scene),
        )
        self._kinds = colliders.pairs()
        fixed = colliders.types[colliders.bodies == collider_record.STATIC]
        self._corners = len(fixed) > 1 or SURFACE in fixed
        materials = colliders.materials.reshape(-1, material.SIZE)
        rules = pair_rules(scene.contact, layout.names)
        materials = np.concatenate((materials, rules.materials))  # in the same columns
        resistances = materials[:, [material.ROLLING_FRICTION, material.TORSIONAL_FRICTION]]
        self._angular = bool(np.any(resistances > 0.0))
        self._bounces = bool(np.any(materials[:, material.RESTITUTION] > 0.0))
        self._width = (
            contact_point.SIZE_LONG if self._angular or self._bounces else contact_point.SIZE
        )
        flows = variable_mass.flows_of(layout, colliders.bodies.tolist())
        self.arrays = WorldArrays(
            layout.n_moving,
            self._width,
            flows,
            layout.pivoted,
            holds=self._holds,
            recycles=self._recycles,
        )
        self.arrays.take_colliders(colliders, order(scene, colliders))
        self.arrays.take_settings(settings)
        rows = integrator.coefficients(layout.moments).shape[1]
        self.arrays.take_integrator(rows)
        self.arrays.take_events(rows, wanted=self._events)
        self.arrays.take_pair_rules(rules, len(scene.bodies))
        self._sleepers = self._make_sleepers(scene, settings.sleeping)
        self.arrays.pack()
        self._kernels: dict[str, Callable[..., Any]] = {}
        self._take_workers(scene)

    def _take_workers(self, scene: Scene) -> None:
        """Make who works with the arrays."""
        layout, arrays, sleepers = self._layout, self.arrays, self._sleepers
        count, substeps = layout.n_moving, self._integrator.substeps
        written = Written(self._width, self._angular, self._bounces, self._events, substeps)
        self.readout = WorldReadout(scene, layout, arrays, sleepers, written)
        self.memory = WorldMemory(arrays, sleepers, self.readout)
        self.pieces = Pieces(arrays, sleepers, self.readout)
        self.islands = IslandTicks(
            groups_of(scene, layout), arrays, self.readout, sleeps=sleepers is not None
        )
        cut_ticks = CutTicks(count, arrays, self.readout, self.pieces, self.islands)
        self.ticks = Ticks(count, arrays, self.readout, self.pieces, cut_ticks)

    @property
    def _holds(self) -> bool:
        """Whether points of some pairs depend on those of the last tick: see `held_features`."""
        return not HELD_KINDS.isdisjoint(self._kinds)

    @property
    def _balls_meet(self) -> bool:
        """Whether two balls may meet, or one several that cannot move: see `ball_impacts`."""
        return (SPHERE, SPHERE) in self._kinds or (
            any(SPHERE in kinds for kinds in self._kinds) and self._corners
        )

    @property
    def _recycles(self) -> bool:
        """Whether manifolds of some pairs follow their bodies: see `collision.recycling`."""
        return not (self._events or RECYCLED_KINDS.isdisjoint(self._kinds))

    def _make_sleepers(self, scene: Scene, sleeping: bool) -> Any:
        """Make what keeps the contacts of sleepers; None where nobody may sleep."""
        if not sleeping:
            nobody = make_sleep_state(np.zeros(0), np.zeros(0, dtype=np.int64))
            self.arrays.take_sleep_state(nobody)
            return None
        from rigid_body_sim.physics.contact.islands.sleepers import Sleepers

        arrays = self.arrays
        sleepers = Sleepers(
            scene, self._layout, arrays.table, arrays.local_bounds, arrays.local_poses
        )
        arrays.take_sleep_state(sleepers.state)
        return sleepers

    def take_tick(self, h: float) -> None:
        """Take over the length of a whole tick [s]."""
        if h != self.readout.whole:
            self.arrays.settings[tick_settings.WHOLE_TICK] = h
            self.readout.take_tick(h)

    def take_pulled(self, bodies: Callable[[], NDArray[np.bool_]]) -> None:
        """Take over on which bodies forces act that depend on the state or on time."""
        if self._events:
            self.arrays.take_pulled(bodies())

    def kernel(
        self, scene: str, evaluate: Callable[..., Any] | None, velocity_dependent: bool
    ) -> Callable[..., Any]:
        """
        Make the kernel of the scene, with the usual call of a scheme.

        scene, evaluate, velocity_dependent : as of `Scheme.coupled`; evaluate None: nothing
                                              depends on the state
        """
        if scene not in self._kernels:
            compiled = self._compile(scene, evaluate, velocity_dependent)
            self._kernels[scene] = self.ticks.of_kernel(compiled, apart=self._apart(evaluate))
        return self._kernels[scene]

    def _apart(self, evaluate: Callable[..., Any] | None) -> bool:
        """Whether islands may pass their substeps one after the other, or at once."""
        arrays = self.arrays
        together = arrays.flows.size or arrays.drives.size or arrays.pivoted.size
        return evaluate is None and not together

    def _compile(
        self, scene: str, evaluate: Callable[..., Any] | None, velocity_dependent: bool
    ) -> Callable[..., Any]:
        """Make the kernel of the ticks: only what the scene needs."""
        assert isinstance(self._integrator.scheme, Splitting)
        flows = bool(self.arrays.flows.size)
        pairs = [(a, b, collide_kernel(a, b)) for a, b in self._kinds]
        features = symmetry_features(self._kinds, off_center=self.arrays.has_ball_off_center())
        driven = bool(self.arrays.drives.size)
        iterations = solver(
            width=self._width,
            angular=self._angular,
            bounces=self._bounces,
            turns=bool(np.ptp(self._layout.moments, axis=1).any()) or flows,
            arcs=self.arrays.has_surface_that_turns(),
            **features,
        )
        return step.tick_kernel(
            f'{self._integrator.name}_{scene}',
            WIDTH=self._width,
            ANGULAR=self._angular,
            BOUNCES=self._bounces,
            CURVED=features['curved'],
            BALLS_MEET=self._balls_meet,
            COUPLED=evaluate is not None,
            APART=self._apart(evaluate),
            EVENTS=self._events,
            VELOCITY_DEPENDENT=velocity_dependent,
            SLEEPING=self._sleepers is not None,
            FLOWS=flows,
            DRIVES=driven,
            IGNORES=bool(self.arrays.ignored.size),
            HOLDS=self._holds,
            RECYCLES=self._recycles,
            drift_rotation=self._integrator.scheme.drift_rotation,
            evaluate=_nothing if evaluate is None else evaluate,
            **manifold_finder(
                pairs, holds=self._holds, recycles=self._recycles, events=self._events
            ),
            **{'apply_restitution': _nothing, **iterations},
            **self._impacts_of(pairs),
        )

    def _impacts_of(self, pairs: Any) -> dict[str, Any]:
        """Make the kernels of impacts at their instants, where the scene wants them."""
        if not self._events:
            return dict.fromkeys(('find_impacts', 'meet_now', 'land'), _nothing)
        from rigid_body_sim.physics.contact.events.impact_kernels import impact_kernels

        scheme = self._integrator.scheme
        assert isinstance(scheme, Splitting)
        made = impact_kernels(self._integrator.name, pairs, drift_rotation=scheme.drift_rotation)
        return made._asdict()


def _nothing(*_arguments: Any) -> None:
    """Stand for forces, or bounces, in a scene without."""
