# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Energy through a recorded run, and the drift of energy, momentum and angular momentum.

Computed from the recorded poses and twists with the masses and inertias of the scene that the bag
carries; the laws are those of `physics.diagnostics.invariants`. An instant at which the bag lacks
one of the bodies is left out.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.diagnostics.invariants import Invariants
from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.model.inertia_over_time import along
from rigid_body_sim.physics.model.scene import Body, Scene
from rigid_body_sim.physics.model.variable_mass import flow_of, mass_at, masses_at
from rigid_body_sim.physics.state.snapshot import COLUMNS, State
from rigid_body_sim.view.recorded_motion import RecordedMotion, Track

Array = NDArray[np.float64]

MOST_NUMBERS = 4_000_000  # [-] of states at once
IN_BAG = ('time', 'work_of_commands', 'work_of_drives', 'dissipation', 'contact', 'defect')


@dataclass(frozen=True, eq=False)
class BalanceHistory:
    """
    The energy balance of a run as it recorded it (`runs.energy_log`), one row per look.

    time                      : (k,) [s]
    commands, drives          : (k,) [J] work since the begin
    dissipation, contact      : (k,) [J] taken by dampers and drag, by friction and impacts
    defect                    : (k,) [J]
    turnover                  : [J] largest energy that moved
    """

    time: Array
    commands: Array
    drives: Array
    dissipation: Array
    contact: Array
    defect: Array
    turnover: float


@dataclass(frozen=True, eq=False)
class EnergyHistory:
    """
    Energies and drifts, one row per instant.

    time               : (k,) [s]
    kinetic, potential : (k,) [J]
    drift              : (k, 3) [-] largest change of energy, momentum, angular momentum so far,
                         relative to the largest values of the run; nan where none is conserved
    may_only_fall      : bodies meet: the first column of `drift` is how far the energy rose
    balance            : the energy balance that the run kept; None where the bag has none
    """

    time: Array
    kinetic: Array
    potential: Array
    drift: Array
    may_only_fall: bool = False
    balance: BalanceHistory | None = None


def balance_history(
    ending: Mapping[str, str] | None, beyond: float | None = None
) -> BalanceHistory | None:
    """
    Read the energy balance of a bag from its ending; None where it has none.

    beyond : [s] what is later is left out
    """
    try:
        rows = json.loads((ending or {})['energy_history'])
        time, *columns = (np.array(rows[name], dtype=np.float64) for name in IN_BAG)
        turnover = float(json.loads((ending or {})['energy_balance'])['turnover'])
    except (KeyError, TypeError, ValueError, OverflowError, RecursionError):
        return None
    if time.ndim != 1 or any(column.shape != time.shape for column in columns):
        return None
    finite = np.isfinite([time, *columns]).all(axis=0)
    if beyond is not None:
        finite &= time < beyond
    time, *columns = (column[finite] for column in (time, *columns))
    if len(time) < 2 or not np.isfinite(turnover):
        return None
    commands, drives, dissipation, contact, defect = columns
    return BalanceHistory(time, commands, drives, dissipation, contact, defect, turnover)


def energy_history(
    scene: Scene, motion: RecordedMotion, *, ending: Mapping[str, str] | None = None
) -> EnergyHistory | None:
    """
    Follow the conserved quantities; None where a body of the scene is not in the bag.

    ending : of the bag, which holds the energy balance of the run
    """
    tracks = {track.name: track for track in motion.tracks}
    if not all(body.fixed or body.name in tracks for body in scene.bodies):
        return None
    time = _common_time(list(tracks.values()))
    if len(time) == 0:
        return None
    states = _states(scene, tracks, time, motion.passed(time))
    invariants = Invariants(scene)
    return EnergyHistory(
        time,
        np.array([invariants.kinetic_energy(state) for state in states]),
        np.array([invariants.potential_energy(state) for state in states]),
        _drift(invariants, states, time, motion.command_time),
        invariants.energy_must_not_rise,
        balance_history(ending, motion.beyond),
    )


