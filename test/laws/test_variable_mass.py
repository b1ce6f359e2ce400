# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Bodies that lose or gain mass."""

import math

import numpy as np
import pytest

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.exact import rocket
from rigid_body_sim.physics.errors import InvalidModel, SimulationDiverged
from rigid_body_sim.physics.integration.integrators import INTEGRATORS
from rigid_body_sim.physics.model.scene import Body, MassFlow, Scene

from ..integrators.scenes import mostly_long

pytestmark = pytest.mark.usefixtures('plain_source')  # few ticks: to compile takes longer

# those whose error the tick length sets, not a tolerance
FIXED_STEP = sorted(name for name in INTEGRATORS if not INTEGRATORS[name].controls_its_error)

NAMES = sorted(name for name, method in INTEGRATORS.items() if not method.is_reference)
ROUND_OFF = 1e-12  # [-] sums over some thousand ticks
SLOPE = 0.1  # the next term of the error at the step lengths chosen
FLOW, EXHAUST, MASS, GRAVITY = 1.5, 300.0, 10.0, 9.81
POINT = {'type': 'particle'}
TANK = {'type': 'cylinder', 'radius': 0.2, 'length': 1.0}


def scene(*, dt=0.01, shape=POINT, gravity=GRAVITY, forces=(), **body):
    rocket_body = {
        'name': 'rocket',
        'mass': MASS,
        'shape': shape,
        'mass_rate': -FLOW,
        'exhaust_velocity': EXHAUST,
    }
    return load_scene(
        {
            'version': 1,
            'name': 'rocket',
            'dt': dt,
            'gravity': [0, 0, -gravity],
            'bodies': [rocket_body | body],
            'forces': list(forces),
        }
    )


def exact(t, *, final_mass=None):
    """Height and speed by Tsiolkovsky, free flight after the burn-out."""
    burnt = t if final_mass is None else min(t, (MASS - final_mass) / FLOW)
    z, v = (
        float(x[0])
        for x in rocket.ascent(
            burnt, mass=MASS, mass_flow=FLOW, exhaust_speed=EXHAUST, gravity=GRAVITY
        )
    )
    left = t - burnt
    return z + v * left - 0.5 * GRAVITY * left**2, v - GRAVITY * left


# that each scheme evaluates at its own times is seen in test_forces_over_time.py
SHORT = 'dmv6', 'rk4', 'implicit_midpoint'
CASES = [
    (POINT, None),
    (TANK, 5.5),
    (TANK, 5.5123),
]  # burn-out never, on a tick, and within a tick


@pytest.mark.parametrize(
    ('shape', 'final_mass'), CASES, ids=['point', 'tank', 'tank within a tick']
)
@pytest.mark.parametrize('name', mostly_long(FIXED_STEP, short=SHORT))
def test_a_rocket_rises_by_tsiolkovsky_with_the_order_of_the_integrator(name, shape, final_mass):
    order = INTEGRATORS[name].order
    steps = {1: (0.002, 0.001), 2: (0.02, 0.01), 4: (0.1, 0.05)}.get(order, (0.2, 0.1))
    more = {} if final_mass is None else {'final_mass': final_mass}
    errors = []
    for h in steps:
        flight = scene(dt=h, shape=shape, **more)
        refusal = INTEGRATORS[name].refuses(flight)
        if refusal is not None:
            pytest.skip(refusal)
        sim = Simulation(flight, integrator=name)
        sim.step(round(4.0 / h))
        z, v = exact(4.0, final_mass=final_mass)
        errors.append(math.hypot(sim.state.position[0, 2] - z, sim.state.velocity[0, 2] - v))
    if INTEGRATORS[name].controls_its_error:
        assert errors[0] < 1e-5  # rtol 1e-9 of a height of 1e3 m, over some twenty ticks
        return
    if errors[1] < ROUND_OFF * 1e3:
        return  # at round-off of a height of 1e3 m: nothing left to converge
    # the parts of a cut tick are shorter than h: the slope wobbles by their share of the whole
    assert math.log2(errors[0] / errors[1]) > order - (
        SLOPE if final_mass != 5.5123 else 2 * SLOPE
    )


def test_burn_out_within_a_tick_is_at_its_instant():
    """
    Seen from afar: the same speed gained whatever the tick, with a method that is exact to round-
    off here.
    """
    speeds = []
    for h in (0.05, 0.011, 0.002):
        sim = Simulation(scene(dt=h, gravity=0.0, final_mass=5.5123), integrator='rk4')
        sim.step(round(3.3 / h))
        speeds.append(sim.state.velocity[0, 2])
    gained = EXHAUST * math.log(MASS / 5.5123)
    assert speeds == pytest.approx([gained] * 3, rel=1e-8)  # truncation of rk4 at 50 ms


