# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""The page that plays a run: whole by itself, drawn by a real browser, true to the bag."""

from __future__ import annotations

import argparse
import hashlib
from importlib.resources import files
from io import BytesIO
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest

from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.scene import load_scene
from rigid_body_sim.verbs import simulate, view
from rigid_body_sim.view.page_numbers import PageNumbers
from rigid_body_sim.view.page_record import page_record
from rigid_body_sim.view.playback_page import LIBRARIES, playback_page
from rigid_body_sim.view.recorded_motion import RecordedMotion, Track, read_motion

from ..pages import PageOf, array_of

SCENE = """
# Six shapes, a top without one, a spring, a drag and a drive: <b>nothing</b> & no "one" is hurt.
# Expected: what falls falls.
version: 1
name: six <shapes> & a plane
dt: 0.01
gravity: [0, 0, -9.81]
bodies:
  - {name: floor, shape: {type: plane, normal: [0, 0, 1]}}
  - {name: ball, shape: {type: sphere, radius: 0.2}, mass: 1, initial: {position: [0, 0, 3]}}
  - name: box
    shape: {type: box, size: [0.4, 0.2, 0.1]}
    mass: 1
    initial: {position: [1, 0, 3], angular_velocity: [1, 2, 3], velocity: [0, 1, 2]}
  - name: rod
    shape: {type: cylinder, radius: 0.1, length: 1}
    mass: 1
    initial: {position: [2, 0, 3]}
  - name: pill
    shape: {type: capsule, radius: 0.1, length: 0.3}
    mass: 1
    initial: {position: [3, 0, 3]}
  - name: wedge
    shape: {type: convex_hull, vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]}
    mass: 1
    initial: {position: [4, 0, 3]}
  - {name: point, shape: {type: particle}, mass: 1, initial: {position: [5, 0, 3]}}
  - name: top
    mass: 1
    inertia: {ixx: 0.1, iyy: 0.1, izz: 0.15}
    initial: {position: [-1, 0, 3], angular_velocity: [0, 0, 40]}
forces:
  - {type: spring, a: point, b: world, b_point: [5, 0, 4], stiffness: 50, damping: 1,
     rest_length: 1}
  - {type: drag, body: box, linear: 0.5}
  - {type: constant, body: rod, force: [0, 0, 9.81], point: [0, 0, 0.5], frame: body}
"""
COMMANDS = """time,body,kind,frame,fx,fy,fz,tx,ty,tz
0.30,ball,wrench,world,3,0,0,0,0,0.5
0.31,ball,wrench,world,0,0,0,0,0,0
"""
READY = "document.body.dataset.state === 'ready'"
PINNED = {
    'three.module.min.js': '08fd7545d13d2c7fb65ab691530a802dafefd638596501854f267d0fb13c39e7',
    'OrbitControls.js': '80efaadea4f8a636a65fb0bd08bfef62f3d93a0bb94e2e7500f23176c5c07f4e',
    'uPlot.esm.js': '5dd9b3281aa64b461b42d9945f6adb2649d346502b12281a9ae0d46599a80eba',
    'uPlot.min.css': 'df630c6a8d6f8eeaff264b50f73ce5b114f646ffd9a0bb74f049b0a00135fa04',
}  # three 0.170.0 (build/, examples/jsm/controls/), uplot 1.6.32 (dist/)


@pytest.fixture(scope='module')
def page(tmp_path_factory):
    """A bag of one second and the page of it."""
    folder = tmp_path_factory.mktemp('page')
    (folder / 'shapes.yaml').write_text(SCENE)
    (folder / 'commands.csv').write_text(COMMANDS)
    parser = argparse.ArgumentParser()
    simulate.add_arguments(parser)
    words = [str(folder / 'shapes.yaml'), '-o', str(folder / 'bag'), '--duration', '1', '--json']
    words += ['--commands', str(folder / 'commands.csv')]
    assert simulate.run(parser.parse_args(words)) == 0
    parser = argparse.ArgumentParser()
    view.add_arguments(parser)
    assert view.run(parser.parse_args([str(folder / 'bag'), '-o', str(folder / 'run.html')])) == 0
    return folder / 'run.html'


@pytest.fixture(scope='module')
def run(page):
    return PageOf(page)


