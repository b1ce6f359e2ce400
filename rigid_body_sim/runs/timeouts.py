# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Times after which something ends, in seconds as users give them; zero stands for never.

What would be rounded to zero nanoseconds is none of them: it would never end.
"""

from __future__ import annotations

LEAST, MOST = 1e-9, 1e9  # [s]


def timeout_problem(name: str, seconds: float, *, never: str) -> str | None:
    """
    Say why a timeout cannot be used; None where it can.

    name  : of the option or parameter
    never : what zero means, in words
    """
    if seconds == 0.0 or LEAST <= seconds <= MOST:
        return None
    return f'{name}: got {seconds:g} s; allowed: 0 ({never}), or {LEAST:g} to {MOST:g} s'
