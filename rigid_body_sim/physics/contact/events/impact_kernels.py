# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The kernels of impacts for one scene: its integrator, its pairs of shapes, what its forces need.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from rigid_body_sim.physics.compile.kernels import specialise
from rigid_body_sim.physics.contact.collision.collider import SURFACE
from rigid_body_sim.physics.contact.collision.narrow_phase import collider_of_pairs
from rigid_body_sim.physics.contact.events import (
    closest_axis,
    contact_points,
    first_instants,
    flight,
    flush_faces,
    free_points,
    ground_parts,
    impact,
    impact_queue,
    joint,
    neighbours,
    on_ground,
    present_instant,
    time_of_impact,
)


class ImpactKernels(NamedTuple):
    """
    What the tick calls.

    find_impacts : see `impact_queue`
    meet_now     : see `present_instant`
    land         : see `impact_queue`
    """

    find_impacts: Callable[..., Any]
    meet_now: Callable[..., Any]
    land: Callable[..., Any]


def impact_kernels(
    name: str, kernels: Sequence[tuple[int, int, Callable[..., Any]]], *,
    drift_rotation: Callable[..., Any],
) -> ImpactKernels:  # fmt: skip
    """
    Make the kernels of impacts of a scene.

        name           : of the integrator
        kernels        : (type of A, type of B, pair kernel)
        drift_rotation : of the integrator, see `schemes.splitting`
    """
    ground = any(type_b == SURFACE for _, type_b, _ in kernels)
    offered: dict[str, Any] = {
        'drift_rotation': drift_rotation,
        'collide': collider_of_pairs(kernels),
        'GROUND': ground,
        **dict.fromkeys(_OF_GROUND, _nothing),
    }

    def make(slot: str, function: Any) -> None:
        offered[slot] = specialise(function, name=name, offered=offered)

    make('turned', flight._turned)
    make('look', flight._look)
    make('bring', flight._bring)
    if ground:
        make('axis_to_triangle', ground_parts._axis_to_triangle)
        make('ask_surface', on_ground._ask_surface)
        make('points_on_ground', on_ground._points_on_ground)
        offered['all_lie_over'] = on_ground.all_lie_over
    make('axis', closest_axis._axis)
    make('find_instant', time_of_impact._find_instant)
    make('find_points', contact_points._find_points)
    make('find_manifold', free_points._find_manifold)
    make('measure_free_points', free_points._measure_free_points)
    make('list_free_points', free_points._list_free_points)
    offered['put_touching'] = joint.put_touching
    offered['meet_at_points'] = joint.meet_at_points
    make('add_flush_points', flush_faces._add_flush_points)
    offered['write_flush_impacts'] = flush_faces.write_flush_impacts
    make('add_carriers', joint._add_carriers)
    make('meet_with_load', joint._meet_with_load)
    make('strike', impact._strike)
    make('closing_speed', first_instants._closing_speed)
    make('is_left_to_solver', first_instants._is_left_to_solver)
    make('wants_a_cut', impact_queue._wants_a_cut)
    if ground:
        make('lies_over_facet', on_ground._lies_over_facet)
        make('take_part', on_ground._take_part)
        make('find_on_facets', on_ground._find_on_facets)
        make('find_on_triangles', on_ground._find_on_triangles)
        make('find_on_ground', on_ground._find_on_ground)
        make('measure_ground', on_ground._measure_ground)
        make('ask_ground_first', first_instants._ask_ground_first)
    make('ask_first', first_instants._ask_first)
    make('ask_all', first_instants._ask_all)
    make('begin_anew', first_instants._begin_anew)
    make('find_events', first_instants._find_events)
    make('ask_neighbours', neighbours._ask_neighbours)
    make('ask_again', impact_queue._ask_again)
    make('follow_impacts', impact_queue._follow_impacts)
    make('find_impacts', impact_queue._find_impacts)
    make('measure', present_instant._measure)
    make('next_of_cluster', present_instant._next_of_cluster)
    make('find_flush', present_instant._find_flush)
    make('meet_now', present_instant._meet_now)
    make('land', impact_queue._land)
    return ImpactKernels(offered['find_impacts'], offered['meet_now'], offered['land'])


# what only scenes with ground of triangles call
_OF_GROUND = (
    'axis_to_triangle', 'ask_surface', 'points_on_ground', 'all_lie_over', 'find_on_ground',
    'measure_ground', 'ask_ground_first',
)  # fmt: skip


def _nothing(*_arguments: Any) -> None:
    """Stand for what a scene has not."""