@pytest.fixture(scope='module')
def looked_at(tab, page):
    """The page at its first instant, for the tests that leave it as it is: they stand together."""
    tab.open(f'{page.as_uri()}#paused')
    tab.wait_for(READY)
    tab.settle()
    return tab


@pytest.fixture
def opened(tab, page):
    """The page in a browser, at its first instant."""

    def go(*, width=1280, height=900, wishes='paused'):
        tab.open('about:blank')
        tab.open(f'{page.as_uri()}#{wishes}', width=width, height=height)
        tab.wait_for(READY)
        tab.settle()
        return tab

    return go


def test_the_states_in_the_page_are_those_of_the_bag_in_single_precision(page, run):
    motion = read_motion(Bag(page.parent / 'bag'), samples=10_000)
    positions, orientations = run.positions, run.of_bodies('orientation')
    for i, track in enumerate(motion.tracks):
        assert run['bodies'][i]['name'] == track.name
        # single precision of the way from the first instant, below 6 m
        assert np.allclose(positions[:, i], track.position, rtol=0, atol=4e-7)
        assert np.array_equal(orientations[:, i], track.orientation.astype('<f4'))
        for name in ('velocity', 'angular_velocity'):
            assert np.array_equal(run.of_bodies(name)[:, i], getattr(track, name).astype('<f4'))
    assert np.array_equal(run.times, motion.tracks[0].time)


def test_a_command_of_one_tick_is_in_the_page_at_the_instant_that_shows_it(run):
    """It acted from 0.30 s to 0.31 s: what the state at 0.31 s has felt."""
    ball = [body['name'] for body in run['bodies']].index('ball')
    force, torque = run.of_bodies('force')[:, ball], run.of_bodies('torque')[:, ball]
    (acted,) = np.flatnonzero(force.any(axis=1))
    assert run.times[acted] == pytest.approx(0.31, abs=1e-12)
    assert force[acted].tolist() == [3, 0, 0] and torque[acted].tolist() == [0, 0, 0.5]


@pytest.mark.parametrize('samples', [1000, 40, 7])
def test_however_few_instants_are_kept_a_command_is_at_the_next_and_nowhere_else(page, samples):
    record, numbers, _ = page_record(read_motion(Bag(page.parent / 'bag'), samples=samples), None)
    entry = record['series']['force']
    force = array_of(entry, numbers).reshape(-1, len(record['bodies']), 3)
    times = array_of(record['series']['time'], numbers)
    (acted,) = np.flatnonzero(force.any(axis=(1, 2)))
    assert acted == np.searchsorted(times, 0.30 + 1e-9)


def test_drag_and_drives_are_drawn_as_the_scene_has_them(run):
    names = [body['name'] for body in run['bodies']]
    sets = {each['kind']: each for each in run['arrows']}
    drag = run.series(sets['drag']['series'])
    velocity = run.of_bodies('velocity')[:, names.index('box')]
    assert sets['drag']['bodies'] == [names.index('box')]
    assert np.allclose(drag, -0.5 * velocity, rtol=1e-6, atol=0)  # single precision
    assert sets['drive']['at'] == [[0.0, 0.0, 0.5]]
    drive = run.series(sets['drive']['series'])
    assert np.allclose(np.linalg.norm(drive, axis=1), 9.81, rtol=1e-6)


def test_the_libraries_are_those_that_were_pinned_and_their_licences_are_there():
    vendor = files('rigid_body_sim.view') / 'vendor'
    found = {name: hashlib.sha256((vendor / name).read_bytes()).hexdigest() for name in PINNED}
    assert found == PINNED
    assert set(LIBRARIES.values()) <= set(PINNED)
    for name in ('three.LICENSE', 'uPlot.LICENSE'):
        assert 'Permission is hereby granted' in (vendor / name).read_text()


def test_the_corner_of_a_hull_is_drawn_from_its_centre_of_mass(run):
    wedge = next(body for body in run['bodies'] if body['name'] == 'wedge')
    # centroid of this tetrahedron: a quarter of each edge
    assert np.allclose(wedge['parts'][0]['at'], [-0.25, -0.25, -0.25], rtol=0, atol=1e-15)


