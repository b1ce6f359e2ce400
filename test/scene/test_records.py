# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Records made in Python are judged as scene files are; a simulation keeps its state to itself."""

from __future__ import annotations

import copy
import math
import pickle
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from rigid_body_sim import Simulation
from rigid_body_sim.errors import UserError
from rigid_body_sim.physics import simulation as physics
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.forces.elements import FORCES
from rigid_body_sim.physics.model.scene import Body, Frame, MassFlow, Material, Motion, Scene
from rigid_body_sim.physics.model.shapes import Box, Particle, Particles, Plane, Sphere
from rigid_body_sim.scene import load_scene

BODY = Body('b', Box((1.0, 1.0, 1.0)), 2.0, inertia=np.eye(3))
SCENE = Scene('t', 1_000_000, (BODY, Body('p', None, 1.0)))
NAN = math.nan


def refused(scene: Scene) -> str:
    """
    What `Simulation` says of a scene that it refuses.
    """
    with pytest.raises(InvalidModel) as error:
        Simulation(scene)
    assert str(error.value).isprintable()
    return str(error.value)


@pytest.mark.parametrize(
    ('changes', 'reason'),
    [
        ({'mass': -2.0}, 'bodies[0].mass: mass is -2.0 kg; it must be positive'),
        ({'mass': NAN}, 'bodies[0].mass: got nan'),
        ({'mass': '2'}, "bodies[0].mass: got '2'"),
        ({'mass': 10**400}, 'bodies[0].mass: got '),
        ({'mass': True}, 'bodies[0].mass: got True'),
        ({'inertia': np.diag([1.0, 1.0, 5.0])}, 'bodies[0].inertia: principal moments'),
        ({'inertia': np.full((3, 3), NAN)}, 'bodies[0].inertia: the inertia tensor holds NaN'),
        ({'inertia': None}, 'bodies[0].inertia: none is given'),
        ({'inertia': 'round'}, "bodies[0].inertia: got 'round'"),
        ({'name': 'a\nb'}, "bodies[0].name: got 'a"),
        ({'name': 'p'}, "bodies[1].name: the name 'p' is taken"),
        ({'shape': 'box'}, "bodies[0].shape: got 'box'"),
        ({'shape': Plane((0, 0, 1))}, 'bodies[0].fixed: a plane is always fixed'),
        ({'center_of_mass': (0, 0)}, 'bodies[0].center_of_mass: got (0, 0); three finite'),
        ({'shape_orientation': (0, 0, 1, 1)}, 'bodies[0].shape_orientation: got'),
        ({'initial': Motion(velocity=(0, math.inf, 0))}, 'bodies[0].initial.velocity: got'),
        ({'initial': Motion(velocity=(1.7e308, 0, 0))}, 'bodies[0].initial: the momentum'),
        (
            {'initial': Motion(velocity=(0, 1e200, 0))},
            'bodies[0].initial.velocity: the velocity of 1e+200 m/s has no finite energy',
        ),
        (
            {'initial': Motion(position=(0, 1e308, 0))},
            'bodies[0].initial.position: the position of 1e+308 m has no finite energy',
        ),
        (
            {'initial': Motion(angular_velocity=(0, 1e151, 0))},
            'bodies[0].initial.angular_velocity: the angular velocity of 1e+151 rad/s has no',
        ),
        ({'initial': None}, 'bodies[0].initial: got None; a Motion'),
        ({'material': Material(restitution=2.0)}, 'bodies[0].material.restitution: got 2.0'),
        ({'mass_flow': MassFlow(NAN)}, 'bodies[0].mass_flow.rate: got nan'),
        ({'fixed': True, 'initial': Motion(velocity=(1, 0, 0))}, 'a fixed body does not move'),
        ({'shape': Particle()}, 'bodies[0].inertia: a particle is a point mass'),
    ],
)
def test_a_body_that_no_scene_file_could_hold_is_refused_with_its_path(
    changes: dict[str, Any], reason: str
) -> None:
    bodies = (replace(BODY, **changes), *SCENE.bodies[1:])
    assert reason in refused(replace(SCENE, bodies=bodies))


