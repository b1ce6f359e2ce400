# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Angles below which two lines count as parallel: squared sines [-], by what is made of the two.

A larger one takes the normal of a side, or the ends, where edges cross at so small an angle; a
smaller one lets the direction of a normal, or the place of a nearest point, be round-off.
"""

from __future__ import annotations

NO_COMMON_NORMAL = 1e-6  # the normal across both, where a side may give it too: within 1 mrad
NO_CROSS_PRODUCT = 1e-12  # their cross product: below, its direction is round-off
NO_NEAREST_POINT = 1e-16  # the nearest point of the one: below, all its points are as near
