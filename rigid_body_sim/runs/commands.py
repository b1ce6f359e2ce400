# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Commands to bodies as they come from a topic, a file or a recording, and which of them are refused.

    kind      unit          lasts
    force     N             until the next force, or the command timeout
    torque    N m           until the next torque, or the command timeout
    wrench    N, N m        until the next wrench, or the command timeout
    impulse   N s, N m s    applied once, whatever the tick length
    set_state m, m/s, …     pose and twist from then on: `asked_states`

Force, torque and wrench add, and each named frame holds its own beside them.

`frame_id` is empty or the world frame (world axes), the name of the body (axes that turn with it),
or a frame of the body, `<body>/<frame>` or `<frame>` (its origin and its axes, as tf2 reads a
wrench); anything else is refused. A force acts at the origin of such a frame, and else at the
centre of mass.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.diagnostics.extreme_commands import least_moment
from rigid_body_sim.physics.errors import MOST_NAMED, InvalidModel
from rigid_body_sim.physics.model.finite_energy import CURE
from rigid_body_sim.physics.model.named_frames import (
    at_center,
    find_frame,
    frame_names,
    full_name,
    own_name,
)
from rigid_body_sim.physics.model.rotation import IDENTITY
from rigid_body_sim.physics.model.scene import Body, Frame, Scene, Vector
from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.topics import COMMAND_TYPES, body_topic
from rigid_body_sim.runs import asked_states
from rigid_body_sim.runs.asked_states import AskedState
from rigid_body_sim.scene import numerals, regular_file

KINDS = tuple(COMMAND_TYPES)
NO_VECTOR: Vector = (0.0, 0.0, 0.0)
MOST = 1e154  # [N], [N m], [N s], [N m s], whose square is still a number
USUAL = 1e9  # of the same, above which a command is looked at
LATEST = 2.0**31  # [s] what a stamp holds
FORCE_COLUMNS, TORQUE_COLUMNS = ('fx', 'fy', 'fz'), ('tx', 'ty', 'tz')
WRENCH_COLUMNS = FORCE_COLUMNS + TORQUE_COLUMNS
NOT_OF = {'force': TORQUE_COLUMNS, 'torque': FORCE_COLUMNS}  # their messages hold one vector
POSITION_COLUMNS, ORIENTATION_COLUMNS = ('x', 'y', 'z'), ('qx', 'qy', 'qz', 'qw')
TWIST_COLUMNS = ('vx', 'vy', 'vz', 'wx', 'wy', 'wz')
STATE_COLUMNS = POSITION_COLUMNS + ORIENTATION_COLUMNS + TWIST_COLUMNS
CSV_COLUMNS = ('time', 'body', 'kind', 'frame', *WRENCH_COLUMNS, *STATE_COLUMNS)


@dataclass(frozen=True)
class Command:
    """
    One command, before anybody judged it.

    force, torque : of an impulse, N s and N m s
    frame_id      : as it came
    stamp_ns      : time stamp of the sender [ns]; recorded, not used
    received      : the message in which it came, see `decode`; None if it was made here
    state         : of a set_state, what is asked for
    """

    body: str
    kind: str
    force: Vector = NO_VECTOR
    torque: Vector = NO_VECTOR
    frame_id: str = ''
    stamp_ns: int = 0
    received: bytes | None = field(default=None, compare=False, repr=False)
    state: AskedState | None = None

    @property
    def acts_at_once(self) -> bool:
        """Whether it changes the state before a tick does."""
        return self.kind in ('impulse', asked_states.KIND)

    @cached_property
    def message(self) -> bytes:
        """What is published and recorded of it: as it came, or encoded when first asked for."""
        return encode(self) if self.received is None else self.received


