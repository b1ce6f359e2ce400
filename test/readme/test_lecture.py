# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Every lesson of examples/lecture measures what it claims, and its page says just that."""

from __future__ import annotations

import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from ..children import result_of
from ..patience import HANGING

ROOT = Path(__file__).parents[2]
TOUCHING = {
    'bouncing',
    'friction',
    'polyhedra',
    'slope',
}  # some hundred times slower as plain source
RUN = """
import json, sys
sys.path.insert(0, 'tools')
import lecture
print(json.dumps({name: lecture.taught(name)[0] for name in sys.argv[1:]}))
"""


def tool():
    spec = importlib.util.spec_from_file_location('lecture', ROOT / 'tools' / 'lecture.py')
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope='module')
def claims():
    """What the lessons print; those that compile nothing in one process, the others in one."""
    result = subprocess.run(
        [sys.executable, '-c', RUN, *sorted({*tool().lessons()} - TOUCHING)],
        cwd=ROOT,
        env=os.environ | {'PYTHONPATH': str(ROOT), 'RIGID_BODY_SIM_COMPILE': '0'},
        capture_output=True,
        text=True,
        timeout=HANGING,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    return json.loads(result.stdout) | result_of(claims_of, sorted(TOUCHING))


def claims_of(names):
    return {name: tool().taught(name)[0] for name in names}


def test_every_lesson_claims_something_and_measures_it(claims):
    """A claim that does not hold ends its script with an error, and so the fixture."""
    assert len(claims) >= 16
    assert {name for name, said in claims.items() if len(said) < 2} == set()


def test_the_pages_say_what_the_lessons_claim(claims):
    lecture = tool()
    for path, text in lecture.pages(claims).items():
        assert path.read_text(encoding='utf-8') == text, 'run `python tools/lecture.py`'
    every = ''.join(path.read_text(encoding='utf-8') for path in lecture.PAGES.glob('*.md'))
    for name in lecture.lessons():
        assert f'<!-- claims: {name} -->' in every and f']({name}.png)' in every
        assert f'{name}.py' in every and (lecture.PAGES / f'{name}.png').stat().st_size > 10_000


def test_a_claim_that_does_not_hold_is_an_error(monkeypatch):
    monkeypatch.syspath_prepend(str(tool().SCRIPTS))
    import lesson

    with pytest.raises(AssertionError, match=r'is more than 1e-09 m'):
        lesson.claim('the ball stands', [0.0, 1e-8], within=1e-9, unit='m')
    with pytest.raises(AssertionError):
        lesson.claim('it is a number', float('nan'), within=1.0)