@pytest.mark.parametrize(
    ('changes', 'reason'),
    [
        ({'dt_ns': 0}, 'dt_ns: got 0'),
        ({'dt_ns': 1e6}, 'dt_ns: got 1000000.0'),
        ({'bodies': ()}, 'bodies: there are none'),
        ({'bodies': (3,)}, 'bodies[0]: got 3; a Body is needed'),
        ({'gravity': (0, 0, NAN)}, 'gravity: got (0, 0, nan)'),
        ({'contact': {'mode': 'none', 'slop': 1}}, 'contact: got'),
        ({'contact': 'none'}, "contact: got 'none'"),
        ({'integrator': ''}, "integrator '' is unknown"),
        ({'integrator': ['rk4']}, "integrator: got ['rk4']; the name"),
        ({'name': 'a\nb'}, 'name: got'),
        ({'forces': ('spring',)}, "forces[0]: got 'spring'"),
        ({'forces': (FORCES['drag']('x', linear=1.0),)}, "forces[0].body: body 'x' is unknown"),
        ({'forces': (FORCES['drag']('b', linear=-1.0),)}, 'forces[0].linear: got -1.0'),
        ({'forces': (FORCES['spring']('b', 'p', NAN),)}, 'forces[0].stiffness: got nan'),
        (
            {'forces': (FORCES['spring']('b', 'p', 1.0, a_point=(0, 0)),)},
            'forces[0].a_point: got (0, 0)',
        ),
    ],
)
def test_a_scene_that_no_file_could_hold_is_refused_with_its_path(
    changes: dict[str, Any], reason: str
) -> None:
    assert reason in refused(replace(SCENE, **changes))


def test_no_record_is_a_scene() -> None:
    with pytest.raises(InvalidModel, match='a Scene, such as load_scene returns'):
        physics.Simulation(7)  # type: ignore[arg-type]


@pytest.mark.parametrize('ends', [('b', 'b'), ('world', 'world')])
@pytest.mark.parametrize('kind', ['spring', 'bumper'])
def test_a_spring_between_points_that_keep_their_distance_is_refused_both_ways(
    kind: str, ends: tuple[str, str]
) -> None:
    a, b = ends
    with pytest.raises(InvalidModel, match=f'both ends of this {kind} are on {a!r}'):
        FORCES[kind](a, b, 1.0, 1.0)
    length = 'rest_length' if kind == 'spring' else 'length'
    force = {'type': kind, 'a': a, 'b': b, 'stiffness': 1, length: 1, 'a_point': [1, 0, 0]}
    point = {'name': 'b', 'shape': {'type': 'sphere', 'radius': 1}, 'mass': 1}
    with pytest.raises(UserError, match=r'forces\[0\].b: both ends'):
        load_scene({'dt': 0.001, 'bodies': [point], 'forces': [force]})


@pytest.mark.parametrize(
    'make',
    [
        lambda: Box('abc'),  # type: ignore[arg-type]
        lambda: Box((1.0, 2.0)),  # type: ignore[arg-type]
        lambda: Sphere('1'),  # type: ignore[arg-type]
        lambda: Sphere(10**400),
        lambda: Plane((0, 0)),  # type: ignore[arg-type]
        lambda: Particles(np.eye(3), ['a', 'b', 'c']),  # type: ignore[arg-type]
        lambda: Motion(orientation=(0, 0, 0, 0)),
        lambda: Motion(orientation='xyzw'),  # type: ignore[arg-type]
        lambda: FORCES['time']('b', table=((0, 0), (1,))),
        lambda: FORCES['time']('b', table=5),
        lambda: FORCES['gravity'](('b', ['p'])),
    ],
)
def test_a_record_that_can_tell_alone_refuses_when_it_is_made(make: Callable[[], Any]) -> None:
    with pytest.raises(InvalidModel):
        make()


def test_an_attitude_of_any_length_is_scaled_as_in_a_file() -> None:
    assert Motion(orientation=(0, 0, 3, 4)).orientation == (0.0, 0.0, 0.6, 0.8)


@pytest.mark.parametrize(
    'vector', [('a', 'b', 'c'), (10**400, 0, 0), (NAN, 0, 0), (1, 2), 3, None]
)
def test_a_command_that_is_no_vector_is_refused_by_name(vector: Any) -> None:
    simulation = Simulation(SCENE)
    for command in (
        lambda: simulation.set_wrench('b', force=vector),
        lambda: simulation.apply_impulse('b', angular=vector),
        lambda: simulation.hold('b', 'force', torque=vector),
    ):
        with pytest.raises(InvalidModel, match='three finite numbers'):
            command()


