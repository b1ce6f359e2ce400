# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The parameters of the node: what each means, what it may be, and what was given.

A parameter is read once, at the start, unless it is live. What cannot be used ends the node with
exit code 2 before anything moves.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, TypeVar, cast

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.node import Node
from rclpy.parameter import Parameter

from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.errors import nearest
from rigid_body_sim.runs.timeouts import timeout_problem
from rigid_body_sim.runs.view import EVERY_BODY
from rigid_body_sim.runs.viewing import MARKER_RATE
from rigid_body_sim.runs.views import VIEWS

LARGEST = 1e9  # upper end of ranges that have no natural one
LEAST_FACTOR = 1e-9  # real-time factor; with less a tick would not come in years, or never
_BUILT_IN = ('use_sim_time', 'start_type_description_service', 'qos_overrides')


@dataclass(frozen=True)
class Entry:
    """
    One parameter.

    default : fixes the type; an empty tuple stands for a list of texts
    range   : smallest and largest number
    choices : allowed texts
    live    : may be changed while the node runs
    """

    name: str
    default: bool | int | float | str | tuple[str, ...]
    description: str
    range: tuple[float, float] | None = None
    choices: tuple[str, ...] = ()
    live: bool = False


T = TypeVar('T')


def parameter(
    default: T,
    description: str,
    range: tuple[float, float] | None = None,
    *,
    choices: tuple[str, ...] = (),
    live: bool = False,
) -> T:
    """Describe a parameter as `Entry` does, for a field of `Settings` of the type of `default`."""
    said = {
        'default': default, 'description': description, 'range': range, 'choices': choices,
        'live': live,
    }  # fmt: skip
    return cast('T', field(metadata=said))  # it has no default: each value is read from the node


@dataclass(frozen=True)
class Settings:
    """
    What the node was given: the parameters by name, after the checks.

    views : names of those whose parameter is true
    """

    scene: str = parameter(
        'demo',
        'path of a scene file, which may begin with ~/, or the name of a shipped scene',
    )
    dt: float = parameter(
        0.0,
        'tick length [s], a whole number of nanoseconds; 0.0: of the scene',
        (0.0, LARGEST),
    )
    integrator: str = parameter(
        '',
        'name of the integrator; empty: of the scene',
    )
    publish_rate: float = parameter(
        100.0,
        'states per second of simulation time [Hz], rounded to whole ticks',
        (1e-9, LARGEST),
    )
    real_time_factor: float = parameter(
        1.0,
        'seconds of simulation time per second of wall time, at least 1e-09; 0.0: as fast as '
        'possible',
        (0.0, LARGEST),
        live=True,
    )
    start_paused: bool = parameter(
        False,
        'start without moving; ~/step and ~/pause go on',
    )
    step_mode: str = parameter(
        'free',
        'free: time runs by itself; lockstep: it waits for the commands that answer its states',
        choices=('free', 'lockstep'),
    )
    lockstep_topics: tuple[str, ...] = parameter(
        (),
        'command topics that answer each state, such as satellite/torque, in the order in which '
        'the answers are applied; one that answers in several frames once for each, such as '
        'drone/wrench@front_left; for step_mode lockstep',
    )
    lockstep_stamps: bool = parameter(
        True,
        'an answer bears the stamp of its state; false: the first command that comes after the '
        'state was published is the answer, whatever its stamp',
    )
    lockstep_period: float = parameter(
        0.0,
        'simulation time between two states that are answered [s], a whole number of publishing '
        'periods; 0.0: one',
        (0.0, LARGEST),
    )
    lockstep_timeout: float = parameter(
        10.0,
        'how long answers may take [s of wall time] before the node counts as paused and names '
        'what is missing; it goes on when the answers come; at least 1e-09; 0.0: for ever',
        (0.0, LARGEST),
    )
    step_count: int = parameter(
        1,
        'ticks per call of ~/step',
        (1, 2**31 - 1),
        live=True,
    )
    command_timeout: float = parameter(
        0.2,
        'how long a held command lasts [s of simulation time], at least 1e-09; 0.0: until '
        'changed; not to be changed while recording',
        (0.0, LARGEST),
        live=True,
    )
    stop_time: float = parameter(
        0.0,
        'simulation time at which the node ends [s]; 0.0: never',
        (0.0, LARGEST),
        live=True,
    )
    record: bool = parameter(
        False,
        'record from the start',
    )
    record_path: str = parameter(
        '',
        'bag to write, its path may begin with ~/; empty: rigid_body_sim_<date>_<time> in the '
        'current folder',
    )
    world_frame: str = parameter(
        'world',
        'name of the world axes in frame_id',
    )
    error_estimate: bool = parameter(
        False,
        'let two finer runs go along and tell on /diagnostics how wrong the run is; six times the '
        'cost, on stiff scenes more',
    )
    publish_clock: bool = parameter(
        True,
        'publish simulation time on /clock',
    )
    publish_contacts: bool = parameter(
        False,
        'publish (and record) where bodies touch and with what force, on <body>/contacts; for '
        'scenes with contact',
    )
    views: frozenset[str] = parameter(frozenset(), 'a parameter of its own for each')
    marker_rate: float = parameter(
        MARKER_RATE,
        'messages of ~/markers per second of simulation time [Hz], rounded to published states',
        (1e-9, LARGEST),
    )
    arrow_scale: float = parameter(
        0.0,
        'length of the arrows of ~/markers [m/N]; 0.0: chosen from the scene',
        (0.0, LARGEST),
    )
    frame_prefix: str = parameter(
        '',
        'put before the names of frames of bodies (not the world frame), such as lab/; commands '
        'may leave it out',
    )
    body_topics: str = parameter(
        EVERY_BODY,
        'bodies that have topics of their own, for states and commands: names or patterns (* and '
        '?) separated by commas; none: no body, for crowds with publish_arrays',
    )
    diagnostics_period: float = parameter(
        1.0,
        'time between two messages on /diagnostics [s of wall time]',
        (0.05, LARGEST),
    )
    state_depth: int = parameter(
        0,
        'states that a topic keeps for a subscriber that lags [messages]; 0: 1000, in scenes with '
        'over 300 topics 300000 in all',
        (0, 1_000_000),
    )
    command_reliability: str = parameter(
        'reliable',
        'asked of the publishers of commands; best_effort takes every publisher, and may lose',
        choices=('reliable', 'best_effort'),
    )


