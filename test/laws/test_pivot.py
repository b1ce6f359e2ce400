# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Bodies that turn about a pivot: tops, pendulums, and what a ball joint does to forces."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.exact import free_asymmetric_top, heavy_top, pendulum
from rigid_body_sim.physics.diagnostics import point_motion
from rigid_body_sim.physics.model import rotation

G = 9.81
ACROSS, AXIAL, MOMENT = 0.35, 0.15, G * 0.5  # of the top below, about its pivot


def scene(body, *, dt, gravity=(0.0, 0.0, -G), forces=(), more=()):
    return load_scene(
        {
            'version': 1,
            'name': 'pivot',
            'dt': dt,
            'gravity': list(gravity),
            'bodies': [body, *more],
            'forces': list(forces),
        }
    )


def top(*, dt, tilt, omega_body, gravity=(0.0, 0.0, -G)):
    """A symmetric top of 1 kg whose centre of mass is 0.5 m above its tip."""
    body = {
        'name': 'top',
        'mass': 1.0,
        'center_of_mass': [0.0, 0.0, 0.5],
        'inertia': {'ixx': 0.1, 'iyy': 0.1, 'izz': 0.15},
        'pivot': {'point': [0.0, 0.0, 0.0], 'at': [0.0, 0.0, 0.0]},
        'initial': {
            'orientation': [math.sin(tilt / 2), 0.0, 0.0, math.cos(tilt / 2)],
            'angular_velocity_body': [float(x) for x in np.ravel(omega_body)],
        },
    }
    return scene(body, dt=dt, gravity=gravity)


def steady_top(*, dt, tilt=math.pi / 6, precession=2.0):
    """The top in steady precession, and its exact motion as a function of time."""
    spin = heavy_top.spin_for(
        precession, inertia_across=ACROSS, inertia_axial=AXIAL, weight_moment=MOMENT, tilt=tilt
    )

    def exact(t):
        return heavy_top.steady(t, precession=precession, spin=spin, tilt=tilt)

    start = exact(0.0).angular_velocity_body
    return top(dt=dt, tilt=tilt, omega_body=start), exact


def angle(simulation, exact):
    """Angle between the first body and an exact motion now [rad]."""
    orientation = np.ravel(exact(simulation.time).orientation)
    return float(rotation.angle_between(simulation.state.orientation[0], orientation))


@pytest.mark.parametrize(
    ('name', 'options', 'dt'),
    [
        ('blanes_moan4', {}, 0.02),
        ('blanes_moan4', {'drift': 'exact'}, 0.02),
        pytest.param('rk8', {}, 0.025, marks=pytest.mark.long),
    ],
)
def test_a_heavy_top_precesses_steadily(name, options, dt):
    top, exact = steady_top(dt=dt)
    simulation = Simulation(top, integrator=name, integrator_options=options)
    simulation.step(round(10.0 / dt))
    assert (
        angle(simulation, exact) < 2e-8
    )  # truncation at this step, 1e-8 at most; round-off 1e-13


def test_a_heavy_top_keeps_energy_and_the_vertical_angular_momentum():
    top, _ = steady_top(dt=0.01)
    simulation = Simulation(top, integrator='blanes_moan4')
    energy = simulation.energy()
    vertical = simulation.angular_momentum()[2]
    simulation.step(10_000)
    # the energy of a symmetric method oscillates with the truncation error and does not drift
    assert simulation.energy() == pytest.approx(energy, rel=1e-11)
    # the torque a x F of a vertical force has no vertical part: round-off of 1e4 kicks of 7
    assert simulation.angular_momentum()[2] == pytest.approx(vertical, rel=2e-13)


@pytest.mark.usefixtures('plain_source')
@pytest.mark.parametrize('looks', [4, pytest.param(20, marks=pytest.mark.long)])
def test_a_top_released_with_spin_alone_falls_and_rises_to_cusps(looks):
    spin = 30.0
    simulation = Simulation(top(dt=0.005, tilt=1.0, omega_body=(0, 0, spin)), integrator='rk8')

    def exact(t):
        return heavy_top.cusped(
            t,
            inertia_across=ACROSS,
            inertia_axial=AXIAL,
            weight_moment=MOMENT,
            spin=spin,
            tilt=1.0,
        )

    for _ in range(looks):
        simulation.step(100)
        assert angle(simulation, exact) < 1e-11  # truncation 5e-13, rounding of 2000 steps


