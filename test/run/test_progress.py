# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is shown while one waits: on a terminal what goes on, and how long; elsewhere nothing."""

from __future__ import annotations

import os
import pty
import struct
import subprocess
import sys
import termios
import time
from fcntl import ioctl
from pathlib import Path

import pytest

from rigid_body_sim.physics.compile import kernels
from rigid_body_sim.physics.compile.images import Images
from rigid_body_sim.physics.compile.wanted import Wanted
from rigid_body_sim.runs import compile_note
from rigid_body_sim.runs.compile_note import CompileNote, expected_functions, time_left
from rigid_body_sim.scene import load_scene
from rigid_body_sim.verbs.report import rest_words

from ..patience import HANGING

ROOT = Path(__file__).parents[2]
BODY = 'dt: 0.01\nbodies:\n- {name: a, shape: {type: particle}, mass: 1}\n'


def on_terminal(*words: str, folder: Path, **environment: str) -> tuple[str, str, int]:
    """
    Run a verb whose standard error is a terminal of 120 columns.
    """
    ours, theirs = pty.openpty()
    ioctl(theirs, termios.TIOCSWINSZ, struct.pack('HHHH', 40, 120, 0, 0))
    child = subprocess.Popen(
        [sys.executable, '-m', 'rigid_body_sim', *words],
        cwd=folder,
        env={k: v for k, v in os.environ.items() if k != 'RIGID_BODY_SIM_COMPILE'}
        | {'PYTHONPATH': str(ROOT)}
        | environment,
        stdout=subprocess.PIPE,
        stderr=theirs,
        text=True,
    )
    os.close(theirs)
    shown = b''
    try:
        while data := os.read(ours, 65536):
            shown += data
    except OSError:  # the other end is closed
        pass
    os.close(ours)
    out, _ = child.communicate(timeout=HANGING)
    return out, shown.decode(errors='replace'), child.returncode


def test_a_first_run_tells_what_is_compiled_and_the_next_ones_show_the_ticks(
    tmp_path: Path,
) -> None:
    (tmp_path / 'a.yaml').write_text(BODY)
    cache = {'RIGID_BODY_SIM_CACHE': str(tmp_path / 'cold')}
    out, shown, code = on_terminal('simulate', 'a.yaml', '-o', 'a', folder=tmp_path, **cache)
    assert code == 0 and out.startswith('a: 10 s of 1 body with dmv6, 1000 ticks in ')
    assert 'dmv6 for free bodies' in shown
    out, shown, code = on_terminal('replay', 'a', folder=tmp_path, **cache)
    assert code == 0 and out.startswith('identical')
    assert 'tick/s' in shown and 'compiling' not in shown


@pytest.mark.parametrize('words', [('--duration', '2'), ('--duration', '2', '--json')])
def test_json_and_progress_never_come_together(
    words: tuple[str, ...], verb, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / 'a.yaml').write_text(BODY)
    monkeypatch.setattr(type(sys.stderr), 'isatty', lambda _stream: True)
    code, out, err = verb('simulate', tmp_path / 'a.yaml', '-o', tmp_path / 'a', *words)
    assert code == 0
    assert ('tick' in err) == ('--json' not in words) == (not out.startswith('{'))
    assert '--json' not in words or err == ''


def test_a_free_body_needs_the_fewest_functions_and_contact_the_most() -> None:
    free, pulled, touching = (
        expected_functions(load_scene(text.encode()))
        for text in (BODY, f'gravity: [0, 0, -9]\n{BODY}', f'contact: {{mode: timestep}}\n{BODY}')
    )
    assert 0 < free < pulled < touching


def test_the_time_left_shrinks_as_functions_are_done_at_an_even_pace() -> None:
    """At the shares of time that SHARE tells the guess is the truth, to rounding."""
    assert time_left(3, 100, 5.0) is None  # too few to tell
    for done, of_time in ((25, 0.15), (50, 0.28), (75, 0.44), (90, 0.52)):
        assert time_left(done, 100, 20.0 * of_time) == pytest.approx(20.0 * (1.0 - of_time))
    assert time_left(99, 100, 20.0) == time_left(130, 100, 20.0) == 0.0


def test_while_llvm_is_at_work_the_last_guess_runs_down(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = [0.0]
    monkeypatch.setattr(compile_note.time, 'monotonic', lambda: clock[-1])
    note = CompileNote(100, shown=False)
    for now, done, said in (
        (11.0, 75, 'some 14 s left'),
        (12.0, 100, 'some 13 s left'),
        (24.0, 100, 'some 1 s left'),
        (26.0, 100, 'soon done'),
    ):
        clock.append(now)
        note._done = done
        assert said in note.text()


def test_a_report_says_how_long_the_other_problems_take_once_it_knows() -> None:
    assert rest_words(0, 14, 0.1) == ''
    assert rest_words(2, 14, 30.0) == ', some 180 s left'


def test_what_numba_compiles_meanwhile_is_counted(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    numba = pytest.importorskip('numba')
    monkeypatch.setattr(compile_note, 'EVERY', 0.01)
    monkeypatch.setattr(sys.stderr, 'isatty', lambda: True, raising=False)
    with CompileNote(2, shown=True) as note:
        note.compiling('squares')
        seen, end = '', time.monotonic() + HANGING
        while 'squares' not in seen and time.monotonic() < end:  # it looks for numba, then shows
            time.sleep(0.005)
            seen += capsys.readouterr().err
        assert 'squares' in seen
        numba.njit(lambda x: x * x)(2.0)
        assert 'compiling, once per machine' in note.text() and '(1 of some 2' in note.text()
        if kernels.IMAGES is not None:  # what kernels call is compiled in a way of our own
            half = kernels.inline(lambda x: 0.5 * x)
            Images(None, None).bitcode(Wanted(lambda x: half(x) + 1.0, ('float64',), (3.0,)))
            assert '(2 of some 2' in note.text()
    done = note.text().partition('(')[2]
    numba.njit(lambda x: x + x)(2.0)
    assert note.text().partition('(')[2] == done  # nobody counts any more


def test_where_nobody_looks_on_bars_are_not_even_imported(tmp_path: Path) -> None:
    (tmp_path / 'scene.yaml').write_text(BODY)
    done = subprocess.run(
        [sys.executable, '-c',
         'import sys; from rigid_body_sim.__main__ import main; code = main(sys.argv[1:]); '
         "print(code, {'tqdm', 'numpy.ma'} & set(sys.modules))",
         'simulate', 'scene.yaml', '-o', 'bag', '--duration', '0.1'],
        cwd=tmp_path, capture_output=True, text=True, timeout=HANGING, check=True,
        # numba imports what it likes
        env=os.environ | {'PYTHONPATH': str(ROOT), 'RIGID_BODY_SIM_COMPILE': '0'},
    )  # fmt: skip
    assert done.stdout.splitlines()[-1] == '0 set()'
