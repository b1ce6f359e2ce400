# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The tick length dt as a whole number of nanoseconds, so that time is k * dt_ns in integers.

A decimal number of seconds is taken as it is written: 0.001 means one million nanoseconds,
although no binary floating-point number equals 0.001; 1/3 is refused, not rounded.
"""

from decimal import Decimal

from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model.numbers import is_number, shown

NANOSECONDS = Decimal(1_000_000_000)  # [ns/s]
NEAR = Decimal('1e-6')  # [-] how near a time must be to a whole number of ticks, of itself
LONGEST_NS = 2**63 - 1  # [ns] what a signed 64-bit stamp holds, 292 years


def tick_nanoseconds(dt: float) -> int:
    """
    Return dt [s] in nanoseconds; dt is read by the shortest decimal form of the number.

    Raises InvalidModel for what is no number, not positive, or not a whole number of nanoseconds.
    """
    if not is_number(dt) and not isinstance(dt, float):
        raise InvalidModel(f'got {shown(dt)}; dt is a finite number of seconds, such as 0.001')
    exact = Decimal(repr(float(dt))) * NANOSECONDS
    if not exact.is_finite() or exact <= 0:
        raise InvalidModel(
            f'{dt} s is not positive and finite; dt is at least 1e-09 s, for example 0.001'
        )
    if exact > LONGEST_NS:
        raise InvalidModel(
            f'{dt} s is longer than 64 bits of nanoseconds hold; '
            f'the largest dt is {LONGEST_NS // 10**9} s'
        )
    nearest = max(1, round(exact))
    if exact != nearest:
        raise InvalidModel(
            f'{dt} s is not a whole number of nanoseconds; '
            f'the nearest allowed value is {nearest / NANOSECONDS:f} s'
        )
    return nearest


def whole_ticks(seconds: float, dt_ns: int, *, what: str) -> int:
    """
    Count the ticks of dt_ns [ns] in a time [s] of at least 0.

    what : the time, for messages

    Raises InvalidModel for what is no number, negative, beyond 64 bits of nanoseconds, or further
    than 1e-6 of itself from a whole number of ticks; the message names the nearest ones.
    """
    if not is_number(seconds) or not 0.0 <= seconds <= LONGEST_NS * 1e-9:
        raise InvalidModel(f'{what}: {shown(seconds)} s; allowed: a number of seconds from 0 on')
    exact = Decimal(repr(float(seconds))) * NANOSECONDS
    ticks = round(exact / dt_ns)
    if abs(ticks * dt_ns - exact) > NEAR * exact:
        dt, below = dt_ns / NANOSECONDS, int(exact // dt_ns)
        near = ' or '.join(f'{count * dt:g}' for count in (below, below + 1) if count)
        raise InvalidModel(
            f'{what}: {seconds:g} s is no whole number of ticks of {dt:g} s; '
            f'the nearest allowed: {near} s'
        )
    return ticks
