# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A checkpoint goes on bit for bit; what is none, or damaged, is one error."""

import pickle

import pytest

import rigid_body_sim as rbs
from rigid_body_sim.library import checkpoint


def hold(sim):
    """
    Hold what turns, what ends, and a frame of a body where there is one; of bodies that touch
    without other forces nothing that turns: it takes a kernel of its own.
    """
    body = next(body for body in sim.scene.bodies if not body.fixed)
    touches = sim.scene.contact.get('mode', 'none') != 'none'
    sim.hold(body.name, 'force', force=(1, 0, 0.5), until=170)
    if not body.is_point and (sim.scene.forces or not touches):
        sim.set_wrench(body.name, torque=(0, 0, 0.1), frame='body')
    for frame in body.frames:
        sim.set_wrench(body.name, force=(0, 0, 0.1), frame=frame)


@pytest.mark.parametrize(
    ('scene', 'choices'),
    [
        ('satellite', {}),
        ('quadrotor', {}),
        ('rocket', {}),
        ('skater', {}),
        ('two_bodies', {'integrator': 'rk4', 'integrator_options': {'orientation': 'matrix'}}),
        ('stack', {'dt': 0.002}),
        ('deck_landing', {}),
        ('tetrahedron', {}),
    ],
)
def test_it_goes_on_bit_for_bit(scene, choices, tmp_path, request):
    if 'integrator' in choices:  # a kernel that no other test wants
        request.getfixturevalue('plain_source')
    sim = rbs.Simulation(scene, **choices)
    hold(sim)
    sim.step(100)
    sim.save(tmp_path / 'at_100')
    other = rbs.Simulation.load(tmp_path / 'at_100')
    assert type(other) is rbs.Simulation and other.dt == sim.dt and other.tick == 100
    sim.step(100)
    other.step(100)
    assert other.state_bytes() == sim.state_bytes() and other.held_slots == sim.held_slots
    assert other.scene_time == sim.scene_time
    assert [path.name for path in tmp_path.iterdir()] == ['at_100']


def test_sleepers_and_a_scene_after_its_reset_go_on_bit_for_bit(tmp_path):
    rest = {'mode': 'timestep', 'sleeping': True}
    ground = rbs.make_body('ground', rbs.Plane((0, 0, 1)))
    boxes = [
        rbs.make_body(f'b{k}', rbs.Box((0.2, 0.2, 0.2)), mass=1, position=(0, 0, 0.1 + 0.2 * k))
        for k in range(2)
    ]
    scene = rbs.make_scene([ground, *boxes], dt=0.004, gravity=(0, 0, -9.81), contact=rest)
    sim = rbs.Simulation(scene)
    sim.step(50)
    sim.reset()
    sim.step(500)  # asleep by now
    sim.save(tmp_path / 'asleep')
    other = rbs.Simulation.load(tmp_path / 'asleep')
    for one in (sim, other):
        one.apply_impulse('b1', linear=(0.5, 0, 0))  # which wakes them
        one.step(100)
    assert other.state_bytes() == sim.state_bytes() and other.scene_time == sim.scene_time


def test_auto_goes_on_with_what_it_saw(tmp_path):
    sim = rbs.Simulation('two_bodies', integrator='auto')
    sim.set_wrench('box', torque=(0, 0.1, 0))
    sim.step(30)  # in the middle of a look: a shadow goes along
    sim.save(tmp_path / 'auto')
    other = rbs.Simulation.load(tmp_path / 'auto')
    sim.step(1500)
    other.step(1500)
    assert other.state_bytes() == sim.state_bytes() and other.choices == sim.choices
    assert other.watch.looks == sim.watch.looks > 0


@pytest.fixture(scope='module')
def whole(tmp_path_factory):
    """The bytes of a checkpoint."""
    path = tmp_path_factory.mktemp('checkpoint') / 'file'
    rbs.Simulation('satellite').save(path)
    return path.read_bytes()


@pytest.mark.parametrize(
    ('damage', 'reason'),
    [
        (lambda whole: whole[:-1], 'damaged'),
        (lambda whole: whole + b'x', 'damaged'),
        (lambda whole: whole[:300] + bytes([whole[300] ^ 1]) + whole[301:], 'damaged'),
        (lambda whole: whole[:40] + b'0' + whole[41:], 'damaged'),
        (lambda whole: whole[:20], 'no checkpoint'),
        (lambda whole: b'', 'no checkpoint'),
        (lambda whole: pickle.dumps(print), 'no checkpoint'),
        (lambda whole: b'version: 1\n', 'no checkpoint'),
    ],
)
def test_every_damage_is_one_error(damage, reason, whole, tmp_path):
    (tmp_path / 'file').write_bytes(damage(whole))
    with pytest.raises(rbs.UserError, match=f'file: {reason}') as refused:
        rbs.Simulation.load(tmp_path / 'file')
    assert '\n' not in str(refused.value)


def test_every_flipped_byte_is_found(whole, tmp_path):
    for place in range(0, len(whole), max(1, len(whole) // 40)):
        changed = bytearray(whole)
        changed[place] ^= 0x10
        (tmp_path / 'file').write_bytes(changed)
        with pytest.raises(rbs.UserError):
            rbs.Simulation.load(tmp_path / 'file')


def test_a_file_that_would_start_code_starts_none(tmp_path):
    class Evil:
        def __reduce__(self):
            return print, ('started',)

    scene = rbs.load_scene('satellite')
    part = pickle.dumps(Evil())
    with pytest.raises(pickle.UnpicklingError, match='does not belong here'):
        checkpoint._unpacked_auto(part, scene)


def test_paths_that_cannot_be_are_refused(tmp_path):
    sim = rbs.Simulation('satellite')
    for path in (tmp_path, tmp_path / 'no' / 'file'):
        with pytest.raises(rbs.UserError):
            sim.save(path)
        with pytest.raises(rbs.UserError, match='cannot be read'):
            rbs.Simulation.load(path)
    assert not [*tmp_path.iterdir()]
