# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Implicit integrators: their stability functions, what they keep, how they fail."""

import cmath
import math

import numpy as np
import pytest

from rigid_body_sim import Simulation
from rigid_body_sim.exact import free_asymmetric_top, oscillator
from rigid_body_sim.physics.errors import SimulationDiverged
from rigid_body_sim.physics.forces.elements import FORCES
from rigid_body_sim.physics.integration.schemes.implicit import coupling, linearly_implicit, stage
from rigid_body_sim.physics.model.rotation import angle_between

from . import scenes

IMPLICIT = ('implicit_euler', 'implicit_midpoint', 'sdirk2')
G = 1.0 - 1.0 / math.sqrt(2.0)


def growth(name, z):
    """Stability function R(z): what a step of y' = lambda y multiplies y by, z = h lambda."""
    if name == 'implicit_euler':
        return 1.0 / (1.0 - z)
    if name == 'implicit_midpoint':
        return (1.0 + z / 2.0) / (1.0 - z / 2.0)
    return (1.0 + (1.0 - 2.0 * G) * z) / (1.0 - G * z) ** 2


def exact_steps(name, *, stiffness, damping, h, steps):
    """
    State (x, v) that the method gives on x'' = -k x - c x' from (1, 0), by its stability function.
    """
    root = cmath.sqrt(damping * damping - 4.0 * stiffness)
    slow, fast = (-damping + root) / 2.0, (-damping - root) / 2.0
    if abs(slow) < abs(fast):
        slow = stiffness / fast  # free of cancellation
    else:
        fast = stiffness / slow
    a, b = -fast / (slow - fast), slow / (slow - fast)
    a, b = a * growth(name, h * slow) ** steps, b * growth(name, h * fast) ** steps
    return (a + b).real, (a * slow + b * fast).real


@pytest.mark.parametrize('ratio', [1e-2, 1.0, 1e2, 1e4, 1e6, 1e9])
@pytest.mark.parametrize('damping_ratio', [0.0, 0.3, 2.0])
@pytest.mark.parametrize('name', IMPLICIT)
def test_stiff_spring_moves_as_the_stability_function_says(name, damping_ratio, ratio):
    h = 0.01
    stiffness = ratio / h**2
    omega = math.sqrt(stiffness)
    damping = 2.0 * damping_ratio * omega
    sim = Simulation(
        scenes.oscillator(dt=h, stiffness=stiffness, damping=damping), integrator=name
    )
    sim.step(20)
    x, v = exact_steps(name, stiffness=stiffness, damping=damping, h=h, steps=20)
    # round-off of twenty solves with condition k h^2, in units of the start
    tolerance = 1e-14 * 20
    assert sim.state.position[0, 0] == pytest.approx(x, rel=1e-10, abs=tolerance)
    assert sim.state.velocity[0, 0] / omega == pytest.approx(v / omega, rel=1e-10, abs=tolerance)


@pytest.mark.parametrize('ratio', [1e-2, 1.0, 1e3, 1e6, 1e9])
def test_implicit_midpoint_neither_grows_nor_decays_on_a_spring(ratio):
    h = 0.01
    sim = Simulation(
        scenes.oscillator(dt=h, stiffness=ratio / h**2), integrator='implicit_midpoint'
    )
    energy = sim.energy()
    sim.step(500)
    # round-off: 500 solves whose condition grows with k h^2
    assert sim.energy() / energy == pytest.approx(1.0, abs=1e-11)


@pytest.mark.parametrize(
    ('name', 'error'),
    [('implicit_euler', 5.0e-7), ('sdirk2', 1e-9), ('implicit_midpoint', 9.6e-5)],
)
def test_overdamped_slow_mode_is_right_at_steps_ten_thousand_times_too_long(name, error):
    """
    k = 1e4, c = 1e6: exp(-0.01 t) is left; error of the exact stability function, from the table
    of methods.
    """
    sim = Simulation(scenes.oscillator(dt=0.01, stiffness=1e4, damping=1e6), integrator=name)
    sim.step(100)
    exact = oscillator.oscillation(1.0, mass=1.0, stiffness=1e4, damping=1e6, position=1.0)
    assert sim.state.position[0, 0] == pytest.approx(float(exact.position[0]), abs=1.05 * error)


