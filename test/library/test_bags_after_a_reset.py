# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
After a reset the scene begins anew and time goes on: a bag from there tells of the same masses,
inertias and forces over time as one from t = 0, at stamps that are so much later.
"""

import numpy as np
import pytest

import rigid_body_sim as rbs
from rigid_body_sim.__main__ import main
from rigid_body_sim.library.notebook import page_of_run
from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.view import live_server
from rigid_body_sim.view.bag_follower import BagFollower
from rigid_body_sim.view.energy_history import energy_history

from ..pages import PageOf

RESET = 1300  # [tick] of 1 ms
# a cart that loses half its mass in 0.8 s, pushed from 0.2 to 0.6 s; a skater who draws in arms
SCENE = {
    'dt': 0.001,
    'integrator': 'lie_rk4',
    'bodies': [
        {'name': 'cart', 'shape': {'type': 'box', 'size': [0.4, 0.3, 0.2]}, 'mass': 2.0,
         'mass_rate': -1.25, 'final_mass': 1.0, 'initial': {'velocity': [0, 1, 0]}},
        {'name': 'skater', 'mass': 1.0, 'inertia_over_time': {
            'table': [[0.1, 1.0, 1.0, 1.5], [0.7, 1.0, 1.0, 0.75]]},
         'initial': {'angular_velocity': [0, 0, 1]}},
    ],
    'forces': [{'type': 'time', 'body': 'cart', 'table': [[0.2, 1, 0, 0], [0.6, 1, 0, 0]]}],
}  # fmt: skip


@pytest.fixture(scope='module')
def bags(tmp_path_factory):
    """
    The second of the scene from t = 0, and the same after a reset at 1.3 s.
    """
    folder, paths = tmp_path_factory.mktemp('bags'), []
    for name, ticks in (('first', 0), ('again', RESET)):
        simulation = rbs.Simulation(SCENE)
        if ticks:
            simulation.step(ticks)
            simulation.reset()
        simulation.run(1.0, every=0.005).save(folder / name)
        paths.append(folder / name)
    return paths


def wrenches(bag, body):
    """Stamps [ns], and forces and torques (k, 6)."""
    found = [
        (m.log_time, cdr.decode(cdr.WrenchStamped.TYPE, m.data))
        for m in Bag(bag).messages([f'/{body}/wrench'])
    ]
    times = np.array([time for time, _ in found])
    return times, np.array([(*wrench.force, *wrench.torque) for _, wrench in found])


def test_the_wrench_that_explains_it_is_the_same(bags, capsys):
    for bag in bags:
        assert main(['inverse', str(bag), '-o', f'{bag}_derived']) == 0
        assert 'warning' not in capsys.readouterr().out
    for body in ('cart', 'skater'):
        first, again = (wrenches(f'{bag}_derived', body) for bag in bags)
        assert (again[0] - first[0] == RESET * 1_000_000).all()
        np.testing.assert_array_equal(again[1], first[1])
    times, wrench = wrenches(f'{bags[1]}_derived', 'cart')
    pushed = (times > 1.51e9) & (times < 1.89e9)  # 0.2 to 0.6 s after the reset
    # truncation of the spline, whose estimate is 1e-5 N
    np.testing.assert_allclose(wrench[pushed, 0], 1.0, atol=1e-4)


def test_energies_momenta_and_drawn_drives_are_the_same(bags, tmp_path, monkeypatch):
    pages, energies = [], []

    def followed(*words, **more):
        energies.append(energy_history(*words, **more))
        return energies[-1]

    monkeypatch.setattr('rigid_body_sim.verbs.view.energy_history', followed)
    monkeypatch.setattr('rigid_body_sim.library.notebook.energy_history', followed)
    for bag in bags:
        page = tmp_path / f'{bag.name}.html'
        assert main(['view', str(bag), '-o', str(page)]) == 0
        pages.append(PageOf(page))
        page.write_text(page_of_run(rbs.open_bag(bag)))
        pages.append(PageOf(page))
    for energy in energies[1:]:
        # rounding of the stamps, 1.3 s in place of 0
        np.testing.assert_allclose(energy.kinetic, energies[0].kinetic, rtol=1e-12)
    for page in pages[1:]:
        for name in pages[0]['series'].keys() - {'time'}:
            # in single precision
            np.testing.assert_allclose(
                page.series(name), pages[0].series(name), rtol=1e-6, atol=1e-6, err_msg=name
            )


def test_the_page_that_follows_a_bag_draws_the_same(bags, tmp_path):
    pages = []
    for bag in bags:
        run = live_server.LiveRun(BagFollower(bag))
        while not run.ended:
            run.look()
        page = tmp_path / f'{bag.name}.html'
        page.write_text(run.page())
        pages.append(PageOf(page))
    first, again = pages
    assert {'arrows_0', 'angular_momentum', 'total'} <= set(first['series'])
    assert np.any(first.series('arrows_0'))
    for name in first['series'].keys() - {'time'}:
        # in single precision
        np.testing.assert_allclose(
            again.series(name), first.series(name), rtol=1e-6, atol=1e-6, err_msg=name
        )
