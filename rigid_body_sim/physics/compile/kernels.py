# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
How a plain Python function becomes a kernel: compiled by numba where it is present, itself where
it is not.

A kernel takes scalars and one-dimensional float64 arrays, writes into them, never raises and never
prints; compiled, a range that steps by zero ends the process. The same source runs both ways and
gives the same bits: numba is used without fastmath, so no operation is reordered or fused.

`specialise` makes a kernel for one scene out of a general one: it binds the slots that the general
source leaves open (the drift of an integrator, the force elements of a scene), so that what a
scene lacks is neither compiled nor called. A module declares its slots at its head,

    STAGES = slot('[-] stages of a step')
    evaluate = slot('kernel (place, time, …): adds the wrenches of all force elements')

and a function that names one is no kernel before `specialise` has bound it. How numba is spared
work is in `numba_pipeline`.

What Python calls is kept as an image: machine code that the next process copies into memory and
calls (`images`), and for which it does not even import numba. What kernels call is kept as text
for LLVM (`pieces`), for the next kernel that calls it. All of it lies under a folder whose name is
a digest of every kernel source, because numba itself does not see a change in a function that a
cached kernel calls. The folder is, in this order: $RIGID_BODY_SIM_CACHE, $NUMBA_CACHE_DIR,
$XDG_CACHE_HOME/rigid_body_sim, ~/.cache/rigid_body_sim. One that cannot be written, belongs to
another user or may be written by others is passed over; where none is left, kernels are compiled
anew at each start: that costs time, not the run. Damage is found and mended, see `kernel_files`.

Whoever sets numba (NUMBA_BOUNDSCHECK, NUMBA_OPT, .numba_config.yaml …) gets what numba makes of
that, without images; NUMBA_CPU_NAME and NUMBA_CPU_FEATURES hold for images too.

