# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The problems: a module of this folder defines `PROBLEM` and bears its name.

To add one, write one file.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from importlib import import_module
from pkgutil import iter_modules

from rigid_body_sim.report.problem import Problem


class Registry(Mapping[str, Problem]):
    """Problems by name; each is imported, and its exact end computed, when it is asked for."""

    def __init__(self) -> None:
        self._names = [module.name for module in iter_modules(__path__)]

    def __getitem__(self, name: str) -> Problem:
        if name not in self._names:
            raise KeyError(name)
        return import_module(f'{__name__}.{name}').PROBLEM

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)


PROBLEMS = Registry()
