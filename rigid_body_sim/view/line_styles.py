# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Colours and dashes that tell bodies apart in print and for the colour-blind.

Eight colours after Okabe and Ito (2008, "Color Universal Design"), their yellow last and darkened
for white paper; the dash changes with every body as well, so that colour is never the only sign.
"""

from __future__ import annotations

from typing import Any

COLORS = ('#0072B2', '#D55E00', '#009E73', '#CC79A7', '#000000', '#56B4E9', '#E69F00', '#B8A800')
DASHES = ('-', '--', '-.', ':', (0, (6, 1.5, 1, 1.5, 1, 1.5)))
NAMED_BODIES = 10  # bodies with a line of their own and a name in the legend
OTHERS = {'color': '#999999', 'linestyle': '-', 'linewidth': 0.5, 'alpha': 0.5, 'zorder': 1}


def style(place: int) -> dict[str, Any]:
    """Line style of the body at a place in the bag; grey from the eleventh on."""
    if place >= NAMED_BODIES:
        return dict(OTHERS)
    return {
        'color': COLORS[place % len(COLORS)],
        'linestyle': DASHES[place % len(DASHES)],
        'linewidth': 1.6,
        'zorder': 3,
    }
