# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A Dask cluster of its own and sweeps on it, in a process of its own: what Dask leaves behind are
threads, and tests that compile make copies of their process.

    python dask_session.py SCENE FOLDER    writes plain.parquet and killed.parquet

It fails if a scheduler that is not there is taken.
"""

import json
import os
import signal
import sys
from pathlib import Path

import distributed

import rigid_body_sim as rbs
from rigid_body_sim.errors import UserError
from rigid_body_sim.sweeps import cluster as cluster_module


def main(scene, folder):
    asked, folder = json.loads(Path(scene).read_text()), Path(folder)
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, host='127.0.0.1', dashboard_address=None
    ) as cluster:
        address = cluster.scheduler_address
        rbs.sweep(**asked, scheduler=address, output=folder / 'plain.parquet')
        killed = []

        def kill_one(done, _runs):
            if done >= 1 and not killed:
                killed.append(next(iter(cluster.workers.values())).pid)
                os.kill(killed[0], signal.SIGKILL)

        more = {'scheduler': address, 'progress': kill_one}
        rbs.sweep(**asked, **more, output=folder / 'killed.parquet')
        assert killed
    cluster_module.CONNECTS_WITHIN = 0.5
    try:
        rbs.sweep(**asked, scheduler='tcp://127.0.0.1:9')
    except UserError as refused:
        assert 'no Dask scheduler answers there' in str(refused)
    else:
        raise AssertionError('a scheduler that is not there was taken')


if __name__ == '__main__':
    main(*sys.argv[1:])
