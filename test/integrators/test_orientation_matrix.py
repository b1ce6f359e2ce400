# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The lecture's state (r, R, p, L): how the matrix drifts, and that re-orthonormalising keeps it a
rotation.
"""

import numpy as np
import pytest

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.errors import UserError
from rigid_body_sim.exact import free_asymmetric_top
from rigid_body_sim.physics.integration.integrators import INTEGRATORS
from rigid_body_sim.physics.model import rotation

from . import scenes

pytestmark = pytest.mark.usefixtures('plain_source')  # few ticks: to compile takes longer

OF_FIXED_STEP = ['explicit_euler', 'midpoint', 'rk4', 'rk8']
NAMES = [*OF_FIXED_STEP, 'rk45']
# one that steps as it is told and one that chooses: the others have other coefficients
SHORT = ['rk4', 'rk45']
KEPT = {'orientation': 'matrix', 'reorthonormalise': True}
DRIFTING = {'orientation': 'matrix', 'reorthonormalise': False}


def spun(name, options, *, omega=(0.0, 0.0, 1.0), h=0.1, ticks=100):
    sim = Simulation(scenes.top(omega=omega, dt=h), integrator=name, integrator_options=options)
    sim.step(ticks)
    return sim


def stretch(sim):
    """Largest entry of R^T R - 1."""
    matrix = sim.orientation_matrices()[0]
    return float(np.abs(matrix.T @ matrix - np.eye(3)).max())


# about a fixed axis a step multiplies by P(i z), z = h omega, P the Taylor polynomial: |P(i z)|^2
# is what R^T R gains
GROWTH = {
    'explicit_euler': lambda z: 1 + z**2,
    'midpoint': lambda z: 1 + z**4 / 4,
    'rk4': lambda z: 1 - z**6 / 72 + z**8 / 576,
}


@pytest.mark.parametrize('name', scenes.mostly_long(sorted(GROWTH), short=SHORT))
def test_the_matrix_drifts_from_a_rotation_as_the_method_says(name):
    for ticks in (10, 100):
        sim = spun(name, DRIFTING, h=0.5, ticks=ticks)
        expected = abs(GROWTH[name](0.5) ** ticks - 1.0)
        assert stretch(sim) == pytest.approx(expected, rel=1e-11)  # round-off of a product
        assert sim.orientation_drift() == pytest.approx(expected, rel=1e-11)


@pytest.mark.parametrize('ticks', [250, pytest.param(1000, marks=pytest.mark.long)])
@pytest.mark.parametrize('name', scenes.mostly_long(NAMES, short=SHORT))
def test_a_reorthonormalised_matrix_stays_a_rotation(name, ticks):
    spun_by_it = spun(name, KEPT, omega=(0.4, 1.0, 0.3), h=0.1, ticks=ticks)
    assert stretch(spun_by_it) < 2e-15  # round-off


def test_the_quaternion_stays_a_rotation_where_the_matrix_does_not():
    omega = (0.4, 1.0, 0.3)
    kept = spun('rk4', {}, omega=omega)
    assert stretch(kept) < 2e-15  # round-off
    assert kept.orientation_drift() is None
    assert stretch(spun('rk4', DRIFTING, omega=omega)) > 1e-8


@pytest.mark.parametrize('options', [KEPT, DRIFTING], ids=['kept', 'drifting'])
@pytest.mark.parametrize(
    ('name', 'steps'),
    [
        pytest.param('explicit_euler', (2e-4, 1e-4), marks=pytest.mark.long),
        pytest.param('midpoint', (0.01, 0.005), marks=pytest.mark.long),
        ('rk4', (0.04, 0.02)),
        pytest.param('rk8', (0.125, 0.1), marks=pytest.mark.long),
    ],
)
def test_the_order_is_that_of_the_method(name, steps, options):
    omega = (0.4, 1.0, 0.3)
    exact = free_asymmetric_top.rotation(8.0, inertia=(1, 2, 3), angular_velocity_body=omega)
    coarse, fine = (
        float(
            rotation.angle_between(
                spun(name, options, omega=omega, h=h, ticks=round(8 / h)).state.orientation[0],
                exact.orientation,
            )
        )
        for h in steps
    )
    order = np.log(coarse / fine) / np.log(steps[0] / steps[1])
    # 0.1 of the next term; rk8 is that far from its leading term when round-off begins
    assert order == pytest.approx(INTEGRATORS[name].free_order, abs=0.15 if name == 'rk8' else 0.1)


@pytest.mark.parametrize('options', [KEPT, DRIFTING], ids=['kept', 'drifting'])
def test_steps_of_chosen_length_keep_to_their_tolerance_on_a_matrix_too(options):
    omega = (0.4, 1.0, 0.3)
    exact = free_asymmetric_top.rotation(8.0, inertia=(1, 2, 3), angular_velocity_body=omega)
    errors = []
    for rtol in (1e-6, 1e-9):
        tolerances = {'rtol': rtol, 'atol': 1e-3 * rtol}
        sim = spun('rk45', options | tolerances, omega=omega, h=2.0, ticks=4)  # refuses substeps
        errors.append(float(rotation.angle_between(sim.state.orientation[0], exact.orientation)))
        assert errors[-1] < 100 * rtol
    assert errors[1] < errors[0] / 50


@pytest.mark.parametrize('options', [KEPT, DRIFTING], ids=['kept', 'drifting'])
def test_angular_momentum_does_not_change_in_its_last_bit_without_torque(options):
    sim = Simulation(
        scenes.top(omega=(0.4, 1.0, 0.3), dt=0.05), integrator='rk4', integrator_options=options
    )
    before = sim.state.angular_momentum.tobytes()
    sim.step(1000)
    assert sim.state.angular_momentum.tobytes() == before


# rk4 also drifts below; what is kept comes after the evaluation of forces, and each method does it
# alone above
@pytest.mark.parametrize(
    ('name', 'options'),
    [
        pytest.param('explicit_euler', KEPT, marks=pytest.mark.long),
        pytest.param('midpoint', DRIFTING, marks=pytest.mark.long),
        ('rk4', KEPT),
        pytest.param('rk8', DRIFTING, marks=pytest.mark.long),
    ],
)
def test_matrix_and_quaternion_agree_on_linked_bodies(name, options):
    runs = [
        Simulation(scenes.linked_bodies(), integrator=name, integrator_options=o)
        for o in ({}, options)
    ]
    for sim in runs:
        sim.step(40)
    # truncation of either over 40 ms at h = 1 ms
    allowed = {'explicit_euler': 0.05, 'midpoint': 2e-4, 'rk4': 1e-8, 'rk8': 1e-12}[name]
    assert runs[0].state.values == pytest.approx(runs[1].state.values, abs=allowed)


@pytest.mark.parametrize(
    ('name', 'options', 'bodies'),
    [
        ('rk4', KEPT, scenes.linked_bodies),
        pytest.param('rk4', DRIFTING, scenes.linked_bodies, marks=pytest.mark.long),
        ('rk4', DRIFTING, scenes.top),
        ('rk45', KEPT, scenes.top),
        pytest.param('rk45', KEPT, scenes.linked_bodies, marks=pytest.mark.long),
    ],
)
def test_the_matrix_belongs_to_the_state(name, options, bodies):
    """
    One call or many, and going on from state bytes: the same bits; and a reset forgets the drift.
    """

    def made():
        return Simulation(bodies(), integrator=name, integrator_options=options, dt=0.01)

    whole, parts = made(), made()
    start = whole.state_bytes()
    whole.step(60)
    for _ in range(40):
        parts.step()
    rest = made()
    rest.restore(tick=40, state=parts.state_bytes(), slots={})
    rest.step(20)
    assert rest.state_bytes() == whole.state_bytes()
    whole.reset()
    assert whole.state_bytes() == start


def test_a_state_without_matrix_starts_from_its_quaternions():
    source = Simulation(scenes.linked_bodies(), integrator='rk4')
    source.step(10)
    sim = Simulation(scenes.linked_bodies(), integrator='rk4', integrator_options=DRIFTING)
    sim.restore(tick=10, state=source.state_bytes(), slots={})
    matrices = rotation.matrix_from_quaternion(sim.state.orientation[:2])
    assert sim.orientation_matrices()[:2] == pytest.approx(matrices, abs=1e-15)  # round-off


def written(**keys):
    return load_scene(
        {
            'dt': 0.001,
            'bodies': [{'name': 'b', 'mass': 1, 'shape': {'type': 'box', 'size': [1, 2, 3]}}],
            **keys,
        }
    )


@pytest.mark.parametrize(
    ('keys', 'reorthonormalise'),
    [
        ({'integrator': 'rk4', 'orientation': 'matrix'}, False),
        (
            {
                'integrator': 'rk4',
                'orientation': {'representation': 'matrix', 'reorthonormalise': True},
            },
            True,
        ),
        ({'integrator': {'name': 'rk4', 'orientation': 'matrix', 'reorthonormalise': True}}, True),
    ],
)
def test_the_scene_chooses_the_representation(keys, reorthonormalise):
    settings = Simulation(written(**keys)).integrator.settings
    assert settings['orientation'] == 'matrix'
    assert settings['reorthonormalise'] is reorthonormalise


def test_an_integrator_that_offers_no_choice_refuses_one():
    with pytest.raises(UserError, match=r'dmv6.*explicit_euler, midpoint, rk4, rk45, rk8'):
        written(integrator='dmv6', orientation='matrix')
