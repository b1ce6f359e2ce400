# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A mass on a spring, let go 0.2 m beyond its rest, is struck with 0.5 N s at t = 0."""

import math


def test_the_mass_answers_as_the_closed_form_says(simulation):
    sim = simulation('oscillator', integrator='rk8', start_paused=True, step_count=50)
    sim.impulse('mass', linear=(0.5, 0, 0))
    for step in range(1, 21):
        sim.call('step')
        swing = 0.2 * math.cos(0.5 * step) + 0.1 * math.sin(0.5 * step)  # J / (m omega) = 0.1 m
        assert abs(sim.state('mass').position[0] - 0.8 - swing) < 1e-9  # m
        assert math.isclose(sim.time, 0.05 * step)
