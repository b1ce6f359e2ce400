# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What is packed is what is published, recorded, and read back, bit for bit.
"""

import numpy as np
import pytest

from rigid_body_sim.errors import RunError
from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.packing import StatePacker

DT_NS = 1_000_000


def decoded(batch, packer):
    """
    Topic -> message.
    """
    topics = dict(enumerate(packer.topics, start=1))
    return {
        topics[channel].name: cdr.decode(topics[channel].type, payload)
        for channel, payload in batch.payloads()
    }


def test_a_tick_holds_the_arrays_bit_for_bit(run):
    arrays = run.arrays(5)
    arrays['position'][0] = (-0.0, np.nan, 5e-324)
    found = decoded(run.packer.pack(5, **arrays), run.packer)
    parts = {
        'pose': {'position': 'position', 'orientation': 'orientation'},
        'twist': {'linear': 'velocity', 'angular': 'angular_velocity'},
        'applied_wrench': {'force': 'force', 'torque': 'torque'},
    }
    for index, body in enumerate(run.bodies):
        for leaf, names in parts.items():
            message = found[f'/{body}/{leaf}']
            for part, name in names.items():
                values = np.array(getattr(message, part))
                assert values.tobytes() == arrays[name][index].tobytes()
            assert message.frame_id == 'world'


def test_wrenches_carry_the_start_of_the_tick_and_states_its_end(run):
    found = decoded(run.packer.pack(2001, **run.arrays(1)), run.packer)
    assert found['/clock'] == cdr.Clock(2, 1_000_000)
    for body in run.bodies:
        assert (found[f'/{body}/pose'].sec, found[f'/{body}/pose'].nanosec) == (2, 1_000_000)
        assert (found[f'/{body}/twist'].sec, found[f'/{body}/twist'].nanosec) == (2, 1_000_000)
        wrench = found[f'/{body}/applied_wrench']
        assert (wrench.sec, wrench.nanosec) == (2, 0)


@pytest.mark.parametrize('frame_id', ['', 'map', 'odom', 'world', 'a_long_frame', 'Bezug_ä'])
def test_packed_payloads_are_what_the_encoder_writes(run, frame_id):
    packer = StatePacker(run.bodies, dt_ns=DT_NS, namespace='/lab/', frame_id=frame_id)
    assert packer.topics[0].name == '/lab/box/applied_wrench'
    batch = packer.pack(7, **run.arrays(7))
    types = {number: topic.type for number, topic in enumerate(packer.topics, start=1)}
    for channel, payload in batch.payloads():
        assert payload == cdr.encode(cdr.decode(types[channel], payload))


def test_wrenches_of_some_bodies_are_theirs(make_run):
    run = make_run(tuple('abcdefg'))
    arrays = run.arrays(4)
    chosen = np.array([1, 4])
    batch = run.packer.pack_wrenches(chosen, 3, force=arrays['force'], torque=arrays['torque'])
    found = decoded(batch, run.packer)
    assert list(found) == ['/b/applied_wrench', '/e/applied_wrench']
    for index, message in zip(chosen, found.values()):
        assert message == cdr.WrenchStamped(
            0, 3_000_000, 'world', tuple(arrays['force'][index]), tuple(arrays['torque'][index])
        )
    whole = run.packer.pack_wrenches(
        np.arange(7), 3, force=arrays['force'], torque=arrays['torque']
    )
    assert run.packer.pack(4, **arrays).data.startswith(whole.data)


def test_equal_inputs_give_equal_bytes(run, make_run):
    assert run.state(5).data == make_run().state(5).data


@pytest.mark.parametrize('tick', [2**32, -1, 2**31 * 1000])
def test_a_tick_beyond_the_message_is_refused(run, tick):
    with pytest.raises(RunError, match='does not fit'):
        run.packer.pack(tick, **run.arrays(1))


def test_a_time_beyond_the_stamp_is_refused(run):
    packer = StatePacker(run.bodies, dt_ns=10**9)
    with pytest.raises(RunError, match='2\\^31 s'):
        packer.pack(2**31, **run.arrays(1))