@pytest.mark.parametrize(
    ('name', 'h', 'error'),
    [
        ('implicit_euler', 0.01, 0.99),
        ('implicit_euler', 0.001, 0.39),
        ('implicit_midpoint', 0.01, 8.3e-2),
        ('implicit_midpoint', 0.001, 8.3e-4),
        ('sdirk2', 0.01, 4.0e-2),
        ('sdirk2', 0.001, 4.0e-4),
    ],
)
def test_errors_on_a_spring_are_those_of_the_table(name, h, error):
    """k = 100, c = 0, T = 10: distance in (x, v / omega)."""
    sim = Simulation(scenes.oscillator(dt=h, stiffness=100.0), integrator=name)
    sim.step(round(10.0 / h))
    measured = math.hypot(
        sim.state.position[0, 0] - math.cos(100.0),
        sim.state.velocity[0, 0] / 10.0 + math.sin(100.0),
    )
    assert measured == pytest.approx(error, rel=0.02)  # two digits in the table


@pytest.mark.parametrize('h', [0.001, 0.05, 0.4, 2.0, 4.0])
@pytest.mark.parametrize('inertia', [(1.0, 2.0, 3.0), (1e-3, 1.0, 1.0005), (1.0, 1.0, 1.0)])
def test_implicit_midpoint_keeps_energy_and_the_bits_of_the_angular_momentum(inertia, h):
    omega = (0.3, 0.8, 0.52)
    sim = Simulation(
        scenes.top(inertia=inertia, omega=omega, dt=h), integrator='implicit_midpoint'
    )
    energy, angular = sim.energy(), sim.state.angular_momentum.tobytes()
    sim.step(2000)
    assert sim.state.angular_momentum.tobytes() == angular
    # round-off, 1000 times larger on the needle: an attitude error of 1e-16 a step moves L across
    # its axes
    assert sim.energy() / energy == pytest.approx(1.0, abs=1e-12 * max(inertia) / min(inertia))


@pytest.mark.parametrize('held', [False, True])
def test_implicit_midpoint_is_one_method_whether_bodies_are_coupled_or_free(held):
    def last(*, with_element):
        scene = scenes.top(omega=(0.3, 1.0, 0.2), dt=0.05)
        sim = Simulation(scene, integrator='implicit_midpoint')
        if held:
            sim.set_wrench('top', force=(1, 2, 3), torque=(0.1, 0.0, -0.2))
        if with_element:  # zero, but in body axes: takes the coupled kernel
            sim.hold('top', 'force', force=(0.0, 0.0, 0.0), frame='body')
        sim.step(100)
        return sim.state

    free, coupled = last(with_element=False), last(with_element=True)
    np.testing.assert_array_equal(free.angular_momentum, coupled.angular_momentum)
    assert angle_between(free.orientation[0], coupled.orientation[0]) < 1e-13  # round-off
    np.testing.assert_allclose(free.position, coupled.position, rtol=1e-13)


def test_implicit_midpoint_keeps_momentum_and_angular_momentum_of_linked_bodies():
    bodies = [
        {
            'name': name,
            'mass': mass,
            'inertia': {'ixx': 0.2, 'iyy': 0.3, 'izz': 0.25},
            'initial': {'position': position, 'velocity': velocity, 'angular_velocity': [1, 2, 3]},
        }
        for name, mass, position, velocity in (
            ('a', 1.0, [0, 0, 0], [0, 1, 0]),
            ('b', 2.0, [1, 0, 0], [0, 0, 1]),
        )
    ]
    spring = {
        'type': 'spring', 'a': 'a', 'a_point': [0.1, 0.2, 0.3],
        'b': 'b', 'b_point': [-0.2, 0.1, 0], 'stiffness': 5000.0,
        'damping': 0.3, 'rest_length': 0.4,
    }  # fmt: skip
    sim = Simulation(
        scenes.scene(bodies, forces=[spring], dt=0.01), integrator='implicit_midpoint'
    )
    momentum, angular = sim.momentum(), sim.angular_momentum()
    sim.step(1000)
    # round-off of 1000 solves
    np.testing.assert_allclose(sim.momentum(), momentum, rtol=0, atol=1e-12)
    np.testing.assert_allclose(sim.angular_momentum(), angular, rtol=0, atol=1e-11)


@pytest.mark.usefixtures('plain_source')
@pytest.mark.parametrize('name', scenes.mostly_long(IMPLICIT, short=('implicit_midpoint',)))
def test_derivatives_by_differences_give_the_same_motion(name, monkeypatch):
    """An element that brings no kernel `linearise` is served as well."""

    def final():
        sim = Simulation(scenes.linked_bodies(), integrator=name, dt=0.01)
        sim.set_wrench('rod', force=(0, 0, 1), frame='body')
        sim.step(50)
        return sim.state.values

    analytic = final()
    monkeypatch.delattr(FORCES['drag'], 'linearise')
    monkeypatch.delattr(FORCES['spring'], 'linearise')
    # both solve the same equations to round-off
    np.testing.assert_allclose(final(), analytic, rtol=0, atol=1e-12)


