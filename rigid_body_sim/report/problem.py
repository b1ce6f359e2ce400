# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A problem: a scene, how long it runs, and how far its end is from the exact one.

Errors are taken at the end of the run from a closed form, or from a Taylor series in 34 digits;
never from an engine, this one or another.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rigid_body_sim.exact.attitude import angle_between
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.scene import load_scene

Array = NDArray[np.float64]

WORK_PRECISION, THROUGHPUT = 'work_precision', 'throughput'
ERRORS = (1e-4, 1e-6, 1e-8, 1e-10)  # at which methods and engines are compared
CONTACT_ERRORS = (1e-1, 1e-2, 1e-3, 1e-4)
LECTURE = 'The lecture'  # heading of problems that show what a lecture on mechanics tells
QUICK_BODIES = 1_000
SEED = 1  # of whatever a problem draws at random


# velocities and angular velocities (n, 3), world -> forces and torques (n, 3), world
Control = Callable[[Array, Array], tuple[Array, Array]]


class Final(Protocol):
    """
    The bodies at the end of a run, scene order; `Simulation.state` is one.

    position, velocity : (n, 3) [m], [m/s]  of the centre of mass, world
    orientation        : (n, 4) [-]         xyzw, body to world
    angular_velocity   : (n, 3) [rad/s]     world
    """

    @property
    def position(self) -> Array: ...
    @property
    def orientation(self) -> Array: ...
    @property
    def velocity(self) -> Array: ...
    @property
    def angular_velocity(self) -> Array: ...


@dataclass(frozen=True)
class Problem:
    """
    One problem with an exact answer.

    title        : a few words, for a heading
    heading      : of the part of the report it belongs to; without, it stands before all parts
    description  : what moves, in one sentence, with its numbers
    shows        : what the problem tells methods apart by, in one sentence
    document     : the scene as a mapping, or read; its dt does not count
    duration     : [s]
    error        : end of a run -> error, in `error_unit`
    instants     : at how many instants ours is compared, evenly spaced, the end included
    error_on_way : (instant from 0, state) -> error, where there are several
    error_of_run : simulation at the end of a run -> error, where a state does not tell it; then
                   other engines are not asked
    control      : who commands all bodies before each step, in Python; None: nobody
    reference    : where the exact end comes from
    useless      : error from which on a result says nothing; such points are "not accurate"
    integrators  : methods that suit, measured by default: see `report.method`
    steps        : dt [s], coarse to fine; every one divides the duration
    steps_of     : the same for methods that bear longer ones, or need others
    tick         : [s] tick of the methods that control their error
    longest_tick : [s] shorter steps are substeps of such a tick; 0: every step is a tick
    closed_form  : methods whose step is the closed form of this very motion: stated apart
    kind         : WORK_PRECISION, or THROUGHPUT: many bodies, one step
    bodies       : how many bodies; more than one value for THROUGHPUT alone
    spread       : (scene of one body, count) -> scene of so many
    errors       : at which methods and engines are compared
    enough       : a sweep ends at an error below this
    most_steps   : a sweep ends before a run of more steps than this
    """

    name: str
    title: str
    description: str
    shows: str
    document: Mapping[str, Any] | Scene
    duration: float
    error: Callable[[Final], float]
    error_unit: str
    reference: str
    useless: float
    integrators: tuple[str, ...]
    steps: tuple[float, ...]
    tick: float
    longest_tick: float = 0.0
    steps_of: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    closed_form: tuple[str, ...] = ()
    kind: str = WORK_PRECISION
    bodies: tuple[int, ...] = (1,)
    spread: Callable[[Scene, int], Scene] | None = None
    errors: tuple[float, ...] = ERRORS
    enough: float = 0.0
    instants: int = 1
    error_on_way: Callable[[int, Final], float] | None = None
    most_steps: int = 100_000
    heading: str = ''
    error_of_run: Callable[[Simulation], float] | None = None
    control: Control | None = None

    def error_at_end(self, simulation: Simulation) -> float:
        """Give the error of a run of ours that has come to its end."""
        if self.error_of_run is not None:
            return self.error_of_run(simulation)
        return self.error(simulation.state)

    def bodies_for(self, *, quick: bool) -> list[int]:
        """Give the numbers of bodies; only small ones if it is to be quick."""
        return [count for count in self.bodies if not quick or count <= QUICK_BODIES]

    def steps_for(self, method: str) -> tuple[float, ...]:
        """Give the steps [s] of one method, coarse to fine."""
        return self.steps_of.get(method, self.steps)

    def tick_of(self, step: float) -> tuple[float, int]:
        """Give the tick [s] and the number of substeps that make steps of such a length [s]."""
        if not self.longest_tick or step >= self.longest_tick:
            return step, 1
        return self.longest_tick, round(self.longest_tick / step)

    def scene(self, bodies: int = 1) -> Scene:
        """Read the scene, for so many bodies."""
        document = self.document
        scene = document if isinstance(document, Scene) else load_scene(document)
        return scene if self.spread is None else self.spread(scene, bodies)