class CommandRules:
    """
    What a scene allows to be commanded.

    frame_prefix : stands before the names of frames of bodies; commands may leave it out
    also         : further words for frames that whoever asks takes, for messages
    commanded    : names of the bodies that take commands; None: all
    """

    def __init__(
        self,
        scene: Scene,
        *,
        world_frame: str = 'world',
        frame_prefix: str = '',
        also: tuple[str, ...] = (),
        commanded: Collection[str] | None = None,
    ) -> None:
        self._world_frame = world_frame
        self._frame_prefix = frame_prefix
        self._also = also
        self._commanded = None if commanded is None else frozenset(commanded)
        self._bodies = {body.name: body for body in scene.bodies}
        self._named = frozenset(name for body in scene.bodies for name in frame_names(body))

    def without_prefix(self, command: Command) -> Command:
        """Give the same command in frames without the prefix, where it names some of bodies so."""
        if not self._frame_prefix:
            return command
        command = replace(command, frame_id=self._bare(command.frame_id))
        if command.state is None:
            return command
        child = self._bare(command.state.child_frame_id)
        return replace(command, state=replace(command.state, child_frame_id=child))

    def _bare(self, name: str) -> str:
        """Take the prefix off a name of a frame that means something without and nothing with."""
        bare = name.removeprefix(self._frame_prefix)
        if name == self._world_frame or name in self._named:
            return name
        return bare if bare in self._named else name

    def frame(self, command: Command) -> str:
        """Frame of a command that was not refused, as `Simulation.hold` names it."""
        command = self.without_prefix(command)
        if command.frame_id in ('', self._world_frame):
            return 'world'
        if command.frame_id == command.body:
            return 'body'
        return own_name(self._bodies[command.body], command.frame_id)

    def refusal(self, command: Command) -> str | None:
        """Say why a command cannot be honoured, in one line; None if it can."""
        command = self.without_prefix(command)
        body = self._bodies.get(command.body)
        if body is None:
            return f'no body is named {command.body!r}; the scene has: {", ".join(self._bodies)}'
        if self._commanded is not None and body.name not in self._commanded:
            return (
                f'{body.name!r} has no topics of its own and takes no commands; name it in '
                'body_topics'
            )
        if body.motion is not None:
            return f'{body.name!r} moves as told and takes no commands; command another body'
        if body.fixed:
            return f'{body.name!r} is fixed; command a movable body'
        if command.state is not None:
            return asked_states.refusal(
                command.state,
                body,
                frame_id=command.frame_id,
                world_frame=self._world_frame,
                bodies=self._bodies,
            )
        frame = find_frame(body, command.frame_id)
        reason = self._refused_frame(command, body, frame)
        if reason is not None:
            return reason
        if not all(map(math.isfinite, (*command.force, *command.torque))):
            return f'{command.kind} for {body.name!r} is not finite; send finite numbers'
        if body.is_point and any(command.torque):
            return (
                f'torque on the point mass {body.name!r}, which has no orientation; send a force'
            )
        reason = _too_large(command, body)
        if reason is not None:
            return reason
        if body.is_point and self.frame(command) == 'body':
            return (
                f'{command.kind} in the axes of the point mass {body.name!r}, which has '
                'none; use the world frame'
            )
        if frame is not None:
            try:
                at_center(frame, command.force, command.torque)
            except InvalidModel as error:
                return f'{command.kind} for {body.name!r} in frame {command.frame_id!r}: {error}'
        return None

    def _refused_frame(self, command: Command, body: Body, frame: Frame | None) -> str | None:
        """Say why nobody knows which frame is meant, or whose; None where one does."""
        name, plain = command.frame_id, ('', self._world_frame, body.name)
        said = f'{command.kind} for {body.name!r} in frame {asked_states.quoted(name)}'
        if (name in plain) is not (frame is not None):
            return None
        allowed = (*plain, *self._also, *(full_name(body, own) for own in body.frames))
        listed = ', '.join(map(repr, allowed[:MOST_NAMED]))
        if frame is not None:
            return f'{said}, which is both the world frame and a frame of the body; rename one'
        owner = self._owner(name)
        whose = '' if owner is None else f', which is fixed to {owner!r}'
        return f'{said}{whose}; allowed: {listed}'

    def _owner(self, name: str) -> str | None:
        """Name the body that is called so, or has a frame that is."""
        for body in self._bodies.values():
            if name == body.name or find_frame(body, name) is not None:
                return body.name
        return None


