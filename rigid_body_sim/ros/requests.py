# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Wishes from other threads that wait for a tick boundary: services and live parameters.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple


class Answer(NamedTuple):
    """Whether a wish was granted, and one line about it."""

    granted: bool
    message: str


@dataclass
class Request:
    """
    One wish.

    name  : pause, step, reset, record, or the name of a live parameter
    value : what it is about
    """

    name: str
    value: float = 0.0
    answer: Answer | None = None
    answered: threading.Event = field(default_factory=threading.Event)

    def give(self, answer: Answer) -> None:
        """Answer it; the first answer counts."""
        if self.answer is None:
            self.answer = answer
            self.answered.set()


class RequestQueue:
    """
    Requests in the order in which they were made; looking at `waiting` costs nothing.

    call : wakes whoever serves them; None: they wait for `wake`
    """

    def __init__(self, call: Callable[[], object] | None = None) -> None:
        self.waiting: deque[Request] = deque()
        self.wake = threading.Event()
        self._call = call or self.wake.set

    def post(self, name: str, value: float = 0.0) -> Request:
        """Add a wish and wake whoever serves them."""
        request = Request(name, value)
        self.waiting.append(request)
        self._call()
        return request
