# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A run as arrays: one row per published instant, the first of them where the run began.

    run.time                       (m,) [s]
    run['box'].position            (m, 3) [m], and what else `BodyRun` lists
    run.energy                     (m,) [J]

Commands: a row of `force` and `torque` is the last `applied_wrench` of a bag that begins at its
instant or before: what a controller answered there acts from that row on. A command that is given
anew at an instant stands in its row as it acts from there on; one that goes on stands as it acted
over the tick before (in world axes that is the same; in axes of a body it is a tick older).

All arrays are read-only. A run in memory has what the simulation had, to the bit; a run from a bag
has what the bag has, and momenta, energies and rates in body axes are computed from that.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.diagnostics.invariants import Invariants
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.state import snapshot
from rigid_body_sim.physics.state.impacts import NO_IMPACTS, Impacts
from rigid_body_sim.physics.state.layout import unknown_body
from rigid_body_sim.physics.state.snapshot import State

Array = NDArray[np.float64]

WHOLE = 'duration'  # how a run ends that came to its end
MOST_SHOWN = 6  # names in a repr


@dataclass(frozen=True)
class Origin:
    """
    From what a run in memory can be made again, bit for bit.

    start     : what `Simulation.__getstate__` gave before the first tick
    commands  : (tick, body, force, torque, frame) of the controller, as they were given
    choices   : changes of integrator that `auto` made on the way
    final     : `Simulation.state_bytes()` at the end
    """

    start: Mapping[str, Any]
    commands: Sequence[tuple[int, str, Sequence[float], Sequence[float], str]]
    choices: Sequence[Any]
    final: bytes


@dataclass(frozen=True, eq=False)
class BodyRun:
    """
    One body through a run; all arrays are read-only, one row per instant.

    name  : of the body
    time  : (m,) [s]
    force, torque : (m, 3) [N], [N m]  what commands exert, world axes, at the centre of mass; NaN
                    where a bag does not tell; which instant they belong to: see the module
    """

    name: str
    time: Array
    force: Array
    torque: Array
    _values: Array = field(repr=False)

    @property
    def position(self) -> Array:
        """Centre of mass (m, 3) [m], world."""
        return self._values[:, snapshot.POSITION : snapshot.ORIENTATION]

    @property
    def orientation(self) -> Array:
        """Unit quaternions (m, 4) [-], xyzw, body to world; (0, 0, 0, 1) of a point mass."""
        return self._values[:, snapshot.ORIENTATION : snapshot.VELOCITY]

    @property
    def velocity(self) -> Array:
        """Velocity of the centre of mass (m, 3) [m/s], world."""
        return self._values[:, snapshot.VELOCITY : snapshot.ANGULAR_VELOCITY]

    @property
    def angular_velocity(self) -> Array:
        """Angular velocity (m, 3) [rad/s], world axes."""
        return self._values[:, snapshot.ANGULAR_VELOCITY : snapshot.ANGULAR_VELOCITY_BODY]

    @property
    def angular_velocity_body(self) -> Array:
        """Angular velocity (m, 3) [rad/s], body axes."""
        return self._values[:, snapshot.ANGULAR_VELOCITY_BODY : snapshot.MOMENTUM]

    @property
    def momentum(self) -> Array:
        """Momentum (m, 3) [kg m/s], world; NaN where a bag holds no scene."""
        return self._values[:, snapshot.MOMENTUM : snapshot.ANGULAR_MOMENTUM]

    @property
    def angular_momentum(self) -> Array:
        """Angular momentum about the centre of mass (m, 3) [kg m^2/s], world axes; or NaN."""
        return self._values[:, snapshot.ANGULAR_MOMENTUM : snapshot.COLUMNS]

    def __repr__(self) -> str:
        return f'<{self.name!r} at {_instants(self.time)}>'


