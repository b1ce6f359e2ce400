# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Bags without a given name: nodes that begin in one second in one folder do not collide."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Barrier

import pytest

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.errors import UserError
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.ros.bags import Bags
from rigid_body_sim.runs.run import Run, RunSettings

NODES = 6


def test_each_of_many_that_begin_together_gets_a_bag_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    runs = [Run(Simulation(load_scene('free_fall')), RunSettings()) for _ in range(NODES)]
    together = Barrier(NODES)

    def begin(run):
        bags = Bags(run, None)
        together.wait()
        path = bags.start()
        bags.stop('stopped')
        return path

    with ThreadPoolExecutor(NODES) as pool:
        paths = list(pool.map(begin, runs))
    assert len(set(paths)) == NODES
    assert sorted(paths) == sorted(Path(path.name) for path in tmp_path.iterdir())
    assert all(Bag(path).complete for path in paths)

    taken = Bags(runs[0], paths[0])
    with pytest.raises(UserError, match='exists already'):
        taken.start()
    assert not taken.is_open
