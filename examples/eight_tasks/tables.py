# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A run becomes a bag, a Parquet file and a data frame; all of them have the same numbers."""

import tempfile
from pathlib import Path

import pandas as pd

import rigid_body_sim as rbs

folder = Path(tempfile.mkdtemp())
run = rbs.simulate('two_bodies', duration=2, every=0.01)
run.save(folder / 'bag')
rbs.open_bag(folder / 'bag').to_parquet(folder / 'run.parquet')
table = pd.read_parquet(folder / 'run.parquet').set_index('time')
print(table[['box.position.z', 'ball.velocity.z', 'energy']].tail(3))
assert (table['box.position.z'] == run['box'].position[:, 2]).all()
