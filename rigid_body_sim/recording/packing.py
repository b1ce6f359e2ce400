# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
From the arrays of a tick to MCAP message records, in one pass.

A tick is a template: one structured record whose constant parts (framing, channel ids, frame
names, zeroed padding) are written once. Packing a tick assigns two time stamps and six arrays into
it. The published payloads are slices of the recorded bytes (`Batch.payloads`).

Records of the published tick k, in file order (dt_ns: tick length [ns]):

    applied wrenches      sequence k      stamp, log time k dt_ns        held from k to k + 1
    clock, poses, twists  sequence k + 1  stamp, log time (k + 1) dt_ns  the state reached

Before the first tick, number s, there are clock, poses and twists of sequence s alone.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from struct import Struct

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.errors import RunError
from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.batch import (
    MESSAGE_HEAD,
    MESSAGE_HEAD_SIZE,
    MESSAGE_LENGTH_EXTRA,
    MESSAGE_OPCODE,
    Batch,
    TickLayout,
)
from rigid_body_sim.recording.topics import CLOCK_TOPIC, Topic, body_topic

Array = NDArray[np.float64]

# What changes with the time alone: sequence, log and publish time, encapsulation, stamp.
_STAMP = Struct('<IQQ4siI')
_STAMP_OFFSET = 11
_STAMP_DTYPE = np.dtype(f'V{_STAMP.size}')
_CACHED_LAYOUTS = 256  # cached layouts of body subsets; more only costs building them again


