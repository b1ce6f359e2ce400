# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""The command line of what a run publishes beside its states; see `runs.viewing`."""

from __future__ import annotations

import argparse

from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.runs.view import EVERY_BODY, ViewSettings
from rigid_body_sim.runs.viewing import (
    LARGEST_SCALE,
    MARKER_RATE,
    check_view,
    marker_every,
)
from rigid_body_sim.runs.views import VIEWS

LEAST_RATE, MOST_RATE = 1e-9, 1e9  # [Hz]


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the options; what is not asked for is not recorded."""
    group = parser.add_argument_group('what viewers and controllers ask for, as the node has it')
    for view in VIEWS.values():
        group.add_argument(view.option, action='store_true', help=f'record {view.description}')
    group.add_argument(
        '--marker-rate',
        type=float,
        default=MARKER_RATE,
        metavar='HZ',
        help=f'markers per second, default {MARKER_RATE:g}; rounded to recorded states',
    )
    group.add_argument(
        '--arrow-scale',
        type=float,
        default=0.0,
        metavar='M/N',
        help='length of arrows, default 0: chosen from the scene',
    )
    group.add_argument(
        '--frame-prefix',
        default='',
        metavar='TEXT',
        help='before the names of frames of bodies, such as lab/',
    )
    group.add_argument(
        '--body-topics',
        default=EVERY_BODY,
        metavar='NAMES',
        help='bodies that have topics of their own: names or patterns (* and ?), separated by '
        'commas, or none; default all',
    )


def settings_of(arguments: argparse.Namespace, *, publish_every: int, dt_ns: int) -> ViewSettings:
    """Read the options; UserError for what cannot be used."""
    rate, scale = arguments.marker_rate, arguments.arrow_scale
    if not LEAST_RATE <= rate <= MOST_RATE:
        raise UserError(f'--marker-rate {rate:g} Hz; allowed: {LEAST_RATE:g} to {MOST_RATE:g} Hz')
    if not 0.0 <= scale <= LARGEST_SCALE:
        raise UserError(
            f'--arrow-scale {scale:g} m/N; allowed: 0 (of the scene) to {LARGEST_SCALE:g}'
        )
    return ViewSettings(
        frozenset(name for name, view in VIEWS.items() if getattr(arguments, view.word)),
        marker_every=marker_every(rate, publish_every, dt_ns),
        arrow_scale=scale,
        frame_prefix=arguments.frame_prefix,
        body_topics=arguments.body_topics,
    )


def names_of(arguments: argparse.Namespace, scene: Scene) -> list[str]:
    """Name the bodies with topics of their own, before anything is compiled; UserError."""
    return check_view(scene, settings_of(arguments, publish_every=1, dt_ns=1), 'world')
