# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a test is told when the node does not do what the test needs.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any, ParamSpec, TypeVar

LAST_LINES = 12  # of the node's output that a message shows


class NodeFailure(AssertionError):
    """
    The node refused, ended, hangs, or did not come to what was waited for.

    The message says what was asked, what was seen, and the last lines of the node where they help.
    """


def with_last_lines(problem: str, said: str, count: int = LAST_LINES) -> str:
    """
    Put the last lines of a node under a problem.
    """
    lines = said.strip().splitlines()
    if not lines:
        return f'{problem}; the node said nothing'
    shown = '\n'.join(f'    {line}' for line in lines[-count:])
    more = f' (of {len(lines)})' if len(lines) > count else ''
    return f'{problem}; the last lines of the node{more}:\n{shown}'


Given = ParamSpec('Given')
Result = TypeVar('Result')


def told_at_the_caller(function: Callable[Given, Result]) -> Callable[Given, Result]:
    """
    Let the traceback of a NodeFailure end at the line of the test.
    """

    @wraps(function)
    def told(*arguments: Given.args, **named: Given.kwargs) -> Any:
        __tracebackhide__ = True
        try:
            return function(*arguments, **named)
        except NodeFailure as failure:
            raise failure.with_traceback(None) from None

    return told