@pytest.mark.parametrize(('share', 'falls'), [(0.95, True), (1.05, False)])
def test_an_upright_top_sleeps_exactly_above_its_critical_spin(share, falls):
    """(I3 w3)^2 = 4 I1 m g l; below it the tilt grows by exp(t sqrt(…)/(2 I1))."""
    critical = math.sqrt(4.0 * ACROSS * MOMENT) / AXIAL
    spin, tilt, seconds = share * critical, 1e-8, 6.0
    simulation = Simulation(
        top(dt=0.01, tilt=tilt, omega_body=(0, 0, spin)), integrator='blanes_moan4'
    )
    highest = tilt
    for _ in range(60):
        simulation.step(10)
        up = simulation.state.position[0] / 0.5
        highest = max(highest, math.hypot(up[0], up[1]))
    square = (AXIAL * spin) ** 2 - 4.0 * ACROSS * MOMENT
    if falls:
        # z'' of the complex tilt z: two exponents i I3 w3/(2 I1) +- rate; z(0) = tilt, z'(0) = 0
        rate = math.sqrt(-square) / (2.0 * ACROSS)
        turn = 1j * AXIAL * spin / (2.0 * ACROSS)
        grown = abs(0.5 * tilt * (1.0 - turn / rate)) * math.exp(rate * seconds)
        assert highest == pytest.approx(grown, rel=1e-4)  # linear: the square of the tilt is 1e-9
    else:
        rate = math.sqrt(square) / (2.0 * ACROSS)
        assert highest < tilt * AXIAL * spin / (2.0 * ACROSS * rate) * 1.01  # the widest ellipse


@pytest.mark.parametrize('angle', [0.3, 2.0, 3.1])
def test_a_physical_pendulum_swings_like_its_elliptic_function(angle):
    size, arm, mass = (0.2, 0.1, 0.6), 0.25, 2.0
    inertia = mass * ((size[1] ** 2 + size[2] ** 2) / 12.0 + arm**2)
    body = {
        'name': 'rod',
        'shape': {'type': 'box', 'size': list(size)},
        'mass': mass,
        'pivot': {'point': [0, 0, arm], 'at': [1.0, 2.0, 3.0]},
        'initial': {'orientation': [math.sin(angle / 2), 0, 0, math.cos(angle / 2)]},
    }
    simulation = Simulation(scene(body, dt=0.01), integrator='blanes_moan4')
    for _ in range(5):
        simulation.step(100)
        exact = pendulum.swing(
            simulation.time, inertia=inertia, weight_moment=mass * G * arm, angle=angle
        )
        down = simulation.state.position[0] - (1.0, 2.0, 3.0)
        # truncation of order four; near the top it grows like the motion itself
        assert math.atan2(down[1], -down[2]) == pytest.approx(float(exact.angle), abs=2e-6)
        assert simulation.state.angular_velocity[0, 0] == pytest.approx(
            float(exact.rate), abs=2e-5
        )


def test_the_closed_form_of_the_pendulum_solves_its_equation():
    of = {'inertia': 0.3, 'weight_moment': 2.0, 'angle': 2.5}
    t = np.linspace(0.0, 7.0, 15)
    found = solve_ivp(
        lambda _t, y: (y[1], -2.0 / 0.3 * math.sin(y[0])),
        (0.0, 7.0),
        (2.5, 0.0),
        method='DOP853',
        t_eval=t,
        rtol=1e-13,
        atol=1e-14,
    )
    exact = pendulum.swing(t, **of)
    assert np.allclose(exact.angle, found.y[0], rtol=0, atol=1e-11)  # of the solver
    assert np.allclose(exact.rate, found.y[1], rtol=0, atol=1e-11)
    after = pendulum.swing(pendulum.period(**of), **of)
    assert float(after.angle) == pytest.approx(2.5, abs=1e-13)


def test_without_gravity_a_pivoted_body_is_a_free_one_of_the_inertia_about_its_pivot():
    omega = (0.4, 1.0, 0.3)
    body = {
        'name': 'body',
        'mass': 2.0,
        'inertia': {'ixx': 1.0, 'iyy': 2.0, 'izz': 2.5},
        'pivot': {'point': [0.0, 0.5, 0.0]},
        'initial': {'angular_velocity_body': list(omega)},
    }
    simulation = Simulation(scene(body, dt=0.02, gravity=(0, 0, 0)), integrator='blanes_moan4')
    before = simulation.state_bytes()
    simulation.step(500)
    exact = free_asymmetric_top.rotation(
        10.0, inertia=(1.0 + 0.5, 2.0, 2.5 + 0.5), angular_velocity_body=omega
    )
    error = rotation.angle_between(simulation.state.orientation[0], exact.orientation)
    assert error < 1e-12  # round-off of 3000 drifts
    assert simulation.state_bytes()[-24:] == before[-24:]  # L about the pivot, to the last bit