def test_the_page_asks_no_network_for_anything(looked_at):
    outside = [
        address
        for address in looked_at.requests
        if not address.startswith(('file:', 'blob:', 'data:'))
    ]
    assert outside == []


def test_the_page_is_small_and_its_words_are_those_of_the_scene(looked_at, page):
    assert page.stat().st_size < 1_000_000
    assert (
        looked_at.evaluate("document.querySelector('h1').textContent") == 'six <shapes> & a plane'
    )
    caption = looked_at.evaluate("document.getElementById('caption').textContent")
    assert '<b>nothing</b> & no "one" is hurt' in caption and 'what falls falls' in caption


def test_between_instants_a_fast_spin_goes_on_as_the_angular_velocity_tells(looked_at, run):
    """
    40 rad/s seen every 0.1 s is 4 rad from instant to instant, more than half a turn: the short
    way round would go backwards. The page is told only each tenth instant of the bag.
    """
    top = [body['name'] for body in run['bodies']].index('top')
    found = looked_at.evaluate(f"""(() => {{
        const {{ run }} = view, whole = run.series;
        const tenth = each => each.values.filter((_, i) => Math.floor(i / each.width) % 10 === 0);
        run.series = Object.fromEntries(Object.entries(whole).map(
            ([name, each]) => [name, {{ width: each.width, values: tenth(each) }}]));
        const q = run.orientation({top}, run.moment(0.15), []);
        run.series = whole;
        return q; }})()""")
    angle = 2.0 * np.arctan2(found[2], found[3])
    assert np.cos(angle - 40.0 * 0.15) == pytest.approx(1.0, abs=1e-6)  # single precision


def test_what_is_zero_on_a_logarithmic_axis_is_told_as_zero(looked_at, run):
    plots = [plot for plot in run['curves'] if plot.get('logarithmic')]
    drifts = [run.array(curve['values']) for plot in plots for curve in plot['curves']]
    assert drifts and all(drift[0] == 0.0 for drift in drifts)
    titles = [f'{plot["title"]} [–]' for plot in plots]
    shown = looked_at.evaluate(f"""[...document.querySelectorAll('figure')]
        .filter(figure => {titles}.includes(figure.querySelector('.title').textContent))
        .flatMap(figure => [...figure.querySelectorAll('b')].map(value => value.textContent))""")
    assert shown == ['0'] * len(drifts)


SEEN = """(() => {
    view.draw();
    const framed = 'header, #stage, #controls, #panel, figure, button, select, input, output, '
        + 'figcaption span';
    const outside = [...document.querySelectorAll(framed)].filter(each => each.checkVisibility())
        .filter(each => {
            const box = each.getBoundingClientRect();
            return box.left < -0.5 || box.right > innerWidth + 0.5; })
        .map(each => each.id || each.className || each.tagName);
    const stage = document.getElementById('stage').getBoundingClientRect();
    const { bodies } = view.run, seen = i => view.stage.project(view.bodies.places[i].position);
    return { outside, stage: [stage.width, stage.height],
        hidden: bodies.flatMap((body, i) => (body.watched && !seen(i).inside ? [body.name] : [])),
        theme: document.documentElement.dataset.theme,
        paper: getComputedStyle(document.body).backgroundColor }; })()"""


@pytest.mark.parametrize(
    ('theme', 'width', 'height'),
    [
        ('light', 1280, 900),
        ('dark', 390, 844),
        pytest.param('light', 390, 844, marks=pytest.mark.long),
        pytest.param('dark', 1280, 900, marks=pytest.mark.long),
    ],
)
def test_every_body_is_in_view_at_the_start_and_nothing_is_outside_its_frame(
    opened, width, height, theme
):
    tab = opened(width=width, height=height, wishes=f'theme={theme}&paused')
    seen = tab.evaluate(SEEN)
    assert (seen['outside'], seen['hidden'], seen['theme']) == ([], [], theme)
    assert min(seen['stage']) >= 250
    assert (sum(map(int, seen['paper'][4:-1].split(','))) < 3 * 128) == (theme == 'dark')
    assert tab.errors == []


SECONDS = {'pile_of_1000': 0.1}  # [s] in place of one: a thousand boxes take long
SCENES = sorted(path.stem for path in (Path(__file__).parents[2] / 'config/scenes').glob('*.yaml'))


