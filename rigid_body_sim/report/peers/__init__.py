# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Other engines, measured beside ours: a module of this folder with `ENGINE`, `PACKAGE` and `load`.

    ENGINE  : name of the engine, as its authors write it
    PACKAGE : what pip installs
    load    : () -> its version and the ways to run it; imports the engine, so ImportError where it
              is absent
    start   : (task, dt [s]) -> a program that makes one step, and what it reads; may be missing

To add an engine, write one file. An engine that is not there becomes a row with the reason. All of
them: `pip install rigid_body_sim[peers]`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from importlib import import_module
from pkgutil import iter_modules
from typing import Any, NamedTuple

from rigid_body_sim.report.entry import Peer
from rigid_body_sim.report.peers.engine import Engine
from rigid_body_sim.report.peers.task import Task
from rigid_body_sim.report.problem import Problem


class Absent(NamedTuple):
    """An engine that could not be measured, and why."""

    engine: str
    reason: str


def names() -> list[str]:
    """Modules of engines, whether those are installed or not."""
    return [
        module.name for module in iter_modules(__path__) if hasattr(_module(module.name), 'ENGINE')
    ]


def find(wanted: Iterable[str] | None = None) -> tuple[list[Peer], list[Absent]]:
    """
    Load the engines that are installed.

    wanted  : module names; None: all
    returns : those that can be measured, and the others with a reason each
    """
    found: list[Peer] = []
    absent: list[Absent] = []
    for name in names() if wanted is None else wanted:
        module = _module(name)
        try:
            version, ways = module.load()
        except ImportError as missing:
            reason = f'not installed ({missing}); pip install {module.PACKAGE}'
            absent.append(Absent(module.ENGINE, reason))
        else:
            found.append(Engine(module.ENGINE, version, ways, getattr(module, 'PRECISION', 'f64')))
    return found, absent


def engine_of(name: str) -> str:
    """Name of the engine of a module, as its authors write it."""
    return _module(name).ENGINE


class Started(NamedTuple):
    """A program that imports an engine, builds a problem and makes one step."""

    engine: str
    version: str
    program: str
    reads: str


def start_of(name: str, problem: Problem, dt: float) -> Started | None:
    """Give the start of an engine; None where it is absent or nobody wrote one."""
    module = _module(name)
    if not hasattr(module, 'start'):
        return None
    try:
        version, _ = module.load()
    except ImportError:
        return None
    return Started(module.ENGINE, version, *module.start(Task.of(problem), dt))


def how_run(points: Iterable[Mapping[str, Any]]) -> list[tuple[str, str, str]]:
    """
    Say how the engines of some points were run.

    returns : name, version, and the text of the engine's module in one line
    """
    versions = {point['engine']: point['version'] for point in points}
    found = []
    for name in names():
        module = _module(name)
        if module.ENGINE in versions:
            _, _, text = ' '.join((module.__doc__ or '').split()).partition(': ')
            found.append((module.ENGINE, versions[module.ENGINE], text[:1].upper() + text[1:]))
    return found


def _module(name: str) -> Any:
    return import_module(f'{__name__}.{name}')
