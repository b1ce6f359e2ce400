# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Six kicks and drifts of Blanes & Moan, order four for forces that depend on position and attitude.

SRKN6, with the Moser–Veselov drift of order ten in place of the exact free motion: the whole is of
order four only with a drift of order four and more. At a step where kick–drift–kick is wrong by
7e-3 rad on a heavy top this is wrong by 1e-7, for six evaluations of the forces instead of one
(the last kick of a tick and the first of the next share one). With `drift: exact` the free motion
is solved: three times as fast for symmetric tops, slower for others.

Two drifts and two kicks go backwards in time. A damper or drag would feed energy in there, so a
scene with forces that depend on velocity is refused.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from rigid_body_sim.physics.integration.free_rotation import exact_rotor, moser_veselov
from rigid_body_sim.physics.integration.integrator import Integrator
from rigid_body_sim.physics.integration.limits import Limits
from rigid_body_sim.physics.integration.options import Option
from rigid_body_sim.physics.integration.schemes.splitting import Splitting
from rigid_body_sim.physics.model.scene import Scene

KICKS = (0.0829844064174052, 0.396309801498368, -0.0390563049223486)  # b1, b2, b3
MIDDLE_KICK = 1.0 - 2.0 * sum(KICKS)
DRIFTS = (0.245298957184271, 0.604872665711080)  # a1, a2
MIDDLE_DRIFT = 0.5 - sum(DRIFTS)


def refuses(scene: Scene) -> str | None:
    """Refuse forces that depend on velocity: they would run backwards in time."""
    for index, force in enumerate(scene.forces):
        if force.depends_on_velocity():
            return (
                f'it takes substeps backwards in time, and forces[{index}] ({force.TYPE} on '
                f'{", ".join(force.bodies())}) depends on velocity: damping would feed energy in; '
                'choose force_gradient4 or dmv6, which go forwards alone, or rk8'
            )
    return None


def configure(integrator: Integrator, settings: Mapping[str, Any]) -> Integrator:
    """Choose the drift."""
    if settings['drift'] == 'dmv10':
        return integrator
    scheme: Any = integrator.scheme
    return replace(
        integrator,
        free_order=math.inf,
        stability='h |omega| <= 1000 (free rotation); springs: h omega <= 4.7; no damping',
        scheme=replace(scheme, drift_rotation=exact_rotor.drift),
        coefficients=exact_rotor.coefficients,
    )


INTEGRATOR = Integrator(
    name='blanes_moan4',
    order=4,
    free_order=10,
    keeps='L to the last bit and energy to rounding without torque; energy without drift while '
    'forces depend on position',
    stability='h |omega| <= 4 (free rotation, from 1.6 on the drifts are divided); springs: h '
    'omega <= 3.16; no damping',
    source='Blanes & Moan, J. Comput. Appl. Math. 142 (2002), SRKN6; '
    'Celledoni et al., SIAM J. Sci. Comput. 30 (2008)',
    scheme=Splitting(
        kicks=(*KICKS, MIDDLE_KICK, *KICKS[::-1]),
        drifts=(*DRIFTS, MIDDLE_DRIFT, MIDDLE_DRIFT, *DRIFTS[::-1]),
        drift_rotation=moser_veselov.drift(10),
        order=4,
    ),
    coefficients=moser_veselov.coefficients(10),
    refuses=refuses,
    options={'drift': Option('dmv10', choices=('dmv10', 'exact'))},
    configure=configure,
    limits=Limits(rotation=4.0, oscillation=3.16),
)
