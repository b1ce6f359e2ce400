# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Runs that share a simulation: the same bits as one by one, whatever their neighbours do; and who
may not share one.

Equality is to the bit: nothing is rounded otherwise, so there is no tolerance.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rigid_body_sim import load_scene, normal, random_rotation, uniform
from rigid_body_sim.physics.integration.integrators import INTEGRATORS
from rigid_body_sim.sweeps import rows
from rigid_body_sim.sweeps.packs import pack_key
from rigid_body_sim.sweeps.plan import plan_sweep
from rigid_body_sim.sweeps.rows import rows_of, same_bits

from .conftest import scene

SPRING = {'type': 'spring', 'a': 'ball', 'b': 'tumbler', 'b_point': [0.1, 0.2, 0.0],
          'stiffness': 40.0, 'rest_length': 0.7}  # fmt: skip
TO_WORLD = {'type': 'spring', 'a': 'ball', 'b': 'world', 'b_point': [1, 0, 1], 'stiffness': 20.0}
DRAG = {'type': 'drag', 'body': 'ball', 'linear': 0.2}
VARY = {
    'tumbler.mass': uniform(1, 3),
    'tumbler.initial.angular_velocity_body': normal(0.0, 3.0),
    'tumbler.initial.orientation': random_rotation(),
    'ball.initial.position': normal(0.0, 1.0),
}
PACKABLE = ('dmv6', 'dmv2', 'exact_rotor', 'lie_rk4', 'rk4', 'semi_implicit_euler', 'taylor16')


def both_ways(source, vary, runs, **more):
    """Rows of runs side by side, and one by one; the notes of the former."""
    sweep = plan_sweep(source, vary, runs=runs, **{'duration': 0.5, **more})
    together, notes = rows_of(sweep, range(runs))
    alone, _ = rows_of(sweep, range(runs), pack=False)
    return together, alone, notes


def assert_same(together, alone):
    """Compare rows by their bits."""
    different = [a['run'] for a, b in zip(together, alone, strict=True) if not same_bits(a, b)]
    assert not different


@pytest.mark.parametrize('draws', [3, pytest.param(12, marks=pytest.mark.long)])
def test_runs_side_by_side_have_the_bits_of_runs_alone(draws):
    @settings(max_examples=draws)
    @given(
        method=st.sampled_from(PACKABLE),
        forces=st.sampled_from([[], [SPRING], [TO_WORLD, SPRING]]),
        gravity=st.sampled_from([[0, 0, 0], [0.1, 0, -9.81]]),
        runs=st.integers(2, 70),
        seed=st.integers(0, 2**32),
    )
    def holds(method, forces, gravity, runs, seed):
        source = scene(integrator=method, forces=forces, gravity=gravity)
        together, alone, notes = both_ways(source, VARY, runs, seed=seed, duration=0.2)
        assert notes == [] and {row['status'] for row in together} == {'done'}
        assert_same(together, alone)

    holds()


def test_bodies_on_pivots_and_fixed_ones_are_packed_too():
    pendulum = {
        'name': 'rod',
        'shape': {'type': 'box', 'size': [0.1, 0.1, 1.0]},
        'mass': 1.0,
        'pivot': {'point': [0, 0, 0.5], 'at': [0, 0, 2]},
    }
    post = {'name': 'post', 'shape': {'type': 'box', 'size': [1, 1, 1]}, 'fixed': True}
    source = scene(bodies=[post, pendulum], gravity=[0, 0, -9.81])
    vary = {'rod.initial.angular_velocity_body': normal(0.0, 1.0)}
    together, alone, notes = both_ways(source, vary, 12)
    assert notes == [] and 'post.position.x' not in together[0]
    assert_same(together, alone)


