# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Change of energy = work of commands + of drives - dissipation + defect; and who keeps momentum.

The long form, on random scenes and against DOP853: benchmark/energy_balance.py.
"""

import copy

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import expm

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.physics.diagnostics.conserved_groups import ConservedGroups, GroupDrifts
from rigid_body_sim.physics.diagnostics.energy_balance import EnergyBalance
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.scene.shipped_scenes import find_scene
from test.integrators.scenes import linked_bodies, oscillator, scene, top

DAMPING = 0.6


def kept(sim: Simulation) -> Simulation:
    sim.keep_energy_balance()
    return sim


def closes(balance: EnergyBalance) -> bool:
    works = balance.work_of_commands + balance.work_of_drives - balance.dissipation
    return balance.change == pytest.approx(works - balance.contact + balance.defect, abs=1e-12)


def defect_of_damped_oscillator(name: str, dt: float) -> tuple[float, float]:
    """The defect of a damped oscillator that is pushed, and the sum of what each step did."""
    sim = kept(Simulation(oscillator(dt=dt, damping=DAMPING), integrator=name))
    force = (0.7, 0.0, 0.0)
    flow = expm(dt * np.array([[0.0, 1.0, 0.0], [-4.0, -DAMPING, 0.7], [0.0, 0.0, 0.0]]))
    by_hand = 0.0
    for number in range(round(2.0 / dt)):
        if number == round(1.0 / dt):
            sim.set_wrench('ball', force=force)
        state = np.array(
            [sim.state.position[0, 0], sim.state.velocity[0, 0], float(number * dt >= 0.9999)]
        )
        exact = flow @ state
        sim.step()
        by_hand += sim.energy() - (2.0 * exact[0] ** 2 + 0.5 * exact[1] ** 2)
    balance = sim.energy_balance()
    assert closes(balance) and balance.gain is None
    return balance.defect, by_hand


@pytest.mark.usefixtures('plain_source')
@pytest.mark.parametrize(('name', 'order'), [('explicit_euler', 1), ('dmv6', 2), ('rk4', 4)])
def test_the_defect_is_what_the_steps_did_and_vanishes_with_the_order(name, order):
    """Against the exact flow from each state of the run, which knows all work of a tick."""
    coarse, by_hand = defect_of_damped_oscillator(name, 0.04)
    fine, fine_by_hand = defect_of_damped_oscillator(name, 0.02)
    # the work along the run and that along the flow differ by one order more
    assert coarse == pytest.approx(by_hand, rel=0.2)
    assert fine == pytest.approx(fine_by_hand, rel=0.1)
    assert np.log2(coarse / fine) == pytest.approx(order, abs=0.35)


@pytest.mark.parametrize('dt', [0.05, 0.1])
def test_long_ticks_of_an_exact_method_leave_no_defect(dt):
    """
    What the quadrature of the power leaves would be called defect: a body on a spring off its
    centre turns by 0.3 to 0.6 rad of its swing in a tick, and drag takes 4 J.
    """
    body = {'name': 'b', 'mass': 1.0, 'inertia': {'ixx': 0.1, 'iyy': 0.2, 'izz': 0.25}}
    body['initial'] = {'position': [0.3, 0.1, -0.5], 'angular_velocity_body': [1.0, 2.0, -1.5]}
    spring = {'type': 'spring', 'a': 'b', 'b': 'world', 'stiffness': 40.0}
    drag = {'type': 'drag', 'body': 'b', 'linear': 0.3, 'angular': 0.02}
    hung = scene(
        [body],
        forces=[spring | {'a_point': [0.2, 0.1, 0.3]}, drag],
        dt=dt,
        gravity=(0.0, 0.0, -9.81),
    )
    tight = {'rtol': 1e-13, 'atol': 1e-15}
    sim = kept(Simulation(hung, integrator='rk45', integrator_options=tight))
    sim.step(round(4.0 / dt))
    balance = sim.energy_balance()
    assert balance.dissipation > 3.0
    # the error of the method in 4 s of 40 J that come and go, and of the quadrature as it says
    assert abs(balance.defect) < 1e-10
    assert balance.uncertainty < 1e-8


def test_held_forces_and_impulses_do_the_work_of_the_textbook():
    """A free body: F . dr and torque . dphi, and the kinetic energy of a blow, to round-off."""
    sim = kept(Simulation(top(inertia=(1.0, 1.0, 1.0), omega=(0.0, 0.0, 2.0), dt=0.01)))
    sim.set_wrench('top', force=(3.0, 0.0, 0.0), torque=(0.0, 0.0, 0.5))
    sim.step(100)
    turned = 2.0 + 0.5 * 0.5
    assert sim.energy_balance().work_of_commands == pytest.approx(
        3.0 * sim.state.position[0, 0] + 0.5 * turned, rel=1e-12
    )
    before = sim.energy_balance().work_of_commands
    sim.set_wrench('top')
    sim.apply_impulse('top', linear=(0.0, 2.0, 0.0))
    balance = sim.energy_balance()
    assert balance.work_of_commands - before == pytest.approx(2.0, rel=1e-12)
    assert abs(balance.defect) < 1e-13 and closes(balance)


@pytest.mark.usefixtures('plain_source')
@pytest.mark.parametrize('every', [1, 5, 60])
def test_a_balance_knows_the_work_on_what_bounces_to_the_jumps_of_its_power(every):
    """
    An elastic ball on smooth ground keeps its energy in event mode: what the balance cannot
    explain is that of the rule over ticks in which the velocity jumps, by 2 v.
    """
    floor = {'name': 'floor', 'shape': {'type': 'plane', 'normal': [0, 0, 1]}, 'friction': 0.0}
    ball = {
        'name': 'ball', 'shape': {'type': 'sphere', 'radius': 0.1}, 'mass': 1.0,
        'restitution': 1.0, 'friction': 0.0, 'initial': {'position': [0, 0, 0.13]},
    }  # fmt: skip
    flying = {'version': 1, 'name': 'bounces', 'dt': 0.01, 'gravity': [0, 0, -9.81]}
    flying |= {'contact': {'mode': 'event'}, 'bodies': [floor, ball]}
    sim = kept(Simulation(load_scene(flying)))
    jumps, missed = 0.0, []
    for tick in range(60):
        if tick % every == 0:
            force = 3.0 + 0.01 * (tick % 2)
            sim.set_wrench('ball', force=(0.0, 0.0, -force))
        sim.step()
        jumps += 3.01 * abs(sim.impacts().impulse[:, 2]).sum()
        balance = sim.energy_balance()
        missed.append(abs(balance.unexplained))
        assert missed[-1] <= balance.uncertainty
    assert max(missed) > 1e-3  # the rule is wrong by so much, [J] of some 0.4
    # half a tick of the jumps, and of what F v grows by in flight where each tick is a stretch
    grown = 3.01 * (9.81 + 3.01) * 0.6
    assert balance.uncertainty <= 0.5 * 0.01 * 1.1 * (jumps + grown)


@pytest.mark.usefixtures('plain_source')
@pytest.mark.parametrize('size', [1e6, 1e8, 1e150])
@pytest.mark.parametrize('how', ['struck', 'placed'])
def test_a_balance_knows_its_defect_no_better_than_what_jumps_left_of_it(how, size):
    """Energies of 5e11 J and more come and go between two looks, and are rounded."""
    ball = {'name': 'ball', 'shape': {'type': 'sphere', 'radius': 0.3}, 'mass': 1.0}
    sim = kept(Simulation(scene([ball], gravity=(0.3, 0.0, -9.81), dt=0.01)))
    for sign in (1.0, -1.0):
        if how == 'struck':
            sim.apply_impulse('ball', linear=(sign * size, 0.0, 0.0))
        else:
            sim.set_state('ball', velocity=(0.5 * (1.0 + sign) * size, 0.0, 0.0))
        sim.step(7)
    balance = sim.energy_balance()
    assert abs(balance.defect) <= balance.uncertainty
    assert balance.uncertainty <= 1e-14 * size**2


def test_it_changes_no_bit_and_does_not_depend_on_how_ticks_are_asked_for():
    """Balance or none, step(40) or 40 times step(), read in between or not."""
    plain, whole, single = (Simulation(linked_bodies(), integrator='rk4') for _ in range(3))
    for sim in (whole, single):
        sim.keep_energy_balance()
    for sim in (plain, whole, single):
        sim.set_wrench('box', force=(1.0, 0.0, 0.0), frame='body')
    plain.step(40)
    whole.step(40)
    for _ in range(40):
        single.step()
        single.energy_balance()
    assert plain.state_bytes() == whole.state_bytes() == single.state_bytes()
    assert whole.energy_balance() == single.energy_balance()
    assert whole.energy_balance().dissipation > 0.0


@pytest.mark.usefixtures('plain_source')
def test_a_reset_begins_a_new_balance_and_nobody_gets_one_unasked():
    sim = Simulation(oscillator(dt=0.01, damping=DAMPING))
    with pytest.raises(InvalidModel, match='keep_energy_balance'):
        sim.energy_balance()
    kept(sim).step(50)
    assert sim.energy_balance().dissipation > 0.0
    with pytest.raises(InvalidModel, match='again in a copy, a pickle or a checkpoint, which'):
        copy.copy(sim).energy_balance()
    sim.reset()
    assert sim.energy_balance().dissipation == 0.0 == sim.energy_balance().change


@pytest.mark.usefixtures('plain_source')
def test_a_passive_scene_that_gains_is_seen_and_one_that_swings_is_not():
    """Explicit Euler feeds an oscillator, kick-drift-kick does not."""
    for name, gains in (('explicit_euler', True), ('dmv6', False)):
        sim = kept(Simulation(oscillator(dt=0.04), integrator=name))
        for _ in range(20):
            sim.step(5)
            sim.look_at_energy()
        assert sim.energy_balance().gains is gains


def test_a_box_beside_a_spring_and_a_ball_keeps_what_is_its_own():
    """Of the shipped scene: nothing of the whole stays, of the box everything."""
    shipped = load_scene(find_scene('two_bodies'))
    groups = ConservedGroups(shipped)
    assert groups.laws == [((0,), 'momentum'), ((0,), 'angular momentum')]
    sim = Simulation(shipped)
    drifts = GroupDrifts(groups, sim.state, time=0.0)
    moved = sim.state
    values = moved.values.copy()
    values[0, 16:19] += (1.0, 0.0, 0.0)  # momentum of the box
    values[1, 16:19] += (9.0, 0.0, 0.0)  # of the ball
    pushed = type(moved)(values)
    drifts.sample(pushed, time=0.0, commanded={0})
    assert [law.drift for law in drifts.kept()] == [0.0, 0.0]
    drifts.sample(moved, time=0.0, commanded={1})
    momentum, angular = drifts.kept()
    assert momentum.bodies == ('box',) and momentum.drift == 1.0 and angular.drift == 0.0


def test_ties_make_groups_and_what_is_outside_ends_them():
    """Three balls in a row, the last tied to the world; a fourth on its own, spinning in drag."""
    ball = {'shape': {'type': 'sphere', 'radius': 0.1}, 'mass': 1.0}
    spring = {'type': 'spring', 'stiffness': 1.0}
    bodies = [{'name': name, **ball} for name in 'abcd']
    laws = [
        ConservedGroups(scene(bodies, forces=forces)).laws
        for forces in (
            [{**spring, 'a': 'a', 'b': 'b'}, {**spring, 'a': 'c', 'b': 'world'}],
            [{**spring, 'a': 'a', 'b': 'b', 'a_point': [0.1, 0, 0]},
             {**spring, 'a': 'b', 'b': 'world'}, {'type': 'drag', 'body': 'd', 'linear': 1.0}],
        )
    ]  # fmt: skip
    assert laws[0] == [
        ((0, 1), 'momentum'), ((3,), 'momentum'), ((0, 1), 'angular momentum'),
        ((3,), 'angular momentum'), ((0,), 'own angular momentum'), ((1,), 'own angular momentum'),
        ((2,), 'own angular momentum'),
    ]  # fmt: skip
    assert laws[1] == [
        ((2,), 'momentum'), ((2,), 'angular momentum'), ((1,), 'own angular momentum'),
        ((3,), 'own angular momentum'),
    ]  # fmt: skip


@pytest.mark.usefixtures('plain_source')
def test_a_rocket_brings_the_energy_of_its_thrust_and_of_what_it_loses():
    """The work of the drive is the change of energy, through the burn-out too."""
    body = {
        'name': 'rocket', 'shape': {'type': 'particle'}, 'mass': 2.0, 'mass_rate': -1.0,
        'exhaust_velocity': [0.0, 0.0, -50.0], 'final_mass': 1.505,
    }  # fmt: skip
    sim = kept(Simulation(scene([body], dt=0.01, gravity=(0.0, 0.0, -9.81)), integrator='rk4'))
    sim.step(60)
    balance = sim.energy_balance()
    assert_allclose(balance.work_of_drives, balance.change, rtol=1e-9)
    assert balance.gain is None


@pytest.mark.usefixtures('plain_source')
def test_what_has_a_potential_does_no_work_as_a_drive_where_masses_flow():
    """
    A ball that loses mass runs into a bumper: what the bumper takes stands in the energy, and is
    given back. Counted as a drive as well, it would leave the 2 J that it holds as defect.
    """
    balls = [
        {'name': name, 'mass': 1.0, 'shape': {'type': 'particle'}, 'initial': initial}
        for name, initial in (('a', {'velocity': [1.0, 0.0, 0.0]}), ('b', {'position': [1, 0, 0]}))
    ]
    balls[0]['mass_rate'] = -0.1
    bumper = {'type': 'bumper', 'a': 'a', 'b': 'b', 'stiffness': 20.0, 'length': 1.5}
    sim = kept(Simulation(scene(balls, forces=[bumper], dt=0.01), integrator='rk8'))
    sim.step(25)  # they still touch: no kink
    balance = sim.energy_balance()
    assert closes(balance)
    # what is left is rounding; the mass that leaves takes 0.1 kg/s v^2 / 2 with it, nothing else
    assert abs(balance.defect) < 1e-12
    assert -0.015 - 1e-12 < balance.work_of_drives < 0.0