def test_a_body_hung_in_its_center_of_mass_does_not_feel_its_weight():
    body = {
        'name': 'wheel',
        'shape': {'type': 'cylinder', 'radius': 0.3, 'length': 0.1},
        'mass': 2.0,
        'pivot': {'point': [0, 0, 0], 'at': [0, 0, 1]},
        'initial': {'angular_velocity_body': [0.1, 0.2, 30.0]},
    }
    simulation = Simulation(scene(body, dt=0.001), integrator='blanes_moan4')
    before = simulation.state.angular_momentum.tobytes()
    simulation.step(1000)
    assert simulation.state.angular_momentum.tobytes() == before
    assert simulation.state.position[0].tolist() == [0.0, 0.0, 1.0]


# a ball joint in full: Newton and Euler for the centre of mass, with the force of the pivot

MASS, POINT, AT = 1.5, np.array([0.1, -0.2, 0.3]), np.array([0.2, 0.1, 1.0])
INERTIA = np.array([[0.2, 0.02, 0.0], [0.02, 0.3, -0.01], [0.0, -0.01, 0.25]])
CENTER = np.array([0.05, 0.1, -0.15])
OMEGA = np.array([0.5, -1.0, 2.0])
HOOK, ANCHOR = np.array([0.3, 0.0, -0.2]), np.array([1.0, 0.5, 0.5])
STIFFNESS, DAMPING, LINEAR, ANGULAR = 30.0, 0.7, 0.4, 0.05
THRUST, THRUST_TORQUE = np.array([0.5, 0.2, -0.3]), np.array([0.02, 0.01, 0.03])
PUSH, PUSH_TORQUE = np.array([1.0, -0.4, 0.6]), np.array([0.05, 0.02, -0.1])


def jointed(dt, *, damped=True):
    body = {
        'name': 'arm',
        'mass': MASS,
        'center_of_mass': CENTER.tolist(),
        'inertia': dict(
            zip(
                ('ixx', 'iyy', 'izz', 'ixy', 'ixz', 'iyz'),
                (0.2, 0.3, 0.25, 0.02, 0.0, -0.01),
                strict=True,
            )
        ),
        'pivot': {'point': POINT.tolist(), 'at': AT.tolist()},
        'initial': {'angular_velocity': OMEGA.tolist()},
    }
    spring = {
        'type': 'spring', 'a': 'arm', 'a_point': HOOK.tolist(), 'b': 'world',
        'b_point': ANCHOR.tolist(), 'stiffness': STIFFNESS, 'damping': DAMPING * damped,
    }  # fmt: skip
    drag = {'type': 'drag', 'body': 'arm', 'linear': LINEAR, 'angular': ANGULAR}
    return scene(body, dt=dt, forces=[spring, drag] if damped else [spring])


def commanded(simulation):
    simulation.hold('arm', 'wrench', force=PUSH, torque=PUSH_TORQUE)
    simulation.hold('arm', 'force', force=THRUST, frame='body')
    simulation.hold('arm', 'torque', torque=THRUST_TORQUE, frame='body')
    return simulation


def newton_euler(seconds, *, damped=True):
    """Position, orientation, velocity and angular velocity, from 15 coupled equations."""

    def slope(_t, y):
        r, q, v, w = y[:3], y[3:7], y[7:10], y[10:13]
        turn = rotation.matrix_from_quaternion(q / np.linalg.norm(q))
        a = turn @ (CENTER - POINT)
        hook = turn @ (HOOK - CENTER)
        pull = STIFFNESS * (ANCHOR - r - hook)
        force = pull + (0.0, 0.0, -G * MASS) + turn @ THRUST + PUSH
        torque = turn @ THRUST_TORQUE + PUSH_TORQUE
        if damped:
            pull = pull - DAMPING * (v + np.cross(w, hook))
            force = force - DAMPING * (v + np.cross(w, hook)) - LINEAR * v
            torque = torque - ANGULAR * w
        torque = torque + np.cross(hook, pull)
        inertia = turn @ INERTIA @ turn.T
        # unknown v', w', N:  m v' - N = F,  I w' + a x N = T - w x I w,  v' + a x w' = w x (w x a)
        cross = np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
        matrix = np.zeros((9, 9))
        matrix[:3, :3], matrix[:3, 6:] = MASS * np.eye(3), -np.eye(3)
        matrix[3:6, 3:6], matrix[3:6, 6:] = inertia, cross
        matrix[6:, :3], matrix[6:, 3:6] = np.eye(3), cross
        right = np.concatenate(
            (force, torque - np.cross(w, inertia @ w), np.cross(w, np.cross(w, a)))
        )
        x = np.linalg.solve(matrix, right)
        return np.concatenate((v, 0.5 * rotation.multiply((*w, 0.0), q), x[:6]))

    arm = CENTER - POINT
    start = np.concatenate((AT + arm, (0.0, 0.0, 0.0, 1.0), np.cross(OMEGA, arm), OMEGA))
    found = solve_ivp(slope, (0.0, seconds), start, method='DOP853', rtol=1e-12, atol=1e-13)
    return found.y[:, -1]