def _too_large(command: Command, body: Body) -> str | None:
    """Say that work and energy of a command are beyond the numbers; None: they are not."""
    is_impulse, s = command.kind == 'impulse', ' s' * (command.kind == 'impulse')
    for values, unit in ((command.force, f'N{s}'), (command.torque, f'N m{s}')):
        size = math.hypot(*values)
        if size <= USUAL:
            continue
        most = MOST
        if is_impulse:  # J^2 / m, H^2 / I
            moment = least_moment(body) if values is command.torque else body.mass
            most *= math.sqrt(min(1.0, moment))
        if not size <= most:
            return (
                f'{command.kind} for {body.name!r} of {size:.3g} {unit}: its square is beyond the '
                f'numbers, and so would be its work; allowed: up to {most:.3g} {unit}; {CURE}'
            )
    return None


def frame_id_of(body: str, frame: str) -> str:
    """Give the `frame_id` of a frame that `Simulation.hold` knows: world, body, or another."""
    return {'world': '', 'body': body}.get(frame, frame)


def encode(command: Command) -> bytes:
    """Give the message of a command, padding zeroed."""
    if command.state is not None:
        return asked_states.encode(
            command.state, stamp_ns=command.stamp_ns, frame_id=command.frame_id
        )
    sec, nanosec = divmod(command.stamp_ns, 1_000_000_000)
    if command.kind in ('force', 'torque'):
        vector = command.force if command.kind == 'force' else command.torque
        return cdr.encode(cdr.Vector3Stamped(sec, nanosec, command.frame_id, vector))
    return cdr.encode(
        cdr.WrenchStamped(sec, nanosec, command.frame_id, command.force, command.torque)
    )


def decode(body: str, kind: str, data: bytes) -> Command:
    """
    Read the message of a command; CdrError if it is none.

    The command keeps the bytes as they came; only where they are big endian, or their padding is
    not zero, does it keep what `encode` writes in their place (`cdr.canonical`), so that equal
    commands are recorded with equal bytes.
    """
    message = cdr.decode(COMMAND_TYPES[kind], data)
    assert not isinstance(message, cdr.Clock | cdr.Described)
    stamp = message.sec * 1_000_000_000 + message.nanosec
    if isinstance(message, cdr.Odometry):
        return Command(
            body,
            kind,
            frame_id=message.frame_id,
            stamp_ns=stamp,
            state=asked_states.decode(message),
            received=cdr.canonical(message, data),
        )
    if isinstance(message, cdr.Vector3Stamped):
        force = message.vector if kind == 'force' else NO_VECTOR
        torque = message.vector if kind == 'torque' else NO_VECTOR
    else:
        assert isinstance(message, cdr.WrenchStamped)
        force, torque = message.force, message.torque
    received = cdr.canonical(message, data)
    return Command(body, kind, force, torque, message.frame_id, stamp, received)


def topics_of(bodies: Sequence[str], *, namespace: str) -> dict[str, tuple[str, str]]:
    """Name the command topics: topic -> (body, kind)."""
    return {
        body_topic(namespace, body, kind, '').name: (body, kind)
        for body in bodies
        for kind in KINDS
    }


def read_csv(
    path: Path, scene: Scene, *, dt_ns: int, commanded: Collection[str] | None = None
) -> list[tuple[int, Command]]:
    """
    Read timed commands: columns time [s], body, kind, frame (world, body, or a frame of the
    body), fx … tz; missing numbers but the time are zero; a force has no torque, nor a torque a
    force. A set_state has x, y, z, which it needs, qx … qw (none: turned as the world; else qw is
    needed), vx … wz in their place; frame (world or body) says the axes of the velocities.

    commanded : names of the bodies that take commands; None: all
    returns : (tick, command), ascending; a command takes effect at the first tick boundary not
              before its time
    """
    timed = regular_file.rows(
        path,
        lambda where, lines: _rows(
            where, lines, CommandRules(scene, commanded=commanded, also=('body',)), dt_ns
        ),
        wanted='a CSV file of commands',
    )
    return sorted(timed, key=lambda item: item[0])