def _entries() -> Iterator[Entry]:
    """Give the parameters in the order of their settings; each view has one of its own."""
    for one in fields(Settings):
        if one.name != 'views':
            yield Entry(one.name, **one.metadata)
            continue
        for view in VIEWS.values():
            yield Entry(view.parameter, False, f'publish (and record) {view.description}')


PARAMETERS = tuple(_entries())


def declare(node: Node) -> Settings:
    """Declare every parameter and read it; UserError for what cannot be used."""
    if node.get_parameter('use_sim_time').value:
        raise UserError(
            'parameter use_sim_time: got true; this node makes the simulation time on /clock and '
            'must not wait for it; leave use_sim_time out'
        )
    given = {entry.name: _declare(node, entry) for entry in PARAMETERS}
    views = frozenset(name for name, view in VIEWS.items() if given.pop(view.parameter))
    settings = Settings(views=views, **given)
    _judge_lockstep(settings)
    for name in ('real_time_factor', 'command_timeout', 'lockstep_timeout'):
        problem = problem_of(name, getattr(settings, name))
        if problem is not None:
            raise UserError(f'parameter {problem}')
    if not settings.world_frame or '\0' in settings.world_frame:
        raise UserError(
            f'parameter world_frame: got {settings.world_frame!r}; allowed: a name, such as world'
        )
    return settings


def problem_of(name: str, value: float) -> str | None:
    """Say why a parameter cannot have a value within its range; None where it can."""
    match name:
        case 'real_time_factor':
            return _factor_problem(value)
        case 'command_timeout':
            return timeout_problem(name, value, never='until changed')
        case 'lockstep_timeout':
            return timeout_problem(name, value, never='for ever')
    return None


def _factor_problem(factor: float) -> str | None:
    if factor == 0 or factor >= LEAST_FACTOR:
        return None
    return (
        f'real_time_factor: got {factor:g}; allowed: 0.0 (as fast as possible), or a number from '
        f'{LEAST_FACTOR:g} to {LARGEST:g}; to stand still, call ~/pause with true'
    )


