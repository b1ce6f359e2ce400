# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The simulations of one test: started one by one, ended together, their bags kept or removed.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from rigid_body_sim.testing.domains import DomainLease
from rigid_body_sim.testing.failures import NodeFailure, told_at_the_caller, with_last_lines
from rigid_body_sim.testing.kept_bags import keep, replay_line
from rigid_body_sim.testing.live_simulation import LiveSimulation
from rigid_body_sim.testing.surroundings import surroundings

_OF_WORKER: list[DomainLease] = []  # the domain of this process, as soon as a test needs one


class Simulations:
    """
    What one test starts.

    folder : for what the nodes write
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._started: list[LiveSimulation] = []
        self._leases: list[DomainLease] = []
        if not _OF_WORKER:
            _OF_WORKER.append(DomainLease())
        changes = surroundings(_OF_WORKER[0].number, os.environ)
        self._before = {name: os.environ.get(name) for name in changes}
        _change(changes)  # so that nodes that the test starts meet the simulation

    @told_at_the_caller
    def start(
        self,
        scene: Any,
        *,
        lockstep: Iterable[str] = (),
        namespace: str = '',
        hear: Iterable[str] | None = None,
        **parameters: Any,
    ) -> LiveSimulation:
        """
        Start the node for a scene; NodeFailure, with its own words, if it refuses.

        scene      : name of a shipped scene, path, or mapping with the keys of a scene file
        lockstep   : command topics that `LiveSimulation.lockstep` answers, in the order in which
                     they are applied, one in several frames as 'drone/wrench@front_left'; the
                     node then goes as fast as it can
        namespace  : of the node
        hear       : bodies whose states are heard; None: all
        parameters : of the node, by name
        """
        folder = self._folder / str(len(self._started) + 1)
        folder.mkdir()
        simulation = LiveSimulation(
            scene,
            lockstep=lockstep,
            namespace=namespace,
            hear=hear,
            parameters=parameters,
            folder=folder,
            domain=self._domain(),
        )
        self._started.append(simulation)
        simulation.wait_until_ready()
        return simulation

    def _domain(self) -> int:
        """Give the domain of the worker; beside another that runs, one more."""
        own = _OF_WORKER[0]
        if all(one.has_ended or one.domain != own.number for one in self._started):
            return own.number
        self._leases.append(DomainLease())
        return self._leases[-1].number

    def sections(self) -> list[tuple[str, str]]:
        """What the report of a failed test shows of each node."""
        return [
            (f'node {number}', with_last_lines(one.where, one.said))
            for number, one in enumerate(self._started, start=1)
        ]

    def end(self) -> list[str]:
        """End all, the last one first; return what went wrong."""
        problems = []
        for simulation in reversed(self._started):
            try:
                simulation.end()
            except NodeFailure as failure:
                problems.append(str(failure))
            finally:
                simulation.close()
        for lease in self._leases:
            lease.end()
        _change(self._before)
        return problems

    def keep(self, root: Path, test: str) -> list[str]:
        """Keep the bags of a test that failed; return the lines that replay them."""
        bags = [bag for simulation in self._started for bag in simulation.bags]
        own = [bag.is_relative_to(self._folder) for bag in bags]
        kept = [
            keep(bag, root, test, number) if mine else bag
            for number, (bag, mine) in enumerate(zip(bags, own), start=1)
        ]
        if not any(bag.is_relative_to(self._folder) for bag in kept):
            self.discard()
        return [replay_line(bag) for bag in kept]

    def discard(self) -> None:
        """Remove what the nodes wrote."""
        shutil.rmtree(self._folder, ignore_errors=True)


def _change(changes: dict[str, str | None]) -> None:
    for name, value in changes.items():
        if value is None:
            os.environ.pop(name, None)
        else:
            os.environ[name] = value
