# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""How far off are the methods on a heavy top, and what do they do to its energy?"""

import numpy as np

import rigid_body_sim as rbs

exact = rbs.simulate('heavy_top', 5, every=0.5, integrator='rk8', dt=0.001)
for name in ('blanes_moan4', 'dmv6', 'lie_rk4', 'rk4', 'explicit_euler'):
    run = rbs.simulate('heavy_top', 5, every=0.5, integrator=name, dt=0.01)
    off = np.abs(run['top'].position - exact['top'].position).max()
    print(f'{name:15} {off:8.1e} m off, energy within {np.ptp(run.energy):8.1e} J')
    assert name == 'explicit_euler' or off < 0.02  # that one has no business here