def test_a_command_to_nobody_is_refused_by_name() -> None:
    simulation = Simulation(SCENE)
    for body in (['b'], None, 'x', np.array(['b'])):
        with pytest.raises(InvalidModel, match='no body is named'):
            simulation.set_wrench(body, force=(1, 0, 0))  # type: ignore[arg-type]
    with pytest.raises(InvalidModel, match='source'):
        simulation.hold('b', 'push', force=(1, 0, 0))
    with pytest.raises(InvalidModel, match='frame'):
        simulation.set_wrench('b', force=(1, 0, 0), frame=['body'])  # type: ignore[arg-type]


@pytest.mark.parametrize('dt', [0, -1.0, NAN, '0.001', [1], True, 10**400])
def test_an_impossible_step_is_refused(dt: Any) -> None:
    with pytest.raises(InvalidModel):
        Simulation(SCENE, dt=dt)


def test_an_empty_name_of_an_integrator_is_not_that_of_the_scene() -> None:
    for name in ('', 0, ['rk4']):
        with pytest.raises(InvalidModel, match='is unknown'):
            Simulation(SCENE, integrator=name)  # type: ignore[arg-type]


def test_what_is_read_of_a_state_cannot_be_written_to() -> None:
    state = Simulation(SCENE).state
    for name in ('position', 'orientation', 'velocity', 'angular_velocity', 'momentum', 'values'):
        with pytest.raises(ValueError, match='read-only'):
            getattr(state, name)[:] = 99.0
    state.position.copy()[:] = 99.0  # a copy is its owner's


@pytest.mark.parametrize(
    'copied', [lambda scene: scene, copy.deepcopy, lambda scene: pickle.loads(pickle.dumps(scene))]
)
@pytest.mark.parametrize('name', ['tetrahedron', 'sea_bed', 'demo', 'satellite'])
def test_no_array_of_a_scene_can_be_written_to_by_one_of_its_simulations(
    name: str, copied: Callable[[Scene], Scene]
) -> None:
    scene = copied(Simulation(load_scene(name)).scene)
    arrays = [
        value
        for body in scene.bodies
        for value in (body.inertia, *getattr(body.shape, '__dict__', {}).values())
        if isinstance(value, np.ndarray)
    ]
    assert arrays
    for array in arrays:
        with pytest.raises(ValueError, match='read-only'):
            array[...] *= 2


@pytest.mark.parametrize(
    'copied',
    [
        lambda scene: scene,
        copy.copy,
        copy.deepcopy,
        lambda scene: pickle.loads(pickle.dumps(scene)),
        lambda scene: replace(scene, dt_ns=2_000_000),
    ],
)
def test_no_mapping_of_a_scene_can_be_written_to(copied: Callable[[Scene], Scene]) -> None:
    contact = {'mode': 'timestep', 'pairs': [{'bodies': ['b', 'p'], 'friction': 0.1}]}
    frames = {'nose': Frame((1.0, 0.0, 0.0))}
    told = replace(SCENE, contact=contact, bodies=(replace(BODY, frames=frames), SCENE.bodies[1]))
    scene = copied(replace(told, integrator_options={'substeps': 2}, files={'x.obj': b'x'}))
    contact['substeps'] = 1
    frames.clear()
    mappings: list[Any] = [scene.contact, scene.contact['pairs'][0], scene.bodies[0].frames]
    for mapping in (*mappings, scene.integrator_options, scene.files):
        before = dict(mapping)
        for change in (
            lambda mapping: mapping.update(mode='none'),
            lambda mapping: mapping.__setitem__('mode', 'none'),
            lambda mapping: mapping.__delitem__(next(iter(mapping))),
            lambda mapping: mapping.__ior__({'mode': 'none'}),
            lambda mapping: mapping.setdefault('other', 1),
            lambda mapping: mapping.popitem(),
            lambda mapping: mapping.clear(),
        ):
            with pytest.raises(TypeError, match='cannot be written to'):
                change(mapping)
        assert before and mapping == before
    assert 'substeps' not in scene.contact and list(scene.bodies[0].frames) == ['nose']
    dict(scene.contact)['mode'] = 'none'  # a copy is its owner's
    assert {**scene.contact, 'substeps': 3}['substeps'] == 3


