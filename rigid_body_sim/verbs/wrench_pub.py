# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
`wrench_pub BODY --force X Y Z …` publishes a command; `wrench_pub --bag BAG` those of a recording.

It waits until the node listens, at most 10 s.
"""

from __future__ import annotations

import argparse
import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model.named_frames import SEPARATOR
from rigid_body_sim.physics.model.scene import Vector
from rigid_body_sim.physics.validation import check_name
from rigid_body_sim.ros.playback import play_bag, publish_command
from rigid_body_sim.runs.commands import NO_VECTOR, Command
from rigid_body_sim.stop_signals import STOP, say

SUMMARY = 'publish commands to a body, or those of a bag'
TAKES_ROS_ARGUMENTS = True  # a launch file adds some; none means anything here
LEAST, MOST = 1e-6, 1e9  # [Hz], [s], [-] of the options
USUAL = {
    'frame': 'world',
    'rate': 100.0,  # [Hz]
    'seconds': 1.0,  # [s]
    'namespace': '',
    'rate_factor': 1.0,  # [-]
    'topics': [],
}  # what options are unless given
OF_A_COMMAND = ('force', 'torque', 'impulse', 'frame', 'rate', 'seconds', 'namespace')
OF_A_WRENCH = ('rate', 'seconds')
OF_A_BAG = ('rate_factor', 'topics')
MEANT = {'rate': '; how fast a bag is played is --rate-factor'}
_NUMBER = re.compile(r'-(\d|\.\d|inf|nan)', re.IGNORECASE)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command line."""
    parser._negative_number_matcher = _NUMBER  # argparse's own takes -1e-3 for an option
    vector = {'nargs': 3, 'type': float, 'metavar': ('X', 'Y', 'Z')}
    parser.add_argument('body', nargs='?', metavar='BODY', help='name of the body')
    parser.add_argument('--force', **vector, help='force [N], or with --impulse [N s]')
    parser.add_argument('--torque', **vector, help='torque [N m], or with --impulse [N m s]')
    parser.add_argument(
        '--frame',
        metavar='NAME',
        help='world (default), body, or a frame of the body: axes, and where the force acts',
    )
    parser.add_argument('--impulse', action='store_true', help='send an impulse, once')
    parser.add_argument(
        '--rate', type=float, metavar='HZ', help='messages per second, default 100'
    )
    parser.add_argument(
        '--for',
        type=float,
        metavar='S',
        dest='seconds',
        help='how long [s], default 1; then a zero wrench',
    )
    parser.add_argument('--namespace', metavar='NS', help='namespace of the node')
    parser.add_argument(
        '--bag',
        type=Path,
        metavar='BAG',
        help='send the commands of this bag, as they were spaced',
    )
    parser.add_argument(
        '--rate-factor', type=float, metavar='R', help='2 plays the bag twice as fast'
    )
    parser.add_argument(
        '--topics', nargs='+', metavar='TOPIC', help='only these topics of the bag'
    )


def run(arguments: argparse.Namespace) -> int:
    """Publish; 1 if nobody listens."""
    if (arguments.body is None) == (arguments.bag is None):
        raise UserError('give either the name of a BODY or --bag BAG')
    _refuse_ignored(arguments)
    for option, usual in USUAL.items():
        if getattr(arguments, option) is None:
            setattr(arguments, option, usual)
    for option in ('rate', 'seconds', 'rate_factor'):
        value = getattr(arguments, option)
        if not LEAST <= value <= MOST:
            raise UserError(f'{_name(option)} {value:g}; allowed: {LEAST:g} to {MOST:g}')
    STOP.keep()  # who is pushed gets a zero wrench at the end, however it comes
    count = _play(arguments) if arguments.bag is not None else _publish(arguments)
    print(f'{count} messages sent')
    if arguments.bag is None and SEPARATOR in _frame_id(arguments.body, arguments.frame):
        say(
            f'rigid_body_sim wrench_pub: the frame {arguments.frame!r} was sent as one of '
            f'{arguments.body!r}; a node whose scene has no frames: entry of that name for it '
            'refuses every message, and only its log says so; always known: world, body'
        )
    return 0


def _refuse_ignored(arguments: argparse.Namespace) -> None:
    """Refuse what is of another kind of sending, and would change nothing."""
    if arguments.bag is None:
        _refuse(arguments, OF_A_BAG, 'without --bag', 'is of a bag that is played', {})
        if arguments.impulse:
            _refuse(
                arguments, OF_A_WRENCH, '--impulse', 'is of a wrench; an impulse is sent once', {}
            )
        return
    sent = 'is of a command to a BODY; a bag is sent as it was recorded'
    _refuse(arguments, OF_A_COMMAND, f'--bag {arguments.bag}', sent, MEANT)


def _refuse(
    arguments: argparse.Namespace,
    options: Sequence[str],
    beside: str,
    reason: str,
    meant: Mapping[str, str],
) -> None:
    for option in options:
        if getattr(arguments, option) not in (None, False):
            raise UserError(
                f'{beside}: {_name(option)} {reason}; leave it out{meant.get(option, "")}'
            )


def _name(option: str) -> str:
    """Give an option as it stands on the command line."""
    return '--for' if option == 'seconds' else f'--{option.replace("_", "-")}'


def _play(arguments: argparse.Namespace) -> int:
    return play_bag(arguments.bag, topics=arguments.topics, rate_factor=arguments.rate_factor)


def _publish(arguments: argparse.Namespace) -> int:
    if not (arguments.force or arguments.torque):
        raise UserError('give --force X Y Z, --torque X Y Z, or both')
    check_name(arguments.body)
    for option in ('force', 'torque'):
        numbers = getattr(arguments, option) or NO_VECTOR
        if not all(map(math.isfinite, numbers)):
            raise UserError(f'--{option} {" ".join(map(str, numbers))}; allowed: finite numbers')
    command = Command(
        arguments.body,
        'impulse' if arguments.impulse else 'wrench',
        _vector(arguments.force),
        _vector(arguments.torque),
        _frame_id(arguments.body, arguments.frame),
    )
    return publish_command(
        command, namespace=arguments.namespace, rate_hz=arguments.rate, seconds=arguments.seconds
    )


def _vector(numbers: Sequence[float] | None) -> Vector:
    x, y, z = numbers or NO_VECTOR
    return (x, y, z)


def _frame_id(body: str, frame: str) -> str:
    """Give the frame_id of a frame as it stands on the command line."""
    if frame == 'world':
        return ''
    if frame in ('body', body):
        return body
    name = frame.removeprefix(body + SEPARATOR)
    try:
        check_name(name, of='frame')
    except InvalidModel as error:
        raise UserError(
            f'--frame {frame}: {error}; allowed: world, body, a frame of {body!r}'
        ) from None
    return body + SEPARATOR + name
