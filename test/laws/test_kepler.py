# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Kepler's ellipse: the equation, the laws of areas and periods, and the force."""

import numpy as np
import pytest

from rigid_body_sim.exact import kepler

ORBIT = {'parameter': 3.0, 'semi_major_axis': 1.3}


@pytest.mark.parametrize('eccentricity', [0.0, 0.3, 0.9, 0.999])
def test_keplers_equation_is_solved_at_every_instant(eccentricity):
    mean = np.linspace(-20.0, 20.0, 401)
    anomaly = kepler.eccentric_anomaly(mean, eccentricity=eccentricity)
    assert anomaly - eccentricity * np.sin(anomaly) == pytest.approx(mean, abs=1e-13)


@pytest.mark.parametrize('eccentricity', [0.0, 0.5, 0.9])
def test_the_ellipse_obeys_newtons_law_keeps_its_area_and_comes_back(eccentricity):
    orbit = {**ORBIT, 'eccentricity': eccentricity}
    t, h = np.linspace(0.1, 5.0, 50), 1e-5
    before, now, after = (kepler.relative(t + dt, **orbit) for dt in (-h, 0.0, h))
    distance = np.linalg.norm(now.position, axis=1, keepdims=True)
    force = -ORBIT['parameter'] * now.position / distance**3
    assert (after.velocity - before.velocity) / (2 * h) == pytest.approx(force, rel=1e-5, abs=1e-5)
    assert (after.position - before.position) / (2 * h) == pytest.approx(now.velocity, abs=1e-5)
    areas = np.cross(now.position, now.velocity)[:, 2]
    assert areas == pytest.approx(areas[0], rel=1e-13)
    energy = 0.5 * np.sum(now.velocity**2, axis=1) - ORBIT['parameter'] / distance[:, 0]
    assert energy == pytest.approx(-0.5 * ORBIT['parameter'] / ORBIT['semi_major_axis'], rel=1e-12)
    again = kepler.relative(t + kepler.period(**ORBIT), **orbit)
    assert again.position == pytest.approx(now.position, abs=1e-12)
