# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Measured order equals claimed order."""

import itertools
import math
from functools import cache

import numpy as np
import pytest

from rigid_body_sim import Simulation
from rigid_body_sim.exact import drag, free_asymmetric_top, free_symmetric_top, oscillator
from rigid_body_sim.physics.integration.integrators import INTEGRATORS
from rigid_body_sim.physics.model.rotation import angle_between

from . import scenes

NAMES = scenes.of_fixed_step()
TURNING = scenes.of_fixed_step(scenes.TURNING)
SLOPE = 0.1  # what the order may differ by: the next term of the error at the step lengths chosen


def slope(error, steps):
    """Last slope of log error over log step."""
    errors = [error(h) for h in steps]
    slopes = [
        math.log(a / b) / math.log(g / h)
        for (g, a), (h, b) in itertools.pairwise(zip(steps, errors, strict=True))
    ]
    return slopes[-1]


# step lengths short enough for the leading term and long enough to stay clear of round-off
FREE_STEPS = {
    1: (2e-4, 1e-4),
    2: (0.01, 0.005),
    4: (0.04, 0.02),
    6: (0.16, 0.08),
    8: (0.2, 0.16),
    10: (0.32, 0.2),
}
FREE_STEPS_OF = {  # closer to round-off: six drifts a step, large coefficients
    'blanes_moan4': (0.5, 0.32),
    'force_gradient4': (0.32, 0.16),  # two drifts a step
    'rk8': (0.4, 0.32),
}
# from order 16 on truncation lies below round-off at every step the method takes undivided
AT_ROUND_OFF = 16
FORCED_STEPS = {1: (2e-4, 1e-4), 2: (0.01, 0.005), 4: (0.04, 0.02), 8: (0.25, 0.2)}
TORQUE_STEPS_OF = {'blanes_moan4': (0.08, 0.05)}  # a thousandth of the error of others


def assert_free_order(error, name):
    order = INTEGRATORS[name].free_order
    if order >= AT_ROUND_OFF:
        assert max(error(h) for h in (0.4, 0.1)) < 2e-14  # eighty steps of 1e-16
    else:
        assert slope(error, FREE_STEPS_OF.get(name) or FREE_STEPS[order]) == pytest.approx(
            order, abs=SLOPE
        )


def simulation(scene, name):
    """Make a run, or leave the test where the integrator refuses the scene."""
    refusal = INTEGRATORS[name].refuses(scene)
    if refusal is not None:
        pytest.skip(refusal)
    return Simulation(scene, integrator=name)


def run_plain_if_few(name, request):
    """Ticks of a method of the first order are many: it is compiled."""
    if INTEGRATORS[name].order > 1:
        request.getfixturevalue('plain_source')


@pytest.mark.parametrize('name', TURNING)
def test_free_asymmetric_top_converges_with_the_claimed_order(name):
    omega = (0.4, 1.0, 0.3)

    def error(h):
        sim = Simulation(scenes.top(omega=omega, dt=h), integrator=name)
        sim.step(round(8.0 / h))
        exact = free_asymmetric_top.rotation(8.0, inertia=(1, 2, 3), angular_velocity_body=omega)
        return angle_between(sim.state.orientation[0], exact.orientation)

    assert_free_order(error, name)


@pytest.mark.parametrize('name', TURNING)
def test_free_symmetric_top_converges_with_the_claimed_order(name):
    omega = (0.6, 0.0, 1.0)

    def error(h):
        sim = Simulation(scenes.top(inertia=(2.0, 2.0, 1.0), omega=omega, dt=h), integrator=name)
        sim.step(round(8.0 / h))
        exact = free_symmetric_top.rotation(
            8.0, inertia_across=2.0, inertia_axial=1.0, angular_velocity_body=omega
        )
        return angle_between(sim.state.orientation[0], exact.orientation)

    assert_free_order(error, name)