def test_a_body_that_loses_mass_at_rest_to_itself_moves_as_if_nothing_happened():
    a = Simulation(scene(exhaust_velocity=0.0, initial={'velocity': [3, 2, 1]}))
    b = Simulation(scene(exhaust_velocity=0.0, mass_rate=0.0, initial={'velocity': [3, 2, 1]}))
    a.step(100)
    b.step(100)
    assert a.state.velocity == pytest.approx(b.state.velocity, rel=ROUND_OFF)
    assert a.state.position == pytest.approx(b.state.position, rel=ROUND_OFF)
    assert a.momentum() == pytest.approx(b.momentum() * 0.85, rel=ROUND_OFF)


def test_a_body_that_gains_mass_is_slowed_by_what_joins_it():
    """Mass that comes from ahead with velocity u relative to the body: m v' = rate u."""
    sim = Simulation(
        scene(
            gravity=0.0,
            mass_rate=2.0,
            exhaust_velocity=[-4, 0, 0],
            final_mass=15.0,
            initial={'velocity': [9, 0, 0]},
        ),
        integrator='rk4',
    )
    sim.step(1000)
    slowed = 9.0 - 4.0 * math.log(1.5)
    assert sim.state.velocity[0, 0] == pytest.approx(slowed, rel=1e-9)  # truncation of rk4
    assert sim.momentum()[0] == pytest.approx(15.0 * slowed, rel=1e-9)


def test_held_commands_and_impulses_act_on_the_mass_of_the_moment():
    sim = Simulation(scene(gravity=0.0, exhaust_velocity=0.0), integrator='rk4')
    sim.step(200)  # 7 kg left
    sim.apply_impulse('rocket', linear=(1, 0, 0))
    assert sim.state.velocity[0, 0] == pytest.approx(1 / 7, rel=ROUND_OFF)
    assert sim.state.momentum[0, 0] == pytest.approx(1.0, rel=ROUND_OFF)
    sim.set_wrench('rocket', force=(0, 3, 0))
    sim.step(100)
    gained = 3.0 / FLOW * math.log(7.0 / 5.5)  # m v' = F with m = 7 - 1.5 t
    assert sim.state.velocity[0, 1] == pytest.approx(gained, rel=1e-9)  # truncation of rk4


def test_inertia_goes_with_the_mass():
    """A torque about an axis of symmetry: w' = torque / (I0 m/m0)."""
    sim = Simulation(
        scene(shape=TANK, gravity=0.0, exhaust_velocity=0.0, final_mass=5.5), integrator='rk4'
    )
    sim.set_wrench('rocket', torque=(0, 0, 0.4))
    sim.step(400)
    axial = 0.5 * MASS * 0.2**2
    spin = 0.4 / axial * (MASS / FLOW * math.log(MASS / 5.5) + 1.0 / 0.55)
    assert sim.state.angular_velocity_body[0, 2] == pytest.approx(
        spin, rel=1e-9
    )  # truncation of rk4
    assert sim.state.angular_momentum[0, 2] == pytest.approx(0.55 * axial * spin, rel=1e-9)


def test_a_free_spin_does_not_feel_the_loss():
    """
    What leaves takes its share of angular momentum along: the motion is that of the whole body,
    bit for bit.
    """
    start = {'angular_velocity': [1, 2, 3]}
    box = {'type': 'box', 'size': [0.3, 0.2, 0.1]}
    a = Simulation(scene(shape=box, exhaust_velocity=0.0, initial=start))
    b = Simulation(scene(shape=box, exhaust_velocity=0.0, mass_rate=0.0, initial=start))
    for sim in (a, b):
        sim.step(300)
    assert np.array_equal(a.state.orientation, b.state.orientation)
    assert np.array_equal(a.state.angular_velocity, b.state.angular_velocity)


def test_thrust_turns_with_the_body():
    """
    A rocket that spins about an axis across its thrust goes round: v = (u rate/m) in rotating
    axes.
    """
    quarter = math.pi / 2
    tank = {'ixx': 1.0, 'iyy': 1.0, 'izz': 1.0}
    sim = Simulation(
        scene(
            shape=None,
            inertia=tank,
            gravity=0.0,
            mass_rate=-1e-6,
            exhaust_velocity=[0, 0, -1e6],
            initial={'angular_velocity': [0, quarter, 0]},
        ),
        integrator='rk4',
    )
    sim.step(100)
    # F = 1 N along R z = (sin wt, 0, cos wt), m = 10 kg within 1e-7
    assert sim.state.velocity[0] == pytest.approx(
        np.array([1.0, 0.0, 1.0]) / quarter / MASS, rel=1e-6
    )


