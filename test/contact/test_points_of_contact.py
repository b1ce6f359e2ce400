# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Where a contact is read to be at the end of a tick: midway between the surfaces of both bodies, as
they have moved and turned.
"""

import itertools

import numpy as np
import pytest

from rigid_body_sim import Simulation
from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.model.scene import Body, Material
from rigid_body_sim.physics.model.shapes import Box, Capsule, Cylinder, Plane, Sphere

from .touching import G, ball, box, ground, motion, scene

VELOCITY = np.array([0.5, 0.3, -0.2])  # [m/s]
TURN = np.array([3.0, 4.0, 5.0])  # [rad/s]
LYING = (0.0, np.sqrt(0.5), 0.0, np.sqrt(0.5))
ACROSS = (np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5))
LEANING = so3.normalise(np.array([0.3, 0.2, 0.1, 1.0]))
# [m/s^2] of points 0.2 m from a centre: what the first order leaves is this times h^2
BEND = (TURN @ TURN) ** 0.5 * (0.2 * (TURN @ TURN) ** 0.5 + (VELOCITY @ VELOCITY) ** 0.5)


def rod(name, shape, position, q, **others):
    return Body(
        name, shape, 1.0, inertia=np.diag([0.01, 0.01, 0.008]),
        initial=motion(position, q=q, velocity=VELOCITY, turn=TURN), **others,
    )  # fmt: skip


def corner_on_box(x, overlap, material):
    """A box with a corner in a side of another, where both have one velocity: nothing slides."""
    half = np.array([0.1, 0.08, 0.12])
    corners = so3.rotate(LEANING, np.array(list(itertools.product(*[(-k, k) for k in half]))))
    corner = corners[np.argmin(corners[:, 2])]
    middle = np.array([x, 0.0, 5.0])
    place = middle + (0.02, 0.03, 0.15 - overlap)
    slow = np.array([-2.0, 3.0, 1.0])
    return [
        box(f'below {x}', 0.3, middle, turn=slow, material=material,
            velocity=VELOCITY + np.cross(slow, middle - place)),
        box(f'above {x}', 2.0 * half, place - corner, q=LEANING, turn=TURN, material=material,
            velocity=VELOCITY - np.cross(TURN, corner)),
    ]  # fmt: skip


def meetings(h):
    """Pairs far from each other, once without and once with restitution."""
    moving = {'velocity': VELOCITY, 'turn': TURN}
    bodies = [ground()]
    for x, material in ((0.0, {}), (50.0, {'restitution': 0.5})):
        of = {'material': Material(**material)}
        bodies += [
            box(f'box {x}', 0.2, (x, 0, 0.1), material=material, **moving),
            ball(f'ball {x}', 0.1, (x + 5, 0, 0.1), material=material, **moving),
            rod(f'capsule {x}', Capsule(0.1, 0.3), (x + 10, 0, 0.1), LYING, **of),
            rod(f'cylinder {x}', Cylinder(0.1, 0.3), (x + 15, 0, 0.1), LYING, **of),
            rod(f'lower {x}', Capsule(0.1, 0.3), (x + 20, 0, 4.8), ACROSS, **of),
            ball(f'on it {x}', 0.1, (x + 20, 0, 5.0), material=material, velocity=(0, 0, -1)),
            *corner_on_box(x + 25, 20.0 * h * h, material),
        ]
    return bodies


def distance(shape, point):
    """Distance of a point from a surface, in the axes of the shape."""
    if isinstance(shape, Plane):
        return np.dot(shape.normal, point) - shape.offset
    if isinstance(shape, Sphere):
        return np.linalg.norm(point) - shape.radius
    if isinstance(shape, Capsule):
        end = 0.5 * shape.length
        return np.linalg.norm(point - (0.0, 0.0, np.clip(point[2], -end, end))) - shape.radius
    if isinstance(shape, Box):
        out = np.abs(point) - 0.5 * np.asarray(shape.size)
    else:
        out = np.array([np.hypot(*point[:2]) - shape.radius, abs(point[2]) - 0.5 * shape.length])
    return np.linalg.norm(np.maximum(out, 0.0)) + min(np.max(out), 0.0)


@pytest.mark.parametrize(
    ('h', 'substeps'), [(1 / 120, 1), (1 / 120, 4), (1 / 480, 1), (1 / 480, 4)]
)
def test_a_contact_point_lies_on_both_bodies_where_they_are_at_the_end_of_the_tick(h, substeps):
    bodies = meetings(h)
    sim = Simulation(scene(bodies, dt=h, gravity=(0, 0, 0), substeps=substeps))
    sim.step()
    found, state = sim.contacts(), sim.state
    assert set(found.bodies.ravel()) == set(range(len(bodies)))
    for pair, point, normal, gap in zip(found.bodies, found.point, found.normal, found.gap):
        for k, side in zip(pair, (-0.5, 0.5)):
            arm = point + side * gap * normal - state.position[k]
            off = distance(bodies[k].shape, so3.rotate_back(state.orientation[k], arm))
            assert abs(off) <= BEND * h * h, [bodies[i].name for i in pair]


def test_the_gap_of_what_is_let_down_at_rest_is_that_of_its_place():
    """
    Each tick lifts the ball a little, and takes that back with its place (`energy.gain_bound`).
    """
    sim = Simulation(scene([ground(), ball('b', 0.1, (0, 0, 0.0985))], dt=0.004, slop=0.001))
    sim.step(50)
    height = sim.state.position[1, 2] - 0.1
    # of its weight in a tick, 0.04 m/s, a last digit
    assert height < -1e-3 and np.abs(sim.state.velocity[1]).max() < 1e-17
    # rounding of 0.1 m; the gap before it is let down differs by 6e-7 m
    assert sim.contacts().gap == pytest.approx([height], abs=1e-14)


LOW, HIGH, START = 0.5, 0.1, 0.1  # [m] radii of a body that lies and one on it; [rad] at the start


def _round_pairs(friction):
    """Pairs of round bodies, one fixed and the other on it, START aside of its top."""
    material = Material(friction=friction)
    rolls = np.diag([0.1, 0.1, 0.4 * HIGH**2])
    up = (LOW + HIGH) * np.array([np.sin(START), 0, np.cos(START)])
    bodies = [ground(), box('bystander', 0.2, (-30, 0, 9))]
    for x, lower, upper in (
        (0, Sphere(LOW), Sphere(HIGH)),
        (5, Capsule(LOW, 1.0), Sphere(HIGH)),
        (10, Cylinder(LOW, 1.0), Sphere(HIGH)),
        (15, Sphere(LOW), Capsule(HIGH, 1.0)),
        (20, Sphere(LOW), Cylinder(HIGH, 1.0)),
    ):
        place = np.array([x, 0, 5])
        bodies += [
            Body(f'below {x}', lower, 0.0, fixed=True, material=material,
                 initial=motion(place, q=ACROSS)),
            Body(f'above {x}', upper, 1.0, inertia=rolls, material=material,
                 initial=motion(place + up, q=ACROSS)),
        ]  # fmt: skip
    return bodies


@pytest.mark.parametrize(('friction', 'share'), [(0.0, 0.0), (2.0, 0.4)])
def test_what_slides_or_rolls_over_a_round_body_goes_round_it_as_round_a_ball(friction, share):
    """
    v^2 (1 + share) = 2 g (R + r) (cos(start) - cos(angle)): nothing is lost, and it stays on it.
    """
    sim = Simulation(scene(_round_pairs(friction), dt=0.004))
    sim.step(150)  # to 0.5 rad and more; what slides leaves at acos(2/3)
    state = sim.state
    angles = []
    for above in range(3, 12, 2):
        way, v = state.position[above] - state.position[above - 1], state.velocity[above]
        angles.append(np.arctan2(way[0], way[2]))
        fell = 2 * G * (LOW + HIGH) * (np.cos(START) - np.cos(angles[-1]))
        # of second order in dt; with a normal that stands still in the tick of first: 6e-3
        assert v @ v * (1 + share) == pytest.approx(fell, rel=1e-5)
        assert np.hypot(way[0], way[2]) == pytest.approx(LOW + HIGH, abs=1e-5)
        assert abs(way[1]) < 1e-12  # rounding
    assert angles[0] > 0.3
    # one rule for all of them: rounding, grown as what is unstable grows
    assert angles == pytest.approx([angles[0]] * 5, rel=1e-9)
