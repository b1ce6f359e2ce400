# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Wishes from other threads that wait for a tick boundary: services and live parameters.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Generator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

ENDED = 'the run has ended'


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
        return self.put(Request(name, value, told))

    def put(self, request: Request) -> Request:
        """Add a wish that was made before, and wake whoever serves them."""
        self.waiting.append(request)
        self._call()
        return request


class Answered:
    """
    To be awaited: goes on when a request is answered, or nobody is left to answer it.

    has_ended : whether the run has ended
    """

    def __init__(self, request: Request, has_ended: Callable[[], bool]) -> None:
        self._request = request
        self._has_ended = has_ended

    def __await__(self) -> Generator[None, None, Answer]:
        request, looks = self._request, 0
        while not request.answered.is_set():
            looks += self._has_ended()
            if looks > 1:  # the run answers what it finds when it ends, and nothing after that
                request.give(Answer(False, ENDED))
            else:
                yield
        assert request.answer is not None
        return request.answer