@pytest.mark.long
@pytest.mark.parametrize('scene', SCENES)
def test_every_shipped_scene_is_seen_whole_in_all_sizes_and_themes(tab, tmp_path, scene):
    """Also after a second: where bodies leave, the camera goes with them."""
    end = SECONDS.get(scene, 1.0)
    parser = argparse.ArgumentParser()
    simulate.add_arguments(parser)
    words = [scene, '-o', str(tmp_path / 'bag'), '--duration', str(end), '--json']
    assert simulate.run(parser.parse_args(words)) == 0
    parser = argparse.ArgumentParser()
    view.add_arguments(parser)
    file = tmp_path / 'run.html'
    assert view.run(parser.parse_args([str(tmp_path / 'bag'), '-o', str(file)])) == 0
    tab.open('about:blank')
    tab.open(f'{file.as_uri()}#theme=light&paused')
    tab.wait_for(READY)
    for width, height in ((1280, 900), (390, 844)):
        tab.resize(width, height)
        tab.settle()
        for time in (0.0, end):
            tab.evaluate(f'view.seek({time})')
            tab.evaluate('view.theme.toggle()')
            seen = tab.evaluate(SEEN)
            assert (seen['outside'], seen['hidden']) == ([], [])
    assert tab.errors == []


def key(tab, name, *, code=None, text=None):
    for kind in ('keyDown', 'keyUp'):
        more = {'text': text} if text and kind == 'keyDown' else {}
        tab.ask('Input.dispatchKeyEvent', type=kind, key=name, code=code or name, **more)
    tab.settle()


def mouse(tab, x, y, *, to=None):
    """Press and release the left button, moving in between where `to` says so."""
    at = {'button': 'left', 'clickCount': 1}
    tab.ask('Input.dispatchMouseEvent', type='mousePressed', x=x, y=y, **at)
    if to:
        tab.ask('Input.dispatchMouseEvent', type='mouseMoved', x=to[0], y=to[1], buttons=1, **at)
    x, y = to or (x, y)
    tab.ask('Input.dispatchMouseEvent', type='mouseReleased', x=x, y=y, **at)
    tab.settle()


def test_keys_play_step_choose_and_change_the_theme(opened):
    tab = opened()
    key(tab, ' ', code='Space', text=' ')
    assert (
        tab.evaluate('view.player.playing')
        and tab.evaluate('document.body.dataset.playing') == 'true'
    )
    tab.wait_for('view.player.now > 0.02')
    key(tab, ' ', code='Space', text=' ')
    assert not tab.evaluate('view.player.playing')
    key(tab, 'Home')
    key(tab, 'ArrowRight')
    assert tab.evaluate('view.player.now') == pytest.approx(0.01, abs=1e-12)
    key(tab, 'End')
    assert tab.evaluate('view.player.now') == pytest.approx(1.0, abs=1e-12)
    key(tab, 'ArrowLeft')
    assert tab.evaluate('view.player.now') == pytest.approx(0.99, abs=1e-12)
    before = tab.evaluate('view.chosen')
    key(tab, 'n', text='n')
    assert tab.evaluate('view.chosen') == before + 1
    theme = tab.evaluate('view.theme.name')
    key(tab, 't', text='t')
    assert tab.evaluate('document.documentElement.dataset.theme') != theme
    rate = tab.evaluate('view.player.rate')
    key(tab, 'ArrowUp')
    assert tab.evaluate('view.player.rate') > rate
    assert tab.errors == []


def test_a_click_on_a_body_selects_it_and_its_plots(opened, run):
    tab = opened()
    box = [body['name'] for body in run['bodies']].index('box')
    assert tab.evaluate('view.chosen') != box
    at = tab.evaluate(f"""(() => {{
        const seen = view.stage.project(view.bodies.places[{box}].position);
        const stage = document.getElementById('stage').getBoundingClientRect();
        return [stage.left + seen.x, stage.top + seen.y]; }})()""")
    mouse(tab, *at)
    assert tab.evaluate('view.chosen') == box
    titles = tab.evaluate(
        "[...document.querySelectorAll('figure .title')].map(each => each.textContent)"
    )
    wanted = (
        'position [m]',
        'roll, pitch, yaw',
        'velocity [m/s]',
        'body axes [rad/s]',
        'energy [J]',
    )
    for words in wanted:
        assert any(words in title for title in titles), titles
    assert not any('torque' in title for title in titles)  # the box has none: no empty panel


