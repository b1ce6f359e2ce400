# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A wrench in a frame of a body is the force at its origin, along its axes, wherever it lies."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import fresnel

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.model.named_frames import at_center
from rigid_body_sim.physics.model.scene import Frame

QUARTER = (0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5))  # about z: x of the frame is y of the body
FRAMES = {
    'nozzle': {'position': [0.25, 0.5, -0.125]},
    'side': {'position': [0.0, 0.5, 0.0], 'orientation': [0, 0, 1, 1]},
    'aslant': {'position': [0.1, -0.3, 0.2], 'orientation': [0.3, -0.2, 0.5, 0.7]},
}
INERTIA = {'ixx': 0.5, 'iyy': 0.5, 'izz': 0.25}  # kg m^2
MASS = 2.0  # [kg]


def free(**body):
    body = {'name': 'box', 'mass': MASS, 'inertia': INERTIA, 'frames': FRAMES} | body
    return Simulation(load_scene({'dt': 0.001, 'bodies': [body]}))


def test_a_force_in_a_frame_is_held_as_the_force_and_its_moment_at_the_centre_to_the_bit():
    force, arm = np.array((3.0, -2.0, 0.75)), np.array(FRAMES['nozzle']['position'])
    torque = np.array((0.5, 0.0, -0.25))
    one, other = free(), free()
    one.set_wrench('box', force=force, torque=torque, frame='nozzle')
    other.set_wrench('box', force=force, torque=torque + np.cross(arm, force), frame='body')
    for sim in (one, other):
        sim.step(200)
    assert one.state_bytes() == other.state_bytes()
    assert not np.array_equal(one.applied_wrench()[0][0], force)  # it has turned with the body


def test_a_full_name_is_the_same_frame_and_the_attitude_of_the_frame_turns_the_force():
    one, other, by_hand = free(), free(), free()
    one.set_wrench('box', force=(1.0, 0.0, 0.0), frame='box/side')
    other.set_wrench('box', force=(1.0, 0.0, 0.0), frame='side')
    assert one.held_slots == other.held_slots
    force, torque = one.applied_wrench()
    assert force[0] == pytest.approx((0, 1, 0), abs=1e-15)  # round-off of the attitude
    assert torque[0] == pytest.approx((0, 0, 0), abs=1e-15)  # it pulls along its own arm
    by_hand.set_wrench('box', force=so3.rotate(QUARTER, (1.0, 0.0, 0.0)), frame='body')
    assert by_hand.applied_wrench()[0] == pytest.approx(force, abs=1e-15)


def test_a_steady_push_off_centre_spins_a_free_body_up_along_a_clothoid():
    """theta = T t^2 / 2 I,  v = F/m int (cos theta, sin theta) dt: Fresnel's integrals."""
    sim = free()
    push = 0.5  # [N] along x of a frame half a metre to the left: a torque of -0.25 N m
    sim.set_wrench('box', force=(0.0, -push, 0.0), frame='side')
    sim.step(2000)
    rate = push * 0.5 / INERTIA['izz']  # [rad/s^2], F = (F, 0, 0) at (0, 0.5, 0): about -z
    t = sim.time
    # second order in the step: h^2 / 24 of the turn of the force, (rate t)^2 h^2 / 24 < 2e-7
    assert sim.state.angular_velocity[0] == pytest.approx((0, 0, -rate * t), abs=1e-12)
    scale = math.sqrt(math.pi / rate)
    sine, cosine = fresnel(t / scale)
    expected = push / MASS * scale * np.array((cosine, -sine, 0.0))
    assert sim.state.velocity[0] == pytest.approx(expected, abs=2e-7)


def test_each_frame_holds_a_command_of_its_own():
    sim = free()
    asked = {'nozzle': (1.0, 2.0, 3.0), 'side': (0.5, 0.0, -1.0), 'body': (0.0, 4.0, 0.0)}
    for frame, force in asked.items():
        sim.set_wrench('box', force=force, frame=frame)
    parts = []
    for frame, force in asked.items():
        alone = free()
        alone.set_wrench('box', force=force, frame=frame)
        parts.append(np.concatenate(alone.applied_wrench()))
    # three sums of three numbers, in another order
    assert np.concatenate(sim.applied_wrench()) == pytest.approx(sum(parts), abs=1e-14)
    sim.set_wrench('box', force=(0.0, 0.0, 7.0), frame='box/nozzle')  # in place of its last
    sim.set_wrench('box', frame='side')
    sim.set_wrench('box', force=(0.0, 4.0, 0.0))  # world and body axes are one source, as ever
    assert sorted(source for _, source in sim.held_slots) == ['wrench', 'wrench/nozzle']
    assert sim.applied_wrench()[0][0] == pytest.approx((0, 4, 7), abs=1e-15)


