# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""`list` tells all that there is, with the words of scenes, modules and records themselves."""

import json

import pytest

from rigid_body_sim.__main__ import main
from rigid_body_sim.physics.forces.elements import FORCES
from rigid_body_sim.physics.integration.integrators import INTEGRATORS
from rigid_body_sim.report.problems import PROBLEMS
from rigid_body_sim.scene.shapes import KINDS
from rigid_body_sim.scene.shipped_scenes import shipped_scenes

WHOLE = {
    'scenes': shipped_scenes(),
    'integrators': [*INTEGRATORS, 'auto'],
    'forces': FORCES,
    'shapes': KINDS,
    'problems': PROBLEMS,
}


@pytest.mark.parametrize('kind', WHOLE)
def test_each_has_a_line_with_its_purpose(kind, capsys):
    assert main(['list', kind]) == 0
    lines = capsys.readouterr().out.splitlines()
    found = {line.split()[0]: line.split(maxsplit=1)[1] for line in lines}
    assert set(found) == set(WHOLE[kind])
    assert all(len(purpose) > 12 and '\n' not in purpose for purpose in found.values())
    assert main(['list', kind, '--json']) == 0
    assert set(json.loads(capsys.readouterr().out)[kind]) == set(found)


def test_a_purpose_is_said_once(capsys):
    main(['list', 'scenes'])
    out = capsys.readouterr().out
    line = shipped_scenes()['stack'].read_text().splitlines()[0].lstrip('# ').rstrip('.')
    assert line in out


def test_a_kind_that_is_none_is_refused_with_a_proposal(capsys):
    assert main(['list', 'intergators']) == 2
    assert "did you mean 'integrators'?" in capsys.readouterr().err
