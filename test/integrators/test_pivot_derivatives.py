# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""The derivatives that implicit integrators get of pivoted bodies are those of the wrenches."""

import numpy as np
import pytest

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.physics.compile.kernels import argument
from rigid_body_sim.physics.forces.derivatives import BLOCK, DAMPING_MATRIX
from rigid_body_sim.physics.forces.elements import FORCES
from rigid_body_sim.physics.integration.integrators import INTEGRATORS
from rigid_body_sim.physics.integration.schemes.implicit import coupling
from rigid_body_sim.physics.integration.schemes.steps import start_evaluation
from rigid_body_sim.physics.model import rotation
from rigid_body_sim.physics.state.blocks import (
    FX,
    LX,
    PX,
    QX,
    ROTATION,
    RX,
    TRANSLATION,
    TX,
    gather,
    scatter,
)

from .. import inside

STEP = 1e-6  # of the differences


def linked():
    """Two pivoted bodies and a free one on damped springs, drag, a command in body axes."""

    def bar(name, x):
        return {
            'name': name,
            'shape': {'type': 'box', 'size': [0.1, 0.2, 0.6]},
            'mass': 1.5,
            'pivot': {'point': [0.05, 0.02, 0.3], 'at': [x, 0, 0]},
            'initial': {'angular_velocity': [1, 2, 3 + x]},
        }

    spring = {'type': 'spring', 'stiffness': 20.0, 'damping': 3.0, 'rest_length': 0.5}
    scene = {
        'dt': 0.01,
        'gravity': [0, 0, -9.81],
        'bodies': [
            bar('p', 0),
            bar('q', 1),
            {
                'name': 'm',
                'shape': {'type': 'sphere', 'radius': 0.2},
                'mass': 0.3,
                'initial': {'position': [2, 0, -1], 'velocity': [0.3, 0.1, 0.2]},
            },
        ],
        'forces': [
            spring | {'a': 'p', 'a_point': [0, 0, -0.3], 'b': 'q', 'b_point': [0, 0.1, -0.3]},
            spring | {'a': 'q', 'b': 'm', 'b_point': [0, 0.1, 0]},
            {'type': 'drag', 'body': 'p', 'linear': 0.4, 'angular': 0.1, 'quadratic': 0.2},
        ],
    }
    simulation = Simulation(load_scene(scene), integrator='implicit_midpoint')
    simulation.set_wrench('q', force=(1, 2, 3), torque=(0.1, 0.2, 0.3), frame='body')
    return inside.with_commands(simulation)


class Wrenches:
    """Forces and torques on the bodies of a simulation as its state is moved a little."""

    def __init__(self, simulation):
        self.stepper = inside.stepper(simulation)
        self.acting = inside.elements(simulation)
        self.layout = inside.layout(simulation)
        self.n = self.layout.n_moving

    def of(self, *, turned=None, spun=None, moved=None, pushed=None):
        """(n, 6), after a turn, a change of angular velocity, of place or of velocity: (n, 3)."""
        stepper, n, zero = self.stepper, self.n, np.zeros((self.n, 3))
        translation, turns = stepper.translation.copy(), stepper.rotation.copy()
        q, momentum = (gather(turns, ROTATION, row, c, n) for row, c in ((QX, 4), (LX, 3)))
        omega = rotation.rotate(q, rotation.rotate_back(q, momentum) / self.layout.moments)
        half = 0.5 * (zero if turned is None else turned)
        q = rotation.multiply(np.hstack((half, np.ones((n, 1)))), q)
        q /= np.linalg.norm(q, axis=1)[:, None]
        omega = omega + (zero if spun is None else spun)
        momentum = rotation.rotate(q, rotation.rotate_back(q, omega) * self.layout.moments)
        scatter(turns, ROTATION, QX, q)
        scatter(turns, ROTATION, LX, momentum)
        for row, change in ((RX, moved), (PX, pushed)):
            value = gather(translation, TRANSLATION, row, 3, n)
            mass = 1.0 if row == RX else self.layout.masses[:, None]
            scatter(
                translation, TRANSLATION, row, value + mass * (zero if change is None else change)
            )
        arrays = (argument(translation), argument(turns))
        start_evaluation(n, n, *arrays)
        elements, ranges = self.acting.arguments
        for place, (_, element) in enumerate(self.acting.chain()):
            start, count = (int(x) for x in ranges[2 * place : 2 * place + 2])
            element.accumulate(elements, start, count, 0.0, *arrays)
        return np.hstack(
            (gather(translation, TRANSLATION, FX, 3, n), gather(turns, ROTATION, TX, 3, n))
        )