def test_an_impulse_in_a_frame_leaves_r_cross_j_to_the_last_bit():
    sim = free()
    linear, arm = np.array((0.375, -1.1, 0.7)), np.array(FRAMES['nozzle']['position'])
    returned = sim.apply_impulse('box', linear=linear, frame='nozzle')
    assert np.array_equal(sim.state.angular_momentum[0], np.cross(arm, linear))
    assert np.array_equal(sim.state.momentum[0], linear)
    assert returned == (tuple(linear), tuple(np.cross(arm, linear)))
    # about the origin of the world too, whatever dt is
    assert np.array_equal(sim.angular_momentum(), np.cross(arm, linear))


def test_a_centre_of_mass_that_is_stated_is_where_frames_are_told_from():
    plain, moved = free(), free(center_of_mass=[0.4, 0.1, 0.0])
    for sim in (plain, moved):
        sim.set_wrench('box', force=(0.0, 0.0, 1.0), frame='nozzle')
        sim.step(50)
    assert plain.state_bytes() == moved.state_bytes()
    lever = np.cross(FRAMES['nozzle']['position'], (0.0, 0.0, 1.0))
    assert plain.state.angular_velocity[0, :2] == pytest.approx(lever[:2] * 0.05 / 0.5, rel=1e-3)


@pytest.mark.usefixtures('plain_source')
def test_a_body_that_loses_mass_keeps_its_arms():
    sim = free(mass_rate=-10.0, exhaust_velocity=[0, 0, 0])
    sim.step(100)  # half of it is gone, and half of the inertia
    sim.apply_impulse('box', linear=(1.0, 0.0, 0.0), frame='box/nozzle')
    expected = np.cross(FRAMES['nozzle']['position'], (1.0, 0.0, 0.0))
    assert sim.state.momentum[0] == pytest.approx((1, 0, 0), rel=1e-12)
    assert sim.state.angular_momentum[0] == pytest.approx(expected, rel=1e-12)


NUMBER = st.floats(-10.0, 10.0, allow_subnormal=False)
VECTOR = st.tuples(NUMBER, NUMBER, NUMBER)
ATTITUDE = st.tuples(NUMBER, NUMBER, NUMBER, NUMBER).filter(lambda q: math.hypot(*q) > 1e-3)


@given(VECTOR, ATTITUDE, VECTOR, VECTOR, VECTOR, VECTOR)
def test_power_and_moment_do_not_depend_on_where_a_wrench_is_told(p, q, force, torque, v, w):
    """F.v + T.w at the frame is that at the centre, and so is the moment about any point."""
    frame = Frame(position=p, orientation=q)
    at = np.array(so3.matrix_from_quaternion(frame.orientation))
    f, t = (np.array(x) for x in at_center(frame, force, torque))
    f_here, t_here = at @ force, at @ torque
    v, w, p = np.array(v), np.array(w), np.array(p)
    size = 1.0 + 10.0**4  # of the terms: a hundred times a hundred
    here = f_here @ (v + np.cross(w, p)) + t_here @ w
    assert f @ v + t @ w == pytest.approx(here, abs=1e-14 * size * 10)
    point = v  # any
    moment = t_here + np.cross(p - point, f_here)
    assert t + np.cross(-point, f) == pytest.approx(moment, abs=1e-14 * size)


@pytest.mark.parametrize(
    ('frame', 'reason'),
    [
        ('nozle', "did you mean 'nozzle'"),
        ('box/nozle', 'allowed'),
        ('ball/nozzle', 'allowed: world, body, nozzle, side, aslant'),
        ('', 'allowed'),
        (None, 'allowed'),
    ],
)
def test_a_frame_that_the_body_does_not_have_is_refused(frame, reason):
    sim = free()
    for command in (sim.set_wrench, sim.hold):
        words = ('box',) if command == sim.set_wrench else ('box', 'force')
        with pytest.raises(InvalidModel, match=reason):
            command(*words, force=(1, 0, 0), frame=frame)
    with pytest.raises(InvalidModel, match=reason):
        sim.apply_impulse('box', linear=(1, 0, 0), frame=frame)
    assert not sim.held_slots


def test_a_moment_beyond_the_numbers_is_refused():
    sim = free(frames={'far': {'position': [1e200, 0, 0]}})
    with pytest.raises(InvalidModel, match='beyond the largest number'):
        sim.set_wrench('box', force=(0, 1e200, 0), frame='far')