def _rows(
    path: Path, lines: Iterator[str], rules: CommandRules, dt_ns: int
) -> Iterator[tuple[int, Command]]:
    reader = csv.DictReader(lines, skipinitialspace=True)
    _need_columns(path, tuple(reader.fieldnames or ()))
    for row in reader:
        where = f'{path}: line {reader.line_num}'
        if None in row or None in row.values():
            raise UserError(f'{where}: has not as many values as the header has columns')
        command = _command(where, row)
        reason = rules.refusal(command)
        if reason is not None:
            raise UserError(f'{where}: {reason}')
        yield -(-command.stamp_ns // dt_ns), command


def _need_columns(path: Path, columns: tuple[str, ...]) -> None:
    """Refuse a header with columns that nobody knows, without those that are needed, or twice."""
    allowed = f'needed: time, body, kind; allowed: {", ".join(CSV_COLUMNS)}'
    unknown = set(columns) - set(CSV_COLUMNS)
    missing = {'time', 'body', 'kind'} - set(columns)
    if unknown or missing:
        raise UserError(f'{path}: columns {", ".join(columns) or "none"}; {allowed}')
    twice = next((name for name in columns if columns.count(name) > 1), None)
    if twice is not None:
        raise UserError(
            f'{path}: columns {", ".join(columns)}: {twice} stands there {columns.count(twice)} '
            f'times; allowed: each once; {allowed}'
        )


def _command(where: str, row: dict[str, str]) -> Command:
    """Read the command of a line; what a scene allows is not asked here."""
    numbers = {
        name: _number(where, name, row.get(name))
        for name in ('time', *WRENCH_COLUMNS, *STATE_COLUMNS)
    }
    kind = row['kind']
    if kind not in KINDS:
        raise UserError(f'{where}: kind {kind!r}; allowed: {", ".join(KINDS)}')
    if not row['time'].strip():
        raise UserError(f'{where}: time is empty; allowed: 0 and more, below 2^31 s')
    if not 0.0 <= numbers['time'] < LATEST:
        raise UserError(f'{where}: time {numbers["time"]:g} s; allowed: 0 and more, below 2^31 s')
    others = WRENCH_COLUMNS if kind == asked_states.KIND else STATE_COLUMNS
    strange = [name for name in others if row.get(name)]
    if strange:
        raise UserError(f'{where}: {kind} has no {strange[0]}; leave empty: {", ".join(others)}')
    frame = row.get('frame') or 'world'
    frame_id = row['body'] if frame == 'body' else frame
    command = Command(row['body'], kind, stamp_ns=round(numbers['time'] * 1e9))
    if kind == asked_states.KIND:
        if frame not in ('world', 'body'):
            raise UserError(f'{where}: frame {frame!r} of a set_state; allowed: world, body')
        return replace(command, state=_state(where, row, numbers, frame_id))
    for name in NOT_OF.get(kind, ()):
        if numbers[name]:
            raise UserError(
                f'{where}: {kind} has no {name}, got {row[name]}; leave empty, or zero: '
                f'{", ".join(NOT_OF[kind])}; kind wrench has force and torque'
            )
    fx, fy, fz, tx, ty, tz = (numbers[name] for name in WRENCH_COLUMNS)
    return replace(command, force=(fx, fy, fz), torque=(tx, ty, tz), frame_id=frame_id)


def _state(
    where: str, row: dict[str, str], numbers: dict[str, float], frame_id: str
) -> AskedState:
    """Read the state that a line asks for; `frame_id` says the axes of its velocities."""
    x, y, z, qx, qy, qz, qw, vx, vy, vz, wx, wy, wz = (numbers[name] for name in STATE_COLUMNS)
    is_turned = any(row.get(name) for name in ORIENTATION_COLUMNS)
    needed = POSITION_COLUMNS + ORIENTATION_COLUMNS[-1:] * is_turned
    missing = [name for name in needed if not row.get(name)]
    if missing:
        raise UserError(
            f'{where}: {asked_states.KIND} without {missing[0]}, and it says where the body is '
            f'from then on; needed: {", ".join(POSITION_COLUMNS)}, and qw where it is turned; '
            'velocities that are left out are zero'
        )
    return AskedState(
        (x, y, z),
        (qx, qy, qz, qw) if is_turned else IDENTITY,
        (vx, vy, vz),
        (wx, wy, wz),
        child_frame_id=frame_id,
    )


def _number(where: str, name: str, text: str | None) -> float:
    if not text:
        return 0.0
    number = numerals.decimal(text.strip())
    if number is None:
        raise UserError(f'{where}: {name} {text!r}; allowed: a finite number{numerals.cure(text)}')
    if not math.isfinite(number):
        raise UserError(f'{where}: {name} {text!r}; allowed: a finite number')
    return number
