# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The registry of integrators: every module of this folder that defines `INTEGRATOR`.

To add one, write one file.
"""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module
from pkgutil import iter_modules

from rigid_body_sim.physics.integrators.integrator import Integrator
from rigid_body_sim.physics.integrators.options import SUBSTEPS


def _found() -> dict[str, Integrator]:
    found = {}
    for module in iter_modules(__path__):
        integrator = getattr(import_module(f'{__name__}.{module.name}'), 'INTEGRATOR', None)
        if integrator is not None:
            options = {**integrator.options, 'substeps': SUBSTEPS}
            found[integrator.name] = replace(integrator, options=options)
    return found


INTEGRATORS = _found()
DEFAULT_INTEGRATOR = 'dmv6'
