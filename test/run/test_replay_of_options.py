# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Options of the integrator are part of the recording: with them a replay is identical, with others
it tells the error.
"""

import json

import pytest

from rigid_body_sim.recording.bag_reader import Bag

from .conftest import SCENES

ADAPTIVE = 'integrator: {name: rk45, rtol: 1e-6, atol: 1e-9}'
DRIFTING = 'integrator: rk4\norientation: {representation: matrix, reorthonormalise: false}'
KEPT = 'integrator: {name: rk4, orientation: matrix, reorthonormalise: true}'


@pytest.fixture(
    params=[ADAPTIVE, DRIFTING, pytest.param(KEPT, marks=pytest.mark.long)],
    ids=['adaptive', 'drifting', 'kept'],
)
def recorded(request, tmp_path, verb, commands):
    """A bag of two_bodies with commands, run with options."""
    if request.param != ADAPTIVE:  # no other test wants kernels of matrices under forces
        request.getfixturevalue('plain_source')
    lines = (SCENES / 'two_bodies.yaml').read_text().splitlines()
    text = '\n'.join(line for line in lines if not line.startswith('integrator:'))
    scene = tmp_path / 'scene.yaml'
    scene.write_text(f'{text}\n{request.param}\n')
    words = ('--duration', 0.16, '--dt', 0.001, '--commands', commands)
    code, _, err = verb('simulate', scene, '-o', tmp_path / 'run', *words)
    assert code == 0, err
    return tmp_path / 'run'


def test_replay_with_options_is_identical(recorded, as_json):
    settings = json.loads(Bag(recorded).manifest['integrator_options'])
    assert settings.get('rtol') == 1e-6 or settings.get('orientation') == 'matrix'
    code, result = as_json('replay', recorded)
    assert (code, result['identical'], result['ticks']) == (0, True, 160)


def test_another_integrator_starts_from_the_same_state_with_its_own_defaults(recorded, as_json):
    code, result = as_json('replay', recorded, '--integrator', 'rk8')
    assert code == 0
    errors = result['errors'].values()
    assert errors and all(error['largest']['angle'] < 1e-3 for error in errors)
