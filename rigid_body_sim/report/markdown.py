# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A report as Markdown, losses first: `report.md` beside the pictures, and the document in `docs`.

    python -m rigid_body_sim.report.markdown report_output docs/speed_against_error.md

writes the document anew from a report, with smaller copies of its pictures in a folder of its
name.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rigid_body_sim.report import peers, results
from rigid_body_sim.report.losses import LIMITS, losses, missed_goals
from rigid_body_sim.report.problem import THROUGHPUT
from rigid_body_sim.report.series import series_of
from rigid_body_sim.report.subject import answer, subject
from rigid_body_sim.report.tables import WAITED, as_markdown, ratios, starts, summaries

FILE = 'report.md'
COLORS = 64
Row = Mapping[str, Any]
AGAIN = (
    '`make report`; beside other engines `make report-peers`; and with that the document in '
    '`docs` `make document`'
)


def write(report: Row, folder: Path) -> Path:
    """Write `report.md`."""
    return results.write_whole(folder / FILE, markdown(report))


def document(folder: Path, path: Path) -> None:
    """
    Write a document from the report in a folder, and its pictures in few colours: a third of the
    bytes.
    """
    from PIL import Image

    report = results.read(folder)
    pictures = path.with_suffix('')
    pictures.mkdir(parents=True, exist_ok=True)
    for problem in report['problems']:
        drawn = folder / f'{problem["name"]}.png'
        if drawn.is_file():
            with Image.open(drawn) as image:
                few = image.convert('RGB').quantize(COLORS, dither=Image.Dither.NONE)
                few.save(pictures / drawn.name, optimize=True)
    path.write_text(markdown(report, pictures=f'{pictures.name}/'), encoding='utf-8')


def markdown(report: Row, *, pictures: str = '') -> str:
    """
    Make the text.

    pictures : what stands before the names that `report.pictures` gives
    """
    parts = ['# Speed against error', _made(report['made'])]
    tables, begun = summaries(report), starts(report)
    if tables or begun is not None:
        parts += _list('Where ours loses', losses(report))
    if tables:
        parts += _list('Where it falls short of the goal', missed_goals(report))
        parts += [
            '## How many times cheaper than the best peer',
            'Cost of the cheapest peer point over that of our cheapest, both at least as accurate '
            'as the error at the head; behind a slash, by a method that is the closed form of the '
            'problem.',
            *map(as_markdown, tables),
        ]
    if begun is not None:
        parts += ['## First start', WAITED, as_markdown(begun)]
    last = ''
    for problem in results.in_parts(report['problems']):
        if problem.get('heading', '') != last:
            last = problem['heading']
            parts.append(f'# {last}')
        parts += _problem(problem, pictures)
    points = [point for problem in report['problems'] for point in problem['points']]
    run = [f'**{engine}** {version}: {how}' for engine, version, how in peers.how_run(points)]
    if run:
        parts += _list('How the other engines were run', run)
        parts += _list('What this does not say', LIMITS)
    if report['absent']:
        lines = [f'{each["engine"]}: {each["reason"]}.' for each in report['absent']]
        parts += _list('Engines that were not there', lines)
    return '\n\n'.join(parts) + '\n'


def _made(made: Row) -> str:
    versions = ', '.join(f'{name} {version}' for name, version in made['versions'].items())
    again = f'`{made["command"]}`' if made.get('command') else AGAIN
    return (
        f'{subject(made)} Costs are processor time on one thread for a simulated second, the '
        f'stepping alone, all methods taking turns; medians of {made["repetitions"]}.\n\n'
        f'Made {made["date"]} on {made["machine"]}, {made["cpu"]}, {made["cores"]} cores, load '
        f'{made.get("load", "unknown")} at the start; {versions}; seed {made["seed"]}'
        f'{"; quick" if made["quick"] else ""}.\n\n'
        f'To make it again: {again}.'
    )


def _list(title: str, lines: Sequence[str]) -> list[str]:
    return [f'## {title}', '\n'.join(f'- {line}' for line in lines) or 'Nowhere.']


def _problem(problem: Row, pictures: str) -> list[str]:
    parts = [
        f'## {problem["title"]}',
        f'{problem["description"]} {problem["shows"]} {answer(problem)}.',
        f'**{problem["verdict"]}**',
    ]
    if problem.get('recommendation'):
        parts.append(f'**{problem["recommendation"]}**')
    if series_of(problem):
        parts.append(f'![{problem["title"]}]({pictures}{problem["name"]}.png)')
    table = ratios(problem)
    if table is not None:
        same = 'numbers of bodies' if problem['kind'] == THROUGHPUT else 'errors'
        parts += [f'At equal {same}:', as_markdown(table)]
    return parts


if __name__ == '__main__':
    document(Path(sys.argv[1]), Path(sys.argv[2]))