def test_stiff_link_between_bodies_is_followed_at_any_stiffness():
    """
    Two bodies on a stiff spring without rest length: its ends stay together, the rest moves on.
    """
    for stiffness in (1e2, 1e6, 1e10):
        bodies = [
            {
                'name': name,
                'mass': 1.0,
                'inertia': {'ixx': 0.1, 'iyy': 0.2, 'izz': 0.25},
                'initial': {'position': [x, 0, 0], 'angular_velocity': [0, 0, 1]},
            }
            for name, x in (('a', 0.0), ('b', 1.0))
        ]
        spring = {
            'type': 'spring', 'a': 'a', 'a_point': [0.5, 0, 0], 'b': 'b', 'b_point': [-0.5, 0, 0],
            'stiffness': stiffness,
        }  # fmt: skip
        sim = Simulation(scenes.scene(bodies, forces=[spring], dt=0.01), integrator='sdirk2')
        energy = sim.energy()
        sim.step(500)
        assert np.isfinite(sim.state.values).all()
        assert sim.energy() <= energy * (
            1.0 + 1e-9
        )  # L-stable: stiff motion is damped, none is made


def test_a_group_that_needs_smaller_parts_does_not_disturb_the_others():
    """The first body spins too fast for Newton in one piece; the second never meets it."""

    def last(count):
        bodies = [
            {
                'name': f'b{i}',
                'mass': 1.0,
                'inertia': {'ixx': 1.0, 'iyy': 2.0, 'izz': 2.5},
                'initial': {
                    'angular_velocity': [0.1, 1.0, 0.2] if i == 0 else [400.0, 300.0, 20.0]
                },
            }
            for i in range(count)
        ]
        drag = [{'type': 'drag', 'body': b['name'], 'angular_quadratic': 0.1} for b in bodies]
        sim = Simulation(scenes.scene(bodies, forces=drag, dt=0.2), integrator='sdirk2')
        sim.step(5)
        return sim.state.values[0].tobytes()

    assert last(1) == last(2)


@pytest.mark.parametrize('name', IMPLICIT)
def test_newton_that_does_not_converge_stops_the_run_and_says_so(name):
    """
    Drag 1e20 v^2 at 1e8 m/s: the speed falls by 1e28 in a step, and each iteration halves it only.
    """
    ball = {
        'name': 'ball',
        'shape': {'type': 'particle'},
        'mass': 1.0,
        'initial': {'velocity': [1e8, 0.0, 0.0]},
    }
    drag = {'type': 'drag', 'body': 'ball', 'quadratic': 1e20}
    sim = Simulation(scenes.scene([ball], forces=[drag], dt=1.0), integrator=name)
    with pytest.raises(SimulationDiverged, match='Newton iteration did not converge') as caught:
        sim.step(10)
    assert (caught.value.body, caught.value.tick, sim.tick) == ('ball', 0, 0)
    assert sim.state.velocity[0, 0] == 1e8  # the last good state


def test_free_top_follows_the_exact_motion():
    sim = Simulation(scenes.top(omega=(0.4, 1.0, 0.3), dt=0.001), integrator='sdirk2')
    sim.step(2000)
    exact = free_asymmetric_top.rotation(
        2.0, inertia=(1, 2, 3), angular_velocity_body=(0.4, 1.0, 0.3)
    )
    assert angle_between(sim.state.orientation[0], exact.orientation) < 1e-6  # truncation h^2


def test_the_scratch_of_a_body_has_room_in_its_row():
    assert max(stage.scratch.size, linearly_implicit.scratch.size) <= coupling.BODY


def test_cayley_half_of_the_midpoint_rule_is_half_of_the_rotation():
    """q0 (c, 1) with c = u / (1 + |(u, 1)|) twice is q0 (u, 1)."""
    u = np.array([0.3, -0.7, 0.2])
    c = u / (1.0 + math.sqrt(1.0 + u @ u))
    half = stage.turned((0.0, 0.0, 0.0, 1.0), tuple(c.tolist()))
    whole = stage.turned(half, tuple(c.tolist()))
    assert angle_between(whole, (*u, 1.0) / np.sqrt(1.0 + u @ u)) < 1e-15
