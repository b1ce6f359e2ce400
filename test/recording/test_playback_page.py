# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""The page that plays a run: whole by itself, drawn by a real browser, true to the bag."""

from __future__ import annotations

import argparse
import base64
import json
import re

import numpy as np
import pytest

from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.verbs import simulate, view
from rigid_body_sim.view.recorded_motion import read_motion

SCENE = """
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
"""


@pytest.fixture(scope='module')
def page(tmp_path_factory):
    """A bag of one second and the page of it."""
    folder = tmp_path_factory.mktemp('page')
    (folder / 'shapes.yaml').write_text(SCENE)
    parser = argparse.ArgumentParser()
    simulate.add_arguments(parser)
    words = [str(folder / 'shapes.yaml'), '-o', str(folder / 'bag'), '--duration', '1', '--json']
    assert simulate.run(parser.parse_args(words)) == 0
    parser = argparse.ArgumentParser()
    view.add_arguments(parser)
    assert view.run(parser.parse_args([str(folder / 'bag'), '-o', str(folder / 'run.html')])) == 0
    return folder / 'run.html'


def run_of(page):
    """The data in the page."""
    text = page.read_text()
    return json.loads(re.search(r'type="application/json">(.*?)</script>', text)[1])


def test_the_poses_in_the_page_are_those_of_the_bag_in_single_precision(page):
    run = run_of(page)
    numbers = np.frombuffer(base64.b64decode(run['numbers']), '<f4')
    poses = numbers.reshape(len(run['times']), len(run['bodies']), 7)
    motion = read_motion(Bag(page.parent / 'bag'), samples=10_000)
    for i, track in enumerate(motion.tracks):
        assert run['bodies'][i]['name'] == track.name
        assert np.array_equal(poses[:, i, :3], track.position.astype('<f4'))
        assert np.array_equal(poses[:, i, 3:], track.orientation.astype('<f4'))
    assert np.array_equal(run['times'], motion.tracks[0].time)


def test_the_page_asks_no_network_for_anything(page):
    text = page.read_text()
    assert not re.search(r'(?:src|href)\s*=\s*["\'](?!data:)', text)
    assert not re.search(r'\bimport\s*\(|@import|<link', text)


def test_the_corner_of_a_hull_is_drawn_from_its_centre_of_mass(page):
    wedge = next(body for body in run_of(page)['bodies'] if body['name'] == 'wedge')
    # centroid of this tetrahedron: a quarter of each edge
    assert np.allclose(wedge['parts'][0]['at'], [-0.25, -0.25, -0.25], rtol=0, atol=1e-15)


def test_a_browser_draws_every_body_without_a_word_of_complaint(tab, page):
    tab.open(page.as_uri())
    # the floor has a pose like every other body
    assert tab.evaluate('Number(document.body.dataset.drawn)') == len(run_of(page)['bodies'])
    assert tab.errors == []
