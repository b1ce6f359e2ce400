# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Which result a state that is asked of an entity gets, judged without a node: a pose that is none is
told apart from a pose that is well and cannot be given.
"""

import math

import pytest

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.ros.inbox import Inbox
from rigid_body_sim.ros.run_loop import Visit
from rigid_body_sim.ros.standard.messages import EntityMotion, MotionAsked
from rigid_body_sim.ros.standard.services import _put
from rigid_body_sim.runs.run import Run, RunSettings
from rigid_body_sim.runs.view import ViewSettings

SCENE = {
    'dt': 0.01,
    'bodies': [
        {'name': 'box', 'mass': 2.0, 'shape': {'type': 'box', 'size': [0.4, 0.2, 0.1]}},
        {'name': 'stone', 'mass': 0.5, 'shape': {'type': 'particle'}},
        {
            'name': 'top',
            'mass': 1.0,
            'inertia': {'ixx': 0.02, 'iyy': 0.02, 'izz': 0.01},
            'pivot': {'point': [0, 0, -0.2], 'at': [0, 0, 1]},
        },
    ],
}
SAME = (0.0, 0.0, 0.0, 1.0)
TURN = (0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5))


def put(entity, position=(0.0, 0.0, 0.0), orientation=SAME, linear=(0.0, 0.0, 0.0), **told):
    """Ask for a state of an entity; whether its pose is called bad, and why it is refused."""
    topics = told.pop('body_topics', '*')
    run = Run(Simulation(load_scene(SCENE)), RunSettings(view=ViewSettings(body_topics=topics)))
    visit = Visit(run, Inbox(run.rules), held=True, paused=True, stepping=False, ask=None)
    motion = EntityMotion(position, orientation, linear, (0.0, 0.0, 0.0))
    told = {'pose': True, 'twist': True} | told
    index = [body.name for body in run.simulation.scene.bodies].index(entity)
    return _put(MotionAsked(entity, '', motion, acceleration=False, **told), index, visit)


@pytest.mark.parametrize(
    ('entity', 'asked', 'reason'),
    [
        ('box', {'position': (math.nan, 0, 0)}, 'three finite numbers'),
        ('box', {'position': (1e308, 0, 0)}, 'no finite energy'),
        ('box', {'orientation': (0, 0, 0, 0)}, 'zero length'),
        ('stone', {'orientation': TURN}, 'point mass'),
        ('top', {'position': (0, 0, 5)}, 'tear it off its pivot'),
    ],
)
def test_a_pose_that_the_body_cannot_have_is_an_invalid_pose(entity, asked, reason):
    is_bad, said = put(entity, **asked)
    assert is_bad
    assert reason in said


@pytest.mark.parametrize(
    ('entity', 'asked', 'reason'),
    [
        ('box', {'body_topics': 'stone'}, 'takes no commands'),
        ('box', {'body_topics': 'none'}, 'takes no commands'),
        ('box', {'linear': (math.inf, 0, 0)}, 'three finite numbers'),
        ('box', {'linear': (1e200, 0, 0), 'pose': False}, 'no finite energy'),
        ('top', {'linear': (1.0, 0, 0), 'pose': False}, 'tear it off its pivot'),
    ],
)
def test_a_pose_that_is_well_is_not_called_invalid_whatever_else_is_wrong(entity, asked, reason):
    is_bad, said = put(entity, **asked)
    assert not is_bad
    assert reason in said


def test_what_can_be_given_is_given():
    assert put('box', position=(1.0, 2.0, 3.0), orientation=TURN) == (False, None)
