# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""The page, the pictures and the text of a report: whole, true to the numbers, without network."""

import dataclasses
import html
import html.parser
import math
import re

import numpy as np
import pytest

from rigid_body_sim.report import labels, markdown, page, pictures, results, series
from rigid_body_sim.report.losses import losses, missed_goals
from rigid_body_sim.report.point import DIVERGED, NOT_ACCURATE, OK, Point
from rigid_body_sim.report.problems import PROBLEMS

MADE = {
    'date': '2026-01-01T00:00:00+00:00',
    'machine': 'Linux x86_64',
    'cpu': 'a <fast> & cheap one',
    'cores': 2,
    'load': 0.0,
    'versions': {'rigid_body_sim': '0.1.0'},
    'compiled': True,
    'seed': 1,
    'repetitions': 7,
    'quick': False,
    'interrupted': False,
}
ABSENT = [{'engine': 'An engine', 'reason': 'not installed; pip install </script> it'}]


def sweep(engine, method, *, order, cost, coarse=1.0, points=12):
    """Points of a method of some order that costs so much a step."""
    found = []
    for halving in range(points):
        dt = coarse / 2**halving
        error = 0.1 * dt**order
        found.append(
            Point(
                engine=engine,
                version='1.0',
                method=method,
                precision='f64',
                setting=f'dt = {dt:g} s',
                dt=dt,
                tolerance=None,
                bodies=1,
                status=OK,
                error=error,
                energy_drift=None,
                cost=cost / dt,
                cost_low=0.9 * cost / dt,
                cost_high=1.1 * cost / dt,
                ns_per_step=cost * 1e9,
                evaluations_per_step=order,
            )
        )
    return found


@pytest.fixture(scope='module')
def report():
    """A report of two problems: ours of order four, a peer of order two that is cheap at first."""
    points = [
        *sweep('rigid_body_sim', 'rk4', order=4, cost=1e-7),
        *sweep('rigid_body_sim', 'dmv6', order=2, cost=2e-7),
        *sweep('Peer <b>', 'RK2', order=2, cost=5e-9, points=20),
        *sweep('Peer <b>', 'Euler', order=1, cost=4e-9, points=20),
        dataclasses.replace(
            sweep('rigid_body_sim', 'rk4', order=4, cost=1e-7, coarse=8.0)[0],
            status=NOT_ACCURATE,
            error=400.0,
        ),
        Point(
            'rigid_body_sim', '1.0', 'rk8', 'f64', 'dt = 9 s', 9.0, None, 1, DIVERGED, 'in tick 3'
        ),
    ]
    many = []
    for method, price in (('rk4', 20.0), ('dmv6', 15.0)):
        for bodies in (1, 10, 100):
            point = sweep('rigid_body_sim', method, order=4, cost=1e-7)[3]
            each = price * (1.0 + 10.0 / bodies)
            many.append(dataclasses.replace(point, bodies=bodies, ns_per_body_step=each))
    problems = [
        results.problem_results(PROBLEMS['torque_free_top'], points),
        results.problem_results(PROBLEMS['throughput'], many),
    ]
    return results.report(MADE, problems, ABSENT)


@pytest.fixture(scope='module')
def text(report):
    return page.page(report)


class Structure(html.parser.HTMLParser):
    """Every element that opens is closed, and nothing points away from the page."""

    def __init__(self):
        super().__init__()
        self.open, self.rows, self.addresses = [], 0, []

    def handle_starttag(self, tag, attributes):
        if tag not in ('meta', 'link', 'br'):
            self.open.append(tag)
        self.rows += tag == 'tr'
        self.addresses += [
            v for k, v in attributes if k in ('src', 'href') and not v.startswith('#')
        ]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def test_page_is_whole_and_names_no_address_but_its_own(text):
    structure = Structure()
    structure.feed(text)
    assert structure.open == []
    assert structure.addresses == ['data:,']  # an icon of nothing, so that no browser asks for one
    assert set(re.findall(r'https?://[\w./]*', text)) == {'http://www.w3.org/2000/svg'}  # a name


def test_page_shows_every_point_whatever_became_of_it(report, text):
    table = text[text.index('All 66 points') :]
    assert table.count('dt = ') >= 66
    assert 'diverged: in tick 3' in text
    assert 'not accurate' in text


