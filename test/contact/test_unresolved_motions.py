# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A motion that ticks do not resolve is told before anything is thrown by it, and no other one.
"""

import numpy as np
import pytest

from rigid_body_sim.physics.model import prescribed_motion as parts
from rigid_body_sim.physics.model.prescribed_motion import greatest_rates, motion_at, path_of
from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.scene import load_scene

DT = 0.004  # [s]
SLAB = {'type': 'box', 'size': [2, 2, 0.2]}
# rows far closer than ticks, which end at rest; more than g
WAVE = [[k * 1e-3, 0, 0, 1 - np.cos(k * 2 * np.pi * 1e-3)] for k in range(1001)]


def warnings_of(motion, *, mode='timestep', dt=DT, **initial):
    ball = {'name': 'ball', 'shape': {'type': 'sphere', 'radius': 0.1}, 'mass': 1.0,
            'initial': {'position': [0, 0, 2]}}  # fmt: skip
    deck = {'name': 'deck', 'shape': SLAB, 'motion': motion, 'initial': initial}
    scene = {'dt': dt, 'gravity': [0, 0, -9.81], 'contact': {'mode': mode},
             'bodies': [deck, ball]}  # fmt: skip
    return Simulation(load_scene(scene)).scene_warnings


def heave(amplitude, ticks):
    return {'heave': {'amplitude': amplitude, 'period': ticks * DT}}


@pytest.mark.parametrize(
    ('motion', 'mode', 'is_told'),
    [
        (heave(0.01, 0.5), 'timestep', True),
        (heave(0.01, 7.5), 'timestep', True),
        (heave(0.01, 8.5), 'timestep', False),
        (heave(0.01, 1.5), 'event', True),
        (heave(0.01, 7.5), 'event', False),
        (heave(1e-9, 0.1), 'timestep', False),  # less than g: what lies on it stays there
        ({'pitch': {'amplitude': 0.1, 'period': 4 * DT}}, 'timestep', True),
        ({'table': [[0, 0, 0, 0], [1e-6, 0, 0, 0.05]]}, 'timestep', True),
        ({'table': [[0, 0, 0, 0], [1.0, 0, 0, 0.05]]}, 'timestep', False),
        ({'table': WAVE}, 'timestep', False),
        ({}, 'timestep', False),  # goes on evenly
    ],
)
def test_a_motion_is_told_that_changes_its_velocity_within_a_tick(motion, mode, is_told):
    more = {} if motion else {'velocity': [30, 0, 0]}
    told = warnings_of(motion, mode=mode, **more)
    assert len(told) == is_told
    if is_told:
        assert told[0].startswith("'deck' moves faster than ticks of 0.004 s can follow")
        cure = float(told[0].split('set dt to at most ')[1].split(' s')[0])
        assert not warnings_of(motion, mode=mode, dt=round(cure, 9))


def test_greatest_rates_bound_those_of_every_instant():
    rng = np.random.default_rng(2)
    for _ in range(8):
        times = np.cumsum(rng.uniform(0.1, 0.5, 6))
        motion = {'table': np.column_stack((times, rng.normal(size=(6, 6)))).tolist()}
        for way in ('surge', 'heave', 'yaw'):
            motion[way] = {'amplitude': rng.normal(), 'period': rng.uniform(0.2, 2.0)}
        deck = {'name': 'deck', 'shape': SLAB, 'motion': motion}
        body = load_scene({'dt': DT, 'bodies': [deck]}).bodies[0]
        rates, changes = greatest_rates(body)
        path, found = path_of(body, body.center_of_mass), np.zeros((2, 6))
        out = np.zeros(parts.INSTANT)
        for time in np.linspace(0.0, times[-1], 3000, endpoint=False):
            motion_at(path, 0, time, out)
            now = out[parts.RATES_AT : parts.INSTANT].reshape(2, 6)
            found = np.maximum(found, np.abs(now))
        assert (found <= [rates, changes]).all()
        ways = [1, 3, 4]  # of the table alone
        assert found[:, ways] == pytest.approx(np.array([rates, changes])[:, ways], rel=0.02)