@pytest.mark.parametrize('damping', [pytest.param(0.0, marks=pytest.mark.long), 0.8])
@pytest.mark.parametrize(
    'name',  # the implicit method of the first order would be compiled for its many ticks
    scenes.mostly_long(NAMES, short=scenes.first_of_each_scheme(NAMES) - {'implicit_euler'}),
)
def test_spring_converges_with_the_claimed_order(name, damping, request):
    run_plain_if_few(name, request)

    def error(h):
        sim = simulation(scenes.oscillator(dt=h, damping=damping), name)
        sim.step(round(2.0 / h))
        exact = oscillator.oscillation(2.0, mass=1.0, stiffness=4.0, damping=damping, position=1.0)
        return math.hypot(
            sim.state.position[0, 0] - float(exact.position[0]),
            (sim.state.velocity[0, 0] - float(exact.velocity[0])) / 2.0,
        )

    order = INTEGRATORS[name].order
    if order == math.inf:
        assert max(error(h) for h in (0.5, 0.1)) < 1e-14  # twenty products of 1e-16
    else:
        assert slope(error, FORCED_STEPS[order]) == pytest.approx(order, abs=SLOPE)


# from rest the stages of a method of high order lie on both sides of the kink of |v| v in its
# first step
@pytest.mark.parametrize(
    'name', scenes.of_each_scheme([name for name in NAMES if INTEGRATORS[name].order < 8])
)
def test_quadratic_drag_converges_with_the_claimed_order(name, request):
    run_plain_if_few(name, request)

    def error(h):
        scene = scenes.scene(
            [{'name': 'ball', 'shape': {'type': 'particle'}, 'mass': 1.0}],
            forces=[{'type': 'drag', 'body': 'ball', 'quadratic': 0.5}],
            gravity=(0.0, 0.0, -9.81),
            dt=h,
        )
        sim = simulation(scene, name)
        sim.step(round(1.2 / h))
        exact = drag.quadratic_fall(1.2, mass=1.0, coefficient=0.5, gravity=9.81)
        return abs(sim.state.position[0, 2] - float(np.ravel(exact.position)[-1]))

    order = INTEGRATORS[name].order
    assert slope(error, FORCED_STEPS[order]) == pytest.approx(order, abs=SLOPE)


@cache
def attitude(h, integrator):
    """Where a top in a uniform field has turned to after 2 s."""
    scene = scenes.scene(
        [
            {
                'name': 'top',
                'mass': 1.0,
                'inertia': {'ixx': 1.0, 'iyy': 1.2, 'izz': 0.7},
                'initial': {'angular_velocity': [0.3, 0.2, 2.0]},
            }
        ],
        forces=[
            {'type': 'constant', 'body': 'top', 'force': [0.4, 0, -1.0], 'point': [0, 0, 0.5]}
        ],
        dt=h,
    )
    sim = Simulation(scene, integrator=integrator)
    sim.step(round(2.0 / h))
    return sim.state.orientation[0]


@pytest.mark.parametrize(
    'name',
    scenes.mostly_long(
        TURNING,  # those of the first order take so many ticks that each would be compiled
        short=[
            n
            for n in scenes.first_of_each_scheme(TURNING)
            if INTEGRATORS[n].order > 1 and n != 'sdirk2'  # its order is that on a spring, above
        ],
    ),
)
def test_torque_that_follows_the_attitude_converges_with_the_claimed_order(name, request):
    """
    A top in a uniform field: a force in world axes at a point off the centre of mass, against the
    finest run.
    """
    reference = attitude(0.001, 'rk4')  # its own error: 1e-13 rad, a thousandth of any below
    run_plain_if_few(name, request)
    order = INTEGRATORS[name].order
    steps = TORQUE_STEPS_OF.get(name) or FORCED_STEPS[order]
    measured = slope(lambda h: angle_between(attitude(h, name), reference), steps)
    assert measured == pytest.approx(order, abs=SLOPE)
