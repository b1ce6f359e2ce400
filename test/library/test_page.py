# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""What docs/python.md shows is run, word for word."""

import re
import shlex
from pathlib import Path

import pytest

from rigid_body_sim.__main__ import main

TEXT = (Path(__file__).parents[2] / 'docs' / 'python.md').read_text()
BLOCKS = re.findall(r'^```(\w*)\n(.*?)^```$', TEXT, flags=re.DOTALL | re.MULTILINE)
PROGRAMS = [text for kind, text in BLOCKS if kind == 'python']


@pytest.mark.parametrize('number', range(len(PROGRAMS)))
def test_each_program_of_the_page_runs(number, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    exec(compile(PROGRAMS[number], f'program {number}', 'exec'), {})


def test_its_commands_work_on_the_bag_that_it_makes(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (program,) = (text for text in PROGRAMS if "run.save('bag')" in text)
    exec(compile(program, 'bag', 'exec'), {})
    (commands,) = (text for kind, text in BLOCKS if kind == '' and 'export' in text)
    for line in commands.splitlines():
        words = shlex.split(line, comments=True)
        assert words[:3] == ['python', '-m', 'rigid_body_sim'] and main(words[3:]) == 0
