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

    from rigid_body_sim.physics.diagnostics.energy_balance import EnergyBalance

__all__ = ['WHOLE', 'BodyRun', 'Origin', 'Run']


class Run(RunArrays):
    __doc__ = RunArrays.__doc__

    @property
    def energy_balance(self) -> EnergyBalance | None:
        """
        What commands, drives, dampers, contact and the method did to the energy [J]: the record of
        `simulate --json`; None where a bag tells none.

            change = work_of_commands + work_of_drives - dissipation - contact + defect

        A run in memory is made again for it when it is first asked for, which takes about twice as
        long as the run did. Raises RunError where it then comes out otherwise, see `Run.save`.
        """
        from rigid_body_sim.library import account  # only who asks for it waits

        return account.balance_of(account.ending_of(self))

    def summary(self) -> str:
        """
        Say what the run is, how it ended, what became of its energy, and its warnings.

        A run that took long says nothing of its energy until `energy_balance` was asked for.
        """
        from rigid_body_sim.library import account  # only who asks for it waits

        return account.summary_of(self)

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
