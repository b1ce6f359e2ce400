# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A compiled kernel as Python sees it: nothing is compiled, and numba not even imported, before it is
called, and then only if its image is not at hand.

    kernel(*arguments)   looks at each argument, and calls the image that takes such
    kernel.bind(*kept)   the same with all but the first three arguments known: a call that costs a
                         quarter of a microsecond; while it is used, no array of them may be moved
                         (numpy moves none that somebody else holds)

Whoever compiles a kernel that names another one takes its twin (`_numba_type_`).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import update_wrapper
from pathlib import Path
from types import FunctionType
from typing import Any

from rigid_body_sim.physics.compile.image import LEADING, Image, kinds_of
from rigid_body_sim.physics.compile.images import Images, Wanted


class Kernel:
    """
    A plain function and what is made of it.

    images  : where its images come from; None: numba runs it
    folder  : where numba keeps what it compiles, if anywhere
    inlined : whether it is to disappear inside its caller
    """

    def __init__(
        self,
        function: Callable[..., Any],
        images: Images | None,
        folder: Path | None,
        *,
        inlined: bool,
    ) -> None:
        assert isinstance(function, FunctionType)
        update_wrapper(self, function)
        self.py_func = function
        self._images = None if function.__defaults__ or function.__kwdefaults__ else images
        self._folder, self._inlined = folder, inlined
        self._found: dict[tuple[str, ...], Image | None] = {}
        self._by_numba: Any = None
        self._twin: Any = None

    def __repr__(self) -> str:
        return f'<kernel {self.__module__}.{self.__qualname__}>'

    @property
    def _numba_type_(self) -> Any:
        """What numba takes a global of this value for."""
        if self._twin is None:
            from rigid_body_sim.physics.compile import numba_pipeline

            made = numba_pipeline.twin(self.py_func, self._folder, inlined=self._inlined)
            self._twin = made
        return self._twin._numba_type_

    @property
    def by_numba(self) -> Any:
        """The kernel as numba runs it."""
        if self._by_numba is None:
            from rigid_body_sim.physics.compile import numba_pipeline

            made = numba_pipeline.Kernel(self.py_func, self._folder, inlined=self._inlined)
            self._by_numba = made
        return self._by_numba

    def image(self, arguments: tuple[Any, ...]) -> Image | None:
        """Give the image that takes such arguments; None: numba is to take them."""
        kinds = None if self._images is None else kinds_of(arguments)
        if kinds is None or self._images is None:
            return None
        if kinds not in self._found:
            self._found[kinds] = self._images.find(Wanted(self.py_func, kinds, arguments))
        return self._found[kinds]

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        """Run the kernel."""
        image = None if named else self.image(arguments)
        return (image or self.by_numba)(*arguments, **named)

    def bind(self, *kept: Any) -> Callable[[Any, Any, Any], Any]:
        """Give the kernel with all but its first three arguments."""
        entry, place, result = None, 0, None
        holds: list[Any] = []  # for good: another thread may be inside
        first = second = third = type(None)

        def call(a: Any, b: Any, c: Any) -> Any:
            if a.__class__ is first and b.__class__ is second and c.__class__ is third:
                got = entry(place, a, b, c)
                return got if got == got else result(got)
            return prepare(a, b, c)

        def prepare(a: Any, b: Any, c: Any) -> Any:
            nonlocal entry, place, result, first, second, third
            image = self.image((a, b, c, *kept))
            if image is None or image.leading != LEADING or image.returns != 'float64':
                return self(a, b, c, *kept)
            entry, place, held = image.prepared(kept)
            holds.append(held)
            result = image.result
            first, second, third = a.__class__, b.__class__, c.__class__
            return call(a, b, c)

        return call


def bind(kernel: Callable[..., Any], *kept: Any) -> Callable[[Any, Any, Any], Any]:
    """Give a kernel, compiled or plain, with all but its first three arguments."""
    if isinstance(kernel, Kernel):
        return kernel.bind(*kept)
    return lambda a, b, c: kernel(a, b, c, *kept)
