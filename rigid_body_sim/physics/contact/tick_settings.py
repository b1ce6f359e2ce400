# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The settings of a scene as numbers for the kernels: see `settings`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.contact.settings import ContactSettings

settings = Record()
SUBSTEPS = settings.number('-', 'of a tick')
DAMPING_RATIO = settings.number('-', 'zeta of the soft contact')
RELAXATIONS = settings.number('-', 'iterations that relax')
RESTITUTION_THRESHOLD = settings.number('m/s', 'slower impacts do not bounce')
SLOP = settings.number('m', 'overlap that is left alone')
PUSH_OUT_SPEED = settings.number('m/s', 'the fastest that overlap is undone')
MARGIN = settings.number('m', 'separation within which a contact is foreseen (speculative)')
USUAL_RADIUS = settings.number('m', 'median of the bounding radii')
SLEEP_SPEED = settings.number('m/s', 'slower bodies may fall asleep')
SLEEP_TIME = settings.number('s', 'so long they must have been slower')
IMPACT_SPEED = settings.number('m/s', 'slower approach is no impact at an instant: `events`')
WHOLE_TICK = settings.number('s', 'length of a tick that is not cut')
SIZE = settings.size


def settings_row(given: ContactSettings, usual_radius: float) -> NDArray[np.float64]:
    """Make the numbers of the settings of a scene."""
    row = np.zeros(SIZE)
    row[SUBSTEPS] = given.substeps
    row[DAMPING_RATIO] = given.damping_ratio
    row[RELAXATIONS] = given.relaxations
    row[RESTITUTION_THRESHOLD] = given.restitution_threshold
    row[IMPACT_SPEED] = given.impact_speed
    row[SLOP] = given.slop
    row[PUSH_OUT_SPEED] = given.push_out_speed
    row[MARGIN] = given.margin
    row[USUAL_RADIUS] = usual_radius
    row[SLEEP_SPEED] = given.sleep_speed
    row[SLEEP_TIME] = given.sleep_time
    return row
