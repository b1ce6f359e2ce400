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
from typing import Any, NamedTuple


class Answer(NamedTuple):
    """Whether a wish was granted, and one line about it."""

    granted: bool
    message: str


@dataclass
class Request:
    """
    One wish.

    name  : pause, step, steps, stop_steps, reset, record, visit, quit, or a live parameter
    value : what it is about; of `visit`, what to do with the run at its tick boundary
    told  : is called when it is answered, by whoever answers it
    """

    name: str
    value: Any = 0.0
    told: Callable[[], object] | None = None
    answer: Answer | None = None
    answered: threading.Event = field(default_factory=threading.Event)

    def give(self, answer: Answer) -> None:
        """Answer it; the first answer counts."""
        if self.answer is None:
            self.answer = answer
            self.answered.set()
            if self.told is not None:
                self.told()


class RequestQueue:
    """
    Requests in the order in which they were made; looking at `waiting` costs nothing.

    call : wakes whoever serves them; None: they wait for `wake`
    """

    def __init__(self, call: Callable[[], object] | None = None) -> None:
        self.waiting: deque[Request] = deque()
        self.wake = threading.Event()
        self._call = call or self.wake.set

    def post(
        self, name: str, value: Any = 0.0, told: Callable[[], object] | None = None
    ) -> Request:
        """Add a wish and wake whoever serves them."""
        request = Request(name, value, told)
        self.waiting.append(request)
        self._call()
        return request
