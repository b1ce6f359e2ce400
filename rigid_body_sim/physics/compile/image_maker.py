# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
From bitcode to an image for this processor, by llvmlite alone.

    Bitcode : a kernel with all that it calls, linked, not yet optimised, which names no processor
    image   : that bitcode, optimised as one closed whole, and an entry that Python can call
              without numba (`image`)

LLVM drops the arguments that are not used, of each array five words out of seven. Left alone it
would then make one function of all that is called once, and lose sight of what is in registers; so
what is long stays a function (LONG).

The entry fills in what numba's code expects of an array: no owner, its length, its place, its
stride. `numba_pipeline` looks whether that is what this release of numba expects.
"""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass
from functools import cache
from itertools import islice
from typing import Any

import llvmlite.binding as ll

from rigid_body_sim.physics.compile.elf import FlatCode, UnknownCode, flatten
from rigid_body_sim.physics.compile.image import STOPPED, count_leading

LONG = 150  # [instructions] of a function that keeps its own registers; see `numba_pipeline`
_ENTRY = 'rigid_body_sim_entry'
_LLVM = {'int64': 'i64', 'float64': 'double', 'bool': 'i8'}
_SIZES = {'int64': 8, 'float64': 8, 'bool': 1}
_HEAD = struct.Struct('<I')
# of numba's helpers, which come with numba: the same in terms of the C library
_HELPERS = {
    'numba_frexp': """
declare double @frexp(double, ptr)
define linkonce_odr double @numba_frexp(double %x, ptr %exponent) {
  %rest = fsub double %x, %x
  %finite = fcmp oeq double %rest, 0.0
  %other = fcmp une double %x, 0.0
  %usual = and i1 %finite, %other
  br i1 %usual, label %split, label %keep
split:
  %fraction = call double @frexp(double %x, ptr %exponent)
  ret double %fraction
keep:
  store i32 0, ptr %exponent
  ret double %x
}
""",
    'numba_ldexp': """
declare double @ldexp(double, i32)
define linkonce_odr double @numba_ldexp(double %x, i32 %exponent) {
  %rest = fsub double %x, %x
  %finite = fcmp oeq double %rest, 0.0
  %other = fcmp une double %x, 0.0
  %usual = and i1 %finite, %other
  %shifts = icmp ne i32 %exponent, 0
  %moves = and i1 %usual, %shifts
  br i1 %moves, label %scale, label %keep
scale:
  %scaled = call double @ldexp(double %x, i32 %exponent)
  ret double %scaled
keep:
  ret double %x
}
""",
}


@dataclass(frozen=True)
class Bitcode:
    """
    A kernel on its way from numba to an image.

    content : linked bitcode
    symbol  : name of the function in it
    kinds   : of the arguments, see `image.kind_of`
    returns : of `image.RETURNS`
    """

    content: bytes
    symbol: str
    kinds: tuple[str, ...]
    returns: str

    def packed(self) -> bytes:
        """Give the bytes that are kept."""
        head = {'symbol': self.symbol, 'kinds': self.kinds, 'returns': self.returns}
        text = json.dumps(head, sort_keys=True).encode()
        return _HEAD.pack(len(text)) + text + self.content

    @staticmethod
    def unpacked(content: bytes) -> Bitcode:
        """Give what `packed` has packed; ValueError for anything else."""
        try:
            begin = _HEAD.size + _HEAD.unpack_from(content)[0]
            head = json.loads(content[_HEAD.size : begin])
            kinds = tuple(head['kinds'])
            return Bitcode(content[begin:], head['symbol'], kinds, head['returns'])
        except (struct.error, KeyError, TypeError) as error:
            raise ValueError(f'no bitcode: {error!r}') from error


def _parameters_of(kinds: tuple[str, ...]) -> list[str]:
    """Give the types of the parameters that numba's code of a kernel has, as LLVM writes them."""
    found = ['ptr', 'ptr']  # where the result goes, and where an error is told
    for kind in kinds:
        if kind.endswith('[]'):  # owner, parent, count, size of one, place, shape, strides
            found += ['ptr', 'ptr', 'i64', 'i64', 'ptr', 'i64', 'i64']
        else:
            found.append(_LLVM[kind])
    return found


