# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The pair of orders five and four of Dormand & Prince: substeps as long as the tolerances allow,
every tick reached.

For scenes whose pace changes, and where the error is to be asked for rather than the step. The
bounded energy error of a symmetric method is not to be had with it.
"""

from rigid_body_sim.physics.integration.integrator import Integrator, within_tolerances
from rigid_body_sim.physics.integration.options import tolerances
from rigid_body_sim.physics.integration.orientation import ORIENTATION, oriented
from rigid_body_sim.physics.integration.schemes.adaptive import EmbeddedPair

A = (
    (),
    (1 / 5,),
    (3 / 40, 9 / 40),
    (44 / 45, -56 / 15, 32 / 9),
    (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
    (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
)
B = (35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84)
ERROR = (71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40)

INTEGRATOR = Integrator(
    name='rk45',
    order=5,
    free_order=5,
    keeps='nothing, each to within the tolerances; parabolas of free fall are exact',
    stability='none; a stiff spring costs substeps of 3 / omega',
    source='Dormand & Prince, J. Comp. Appl. Math. 6 (1980); Gustafsson, ACM TOMS 17 (1991)',
    scheme=EmbeddedPair(a=A, b=B, error=ERROR),
    failure='no substep down to 1e-12 of the tick meets rtol and atol',
    options=tolerances(1e-9, 1e-12) | ORIENTATION,
    configure=lambda method, settings: oriented(within_tolerances(method, settings), settings),
)
