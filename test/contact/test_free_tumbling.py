# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A free box that tumbles about its middle axis, in a scene in which bodies may meet (verification
case V20): with moments I1 < I2 < I3, energy E, angular momentum L, and L^2 > 2 E I2,

    T = 4 K(k) sqrt(I1 I2 I3 / ((I3 - I2) (L^2 - 2 E I1)))
    k^2 = (I2 - I1) (2 E I3 - L^2) / ((I3 - I2) (L^2 - 2 E I1))

is the period of its angular velocity in body axes (Landau & Lifshitz, Mechanics, section 37); it
flips every T/2. For L^2 < 2 E I2 the moments 1 and 3 change places.
"""

import numpy as np
import pytest
from scipy.special import ellipk

from rigid_body_sim import Simulation

from .touching import box, ground, scene

SIZE = np.array([0.2, 0.3, 0.5])  # [m]
MOMENTS = ((SIZE**2).sum() - SIZE**2) / 12  # [kg m^2] of 1 kg, the middle one about y
DT = 0.004  # [s]
TICKS = 600  # [-] of a period


def period(omega):
    """
    Period of the angular velocity in body axes [s].
    """
    twice, square = (MOMENTS * omega**2).sum(), ((MOMENTS * omega) ** 2).sum()
    i1, i2, i3 = np.sort(MOMENTS)
    if square < twice * i2:
        i1, i3 = i3, i1
    rate = (i3 - i2) * (square - twice * i1)
    k2 = (i2 - i1) * (twice * i3 - square) / rate
    return 4 * ellipk(k2) * np.sqrt(i1 * i2 * i3 / rate)


def in_body_axes(q, v):
    """
    Turn a vector of the world into body axes; q: xyzw.
    """
    back, w = -q[:3], q[3]
    return v + 2 * np.cross(back, np.cross(back, v) + w * v)


@pytest.mark.parametrize('push', [(0.0, 0.02), (0.02, 0.0)])
def test_a_box_that_tumbles_freely_flips_twice_in_its_period_and_keeps_its_momentum(push):
    """
    Spun about the middle axis with a push along the one of the largest or of the least moment.
    """
    omega = np.array([push[0], 1.0, push[1]])
    omega *= period(omega) / (TICKS * DT)  # the period goes as 1/omega
    tumbler = box('b', SIZE, (0, 0, 50), turn=omega)
    sim = Simulation(scene([ground(), tumbler], dt=DT, gravity=(0, 0, 0)))
    momentum, energy = sim.angular_momentum(), sim.energy()
    found = []
    for _ in range(4):
        sim.step(TICKS // 2)
        state = sim.state
        found.append(in_body_axes(state.orientation[1], state.angular_velocity[1]))
    # rounding, and what the unstable middle axis makes of it in four flips
    flips = [omega * (1.0, sign, 1.0) for sign in (-1.0, 1.0, -1.0, 1.0)]
    assert found == pytest.approx(np.array(flips), abs=1e-11 * np.linalg.norm(omega))
    assert sim.angular_momentum() == pytest.approx(momentum, rel=1e-14, abs=0.0)
    assert sim.energy() == pytest.approx(energy, rel=1e-14)
