# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The impulse of an impact at one point: Coulomb friction along Routh's path, Stronge's end.
"""

import math

import numpy as np
import pytest

from rigid_body_sim.physics.contact.events.collision_matrix import StruckBody
from rigid_body_sim.physics.contact.events.point_impact import point_impact

from .impact_cases import GROUND, Impact, box, brute_force, collision_matrix, random_impact


@pytest.fixture(scope='module', params=[2000, pytest.param(5000, marks=pytest.mark.long)])
def impacts(request):
    rng = np.random.default_rng(20)
    found = [random_impact(rng) for _ in range(request.param)]
    return [(impact, np.array(point_impact(*impact))) for impact in found]


def ball(mass, radius, arm):
    inverse = 2.5 / (mass * radius**2)
    return StruckBody(1 / mass, (inverse, 0, 0, inverse, 0, inverse), arm)


def test_impulse_is_that_of_rouths_equations_integrated_by_brute_force(impacts):
    # the oracle takes its end from dense output, and slip below 1e-13 for stopped: 4e-13
    rough = [(impact, found) for impact, found in impacts if impact.friction > 0]
    for impact, found in rough[: len(impacts) // 200]:
        law = brute_force(impact)
        assert np.linalg.norm(found - law) < 1e-12 * np.linalg.norm(law)


def test_energy_never_rises(impacts):
    for impact, found in impacts:
        matrix, velocity = collision_matrix(impact), np.array(impact.velocity)
        gained = found @ velocity + found @ matrix @ found / 2
        available = velocity @ np.linalg.solve(matrix, velocity) / 2
        assert gained < 1e-13 * available  # round-off


def test_friction_stays_in_its_cone_and_nobody_goes_on_approaching(impacts):
    for impact, found in impacts:
        normal, size = np.array(impact.normal), np.linalg.norm(found)
        along = found @ normal
        assert np.linalg.norm(found - along * normal) <= impact.friction * along + 1e-13 * size
        after = np.array(impact.velocity) + collision_matrix(impact) @ found
        assert after @ normal > -1e-12 * np.linalg.norm(impact.velocity)


def test_normal_work_returned_is_e_squared_of_that_absorbed_without_friction(impacts):
    smooth = [(impact, found) for impact, found in impacts if impact.friction == 0]
    for impact, found in smooth:
        normal, velocity = np.array(impact.normal), np.array(impact.velocity)
        after = velocity + collision_matrix(impact) @ found
        # J = (1 + e) v_n / (1/m + r_t^2 / I) and its like: rounding of K
        assert after @ normal == pytest.approx(
            -impact.restitution * (velocity @ normal), abs=1e-13
        )


def mirrored(impact):
    """
    Everything seen in the mirror z = 0.
    """

    def flipped(vector):
        return vector[0], vector[1], -vector[2]

    def flipped_body(body):
        xx, xy, xz, yy, yz, zz = body.inverse_inertia
        return StruckBody(body.inverse_mass, (xx, xy, -xz, yy, -yz, zz), flipped(body.arm))

    return impact._replace(
        a=flipped_body(impact.a), b=flipped_body(impact.b), normal=flipped(impact.normal),
        velocity=flipped(impact.velocity),
    )  # fmt: skip


def swapped(impact):
    back = tuple(-x for x in impact.normal), tuple(-x for x in impact.velocity)
    return impact._replace(a=impact.b, b=impact.a, normal=back[0], velocity=back[1])


def heavier(impact):
    """
    Masses and inertias four times as large.
    """

    def four_times(body):
        inertia = tuple(x / 4 for x in body.inverse_inertia)
        return StruckBody(body.inverse_mass / 4, inertia, body.arm)

    return impact._replace(a=four_times(impact.a), b=four_times(impact.b))


def test_who_is_a_and_who_is_b_changes_the_sign_and_no_bit(impacts):
    for impact, found in impacts[:1000]:
        assert (-found == point_impact(*swapped(impact))).all()


def test_a_mirror_mirrors_every_bit(impacts):
    for impact, found in impacts[:1000]:
        assert (found * [1, 1, -1] == point_impact(*mirrored(impact))).all()


def test_four_times_the_masses_take_four_times_the_impulse_to_the_bit(impacts):
    for impact, found in impacts[:1000]:
        assert (4 * found == point_impact(*heavier(impact))).all()


def test_who_separates_or_only_slides_is_left_alone():
    for speed in (0.0, 1.0):
        impact = Impact(GROUND, box(1, (1, 1, 1), np.eye(3), (0.5, 0, -0.5)), (0, 0, 1),
                        (3.0, 0.0, speed), 0.5, 0.5)  # fmt: skip
        assert point_impact(*impact) == (0, 0, 0)


@pytest.mark.parametrize('friction', [0.0, 0.1, 2.0])
@pytest.mark.parametrize('restitution', [0.0, 0.8, 1.0])
@pytest.mark.parametrize('ratio', [1.0, 1e-2, 1e4])
def test_two_spheres_follow_newton_along_the_normal_and_coulomb_across(
    ratio, restitution, friction
):
    normal = np.array([2, -1, 2]) / 3
    first = ball(1, 0.1, tuple(0.1 * normal))
    second = ball(ratio, 0.3, tuple(-0.3 * normal))
    velocity = np.array([-3.0, 0.5, 1.0])
    approach = velocity @ normal
    slip = velocity - approach * normal
    found = np.array(
        point_impact(first, second, tuple(normal), tuple(velocity), restitution, friction)
    )
    mass = 1 / (1 + 1 / ratio)
    along = -(1 + restitution) * approach * mass
    across = min(friction * along, np.linalg.norm(slip) * mass * 2 / 7)
    law = along * normal - across * slip / np.linalg.norm(slip)
    np.testing.assert_allclose(found, law, rtol=0, atol=4e-15 * np.abs(law).max())  # round-off


def rod(angle, friction, restitution, velocity):
    """
    A uniform rod of 1 kg and 2 m, its lower end on the ground, at an angle to it in the plane x z.
    """
    c, s = math.cos(angle), math.sin(angle)
    lower = StruckBody(1.0, (0.0, 0.0, 0.0, 3.0, 0.0, 0.0), (-c, 0.0, -s))
    return Impact(GROUND, lower, (0.0, 0.0, 1.0), velocity, restitution, friction)


@pytest.mark.parametrize('restitution', [0.0, 0.5, 1.0])
def test_a_painleve_rod_is_compressed_until_slip_stops(restitution):
    """
    f_n = 1 + 3 cos a (cos a - mu sin a) < 0: no force keeps the end from going in while it slips.
    By the law p_n runs to the end of slip, then it sticks to the end of compression and of
    restitution: three straight lines.
    """
    angle, friction, slip, approach = math.atan(2), 2.0, -1.0, -0.1  # mu above 4/3, tan a = 2
    c, s = math.cos(angle), math.sin(angle)
    k_tt, k_tn, k_nn = 1 + 3 * s * s, -3 * s * c, 1 + 3 * c * c  # du = K p in x and z
    assert k_nn + friction * k_tn < 0
    to_stop = -slip / (friction * k_tt + k_tn)
    pressed = approach + (k_nn + friction * k_tn) * to_stop
    work = to_stop * (approach + pressed) / 2
    sticking = k_nn - k_tn**2 / k_tt
    work -= pressed**2 / (2 * sticking)
    last = restitution * math.sqrt(-2 * sticking * work)
    law_n = to_stop + (last - pressed) / sticking
    law_t = (-slip - k_tn * law_n) / k_tt  # the end does not slip any more
    found = point_impact(*rod(angle, friction, restitution, (slip, 0.0, approach)))
    np.testing.assert_allclose(found, (law_t, 0, law_n), rtol=0, atol=1e-14)  # round-off


def test_where_newtons_rule_gains_energy_stronges_does_not():
    """
    Slip stops before the end of compression: Newton's u_n' = -u_n would return more than there
    was. Straight lines: slip to its stop, then stick to u_n' = 0.9.
    """
    angle, friction, slip, approach = math.pi / 4, 0.95, 0.5, -0.9
    k_tt, k_tn, k_nn = 2.5, -1.5, 2.5  # du = K p in x and z
    stop = slip / (friction * k_tt - k_tn)
    pressed = approach + (k_nn - friction * k_tn) * stop
    stick = -k_tn / k_tt
    assert pressed < 0
    assert stick < friction
    rest = (-approach - pressed) / (k_nn + k_tn * stick)
    newton = np.array([stick * rest - friction * stop, 0.0, stop + rest])
    case = rod(angle, friction, 1.0, (slip, 0.0, approach))
    matrix, velocity = collision_matrix(case), np.array(case.velocity)

    def gained(impulse):
        return impulse @ velocity + impulse @ matrix @ impulse / 2

    assert gained(newton) > 0.03  # [J]
    assert gained(np.array(point_impact(*case))) < -0.01
