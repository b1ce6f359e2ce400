# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The part of a motion that can be drawn: up to where a run that diverges leaves what has a picture.

A browser draws in single precision, which ends at 3.4e38; axes of a plot need squares and sums of
what they show. A number that is missing (NaN, as of a tracker that lost its body) is no such end.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rigid_body_sim.errors import UserError
from rigid_body_sim.view.recorded_motion import Load, RecordedMotion, Track

MOST = 1e30  # [m], [m/s], [rad/s]: the universe has 1e27 m


def drawn_part(motion: RecordedMotion, *, name: str) -> RecordedMotion:
    """
    End a motion at its last instant before a body is or moves beyond MOST.

    name : of the run, for the UserError where there is no such instant
    """
    part = until_beyond(motion)
    if part.beyond is not None and not all(len(track.time) for track in part.tracks):
        raise UserError(
            f'{name}: nothing of it can be drawn: at its first instant, {part.beyond:g} s, a body '
            f'is or moves beyond {MOST:g} m, m/s or rad/s; look at its numbers (`inspect`, '
            '`export`)'
        )
    return part


def until_beyond(motion: RecordedMotion) -> RecordedMotion:
    """Do the same of a stretch of a run, of which nothing may be left."""
    beyond = min(_first_beyond(track) for track in motion.tracks)
    if beyond == np.inf:
        return motion
    tracks = tuple(_before(track, beyond) for track in motion.tracks)
    loads, touching, impacts = motion.loads, motion.touching, motion.impacts
    return replace(
        motion,
        tracks=tracks,
        command_time=motion.command_time[motion.command_time < beyond],
        loads=loads and {body: _load_before(load, beyond) for body, load in loads.items()},
        touching=touching and touching[: len(tracks[0].time)],  # an entry for each instant
        impacts=None if impacts is None else impacts[impacts.time < beyond],
        beyond=beyond,
    )


def note_of(motion: RecordedMotion) -> str:
    """Say in a sentence that a motion ends earlier than what was recorded; '' for a whole one."""
    if motion.beyond is None:
        return ''
    last = max(track.time[-1] for track in motion.tracks)
    return (
        f'Drawn up to {last:g} s: the run diverged, and later instants are beyond what can be '
        f'drawn ({MOST:g} m, m/s or rad/s, passed at {motion.beyond:g} s).'
    )


def _first_beyond(track: Track) -> float:
    """First instant of a body that cannot be drawn [s]; infinite where all can be."""
    found = [
        time[(np.abs(values) > MOST).any(axis=1)]
        for time, values in (
            (track.time, track.position),
            (track.twist_time, track.velocity),
            (track.twist_time, track.angular_velocity),
        )
    ]
    return min((float(times[0]) for times in found if len(times)), default=np.inf)


def _before(track: Track, end: float) -> Track:
    poses, twists = track.time < end, track.twist_time < end
    wrenches = track.wrench_time < end
    return Track(
        track.name,
        track.time[poses],
        track.position[poses],
        track.orientation[poses],
        track.twist_time[twists],
        track.velocity[twists],
        track.angular_velocity[twists],
        track.wrench_time[wrenches],
        track.force[wrenches],
        track.torque[wrenches],
    )


def _load_before(load: Load, end: float) -> Load:
    rows = load.time < end
    return Load(load.time[rows], load.force[rows])