def test_the_plots_follow_the_time_and_a_click_in_a_plot_sets_it(opened, run):
    tab = opened()
    middle = tab.evaluate("""(() => {
        const box = document.querySelector('figure .u-over').getBoundingClientRect();
        return [box.left + 0.25 * box.width, box.top + 0.5 * box.height]; })()""")
    mouse(tab, *middle)
    now = tab.evaluate('view.player.now')
    assert now == pytest.approx(0.25, abs=0.01)  # a pixel of 300
    tab.evaluate('view.seek(0.5)')
    chosen, k = tab.evaluate('view.chosen'), int(np.argmin(np.abs(run.times - 0.5)))
    shown = tab.evaluate("[...document.querySelectorAll('figure')][0].innerText")
    z = run.positions[k, chosen, 2]
    assert f'z {z:.5g}' in ' '.join(shown.split())
    bar = tab.evaluate("""(() => {
        const over = document.querySelector('figure .u-over').getBoundingClientRect();
        const now = document.querySelector('figure .now').getBoundingClientRect();
        return (now.left - over.left) / over.width; })()""")
    assert bar == pytest.approx(0.5, abs=0.01)
    assert tab.evaluate("Number(document.getElementById('time').value)") == pytest.approx(0.5)


def test_the_speed_is_a_slider_and_the_run_begins_again(opened):
    tab = opened()
    tab.evaluate("""(() => { const speed = document.getElementById('speed');
        speed.value = 1; speed.oninput(); })()""")
    assert tab.evaluate("document.getElementById('speed-text').textContent") == '10 ×'
    tab.evaluate('(view.player.set(true), view.player.advance(0.05))')
    assert tab.evaluate('view.player.now') > 0.45
    tab.evaluate('view.player.advance(0.2)')
    assert tab.evaluate('view.player.playing') and tab.evaluate('view.player.now') < 0.9


def test_the_camera_keeps_up_upright_and_goes_with_what_leaves(opened):
    tab = opened()
    stage = tab.evaluate("""(() => {
        const box = document.getElementById('stage').getBoundingClientRect();
        return [box.left, box.top, box.width, box.height]; })()""")
    x, y = stage[0] + 0.85 * stage[2], stage[1] + 0.3 * stage[3]
    before = tab.evaluate('view.stage.camera.position.toArray()')
    mouse(tab, x, y, to=(x - 200, y + 120))
    tab.evaluate('view.draw()')
    after = tab.evaluate('view.stage.camera.position.toArray()')
    assert not np.allclose(before, after, rtol=0, atol=0.1)
    # the world's z is upright in the picture: no component to the side
    side = tab.evaluate(
        """(() => { const e = view.stage.camera.matrixWorld.elements; return e[2]; })()"""
    )
    assert abs(side) < 1e-12
    key(tab, 'a', text='a')
    assert tab.evaluate('view.stage.camera.position.toArray()') == pytest.approx(before, rel=1e-6)
    for time in (0.0, 0.5, 1.0):
        tab.evaluate(f'view.seek({time})')
        assert tab.evaluate(SEEN)['hidden'] == []


CAMERA = """(() => {
    view.draw();
    const { camera, controls } = view.stage;
    return { at: camera.position.toArray(), target: controls.target.toArray(),
        away: view.stage.zoom, // 1: as far as all needs, seen from there
        up: camera.matrixWorld.elements[2] }; })()"""


@pytest.fixture
def phone(tab, page):
    """The page on a phone that is touched."""
    size = {'width': 390, 'height': 844, 'deviceScaleFactor': tab.scale, 'mobile': True}
    tab.open('about:blank')
    tab.open(f'{page.as_uri()}#paused')
    tab.ask('Emulation.setDeviceMetricsOverride', **size)
    tab.ask('Emulation.setTouchEmulationEnabled', enabled=True, maxTouchPoints=2)
    tab.wait_for(READY)
    tab.settle()
    yield tab
    tab.ask('Emulation.setTouchEmulationEnabled', enabled=False)
    tab.resize(1280, 900)