def test_names_cannot_break_out_of_the_page(text):
    assert 'Peer <b>' not in text
    assert 'Peer &lt;b&gt; RK2' in text
    assert '</script> it' not in text


def test_sentences_of_the_numbers_are_on_the_page(report, text):
    for problem in report['problems']:
        assert problem['verdict'] in html.unescape(text)
    assert 'An engine' in text and 'pip install' in text


def test_losses_are_named_where_the_peer_is_cheaper(report):
    # at 1e-4: order two needs dt = 1/32 (0.03^2 * 0.1 < 1e-4) at 5 ns, order four 1/8 at 100 ns
    row = report['problems'][0]['at_equal_error'][0]
    assert row['peer']['cost'] == pytest.approx(5e-9 * 32)
    assert row['ours']['cost'] == pytest.approx(1e-7 * 8)
    assert row['ratio'] < 1.0
    first, second = losses(report)
    assert '1e-04' in first and 'RK2' in first and '160 ns' in first and '800 ns' in first
    assert '1e-06' in second
    assert first in markdown.markdown(report)


def test_goals_that_are_missed_are_named(report):
    # at 1e-8 order two needs 2^12 steps of 5 ns, order four 2^6 of 100 ns: 3.2; 100 is wanted
    first, second = missed_goals(report)
    assert '1e-08' in first and '3.20 times cheaper, aimed at 100' in first
    assert '1e-10' in second and '6.40 times' in second


def test_markdown_tables_have_as_many_fields_as_heads(report):
    tables = re.findall(r'(?:^\|.*\|\n?)+', markdown.markdown(report), re.MULTILINE)
    assert len(tables) >= 3
    for table in tables:
        assert len({line.count('|') for line in table.splitlines()}) == 1


@pytest.fixture(scope='module')
def drawn(report, tmp_path_factory):
    """The pictures of the first problem, beside the numbers."""
    folder = tmp_path_factory.mktemp('drawn')
    results.write(report, folder)
    return pictures.write({'problems': report['problems'][:1]}, folder)


def test_document_has_its_pictures_beside_it(drawn, tmp_path):
    path = tmp_path / 'docs' / 'speed.md'
    markdown.document(drawn[0].parent, path)
    (copy,) = (path.parent / 'speed').iterdir()
    assert f'({path.stem}/{copy.name})' in path.read_text()
    assert 1000 < copy.stat().st_size < 0.7 * drawn[0].stat().st_size


def test_front_is_what_no_other_point_beats(report):
    problem = report['problems'][0]
    front = series.front_of(problem)
    usable = [p for p in problem['points'] if p['status'] == OK]
    assert len(front) > 5
    for cost, error in front:
        assert not [p for p in usable if p['cost'] < cost and p['error'] < error]


def test_ours_and_peers_never_look_alike(report):
    curves = series.series_of(report['problems'][0])
    ours = {(curve.color, curve.mark) for curve in curves if curve.ours}
    peers = {(curve.color, curve.mark) for curve in curves if not curve.ours}
    assert ours and peers and not ours & peers
    assert len(ours) == len([curve for curve in curves if curve.ours and curve.stands_out])


def test_names_of_curves_do_not_cover_each_other():
    rng = np.random.default_rng(1)
    curves = [np.cumsum(rng.uniform(5, 40, (8, 2)), axis=0) + 60 * i for i in range(6)]
    sizes = [(80.0, 12.0)] * 6
    placed = labels.place(curves, sizes, range(6), (0.0, 0.0, 900.0, 700.0))
    for i, a in enumerate(placed):
        assert a.is_free
        for b in placed[:i]:
            assert abs(a.x - b.x) >= 80.0 or abs(a.y - b.y) >= 12.0


def test_pictures_of_the_same_numbers_are_the_same_files(report, drawn, tmp_path):
    again = pictures.write({'problems': report['problems'][:1]}, tmp_path)
    assert [path.name for path in again] == ['torque_free_top.png', 'torque_free_top.svg']
    for path, first in zip(again, drawn, strict=True):
        assert path.read_bytes() == first.read_bytes()
    assert '>rk4<' in drawn[1].read_text()  # text stays text


@pytest.fixture(scope='module')
def tab(tab, report, tmp_path_factory):
    """The page in a browser, from its file."""
    path = page.write(report, tmp_path_factory.mktemp('page'))
    tab.open(path.as_uri())
    yield tab
    assert tab.errors == []
    assert [address for address in tab.requests if address != path.as_uri()] == []


