# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
One HTML page of a report that needs nothing else: no network, no server, no other file.

Plots are drawn by a script of the page from data in the page; without scripts the sentences and
tables are there all the same. A content security policy forbids every request.
"""

from __future__ import annotations

import html
import json
from collections.abc import Iterator, Mapping, Sequence
from importlib import resources
from pathlib import Path
from string import Template
from typing import Any

from rigid_body_sim.report import peers, results
from rigid_body_sim.report.losses import LIMITS, losses, missed_goals
from rigid_body_sim.report.problem import THROUGHPUT
from rigid_body_sim.report.series import Series, axes_of, front_of, series_of
from rigid_body_sim.report.subject import answer, subject
from rigid_body_sim.report.tables import (
    WAITED,
    as_html,
    points,
    ratios,
    starts,
    summaries,
    time_text,
)

FILE = 'report.html'
TITLE = 'Speed against error'
LEAD = (
    'Lower is more accurate, left is cheaper. Costs are processor time on one thread for a '
    'simulated second, the stepping alone, all methods taking turns; medians.'
)
Row = Mapping[str, Any]


def write(report: Row, folder: Path) -> Path:
    """Write the page."""
    return results.write_whole(folder / FILE, page(report))


def page(report: Row) -> str:
    """Make the page."""
    problems = results.in_parts(report['problems'])
    return Template(_asset('page.html')).substitute(
        title=TITLE,
        lead=f'{_escaped(subject(report["made"]))} {LEAD}',
        style=_asset('page.css'),
        script=_asset('page.js'),
        made=_made(report['made']),
        contents=''.join(
            f'<a href="#{_escaped(p["name"])}">{_escaped(p["title"])}</a>' for p in problems
        ),
        summary=_summary(report) + _starts(report),
        problems='\n'.join(_under_headings(problems)),
        absent=_engines(report) + _absent(report['absent']),
        footer=_footer(report),
        data=_script_safe({p['name']: plot(p) for p in problems}),
    )


def _asset(name: str) -> str:
    return (resources.files('rigid_body_sim.report') / 'assets' / name).read_text('utf-8')


def _escaped(text: Any) -> str:
    return html.escape(str(text))


def _script_safe(value: Any) -> str:
    """JSON that cannot end the script element it stands in."""
    return json.dumps(value, ensure_ascii=False, separators=(',', ':')).replace('<', '\\u003c')


def _made(made: Row) -> str:
    versions = ', '.join(f'{name} {version}' for name, version in made['versions'].items())
    rows = {
        'made': made['date'],
        'machine': f'{made["machine"]}, {made["cpu"]}, {made["cores"]} cores, load '
        f'{made.get("load", "unknown")} at the start',
        'versions': versions + ('' if made['compiled'] else ', not compiled'),
        'seed, repetitions': f'{made["seed"]}, {made["repetitions"]}'
        + (' (quick)' if made['quick'] else ''),
        'to make it again': made.get('command')
        or 'make report; with other engines: make report-peers',
    }
    if made.get('interrupted'):
        rows['interrupted'] = 'yes: problems are missing'
    items = ''.join(f'<dt>{_escaped(k)}</dt><dd>{_escaped(v)}</dd>' for k, v in rows.items())
    return f'<dl class="made">{items}</dl>'


def _summary(report: Row) -> str:
    tables = summaries(report)
    lost = _list('Where ours loses', losses(report), 'Nowhere on these problems and errors.')
    if not tables:
        return f'<section id="summary">{lost}</section>' if report.get('starts') else ''
    return (
        '<section id="summary"><h2>How many times cheaper than the best peer</h2>'
        '<p class="soft">Cost of the cheapest peer point over that of our cheapest, both at least '
        'as accurate as the error at the head; behind a slash, by a method that is the closed '
        'form of the problem.</p>'
        + ''.join(map(as_html, tables))
        + lost
        + _list('Where it falls short of the goal', missed_goals(report), 'Nowhere.')
        + '</section>'
    )


def _starts(report: Row) -> str:
    table = starts(report)
    if table is None:
        return ''
    return (
        f'<section id="first_start"><h2>First start</h2><p class="soft">{_escaped(WAITED)}</p>'
        f'{as_html(table)}</section>'
    )


def _list(title: str, lines: Sequence[str], none: str) -> str:
    items = ''.join(f'<li>{_escaped(line)}</li>' for line in lines)
    return f'<h3>{_escaped(title)}</h3>' + (f'<ul>{items}</ul>' if lines else f'<p>{none}</p>')


def _under_headings(problems: Sequence[Row]) -> Iterator[str]:
    """Give the sections, a heading before the first of each part."""
    last = ''
    for problem in problems:
        heading = problem.get('heading', '')
        if heading != last:
            yield f'<h1>{_escaped(heading)}</h1>'
        last = heading
        yield _problem(problem)


def _problem(problem: Row) -> str:
    table, every = ratios(problem), points(problem)
    said = [
        f'<section id="{_escaped(problem["name"])}"><h2>{_escaped(problem["title"])}</h2>',
        f'<p>{_escaped(problem["description"])} {_escaped(problem["shows"])}</p>',
        f'<p class="soft">{_escaped(answer(problem))}.</p>',
        f'<p class="verdict">{_escaped(problem["verdict"])}</p>',
    ]
    if problem.get('recommendation'):
        said.append(f'<p class="verdict"><b>{_escaped(problem["recommendation"])}</b></p>')
    if series_of(problem):
        said.append(
            f'<figure class="plot" data-problem="{_escaped(problem["name"])}">'
            f'<svg role="img" aria-label="{_escaped(_caption(problem))}"></svg>'
            '<div class="tip" hidden></div><ul class="legend"></ul></figure>'
        )
    if table is not None:
        said += [
            '<h3>At equal error</h3>'
            if problem['kind'] != THROUGHPUT
            else '<h3>At equal numbers</h3>',
            as_html(table),
        ]
    said.append(
        f'<details><summary>All {len(every.rows)} points</summary>'
        f'{as_html(every, sortable=True)}</details></section>'
    )
    return '\n'.join(said)


def _caption(problem: Row) -> str:
    axes = axes_of(problem)
    return f'{problem["title"]}: {axes.y} against {axes.x}'


def plot(problem: Row) -> dict[str, Any]:
    """Give what the script draws: axes, curves, front."""
    axes = axes_of(problem)
    return {
        'x': axes.x,
        'y': axes.y,
        'front': front_of(problem),
        'series': [_series(curve, problem) for curve in series_of(problem)],
    }


def _series(curve: Series, problem: Row) -> dict[str, Any]:
    return {
        'label': curve.label,
        'ours': curve.ours,
        'out': curve.stands_out,
        'color': curve.color,
        'mark': curve.mark,
        'points': [
            {'x': x, 'y': y, 'lines': _lines(point, problem)}
            for x, y, point in zip(curve.x, curve.y, curve.points, strict=True)
        ],
    }


def _lines(point: Row, problem: Row) -> list[str]:
    """What a point says when it is pointed at."""
    lines = [point['setting']]
    if problem['kind'] == THROUGHPUT:
        lines.append(f'{point["bodies"]} bodies: {point["ns_per_body_step"]:.3g} ns each')
    lines.append(f'error {point["error"]:.2e} {problem["error_unit"]}')
    lines.append(f'cost {time_text(point["cost"])} per simulated second')
    if point['ns_per_step']:
        lines.append(f'{point["ns_per_step"]:.4g} ns per step')
    if point['energy_drift'] is not None:
        lines.append(f'energy drift {point["energy_drift"]:.1e}')
    if point['on_front']:
        lines.append('on the front')
    return lines


def _engines(report: Row) -> str:
    run = peers.how_run(point for problem in report['problems'] for point in problem['points'])
    if not run:
        return ''
    items = ''.join(
        f'<li><b>{_escaped(engine)}</b> {_escaped(version)}: {_escaped(how)}</li>'
        for engine, version, how in run
    )
    limits = ''.join(f'<li>{_escaped(limit)}</li>' for limit in LIMITS)
    return (
        f'<section id="engines"><h2>How the other engines were run</h2><ul>{items}</ul>'
        f'<h2>What this does not say</h2><ul>{limits}</ul></section>'
    )


def _absent(absent: Sequence[Row]) -> str:
    if not absent:
        return ''
    items = ''.join(
        f'<li><b>{_escaped(each["engine"])}</b>: {_escaped(each["reason"])}</li>'
        for each in absent
    )
    return f'<section id="absent"><h2>Engines that were not there</h2><ul>{items}</ul></section>'


def _footer(report: Row) -> str:
    seed = _escaped(report['made']['seed'])
    return (
        'rigid_body_sim; numbers in report.json and report.csv beside this page. Front (yellow): '
        f'no other point is as accurate for less, closed forms apart. Seed {seed}.'
    )