def middle(tab, element):
    """Where a finger meets an element of the page that is scrolled to its top."""
    x, y = tab.evaluate(f"""(() => {{
        scrollTo(0, 0);
        const box = document.getElementById('{element}').getBoundingClientRect();
        return [box.left + 0.5 * box.width, box.top + 0.5 * box.height]; }})()""")
    return x, min(y, 800)


def touch(tab, *ways, steps=3):
    """Put fingers down, move each along its way [(x, y), (x, y)], and lift them."""
    for k in range(steps + 1):
        points = [
            {'x': a[0] + k / steps * (b[0] - a[0]), 'y': a[1] + k / steps * (b[1] - a[1]), 'id': i}
            for i, (a, b) in enumerate(ways)
        ]
        kind = 'touchMove' if k else 'touchStart'
        tab.ask('Input.dispatchTouchEvent', type=kind, touchPoints=points)
        tab.settle()
    tab.ask('Input.dispatchTouchEvent', type='touchEnd', touchPoints=[])
    tab.settle()
    return tab.evaluate(CAMERA)


def test_one_finger_turns_two_fingers_come_nearer_and_shift(phone):
    x, y = middle(phone, 'stage')
    before = phone.evaluate(CAMERA)
    turned = touch(phone, [(x - 60, y), (x + 60, y + 40)])
    assert not np.allclose(turned['at'], before['at'], rtol=0, atol=0.1)
    assert before['away'] == 1.0 and turned['away'] == pytest.approx(1.0, rel=1e-9)
    assert np.allclose(turned['target'], before['target'], rtol=0, atol=1e-9)
    assert abs(turned['up']) < 1e-12  # upright: the world's z has no component to the side
    nearer = touch(phone, [(x - 30, y), (x - 80, y)], [(x + 30, y), (x + 80, y)])
    assert nearer['away'] < 0.7 * turned['away']
    away = touch(phone, [(x - 80, y), (x - 40, y)], [(x + 80, y), (x + 40, y)])
    assert away['away'] > 1.4 * nearer['away']
    shifted = touch(phone, [(x - 30, y), (x - 30, y + 80)], [(x + 30, y), (x + 30, y + 80)])
    assert shifted['away'] == pytest.approx(away['away'], rel=0.01)
    assert np.linalg.norm(np.subtract(shifted['target'], away['target'])) > 0.5  # m
    assert phone.errors == []


def test_a_tap_selects_the_body_under_the_finger(phone, run):
    box = [body['name'] for body in run['bodies']].index('box')
    at = phone.evaluate(f"""(() => {{
        const seen = view.stage.project(view.bodies.places[{box}].position);
        const stage = document.getElementById('stage').getBoundingClientRect();
        return [stage.left + seen.x, stage.top + seen.y]; }})()""")
    assert phone.evaluate('view.chosen') != box
    touch(phone, [at, at], steps=1)
    assert phone.evaluate('view.chosen') == box


def test_a_finger_scrolls_and_zooms_the_page_everywhere_but_in_the_picture(phone):
    def swiped(element):
        x, y = middle(phone, element)
        touch(phone, [(x, y), (x, y - 40)])
        return phone.evaluate('scrollY')

    def pinched(element):
        x, y = middle(phone, element)
        touch(phone, [(x - 20, y), (x - 80, y)], [(x + 20, y), (x + 80, y)])
        return phone.evaluate('visualViewport.scale')

    before = phone.evaluate(CAMERA)['at']
    assert swiped('caption') > 20 and swiped('panel') > 20
    assert phone.evaluate(CAMERA)['at'] == pytest.approx(before, rel=1e-9)
    assert swiped('stage') == 0
    assert phone.evaluate(CAMERA)['at'] != pytest.approx(before, rel=1e-2)
    assert pinched('stage') == 1.0
    assert pinched('caption') > 1.2


def test_a_page_in_a_frame_of_another_page_works_too(tab, page, tmp_path):
    """Notebooks show it as the `srcdoc` of a frame."""
    host = tmp_path / 'host.html'
    text = page.read_text().replace('&', '&amp;').replace('"', '&quot;')
    host.write_text(
        '<!DOCTYPE html><title>host</title>'
        f'<iframe id="run" width="900" height="600" srcdoc="{text}"></iframe>'
    )
    tab.open(host.as_uri())
    tab.wait_for("document.getElementById('run').contentDocument.body?.dataset.state === 'ready'")
    assert tab.errors == []


