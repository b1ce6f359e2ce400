# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The largest step of each integrator: h |omega| of a free body that keeps energy and |L| within 1 %.

Four bodies turn freely with |omega| = 1 rad/s over 5000 steps; the step is raised along a grid
from 0.001 to 4 rad until the energy or |L| is off by more than the bound at one of the looks. The
attitude is not judged: a method may keep both and be wrong about the angle. A second table gives
what the integrators say of themselves, from theory, of springs and drag.

    top     I = (1, 2, 3)           omega along (1, 1, 1)
    needle  I = (0.001, 1, 1.0005)  omega along (0.8, 0.6, 0.02)
    disc    I = (1, 1.001, 1.999)   omega along (0.6, 0.1, 0.79)
    flip    I = (1, 2, 3)           omega along (0.01, 1, 0.01), beside the unstable axis

    python benchmark/stability_limits.py [--integrators NAME …] [--bound 0.01]
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from typing import Any

import numpy as np
from tqdm import tqdm

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.physics.errors import SimulationDiverged
from rigid_body_sim.physics.integration.integrators import INTEGRATORS

# [rad] of a step
GRID = (
    0.001, 0.002, 0.005, 0.01, 0.025, 0.05, 0.1, 0.125, 0.16, 0.2, 0.25,
    0.32, 0.4, 0.5, 0.8, 1.0, 1.25, 1.6, 2.0, 2.5, 3.0, 4.0,
)  # fmt: skip
STEPS = 5000
LOOK_EVERY = 7  # [step] odd, so that a swing in step with the looks does not hide

# principal moments [kg m^2] and direction of omega, body axes
BODIES = {
    'top': ((1.0, 2.0, 3.0), (1.0, 1.0, 1.0)),
    'needle': ((1e-3, 1.0, 1.0005), (0.8, 0.6, 0.02)),
    'disc': ((1.0, 1.001, 1.999), (0.6, 0.1, 0.79)),
    'flip': ((1.0, 2.0, 3.0), (0.01, 1.0, 0.01)),
}
MATRIX = 'orientation: matrix'  # behind the name of a method: the lecture's own state


def free_body(moments: tuple[float, ...], direction: tuple[float, ...], *, dt: float):
    """Make the scene of one free body that turns with 1 rad/s."""
    omega = np.array(direction) / np.linalg.norm(direction)
    return load_scene(
        {
            'version': 1,
            'name': 'free_body',
            'dt': dt,
            'bodies': [
                {
                    'name': 'body',
                    'mass': 1.0,
                    'inertia': dict(zip(('ixx', 'iyy', 'izz'), moments)),
                    'initial': {'angular_velocity_body': omega.tolist()},
                }
            ],
        }
    )


def worst_error(
    method: str,
    moments: tuple[float, ...],
    direction: tuple[float, ...],
    *,
    step: float,
    steps: int = STEPS,
    bound: float = np.inf,
) -> float:
    """
    Largest relative error of the energy or |L| over a run; infinity where it diverges.

    method : name of an integrator, with ', orientation: matrix' for the state (r, R, p, L)
    bound  : the run ends with the first error beyond it
    """
    name, _, more = method.partition(', ')
    options: Mapping[str, Any] = {'orientation': 'matrix'} if more == MATRIX else {}
    scene = free_body(moments, direction, dt=step)
    sim = Simulation(scene, integrator=name, integrator_options=options)
    before = _energy_and_momentum(sim, moments)
    worst = 0.0
    for _ in range(-(-steps // LOOK_EVERY)):
        try:
            sim.step(LOOK_EVERY)
        except SimulationDiverged:
            return np.inf
        with np.errstate(over='ignore', invalid='ignore'):
            error = float(np.max(np.abs(_energy_and_momentum(sim, moments) / before - 1.0)))
        if not error <= bound:
            return error if np.isfinite(error) else np.inf
        worst = max(worst, error)
    return worst


def _energy_and_momentum(sim: Simulation, moments: tuple[float, ...]) -> np.ndarray:
    """
    Energy [J], twice, and |L| [kg m^2/s], of the matrix itself where the method keeps one.
    """
    momentum = sim.state.angular_momentum[0]
    with np.errstate(over='ignore', invalid='ignore'):
        in_body = sim.orientation_matrices()[0].T @ momentum
        return np.array([in_body @ (in_body / moments), np.sqrt(momentum @ momentum)])


def largest_step(method: str, body: str, *, bound: float = 0.01) -> float:
    """Raise the step along the grid; give the last [rad] that kept within the bound, or 0."""
    kept = 0.0
    for step in GRID:
        if not worst_error(method, *BODIES[body], step=step, bound=bound) <= bound:
            break
        kept = step
    return kept


def methods() -> list[str]:
    """Name the integrators that turn bodies, those with another state too; not scipy's."""
    scene = free_body(*BODIES['top'], dt=0.1)
    names = [
        name
        for name, integrator in INTEGRATORS.items()
        if integrator.refuses(scene) is None and not integrator.is_reference
    ]
    oriented = [f'{n}, {MATRIX}' for n in names if 'orientation' in INTEGRATORS[n].options]
    return sorted([*names, *oriented])


def table(names: list[str], *, bound: float = 0.01) -> dict[str, dict[str, float]]:
    """Give method -> body -> largest step [rad]."""
    return {
        name: {body: largest_step(name, body, bound=bound) for body in BODIES}
        for name in tqdm(names, disable=None, leave=False)
    }


def as_markdown(found: Mapping[str, Mapping[str, float]]) -> str:
    """Write the table; 4 means at least 4."""
    lines = [f'| integrator | {" | ".join(BODIES)} |', f'|---{"|---" * len(BODIES)}|']
    for name, row in found.items():
        lines.append(f'| `{name}` | {" | ".join(f"{row[body]:g}" for body in BODIES)} |')
    return '\n'.join(lines)


_BRAKED = load_scene(
    {
        'version': 1,
        'name': 'braked',
        'dt': 0.1,
        'bodies': [{'name': 'ball', 'mass': 1.0, 'shape': {'type': 'particle'}}],
        'forces': [{'type': 'drag', 'body': 'ball', 'linear': 1.0}],
    }
)


def limits_as_markdown() -> str:
    """Write the limits by which a run is warned."""
    lines = ['| integrator | free rotation | springs | drag |', '|---|---|---|---|']
    for name, integrator in INTEGRATORS.items():
        limits = integrator.limits
        numbers = (limits.rotation, limits.oscillation, limits.relaxation)
        cells = ['–' if np.isinf(number) else f'{number:g}' for number in numbers]
        if limits.gyroscopic:
            cells[0] += ' / s'
        if limits.slender is not None or limits.matrix_slender is not None:
            cells[0] += ' ‡'
        if limits.resists:
            cells[1] += ' *'
        if integrator.refuses(free_body(*BODIES['top'], dt=0.1)) is not None:
            cells[0] = 'refused'
        if integrator.refuses(_BRAKED) is not None:
            cells[2] = 'refused'
        lines.append(f'| `{name}` | {" | ".join(cells)} |')
    return '\n'.join(lines)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--integrators', nargs='+', metavar='NAME')
    parser.add_argument('--bound', type=float, default=0.01, help='[-], default 0.01')
    arguments = parser.parse_args()
    names = arguments.integrators or methods()
    print(as_markdown(table(names, bound=arguments.bound)))
    print()
    print(limits_as_markdown())


if __name__ == '__main__':
    main()