def energies_of(scene: Scene, motion: RecordedMotion, time: Array) -> tuple[Array, Array] | None:
    """
    Kinetic and potential energy (k,) [J] of a run that goes on, at some of its instants.

    None where a body is missing, poses and twists do not come together, or masses and inertias
    change and nobody knows when the run was last reset.
    """
    tracks = {track.name: track for track in motion.tracks}
    whole = motion.tracks[0].time
    if not all(body.fixed or body.name in tracks for body in scene.bodies):
        return None
    changes = any(
        flow_of(body) or body.mass_flow or body.inertia_over_time for body in scene.bodies
    )
    if changes and not motion.begin_is_known:
        return None
    for track in tracks.values():
        if not (np.array_equal(track.time, whole) and np.array_equal(track.twist_time, whole)):
            return None
    invariants = Invariants(scene)
    kinetic, potential = np.empty(len(time)), np.empty(len(time))
    at_once = max(1, MOST_NUMBERS // (COLUMNS * len(scene.bodies)))
    for first in range(0, len(time), at_once):
        part = time[first : first + at_once]
        states = _states(scene, tracks, part, motion.passed(part))
        for k, state in enumerate(states, first):
            kinetic[k] = invariants.kinetic_energy(state)
            potential[k] = invariants.potential_energy(state)
    return kinetic, potential


def _drift(invariants: Invariants, states: list[State], time: Array, command_time: Array) -> Array:
    """Add up the changes between instants, except where a command acted between them."""
    weight = invariants.weight()
    measured = np.array(
        [
            [
                invariants.energy(state),
                *(invariants.momentum(state) - now * weight),
                *invariants.angular_momentum_about_center(state),
            ]
            for state, now in zip(states, time, strict=True)
        ]
    )
    commanded = np.diff(np.searchsorted(command_time, time)) > 0  # in [t_i, t_i+1)
    steps = np.where(commanded[:, None], 0.0, np.diff(measured, axis=0))
    sums = np.concatenate([np.zeros((1, 7)), np.cumsum(steps, axis=0)])
    sizes = np.stack(
        [np.linalg.norm(sums[:, part], axis=1) for part in (slice(1), slice(1, 4), slice(4, 7))],
        axis=1,
    )
    if invariants.energy_must_not_rise:
        sizes[:, 0] = sums[:, 0] - np.minimum.accumulate(sums[:, 0])
    worst = np.maximum.accumulate(sizes, axis=0)
    scales = np.max([invariants.scales(state) for state in states], axis=0)
    energy = invariants.energy_is_conserved or invariants.energy_must_not_rise
    laws = [energy, *2 * [invariants.momentum_is_conserved]]
    return np.where(laws, worst / np.where(scales > 0.0, scales, 1.0), np.nan)


def _common_time(tracks: list[Track]) -> Array:
    """Instants at which every body has a pose and a twist."""
    common = tracks[0].time
    for track in tracks:
        for time in (track.time, track.twist_time):
            if not np.array_equal(time, common):
                common = np.intersect1d(common, time)
    return common


def spin_of(body: Body, time: Array, orientation: Array, angular_velocity: Array) -> Array:
    """
    Angular momentum about the centre of mass (k, 3) [kg m^2/s], world axes; it has an inertia.

    time : (k,) [s] since the scene began;   orientation : (k, 4) [-]
    angular_velocity : (k, 3) [rad/s], world axes
    """
    assert body.inertia is not None
    w_body = so3.rotate_back(orientation, angular_velocity)
    changing = along(body, time)
    spin = w_body @ body.inertia if changing is None else w_body * changing[0]
    mass = np.array([mass_at(body, now) for now in time.tolist()])[:, None]
    return so3.rotate(orientation, spin) * (mass / body.mass)


def _states(scene: Scene, tracks: dict[str, Track], time: Array, passed: Array) -> list[State]:
    """
    The whole scene at each instant; fixed bodies where the scene puts them.

    passed : (k,) [s] the instants, since the scene began
    """
    values = np.zeros((len(time), len(scene.bodies), COLUMNS))
    for i, body in enumerate(scene.bodies):
        out = values[:, i]
        if body.name not in tracks:
            out[:, 0:3], out[:, 3:7] = body.initial.position, body.initial.orientation
            continue
        track = tracks[body.name]
        pose, twist = np.isin(track.time, time), np.isin(track.twist_time, time)
        q = track.orientation[pose]
        v, w = track.velocity[twist], track.angular_velocity[twist]
        out[:, 0:3], out[:, 3:7], out[:, 7:10], out[:, 10:13] = track.position[pose], q, v, w
        if body.fixed:
            continue
        mass = np.array([mass_at(body, now) for now in passed.tolist()])[:, None]
        out[:, 16:19] = mass * v
        if body.inertia is not None:
            out[:, 13:16] = so3.rotate_back(q, w)
            out[:, 19:22] = spin_of(body, passed, q, w)
    return [
        State(row, masses_at(scene.bodies, now))
        for row, now in zip(values, passed.tolist(), strict=True)
    ]
