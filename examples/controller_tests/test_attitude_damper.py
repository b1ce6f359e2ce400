# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A rate damper stops a tumbling satellite: the slowest axis decays with 0.35 / 0.9 s."""

import numpy as np


def test_damper_stops_the_satellite(simulation):
    def damper(state):
        return {'satellite/torque': -0.9 * state['satellite'].angular_velocity}

    sim = simulation('satellite', lockstep=['satellite/torque'])
    end = sim.lockstep(damper, until=20.0)
    assert np.linalg.norm(end['satellite'].angular_velocity) < 1e-6
    assert sim.bag().counts['/satellite/torque'] == 2000