$RIGID_BODY_SIM_COMPILE=0 runs the plain source. Where numba is missing it runs, too, and is warned
of once a process: measured on one core, plain against compiled, a tick takes 70 to 300 times as
long (one free body, ten bodies, springs), and 600 to 700 times where bodies touch (a stack of ten
boxes, a pyramid of 55).
"""

from __future__ import annotations

import hashlib
import importlib
import os
import sys
import tempfile
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from types import CodeType, FrameType, FunctionType
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.images import Images, numba_is_set
from rigid_body_sim.physics.compile.kernel import (
    WITHOUT,
    Kernel,
    Transfer,
    behind,
    without_numba,
)
from rigid_body_sim.physics.compile.kernel_files import KernelFiles, is_ours, names_of
from rigid_body_sim.physics.compile.processors import processor
from rigid_body_sim.physics.compile.sources import codes, digest_of_sources, globals_read
from rigid_body_sim.physics.compile.wanted import release_of

_WANTED = os.environ.get('RIGID_BODY_SIM_COMPILE', '1') != '0'
# releases whose inside is what `numba_pipeline` expects; another one compiles the same, slowly
_KNOWN_INSIDE = ('0.68.',)
SHIPPED = Path(__file__).parent / 'shipped'


def _cache_candidates() -> list[Path]:
    environment = os.environ
    named = [environment.get('RIGID_BODY_SIM_CACHE'), environment.get('NUMBA_CACHE_DIR')]
    candidates = [Path(name) for name in named if name]
    if Path(environment.get('XDG_CACHE_HOME', '')).is_absolute():  # else it counts as not set
        candidates.append(Path(environment['XDG_CACHE_HOME']) / 'rigid_body_sim')
    if environment.get('HOME'):
        candidates.append(Path(environment['HOME']) / '.cache' / 'rigid_body_sim')
    return candidates


def _usable(folder: Path) -> bool:
    """Whether kernels can be kept in a folder, and nobody else could have put some there."""
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        folder.mkdir(mode=0o700, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return is_ours(folder.stat())
    except OSError:
        return False


def _choose_cache(digest: str) -> Path | None:
    for candidate in _cache_candidates():
        folder = candidate / f'kernels-{digest}'
        if _usable(folder):
            return folder
    return None


def _import_numba() -> tuple[bool, str]:
    """Import numba: whether it compiles, and why it does not."""
    try:
        numba: Any = importlib.import_module('numba')  # its settings carry no types
    except ImportError as missing:  # the plain source runs instead
        return False, without_numba(missing)
    release_of.cache_clear()
    return not numba.config.DISABLE_JIT, ''


def _set_up() -> tuple[bool, str, Path | None, Images | None]:
    """
    Find out what compiles and where it is kept; numba is not imported where an earlier process
    has made images with what is installed now.
    """
    if not _WANTED:
        return False, '', None, None
    if release_of('numba') is None or numba_is_set():
        compiles, why_not = _import_numba()
        folder = _choose_cache(digest_of_sources()) if compiles else None
        return compiles, why_not, folder, None
    digest = digest_of_sources()
    folder = _choose_cache(digest)
    images = None
    if processor() is not None and str(release_of('numba')).startswith(_KNOWN_INSIDE):
        images = Images(folder, SHIPPED / f'kernels-{digest}')
        if images.has_worked():
            return True, '', folder, images
    compiles, why_not = _import_numba()
    return compiles, why_not, folder if compiles else None, images if compiles else None


COMPILED, WITHOUT_NUMBA, CACHE, IMAGES = _set_up()


def _jit(function: Callable[..., Any], *, inline: bool, widest: bool = True) -> Callable[..., Any]:
    if str(release_of('numba')).startswith(_KNOWN_INSIDE):
        return Kernel(function, IMAGES, CACHE, inlined=inline, widest=widest)
    numba: Any = importlib.import_module('numba')
    options: dict[str, Any] = {'nogil': True, 'error_model': 'numpy', 'forceinline': inline}
    made: Any = numba.njit(**options)(function)
    if CACHE is not None:
        before = numba.config.CACHE_DIR
        numba.config.CACHE_DIR = str(CACHE)  # read by numba in the next line
        try:
            made.enable_caching()
            _keep_whole_files(made)
        finally:
            numba.config.CACHE_DIR = before
    return made


def _keep_whole_files(made: Any) -> None:
    """
    Let what numba keeps of a function be checked when it is read; where its inside has no place
    for that, keep nothing.
    """
    import numba

    kept = made._cache
    try:
        own = KernelFiles(*names_of(kept), f'numba {numba.__version__}')
    except AttributeError:
        own = None
    if own is None or not hasattr(kept, '_cache_file'):
        uncached: Any = numba.njit(made.py_func)
        made._cache = uncached._cache
        return
    kept._cache_file = own


def kernel(function: Callable[..., Any], *, widest: bool = True) -> Callable[..., Any]:
    """
    Compile a kernel (lazily, at its first call), or return it as it is.

    widest : whether it does little but go over lanes, see `image_maker.Bitcode`
    """
    _want_no_slots(function)
    return _jit(function, inline=False, widest=widest) if COMPILED else function


def inline(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a small function that is to disappear inside its caller's loop."""
    _want_no_slots(function)
    return _jit(function, inline=True) if COMPILED else function


