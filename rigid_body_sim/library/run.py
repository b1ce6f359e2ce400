# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A run as Python users hold it: its arrays, and what becomes of them."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from rigid_body_sim.library.run_arrays import WHOLE, BodyRun, Origin, RunArrays

if TYPE_CHECKING:
    import pandas
    import xarray

__all__ = ['WHOLE', 'BodyRun', 'Origin', 'Run']


class Run(RunArrays):
    __doc__ = RunArrays.__doc__

    def _repr_html_(self) -> str:
        from rigid_body_sim.library import notebook  # only who asks for it waits

        return notebook.html_of_run(self)

    def to_pandas(self) -> pandas.DataFrame:
        """Give the table of `export` as a DataFrame: `time`, columns of each body, energies."""
        from rigid_body_sim.library import tables  # only who asks for it waits

        return tables.to_pandas(self)

    def to_xarray(self) -> xarray.Dataset:
        """Give a Dataset with the dimensions time, body and axis (or quaternion)."""
        from rigid_body_sim.library import tables  # only who asks for it waits

        return tables.to_xarray(self)

    def to_parquet(self, path: str | os.PathLike[str]) -> None:
        """Write the table of `export` as a Parquet file; one that exists is replaced."""
        from rigid_body_sim.library import tables  # only who asks for it waits

        tables.write_parquet(self, path)

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Write the table of `export` as a CSV file, exact; one that exists is replaced."""
        from rigid_body_sim.library import tables  # only who asks for it waits

        tables.write_csv(self, path)

    def save(self, path: str | os.PathLike[str]) -> None:
        """
        Write a bag that holds the scene, the start, the commands and every row: it checks whole
        and replays bit for bit.

        The run is made again for it, and must come out the same. Raises UserError where the path
        is taken, or this run came from a bag; RunError where something else than the controller
        changed the simulation on the way.
        """
        from rigid_body_sim.library import to_bag  # only who asks for it waits

        to_bag.write_bag(self, path)