def difference(simulation, exact):
    """Largest difference from a solution of `newton_euler`."""
    state = simulation.state
    return max(
        float(np.max(np.abs(state.position[0] - exact[:3]))),
        float(rotation.angle_between(state.orientation[0], exact[3:7])),
        float(np.max(np.abs(state.velocity[0] - exact[7:10]))),
        float(np.max(np.abs(state.angular_velocity[0] - exact[10:13]))),
    )


@pytest.mark.parametrize(
    ('name', 'options', 'dt', 'error'),
    [
        pytest.param('rk8', {}, 0.02, 1e-9, marks=pytest.mark.long),
        pytest.param('rk45', {}, 0.1, 1e-6, marks=pytest.mark.long),
        ('scipy_dop853', {}, 0.5, 1e-6),
        ('dmv6', {}, 0.002, 2e-4),
        ('linearly_implicit', {}, 0.0002, 5e-3),
    ],
)
def test_springs_drag_and_commands_move_a_pivoted_body_as_newton_and_euler_say(
    name, options, dt, error, request
):
    if name != 'linearly_implicit':  # whose kernel another test wants
        request.getfixturevalue('plain_source')
    simulation = commanded(
        Simulation(jointed(dt), integrator=name, integrator_options=options or None)
    )
    simulation.step(round(1.0 / dt))
    assert difference(simulation, newton_euler(1.0)) < error  # truncation, by the order of each


@pytest.mark.usefixtures('plain_source')
def test_forces_of_position_move_a_pivoted_body_as_newton_and_euler_say():
    simulation = commanded(Simulation(jointed(0.01, damped=False), integrator='blanes_moan4'))
    simulation.step(100)
    assert difference(simulation, newton_euler(1.0, damped=False)) < 1e-6  # truncation


def test_a_stiff_spring_on_a_pivoted_body_stays_bounded_at_any_step():
    body = {
        'name': 'arm',
        'shape': {'type': 'box', 'size': [0.1, 0.1, 0.5]},
        'mass': 1.0,
        'pivot': {'point': [0, 0, 0.25], 'at': [0, 0, 1]},
        'initial': {'angular_velocity': [1.0, 0.5, 2.0]},
    }
    spring = {'type': 'spring', 'a': 'arm', 'a_point': [0, 0, -0.25], 'b': 'world',
              'b_point': [0, 0, 0.5], 'stiffness': 1e8}  # fmt: skip
    drag = {'type': 'drag', 'body': 'arm', 'linear': 0.1}
    simulation = Simulation(
        scene(body, dt=0.01, forces=[spring, drag]), integrator='linearly_implicit'
    )
    simulation.step(200)
    tip = point_motion.motion_of(simulation, 'arm', (0, 0, -0.25)).position
    assert np.linalg.norm(tip - (0, 0, 0.5)) < 1e-4  # (h |w|)^2 |arm| / 2


@pytest.mark.usefixtures('plain_source')
def test_the_pivot_stays_where_it_is_and_its_body_moves_about_it():
    simulation = commanded(Simulation(jointed(0.001), integrator='rk8'))
    before = simulation.state
    acceleration = point_motion.motion_of(simulation, 'arm', CENTER).acceleration
    joint = point_motion.motion_of(simulation, 'arm', POINT)
    assert np.allclose(joint.position, AT, atol=1e-15)
    assert np.allclose(joint.velocity, 0.0, atol=1e-15)
    assert np.allclose(joint.acceleration, 0.0, atol=1e-13)  # of 40 m/s^2
    simulation.step()
    change = (simulation.state.velocity[0] - before.velocity[0]) / 0.001
    assert np.allclose(change, acceleration, rtol=0.02)  # one step of it
    for point in (simulation.state, before):
        momentum = point.momentum[0]
        assert np.allclose(momentum, MASS * point.velocity[0], rtol=1e-15)


