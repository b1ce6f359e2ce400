# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Which processor this is, and what of machine code that was made beforehand runs on it.

A level of x86-64 is a set of what a processor can do (System V Application Binary Interface, AMD64
Architecture Processor Supplement, "Micro-Architecture Levels"): code for one runs on all that
reach it. Images are shipped for two of them: x86-64-v3 has vectors of four numbers, of nearly all
processors since 2015; x86-64-v4 of eight. Code for a level is as fast as that for exactly one
processor (0.92 to 1.04 times as long for 200 hulls, ten boxes, free bodies on a Zen 4).

A processor can be told (NUMBA_CPU_NAME, NUMBA_CPU_FEATURES): then code is made for what was told,
and no level is looked for.
"""

from __future__ import annotations

import os
import platform
import sys
from functools import cache

TOLD = ('NUMBA_CPU_NAME', 'NUMBA_CPU_FEATURES')
_TOLD_APART = ('vendor_id', 'cpu family', 'model', 'stepping', 'flags')
_HEAD_OF_OBJECTS = 16  # [B] count of references and type
# as Linux calls what a processor can do
_V3 = frozenset(
    'cx16 lahf_lm popcnt pni ssse3 sse4_1 sse4_2 '
    'abm avx avx2 bmi1 bmi2 f16c fma movbe xsave'.split()
)
_V4 = _V3 | frozenset('avx512f avx512bw avx512cd avx512dq avx512vl'.split())
LEVELS = {'x86-64-v4': _V4, 'x86-64-v3': _V3}  # what takes more comes first


@cache
def processor() -> str | None:
    """
    Tell this processor, and what is told of it, from others; None: images are not for it.
    """
    found = _described()
    if 'flags' not in found:
        return None
    told = [os.environ.get(name) for name in TOLD]
    return repr([*(found.get(key) for key in _TOLD_APART), *told])


@cache
def level() -> str | None:
    """Name the highest level that images are shipped for and this processor reaches, if any."""
    if any(os.environ.get(name) is not None for name in TOLD):
        return None
    can = frozenset(_described().get('flags', '').split())
    return next((name for name, needed in LEVELS.items() if needed <= can), None)


@cache
def _described() -> dict[str, str]:
    """Give what the system says of this processor; nothing where images are not for it."""
    if sys.platform != 'linux' or platform.machine() != 'x86_64' or sys.maxsize < 2**32:
        return {}
    if sys.implementation.name != 'cpython' or object.__basicsize__ != _HEAD_OF_OBJECTS:
        return {}  # a build of Python that keeps its objects otherwise (free-threaded, debug)
    try:
        with open('/proc/cpuinfo', encoding='ascii', errors='replace') as file:  # noqa: PTH123
            first = file.read(65536).partition('\n\n')[0]
    except OSError:
        return {}
    lines = (line.partition(':') for line in first.splitlines())
    return {key.strip(): value.strip() for key, _, value in lines}
