# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a test commands: vectors, or a wrench with its frame; and the messages that carry them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from rigid_body_sim.physics.model.scene import Vector
from rigid_body_sim.runs.commands import Command, encode, frame_id_of
from rigid_body_sim.runs.wrench import Wrench

FORMS = {
    'force': 'three numbers [N]',
    'torque': 'three numbers [N m]',
    'wrench': 'a Wrench, or six numbers [N, N m]',
    'impulse': 'a Wrench, or six numbers [N s, N m s]',
}


def as_wrench(kind: str, value: Any, *, where: str) -> Wrench:
    """
    Read what was given for a command; ValueError, which says where, if it is none.

    kind  : force, torque, wrench or impulse
    value : Wrench; three numbers for a force or torque, six for the others; None for nothing
    """
    wrench = _read(kind, value, where)
    if not all(map(math.isfinite, (*wrench.force, *wrench.torque))):
        raise ValueError(f'{where}: got {value!r}; finite numbers are needed')
    unused = {'force': wrench.torque, 'torque': wrench.force}.get(kind, ())
    if any(unused):
        raise ValueError(f'{where}: got {value!r}; this topic carries the {kind} alone')
    return wrench


def _read(kind: str, value: Any, where: str) -> Wrench:
    if value is None:
        return Wrench()
    try:
        if isinstance(value, Wrench):
            return Wrench(_triple(value.force), _triple(value.torque), value.frame)
        if kind == 'force':
            return Wrench(force=_triple(value))
        if kind == 'torque':
            return Wrench(torque=_triple(value))
        first, second = (value[:3], value[3:]) if len(value) == 6 else value
        return Wrench(_triple(first), _triple(second))
    except (TypeError, ValueError, IndexError):
        raise ValueError(f'{where}: got {value!r}; allowed: {FORMS[kind]}') from None


def _triple(numbers: Sequence[float]) -> Vector:
    if isinstance(numbers, str):
        raise TypeError('a text')
    x, y, z = numbers
    return (float(x), float(y), float(z))


def message_of(kind: str, wrench: Wrench, *, body: str, stamp: int) -> bytes:
    """
    Give the bytes of a command.

    stamp : [ns]
    """
    frame = frame_id_of(body, wrench.frame)
    force, torque = _triple(wrench.force), _triple(wrench.torque)
    return encode(Command(body, kind, force, torque, frame, stamp))
