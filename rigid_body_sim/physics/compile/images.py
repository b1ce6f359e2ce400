# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Where the image of a kernel comes from: the cache on disk, else what came with the package (an
image for the level of this processor, or bitcode), else numba.

What was made is kept as it was asked for: the image under the processor. What is shipped is under
none, or under a level of x86-64 (`processors`). Damage is found (`kernel_files`) and mended by
making it anew. Before the first image of a kind is trusted, a probe is made in the same way and
called (`Images.is_trusted`, `Images.of_level`): the convention by which numba's code takes its
arguments is numba's own, and where numpy keeps its arrays is numpy's.

None in place of an image means: by way of numba, see `kernels`. So it is where the system is not
Linux on x86-64, where numba was given settings (NUMBA_BOUNDSCHECK, NUMBA_OPT …), and for a kernel
whose arguments or result an image cannot take. For which processor code is made can be said as to
numba (NUMBA_CPU_NAME, NUMBA_CPU_FEATURES): images know for which one they were made.
"""

from __future__ import annotations

import lzma
import os
import threading
import zlib
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from rigid_body_sim.physics.compile.elf import UnknownCode
from rigid_body_sim.physics.compile.image import load, packed, unpacked
from rigid_body_sim.physics.compile.kernel_files import read_whole, write_whole
from rigid_body_sim.physics.compile.probe import PROBED, agrees, probe, probe_arguments
from rigid_body_sim.physics.compile.processors import LEVELS, TOLD, level
from rigid_body_sim.physics.compile.wanted import Wanted, release_of

_HARMLESS = {'NUMBA_CACHE_DIR', 'NUMBA_NUM_THREADS', 'NUMBA_THREADING_LAYER', *TOLD}
_MAKING = threading.RLock()
Image = Callable[..., Any]  # see `image`


def numba_is_set() -> bool:
    """Whether somebody set numba: then it is asked, and makes and runs all kernels itself."""
    settings = {name for name in os.environ if name.startswith('NUMBA_')} - _HARMLESS
    return bool(settings) or Path('.numba_config.yaml').exists()


class Images:
    """
    The images of a process.

    folder      : of the cache; None: nothing is kept
    shipped     : folder of what came with the package, or is to be shipped
    takes_level : whether an image for the level of this processor does; else one is made for
                  exactly this processor
    made        : names of the kernels whose images this process has made
    """

    def __init__(self, folder: Path | None, shipped: Path | None) -> None:
        self.folder, self.shipped = folder, shipped
        self.takes_level = True
        self.made: list[str] = []
        self._saves = False  # whether all that is asked for is kept there, to be shipped
        self._trusts: bool | None = None  # None: not yet tried
        self._trusts_level: bool | None = None

    def save_to(self, folder: Path) -> None:
        """Keep from now on the bitcode of all that is asked for in a folder, and its images."""
        folder.mkdir(parents=True, exist_ok=True)
        self.shipped, self._saves = folder, True

    def find(self, wanted: Wanted) -> Image | None:
        """Give the image of a kernel, made now if need be; None: go by way of numba."""
        with _MAKING:
            try:
                found = None if self._saves else self.kept(wanted) or self.of_level(wanted)
                if found is None and self.is_trusted():
                    found = self.make(wanted)
            except (ImportError, UnknownCode, OSError, RuntimeError, NotImplementedError):
                return None  # numba tells, if there is anything to tell
            return found

    def kept(self, wanted: Wanted) -> Image | None:
        """Give the image that is kept of a kernel; None where none is whole."""
        if self.folder is None:
            return None
        content = read_whole(*wanted.image_file(self.folder))
        return None if content is None else _loaded(content, wanted)

    def of_level(self, wanted: Wanted) -> Image | None:
        """Give the image that was shipped for the level of this processor, if any."""
        if not self.takes_level:
            return None
        if self._trusts_level is None:
            probed = self._shipped_image(Wanted(probe, PROBED, ()))
            self._trusts_level = probed is not None and agrees(probed)
        return self._shipped_image(wanted) if self._trusts_level else None

    def _shipped_image(self, wanted: Wanted) -> Image | None:
        reached = level()
        if self.shipped is None or reached is None:
            return None
        path, key = wanted.shipped_image_file(self.shipped, reached)
        content = read_whole(path, key, of_any_user=True)
        with suppress(zlib.error):
            return None if content is None else _loaded(zlib.decompress(content), wanted)
        return None

    def make(self, wanted: Wanted) -> Image:
        """Make the image of a kernel, and keep it."""
        from rigid_body_sim.physics.compile.image_maker import make

        flat = make(self.bitcode(wanted))
        image = load(flat, wanted.name)
        if self.folder is not None:
            write_whole(*wanted.image_file(self.folder), packed(flat))
        self.made.append(wanted.name)
        return image

    def bitcode(self, wanted: Wanted) -> Any:
        """Give the bitcode of a kernel: shipped, or compiled by numba."""
        from rigid_body_sim.physics.compile.image_maker import Bitcode

        if self.shipped is not None:
            path, key = wanted.bitcode_file(self.shipped)
            content = read_whole(path, key, of_any_user=True)
            with suppress(ValueError, lzma.LZMAError):
                if content is not None:
                    return Bitcode.unpacked(lzma.decompress(content))
        from rigid_body_sim.physics.compile.numba_pipeline import linked

        found = linked(wanted.function, wanted.arguments, wanted.kinds)
        found = replace(found, widest=wanted.widest)
        if self.shipped is not None and self._saves:
            found = self._save(self.shipped, wanted, found)
        return found

    def _save(self, folder: Path, wanted: Wanted, bitcode: Any) -> Any:
        """Keep what is to be shipped of a kernel: its bitcode, which is given, and its images."""
        from rigid_body_sim.physics.compile.image_maker import closed, make

        found = closed(bitcode)
        contents = {wanted.bitcode_file(folder): lzma.compress(found.packed())}
        for name in LEVELS:
            content = zlib.compress(packed(make(found, level=name)), level=9)
            contents[wanted.shipped_image_file(folder, name)] = content
        for (path, key), content in contents.items():
            write_whole(path, key, content)
            with suppress(OSError):
                path.chmod(0o644)  # who installs it is not who runs it
        return found

    def is_trusted(self) -> bool:
        """
        Tell whether images of this release of numba take their arguments as `image_maker` hands
        them over: a probe is made, called and compared with its plain source. Once it has passed
        it is kept, and says so to the next process.
        """
        if self._trusts is None:
            self._trusts = False
            wanted = Wanted(probe, PROBED, probe_arguments())
            kept = None if self._saves else self.kept(wanted)
            self._trusts = agrees(kept or self.make(wanted))
            if not self._trusts and self.folder is not None:
                wanted.image_file(self.folder)[0].unlink(missing_ok=True)
        return self._trusts

    def has_worked(self) -> bool:
        """
        Tell whether an earlier process made images with what is installed, or whoever shipped the
        package made images or bitcode for it.
        """
        probed, files = Wanted(probe, PROBED, ()), []
        if self.folder is not None:
            files.append(probed.image_file(self.folder)[0])
        if self.shipped is not None:
            if release_of('llvmlite') is not None:
                files.append(probed.bitcode_file(self.shipped)[0])
            reached = level()
            if reached is not None:
                files.append(probed.shipped_image_file(self.shipped, reached)[0])
        return any(path.exists() for path in files)


def _loaded(content: bytes, wanted: Wanted) -> Image | None:
    try:
        return load(unpacked(content), wanted.name)
    except ValueError:
        return None
