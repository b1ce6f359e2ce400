# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Where the image of a kernel comes from: the cache on disk, else bitcode that came with the package,
else numba.

What was made is kept as it was asked for: the image under the processor, the bitcode (`shipped`)
under none. Damage is found (`kernel_files`) and mended by making it anew. Before the first image
of a kind is trusted, a probe is made in the same way and called (`_is_trusted`): the convention by
which numba's code takes its arguments is numba's own.

None in place of an image means: by way of numba, see `kernels`. So it is where the system is not
Linux on x86-64, where numba was given settings (NUMBA_BOUNDSCHECK, NUMBA_OPT …), and for a kernel
whose arguments or result an image cannot take. For which processor code is made can be said as to
numba (NUMBA_CPU_NAME, NUMBA_CPU_FEATURES): images know for which one they were made.
"""

from __future__ import annotations

import lzma
import os
import platform
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache, cached_property
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from rigid_body_sim.physics.compile.elf import UnknownCode
from rigid_body_sim.physics.compile.image import FORMAT, load, packed, unpacked
from rigid_body_sim.physics.compile.kernel_files import named, read_whole, write_whole
from rigid_body_sim.physics.compile.probe import PROBED, agrees, probe, probe_arguments
from rigid_body_sim.physics.compile.sources import digest_of

_TOLD = ('NUMBA_CPU_NAME', 'NUMBA_CPU_FEATURES')
_HARMLESS = {'NUMBA_CACHE_DIR', 'NUMBA_NUM_THREADS', 'NUMBA_THREADING_LAYER', *_TOLD}
_PROCESSOR = ('vendor_id', 'cpu family', 'model', 'stepping', 'flags')
_MAKING = threading.RLock()
Image = Callable[..., Any]  # see `image`
_HEAD_OF_OBJECTS = 16  # [B] count of references and type
_LONGEST = 100  # of the name of a kernel in that of a file


def numba_is_set() -> bool:
    """Whether somebody set numba: then it is asked, and makes and runs all kernels itself."""
    settings = {name for name in os.environ if name.startswith('NUMBA_')} - _HARMLESS
    return bool(settings) or Path('.numba_config.yaml').exists()


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


@cache
def processor() -> str | None:
    """
    Tell this processor, and what is told of it, from others; None: images are not for it.
    """
    if sys.platform != 'linux' or platform.machine() != 'x86_64' or sys.maxsize < 2**32:
        return None
    if sys.implementation.name != 'cpython' or object.__basicsize__ != _HEAD_OF_OBJECTS:
        return None  # a build of Python that keeps its objects otherwise (free-threaded, debug)
    try:
        with open('/proc/cpuinfo', encoding='ascii', errors='replace') as file:  # noqa: PTH123
            first = file.read(65536).partition('\n\n')[0]
    except OSError:
        return None
    lines = (line.partition(':') for line in first.splitlines())
    found = {key.strip(): value.strip() for key, _, value in lines}
    told = [os.environ.get(name) for name in _TOLD]
    if 'flags' not in found:
        return None
    return repr([*(found.get(key) for key in _PROCESSOR), *told])


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

    def bitcode_file(self, folder: Path) -> tuple[Path, bytes]:
        """Name the file of its bitcode, and the key of that."""
        readers = str(release_of('llvmlite')).rpartition('.')[0]  # of one format of bitcode
        kinds = ','.join(self.kinds)
        key = f'bitcode {FORMAT} llvmlite {readers} {digest_of(self.function)} {kinds}'.encode()
        return named(folder, self.name[:_LONGEST], key), key


class Images:
    """
    The images of a process.

    folder  : of the cache; None: nothing is kept
    shipped : folder of bitcode that came with the package, or is to be shipped
    made    : names of the kernels whose images this process has made
    """

    def __init__(self, folder: Path | None, shipped: Path | None) -> None:
        self.folder, self.shipped = folder, shipped
        self.made: list[str] = []
        self._saves = False  # whether the bitcode of all that is asked for is kept there
        self._trusts: bool | None = None  # None: not yet tried

    def save_to(self, folder: Path) -> None:
        """Keep from now on the bitcode of all that is asked for in a folder."""
        folder.mkdir(parents=True, exist_ok=True)
        self.shipped, self._saves = folder, True

    def find(self, wanted: Wanted) -> Image | None:
        """Give the image of a kernel, made now if need be; None: go by way of numba."""
        with _MAKING:
            try:
                found = None if self._saves else self.kept(wanted)
                if found is None and self.is_trusted():
                    found = self.make(wanted)
            except (ImportError, UnknownCode, OSError, RuntimeError, NotImplementedError):
                return None  # numba tells, if there is anything to tell
            return found

    def kept(self, wanted: Wanted) -> Image | None:
        """Give the image that is kept of a kernel; None where none is whole."""
        if self.folder is None:
            return None
        path, key = wanted.image_file(self.folder)
        content = read_whole(path, key)
        if content is None:
            return None
        try:
            return load(unpacked(content), wanted.name)
        except ValueError:
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
        from rigid_body_sim.physics.compile.image_maker import Bitcode, closed

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
            found = closed(found)
            path, key = wanted.bitcode_file(self.shipped)
            write_whole(path, key, lzma.compress(found.packed()))
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
        package made bitcode for it.
        """
        probed, files = Wanted(probe, PROBED, ()), []
        if self.folder is not None:
            files.append(probed.image_file(self.folder)[0])
        if self.shipped is not None and release_of('llvmlite') is not None:
            files.append(probed.bitcode_file(self.shipped)[0])
        return any(path.exists() for path in files)
