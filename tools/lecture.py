# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The pages of docs/lecture, from the scripts in examples/lecture: what each claims, and its picture.

    python tools/lecture.py           runs every script, draws its picture, writes its claims
    python tools/lecture.py --film    the film of the box that turns over anew (Chromium draws it)
    python tools/lecture.py --check   exit code 1 where a page does not say what its scripts claim

A page holds `<!-- claims: NAME -->`; the list below it is what NAME.py printed. How far off each
claim was when it was measured is left out there: it is another number on another machine.
"""

from __future__ import annotations

import io
import re
import runpy
import sys
import tempfile
from collections.abc import Mapping
from contextlib import redirect_stdout
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SCRIPTS = ROOT / 'examples' / 'lecture'
PAGES = ROOT / 'docs' / 'lecture'
SHARED = ('lesson', 'scenes')
MARK = re.compile(r'(<!-- claims: (\w+) -->\n)(?:- .*\n)*')
SIZE, DOTS_PER_INCH = (7.6, 3.6), 90  # [in]


def lessons() -> list[str]:
    """Name the scripts."""
    return sorted(path.stem for path in SCRIPTS.glob('*.py') if path.stem not in SHARED)


def taught(name: str) -> tuple[list[str], Mapping]:
    """Run a script; give the claims that it printed, and what it defines."""
    said = io.StringIO()
    sys.path.insert(0, str(SCRIPTS))
    try:
        with redirect_stdout(said):
            defined = runpy.run_path(str(SCRIPTS / f'{name}.py'))
    finally:
        sys.path.remove(str(SCRIPTS))
    lines = said.getvalue().splitlines()
    return [line.split('  (')[0] for line in lines if ': within ' in line], defined


def pages(claims: Mapping[str, list[str]]) -> dict[Path, str]:
    """Give every page as it should be."""
    return {
        path: MARK.sub(
            lambda found: found[1] + ''.join(f'- {line}\n' for line in claims[found[2]]),
            path.read_text(encoding='utf-8'),
        )
        for path in sorted(PAGES.glob('*.md'))
    }


def picture(name: str, draw) -> None:
    """Draw the picture of a lesson."""
    import matplotlib as mpl

    mpl.use('Agg')
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=SIZE, layout='constrained')
    axes.grid(alpha=0.3)
    draw(axes)
    if axes.get_legend_handles_labels()[1]:
        figure.legend(loc='outside right upper')
    figure.savefig(PAGES / f'{name}.png', dpi=DOTS_PER_INCH)
    pyplot.close(figure)


def film() -> None:
    """Make the film of the box that turns over: two turns, which meet at the ends."""
    from rigid_body_sim.__main__ import main

    with tempfile.TemporaryDirectory() as folder:
        bag, whole = f'{folder}/run', ('--duration', '7.732', '--publish-rate', '50')
        assert main(['simulate', 'tumbling_box', '-o', bag, *whole]) == 0
        size = ('--size', '640x400', '--fps', '12')
        assert main(['view', bag, '-o', str(PAGES / 'tumbling.gif'), *size]) == 0


if __name__ == '__main__':
    sys.path.insert(0, str(ROOT))
    if '--film' in sys.argv:
        film()
        sys.exit()
    claims = {}
    for lesson in lessons():
        claims[lesson], defined = taught(lesson)
        if '--check' not in sys.argv:
            picture(lesson, defined['draw'])
    wanted = pages(claims)
    if '--check' in sys.argv:
        sys.exit(any(text != path.read_text(encoding='utf-8') for path, text in wanted.items()))
    for path, text in wanted.items():
        path.write_text(text, encoding='utf-8')
