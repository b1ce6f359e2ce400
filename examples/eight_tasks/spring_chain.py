# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A chain of ten masses between two walls swings in its lowest mode as the text book says."""

import numpy as np

import rigid_body_sim as rbs

n, k, m = 10, 400.0, 0.1  # masses, N/m, kg
height = 0.01 * np.sin(np.pi * np.arange(1, n + 1) / (n + 1))
balls = [rbs.make_body(f'm{i}', mass=m, position=(i, 0, height[i - 1])) for i in range(1, n + 1)]
springs = [rbs.Spring(f'm{i}', f'm{i + 1}', stiffness=k) for i in range(1, n)]
springs += [rbs.Spring('m1', 'world', stiffness=k)]
springs += [rbs.Spring(f'm{n}', 'world', stiffness=k, b_point=(n + 1, 0, 0))]
run = rbs.simulate(rbs.make_scene(balls, springs, integrator='blanes_moan4'), 2, every=0.01)
omega = 2 * np.sqrt(k / m) * np.sin(np.pi / (2 * (n + 1)))
off = np.abs(run['m5'].position[:, 2] - height[4] * np.cos(omega * run.time)).max()
print(f'{omega:.3f} rad/s; the fifth mass is off by {off:.1e} m at most')
assert off < 1e-8  # m; order four at h omega = 0.018
