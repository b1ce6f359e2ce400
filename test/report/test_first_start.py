# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""How long the first step is waited for: measured in processes of its own, said losses first."""

import sys
from dataclasses import asdict

import pytest

from rigid_body_sim.__main__ import main
from rigid_body_sim.errors import RunError
from rigid_body_sim.report import first_start, markdown, page, results
from rigid_body_sim.report.entry import ENGINE
from rigid_body_sim.report.first_start import Start

from .test_page import ABSENT, MADE


def started(engine, way, cost):
    return asdict(Start(engine, '1', 'Stack', way, cost, 0.9 * cost, 1.1 * cost, cost, 3))


def test_processor_time_of_a_start_is_that_of_the_process_and_of_its_children():
    burn = 'import time\nend = time.process_time() + 0.2\nwhile time.process_time() < end: pass'
    child = f'import subprocess, sys; subprocess.run([sys.executable, "-c", {burn!r}])'
    cost, wall = first_start._run([sys.executable, '-c', child], {})
    assert 0.2 < cost and 0.2 < wall


def test_a_start_that_fails_is_no_figure():
    with pytest.raises(RunError, match='nothing to import'):
        first_start._run([sys.executable, '-c', 'raise SystemExit("nothing to import")'], {})


def test_the_report_says_first_where_others_start_sooner():
    rows = [
        started(ENGINE, first_start.SOURCE, 20.0),
        started(ENGINE, first_start.LATER, 0.3),
        started('MuJoCo', 'every start', 0.4),
    ]
    report = results.report(MADE, [], ABSENT, rows)
    text = markdown.markdown(report)
    assert text.index('20 s of processor time, MuJoCo 400 ms') < text.index('## First start')
    assert 'ours every later start takes' not in text
    assert '| Stack | MuJoCo 1 | every start | 400 ms | 360 ms … 440 ms | 400 ms |' in text
    assert 'id="first_start"' in page.page(report)


def test_starts_go_with_problems_not_with_a_scene(tmp_path, capsys):
    assert main(['report', '-o', str(tmp_path), '--scene', 'two_bodies', '--starts']) == 2
    assert '--scene and --starts' in capsys.readouterr().err


@pytest.mark.long
def test_later_starts_are_sooner_than_those_that_compile():
    rows = first_start.measure([], repetitions=1)
    cost = {(row['scene'], row['way']): row['cost'] for row in rows}
    for scene in {row['scene'] for row in rows}:
        later, bitcode = cost[scene, first_start.LATER], cost[scene, first_start.BITCODE]
        assert later < bitcode < cost[scene, first_start.SOURCE]
        assert cost[scene, first_start.IMAGE] < 0.5 * (later + bitcode)