def test_without_energies_also_what_brakes_is_packed():
    source = scene(forces=[DRAG])
    vary = {'forces[0].linear': uniform(0.1, 1.0), 'ball.initial.velocity': normal(0.0, 1.0)}
    kept = {'keep': ['last', 'extremes']}
    sweep = plan_sweep(source, vary, runs=30, **kept)
    key = pack_key(sweep.scene(sweep.values(0)), energy=False)
    assert key is not None and key == pack_key(sweep.scene(sweep.values(1)), energy=False)
    together, alone, notes = both_ways(source, vary, 30, **kept)
    assert notes == []
    assert_same(together, alone)


@pytest.mark.parametrize('name', INTEGRATORS)
def test_methods_that_decide_for_all_bodies_at_once_are_not_packed(name):
    method = INTEGRATORS[name]
    key = pack_key(load_scene(scene(integrator=name)), energy=True)
    decides = method.controls_its_error or method.wants_derivatives or method.plan is not None
    assert (key is None) == (decides or method.is_reference)


@pytest.mark.parametrize(
    'more',
    [
        {'integrator': 'auto'},
        {'integrator': {'name': 'rk4', 'orientation': 'matrix'}},
        {'contact': {'mode': 'timestep'}},
        {'forces': [DRAG]},
        {'forces': [{'type': 'time', 'body': 'ball', 'table': [[0, 0, 0, 0], [1, 1, 0, 0]]}]},
        {'forces': [{'type': 'constant', 'body': 'tumbler', 'force': [1, 0, 0], 'frame': 'body'}]},
    ],
)
def test_scenes_in_which_something_is_of_the_whole_are_not_packed(more):
    assert pack_key(load_scene(scene(**more)), energy=True) is None


@pytest.mark.parametrize(
    'more',
    [
        {'dt': 0.02},
        {'integrator': 'dmv4'},
        {'integrator': {'name': 'dmv6', 'substeps': 2}},
        {'gravity': [0, 0, 1]},
        {'forces': [SPRING]},
    ],
)
def test_who_differs_in_what_is_of_the_scene_shares_no_simulation(more):
    assert pack_key(load_scene(scene(**more)), energy=True) != pack_key(
        load_scene(scene()), energy=True
    )


def test_steps_and_methods_that_vary_part_the_runs_into_packs():
    vary = {'dt': [0.01, 0.02], 'integrator': ['dmv6', 'rk4'], 'tumbler.mass': '1:2:6'}
    together, alone, notes = both_ways(scene(), vary, 24)
    assert notes == [] and [row['ticks'] for row in together] == [50] * 12 + [25] * 12
    assert_same(together, alone)


def test_runs_that_diverge_or_make_no_scene_disturb_no_neighbour():
    # a spring of 1e9 N/m on half a kilogram leaves the numbers within some ticks of 0.01 s
    source = scene(forces=[TO_WORLD], integrator='semi_implicit_euler')
    stiffness = [20.0, 1e9, 30.0, -1.0, 2e7, *[40.0 + i for i in range(5)]]
    together, alone, notes = both_ways(source, {'forces[0].stiffness': stiffness}, 10, duration=3)
    assert notes == []
    assert_same(together, alone)
    status = [row['status'] for row in together]
    assert status[:5] == ['done', 'diverged', 'done', 'refused', 'diverged']
    assert set(status[5:]) == {'done'}
    gone, bad = together[1], together[3]
    assert "'ball' diverged in tick" in gone['reason'] and 0 < gone['ticks'] < 300
    assert np.isfinite(gone['ball.position.x'])
    assert 'forces[0].stiffness' in bad['reason'] and bad['ticks'] == 0


def test_where_most_diverge_all_are_made_alone():
    source = scene(forces=[TO_WORLD], integrator='semi_implicit_euler')
    vary = {'forces[0].stiffness': [20.0, *[1e9 * (i + 1) for i in range(2 * rows.MOST_EVICTED)]]}
    together, alone, _ = both_ways(source, vary, 2 * rows.MOST_EVICTED + 1, duration=3)
    assert_same(together, alone)
    assert [row['status'] for row in together].count('diverged') == 2 * rows.MOST_EVICTED


