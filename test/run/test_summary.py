# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""What `simulate` says of a run: nothing that contradicts itself, and no digits of rounding."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rigid_body_sim.physics.diagnostics.energy_balance import EnergyBalance
from rigid_body_sim.runs.kept_lines import balance_line, contact_lines, drift_text, pace_text

SCENES = {
    'tumbling_box': (
        'energy balance: nothing brought energy or took it, and it stayed',
        'angular momentum: no drift, to the last bit',
    ),
    'two_bodies': (
        'J = - dissipation ',
        ' defect of the method ',
        'angular momentum of box: no drift, to the last bit',
    ),
    'bouncing_ball': (
        'J = - contact ',
        'energy rise: none beyond rounding',
        'deepest overlap: ',
        'momentum, angular momentum: they change, as forces from outside act on every body',
    ),
}


def balance(**given: float) -> EnergyBalance:
    """
    A balance of 1 J that moved, known to 1e-15 J, with some of its numbers replaced.
    """
    numbers = {
        'change': 0.0, 'work_of_commands': 0.0, 'work_of_drives': 0.0, 'dissipation': 0.0,
        'contact': 0.0, 'defect': 0.0, 'turnover': 1.0, 'uncertainty': 1e-15, 'tolerated': 0.0,
    }  # fmt: skip
    numbers |= given
    relative = abs(numbers['defect']) / numbers['turnover'] if numbers['turnover'] else 0.0
    return EnergyBalance(**numbers, relative=relative, gain=None)


@pytest.mark.parametrize('scene', SCENES)
def test_the_summary_of_a_scene_says_each_thing_once(scene: str, verb, tmp_path: Path) -> None:
    code, out, _ = verb('simulate', scene, '-o', tmp_path / 'run', '--duration', '1')
    assert code == 0
    for said in SCENES[scene]:
        assert out.count(said) == 1, out
    quantities = re.findall(r'^  ([\w ,]+?)(?: of \w+)?: ', out, flags=re.MULTILINE)
    assert len(quantities) == len(set(quantities)), out
    assert ' 1 bodies' not in out and 'no conservation law' not in out


def test_a_balance_that_closes_has_no_defect_and_any_other_names_it_with_its_sign() -> None:
    assert 'defect' not in balance_line(balance(defect=1e-16))
    assert 'defect' not in balance_line(balance(dissipation=0.5, change=-0.5, defect=-1e-16))
    line = balance_line(balance(work_of_commands=2.0, contact=0.5, change=1.4, defect=-0.1))
    assert line.startswith(
        'energy balance: change 1.4 J = commands 2 J - contact 0.5 J - defect of the method 0.1 J'
    )
    assert balance_line(balance(turnover=0.0)) == 'energy balance: nothing moved'


def test_a_run_slower_than_the_clock_has_no_pace_of_zero() -> None:
    assert pace_text(1.0, 140.0) == '0.0071 times real time'
    assert pace_text(100.0, 0.5) == '200 times real time'


def test_zero_is_told_as_zero_and_overlap_as_overlap() -> None:
    assert drift_text(0.0) == 'no drift, to the last bit'
    assert drift_text(2e-5) == 'drift 2.0e-05 of its largest value'
    assert [*contact_lines(0.0, 0.0, None)][-1] == 'deepest overlap: nothing touched'
    assert [*contact_lines(None, None, 1e-3)] == ['deepest overlap: none']
    assert [*contact_lines(1e-4, 0.02, -1e-3)][-1] == 'deepest overlap: 1.0e-03 m'
    assert '2.0e-02 J' in next(contact_lines(1e-4, 0.02, -1e-3))
