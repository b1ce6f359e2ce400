# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Rigid body simulation for ROS 2: scenes, integrators, recordings that can be proved.

    from rigid_body_sim import Simulation, load_scene
"""

TYPE_CHECKING = False  # to those who run it: importing `typing` for the name takes its time
if TYPE_CHECKING:
    from rigid_body_sim.analysis.inverse_kinematics import inverse_kinematics
    from rigid_body_sim.physics.simulation import Simulation
    from rigid_body_sim.scene import load_scene
    from rigid_body_sim.sweeps.distributions import (
        choice,
        direction,
        integers,
        loguniform,
        normal,
        random_rotation,
        truncated_normal,
        uniform,
    )
    from rigid_body_sim.sweeps.ensemble import sweep

__version__ = '0.1.0'
__all__ = [
    'Simulation',
    '__version__',
    'choice',
    'direction',
    'integers',
    'inverse_kinematics',
    'load_scene',
    'loguniform',
    'normal',
    'random_rotation',
    'sweep',
    'truncated_normal',
    'uniform',
]
_DISTRIBUTIONS = {
    'choice',
    'direction',
    'integers',
    'loguniform',
    'normal',
    'random_rotation',
    'truncated_normal',
    'uniform',
}


def __dir__() -> list[str]:
    """Name also what is imported only when it is asked for."""
    return sorted({*globals(), *__all__})


def __getattr__(name: str):
    """Import the physics only when it is asked for: verbs that need none of it start faster."""
    if name == 'Simulation':
        from rigid_body_sim.physics.simulation import Simulation

        return Simulation
    if name == 'load_scene':
        from rigid_body_sim.scene import load_scene

        return load_scene
    if name == 'inverse_kinematics':
        from rigid_body_sim.analysis.inverse_kinematics import inverse_kinematics

        return inverse_kinematics
    if name == 'sweep':
        from rigid_body_sim.sweeps.ensemble import sweep

        return sweep
    if name in _DISTRIBUTIONS:
        from rigid_body_sim.sweeps import distributions

        return getattr(distributions, name)
    raise AttributeError(f'module {__name__!r} has no attribute {name!r}')
