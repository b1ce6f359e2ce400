# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""The playback page shows the recorded contact forces as arrows, each once."""

from __future__ import annotations

import argparse

import numpy as np
import pytest

from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.verbs import simulate, view
from rigid_body_sim.view import contact_arrows

from ..pages import PageOf

SCENE = """
version: 1
name: tower
dt: 0.004
gravity: [0, 0, -9.81]
contact: {mode: timestep}
bodies:
  - {name: ground, shape: {type: plane, normal: [0, 0, 1]}}
  - name: box
    shape: {type: box, size: [0.2, 0.2, 0.2]}
    mass: 1
    initial: {position: [0, 0, 0.1]}
    repeat: {count: [1, 1, 2], spacing: [0, 0, 0.2]}
"""
PLACES = {'ground': 0, 'box_1': 1, 'box_2': 2}


OVERLAP = """
version: 1
name: overlap
dt: 0.004
gravity: [0, 0, -9.81]
contact: {mode: timestep, slop: 0.001}
bodies:
  - {name: ground, shape: {type: plane, normal: [0, 0, 1]}}
  - name: ball
    shape: {type: sphere, radius: 0.1}
    mass: 1
    initial: {position: [0, 0, 0.0985]}
"""


def made(folder, *words, scene=SCENE):
    """The page of a scene, a tower of two boxes, after 0.4 s."""
    (folder / 'tower.yaml').write_text(scene)
    parser = argparse.ArgumentParser()
    simulate.add_arguments(parser)
    line = [folder / 'tower.yaml', '-o', folder / 'bag', '--duration', '0.4', '--json', *words]
    assert simulate.run(parser.parse_args([str(word) for word in line])) == 0
    parser = argparse.ArgumentParser()
    view.add_arguments(parser)
    assert view.run(parser.parse_args([str(folder / 'bag'), '-o', str(folder / 'run.html')])) == 0
    return folder / 'run.html'


@pytest.fixture(scope='module')
def page(tmp_path_factory):
    return made(tmp_path_factory.mktemp('arrows'), '--contacts')


def test_the_arrows_at_rest_carry_the_weights_each_contact_once(page):
    run = PageOf(page)
    starts = run.array(run['contacts']['starts'])
    arrows = run.array(run['contacts']['arrows']).reshape(-1, 6)
    assert len(starts) == len(run.times) + 1
    assert (starts[0], starts[-1]) == (0, len(arrows))
    last = arrows[starts[-2] :]
    assert len(last) == 8
    below = last[:, 2] < 0.1
    # upwards, on what can move and is listed later; at rest to what single precision holds
    assert last[below, 5].sum() == pytest.approx(2 * 9.81, rel=1e-4)
    assert last[~below, 5].sum() == pytest.approx(9.81, rel=1e-4)
    assert np.allclose(last[~below, 2], 0.2, atol=1e-4)
    usual = run['contacts']['longest'] / 4
    assert usual == pytest.approx(run['arrow'])
    assert run['contacts']['metres'] * 9.81 / 2 == pytest.approx(usual, rel=0.1)


def test_an_arrow_begins_on_the_surface_of_its_body_where_the_surfaces_overlap(tmp_path):
    run = PageOf(made(tmp_path, '--contacts', '--publish-rate', '250', scene=OVERLAP))
    starts = run.array(run['contacts']['starts'])
    arrows = run.array(run['contacts']['arrows']).reshape(-1, 6)
    touching = np.flatnonzero(np.diff(starts))
    assert len(touching) == len(arrows) > 10
    height = run.positions[touching, 1, 2] - 0.1
    assert height.max() < -5e-4
    # of the ball's surface, not of the ground's, nor of the middle; single precision of 0.1 m
    assert arrows[:, 2] == pytest.approx(height, abs=2e-8)


def test_where_many_touch_the_largest_are_kept(page, monkeypatch):
    bag, times = Bag(page.parent / 'bag'), PageOf(page).times
    whole = contact_arrows.read_arrows(bag, times, PLACES)
    monkeypatch.setattr(contact_arrows, 'LARGEST', 5 * contact_arrows.BYTES_PER_ARROW * len(times))
    fewer = contact_arrows.read_arrows(bag, times, PLACES)
    assert (whole.left, fewer.left) == (0, len(whole.arrows) - len(fewer.arrows))
    assert np.diff(fewer.starts).max() == 5
    last, kept = (
        np.sort(np.linalg.norm(found.arrows[found.starts[-2] :, 3:], axis=1))
        for found in (whole, fewer)
    )
    assert kept.tolist() == last[-5:].tolist()


def test_without_recorded_contacts_there_is_nothing_of_them(tmp_path):
    page = made(tmp_path)
    assert PageOf(page)['contacts'] is None


def test_a_browser_draws_the_arrows_of_the_instant_while_they_are_wanted(tab, page):
    tab.open(f'{page.as_uri()}#paused')
    tab.wait_for("document.body.dataset.state === 'ready'")
    for shown, count in (('true', 8), ('false', 0)):
        drawn = tab.evaluate(f"""(() => {{
            view.layers.contact.checked = {shown};
            view.seek(view.run.end);
            return view.arrows.count.contact; }})()""")
        assert drawn == count
        legend = tab.evaluate("document.getElementById('legend').textContent")
        assert ('contact force' in legend) == (count > 0)
    assert tab.errors == []
