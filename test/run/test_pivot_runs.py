# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A pivoted body in a run: recorded, replayed, turned around by `inverse`."""

import numpy as np
import pytest

from rigid_body_sim.physics.model import rotation
from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.bag_reader import Bag

from .conftest import SCENES

COMMANDS = """time,body,kind,frame,fx,fy,fz,tx,ty,tz
0.05,top,wrench,world,1,0,0,0,0,0
0.10,top,torque,body,0,0,0,0.01,0,0
0.15,top,impulse,world,0.3,0,0,0,0.1,0
0.20,top,wrench,world,0,0,0,0,0,0
"""


@pytest.mark.parametrize('integrator', [None, 'rk8'])
def test_replay_of_a_commanded_top_is_identical(verb, as_json, tmp_path, integrator):
    (tmp_path / 'commands.csv').write_text(COMMANDS)
    words = ['--duration', 0.6, '--commands', tmp_path / 'commands.csv']
    words += ['--integrator', integrator] if integrator else []
    assert verb('simulate', SCENES / 'heavy_top.yaml', '-o', tmp_path / 'b', *words)[0] == 0
    code, result = as_json('replay', tmp_path / 'b')
    assert (code, result['identical'], result['ticks']) == (0, True, 60)


def columns(bag, topic):
    kind = bag.topics[topic].type
    decoded = [cdr.decode(kind, message.data) for message in bag.messages([topic])]
    return np.array([[x for name, _ in d.PARTS for x in getattr(d, name)] for d in decoded])


def test_inverse_finds_the_force_of_the_pivot(verb, tmp_path):
    """N = m (a - g) and torque a x N about the centre of mass; steady precession: a = -W^2 rho."""
    words = ('--duration', 3)
    assert verb('simulate', SCENES / 'heavy_top.yaml', '-o', tmp_path / 'b', *words)[0] == 0
    assert verb('inverse', tmp_path / 'b', '-o', tmp_path / 'i')[0] == 0
    bag = Bag(tmp_path / 'i')
    pose, wrench = columns(bag, '/top/pose'), columns(bag, '/top/wrench')
    inner = slice(20, -20)  # a spline is worst at its ends
    center = pose[inner, :3]
    force = -4.0 * center * (1.0, 1.0, 0.0) + (0.0, 0.0, 9.81)
    # of a spline of degree five through samples 0.2 rad of spin apart
    assert np.allclose(wrench[inner, :3], force, atol=1e-6)
    assert np.allclose(wrench[inner, 3:], np.cross(-center, force), atol=5e-3)
    assert np.allclose(rotation.rotate(pose[inner, 3:], (0, 0, 0.5)), center, atol=1e-12)
