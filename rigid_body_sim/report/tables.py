# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The tables of a report, written once for the page and for Markdown.

    summaries : how many times cheaper than the best peer, problem by problem
    ratios    : one problem: who is cheapest at an error, or at a number of bodies
    points    : everything that was measured
    starts    : how long the first step is waited for
"""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from rigid_body_sim.report.entry import ENGINE
from rigid_body_sim.report.problem import THROUGHPUT

Row = Mapping[str, Any]
NOTHING = '–'
WAITED = (
    'What is waited for before the first step: a process that imports its packages, reads the '
    'scene, makes one step and ends. Ours compiles its kernels from source, with an empty cache, '
    'or makes them from bitcode that came with the package, or finds them there as images; later '
    'it finds them in the cache.'
)


@dataclass(frozen=True)
class Cell:
    """
    One field of a table.

    value : what it is sorted by; None: by its text
    kind  : class on the page: 'good', 'bad', or none
    """

    text: str
    value: float | None = None
    is_number: bool = True
    kind: str = ''


@dataclass(frozen=True)
class Table:
    """
    Heads with their fields; `kinds` are the classes of the rows on the page.
    """

    heads: tuple[str, ...]
    rows: list[list[Cell]] = field(default_factory=list)
    kinds: list[str] = field(default_factory=list)

    def add(self, cells: Sequence[Cell], kind: str = '') -> None:
        """Append a row."""
        self.rows.append(list(cells))
        self.kinds.append(kind)


def as_html(table: Table, *, sortable: bool = False) -> str:
    """Write a table as HTML."""
    numeric = [
        any(row[place].is_number for row in table.rows) for place in range(len(table.heads))
    ]
    heads = ''.join(
        f'<th scope="col"{"" if number else " class=text"}>'
        + (
            f'<button type="button">{html.escape(head)}</button>'
            if sortable
            else html.escape(head)
        )
        + '</th>'
        for head, number in zip(table.heads, numeric, strict=True)
    )
    rows = ''.join(
        f'<tr class="{kind}">{"".join(map(_html, row))}</tr>\n'
        for row, kind in zip(table.rows, table.kinds, strict=True)
    )
    name = ' class="sortable"' if sortable else ''
    return (
        f'<div class="scroll"><table{name}><thead><tr>{heads}</tr></thead>'
        f'<tbody>\n{rows}</tbody></table></div>'
    )


def _html(cell: Cell) -> str:
    names = ' '.join(filter(None, ['' if cell.is_number else 'text', cell.kind]))
    kind = f' class="{names}"' if names else ''
    value = f' data-v="{"" if cell.value is None else repr(cell.value)}"' if cell.is_number else ''
    return f'<td{kind}{value}>{html.escape(cell.text)}</td>'


def as_markdown(table: Table) -> str:
    """Write a table as Markdown."""
    rule = [
        '---:' if any(row[i].is_number for row in table.rows) else '---'
        for i in range(len(table.heads))
    ]
    lines = [list(table.heads), rule]
    lines += [[cell.text.replace('|', '/') for cell in row] for row in table.rows]
    return '\n'.join(f'| {" | ".join(line)} |' for line in lines)


def words(text: str, kind: str = '') -> Cell:
    """Make a field of text."""
    return Cell(text, is_number=False, kind=kind)


def seconds(value: float | None) -> Cell:
    """Make a field of a time."""
    return Cell(time_text(value), value)


def time_text(value: float | None) -> str:
    """Write a time [s] with a unit that suits it."""
    if value is None:
        return NOTHING
    for scale, unit in ((1.0, 's'), (1e-3, 'ms'), (1e-6, 'µs')):
        if value >= scale:
            return f'{value / scale:.3g} {unit}'
    return f'{value / 1e-9:.3g} ns'


def number(value: float | None, style: str = '.1e') -> Cell:
    """Make a field of a number."""
    if value is not None and style.endswith('g') and value >= 1000.0:
        style = '.0f'  # 1350 rather than 1.35e+03
    return Cell(NOTHING if value is None else format(value, style), value)


def ratio(value: float | None) -> Cell:
    """Make a field of a ratio of costs: above one, ours is cheaper."""
    if value is None:
        return Cell(NOTHING)
    text = f'{value:.2f}' if value < 10.0 else f'{value:,.0f}'.replace(',', ' ')
    return Cell(text, value, kind='bad' if value < 1.0 else 'good')


def summaries(report: Row) -> list[Table]:
    """
    Ratios of all problems at their errors, a table for problems with the same; none without peers.
    """
    groups: dict[tuple[float, ...], list[Row]] = {}
    for problem in report['problems']:
        rows = problem.get('at_equal_error') or []
        if any(row['peer'] for row in rows):
            groups.setdefault(tuple(row['error'] for row in rows), []).append(problem)
    return [_summary(errors, problems) for errors, problems in groups.items()]


def _summary(errors: Sequence[float], problems: Sequence[Row]) -> Table:
    table = Table(('problem', *(f'at {error:.0e}' for error in errors), 'best peer'))
    for problem in problems:
        rows = problem['at_equal_error']
        peers = dict.fromkeys(_named(row['peer']) for row in rows if row['peer'])
        cells = [_summary_cell(row) for row in rows]
        table.add([words(problem['title']), *cells, words(', '.join(peers))])
    return table


def _summary_cell(row: Row) -> Cell:
    """General methods, and behind a slash the closed form; a word where only one side is there."""
    if row['ratio'] is None and row['peer'] is None:
        return Cell('no peer', None)
    cell = Cell('not reached', None, kind='bad') if row['ratio'] is None else ratio(row['ratio'])
    if row['ratio_closed_form'] is None:
        return cell
    return Cell(
        f'{cell.text} / {ratio(row["ratio_closed_form"]).text}', cell.value, kind=cell.kind
    )


def ratios(problem: Row) -> Table | None:
    """Who is cheapest at which error, or fastest with how many bodies; None where not known."""
    if problem['kind'] == THROUGHPUT:
        return _by_bodies(problem)
    rows = problem['at_equal_error']
    if not any(row['ours'] or row['peer'] for row in rows):
        return None
    closed = any(row['closed_form'] for row in rows)
    heads = ('error', 'ours', 'cost', 'best peer', 'cost', 'ratio', 'interpolated')
    table = Table((*heads, 'closed form', 'cost', 'ratio') if closed else heads)
    for row in rows:
        cells = [number(row['error'], '.0e')]
        for side in ('ours', 'peer'):
            cells += [words(_setting(row[side])), seconds(row[side] and row[side]['cost'])]
        cells += [ratio(row['ratio']), ratio(row['ratio_interpolated'])]
        if closed:
            form = row['closed_form']
            cells += [words(_setting(form)), seconds(form and form['cost'])]
            cells.append(ratio(row['ratio_closed_form']))
        table.add(cells)
    return table


def _by_bodies(problem: Row) -> Table | None:
    rows = problem.get('at_equal_bodies') or []
    if not rows:
        return None
    table = Table(
        (
            'bodies',
            'fastest of ours',
            'ns',
            'fastest peer',
            'ns',
            'ratio',
            'ours, no less accurate',
            'ns',
            'ratio',
        )
    )
    for row in rows:
        cells = [number(row['bodies'], 'd')]
        for side, share in (
            ('ours', None),
            ('peer', 'ratio'),
            ('ours_accurate', 'ratio_accurate'),
        ):
            found = row[side]
            cells.append(words(_named(found) if found else NOTHING))
            cells.append(number(found and found['ns_per_body_step'], '.3g'))
            if share:
                cells.append(ratio(row[share]))
        table.add(cells)
    return table


def points(problem: Row) -> Table:
    """Everything that was measured on one problem."""
    many = problem['kind'] == THROUGHPUT
    table = Table(
        (
            'engine',
            'method',
            'setting',
            *(('bodies',) if many else ()),
            f'error [{problem["error_unit"]}]',
            'cost per simulated s',
            'quartiles',
            'ns per step',
            *(('ns per body and step',) if many else ()),
            'forces per step',
            'energy drift',
            'L drift',
            'status',
        )
    )
    for point in problem['points']:
        low, high = point['cost_low'], point['cost_high']
        spread = NOTHING if low is None else f'{time_text(low)} … {time_text(high)}'
        precision = '' if point['precision'] == 'f64' else f' ({point["precision"]})'
        marks = [mark for mark, holds in (('front', point['on_front']),) if holds]
        marks += ['ours'] if point['engine'] == ENGINE else []
        said = point['status'] + (f': {point["note"]}' if point['note'] else '')
        said += ', closed form' if point['closed_form'] else ''
        said += ', on the front' if point['on_front'] else ''
        table.add(
            [
                words(f'{point["engine"]} {point["version"]}{precision}'),
                words(point['method']),
                Cell(point['setting'], point['dt'] or point['tolerance']),
                *((number(point['bodies'], 'd'),) if many else ()),
                number(point['error']),
                seconds(point['cost']),
                words(spread),
                number(point['ns_per_step'], '.4g'),
                *((number(point['ns_per_body_step'], '.3g'),) if many else ()),
                number(point['evaluations_per_step'], 'g'),
                number(point['energy_drift']),
                number(point['angular_momentum_drift']),
                words(said, 'note'),
            ],
            ' '.join(marks),
        )
    return table


def starts(report: Row) -> Table | None:
    """How long starts took; None where none was measured."""
    if not report.get('starts'):
        return None
    table = Table(('scene', 'engine', 'start', 'processor time', 'least and most', 'on the clock'))
    for row in report['starts']:
        table.add(
            [
                words(row['scene']),
                words(f'{row["engine"]} {row["version"]}'),
                words(row['way']),
                seconds(row['cost']),
                words(f'{time_text(row["cost_low"])} … {time_text(row["cost_high"])}'),
                seconds(row['wall']),
            ],
            'ours' if row['engine'] == ENGINE else '',
        )
    return table


def _named(point: Row | None) -> str:
    if point is None:
        return NOTHING
    precision = '' if point.get('precision', 'f64') == 'f64' else f' ({point["precision"]})'
    return (
        point['method']
        if point['engine'] == ENGINE
        else f'{point["engine"]} {point["method"]}{precision}'
    )


def _setting(point: Row | None) -> str:
    return NOTHING if point is None else f'{_named(point)}, {point["setting"]}'
