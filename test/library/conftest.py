# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Runs with everything that may be commanded, and bags of them."""

import pytest

import rigid_body_sim as rbs

VECTORS = ('position', 'orientation', 'velocity', 'angular_velocity', 'force', 'torque')


def damper(t, state):
    """Brake the satellite, push the beacon now and then, and let go of all for a while."""
    if 0.3 < t < 0.5:
        return None
    torque = -0.5 * state['satellite'].angular_velocity_body
    asked = {'satellite': rbs.Wrench(force=(1, 0, 0), torque=torque, frame='body')}
    return asked | ({'beacon': rbs.Wrench(force=(0, t, 0))} if int(10 * t) % 2 else {})


def same_bits(a, b):
    """Whether two arrays are the same to the bit."""
    return a.shape == b.shape and a.tobytes() == b.tobytes()


@pytest.fixture(scope='module')
def run():
    """A second of the satellite under `damper`, rows every 0.05 s."""
    return rbs.simulate('satellite', 1, every=0.05, controller=damper)


@pytest.fixture(scope='module')
def bag(run, tmp_path_factory):
    """The bag of `run`."""
    path = tmp_path_factory.mktemp('run') / 'bag'
    run.save(path)
    return path
