# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A controller that asks for other numbers in each tick gets the bits of commands put anew."""

from typing import Any

import numpy as np
import pytest

from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.scene import load_scene

SIZES = ([1, 0.5, 0.3], [0.2, 0.5, 0.3])


def scene(**more: Any) -> Any:
    """Describe two boxes; the principal axes of the second are not those of the body."""
    bodies: list[dict[str, Any]] = [
        {'name': name, 'shape': {'type': 'box', 'size': size}, 'mass': 1.5,
         'initial': {'position': [3 * i, 0, 0.15], 'angular_velocity': [0.3, 1.0, 0.5]}}
        for i, (name, size) in enumerate(zip(('left', 'right'), SIZES, strict=True))
    ]  # fmt: skip
    bodies[1]['inertia'] = {
        'ixx': 0.4, 'iyy': 0.3, 'izz': 0.5, 'ixy': 0.05, 'ixz': 0.02, 'iyz': 0.01,
    }  # fmt: skip
    return load_scene({'dt': 0.004, 'bodies': bodies, **more})


def given(tick: int) -> tuple[Any, Any]:
    """Give a force and a torque for a tick, as arrays, lists or tuples."""
    draw = np.random.default_rng(tick)
    force, torque = draw.normal(size=(2, 3))
    kinds = (np.asarray, list, tuple, lambda values: tuple(map(float, values)))
    return kinds[tick % 4](force), kinds[(tick + 1) % 4](torque)


SCENES = {
    'free': {},
    'drag': {'forces': [{'type': 'drag', 'body': 'right', 'linear': 0.1, 'angular': 0.1}]},
}


@pytest.mark.parametrize(
    ('frame', 'metered'),
    [
        ('world', False), ('body', True),
        pytest.param('world', True, marks=pytest.mark.long),
        pytest.param('body', False, marks=pytest.mark.long),
    ],
)  # fmt: skip
@pytest.mark.parametrize('name', SCENES)
def test_other_numbers_in_each_tick_act_as_commands_put_anew(name, frame, metered):
    """Put anew: a copy of the simulation, which has forgotten how it wrote the last ones."""
    steady, anew = Simulation(scene(**SCENES[name])), Simulation(scene(**SCENES[name]))
    if metered:
        steady.keep_energy_balance()
    for tick in range(24):
        for simulation in (steady, anew):
            force, torque = given(tick)
            simulation.set_wrench('right', force=force, torque=torque, frame=frame)
            if tick % 7 == 3:  # another source comes, beside it, and goes
                simulation.hold('right', 'force', force=(1, 0, 0), until=tick + 2)
            if tick % 5 == 1:
                simulation.set_wrench('left', force=force, frame='body')
            if tick % 11 == 10:
                simulation.set_wrench('right')  # lets go
            simulation.step()
        assert steady.state_bytes() == anew.state_bytes()
        assert steady.held_slots == anew.held_slots
        assert np.array_equal(steady.applied_wrench(), anew.applied_wrench())
        kept = Simulation(scene(**SCENES[name]))
        kept.restore(tick=anew.tick, state=anew.state_bytes(), slots=anew.held_slots)
        anew = kept


def test_what_is_no_command_changes_nothing_after_many_that_were():
    sim = Simulation(scene())
    for tick in range(4):
        sim.set_wrench('left', force=given(tick)[0])
        sim.step()
    before = sim.held_slots, sim.state_bytes()
    for wrong in ((1, 2), (1, 2, float('nan')), 'abc', None, 3.0, np.zeros((3, 1)), (1, 2, True),
                  np.float64(2.0), (1e308, 1e308, float('inf'))):  # fmt: skip
        with pytest.raises(Exception, match='three finite numbers'):
            sim.set_wrench('left', force=wrong)
        assert (sim.held_slots, sim.state_bytes()) == before
    sim.set_wrench('left', force=(1e308, 1e308, 1e308))  # their sum is none, but they are numbers
    assert sim.applied_wrench()[0][0].tolist() == [1e308] * 3


def test_a_command_that_comes_twice_before_a_tick_is_the_last_one():
    sim, once = Simulation(scene()), Simulation(scene())
    for tick in range(6):
        for force in ((9, 9, 9), (0, 0, 0), (1.0 + tick, 0, 0)):
            sim.set_wrench('left', force=force)
        once.set_wrench('left', force=(1.0 + tick, 0, 0))
        sim.step()
        once.step()
        assert sim.state_bytes() == once.state_bytes()


def test_who_asks_for_nothing_again_and_again_lets_go_of_what_came_between():
    sim, kept = Simulation(scene()), {}
    for between in ('rows', 'slots', 'nothing', 'frame'):
        for _ in range(3):
            sim.set_wrench('left', force=(0.0, -0.0, 0.0))
            sim.step()
        if between == 'rows':
            sim.set_wrenches(force=np.ones((2, 3)))
        elif between == 'slots':
            sim.restore(tick=sim.tick, state=sim.state_bytes(), slots=kept)
        elif between == 'frame':
            sim.set_wrench('left', torque=(1, 0, 0), frame='body')
        kept = sim.held_slots
        sim.set_wrench('left', force=(0.0, 0.0, 0.0))
        assert not sim.applied_wrench()[0][0].any()
        assert {core for core, _ in sim.held_slots} <= {1}
        assert sim.applied_wrench()[0][1].tolist() == [1, 1, 1]  # of the other body
