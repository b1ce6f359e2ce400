# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A changed command writes the lanes of its body and no others: after any history of commands a tick
does what it does in a simulation that is told all of them at once.
"""

import random

import pytest

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.physics.errors import InvalidModel

BODIES = 67  # a block of 64, and some beyond it
SOURCES = ('force', 'torque', 'wrench')


def scene(springs):
    boxes = [
        {
            'name': f'b{i}',
            'shape': {'type': 'box', 'size': [0.4, 0.2, 0.1]},
            'mass': 1.0 + 0.1 * i,
            'initial': {'position': [2.0 * i, 0, 0], 'angular_velocity': [0.3, 1.0, 0.1 * i]},
        }
        for i in range(BODIES)
    ]
    turned = {'ixx': 1.0, 'iyy': 1.2, 'izz': 1.4, 'ixy': 0.2}  # principal axes of its own
    boxes.append({'name': 'turned', 'mass': 2.0, 'inertia': turned})
    ball = {'name': 'ball', 'shape': {'type': 'particle'}, 'mass': 0.5}
    spring = {'type': 'spring', 'a': 'b0', 'b': 'ball', 'stiffness': 5.0, 'damping': 0.1}
    ground = {'name': 'ground', 'shape': {'type': 'box', 'size': [1, 1, 1]}, 'fixed': True}
    return load_scene(
        {
            'dt': 0.001,
            'gravity': [0, 0, -9.81],
            'bodies': [ground, *boxes, ball],
            'forces': [spring] if springs else [],
        }
    )


def command(sim, draw):
    """
    Give one command of any kind.
    """

    def vector():
        return [draw.choice((0.0, -0.0, 1, draw.uniform(-1, 1))) for _ in range(3)]

    names = ['b0', 'b1', 'b63', 'b64', 'turned', 'ball']
    body = draw.choice(names)
    is_point = body == 'ball'
    frame = 'world' if is_point else draw.choice(('world', 'body'))
    asked = {'force': vector(), 'torque': (0, 0, 0) if is_point else vector(), 'frame': frame}
    kind = draw.randrange(6)
    if kind < 2:
        sim.set_wrench(body, **asked)
    elif kind == 2:
        until = sim.tick + draw.randrange(1, 6)
        sim.hold(body, draw.choice(SOURCES), **asked, until=until)
    elif kind == 3:
        sim.set_wrench(body)
    elif kind == 4:
        bodies = sim.scene.bodies
        force = [[0.0] * 3 if b.fixed else vector() for b in bodies]
        torque = [[0.0] * 3 if b.fixed or b.is_point else vector() for b in bodies]
        frame = draw.choice(('world', 'world', 'body'))
        if frame == 'body':
            force[-1] = [0.0] * 3
        sim.set_wrenches(force=force, torque=torque, frame=frame)
    else:
        with pytest.raises(InvalidModel):
            sim.set_wrench(body, force=(1.0, float('nan'), 0.0))


@pytest.mark.parametrize('springs', [False, True])
@pytest.mark.parametrize('seed', [1, pytest.param(2, marks=pytest.mark.long)])
def test_any_history_of_commands_acts_as_what_is_held_in_the_end(springs, seed):
    draw = random.Random(seed)
    sim, other = Simulation(scene(springs)), Simulation(scene(springs))
    for _ in range(120):
        for _ in range(draw.choice((0, 1, 1, 3))):
            command(sim, draw)
        held = sim.held_slots
        other.restore(tick=sim.tick, state=sim.state_bytes(), slots=held)
        ends = [slot.until for slot in held.values()]
        assert sim.next_expiry == other.next_expiry == min(ends, default=sim.next_expiry)
        ticks = draw.choice((1, 1, 2, 9))
        sim.step(ticks)
        other.step(ticks)
        assert sim.state_bytes() == other.state_bytes()
        assert sim.held_slots == other.held_slots
        for mine, of_other in zip(sim.applied_wrench(), other.applied_wrench(), strict=True):
            assert mine.tobytes() == of_other.tobytes()


def test_a_state_that_was_read_stays_while_the_run_goes_on():
    sim = Simulation(scene(springs=False))
    before = sim.state
    values = before.values.copy()
    sim.set_wrench('b0', force=(1.0, 0.0, 0.0))
    sim.step()
    assert (before.values == values).all()
    assert (sim.state.values != values).any()
    with pytest.raises(ValueError, match='read-only'):
        before.position[0] = 1.0
    with pytest.raises(AttributeError):
        before.values = values


@pytest.mark.parametrize(
    'where',
    ['free', 'springs', 'ground', pytest.param('ground', marks=pytest.mark.long, id='compiled')],
)
def test_tick_by_tick_is_what_many_ticks_are_whatever_changes_between(where, request):
    if where == 'ground':  # no other test has a kernel of contact beside what is held alone
        request.getfixturevalue('plain_source')
    box = {
        'name': 'b',
        'shape': {'type': 'box', 'size': [0.4, 0.2, 0.1]},
        'mass': 2.0,
        'initial': {'position': [0, 0, 0.06], 'angular_velocity': [0.3, 1.0, 0.5]},
    }
    told = {'dt': 0.001, 'gravity': [0, 0, -9.81], 'bodies': [box]}
    if where == 'springs':
        told['forces'] = [{'type': 'spring', 'a': 'b', 'b': 'world', 'stiffness': 5.0}]
    if where == 'ground':
        plane = {'name': 'ground', 'shape': {'type': 'plane', 'normal': [0, 0, 1]}}
        told |= {'bodies': [plane, box], 'contact': {'mode': 'timestep'}}
    changes = (
        lambda run: run.set_wrench('b', force=(1.0, 0.0, 0.0)),
        lambda run: run.set_wrench('b', force=(0.0, 1.0, 0.0), frame='body'),
        lambda run: run.keep_energy_balance(),
        lambda run: run.hold('b', 'torque', torque=(0.0, 0.0, 0.1), until=run.tick + 5),
        lambda run: run.set_state('b', velocity=(0.0, 0.0, 1.0)),
        lambda run: run.reset(),
        lambda run: run.set_wrenches(force=[[0, 0, 0]] * (len(told['bodies']) - 1) + [[1, 0, 0]]),
        lambda run: run.restore(tick=run.tick, state=run.state_bytes(), slots=run.held_slots),
    )
    whole, single = Simulation(load_scene(told)), Simulation(load_scene(told))
    for change in changes:
        whole.step(7)
        for _ in range(7):
            single.step()
        assert single.state_bytes() == whole.state_bytes()
        change(whole)
        change(single)