def scene_document(
    name: str,
    bodies: Sequence[Mapping[str, Any]],
    *,
    forces: Sequence[Mapping[str, Any]] = (),
    gravity: Sequence[float] = (0.0, 0.0, 0.0),
    contact: Mapping[str, Any] = MappingProxyType({'mode': 'none'}),
) -> dict[str, Any]:
    """Write a scene as a mapping; dt is set by whoever runs it."""
    return {
        'version': 1,
        'name': name,
        'dt': 0.001,
        'gravity': list(gravity),
        'bodies': list(bodies),
        'forces': list(forces),
        'contact': dict(contact),
    }


def smooth_balls(
    places: Sequence[Sequence[float]],
    speeds: Sequence[Sequence[float]],
    *,
    mass: float,
    radius: float,
) -> list[dict[str, Any]]:
    """Write balls without friction and loss over a ground, places in [m] and speeds in [m/s]."""
    ball = {
        'mass': mass,
        'shape': {'type': 'sphere', 'radius': radius},
        'restitution': 1.0,
        'friction': 0.0,
    }
    return [
        {'name': 'ground', 'shape': {'type': 'plane', 'normal': [0, 0, 1]}, 'friction': 0.0},
        *(
            {
                'name': f'ball_{number}',
                **ball,
                'initial': {'position': list(place), 'velocity': list(speed)},
            }
            for number, (place, speed) in enumerate(zip(places, speeds, strict=True))
        ),
    ]


def principal(moments: Sequence[float]) -> dict[str, float]:
    """Inertia with principal axes along the axes of the body, as a scene writes it."""
    return dict(zip(('ixx', 'iyy', 'izz'), map(float, moments), strict=True))


def attitude_error(exact: ArrayLike) -> Callable[[Final], float]:
    """
    Largest angle [rad] between attitudes and the exact ones.

    exact : (n, 4) or (4,) xyzw
    """
    true = np.atleast_2d(np.asarray(exact, dtype=float))
    return lambda final: float(np.max(angle_between(final.orientation, true)))


def position_error(exact: ArrayLike) -> Callable[[Final], float]:
    """
    Largest distance [m] from the exact positions.

    exact : (n, 3) or (3,)
    """
    true = np.atleast_2d(np.asarray(exact, dtype=float))
    return lambda final: float(np.max(np.linalg.norm(final.position - true, axis=1)))


def ladder(coarsest: float, finest: float) -> tuple[float, ...]:
    """Steps 1, 0.5, 0.2, 0.1, … times a power of ten [s], coarse to fine, both ends included."""
    exponents = range(int(np.floor(np.log10(coarsest))), int(np.floor(np.log10(finest))) - 1, -1)
    steps = [float(f'{digit}e{exponent}') for exponent in exponents for digit in (5, 2, 1)]
    return tuple(step for step in steps if finest <= step * (1 + 1e-9) and step <= coarsest)