class StatePacker:
    """
    Packs clock, poses, twists and applied wrenches of the given bodies.

    topics : what it writes; the channel id of topics[i] is first_channel_id + i
    """

    def __init__(
        self,
        bodies: Sequence[str],
        *,
        dt_ns: int,
        namespace: str = '',
        frame_id: str = 'world',
        first_channel_id: int = 1,
    ) -> None:
        def topics(
            leaf: str, kind: type[cdr.PoseStamped | cdr.TwistStamped | cdr.WrenchStamped]
        ) -> tuple[Topic, ...]:
            return tuple(body_topic(namespace, body, leaf, kind.TYPE) for body in bodies)

        count = len(bodies)
        tail = cdr.header_tail(frame_id)
        wrench = _record_dtype(tail, (3, 3))
        clock = _record_dtype(b'', ())
        pose = _record_dtype(tail, (3, 4))
        twist = _record_dtype(tail, (3, 3))
        self.topics = (
            *topics('applied_wrench', cdr.WrenchStamped),
            Topic(CLOCK_TOPIC, cdr.Clock.TYPE),
            *topics('pose', cdr.PoseStamped),
            *topics('twist', cdr.TwistStamped),
        )
        self._dt_ns = dt_ns
        self._first_channel_id = first_channel_id
        self._dtype = np.dtype(
            [
                ('wrench', wrench, count),
                ('clock', clock, 1),
                ('pose', pose, count),
                ('twist', twist, count),
            ]
        )
        kinds = [wrench] * count + [clock] + [pose] * count + [twist] * count
        self._layout = self._lay_out(
            range(len(self.topics)),
            sizes=[kind.itemsize for kind in kinds],
            time_offsets=[-dt_ns] * count + [0] * (2 * count + 1),
        )
        self._states_layout = self._lay_out(
            range(count, len(self.topics)),
            sizes=[kind.itemsize for kind in kinds[count:]],
            time_offsets=[0] * (2 * count + 1),
        )
        template = b''.join(
            _constant_parts(first_channel_id + index, kind, b'' if kind is clock else tail)
            for index, kind in enumerate(kinds)
        )
        self._block = bytearray(template)
        self._views = _Views(np.frombuffer(self._block, self._dtype)[0])
        self._wrench_dtype = wrench
        # bytes: numpy does not copy what lies between the fields of a structured array
        rows = np.frombuffer(template, np.uint8)[: count * wrench.itemsize]
        self._wrench_rows = rows.reshape(count, wrench.itemsize)
        self._wrench_layouts: dict[bytes, TickLayout] = {}
        self._before, self._after = _StampCell(), _StampCell()

    def pack(
        self,
        tick: int,
        *,
        position: Array,
        orientation: Array,
        velocity: Array,
        angular_velocity: Array,
        force: Array,
        torque: Array,
    ) -> Batch:
        """
        Pack one published tick.

        tick             : number of ticks done; the states are those at tick * dt_ns
        position         : (n, 3) [m]      world
        orientation      : (n, 4) [-]      xyzw, body to world
        velocity         : (n, 3) [m/s]    centre of mass, world
        angular_velocity : (n, 3) [rad/s]  world axes
        force, torque    : (n, 3) [N], [N m]  integrated over the last tick, world axes
        """
        time_ns = tick * self._dt_ns
        self._views.fill(
            self._before.set(tick - 1, time_ns - self._dt_ns),
            self._after.set(tick, time_ns),
            (position, orientation, velocity, angular_velocity, force, torque),
        )
        return Batch(self._layout, bytes(self._block), (time_ns,), tick)

    def pack_states(
        self,
        tick: int,
        *,
        position: Array,
        orientation: Array,
        velocity: Array,
        angular_velocity: Array,
    ) -> Batch:
        """Pack clock, poses and twists at tick * dt_ns, without the wrenches of a tick before."""
        time_ns = tick * self._dt_ns
        self._views.fill_states(
            self._after.set(tick, time_ns), (position, orientation, velocity, angular_velocity)
        )
        states = bytes(self._block[self._wrench_rows.size :])
        return Batch(self._states_layout, states, (time_ns,), tick)

    def split(self, batch: Batch) -> tuple[Batch, Batch]:
        """
        Cut a batch of `pack` into the wrenches of the tick and the states after it: what belongs
        to the same instant as the states, such as contacts, is written between the two.
        """
        cut = self._wrench_rows.size
        (time_ns,) = batch.times
        everybody = np.arange(len(self._wrench_rows))
        return (
            Batch(
                self._wrench_layout(everybody), batch.data[:cut], (time_ns - self._dt_ns,), None
            ),
            Batch(self._states_layout, batch.data[cut:], batch.times, batch.tick),
        )

    def pack_wrenches(
        self, bodies: NDArray[np.int64], tick: int, *, force: Array, torque: Array
    ) -> Batch:
        """
        Pack the applied wrenches of some bodies for tick `tick`, between published ticks.

        bodies        : (m,)  their indices, ascending
        force, torque : (n, 3) [N], [N m]  of all bodies, world axes
        """
        time_ns = tick * self._dt_ns
        rows = self._wrench_rows[bodies]
        records = rows.view(self._wrench_dtype)[:, 0]
        records['stamp'] = self._before.set(tick, time_ns)
        records['first'] = force[bodies]
        records['second'] = torque[bodies]
        return Batch(self._wrench_layout(bodies), rows.tobytes(), (time_ns,), None)

    def _wrench_layout(self, bodies: NDArray[np.int64]) -> TickLayout:
        key = bodies.tobytes()
        layout = self._wrench_layouts.get(key)
        if layout is None:
            if len(self._wrench_layouts) >= _CACHED_LAYOUTS:
                self._wrench_layouts.clear()
            size = self._wrench_dtype.itemsize
            layout = self._lay_out(
                bodies.tolist(), sizes=[size] * len(bodies), time_offsets=[0] * len(bodies)
            )
            self._wrench_layouts[key] = layout
        return layout

    def _lay_out(
        self, indices: Sequence[int], *, sizes: Sequence[int], time_offsets: Sequence[int]
    ) -> TickLayout:
        return TickLayout.of_records(
            self.topics,
            self._first_channel_id,
            channels=[self._first_channel_id + index for index in indices],
            sizes=sizes,
            time_offsets=time_offsets,
        )