def transfer(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a small function for which LLVM is told how: `lane_transfers`, `shared_numbers`."""
    if not COMPILED or not str(release_of('numba')).startswith(_KNOWN_INSIDE):
        return inline(function)
    return Transfer(function, IMAGES, CACHE, inlined=True, widest=False)


class KernelSlot:
    """
    A global name that `specialise` binds; whatever else is done with it is refused.

    meaning : what is bound: `[unit] what the number says`, or `kernel (arguments): what it does`
    """

    __slots__ = ('meaning',)

    def __init__(self, meaning: str) -> None:
        self.meaning = meaning

    def __repr__(self) -> str:
        return f'<slot: {self.meaning}>'


def _refuse(empty: KernelSlot, *_arguments: Any, **_keywords: Any) -> Any:
    raise TypeError(f'{empty!r} is empty: only what kernels.specialise makes can use it')


_USES = (
    'call bool int float complex index round trunc floor ceil len iter next getitem setitem '
    'contains add radd sub rsub mul rmul truediv rtruediv floordiv rfloordiv mod rmod divmod '
    'rdivmod pow rpow matmul rmatmul lshift rlshift rshift rrshift and rand or ror xor rxor '
    'neg pos abs invert eq ne lt le gt ge'
)
for _use in _USES.split():
    setattr(KernelSlot, f'__{_use}__', _refuse)
KernelSlot.__hash__ = object.__hash__


def slot(meaning: str) -> Any:
    """Declare a global name that `specialise` binds, see `KernelSlot`."""
    return KernelSlot(meaning)


def slots_of(function: FunctionType) -> dict[str, KernelSlot]:
    """Give the slots that the source of a plain function names, in the order of their names."""
    known = function.__globals__
    named = {name for name in _names(function.__code__) if isinstance(known.get(name), KernelSlot)}
    if named:  # a name of the code may also be that of an attribute
        named &= globals_read(function.__code__)
    return {name: known[name] for name in sorted(named)}


def _names(code: CodeType) -> Iterator[str]:
    for part in codes(code):
        yield from part.co_names


def _want_no_slots(function: Any) -> None:
    empty = slots_of(function)
    if empty:
        raise TypeError(
            f'{function.__module__}.{function.__qualname__}: names {_listed(empty)}: bind with '
            f'kernels.specialise, which makes the kernel'
        )


def _listed(slots: Mapping[str, KernelSlot]) -> str:
    return ', '.join(f'{name} {empty!r}' for name, empty in slots.items())


def _checked(function: FunctionType, offered: Any, bindings: Any) -> dict[str, Any]:
    """Give what is bound to the slots of a function: to all of them, and to nothing else."""
    slots = _SLOTS.get(function)
    if slots is None:
        slots = _SLOTS[function] = slots_of(function)
    where = f'specialise({function.__module__}.{function.__qualname__})'
    unknown = sorted(bindings.keys() - slots.keys())
    if unknown:
        raise TypeError(
            f'{where}: names no slot {", ".join(unknown)}; it has {_listed(slots) or "none"}'
        )
    found = {name: bindings[name] if name in bindings else offered[name]
             for name in slots if name in bindings or name in offered}  # fmt: skip
    missing = {name: empty for name, empty in slots.items() if name not in found}
    if missing:
        raise TypeError(f'{where}: nothing is bound to {_listed(missing)}')
    empty = {name: value for name, value in found.items() if isinstance(value, KernelSlot)}
    if empty:
        raise TypeError(f'{where}: what is bound is itself a slot: {_listed(empty)}')
    return found


def specialise(
    function: FunctionType,
    *,
    name: str,
    inlined: bool = False,
    widest: bool = True,
    offered: Mapping[str, Any] | None = None,
    **bindings: Any,
) -> Callable[..., Any]:
    """
    Bind the slots of a plain function and make a kernel of the result.

        function : plain Python function whose source names slots
        name     : tells this kernel from the others made of the same source
        inlined  : let it disappear inside its caller, see `inline`
        widest   : see `kernel`
        offered  : constants of a whole family of functions, of which this one takes those that it
                   names
        bindings : what else it names, by name: constants, tuples of constants, or kernels

    Each slot that the source names must be bound, and nothing else may be in `bindings`: a
    TypeError says which.
    """
    bindings = _checked(function, offered or {}, bindings)
    unique = f'{function.__name__}__{name}__{_digest(bindings)}'
    known = _MADE.get((function.__module__, unique))
    if known is not None:
        return known
    bound = FunctionType(
        function.__code__, {**function.__globals__, **bindings}, unique, function.__defaults__
    )
    bound.__qualname__ = unique
    bound.__module__ = function.__module__
    bound.__doc__ = function.__doc__
    made = inline(bound) if inlined else kernel(bound, widest=widest)
    _MADE[function.__module__, unique] = made
    return made


_MADE: dict[tuple[str, str], Callable[..., Any]] = {}  # by module and unique name, as in the cache
# of a source: a scene with contact asks a hundred of them, each anew for every simulation
_SLOTS: WeakKeyDictionary[FunctionType, dict[str, KernelSlot]] = WeakKeyDictionary()


def _digest(bindings: dict[str, Any]) -> str:
    """
    Tell sets of bindings apart: numba finds a cached kernel by its name, whatever its globals
    hold. Kernels of one name in two modules are two.
    """
    parts = (f'{key}={_identity(value)!r}' for key, value in sorted(bindings.items()))
    return hashlib.sha256(','.join(parts).encode()).hexdigest()[:16]


def _identity(value: Any) -> Any:
    """Name a kernel with its module: drifts of several methods are called `drift`."""
    name = getattr(value, '__name__', None)
    return value if name is None else f'{value.__module__}.{name}'


def plain(function: Callable[..., Any]) -> FunctionType:
    """Return the Python source function of a kernel."""
    return getattr(function, 'py_func', function)


def prepared(
    call: Callable[..., Any], first: Sequence[Any], last: Sequence[Any], *, brief: bool = False
) -> Callable[..., Any]:
    """
    Give a kernel with its last arguments at hand, to be called with the others, again and again.

        call  : kernel, or what has a `prepared` of its own
        first : such as it will be called with; nothing is run, but what is needed is compiled
        brief : whether other threads of Python wait for it: saves 50 ns of each call

    Called with first arguments of other kinds (an integer where a float was) it has done nothing
    and gives NotImplemented.
    """
    prepare = getattr(call, 'prepared', None)
    if prepare is None:
        return behind(call, last)
    return prepare(first, last, brief=True) if brief else prepare(first, last)


def argument(array: NDArray[Any]) -> Any:
    """
    Prepare an array for a kernel call.

    The compiled kernel takes the array. The plain one takes a view whose elements are Python
    floats: the same bits, some ten times faster than numpy scalars, and silent about overflow.
    """
    return array if COMPILED else memoryview(array)


def flat_plain(array: NDArray[Any]) -> Any:
    return memoryview(array.ravel())


# prepare an array of several axes: as `argument`, one number behind the other; what is contiguous
# is seen, not copied. A method of C, which costs a third of a function and `reshape`
flat: Callable[[NDArray[Any]], Any] = np.ndarray.ravel if COMPILED else flat_plain

_told: list[str] = []


def warn_if_plain(say: Callable[[str], None] | None = None) -> None:
    """
    Say once a process, if numba is missing, what that costs; not to whom asked for plain source.

    say : takes the line; None: `warnings.warn`, for who called the caller
    """
    if not WITHOUT_NUMBA or _told:
        return
    _told.append(WITHOUT_NUMBA)
    if say is None:
        warnings.warn(WITHOUT_NUMBA, RuntimeWarning, stacklevel=_frames_of_the_package() + 1)
    else:
        say(WITHOUT_NUMBA)


def _frames_of_the_package() -> int:
    """Count the frames from who asks up to the first that is none of this package's."""
    package = __name__.partition('.')[0]
    frame: FrameType | None = sys._getframe(1)
    count = 0
    while frame is not None and frame.f_globals.get('__name__', '').partition('.')[0] == package:
        frame = frame.f_back
        count += 1
    return count


def left_the_numbers(error: Exception) -> bool:
    """
    Tell whether a plain kernel met what a compiled one passes through as infinity or NaN: a
    division by zero, an overflow, a function outside its domain. Any other error is a bug.
    """
    if COMPILED and not WITHOUT:
        return False
    if isinstance(error, ZeroDivisionError | OverflowError):
        return True
    said = str(error)  # Python has no narrower class; 3.14 says 'expected a …'
    return said.startswith(('math domain', 'cannot convert float', 'expected a '))


def versions() -> dict[str, str]:
    """Name the software whose change may change a bit."""
    found = {'python': sys.version.split()[0], 'numpy': np.__version__}
    if COMPILED:
        found['numba'] = str(release_of('numba'))
    return found
