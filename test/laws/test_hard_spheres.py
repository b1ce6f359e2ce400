# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The oracle of billiards and cradles against what is known of both.
"""

import numpy as np
import pytest

from rigid_body_sim.exact.hard_spheres import hard_spheres


@pytest.mark.parametrize('gap', [0.0, 0.01])
@pytest.mark.parametrize('e', [1.0, 0.9])
def test_the_last_ball_of_a_cradle_leaves_with_half_of_one_plus_e_to_the_n_minus_one(e, gap):
    count = 5
    places = [[-0.3, 0.0], *([i * (0.2 + gap), 0.0] for i in range(count - 1))]
    speeds = [[2.0, 0.0]] + [[0.0, 0.0]] * (count - 1)
    end, _ = hard_spheres(places, speeds, mass=1.0, radius=0.1, restitution=e, duration=0.35)
    assert end.velocity[-1, 0] == pytest.approx(2 * ((1 + e) / 2) ** (count - 1), rel=1e-14)
    assert end.velocity[:, 0].sum() == pytest.approx(2.0, rel=1e-14)
    if e == 1.0:
        np.testing.assert_allclose(end.velocity[:-1], 0.0, atol=1e-15)


def test_billiards_keep_momentum_and_energy_and_run_back():
    rng = np.random.default_rng(3)
    places = np.stack(np.meshgrid(*[np.arange(4) * 0.33] * 2), axis=-1).reshape(-1, 2)
    speeds = rng.normal(size=places.shape)
    masses = rng.uniform(0.5, 2.0, len(places))
    rules = {'mass': masses, 'radius': 0.15, 'restitution': 1.0, 'duration': 0.5}
    there, count = hard_spheres(places, speeds, **rules)
    assert count >= 5
    momentum, energy = masses @ speeds, masses @ (speeds**2).sum(axis=1)
    np.testing.assert_allclose(masses @ there.velocity, momentum, rtol=0, atol=1e-13)
    assert masses @ (there.velocity**2).sum(axis=1) == pytest.approx(energy, rel=1e-13)
    back, again = hard_spheres(there.position, -there.velocity, **rules)
    assert again == count
    # each impact multiplies an error by some 2 ways / radius
    np.testing.assert_allclose(back.position, places, rtol=0, atol=1e-9)