def test_a_browser_without_unpacking_says_what_it_lacks(tab, page, opened):
    added = tab.ask(
        'Page.addScriptToEvaluateOnNewDocument', source='delete window.DecompressionStream'
    )
    try:
        tab.open('about:blank')
        tab.open(page.as_uri())
        said = tab.evaluate("document.getElementById('message').textContent")
    finally:
        tab.ask('Page.removeScriptToEvaluateOnNewDocument', **added)
    assert 'Firefox from 113' in said


def test_without_webgl_the_plots_still_work(tab, page):
    source = """const get = HTMLCanvasElement.prototype.getContext;
        HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
            return kind.includes('webgl') ? null : get.call(this, kind, ...more); };"""
    added = tab.ask('Page.addScriptToEvaluateOnNewDocument', source=source)
    try:
        tab.open('about:blank')
        tab.open(page.as_uri())
        tab.wait_for("document.body.dataset.state === 'plots only'")
        assert 'WebGL' in tab.evaluate("document.getElementById('message').textContent")
        assert tab.evaluate("document.querySelectorAll('figure canvas').length") > 3
        tab.evaluate('view.seek(0.5)')
    finally:
        tab.ask('Page.removeScriptToEvaluateOnNewDocument', **added)


PAIR = b"""
dt: 0.01
bodies:
  - {name: left, shape: {type: box, size: [1, 1, 1]}, mass: 1}
  - {name: right, shape: {type: box, size: [1, 1, 1]}, mass: 1, initial: {position: [2, 0, 0]}}
"""


def picture_of_pair(tab, folder, origin, speed):
    """Two boxes beside each other that fly along y, in the middle between two instants."""
    time = np.array([0.0, 1.0, 2.0])
    still, turn = np.zeros((3, 3)), np.tile([0.0, 0.0, np.sin(0.2), np.cos(0.2)], (3, 1))
    flown = origin + np.outer(time, [0.0, speed, 0.0])
    tracks = tuple(
        Track(name, time, flown + place, turn, time, still, still)
        for name, place in (('left', [0.0, 0.0, 0.0]), ('right', [2.0, 0.0, 0.0]))
    )
    motion = RecordedMotion(tracks, np.empty(0))
    path = folder / f'{origin[0]:g}.html'
    path.write_text(playback_page(motion, load_scene(PAIR), title='pair'))
    tab.open(f'{path.as_uri()}#film&paused&theme=light', width=800, height=600)
    tab.wait_for("document.body.dataset.state === 'ready'")
    tab.evaluate("['trails', 'origin'].forEach(name => { view.layers[name].checked = false; })")
    tab.evaluate('view.seek(1.5)')
    tab.settle()
    box = '[view.stage.project(view.bodies.places[1].position)].map(p => [p.x, p.y])[0]'
    x, y = tab.evaluate(box)
    met = tab.evaluate(f'view.at({x}, {y})')
    content = tab.picture()
    return matplotlib.image.imread(BytesIO(content))[:, :, :3], met


@pytest.mark.parametrize(
    ('origin', 'speed'), [pytest.param(6.9e6, 7600.0, marks=pytest.mark.long), (1e9, 3e4)]
)
def test_bodies_far_away_look_as_they_do_at_the_origin(tab, tmp_path, origin, speed):
    """Single precision of 6.9e6 m is half a metre, of 1e9 m 64 m."""
    here, first = picture_of_pair(tab, tmp_path, np.zeros(3), 0.0)
    there, second = picture_of_pair(tab, tmp_path, np.array([origin, 0.3 * origin, 7.0]), speed)
    assert first == second == 1  # who is clicked is found too
    assert np.ptp(here) > 0.3  # there is something to see
    # edges lie between pixels elsewhere, by what double precision has left
    assert np.mean(np.abs(here - there).max(axis=2) > 0.1) < 2e-3


def test_places_far_away_are_told_in_double_precision():
    numbers = PageNumbers()
    near, far = numbers.add_places([1.0, 2.0], 0.5), numbers.add_places([6.9e6, 2.0], 0.5)
    assert (near['kind'], far['kind']) == ('f4', 'f8')
