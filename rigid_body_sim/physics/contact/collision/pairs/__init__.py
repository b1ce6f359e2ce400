# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The pair kernels: for each pair of types one module `<type>_<type>` with a kernel `collide`.

To add one, write one file (`geometry.manifold` says what the kernel gets and gives). A module is
imported and compiled when a scene needs its pair: what does not occur costs nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

from rigid_body_sim.physics.contact.collision.collider import NAMES


def collide_kernel(type_a: int, type_b: int) -> Callable[..., Any]:
    """
    Return the kernel of a pair of types.

    type_a <= type_b: numbers of `collider`
    ValueError for the wrong order and for two of planes and surfaces, which are static.
    """
    if not 0 <= type_a <= type_b < len(NAMES) or NAMES[type_a] in ('plane', 'surface'):
        raise ValueError(
            f'pair of types ({type_a}, {type_b}): got no pair that can meet; need '
            f'0 <= type_a <= type_b < {len(NAMES)}, not both static: exchange the two'
        )
    return import_module(f'{__name__}.{NAMES[type_a]}_{NAMES[type_b]}').collide