def _judge_lockstep(settings: Settings) -> None:
    if settings.step_mode == 'free' and settings.lockstep_topics:
        raise UserError(
            f'parameter lockstep_topics: got {", ".join(settings.lockstep_topics)}, but step_mode '
            'is free and waits for nobody; add step_mode:=lockstep, or leave lockstep_topics out'
        )
    if settings.step_mode == 'lockstep' and settings.command_reliability != 'reliable':
        raise UserError(
            'parameter command_reliability: got best_effort; step_mode lockstep allows: reliable; '
            'it would wait for ever for an answer that was lost'
        )


def _declare(node: Node, entry: Entry) -> Any:
    try:
        if entry.default == ():
            value = _declare_texts(node, entry)
        else:
            value = node.declare_parameter(entry.name, entry.default, _descriptor(entry)).value
    except InvalidParameterTypeException as error:
        raise UserError(_type_problem(entry, str(error))) from None
    except InvalidParameterValueException as error:
        got = str(error).partition('(')[2].partition(')')[0]
        raise UserError(f'parameter {entry.name}: got {got}; allowed: {allowed(entry)}') from None
    if entry.choices and value not in entry.choices:
        raise UserError(f'parameter {entry.name}: got {value!r}; allowed: {allowed(entry)}')
    return value


def _declare_texts(node: Node, entry: Entry) -> tuple[str, ...]:
    """
    Declare a list of texts, which may be empty.

    ROS takes the default `[]` for a list of bytes, and a given `[]` for no value at all; one
    parameter without a value empties the answer to every request that asks for several. So the
    empty list is set, while the parameter may still be written.
    """
    kind = Parameter.Type.STRING_ARRAY
    descriptor = _descriptor(entry)
    descriptor.read_only = False
    if node.declare_parameter(entry.name, kind, descriptor).value is None:
        node.set_parameters([Parameter(entry.name, kind, [])])
    final = _descriptor(entry)
    final.type = kind.value
    node.set_descriptor(entry.name, final)
    return tuple(node.get_parameter(entry.name).value or ())


def _type_problem(entry: Entry, message: str) -> str:
    got = message.partition("' to '")[2].partition("' of type '")[0]
    problem = f'parameter {entry.name}: got {got}; allowed: {allowed(entry)}'
    if isinstance(entry.default, float) and got.lstrip('+-').isdigit():
        problem += f'; ROS tells whole from other numbers: write {got}.0'
    return problem


def allowed(entry: Entry) -> str:
    """Say in words what a parameter may be."""
    if entry.choices:
        return ', '.join(entry.choices)
    kind = {bool: 'true or false', int: 'a whole number', float: 'a number', str: 'a text'}.get(
        type(entry.default), 'a list of texts'
    )
    return f'{kind} from {entry.range[0]:g} to {entry.range[1]:g}' if entry.range else kind


def _descriptor(entry: Entry) -> ParameterDescriptor:
    descriptor = ParameterDescriptor(
        description=entry.description,
        read_only=not entry.live,
        additional_constraints=', '.join(entry.choices),
    )
    if entry.range:
        low, high = entry.range
        if isinstance(entry.default, float):
            descriptor.floating_point_range = [
                FloatingPointRange(from_value=low, to_value=high, step=0.0)
            ]
        else:
            descriptor.integer_range = [
                IntegerRange(from_value=int(low), to_value=int(high), step=1)
            ]
    return descriptor


def strangers(given: Sequence[str]) -> list[str]:
    """One warning for each given parameter that the node does not have."""
    known = [entry.name for entry in PARAMETERS]
    warnings = []
    for name in given:
        if name in known or name.partition('.')[0] in _BUILT_IN:
            continue
        near = nearest(name, known)
        hint = '' if near is None else f'; did you mean {near}?'
        warnings.append(f'parameter {name} is not one of this node and has no effect{hint}')
    return warnings


def help_text() -> str:
    """List the parameters for `--help`."""
    lines = ['parameters (-p name:=value; (live) ones may be changed while the node runs):']
    for entry in PARAMETERS:
        default = 'none' if entry.default == () else entry.default
        default = str(default).lower() if isinstance(default, bool) else default
        live = ' (live)' if entry.live else ''
        lines.append(f'  {entry.name} [{default if default != "" else "empty"}]{live}')
        lines.append(f'      {entry.description}; {allowed(entry)}')
    return '\n'.join(lines)
