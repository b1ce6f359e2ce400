# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The colours of pictures and pages, the same in both, and dashes that tell bodies apart in print and
for the colour-blind.

Bodies have eight colours after Okabe and Ito (2008, "Color Universal Design"): their black, which
a dark page would hide, is a purple, and their yellow is last and darkened for white paper. The
dash changes with every body as well, so that colour is never the only sign. What cannot move is
grey. What has x, y and z is red, green and blue on a page (page/palette.js).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rigid_body_sim.physics.model.scene import Scene

COLORS = ('#0072B2', '#D55E00', '#009E73', '#CC79A7', '#8C6BB1', '#56B4E9', '#E69F00', '#B8A800')
DASHES = ('-', '--', '-.', ':', (0, (6, 1.5, 1, 1.5, 1, 1.5)))
NAMED_BODIES = 10  # bodies with a line of their own and a name in the legend
OTHERS = {'color': '#999999', 'linestyle': '-', 'linewidth': 0.5, 'alpha': 0.5, 'zorder': 1}


def color_places(names: Sequence[str], scene: Scene | None) -> dict[str, int]:
    """Number the bodies that can move, in their order: the place that `style` and COLORS take."""
    still = {
        body.name
        for body in (() if scene is None else scene.bodies)
        if body.fixed and body.motion is None
    }
    return {name: place for place, name in enumerate(n for n in names if n not in still)}


def style(place: int) -> dict[str, Any]:
    """Line style of the body at a place (`color_places`); grey from the eleventh on."""
    if place >= NAMED_BODIES:
        return dict(OTHERS)
    return {
        'color': COLORS[place % len(COLORS)],
        'linestyle': DASHES[place % len(DASHES)],
        'linewidth': 1.6,
        'zorder': 3,
    }