def make(bitcode: Bitcode) -> FlatCode:
    """
    Make an image of a kernel for this processor.

    UnknownCode if it holds what images cannot do; RuntimeError if it is no bitcode that this
    release of LLVM reads.
    """
    machine = _machine()
    module = ll.parse_bitcode(bitcode.content)
    module.link_in(ll.parse_assembly(_entry(bitcode, module)))
    declared = {f.name for f in module.functions if f.is_declaration}
    for name in declared & _HELPERS.keys():
        module.link_in(ll.parse_assembly(_HELPERS[name]))
    for function in module.functions:
        if not function.is_declaration and function.name != _ENTRY:
            function.linkage = 'linkonce_odr'
    _optimise(module, machine, symbol=bitcode.symbol)
    module.verify()
    return flatten(machine.emit_object(module), _ENTRY)


def _entry(bitcode: Bitcode, module: Any) -> str:
    """Write the entry, and what it calls, as LLVM does."""
    wanted = _parameters_of(bitcode.kinds)
    function = module.get_function(bitcode.symbol)
    found = [str(argument.type) for argument in function.arguments]
    if found != wanted:
        raise UnknownCode(f'{bitcode.symbol} takes {found}, not {wanted}')
    leading = count_leading(bitcode.kinds)
    given, lines, at = ['ptr %result', 'ptr %error'], [], 0

    def word(kind: str) -> str:
        nonlocal at
        lines.append(f'  %p{at} = getelementptr inbounds i64, ptr %table, i64 {at}')
        lines.append(f'  %w{at} = load {kind}, ptr %p{at}')
        at += 1
        return f'{kind} %w{at - 1}'

    for i, kind in enumerate(bitcode.kinds):
        if kind.endswith('[]'):
            size = _SIZES[kind.removeprefix('constant ').removesuffix('[]')]
            place, count = word('ptr'), word('i64')
            owner = ['ptr null', 'ptr null']
            given += [*owner, count, f'i64 {size}', place, count, f'i64 {size}']
        else:
            given.append(f'{_LLVM[kind]} %a{i}' if i < leading else word(_LLVM[kind]))
    parameters = ['ptr %table', *(f'{_LLVM[bitcode.kinds[i]]} %a{i}' for i in range(leading))]
    size = {'none': 'i8', 'bool': 'i8'}.get(bitcode.returns, 'i64')
    text = '\n'.join(lines)
    return f"""
target triple = "{module.triple}"
target datalayout = "{module.data_layout}"
declare i32 @"{bitcode.symbol}"({', '.join(wanted)})
define double @{_ENTRY}({', '.join(parameters)}) {{
  %result = alloca i64
  %error = alloca ptr
  store i64 0, ptr %result
  store ptr null, ptr %error
{text}
  %status = call i32 @"{bitcode.symbol}"({', '.join(given)})
  %value = load {size}, ptr %result
  %number = {'bitcast' if size == 'i64' else 'zext'} {size} %value to i64
  %stopped = icmp ne i32 %status, 0
  %wide = zext i32 %status to i64
  %mark = or i64 %wide, {STOPPED}
  %bits = select i1 %stopped, i64 %mark, i64 %number
  %told = bitcast i64 %bits to double
  ret double %told
}}
"""


@cache
def _machine() -> Any:
    """Give what makes machine code for this processor, that may lie anywhere."""
    ll.initialize_native_target()
    ll.initialize_native_asmprinter()
    target = ll.Target.from_triple(ll.get_process_triple())
    return target.create_target_machine(
        cpu=ll.get_host_cpu_name(),
        features=ll.get_host_cpu_features().flatten(),
        opt=3,
        reloc='pic',
        codemodel='small',
    )


def _optimise(module: Any, machine: Any, *, symbol: str) -> None:
    """Optimise as numba does: little at first, then, what is long marked, all."""
    options = ll.create_pipeline_tuning_options(speed_level=0)
    options.loop_vectorization = options.slp_vectorization = False
    builder = ll.create_pass_builder(machine, options)
    passes = builder.getModulePassManager()
    passes.add_loop_rotate_pass()
    passes.add_instruction_combine_pass()
    passes.add_jump_threading_pass()
    passes.run(module, builder)
    for function in module.functions:
        if not function.is_declaration and function.linkage == ll.Linkage.linkonce_odr:
            function.linkage = 'internal'
            if function.name == symbol or is_long(function):
                function.add_function_attribute('noinline')
    options = ll.create_pipeline_tuning_options(speed_level=3)
    options.loop_vectorization, options.slp_vectorization = True, False
    builder = ll.create_pass_builder(machine, options)
    builder.getModulePassManager().run(module, builder)


def is_long(function: Any) -> bool:
    """Tell whether a function is so long that it is to stay one."""
    instructions = (one for block in function.blocks for one in block.instructions)
    return next(islice(instructions, LONG, None), None) is not None
