# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""The energy balance of a run: on the terminal, as JSON, in the bag, and again in a replay."""

import json

import pytest

from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.view.energy_history import balance_history

from .conftest import COMMANDS, SCENES

SCENE = SCENES / 'two_bodies.yaml'


@pytest.fixture
def words(tmp_path):
    (tmp_path / 'commands.csv').write_text(COMMANDS)
    return ('simulate', SCENE, '--duration', 0.5, '--commands', tmp_path / 'commands.csv')


def test_a_run_reports_its_balance_and_a_replay_finds_the_same_bits(as_json, words, tmp_path):
    code, result = as_json(*words, '-o', tmp_path / 'a')
    balance = result['energy_balance']
    assert code == 0 and balance['dissipation'] > 0.0 and balance['work_of_commands'] != 0.0
    works = balance['work_of_commands'] + balance['work_of_drives'] - balance['dissipation']
    assert balance['change'] == pytest.approx(works + balance['defect'], rel=1e-12)
    # dmv6 errs with h^2; a force in body axes, drag and a spring at 1 kHz leave this
    assert abs(balance['defect']) < 1e-4 and balance['uncertainty'] < 1e-9
    assert {(*law['bodies'], law['quantity']) for law in result['kept']} == {
        ('box', 'momentum'), ('box', 'angular momentum')
    }  # fmt: skip
    ending = Bag(tmp_path / 'a').ending
    assert json.loads(ending['energy_balance']) == balance
    code, _ = as_json('replay', tmp_path / 'a', '-o', tmp_path / 'b')
    again = Bag(tmp_path / 'b').ending
    assert code == 0
    for key in ('energy_balance', 'energy_history'):
        assert again[key] == ending[key]


def test_a_balance_that_has_no_numbers_any_more_is_said_once(verb, tmp_path):
    (tmp_path / 'commands.csv').write_text(
        'time,body,kind,fx\n0.05,box,wrench,9e153\n0.05,box,force,9e153\n'
    )
    commands = ('--duration', 0.5, '--commands', tmp_path / 'commands.csv')
    code, _, said = verb('simulate', SCENE, *commands, '-o', tmp_path / 'a')
    assert code == 0
    assert said.count('the energy balance has no numbers any more by 0.1 s') == 1
    ending = Bag(tmp_path / 'a').ending
    (warning,) = [text for text in json.loads(ending['warnings']) if 'balance' in text]
    assert 'work of commands' in warning and '~/reset' in warning
    assert 'work of drives' not in warning


def test_pictures_draw_the_balance_that_the_bag_holds(verb, words, tmp_path):
    assert verb(*words, '-o', tmp_path / 'a')[0] == 0
    ending = Bag(tmp_path / 'a').ending
    history = balance_history(ending)
    assert len(history.time) == 51 and history.time[-1] == 0.5
    assert history.dissipation[-1] > 0.0 and (history.drives == 0.0).all()
    for broken in ('{}', '[]', 'no', '{"time": [0, "x"]}'):
        assert balance_history(ending | {'energy_history': broken}) is None
