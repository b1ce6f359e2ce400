# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The registry of force elements: every module of this folder that defines `ELEMENT`.

To add one, write one file.
"""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules

from rigid_body_sim.physics.forces.element import ForceElement


def _found() -> dict[str, type[ForceElement]]:
    found = {}
    for module in iter_modules(__path__):
        element = getattr(import_module(f'{__name__}.{module.name}'), 'ELEMENT', None)
        if element is not None:
            found[element.TYPE] = element
    return found


FORCES = _found()
