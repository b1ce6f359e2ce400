# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What the text of a scene or of a table of commands may call a number.

The decimal numbers of JSON, and those that C reads alike: a sign + in front (+1), a point with
digits on one side only (-.5, 2.). What YAML 1.1, C and Python read as different numbers is none:
010 (eight or ten?), 0x10, 0b11, 1_000, 1:30. Neither are infinity and NaN.
"""

from __future__ import annotations

import re

DECIMAL = re.compile(
    r'[-+]?(?:(?:0|[1-9][0-9]*)(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]+)?', re.ASCII
)
LOOKS_LIKE_ONE = re.compile(r'[-+.]?[0-9][0-9A-Za-z_:.+-]*', re.ASCII)
HOW = 'write it in decimal without leading zeros, as JSON and C do, such as 10, -0.5 or 1e-3'


def decimal(text: str) -> float | None:
    """Return the number that a text writes, infinity for one too large; None if it is none."""
    return float(text) if DECIMAL.fullmatch(text) else None


def cure(content: object) -> str:
    """Say how to write what looks like a number and is none; nothing for other things."""
    meant = isinstance(content, str) and LOOKS_LIKE_ONE.fullmatch(content) is not None
    return f'; {HOW}' if meant else ''
