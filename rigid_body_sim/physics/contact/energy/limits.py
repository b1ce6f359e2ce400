# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The limits of the projection onto energy that has not risen: value, unit, what breaks.

Energies are counted in falls: the kinetic energy [J] of what falls for a substep from rest. With 4
substeps in 1/240 s a kinetic energy of 1e-4 falls is 0.1 mm/s, one of 10 falls 0.03 m/s.
"""

# A body alone between these kinetic energies pays with its place, else with its motion.
STILL = 1e-4  # [fall] a larger one holds back what hardly moves; a smaller one moves what rests
SLOW = 10.0  # [fall] a smaller one holds back what hardly moves; a larger one moves what is fast

# Gains that are left.
SMALL = 1e-6  # [fall] of a body alone, or of what is fast; a larger one lets vibration grow
START = (
    2e-3  # [fall] of several bodies that are slow; a smaller one holds back what starts to move
)
ROUND_OFF = 1e-13  # [-] of the kinetic energy; a smaller one takes rounding for a gain

# How far a body is let down at most: twice what the ground gives way under it.
LIFT = 0.2  # [-] of h^2 |F| / m; a smaller one leaves what an impact has pushed in with its gain

PARALLEL = 1e-12  # [-] 1 - cosine of normals of one plane, at most; a smaller one parts one plane
