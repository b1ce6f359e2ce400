# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Rigid body simulation for ROS 2: scenes, integrators, recordings that can be proved.

    import rigid_body_sim as rbs

    run = rbs.simulate('satellite', duration=60, every=0.01)
    run['satellite'].angular_velocity_body        # (m, 3) rad/s

`dir(rbs)` names what there is; each name is imported when it is asked for.
"""

TYPE_CHECKING = False  # to those who run it: importing `typing` for the name takes its time
if TYPE_CHECKING:
    from rigid_body_sim import rotation
    from rigid_body_sim.analysis.inverse_kinematics import inverse_kinematics
    from rigid_body_sim.errors import RunError, UserError
    from rigid_body_sim.library.from_bag import open_bag
    from rigid_body_sim.library.make_scene import make_body, make_scene
    from rigid_body_sim.library.run import BodyRun, Run
    from rigid_body_sim.library.simulation import Simulation, simulate
    from rigid_body_sim.library.stretch import RunWarning
    from rigid_body_sim.physics.errors import InvalidModel, SimulationDiverged
    from rigid_body_sim.physics.forces.elements.bumper import Bumper
    from rigid_body_sim.physics.forces.elements.constant import Constant
    from rigid_body_sim.physics.forces.elements.drag import Drag
    from rigid_body_sim.physics.forces.elements.gravity import Gravity
    from rigid_body_sim.physics.forces.elements.spring import Spring
    from rigid_body_sim.physics.forces.elements.time import TimeTable
    from rigid_body_sim.physics.model.scene import (
        Body,
        Frame,
        InertiaOverTime,
        MassFlow,
        Material,
        Motion,
        Oscillation,
        Pivot,
        PrescribedMotion,
        Scene,
    )
    from rigid_body_sim.physics.model.shapes import (
        Box,
        Capsule,
        ConvexHull,
        Cylinder,
        Mesh,
        Part,
        Particle,
        Particles,
        Plane,
        Sphere,
        Surface,
        Union,
    )
    from rigid_body_sim.physics.state.snapshot import State
    from rigid_body_sim.runs.wrench import Wrench
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
    'Body',
    'BodyRun',
    'Box',
    'Bumper',
    'Capsule',
    'Constant',
    'ConvexHull',
    'Cylinder',
    'Drag',
    'Frame',
    'Gravity',
    'InertiaOverTime',
    'InvalidModel',
    'MassFlow',
    'Material',
    'Mesh',
    'Motion',
    'Oscillation',
    'Part',
    'Particle',
    'Particles',
    'Pivot',
    'Plane',
    'PrescribedMotion',
    'Run',
    'RunError',
    'RunWarning',
    'Scene',
    'Simulation',
    'SimulationDiverged',
    'Sphere',
    'Spring',
    'State',
    'Surface',
    'TimeTable',
    'Union',
    'UserError',
    'Wrench',
    '__version__',
    'choice',
    'direction',
    'integers',
    'inverse_kinematics',
    'load_scene',
    'loguniform',
    'make_body',
    'make_scene',
    'normal',
    'open_bag',
    'random_rotation',
    'rotation',
    'simulate',
    'sweep',
    'truncated_normal',
    'uniform',
]

_PLACES = {  # module: what of it is public
    'analysis.inverse_kinematics': ('inverse_kinematics',),
    'errors': ('RunError', 'UserError'),
    'library.environment': ('BodyEnv',),  # needs gymnasium, so it is not in __all__
    'library.from_bag': ('open_bag',),
    'library.make_scene': ('make_body', 'make_scene'),
    'library.run': ('BodyRun', 'Run'),
    'library.simulation': ('Simulation', 'simulate'),
    'library.stretch': ('RunWarning',),
    'physics.errors': ('InvalidModel', 'SimulationDiverged'),
    'physics.forces.elements.bumper': ('Bumper',),
    'physics.forces.elements.constant': ('Constant',),
    'physics.forces.elements.drag': ('Drag',),
    'physics.forces.elements.gravity': ('Gravity',),
    'physics.forces.elements.spring': ('Spring',),
    'physics.forces.elements.time': ('TimeTable',),
    'physics.model.scene': (
        'Body', 'Frame', 'InertiaOverTime', 'MassFlow', 'Material', 'Motion', 'Oscillation',
        'Pivot', 'PrescribedMotion', 'Scene',
    ),
    'physics.model.shapes': (
        'Box', 'Capsule', 'ConvexHull', 'Cylinder', 'Mesh', 'Part', 'Particle', 'Particles',
        'Plane', 'Sphere', 'Surface', 'Union',
    ),
    'physics.state.snapshot': ('State',),
    'runs.wrench': ('Wrench',),
    'scene': ('load_scene',),
    'sweeps.distributions': (
        'choice', 'direction', 'integers', 'loguniform', 'normal', 'random_rotation',
        'truncated_normal', 'uniform',
    ),
    'sweeps.ensemble': ('sweep',),
}  # fmt: skip
_MODULES = {name: module for module, names in _PLACES.items() for name in names}
_ROOMS = ('rotation',)  # modules that are public as they are


def __dir__() -> list[str]:
    """Name what is public, whether it was asked for yet or not."""
    hidden = {'TYPE_CHECKING', '_PLACES', '_MODULES', '_ROOMS'}
    return sorted({*globals(), *__all__, 'BodyEnv'} - hidden)


def __getattr__(name: str):
    """Import what is asked for only then: verbs that need none of it start faster."""
    from importlib import import_module

    if name in _ROOMS:
        return import_module(f'{__name__}.{name}')
    if name in _MODULES:
        value = getattr(import_module(f'{__name__}.{_MODULES[name]}'), name)
        globals()[name] = value
        return value
    from rigid_body_sim.physics.errors import nearest

    near = None if name.startswith('_') else nearest(name, __all__)
    cure = '' if near is None else f'; did you mean {near!r}?'
    raise AttributeError(f'module {__name__!r} has no attribute {name!r}{cure}')
