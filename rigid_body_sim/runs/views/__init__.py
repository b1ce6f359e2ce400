# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The registry of views: every module of this folder that defines `VIEW`.

To add one, write one file.
"""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules

from rigid_body_sim.runs.view import View

# So their flags stand in manifests that exist; others follow by name.
_FIRST = ('odometry', 'transforms', 'markers', 'arrays', 'contact_wrenches')


def _found() -> dict[str, View]:
    modules = [module.name for module in iter_modules(__path__)]
    names = [*_FIRST, *sorted(set(modules) - set(_FIRST))]
    found = (getattr(import_module(f'{__name__}.{name}'), 'VIEW', None) for name in names)
    return {view.name: view for view in found if view is not None}


VIEWS = _found()
