# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Warnings of a run on standard error, a line each, beside a progress bar or without one."""

from __future__ import annotations

from collections.abc import Callable

from rigid_body_sim.terminal import write_beside_bars


def warning_printer(verb: str) -> Callable[[str], None]:
    """Make what prints the warnings of a verb."""

    def warn(text: str) -> None:
        write_beside_bars(f'rigid_body_sim {verb}: warning: {text}')

    return warn