def test_what_the_physics_refuses_late_is_a_row_with_its_place():
    # only a run knows that linear_propagator takes no rigid body that tumbles under a spring
    source = scene(forces=[SPRING])
    vary = {'integrator': ['dmv6', 'linear_propagator'], 'tumbler.mass': [1.0, 2.0]}
    together, alone, _ = both_ways(source, vary, 4)
    assert_same(together, alone)
    assert [row['status'] for row in together] == ['done', 'done', 'refused', 'refused']
    assert together[2]['reason'].startswith('scene: integrator: ')


def test_a_run_beyond_the_limits_of_its_method_says_so_in_its_row():
    source = scene(forces=[TO_WORLD], integrator='rk4')
    vary = {'forces[0].stiffness': [20.0, 1.2e4, 25.0]}  # h omega = 1.5: rk4 loses the swing
    together, alone, _ = both_ways(source, vary, 3)
    assert_same(together, alone)
    lone = plan_sweep(source, vary, runs=3)
    assert rows_of(lone, [1], pack=False)[0][0]['warnings'] == together[1]['warnings']
    assert together[0]['warnings'] is None


def test_a_run_that_loses_what_nothing_took_says_so_in_its_row_and_one_that_swings_does_not():
    swinging = {
        'dt': 0.01,
        'bodies': [
            {'name': 'ball', 'shape': {'type': 'particle'}, 'mass': 1.0,
             'initial': {'position': [1, 0, 0]}},
        ],
        'forces': [
            {'type': 'spring', 'a': 'ball', 'b': 'world', 'b_point': [0, 0, 0],
             'stiffness': 1e4},
        ],
    }  # fmt: skip
    for method, stiffness, loses in (
        ('rk4', 1e4, True),
        ('rk4', 1e2, False),
        ('dmv6', 1e3, False),
    ):
        swinging['integrator'] = method
        varied = {'forces[0].stiffness': [stiffness, 1.01 * stiffness]}
        together, alone, _ = both_ways(swinging, varied, 2, duration=1.0)
        assert_same(together, alone)
        for row in together:
            assert ('which no force, damper or command took' in (row['warnings'] or '')) == loses


def test_a_pack_that_came_out_otherwise_is_made_again_one_by_one(monkeypatch):
    sweep = plan_sweep(scene(), VARY, runs=6, duration=0.2)
    alone, _ = rows_of(sweep, range(6), pack=False)
    true_rows = rows.Pack.rows

    def slightly_wrong(self):
        for row in true_rows(self):
            if len(self.runs) > 1:
                row['ball.position.x'] = np.nextafter(row['ball.position.x'], 2.0).item()
            yield row

    monkeypatch.setattr(rows.Pack, 'rows', slightly_wrong)
    together, notes = rows_of(sweep, range(6))
    assert_same(together, alone)
    assert len(notes) == 1 and 'one by one' in notes[0]


def test_energy_of_a_quiet_scene_is_that_of_the_simulation():
    from rigid_body_sim import Simulation

    source = scene(forces=[SPRING], gravity=[0, 0, -9.81])
    sweep = plan_sweep(source, {'tumbler.mass': [2.0]}, duration=0.5)
    row = rows_of(sweep, [0])[0][0]
    simulation = Simulation(load_scene(source))
    simulation.keep_energy_balance()
    for _ in range(10):
        simulation.step(5)
        simulation.look_at_energy()
    balance = simulation.energy_balance()
    # the same sums in another order: round-off of energies of some joules
    assert row['energy.defect'] == pytest.approx(balance.defect, abs=1e-13)
    assert row['energy.turnover'] == pytest.approx(balance.turnover, rel=1e-2)  # other looks
    assert row['energy.dissipation'] == 0.0
    assert row['ball.position.z'] == simulation.state.position[1, 2]
