# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A compiled kernel as Python sees it: nothing is compiled, and numba not even imported, before it is
called, and then only if its image is not at hand.

A kernel has an image for each set of kinds that its arguments came in, of which most have one. The
last one is called at once; it looks at its arguments itself, and refuses others. Arguments that no
image takes (tuples, other arrays) go by way of numba, and so does all where there are no images.

Whoever compiles a kernel that names another one takes its twin (`_numba_type_`).
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from functools import update_wrapper
from pathlib import Path
from types import FunctionType
from typing import Any

import numpy as np

from rigid_body_sim.physics.compile.image import is_group, kinds_of, members, usual, with_last
from rigid_body_sim.physics.compile.images import Image, Images
from rigid_body_sim.physics.compile.wanted import Wanted


class Kernel:
    """
    A plain function and what is made of it.

    images  : where its images come from; None: numba runs it
    folder  : where numba keeps what it compiles, if anywhere
    inlined : whether it is to disappear inside its caller
    widest  : see `image_maker.Bitcode`
    """

    def __init__(
        self,
        function: Callable[..., Any],
        images: Images | None,
        folder: Path | None,
        *,
        inlined: bool,
        widest: bool,
    ) -> None:
        assert isinstance(function, FunctionType)
        update_wrapper(self, function)
        self.py_func = function
        self.__qualname__ = function.__qualname__
        self._images = None if function.__defaults__ or function.__kwdefaults__ else images
        self._folder, self._inlined, self._widest = folder, inlined, widest
        self._found: dict[tuple[str, ...], Image | None] = {}
        self._last: Image = _unknown
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
            try:
                from rigid_body_sim.physics.compile import numba_pipeline
            except ImportError as missing:  # there are images of another day, and no numba now
                self._by_numba = _plain(self.py_func, missing)
            else:
                made = numba_pipeline.Kernel(self.py_func, self._folder, inlined=self._inlined)
                self._by_numba = made
        return self._by_numba

    def _found_for(self, arguments: tuple[Any, ...]) -> Callable[..., Any]:
        """Give what takes such arguments: an image, or numba."""
        kinds = None if self._images is None else kinds_of(arguments)
        if kinds is None or self._images is None:
            return self.by_numba
        if kinds not in self._found:
            wanted = Wanted(self.py_func, kinds, arguments, self._widest)
            self._found[kinds] = self._images.find(wanted)
        image = self._found[kinds]
        if image is None:
            return self.by_numba
        self._last = image
        return lambda *these: image(*map(usual, members(these)))

    def prepared(
        self, first: Sequence[Any], last: Sequence[Any], *, brief: bool = False
    ) -> Callable[..., Any]:
        """Give the kernel with its last arguments at hand: see `kernels.prepared`."""
        arguments = (*first, *last)
        kinds = None if self._images is None else kinds_of(arguments)
        self._found_for(arguments)
        image = None if kinds is None else self._found[kinds]
        return behind(self, last) if image is None else with_last(image, last, brief=brief)

    def __call__(self, *arguments: Any) -> Any:
        """Run the kernel."""
        got = self._last(*arguments)
        if got is NotImplemented:
            return self._found_for(arguments)(*arguments)
        return got


class Transfer(Kernel):
    """
    A kernel whose twin is no plain source, but written down for LLVM (`lane_transfers`,
    `shared_numbers`).
    """

    @property
    def _numba_type_(self) -> Any:
        """What numba takes a global of this value for."""
        if self._twin is None:
            from rigid_body_sim.physics.compile import lane_transfers, shared_numbers

            name = self.py_func.__name__
            of_lanes = name in lane_transfers.DEFINITIONS
            self._twin = (lane_transfers if of_lanes else shared_numbers).numba_type(name)
        return self._twin


def behind(call: Callable[..., Any], last: Sequence[Any]) -> Callable[..., Any]:
    """Give what puts these arguments behind those that it is called with."""
    return lambda *first: call(*first, *last)


def _unknown(*_arguments: Any) -> Any:
    """Stand for an image before there is one."""
    return NotImplemented


def _plain(function: Callable[..., Any], missing: ImportError) -> Callable[..., Any]:
    """Give a kernel as plain Python, for arguments as the compiled one takes them."""
    if not WITHOUT:
        WITHOUT.append(without_numba(missing))
        warnings.warn(WITHOUT[0], RuntimeWarning, stacklevel=5)

    def viewed(value: Any) -> Any:
        if is_group(value):
            return type(value)(*map(viewed, value))
        return memoryview(value) if isinstance(value, np.ndarray) else value

    return lambda *arguments: function(*map(viewed, arguments))


WITHOUT: list[str] = []  # why some kernel runs as plain Python, though others are images


def without_numba(missing: ImportError) -> str:
    """Say what it costs that numba cannot be imported."""
    return (
        f'numba cannot be imported ({missing}): kernels run as plain Python, with the same bits '
        'but some 200 times slower, 700 times where bodies touch; pip install numba'
    )
