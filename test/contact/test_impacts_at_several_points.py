# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Impacts at several points at once.
"""

import itertools

import numpy as np
import pytest

from rigid_body_sim.physics.contact.events import joint_impact_record as record
from rigid_body_sim.physics.contact.events.joint_impact import JointImpact, joint_impact

from .impact_cases import random_box, rotation

SIDE = 0.2  # [m]
CUBE = (6 / SIDE**2, 0, 0, 6 / SIDE**2, 0, 6 / SIDE**2)  # inverse inertia of 1 kg
CORNERS = [(x * SIDE / 2, y * SIDE / 2, -SIDE / 2) for x in (-1, 1) for y in (-1, 1)]
UP = (0, 0, 1)
GROUND = -1


def meet(bodies, points):
    """
    Let bodies (inverse mass, inverse inertia, velocity, spin) meet at points (A, B, arm of A, arm
    of B, normal, e, mu): the twists afterwards (n, 6), the impulses (m, 3), and whether settled.
    """
    of_bodies = np.zeros((len(bodies), record.BODY_SIZE))
    for row, body in zip(of_bodies, bodies, strict=True):
        row[record.INVERSE_MASS : record.COMPRESSED_VELOCITY] = np.hstack(body)
    of_points = np.zeros((len(points), record.POINT_SIZE))
    for row, point in zip(of_points, points, strict=True):
        row[record.BODY_A : record.IMPULSE] = np.hstack(point)
    flat_bodies, flat_points = of_bodies.ravel(), of_points.ravel()
    settled = joint_impact(JointImpact(len(bodies), len(points), flat_bodies, flat_points))
    twists = flat_bodies.reshape(of_bodies.shape)[:, record.VELOCITY : record.COMPRESSED_VELOCITY]
    start = record.IMPULSE
    return twists, flat_points.reshape(of_points.shape)[:, start : start + 3], settled


def falls_flat(velocity, e, mu, spin=(0, 0, 0)):
    points = [(GROUND, 0, (0, 0, 0), corner, UP, e, mu) for corner in CORNERS]
    twists, impulses, settled = meet([(1.0, CUBE, velocity, spin)], points)
    assert settled
    return twists[0], impulses


@pytest.mark.parametrize('e', [0.0, 0.5, 1.0])
def test_a_flat_cube_rebounds_with_e_v_and_does_not_spin(e):
    twist, impulses = falls_flat((0.3, -0.2, -1.0), e, 0.0)
    np.testing.assert_allclose(twist, (0.3, -0.2, e, 0, 0, 0), rtol=0, atol=1e-15)  # round-off
    assert impulses[:, 2].sum() == pytest.approx(1 + e, rel=1e-15)


def test_a_flat_cube_that_slides_loses_mu_of_its_normal_impulse_and_stays_flat():
    e, mu, speed = 0.5, 0.3, 5.0
    twist, _ = falls_flat((speed, 0, -1.0), e, mu)
    # friction turns it by less than the corners hold: mu < width / height
    law = (speed - mu * (1 + e), 0, e, 0, 0, 0)
    np.testing.assert_allclose(twist, law, rtol=0, atol=1e-14)  # settled to 1e-16 a sweep


def stack(count, ball_velocity, e, mu):
    """
    A ball of 100 g strikes the uppermost of a stack of resting cubes, beside its middle.
    """
    bodies = [(1.0, CUBE, (0, 0, 0), (0, 0, 0))] * count
    inverse = 2.5 / (0.1 * 0.05**2)
    ball = (10.0, (inverse, 0, 0, inverse, 0, inverse), ball_velocity, (0, 0, 0))
    carried = [
        (level - 1, level, (x, y, -z if level else 0.0), (x, y, z), UP, 0.0, mu)
        for level in range(count)
        for x, y, z in CORNERS
    ]
    strike = (count - 1, count, (0.03, 0.02, SIDE / 2), (0, 0, -0.05), UP, e, mu)
    return meet([*bodies, ball], [*carried, strike])


@pytest.mark.parametrize('count', [1, 5])
@pytest.mark.parametrize('e', [1.0, 0.8])
def test_a_ball_leaves_a_resting_stack_with_e_v(count, e):
    twists, _, settled = stack(count, (0, 0, -1), e, 0.5)
    assert settled
    assert twists[-1, 2] == pytest.approx(e, abs=1e-14)
    assert np.abs(twists[:-1]).max() < 1e-14


def energy(bodies, twists):
    """
    Kinetic energy of bodies (inverse mass, inverse inertia, ...).
    """
    total = 0.0
    for (inverse_mass, (xx, xy, xz, yy, yz, zz), *_), twist in zip(bodies, twists, strict=True):
        inverse = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        total += twist[:3] @ twist[:3] / inverse_mass / 2
        total += twist[3:] @ np.linalg.solve(inverse, twist[3:]) / 2
    return total


def random_cluster(rng):
    """
    Three boxes that meet at six points of random normals, some of which carry load.
    """
    bodies = []
    for _ in range(3):
        mass, inertia, _ = random_box(rng)
        bodies.append((mass, inertia, rng.normal(size=3), rng.normal(size=3)))
    points = []
    for a, b in itertools.chain([(GROUND, 0), (GROUND, 1)], [(0, 1), (1, 2)] * 2):
        normal = rotation(rng)[0]
        e = float(rng.choice([0, rng.random(), 1]))
        mu = float(rng.choice([0, rng.uniform(0, 1.5)]))
        points.append((a, b, rng.normal(size=3) / 4, rng.normal(size=3) / 4, normal, e, mu))
    return bodies, points


def test_no_cluster_of_impacts_gains_energy_or_leaves_its_cones():
    rng = np.random.default_rng(4)
    for _ in range(500):
        bodies, points = random_cluster(rng)
        twists, impulses, _ = meet(bodies, points)
        before = energy(bodies, [np.hstack(body[2:]) for body in bodies])
        assert energy(bodies, twists) < before * (1 + 1e-12)  # round-off
        for point, impulse in zip(points, impulses, strict=True):
            along = impulse @ point[4]
            across = np.linalg.norm(impulse - along * point[4])
            assert across <= point[6] * along + 1e-12 * (1 + along)


@pytest.mark.parametrize('of_wall', [1.0, 1.5])
def test_friction_that_compression_has_taken_does_not_hold_in_the_restitution(of_wall):
    """
    A ball with backspin: the wall presses it to the ground, which rubs on what is left. When both
    let go, what they rub changes by mu times what presses then: else the ball was left at rest.
    """
    radius, speed, e = 0.1, 2.58, 0.9
    inverse = 2.5 / radius**2
    ball = (1.0, (inverse, 0, 0, inverse, 0, inverse), (speed, 0, 0), (0, -4.86 / radius, 0))
    wall = (GROUND, 0, (0, 0, 0), (radius, 0, 0), (-1, 0, 0), e, of_wall)
    ground = (GROUND, 0, (0, 0, 0), (0, 0, -radius), UP, 0.0, 0.5)
    (twist,), _, settled = meet([ball], [wall, ground])
    assert settled
    assert twist[0] < -0.7 * speed


def test_elastic_smooth_clusters_keep_their_energy():
    rng = np.random.default_rng(5)
    count = 0
    for _ in range(100):
        bodies, points = random_cluster(rng)
        points = [(*point[:5], 1.0, 0.0) for point in points]
        twists, _, settled = meet(bodies, points)
        before = energy(bodies, [np.hstack(body[2:]) for body in bodies])
        if settled:
            count += 1
            assert energy(bodies, twists) == pytest.approx(before, rel=1e-12)
    assert count > 60
