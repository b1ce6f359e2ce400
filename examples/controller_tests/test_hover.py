# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A drone of 1.2 kg climbs from the ground to two metres, against gravity, and hovers."""

BODY = {'name': 'drone', 'mass': 1.2, 'shape': {'type': 'sphere', 'radius': 0.2}}
SCENE = {'dt': 0.01, 'gravity': [0, 0, -9.81], 'bodies': [BODY]}


def test_the_drone_hovers_at_two_metres(simulation):
    def lift(state):
        height, climb = state['drone'].position[2], state['drone'].velocity[2]
        return {'drone/force': (0, 0, 1.2 * 9.81 + 12.0 * (2.0 - height) - 7.0 * climb)}

    end = simulation(SCENE, lockstep=['drone/force']).lockstep(lift, until=6.0)
    assert abs(end['drone'].position[2] - 2.0) < 1e-6  # m; e^(-17) is left