@pytest.mark.usefixtures('plain_source')
def test_derivatives_of_wrenches_on_pivoted_bodies_are_their_differences():
    simulation = linked()
    wrenches = Wrenches(simulation)
    stepper, acting, n = inside.stepper(simulation), inside.elements(simulation), wrenches.n
    plan = coupling.plan(simulation.scene, inside.layout(simulation), 0.01)
    table = plan[int(plan[coupling.TABLE_AT]) : int(plan[coupling.MATRIX_AT])].copy()
    wrenches.of()  # tells the pivots what force they carry
    arrays = [argument(x.copy()) for x in (stepper.translation, stepper.rotation)]
    elements, ranges = acting.arguments
    for place, (_, element) in enumerate(acting.chain()):
        start, count = (int(x) for x in ranges[2 * place : 2 * place + 2])
        element.linearise(elements, start, count, 0.0, *arrays, argument(table), 0)
    starts = table[2 : 3 + n].astype(int)
    blocks = table[3 + n + int(table[1]) :].reshape(-1, BLOCK)
    found = np.zeros((2, n, 6, n, 6))
    for i in range(n):
        for number in range(starts[i], starts[i + 1]):
            j = int(table[3 + n + number])
            found[0, i, :, j] = blocks[number, :DAMPING_MATRIX].reshape(6, 6)
            found[1, i, :, j] = blocks[number, DAMPING_MATRIX:].reshape(6, 6)
    for kind, (first, second) in enumerate((('moved', 'turned'), ('pushed', 'spun'))):
        for j in range(n):
            for axis in range(6):
                change = np.zeros((n, 3))
                change[j, axis % 3] = STEP
                name = first if axis < 3 else second
                up, down = wrenches.of(**{name: change}), wrenches.of(**{name: -change})
                expected = (up - down) / (2.0 * STEP)
                # rounding of the differences, 1e-15 * 30 / 1e-6, and their own error
                assert found[kind, :, :, j, axis] == pytest.approx(expected, abs=1e-7)
    assert np.abs(found[:, :2, 3:, :2, 3:]).max() > 1.0
    assert not found[:, :2, :3].any()
    assert not found[:, :, :, :2, :3].any()


@pytest.mark.usefixtures('plain_source')
def test_the_definite_part_of_the_derivatives_is_symmetric_and_negative():
    simulation = linked()
    stepper, acting, n = inside.stepper(simulation), inside.elements(simulation), 3
    plan = coupling.plan(simulation.scene, inside.layout(simulation), 0.01)
    table = plan[int(plan[coupling.TABLE_AT]) : int(plan[coupling.MATRIX_AT])].copy()
    arrays = [argument(x.copy()) for x in (stepper.translation, stepper.rotation)]
    elements, ranges = acting.arguments
    for place, (_, element) in enumerate(acting.chain()):
        start, count = (int(x) for x in ranges[2 * place : 2 * place + 2])
        element.linearise(elements, start, count, 0.0, *arrays, argument(table), 1)
    starts = table[2 : 3 + n].astype(int)
    blocks = table[3 + n + int(table[1]) :].reshape(-1, BLOCK)
    whole = np.zeros((2, n, 6, n, 6))
    for i in range(n):
        for number in range(starts[i], starts[i + 1]):
            whole[:, i, :, int(table[3 + n + number])] = blocks[number].reshape(2, 6, 6)
    for matrix in whole.reshape(2, 6 * n, 6 * n):
        assert np.allclose(matrix, matrix.T, atol=1e-13)
        assert np.linalg.eigvalsh(matrix).max() < 1e-12


def test_an_element_without_derivatives_beside_a_pivot_is_refused_where_they_are_all_there_is():
    scene = {
        'dt': 0.01,
        'bodies': [
            {
                'name': 'bar',
                'shape': {'type': 'sphere', 'radius': 0.1},
                'mass': 1,
                'pivot': {'point': [0, 0, 1]},
            }
        ],
        'forces': [{'type': 'time', 'body': 'bar', 'table': [[0, 0, 0, 0], [1, 1, 0, 0]]}],
    }
    assert not hasattr(FORCES['time'], 'linearise')
    reason = INTEGRATORS['linearly_implicit'].refuses(load_scene(scene))
    assert reason is not None and 'turns about a pivot' in reason
