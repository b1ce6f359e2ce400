# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Free fall, projectiles, held forces and torques, impulses: the laws that every beginner can check.
"""

import numpy as np
import pytest

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.exact import ballistic, held_wrench
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.integration.integrators import INTEGRATORS
from rigid_body_sim.physics.model.rotation import angle_between, rotate

ROUND_OFF = (
    1e-12  # relative; 1e4 additions of compensated sums leave some ulps of the largest value
)


def one_body(dt=0.001, gravity=(0, 0, 0), **initial):
    return load_scene(
        {
            'version': 1,
            'name': 'one',
            'dt': dt,
            'gravity': list(gravity),
            'bodies': [
                {
                    'name': 'box',
                    'mass': 2.0,
                    'inertia': {'ixx': 1.0, 'iyy': 2.0, 'izz': 2.5},
                    'initial': initial,
                }
            ],
        }
    )


SECOND_ORDER_OR_MORE = sorted(
    name
    for name, integrator in INTEGRATORS.items()
    if integrator.order > 1
    and integrator.refuses(one_body()) is None
    and not integrator.is_reference
)


@pytest.mark.parametrize('integrator', SECOND_ORDER_OR_MORE)
def test_projectile_flies_on_its_parabola(integrator):
    start = {'position': [1.0, 2.0, 3.0], 'velocity': [3.0, 4.0, 20.0]}
    sim = Simulation(one_body(gravity=(0, 0, -9.81), **start), integrator=integrator)
    sim.step(4000)
    exact = ballistic.flight(4.0, acceleration=(0, 0, -9.81), **start)
    np.testing.assert_allclose(sim.state.position[0], exact.position, rtol=ROUND_OFF)
    np.testing.assert_allclose(sim.state.velocity[0], exact.velocity, rtol=ROUND_OFF)


@pytest.mark.parametrize(
    ('integrator', 'sign'), [('explicit_euler', 1.0), ('semi_implicit_euler', -1.0)]
)
def test_euler_misses_free_fall_by_half_a_step_of_speed(integrator, sign):
    # r_n = -g h^2 n (n -+ 1) / 2, so the error is +- g t h / 2 exactly
    sim = Simulation(one_body(gravity=(0, 0, -9.81)), integrator=integrator)
    sim.step(1000)
    miss = sim.state.position[0, 2] - (-9.81 / 2)
    assert miss == pytest.approx(sign * 9.81 * 1.0 * 0.001 / 2, rel=1e-9)  # a difference of sums


@pytest.mark.parametrize('integrator', SECOND_ORDER_OR_MORE)
def test_held_force_moves_a_body_half_f_over_m_t_squared(integrator):
    sim = Simulation(one_body(), integrator=integrator)
    sim.step(500)
    sim.set_wrench('box', force=(3.0, 0.0, -1.0))
    sim.step(2000)
    exact = held_wrench.held_force(2.0, mass=2.0, force=(3.0, 0.0, -1.0))
    np.testing.assert_allclose(sim.state.position[0], exact.position, rtol=ROUND_OFF)
    np.testing.assert_allclose(sim.state.velocity[0], exact.velocity, rtol=ROUND_OFF)


@pytest.mark.parametrize('frame', ['world', 'body'])
@pytest.mark.parametrize('axis', [0, 1, 2])
def test_held_torque_on_a_principal_axis_turns_it_like_a_falling_point(axis, frame):
    inertia = (1.0, 2.0, 2.5)[axis]
    torque = np.eye(3)[axis] * 0.8
    sim = Simulation(one_body(angular_velocity=(0.3 * np.eye(3)[axis]).tolist()))
    sim.set_wrench('box', torque=torque, frame=frame)
    sim.step(2000)
    exact = held_wrench.held_torque(
        2.0, axis=axis, inertia=inertia, torque=0.8, angular_velocity=0.3
    )
    # dmv6 turns by (h w) (1 + O(h w)^6) in each of 2000 ticks of h w = 2e-3: truncation below
    # round-off
    assert angle_between(sim.state.orientation[0], exact.orientation) < 1e-12
    np.testing.assert_allclose(
        sim.state.angular_velocity_body[0], exact.angular_velocity_body, rtol=ROUND_OFF, atol=1e-15
    )


def test_force_in_body_axes_turns_with_the_body():
    sim = Simulation(one_body(orientation=[0.0, 0.0, 2**-0.5, 2**-0.5]))
    sim.set_wrench('box', force=(2.0, 0.0, 0.0), frame='body')  # body x is world y
    sim.step(1000)
    # the quaternion is unit to an ulp only: the direction is right to some ulps
    np.testing.assert_allclose(sim.state.position[0], (0.0, 0.5, 0.0), rtol=ROUND_OFF, atol=1e-15)


@pytest.mark.parametrize('dt', [0.0001, 0.001, 0.01])
def test_impulse_changes_velocity_by_j_over_m_whatever_dt(dt):
    sim = Simulation(one_body(dt=dt, orientation=[0.0, 0.6, 0.0, 0.8]))
    sim.apply_impulse('box', linear=(1.0, 2.0, 3.0), angular=(0.1, 0.2, 0.3))
    np.testing.assert_array_equal(sim.state.velocity[0], (0.5, 1.0, 1.5))
    np.testing.assert_array_equal(sim.state.angular_momentum[0], (0.1, 0.2, 0.3))


def test_impulse_in_body_axes_is_turned_into_world_axes():
    sim = Simulation(one_body(orientation=[0.0, 0.6, 0.0, 0.8]))
    sim.apply_impulse('box', linear=(1.0, 0.0, 0.0), frame='body')
    expected = rotate((0.0, 0.6, 0.0, 0.8), (1.0, 0.0, 0.0)) / 2.0
    np.testing.assert_allclose(sim.state.velocity[0], expected, rtol=1e-15)


def test_sources_of_commands_add_and_zero_lets_go():
    sim = Simulation(one_body())
    sim.hold('box', 'force', force=(1.0, 0.0, 0.0))
    sim.hold('box', 'wrench', force=(2.0, 0.0, 0.0))
    np.testing.assert_array_equal(sim.applied_wrench()[0][0], (3.0, 0.0, 0.0))
    sim.hold('box', 'force', force=(0.0, 0.0, 0.0))
    np.testing.assert_array_equal(sim.applied_wrench()[0][0], (2.0, 0.0, 0.0))


def test_held_command_ends_on_the_tick_it_was_given():
    sim = Simulation(one_body())
    sim.hold('box', 'wrench', force=(2.0, 0.0, 0.0), until=100)
    sim.step(1000)
    # F/m = 1 m/s^2 for 0.1 s
    assert sim.state.velocity[0, 0] == pytest.approx(0.1, rel=ROUND_OFF)


@pytest.mark.parametrize(
    ('command', 'message'),
    [
        ({'body': 'ball'}, "no body is named 'ball'"),
        ({'body': 'box', 'force': (float('nan'), 0, 0)}, 'three finite numbers'),
        ({'body': 'box', 'force': (1, 2)}, 'three finite numbers'),
        ({'body': 'box', 'frame': 'map'}, "frame 'map'"),
    ],
)
def test_command_that_no_body_can_follow_is_refused(command, message):
    sim = Simulation(one_body())
    with pytest.raises(InvalidModel, match=message):
        sim.set_wrench(command.pop('body'), **command)


def test_torque_on_a_point_mass_is_refused():
    scene = load_scene(
        {
            'version': 1,
            'name': 'point',
            'dt': 0.001,
            'bodies': [{'name': 'ball', 'shape': {'type': 'particle'}, 'mass': 1.0}],
        }
    )
    with pytest.raises(InvalidModel, match='point mass'):
        Simulation(scene).set_wrench('ball', torque=(1.0, 0.0, 0.0))


@pytest.mark.parametrize(
    'force',
    [
        {'type': 'constant', 'body': 'ball', 'torque': [1, 0, 0]},
        {'type': 'constant', 'body': 'ball', 'force': [1, 0, 0], 'frame': 'body'},
        {'type': 'constant', 'body': 'ball', 'force': [1, 0, 0], 'point': [0, 0, 1]},
        {'type': 'drag', 'body': 'ball', 'angular': 0.1},
        {'type': 'spring', 'a': 'ball', 'a_point': [0, 0, 1], 'b': 'world', 'stiffness': 1},
    ],
)
def test_force_element_that_would_turn_a_point_mass_is_refused(force):
    scene = load_scene(
        {
            'version': 1,
            'name': 'point',
            'dt': 0.001,
            'bodies': [{'name': 'ball', 'shape': {'type': 'particle'}, 'mass': 1.0}],
            'forces': [force],
        }
    )
    with pytest.raises(InvalidModel, match='point mass'):
        Simulation(scene)


def test_command_to_a_fixed_body_is_refused():
    scene = load_scene(
        {
            'version': 1,
            'name': 'wall',
            'dt': 0.001,
            'bodies': [
                {
                    'name': 'wall',
                    'shape': {'type': 'box', 'size': [1, 1, 1]},
                    'mass': 1.0,
                    'fixed': True,
                }
            ],
        }
    )
    sim = Simulation(scene)
    sim.step(10)
    np.testing.assert_array_equal(sim.state.position, [[0.0, 0.0, 0.0]])
    with pytest.raises(InvalidModel, match='fixed'):
        sim.set_wrench('wall', force=(1.0, 0.0, 0.0))
