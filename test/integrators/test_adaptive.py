# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
rk45: the tolerance rules the error, every tick is reached, and the bits do not depend on how one
steps.
"""

import math

import numpy as np
import pytest

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.errors import UserError
from rigid_body_sim.exact import ballistic, free_asymmetric_top, oscillator
from rigid_body_sim.physics.errors import InvalidModel, SimulationDiverged
from rigid_body_sim.physics.model.rotation import angle_between

from . import scenes

OMEGA = (0.4, 1.0, 0.3)
BALL = {'type': 'sphere', 'radius': 0.1}  # for the kernel of bodies that turn, which is there


def adaptive(scene, **options):
    return Simulation(scene, integrator='rk45', integrator_options=options)


def error_of_top(rtol, *, dt=2.0):
    sim = adaptive(scenes.top(omega=OMEGA, dt=dt), rtol=rtol, atol=1e-13)
    sim.step(round(8.0 / dt))
    exact = free_asymmetric_top.rotation(8.0, inertia=(1, 2, 3), angular_velocity_body=OMEGA)
    return float(angle_between(sim.state.orientation[0], exact.orientation))


def error_of_spring(rtol, *, dt=1.0):
    sim = adaptive(scenes.oscillator(dt=dt, damping=0.3, shape=BALL), rtol=rtol, atol=1e-13)
    sim.step(round(4.0 / dt))
    exact = oscillator.oscillation(4.0, mass=1.0, stiffness=4.0, damping=0.3, position=1.0)
    return math.hypot(
        sim.state.position[0, 0] - float(exact.position[0]),
        sim.state.velocity[0, 0] - float(exact.velocity[0]),
    )


@pytest.mark.parametrize('error', [error_of_top, error_of_spring])
def test_the_error_follows_the_tolerance(error):
    tolerances = [1e-4, 1e-6, 1e-8, 1e-10]
    errors = [error(rtol) for rtol in tolerances]
    for rtol, measured in zip(tolerances, errors, strict=True):
        # some tens of substeps, each with an error of at most rtol, mostly less
        assert 0.01 * rtol < measured < 50.0 * rtol
    # proportional to the tolerance, but for the number of substeps and the share of the leading
    # term
    slope = math.log10(errors[0] / errors[-1]) / 6.0
    assert 0.8 < slope < 1.2


@pytest.mark.parametrize('dt', [0.01, 0.125, 1.0, 8.0])
def test_every_tick_is_reached_whatever_its_length(dt):
    assert error_of_top(1e-9, dt=dt) < 5e-8


@pytest.mark.usefixtures('plain_source')
def test_free_fall_is_exact_over_any_tick():
    start = {'position': [1.0, 2.0, 3.0], 'velocity': [3.0, 4.0, 20.0]}
    ball = {'name': 'ball', 'shape': {'type': 'particle'}, 'mass': 2.0, 'initial': start}
    sim = adaptive(scenes.scene([ball], dt=0.5, gravity=(0, 0, -9.81)))
    sim.step(8)
    exact = ballistic.flight(4.0, acceleration=(0, 0, -9.81), **start)
    np.testing.assert_allclose(sim.state.position[0], exact.position, rtol=1e-14)  # round-off


def test_one_call_gives_the_bits_of_many_when_ticks_hold_many_substeps():
    def made():
        scene = scenes.linked_bodies()
        sim = Simulation(scene, integrator='rk45', dt=0.2)
        sim.set_wrench('rod', force=(0, 0, 1), frame='body')
        return sim

    whole, parts = made(), made()
    whole.step(10)
    for _ in range(10):
        parts.step()
    assert whole.state_bytes() == parts.state_bytes()


def test_a_run_goes_on_from_its_state_bytes_with_the_same_bits():
    scene = scenes.linked_bodies()
    whole = Simulation(scene, integrator='rk45', dt=0.1)
    whole.step(7)
    middle = whole.state_bytes()
    whole.step(5)
    rest = Simulation(scene, integrator='rk45', dt=0.1)
    rest.restore(tick=7, state=middle, slots={})
    rest.step(5)
    assert rest.state_bytes() == whole.state_bytes()


def test_a_large_block_gives_the_bits_of_a_small_one():
    """From eight bodies on the stages are summed block-wise; the order of the sums is the same."""

    def swinging(count):
        balls = [
            {
                'name': f'b{i}',
                'mass': 1.0,
                'inertia': {'ixx': 1.0, 'iyy': 2.0, 'izz': 2.5},
                'initial': {'position': [1.0, 0, 0], 'angular_velocity': [0.1, 1.0, 0.2]},
            }
            for i in range(count)
        ]
        springs = [
            {
                'type': 'spring',
                'a': f'b{i}',
                'b': 'world',
                'a_point': [0, 0.2, 0],
                'stiffness': 9.0,
            }
            for i in range(count)
        ]
        sim = adaptive(scenes.scene(balls, forces=springs, dt=0.3))
        sim.step(10)
        return sim.state.values[0].tobytes()

    assert swinging(1) == swinging(7) == swinging(9) == swinging(70)


def test_a_stiff_spring_costs_substeps_but_is_right():
    scene = scenes.oscillator(dt=0.1, stiffness=1e6, shape=BALL)
    sim = adaptive(scene, rtol=1e-10, atol=1e-12)
    sim.step(10)
    exact = oscillator.oscillation(1.0, mass=1.0, stiffness=1e6, position=1.0)
    # 160 periods of substeps, each right to rtol: 1e4 substeps of at most 1e-10
    assert abs(sim.state.position[0, 0] - float(exact.position[0])) < 1e-6


def test_what_no_substep_can_follow_stops_the_run_and_says_so():
    sim = adaptive(
        scenes.top(omega=(1e149, 1e149, 1e148), dt=1.0)
    )  # its gyroscopic term nearly overflows
    with pytest.raises(SimulationDiverged, match='no substep down to 1e-12 of the tick') as caught:
        sim.step(3)
    assert caught.value.body == 'top'
    assert caught.value.tick == 0
    assert np.isfinite(sim.state.angular_velocity).all()


def written(**keys):
    ball = {'name': 'ball', 'shape': {'type': 'particle'}, 'mass': 1.0}
    return load_scene({'dt': 0.001, 'bodies': [ball], **keys})


def test_tolerances_are_read_from_the_scene():
    scene = written(integrator={'name': 'rk45', 'rtol': '1e-6'})
    settings = Simulation(scene).integrator.settings
    assert (settings['rtol'], settings['atol']) == (1e-6, 1e-12)
    assert (
        Simulation(scene, integrator='rk4').integrator.name == 'rk4'
    )  # options go with their integrator


@pytest.mark.parametrize(
    ('integrator', 'reason'),
    [
        (
            {'name': 'rk45', 'rtl': 1e-6},
            "integrator.rtl: unknown key; did you mean 'rtol'? allowed: name, rtol, atol",
        ),
        (
            {'name': 'rk45', 'rtol': -1},
            'integrator.rtol: got -1.0; a number [-] from 1e-13 to 0.1',
        ),
        ({'name': 'dmv6', 'rtol': 1e-6}, 'integrator.rtol: unknown key; allowed: name'),
        ({'rtol': 1e-6}, 'integrator: name is missing'),
    ],
)
def test_impossible_options_are_refused_with_the_allowed_ones(integrator, reason):
    with pytest.raises(UserError) as caught:
        written(integrator=integrator)
    assert reason in str(caught.value)


@pytest.mark.parametrize(
    ('options', 'reason'),
    [
        ({'x': 1}, "no option 'x'; allowed: rtol, atol"),
        ({'rtol': 2.0}, 'rtol: got 2.0; a number from'),
    ],
)
def test_impossible_options_of_a_simulation_are_refused(options, reason):
    with pytest.raises(InvalidModel) as caught:
        adaptive(written(), **options)
    assert reason in str(caught.value)
