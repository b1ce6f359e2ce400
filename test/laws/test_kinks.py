# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Jumps that samples show by themselves: found at their instants, none where there is none, and what
is not found is told as an error of its size.
"""

import itertools

import numpy as np
import pytest

from rigid_body_sim import inverse_kinematics
from rigid_body_sim.analysis.kinks import find_kinks
from rigid_body_sim.exact import free_asymmetric_top

FORETOLD = 3.0  # [-] how far an estimate may be below the error itself


def rms(vectors):
    return float(np.sqrt(np.mean(np.sum(np.square(vectors), axis=1))))


def smooth(t):
    """A motion and its velocity."""
    position = np.stack([np.sin(3 * t), 0.5 * np.cos(2 * t), t - 4.9 * t * t], 1)
    return position, np.stack([3 * np.cos(3 * t), -np.sin(2 * t), 1 - 9.8 * t], 1)


def jumpy(seed, kind, noise=0.0, most=4):
    """Samples with jumps of the velocity (kind 0) or of the acceleration at drawn instants."""
    random = np.random.default_rng(seed)
    step, count = float(random.choice([0.002, 0.005, 0.01])), int(random.integers(200, 500))
    t = step * np.arange(count)
    places = np.arange(30, count - 30, 30)  # far enough from each other for the longest windows
    chosen = np.sort(random.choice(places, int(random.integers(1, most + 1)), replace=False))
    instants = step * (chosen + random.uniform(0.1, 0.9, len(chosen)))
    position, velocity = smooth(t)
    for instant in instants:
        jump, after = random.standard_normal(3) * random.choice([0.5, 3.0]), t - instant
        after = np.maximum(after, 0.0)[:, None]
        if kind == 0:
            position, velocity = position + jump * after, velocity + jump * (after > 0.0)
        else:
            position, velocity = position + 2.5 * jump * after**2, velocity + 5.0 * jump * after
    return t, position + noise * random.standard_normal(position.shape), velocity, instants


def long(value):
    return pytest.param(value, marks=pytest.mark.long)


@pytest.mark.parametrize('kind', [0, 1])
@pytest.mark.parametrize('seed', [*range(2), *map(long, range(2, 12))])
def test_jumps_of_exact_samples_are_found_at_their_instants(seed, kind):
    t, position, velocity, instants = jumpy(seed, kind)
    found = inverse_kinematics(t, position)
    assert found.jumps == pytest.approx(instants, abs=0.02 * t[1])  # truncation
    assert rms(found.velocity - velocity) < 1e-3  # of 0.5 m/s and more; smeared: 0.05


@pytest.mark.parametrize('draws', [2, long(12)])
@pytest.mark.parametrize(
    ('noise', 'kind'),
    [
        (1e-7, 0), (1e-4, 1),
        *(pytest.param(*one, marks=pytest.mark.long)
          for one in itertools.product((0.0, 1e-7, 1e-5, 1e-4, 1e-3), (0, 1))
          if one not in ((1e-7, 0), (1e-4, 1))),
    ],
)  # fmt: skip
def test_velocities_beside_jumps_are_no_worse_than_told(noise, kind, draws):
    """Whether noise lets them be found or not."""
    ratios = []
    for seed in range(draws):
        t, position, velocity, _ = jumpy(seed, kind, noise)
        found = inverse_kinematics(t, position)
        ratios.append(rms(found.velocity - velocity) / found.velocity_error)
    # without the jumps of this module: 10 and more
    assert np.median(ratios) < 2.0 and np.mean(np.array(ratios) > FORETOLD) <= 1 / 6


@pytest.mark.parametrize('draws', [2, long(20)])
@pytest.mark.parametrize('noise', [0.0, long(1e-9), 1e-6, long(1e-3)])
def test_smooth_samples_have_no_jumps_whatever_their_noise(noise, draws):
    for seed in range(draws):
        random = np.random.default_rng(seed)
        t = np.cumsum(random.uniform(0.005, 0.015, 400)) if seed % 2 else np.arange(400) * 0.01
        position, _ = smooth(t)
        assert not find_kinks(
            t, position + noise * random.standard_normal(position.shape), rounding=1e-15
        )


@pytest.mark.parametrize('step', [0.02, 0.1, 0.3])
def test_a_top_that_flips_has_no_jumps(step):
    """Its middle axis turns over within a few samples: fast, and smooth."""
    t = np.arange(0.0, 20.0, step)
    omega = (0.01, 3.0, 0.01)
    exact = free_asymmetric_top.rotation(t, inertia=(1, 2, 3), angular_velocity_body=omega)
    flips = np.sum(exact.orientation[1:] * exact.orientation[:-1], axis=1) < 0.0
    signs = np.where(np.append(False, np.cumsum(flips) % 2 == 1), -1.0, 1.0)
    assert not find_kinks(t, exact.orientation * signs[:, None], rounding=1e-15)


def test_a_path_like_a_v_has_two_velocities():
    t = np.linspace(0.0, 1.0, 101)
    path = np.stack([0 * t, 0 * t, 2.0 * np.abs(t - 0.5)], 1)
    found = inverse_kinematics(t, path)
    # at the corner that from there on
    assert found.velocity[:, 2] == pytest.approx(np.where(t < 0.4999, -2.0, 2.0), abs=1e-11)
    assert found.jumps == pytest.approx([0.5], abs=1e-12)


@pytest.mark.parametrize('digits', [2, 3])
def test_steps_of_rounded_samples_are_noise_and_no_jumps(digits):
    t = np.arange(0.0, 5.0, 0.01)
    position, velocity = smooth(0.1 * t)  # ten and more samples on most steps
    velocity *= 0.1
    found = inverse_kinematics(t, np.round(position, digits))
    assert not found.jumps
    assert found.noise == pytest.approx(10.0**-digits / np.sqrt(12.0), rel=0.3)
    assert rms(found.velocity - velocity) < FORETOLD * found.velocity_error
