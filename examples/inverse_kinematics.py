# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Inverse kinematics: positions and what is known at the ends in, velocities and accelerations out.

A simulation goes from a to v to r and needs a start. The other way round, from r to v to a, needs
nothing but positions; what is known at the ends makes it better where it is worst.
"""

import numpy as np

from rigid_body_sim import inverse_kinematics

t = np.linspace(0.0, 1.0, 15)
# a crane moves its load by 2 m, from rest to rest: x = 10 u^3 - 15 u^4 + 6 u^5 of the way, and
# the load swings a little
x = 2.0 * (10 * t**3 - 15 * t**4 + 6 * t**5)
z = 0.05 * np.cos(6.0 * t)
position = np.column_stack([x, 0 * t, z])
true = np.column_stack([2.0 * (60 * t - 180 * t**2 + 120 * t**3), 0 * t, -36.0 * z])

blind = inverse_kinematics(t, position)
told = inverse_kinematics(
    t,
    position,
    start_velocity=(0, 0, 0),
    start_acceleration=true[0],
    end_velocity=(0, 0, -0.3 * np.sin(6.0)),
    end_acceleration=true[-1],
)
print('                        error of a [m/s^2]   estimated')
for name, found in (('positions alone', blind), ('ends known', told)):
    error = np.sqrt(np.mean(np.sum((found.acceleration - true) ** 2, axis=1)))
    print(f'{name:22} {error:18.1e} {found.acceleration_error:13.1e}')
    assert found.acceleration_error / 3 < error < 3 * found.acceleration_error
assert np.allclose(told.velocity[0], 0.0, atol=1e-12)

# the same from a camera that is wrong by a millimetre, a hundred times a second
t = np.linspace(0.0, 1.0, 101)
position = np.column_stack([2.0 * (10 * t**3 - 15 * t**4 + 6 * t**5), 0 * t, 0 * t])
true = 2.0 * (60 * t - 180 * t**2 + 120 * t**3)
seen = position + 1e-3 * np.random.default_rng(1).standard_normal(position.shape)
found = inverse_kinematics(t, seen, start_velocity=(0, 0, 0), end_velocity=(0, 0, 0))
inside = np.abs(found.acceleration[:, 0] - true) < 2 * found.acceleration_deviation[:, 0]
print(f'noise found {found.noise:.1e} m, smoothed to {found.bandwidth:.2g} Hz')
print(f'{100 * np.mean(inside):.0f} % of the accelerations within two standard deviations')
assert np.mean(inside) > 0.8
