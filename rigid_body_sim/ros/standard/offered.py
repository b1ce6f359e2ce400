# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Which services of `simulation_interfaces` there are, their names, and what they do here.

Names are those of the types, in the node's own name space (`~/step_simulation`). The standard
leaves them open; Gazebo's are below its node too, Isaac Sim and O3DE have one simulator in a
domain and theirs at the root, where `-r ~/step_simulation:=/step_simulation` puts these.

What the standard has and no service here serves: spawning, deleting, worlds, SetEntityInfo, bounds
of named poses (a pose here has none).
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Service:
    """
    One of the services.

    type     : in simulation_interfaces/srv, or /action
    name     : below the node
    features : what SimulatorFeatures calls it; those that the installed version knows are told
    meaning  : what it does here, for the documentation
    """

    type: str
    name: str
    features: tuple[str, ...]
    meaning: str


SERVICES = (
    Service('GetSimulatorFeatures', 'get_simulator_features', (), 'what is supported'),
    Service(
        'GetSimulationState',
        'get_simulation_state',
        ('SIMULATION_STATE_GETTING',),
        'playing (also while steps are done) or paused',
    ),
    Service(
        'SetSimulationState',
        'set_simulation_state',
        ('SIMULATION_STATE_SETTING', 'SIMULATION_STATE_PAUSE'),
        'playing, paused or quitting; stopped is not supported, as time goes on',
    ),
    Service(
        'ResetSimulation',
        'reset_simulation',
        ('SIMULATION_RESET', 'SIMULATION_RESET_STATE'),
        'every body back to its start, SCOPE_STATE; time goes on, so no other scope is supported',
    ),
    Service(
        'StepSimulation',
        'step_simulation',
        ('STEP_SIMULATION_SINGLE', 'STEP_SIMULATION_MULTIPLE'),
        'so many ticks, in lock-step periods, while paused; answered with the last',
    ),
    Service(
        'SimulateSteps',
        'simulate_steps',
        ('STEP_SIMULATION_ACTION',),
        'the same as an action, with feedback after each step (after every thousandth part where '
        'there are more than 1000), to be cancelled',
    ),
    Service(
        'GetEntities',
        'get_entities',
        ('ENTITY_CATEGORIES', 'ENTITY_TAGS', 'ENTITY_BOUNDS_BOX'),
        'names of the bodies that meet the filters: name, category, tags, bounds (sphere, box)',
    ),
    Service(
        'GetEntitiesStates',
        'get_entities_states',
        ('ENTITY_STATE_GETTING',),
        'those bodies and their states',
    ),
    Service('GetEntityInfo', 'get_entity_info', ('ENTITY_INFO_GETTING',), 'category, tags, words'),
    Service(
        'GetEntityState',
        'get_entity_state',
        ('ENTITY_STATE_GETTING',),
        'pose, twist and acceleration of the centre of mass, world axes',
    ),
    Service(
        'SetEntityState',
        'set_entity_state',
        ('ENTITY_STATE_SETTING',),
        'the same as a message on `<body>/set_state`: recorded, and replayed',
    ),
    Service(
        'GetEntityBounds',
        'get_entity_bounds',
        ('ENTITY_BOUNDS',),
        'the box around a body, from its centre of mass in body axes',
    ),
    Service(
        'GetNamedPoses',
        'get_named_poses',
        ('NAMED_POSES',),
        'where each body starts, and the named frames of fixed bodies',
    ),
)
ACTION = 'SimulateSteps'
INFO = (
    'entities are the bodies of the scene, at their centres of mass; a step is a tick, in '
    'lock-step a period; simulation time goes on at a reset; what is set holds from the next tick '
    'on; accelerations count contacts by their impulse over the last tick'
)
