# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A rate damper stops a tumbling satellite: its rates decay within 0.35 kg m^2 / 0.9 N m s."""

import numpy as np


def test_the_damper_stops_the_satellite(simulation):
    def damper(state):
        return {'satellite/torque': -0.9 * state['satellite'].angular_velocity}

    sim = simulation('satellite', lockstep=['satellite/torque'])
    end = sim.lockstep(damper, until=5.0)
    assert np.linalg.norm(end['satellite'].angular_velocity) < 1e-6  # rad/s
    assert sim.bag().counts['/satellite/torque'] == 500  # one a period of 0.01 s