@pytest.mark.parametrize(
    ('state', 'reason'),
    [
        (lambda state: state + bytes(8), 'the state does not fit this scene: 8 bytes more'),
        (lambda state: state + b'begun at' + bytes(8), None),
        (lambda state: state[:-8], 'a state of this scene has'),
        (lambda state: b'', 'a state of this scene has'),
        (lambda state: b'\xff' * len(state), 'restore: 31 of 31 numbers of the state are not'),
        (lambda state: np.float64(math.inf).tobytes() + state[8:], 'restore: 1 of 31 numbers'),
    ],
)
def test_a_state_that_is_none_is_refused_and_all_stays(
    state: Callable[[bytes], bytes], reason: str | None
) -> None:
    simulation = Simulation(SCENE)
    simulation.step(3)
    before = simulation.state_bytes()
    if reason is None:
        simulation.restore(tick=3, state=state(before), slots={})
    else:
        with pytest.raises(InvalidModel, match=reason):
            simulation.restore(tick=7, state=state(before), slots={})
    assert simulation.state_bytes() == before and simulation.tick == 3


def test_a_state_that_tells_no_start_is_refused_where_forces_depend_on_time() -> None:
    acts = FORCES['time'](body='b', table=((0.001, 0.0, 0.0, 0.0), (0.004, 1.0, 0.0, 0.0)))
    simulation = Simulation(replace(SCENE, forces=(acts,)))
    simulation.step(3)
    simulation.reset()
    before = simulation.state_bytes()
    with pytest.raises(InvalidModel, match='does not tell when its scene began'):
        simulation.restore(tick=7, state=before[:-8], slots={})
    assert simulation.state_bytes() == before and simulation.tick == 3


def test_a_state_later_than_time_is_counted_is_refused_and_all_stays() -> None:
    simulation = Simulation(SCENE)
    last = 2**63 // simulation.dt_ns  # time is counted in 64 bits of nanoseconds
    for tick in (last + 1, 10**400):
        with pytest.raises(InvalidModel, match='a whole number from 0 to'):
            simulation.restore(tick=tick, state=simulation.state_bytes(), slots={})
    simulation.restore(tick=last - 1, state=simulation.state_bytes(), slots={})
    simulation.reset()  # counts time from there; the state tells it in 64 bits
    assert simulation.tick == last - 1 and simulation.state_bytes()


def test_the_inertia_of_a_body_is_a_copy() -> None:
    inertia = np.diag([1.0, 2.0, 2.5])
    body = Body('a', Box((1.0, 1.0, 1.0)), 1.0, inertia=inertia)
    inertia *= 9.0
    assert body.inertia is not None and body.inertia.tolist() == np.diag([1, 2, 2.5]).tolist()
    assert replace(body, mass=2.0).inertia is body.inertia


def test_what_a_simulation_is_of_cannot_be_set() -> None:
    simulation = Simulation(SCENE)
    simulation.step(2)
    for name in (
        *('scene', 'dt', 'dt_ns', 'time', 'tick', 'scene_time', 'state', 'integrator'),
        *('choice', 'choices', 'watch', 'invariants', 'stability'),
    ):
        with pytest.raises(AttributeError, match=r"no setter|can't set"):
            setattr(simulation, name, getattr(simulation, name))


@pytest.mark.parametrize(
    'copied', [copy.copy, copy.deepcopy, lambda simulation: pickle.loads(pickle.dumps(simulation))]
)
def test_a_copy_goes_on_bit_for_bit_and_alone(copied: Callable[[Simulation], Simulation]) -> None:
    simulation = Simulation(SCENE)
    simulation.step(3)
    simulation.reset()
    simulation.hold('b', 'wrench', force=(1, 0, 2), until=8)
    simulation.step(2)
    other = copied(simulation)
    assert (other.tick, other.time, other.scene_time) == (
        5,
        simulation.time,
        simulation.scene_time,
    )
    before = simulation.state_bytes()
    other.step(10)
    assert simulation.state_bytes() == before
    simulation.step(10)
    assert other.state_bytes() == simulation.state_bytes()
    assert "'t'" in repr(other) and 'tick 15' in repr(other)