@dataclass(frozen=True, eq=False)
class RunArrays:
    """
    What a simulation did, or what a bag holds, as arrays: the numbers of a `Run`.

    names      : of the bodies, in the order of the scene
    time       : (m,) [s]  of the rows: simulated time, from 0 where the simulation began there
    scene      : None where a bag holds none
    integrator : its name at the start; '' where a bag does not tell
    dt         : [s] tick length; NaN likewise
    end_reason : 'duration' where it came to its end; 'diverged', 'stopped' (interrupt), 'error'
                 (of the controller); of a bag also what `bag info` shows
    problem    : what ended it early, in words; '' otherwise
    warnings   : lines that a user should know
    end_time   : [s] where the simulation stood at the end: behind the last row where that does
                 not fall on one
    path       : of the bag; None for a run in memory
    impacts    : at their instants, with `contact: {mode: event}`; none otherwise

    `run['box']` is one body (`BodyRun`); `for name in run` yields the names.
    """

    names: tuple[str, ...]
    time: Array
    scene: Scene | None
    integrator: str
    dt: float
    end_reason: str
    end_time: float
    problem: str = ''
    warnings: tuple[str, ...] = ()
    path: str | None = None
    impacts: Impacts = NO_IMPACTS
    _values: Array = field(repr=False, default_factory=lambda: np.zeros((0, 0, 0)))
    _wrench: Array = field(repr=False, default_factory=lambda: np.zeros((2, 0, 0, 3)))
    _masses: Array | None = field(repr=False, default=None)
    _ticks: tuple[int, int, int] | None = field(repr=False, default=None)
    _origin: Origin | None = field(repr=False, default=None)
    _cost: float = field(repr=False, default=0.0)  # [s] of processor time that it took

    def __post_init__(self) -> None:
        for array in (self.time, self._values, self._wrench, self._masses):
            if array is not None:
                array.setflags(write=False)  # views of it are then read-only too

    def __getstate__(self) -> dict[str, Any]:
        """Leave out what is computed when it is asked for."""
        computed = ('energy', '_energies', '_places')
        return {name: value for name, value in self.__dict__.items() if name not in computed}

    def __setstate__(self, kept: Mapping[str, Any]) -> None:
        self.__dict__.update(kept)
        RunArrays.__post_init__(self)  # a pickle forgets what cannot be written to

    @property
    def complete(self) -> bool:
        """Whether it came to its end."""
        return self.end_reason == WHOLE

    def __getitem__(self, name: str) -> BodyRun:
        """Give one body by its name; UnknownBody (a KeyError) for another name."""
        try:
            i = self._places[name]
        except (KeyError, TypeError):
            raise unknown_body(name, self.names) from None
        force, torque = self._wrench[:, :, i]
        return BodyRun(name, self.time, force, torque, self._values[:, i])

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __contains__(self, name: object) -> bool:
        return name in self.names

    def keys(self) -> tuple[str, ...]:
        """Names of the bodies, so that `dict(run)` has each `BodyRun` by its name."""
        return self.names

    @cached_property
    def _places(self) -> dict[str, int]:
        return {name: i for i, name in enumerate(self.names)}

    @cached_property
    def _energies(self) -> Array:
        """Kinetic and potential energy (2, m) [J]; NaN without a scene."""
        energies = np.full((2, len(self.time)), np.nan)
        if self.scene is not None:
            invariants = Invariants(self.scene)
            for row, values in enumerate(self._values):
                masses = None if self._masses is None else self._masses[row]
                state = State(values, masses)
                with np.errstate(all='ignore'):  # a run about to diverge
                    energies[0, row] = invariants.kinetic_energy(state)
                    energies[1, row] = invariants.potential_energy(state)
        energies.setflags(write=False)
        return energies

    @property
    def kinetic_energy(self) -> Array:
        """Kinetic energy (m,) [J]; NaN where a bag holds no scene."""
        return self._energies[0]

    @property
    def potential_energy(self) -> Array:
        """Potential energy (m,) [J], see `Simulation.energy`; NaN where a bag holds no scene."""
        return self._energies[1]

    @cached_property
    def energy(self) -> Array:
        """Energy (m,) [J], see `Simulation.energy`; NaN where a bag holds no scene."""
        with np.errstate(all='ignore'):
            energy = self._energies[0] + self._energies[1]
        energy.setflags(write=False)
        return energy

    def __repr__(self) -> str:
        title = 'run' if self.scene is None else f'{self.scene.name!r}'
        bodies = ', '.join(self.names[:MOST_SHOWN]) + (', …' * (len(self.names) > MOST_SHOWN))
        method = f', {self.integrator}, dt {self.dt:g} s' if self.integrator else ''
        lines = [f'<Run of {title}: {bodies}; {_instants(self.time)}{method}>']
        if not self.complete:
            lines.append(f'  ended early ({self.end_reason}): {self.problem or "see end_reason"}')
        lines += [f'  warning: {text}' for text in self.warnings]
        return '\n'.join(lines)


def _instants(time: Array) -> str:
    if not len(time):
        return 'no instants'
    return f'{len(time)} instants, {time[0]:g} to {time[-1]:g} s'