def test_a_lighter_partner_attracts_less():
    """
    Mutual gravity with a body that has lost half of its mass before: half of the force on the
    other.
    """
    pulls = []
    for lost in (0, 5000):
        scene_ = load_scene(
            {
                'version': 1,
                'name': 'g',
                'dt': 0.001,
                'bodies': [
                    {'name': 'star', 'shape': POINT, 'mass': 10.0, 'mass_rate': -1.0},
                    {
                        'name': 'probe',
                        'shape': POINT,
                        'mass': 1e-9,
                        'initial': {'position': [1e3, 0, 0]},
                    },
                ],
                'forces': [{'type': 'gravity', 'constant': 1.0}],
            }
        )
        sim = Simulation(scene_)
        sim.step(lost)
        before = sim.state.velocity[1, 0]
        sim.step()
        pulls.append((sim.state.velocity[1, 0] - before) / 0.001)
    assert pulls[0] == pytest.approx(-1e-5, rel=1e-3)  # 1e-4 of the mass flows within the tick
    assert pulls[1] / pulls[0] == pytest.approx(0.5, rel=1e-3)  # the distance changes by 1e-7


def test_energy_and_momentum_of_a_rocket_are_not_called_conserved():
    sim = Simulation(scene())
    assert not sim.invariants.energy_is_conserved
    assert not sim.invariants.momentum_is_conserved
    sim.step(100)
    m, v, z = 8.5, sim.state.velocity[0, 2], sim.state.position[0, 2]
    assert sim.energy() == pytest.approx(0.5 * m * v * v + m * GRAVITY * z, rel=ROUND_OFF)


def test_many_ticks_at_once_give_the_bits_of_single_ticks():
    a, b = (
        Simulation(scene(shape=TANK, final_mass=5.5123)),
        Simulation(scene(shape=TANK, final_mass=5.5123)),
    )
    a.step(400)
    for _ in range(400):
        b.step()
    assert a.state_bytes() == b.state_bytes()


def test_a_reset_fills_the_tank():
    a, b = Simulation(scene(final_mass=5.5)), Simulation(scene(final_mass=5.5))
    a.step(123)
    a.reset()
    a.step(350)
    b.step(350)
    assert a.state.values == pytest.approx(b.state.values, rel=ROUND_OFF)
    c = Simulation(scene(final_mass=5.5))
    c.restore(tick=a.tick, state=a.state_bytes(), slots={})
    a.step(10)
    c.step(10)
    assert a.state_bytes() == c.state_bytes()


def test_a_run_stops_before_the_last_of_the_mass_is_gone():
    sim = Simulation(scene(), integrator='rk4')
    with pytest.raises(
        SimulationDiverged,
        match=r"'rocket' diverged in tick 666: its mass is used up at 6.66667 s",
    ):
        sim.step(1000)
    assert sim.tick == 666
    assert np.all(np.isfinite(sim.state.values))


def test_a_mass_that_is_gone_at_a_tick_boundary_up_to_rounding_is_gone_there():
    """In whole ticks or in one, the run stops a tick before, and says why."""
    for ticks in range(2, 40):
        for at_once in (True, False):
            sim = Simulation(scene(mass_rate=-MASS / (ticks * 0.01)), integrator='rk4')
            with pytest.raises(SimulationDiverged, match='its mass is used up'):
                for _ in range(1 if at_once else ticks):
                    sim.step(ticks if at_once else 1)
            assert sim.tick == ticks - 1


@pytest.mark.parametrize(
    ('flow', 'said'),
    [
        (MassFlow(-1.0, final_mass=11.0), 'cannot be reached'),
        (MassFlow(1.0, final_mass=9.0), 'cannot be reached'),
        (MassFlow(-1.0, final_mass=-2.0), 'must be positive'),
        (MassFlow(math.nan), r'mass_flow.rate: got nan; a finite number \[kg/s\] is needed'),
    ],
)
def test_an_impossible_flow_is_refused(flow, said):
    body = Body(name='rocket', shape=None, mass=10.0, mass_flow=flow)
    with pytest.raises(InvalidModel, match=said):
        Simulation(Scene(name='x', dt_ns=1000000, bodies=(body,)))


def test_the_moment_of_inertia_goes_with_the_mass():
    sim = Simulation(scene(shape=TANK, gravity=0.0, final_mass=7.0), integrator='dmv6')
    z, beside = (0, 0, 1), (1, 0, 0)
    for ticks, mass in ((0, 10.0), (100, 8.5), (200, 7.0)):
        sim.step(ticks)
        own = mass * 0.2**2 / 2  # of the cylinder about its axis
        found = sim.moment_of_inertia('rocket', direction=z)
        assert found == pytest.approx(own, rel=1e-12)
        found = sim.moment_of_inertia('rocket', direction=z, point=beside)
        assert found == pytest.approx(own + mass, rel=1e-12)
