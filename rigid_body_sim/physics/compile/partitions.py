# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A closed kernel in partitions, of which LLVM makes machine code side by side.

    divided : the text of a module -> the texts of its partitions: each defines some of the
              functions and declares those of the others that it calls
    compiled: the bitcode of a partition -> an object file, by a thread that holds neither Python's
              lock nor llvmlite's

Who is long is a function of its own in a closed kernel, and what LLVM had to know of it to
optimise its callers stands in the declaration: so a partition loses nothing, and the code is the
same but for its order. What `llvm-split` does, of which llvmlite has no binding.

llvmlite lets one thread at a time into LLVM, for most use one context. A partition has a context,
a machine and passes of its own, which is all that LLVM asks for; so its two long calls go by the C
library itself. Where llvmlite hides that, they take turns.
"""

from __future__ import annotations

import ctypes
import re
from collections.abc import Callable, Iterable
from typing import Any

import llvmlite.binding as ll
from llvmlite.binding import ffi

from rigid_body_sim.physics.compile.side_by_side import MOST

LEAST = 3000  # [lines] of a partition: less is not worth a thread
_DEFINES = re.compile(r'define (?:internal |linkonce_odr )?(dso_local )?')
_FUNCTION = re.compile(r'^define .*?^\}\n', re.DOTALL | re.MULTILINE)
_KNOWN = re.compile(r'^(?:declare .*?)?([@!][\w.$-]+|@"[^"]*"|attributes #\d+)')
_NAMES = re.compile(r'@"[^"]*"|[@!#][\w.$-]+')


def divided(text: str) -> list[str]:
    """
    Divide a module: its functions in their order, in runs of about the same length.

    text : of a module as LLVM writes it, of which nobody outside knows anything but functions; all
           of them may be known to the other partitions afterwards
    """
    functions = _FUNCTION.findall(text)
    lines = [function.count('\n') for function in functions]
    count = max(1, min(MOST, len(functions), sum(lines) // LEAST))
    bound, done, runs = sum(lines) / count, 0.0, [[] for _ in range(count)]
    for function, length in zip(functions, lines, strict=True):
        runs[min(int((done + length / 2) / bound), count - 1)].append(function)
        done += length
    known = _known_by_name(_FUNCTION.sub('', text), functions)
    head = ''.join(line for line in text.splitlines(keepends=True) if line.startswith('target '))
    return [head + ''.join(_written(run, known)) for run in runs if run]


def _known_by_name(rest: str, functions: Iterable[str]) -> dict[str, str]:
    """Give the lines that a partition may need, by what they tell of."""
    known = {}
    for line in rest.splitlines(keepends=True):
        found = _KNOWN.match(line)
        if found:
            known[found[1].removeprefix('attributes ')] = line
    for function in functions:
        header = function.partition('\n')[0].removesuffix(' {')
        known[_name_of(header)] = _DEFINES.sub(r'declare \1hidden ', header, count=1) + '\n'
    return known


def _name_of(header: str) -> str:
    found = _NAMES.search(header)
    assert found is not None
    return found[0]


def _written(run: list[str], known: dict[str, str]) -> Iterable[str]:
    """Give the functions of a partition and all that they name, each once."""
    seen, ahead = set(map(_name_of, run)), []
    for function in run:
        yield _DEFINES.sub(r'define \1hidden ', function, count=1)
        ahead += _NAMES.findall(function)
    while ahead:
        name = ahead.pop()
        if name in seen or name not in known:
            continue
        seen.add(name)
        yield known[name]
        ahead += _NAMES.findall(known[name])


def read(text: str) -> bytes:
    """Give the bitcode of a partition; what it does not use is not in it."""
    return ll.parse_assembly(text, ll.create_context()).as_bitcode()


def compiled(bitcode: bytes, machine: Any, optimise: Callable[[Any, Any], None]) -> bytes:
    """
    Make an object file of a partition.

    machine  : nobody else's
    optimise : does so with a module for a machine, see `run_passes`
    """
    module = ll.parse_bitcode(bitcode, ll.create_context())
    optimise(module, machine)
    module.verify()
    return _emitted(machine, module)


def run_passes(passes: Any, module: Any, builder: Any) -> None:
    """Run passes over a module beside other threads: it has a context that no other one uses."""
    _unlocked('LLVMPY_RunNewModulePassManager')(passes, module, builder)


def _emitted(machine: Any, module: Any) -> bytes:
    """Give the object file of a module, as `llvmlite.binding.TargetMachine.emit_object` does."""
    lib: Any = ffi.lib
    with ffi.OutputString() as error:
        buffer = _unlocked('LLVMPY_TargetMachineEmitToMemory')(machine, module, 1, error)
        if not buffer:
            raise RuntimeError(str(error))
    try:
        begin, size = lib.LLVMPY_GetBufferStart(buffer), lib.LLVMPY_GetBufferSize(buffer)
        return ctypes.string_at(begin, size)
    finally:
        lib.LLVMPY_DisposeMemoryBuffer(buffer)


def _unlocked(name: str) -> Any:
    """Give a function of llvmlite's library, without the lock that it is wrapped in, if any."""
    locked = getattr(ffi.lib, name)
    return getattr(locked, '_cfn', locked)