def test_an_impulse_at_the_center_of_mass_turns_a_pivoted_body():
    simulation = Simulation(jointed(0.001), integrator='dmv6')
    before = simulation.state
    linear, angular = np.array([0.3, 0.1, -0.2]), np.array([0.01, 0.02, 0.03])
    assert simulation.apply_impulse('arm', linear=linear, angular=angular)[0] == tuple(linear)
    arm = CENTER - POINT
    about = INERTIA + MASS * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    gained = np.linalg.solve(about, angular + np.cross(arm, linear))
    omega = simulation.state.angular_velocity[0]
    assert np.allclose(omega - before.angular_velocity[0], gained, atol=1e-14)
    assert np.allclose(simulation.state.velocity[0], np.cross(omega, arm), atol=1e-15)


def test_energy_is_that_of_the_turn_about_the_pivot_and_of_the_height():
    simulation = Simulation(jointed(0.001, damped=False), integrator='dmv6')
    arm = CENTER - POINT
    about = INERTIA + MASS * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    height = MASS * G * (AT + arm)[2]
    stretch = ANCHOR - (AT + HOOK - POINT)
    stored = 0.5 * STIFFNESS * float(stretch @ stretch)
    assert simulation.energy() == pytest.approx(
        0.5 * OMEGA @ about @ OMEGA + height + stored, rel=1e-14
    )
    total = np.cross(AT + arm, MASS * np.cross(OMEGA, arm)) + INERTIA @ OMEGA
    assert np.allclose(simulation.angular_momentum(), total, atol=1e-14)


@pytest.mark.usefixtures('plain_source')
def test_a_run_goes_on_from_its_state_bytes_with_the_same_bits():
    whole = commanded(Simulation(jointed(0.01), integrator='rk8'))
    whole.step(20)
    saved = whole.state_bytes()
    other = Simulation(jointed(0.01), integrator='rk8')
    other.restore(tick=20, state=saved, slots=whole.held_slots)
    assert other.state.values.tobytes() == whole.state.values.tobytes()
    for simulation in (whole, other):
        simulation.step(20)
    assert other.state_bytes() == whole.state_bytes()
    commands = whole.applied_wrench()
    turn = rotation.matrix_from_quaternion(whole.state.orientation[0])
    assert np.allclose(commands[0][0], PUSH + turn @ THRUST, atol=1e-14)


def test_a_pendulum_does_not_feel_its_neighbours():
    """Seventy of them, in two blocks: the last moves by the bits of one alone."""

    def row(count):
        bars = [
            {
                'name': f'bar{i}',
                'shape': {'type': 'box', 'size': [0.1, 0.1, 0.5]},
                'mass': 1.0,
                'pivot': {'point': [0, 0, 0.25], 'at': [float(i), 0, 0]},
                'initial': {'angular_velocity': [1.0, 0.1 * i, 2.0]},
            }
            for i in range(70)
        ]
        first, *more = bars[-count:]
        return Simulation(scene(first, dt=0.01, more=more), integrator='blanes_moan4')

    alone, together = row(1), row(70)
    for simulation in (alone, together):
        simulation.step(50)
    assert together.state.values[-1].tobytes() == alone.state.values[-1].tobytes()


def test_two_pivoted_bodies_on_a_spring_exchange_energy_and_keep_it():
    def hung(name, x, angle):
        return {
            'name': name,
            'shape': {'type': 'box', 'size': [0.1, 0.1, 0.6]},
            'mass': 1.0,
            'pivot': {'point': [0, 0, 0.3], 'at': [x, 0, 0]},
            'initial': {'orientation': [0, math.sin(angle / 2), 0, math.cos(angle / 2)]},
        }

    link = {'type': 'spring', 'a': 'left', 'b': 'right', 'stiffness': 5.0, 'rest_length': 1.0}
    simulation = Simulation(
        scene(hung('left', 0, 0.5), dt=0.01, forces=[link], more=[hung('right', 1, 0.0)]),
        integrator='blanes_moan4',
    )
    energy = simulation.energy()
    widest = 0.0
    for _ in range(100):
        simulation.step(20)
        widest = max(widest, abs(simulation.state.position[1, 0] - 1.0))
    assert widest > 0.1  # the swing went over to the other
    assert simulation.energy() == pytest.approx(energy, abs=1e-7)  # truncation, J
