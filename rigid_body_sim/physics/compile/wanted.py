# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Which kernel is wanted, and in which files it is kept: the name and the key of each say of what it
was made, so that what has changed since is not found.

    image in the cache    : for one processor, by what is installed now
    image that is shipped : for a level of x86-64 and this release of Python; which numpy there is
                            shows where it runs (`images.Images`)
    bitcode               : for any processor, of a format that this release of LLVM reads
"""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from dataclasses import dataclass
from functools import cache, cached_property
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from rigid_body_sim.physics.compile.image import FORMAT
from rigid_body_sim.physics.compile.kernel_files import named
from rigid_body_sim.physics.compile.processors import processor
from rigid_body_sim.physics.compile.sources import digest_of

_LONGEST = 100  # of the name of a kernel in that of a file


@cache
def release_of(package: str) -> str | None:
    """Give the release of an installed package without importing it; None where that fails."""
    loaded = sys.modules.get(package)
    if loaded is not None:
        return getattr(loaded, '__version__', None)
    with suppress(ImportError, ValueError, AttributeError, OSError):
        spec = find_spec(package)
        if spec is None or spec.origin is None:
            return None
        folder = Path(spec.origin).parent.parent
        begin = f'{package}-'
        (found,) = {
            name.removeprefix(begin).rpartition('.')[0]
            for name in os.listdir(folder)  # noqa: PTH208 (names are all that is wanted)
            if name.startswith(begin) and name.endswith(('.dist-info', '.egg-info'))
        }
        return found.partition('-py')[0]
    return None


def _releases() -> str:
    compilers = f'numba {release_of("numba")} llvmlite {release_of("llvmlite")}'
    return f'{FORMAT} {sys.implementation.cache_tag} numpy {np.__version__} {compilers}'


@dataclass(frozen=True)
class Wanted:
    """
    One kernel with one kind of each argument.

    function  : plain
    kinds     : of its arguments, see `image.kind_of`
    arguments : such as it is called with
    widest    : see `image_maker.Bitcode`
    """

    function: Any
    kinds: tuple[str, ...]
    arguments: tuple[Any, ...]
    widest: bool = True

    @property
    def name(self) -> str:
        """Give the name of the kernel, with the module that it stands in."""
        return f'{self.function.__module__.rpartition(".")[2]}.{self.function.__qualname__}'

    @cached_property
    def _told(self) -> str:
        return f'{_releases()} {digest_of(self.function)} {",".join(self.kinds)}'

    def image_file(self, folder: Path) -> tuple[Path, bytes]:
        """Name the file of its image for this processor, and the key of that."""
        key = f'image {processor()} {self._told}'.encode()
        return named(folder, self.name[:_LONGEST], key), key

    def shipped_image_file(self, folder: Path, level: str) -> tuple[Path, bytes]:
        """Name the file of its image for all processors that reach a level, and the key of it."""
        reader = f'{FORMAT} {sys.implementation.cache_tag}'
        return self._shipped(folder, f'image {level} {reader}')

    def bitcode_file(self, folder: Path) -> tuple[Path, bytes]:
        """Name the file of its bitcode, and the key of that."""
        readers = str(release_of('llvmlite')).rpartition('.')[0]  # of one format of bitcode
        return self._shipped(folder, f'bitcode {FORMAT} llvmlite {readers}')

    def _shipped(self, folder: Path, what: str) -> tuple[Path, bytes]:
        key = f'{what} {digest_of(self.function)} {",".join(self.kinds)}'.encode()
        return named(folder, self.name[:_LONGEST], key), key
