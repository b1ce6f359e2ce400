# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The registry of integrators: a module of this folder defines `INTEGRATOR` and bears its name.

To add one, write one file. A method is imported when it is asked for: a run that uses one does not
wait for the others.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from importlib import import_module
from pkgutil import iter_modules

from rigid_body_sim.physics.integration.integrator import Integrator, NeedsSteadyInertia
from rigid_body_sim.physics.integration.options import SUBSTEPS


class Registry(Mapping[str, Integrator]):
    """Integrators by name."""

    def __init__(self) -> None:
        self._found: dict[str, Integrator | None] = {
            module.name: None for module in iter_modules(__path__)
        }

    def __getitem__(self, name: str) -> Integrator:
        known = self._found[name]
        if known is None:
            integrator: Integrator = import_module(f'{__name__}.{name}').INTEGRATOR
            refuses = integrator.refuses
            if not integrator.follows_inertia:
                refuses = NeedsSteadyInertia(name, refuses)
            options = {**integrator.options, 'substeps': SUBSTEPS}
            known = replace(integrator, options=options, refuses=refuses)
            self._found[name] = known
        return known

    def __iter__(self) -> Iterator[str]:
        return iter(self._found)

    def __len__(self) -> int:
        return len(self._found)


INTEGRATORS = Registry()