def test_browser_draws_every_curve_and_every_point(tab, report):
    for problem in report['problems']:
        curves = series.series_of(problem)
        figure = f'document.querySelector("figure[data-problem={problem["name"]}]")'
        assert tab.evaluate(f'{figure}.querySelectorAll("g.series").length') == len(curves)
        marks = tab.evaluate(f'{figure}.querySelectorAll("g.series path").length')
        assert marks == sum(len(curve.points) for curve in curves)
        inside = tab.evaluate(f"""[...{figure}.querySelectorAll('g.series path')].every(mark => {{
            const box = mark.getBoundingClientRect(), field = {figure}.getBoundingClientRect();
            return box.width > 0 && box.left >= field.left && box.right <= field.right + 1; }})""")
        assert inside


def test_browser_marks_the_front_through_its_points(tab, report):
    path = tab.evaluate('document.querySelector("path.front").getAttribute("d")')
    assert path.count('L') + 1 == len(series.front_of(report['problems'][0]))


def test_browser_sorts_a_table_by_any_column_both_ways(tab):
    errors = """(() => { const table = document.querySelector('table.sortable');
        const heads = [...table.tHead.rows[0].cells];
        const column = heads.findIndex(head => head.textContent.startsWith('error'));
        return [...table.tBodies[0].rows].map(r => r.cells[column].dataset.v); })()"""
    click = """[...document.querySelector('table.sortable').tHead.querySelectorAll('button')]
        .find(b => b.textContent.startsWith('error')).click()"""
    tab.evaluate(click)
    up = tab.evaluate(errors)
    assert up[-1] == '', 'what has no number comes last'
    values = [float(value) for value in up if value]
    assert values == sorted(values) and len(values) == 65
    tab.evaluate(click)
    down = tab.evaluate(errors)
    assert down[-1] == ''
    assert [float(value) for value in down if value] == values[::-1]


def test_browser_tells_of_a_point_under_the_pointer(tab):
    told = tab.evaluate("""(() => {
        const figure = document.querySelector('figure.plot'), svg = figure.querySelector('svg');
        figure.scrollIntoView();
        const curve = figure.querySelector('g.series[data-label=dmv6]');
        const mark = curve.querySelector('path').getBoundingClientRect();
        svg.dispatchEvent(new PointerEvent('pointermove', {
            clientX: mark.x + mark.width / 2, clientY: mark.y + mark.height / 2}));
        return figure.querySelector('.tip').innerText; })()""")
    assert told.startswith('dmv6')
    assert 'dt = 1 s' in told and 'error 1.00e-01 rad' in told and '200 ns' in told


def test_browser_hides_a_curve_on_request(tab):
    count = 'document.querySelector("figure.plot").querySelectorAll("g.series").length'
    before = tab.evaluate(count)
    button = 'document.querySelector("figure.plot .legend button")'
    tab.evaluate(f'{button}.click()')
    assert tab.evaluate(count) == before - 1
    tab.evaluate(f'{button}.click()')
    assert tab.evaluate(count) == before


@pytest.mark.parametrize('width', [1280, 400])
def test_browser_needs_no_scrolling_sideways(tab, width):
    tab.resize(width)
    tab.settle()
    assert tab.evaluate('document.documentElement.scrollWidth') <= width
    box = tab.evaluate('document.querySelector("figure.plot svg").getBoundingClientRect().width')
    assert math.isclose(
        box, tab.evaluate('document.querySelector("figure.plot").clientWidth'), abs_tol=1
    )


def test_problems_of_a_part_stand_under_its_heading(report):
    top, throughput = report['problems']
    parted = {**report, 'problems': [{**top, 'heading': 'The <lecture>'}, throughput]}
    text = page.page(parted)
    before, heading, after = (
        text.index(x)
        for x in ('id="throughput"', '<h1>The &lt;lecture&gt;</h1>', 'id="torque_free_top"')
    )
    assert before < heading < after
    lines = markdown.markdown(parted).splitlines()
    assert lines.count('# The <lecture>') == 1
    assert lines.index('# The <lecture>') < lines.index(f'## {top["title"]}')
    assert lines.index(f'## {throughput["title"]}') < lines.index('# The <lecture>')