class BodyPacker:
    """
    One message of each body at a published tick, stamped as its states.

    kind   : its type: header and one or two parts of doubles
    topics : in the order of the bodies; the channel id of topics[i] is first_channel_id + i
    """

    def __init__(
        self,
        bodies: Sequence[str],
        *,
        leaf: str,
        kind: type[cdr.Stamped],
        namespace: str,
        frame_id: str,
        first_channel_id: int,
    ) -> None:
        self.topics = tuple(body_topic(namespace, body, leaf, kind.TYPE) for body in bodies)
        tail = cdr.header_tail(frame_id)
        record = _record_dtype(tail, [width for _, width in kind.PARTS])
        channels = range(first_channel_id, first_channel_id + len(bodies))
        self._block = bytearray(
            b''.join(_constant_parts(channel, record, tail) for channel in channels)
        )
        self._records = np.frombuffer(self._block, record)
        self._layout = TickLayout.of_records(
            self.topics,
            first_channel_id,
            channels=channels,
            sizes=[record.itemsize] * len(bodies),
            time_offsets=[0] * len(bodies),
        )
        self._stamp = _StampCell()

    def pack(
        self, sequence: int, time_ns: int, first: Array, second: Array | None = None
    ) -> Batch:
        """Pack the message of every body; a row of each part for each of them."""
        self._records['stamp'] = self._stamp.set(sequence, time_ns)
        self._records['first'] = first
        if second is not None:
            self._records['second'] = second
        return Batch(self._layout, bytes(self._block), (time_ns,), None)


class _Views:
    """The changing parts of a block of records, as arrays."""

    def __init__(self, block: np.void) -> None:
        wrench, clock, pose, twist = (block[name] for name in ('wrench', 'clock', 'pose', 'twist'))
        self._before = wrench['stamp']
        self._after = (clock['stamp'], pose['stamp'], twist['stamp'])
        self._arrays = tuple(
            kind[part] for kind in (pose, twist, wrench) for part in ('first', 'second')
        )

    def fill(
        self, before: NDArray[np.void], after: NDArray[np.void], arrays: tuple[Array, ...]
    ) -> None:
        self._before[...] = before
        self.fill_states(after, arrays)

    def fill_states(self, after: NDArray[np.void], arrays: tuple[Array, ...]) -> None:
        for stamp in self._after:
            stamp[...] = after
        for target, array in zip(self._arrays, arrays):
            target[...] = array


class _StampCell:
    """One stamp, rewritten in place."""

    def __init__(self) -> None:
        self._bytes = bytearray(_STAMP.size)
        self._array = np.frombuffer(self._bytes, _STAMP_DTYPE)[:1].reshape(())

    def set(self, sequence: int, time_ns: int) -> NDArray[np.void]:
        sec, nanosec = divmod(time_ns, 1_000_000_000)
        try:
            _STAMP.pack_into(
                self._bytes, 0, sequence, time_ns, time_ns, cdr.ENCAPSULATION, sec, nanosec
            )
        except struct.error as error:
            raise RunError(
                f'recording: tick {sequence} at {sec} s does not fit in a message; '
                'allowed: ticks below 2^32 and times below 2^31 s; choose a shorter run'
            ) from error
        return self._array


def _record_dtype(tail: bytes, widths: Sequence[int]) -> np.dtype[np.void]:
    """
    Return the dtype of one message record with its changing parts alone.

    tail   : bytes of the payload between the stamp and the doubles
    widths : numbers of doubles in the message's one or two parts; none for a clock
    """
    parts = [('<f8', (width,)) for width in widths]
    start = _STAMP_OFFSET + _STAMP.size + len(tail)
    offsets = [_STAMP_OFFSET, *(start + 8 * sum(widths[:part]) for part in range(len(widths)))]
    return np.dtype(
        {
            'names': ['stamp', 'first', 'second'][: 1 + len(parts)],
            'formats': [_STAMP_DTYPE, *parts],
            'offsets': offsets,
            'itemsize': start + 8 * sum(widths),
        }  # type: ignore[arg-type]  # numpy's own stubs do not know this form with subarrays
    )


def _constant_parts(channel: int, record: np.dtype[np.void], tail: bytes) -> bytes:
    """Return a record with everything that never changes."""
    length = record.itemsize - MESSAGE_HEAD_SIZE + MESSAGE_LENGTH_EXTRA
    head = MESSAGE_HEAD.pack(MESSAGE_OPCODE, length, channel, 0, 0, 0)
    return (head + bytes(12) + tail).ljust(record.itemsize, b'\0')
