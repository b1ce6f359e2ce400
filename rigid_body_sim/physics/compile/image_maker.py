# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
From bitcode to an image for this processor, by llvmlite alone.

    Bitcode : a kernel with all that it calls, linked, each function simplified by itself, which
              names no processor; what is to be shipped is also optimised as one closed whole, but
              for loops (`closed`)
    image   : that bitcode, optimised for a processor, and an entry that Python can call without
              numba (`image`)

What is closed is divided, and its partitions are compiled side by side (`partitions`).

LLVM drops the arguments that are not used, of each array five words out of seven. Left alone it
would then make one function of all that is called once, and lose sight of what is in registers; so
what is long stays a function (LONG).

The entry fills in what numba's code expects of an array: no owner, its length, its place, its
stride. What it leans on, the way in which numba's code takes its arguments and where numpy keeps
what belongs to an array, is tried out with a probe before any image is trusted (`images`).

LLVM makes vectors of 256 bits for many processors that have 512 (`rocketlake`, `skylake-avx512`,
`sapphirerapids`): right for code that uses them now and then. Kernels that do nothing else take
the widest there are: 1000 free bodies 22 -> 14.8 ns a tick each. Kernels with contact (not
`Bitcode.widest`) keep LLVM's choice, by which a stack once gained 5 %, but on processors with half
precision in 512 bits, which begin with Sapphire Rapids: 1000 boxes at rest take 0.90 of the time
there, a stack 0.93. Nor are the loops of those kernels unrolled: a sixth less code that is as
fast, made in an eighth less time. No bit depends on any of it.
"""

from __future__ import annotations

import json
import os
import struct
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import accumulate, islice, pairwise
from typing import Any

import llvmlite.binding as ll

from rigid_body_sim.physics.compile.elf import FlatCode, UnknownCode, flatten
from rigid_body_sim.physics.compile.image import READ, WRITE, objects
from rigid_body_sim.physics.compile.partitions import compiled, divided, read, run_passes
from rigid_body_sim.physics.compile.side_by_side import SideBySide

LONG = 150  # [instructions] of a function that keeps its own registers; see `numba_pipeline`
_ENTRY = 'rigid_body_sim_entry'
_LLVM = {'int64': 'i64', 'float64': 'double', 'bool': 'i8'}
_SIZES = {'int64': 8, 'float64': 8, 'bool': 1}  # [B]
# [B] where Python and numpy keep them: PyObject, PyTupleObject and PyArrayObject_fields
_TYPE, _COUNT, _ITEMS = 8, 16, 24
_DATA, _AXES, _SHAPE, _DTYPE, _FLAGS = 16, 24, 32, 56, 64
_WORD = 8  # [B]
_WIDEST = '-prefer-256-bit'
_WIDE_UNITS = '+avx512fp16'  # tells processors that lose nothing by vectors of 512 bits
_PYTHON = """
declare ptr @PyEval_SaveThread()
declare void @PyEval_RestoreThread(ptr)
declare double @PyFloat_AsDouble(ptr)
declare i64 @PyLong_AsLongLong(ptr)
declare ptr @PyErr_Occurred()
declare ptr @PyFloat_FromDouble(double)
declare ptr @PyLong_FromLongLong(i64)
declare ptr @PyBool_FromLong(i64)
declare void @Py_IncRef(ptr)
declare ptr @PyTuple_Pack(i64, ...)
declare void @PyErr_SetObject(ptr, ptr)
"""
# how a result is kept by numba, and what is done with %value
_RESULTS = {
    'float64': (
        'double',
        '%given = call ptr @PyFloat_FromDouble(double %value)\n  ret ptr %given',
    ),
    'int64': (
        'i64',
        '%given = call ptr @PyLong_FromLongLong(i64 %value)\n  ret ptr %given',
    ),
    'bool': (
        'i8',
        '%long = zext i8 %value to i64\n  %given = call ptr @PyBool_FromLong(i64 %long)\n'
        '  ret ptr %given',
    ),
    'none': ('i64', 'call void @Py_IncRef(ptr @the_none)\n  ret ptr @the_none'),
}
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

    partitions : linked, simplified bitcode; one, until it is closed
    symbol  : name of the function in it
    kinds   : of the arguments, see `image.kind_of`
    returns : of `image.RETURNS`
    widest  : whether it does little but go over lanes: then it uses the widest vectors of a
              processor, whatever LLVM prefers, and its loops are unrolled
    is_closed : whether `closed` has made it
    """

    partitions: tuple[bytes, ...]
    symbol: str
    kinds: tuple[str, ...]
    returns: str
    widest: bool = True
    is_closed: bool = False

    def packed(self) -> bytes:
        """Give the bytes that are kept."""
        head = {
            'symbol': self.symbol,
            'kinds': self.kinds,
            'returns': self.returns,
            'widest': self.widest,
            'is_closed': self.is_closed,
            'sizes': [len(partition) for partition in self.partitions],
        }
        text = json.dumps(head, sort_keys=True).encode()
        return b''.join((_HEAD.pack(len(text)), text, *self.partitions))

    @staticmethod
    def unpacked(content: bytes) -> Bitcode:
        """Give what `packed` has packed; ValueError for anything else."""
        try:
            begin = _HEAD.size + _HEAD.unpack_from(content)[0]
            head = json.loads(content[_HEAD.size : begin])
            kinds = tuple(head['kinds'])
            told = (head[name] for name in ('returns', 'widest', 'is_closed'))
            ends = tuple(accumulate(head['sizes'], initial=begin))
            if ends[-1] != len(content):
                raise ValueError(f'no bitcode: {len(content)} bytes, not {ends[-1]}')
            partitions = tuple(content[i:j] for i, j in pairwise(ends))
            return Bitcode(partitions, head['symbol'], kinds, *told)
        except (struct.error, KeyError, TypeError) as error:
            raise ValueError(f'no bitcode: {error!r}') from error


def make(bitcode: Bitcode, *, level: str | None = None) -> FlatCode:
    """
    Make an image of a kernel, for this processor or for all that reach a level of x86-64.

    UnknownCode if it holds what images cannot do; RuntimeError if it is no bitcode that this
    release of LLVM reads.
    """
    if not bitcode.is_closed:
        bitcode = closed(bitcode)
    told = _processor(bitcode.widest) if level is None else (level, _WIDEST)
    optimise = partial(_run_on_whole, speed_level=1, loops=True, unrolls=bitcode.widest)
    found = (read(_entry(bitcode)), *bitcode.partitions)

    def compile_one(number: int) -> tuple[int, bytes]:
        return number, compiled(found[number], machine_for(*told), optimise)

    calls = [partial(compile_one, number) for number in range(len(found))]
    objects = dict(SideBySide().call(calls, ()))
    return flatten([objects[number] for number in range(len(found))], _ENTRY)


def closed(bitcode: Bitcode) -> Bitcode:
    """
    Optimise a kernel as one closed whole, as far as no processor has to be known: all but loops.
    Then it is divided, see `partitions`.

    It takes two thirds of the room then, and its image three fifths of the time (`stack`, 1.0 MB
    and 3.1 s before); the image is as fast.
    """
    machine = machine_for('x86-64', '')
    context = ll.create_context()
    module = ll.parse_bitcode(bitcode.partitions[0], context)
    _want_arguments(bitcode, module)
    _link_helpers(module, context)
    _close(module, machine, bitcode.symbol)
    _run_on_whole(module, machine, speed_level=3, loops=False, unrolls=False)
    texts = divided(str(module))
    return replace(bitcode, partitions=tuple(map(read, texts)), is_closed=True)


def _want_arguments(bitcode: Bitcode, module: Any) -> None:
    """UnknownCode if a kernel takes its arguments in another way than `_entry` hands them over."""
    wanted = ', '.join(_Writer(bitcode).parameters)
    function = module.get_function(bitcode.symbol)
    found = ', '.join(str(argument.type) for argument in function.arguments)
    if found != wanted:
        raise UnknownCode(f'{bitcode.symbol} takes {found}, not {wanted}')


def _link_helpers(module: Any, context: Any) -> None:
    """Add what a kernel needs of numba's own helpers; whatever has a body may be dropped."""
    declared = {f.name for f in module.functions if f.is_declaration}
    for name in declared & _HELPERS.keys():
        module.link_in(ll.parse_assembly(_HELPERS[name], context))


def _entry(bitcode: Bitcode) -> str:
    """Write the builtin function of Python that calls the kernel, as LLVM does."""
    writer = _Writer(bitcode)
    wanted = ', '.join(writer.parameters)
    for i, kind in enumerate(bitcode.kinds):
        writer.look_at(i, kind)
    kept, given = _RESULTS[bitcode.returns]
    known = '\n'.join(f'@{name} = external global i8' for name in objects())
    checks, takes = '\n'.join(writer.checks), '\n'.join(writer.takes)
    return f"""
target triple = "{ll.get_process_triple()}"
{known}
{_PYTHON}
declare void @llvm.memcpy.p0.p0.i64(ptr, ptr, i64, i1)
declare hidden i32 @"{bitcode.symbol}"({wanted})
define ptr @{_ENTRY}(ptr %self, ptr %first, i64 %count) {{
  %result = alloca i64
  %error = alloca ptr
  %all = alloca [{len(bitcode.kinds)} x ptr]
  store i64 0, ptr %result
  store ptr null, ptr %error
  %owned_at = getelementptr inbounds i8, ptr %self, i64 {_COUNT}
  %owned = load i64, ptr %owned_at
  %last = sub i64 %owned, 1
  %whole = add i64 %count, %last
  %right_count = icmp eq i64 %whole, {len(bitcode.kinds)}
  br i1 %right_count, label %list, label %other
list:
  %first_all = icmp eq i64 %last, 0
  br i1 %first_all, label %begin, label %join
join:
  %first_size = mul i64 %count, {_WORD}
  %last_size = mul i64 %last, {_WORD}
  %last_at = getelementptr inbounds i8, ptr %self, i64 {_ITEMS + _WORD}
  %behind = getelementptr inbounds ptr, ptr %all, i64 %count
  call void @llvm.memcpy.p0.p0.i64(ptr %all, ptr %first, i64 %first_size, i1 false)
  call void @llvm.memcpy.p0.p0.i64(ptr %behind, ptr %last_at, i64 %last_size, i1 false)
  br label %begin
begin:
  %arguments = phi ptr [ %first, %list ], [ %all, %join ]
{checks}
{takes}
  %name_at = getelementptr inbounds i8, ptr %self, i64 {_ITEMS}
  %name = load ptr, ptr %name_at
{_call(bitcode.symbol, writer.given)}
  %stopped = icmp ne i32 %status, 0
  br i1 %stopped, label %stop, label %done
done:
  %value = load {kept}, ptr %result
  {given}
stop:
  %wide = sext i32 %status to i64
  %number = call ptr @PyLong_FromLongLong(i64 %wide)
  %what = call ptr (i64, ...) @PyTuple_Pack(i64 2, ptr %name, ptr %number)
  call void @PyErr_SetObject(ptr @the_error, ptr %what)
  ret ptr null
failed:
  ret ptr null
other:
  call void @Py_IncRef(ptr @the_other)
  ret ptr @the_other
}}
"""


def _call(symbol: str, given: Sequence[str]) -> str:
    """Write the call of a kernel, without Python's lock but for a `image.BriefName`."""
    return f"""
  %class_at = getelementptr inbounds i8, ptr %name, i64 {_TYPE}
  %class = load ptr, ptr %class_at
  %lets_go = icmp eq ptr %class, @the_str
  br label %ready
ready:
  br i1 %lets_go, label %let_go, label %run
let_go:
  %own = call ptr @PyEval_SaveThread()
  br label %run
run:
  %thread = phi ptr [ null, %ready ], [ %own, %let_go ]
  %status = call i32 @"{symbol}"({', '.join(given)})
  br i1 %lets_go, label %take_again, label %look
take_again:
  call void @PyEval_RestoreThread(ptr %thread)
  br label %look
look:
"""


class _Writer:
    """
    The lines that look at the arguments of a kernel.

    parameters : their types as numba's code takes them
    checks     : lines that look whether each is of its kind, and go to `other` if not
    takes      : lines that take their values, and go to `failed` if an integer is too large
    given      : what numba's code is called with
    """

    def __init__(self, bitcode: Bitcode) -> None:
        self.given = ['ptr %result', 'ptr %error']  # where the result goes, and what went wrong
        self.parameters = ['ptr', 'ptr']
        for kind in bitcode.kinds:  # owner, parent, count, size of one, place, shape, strides
            array = ['ptr', 'ptr', 'i64', 'i64', 'ptr', 'i64', 'i64']
            self.parameters += array if kind.endswith('[]') else [_LLVM[kind]]
        self.checks: list[str] = []
        self.takes: list[str] = []

    def look_at(self, i: int, kind: str) -> None:
        """Write the lines for argument i."""
        self.checks += [
            f'  %at{i} = getelementptr inbounds ptr, ptr %arguments, i64 {i}',
            f'  %o{i} = load ptr, ptr %at{i}',
        ]
        if kind == 'bool':
            self.checks.append(f'  %true{i} = icmp eq ptr %o{i}, @the_true')
            self.checks.append(f'  %false{i} = icmp eq ptr %o{i}, @the_false')
            self._want(i, f'or i1 %true{i}, %false{i}')
            self.takes.append(f'  %v{i} = zext i1 %true{i} to i8')
            self.given.append(f'i8 %v{i}')
            return
        word = 'ndarray' if kind.endswith('[]') else kind.removesuffix('64')
        self._field(i, 'type', 'ptr', _TYPE)
        self._want(i, f'icmp eq ptr %type{i}, @the_{word}')
        if kind.endswith('[]'):
            self._look_into(i, kind)
        elif kind == 'float64':
            self.takes.append(f'  %v{i} = call double @PyFloat_AsDouble(ptr %o{i})')
            self.given.append(f'double %v{i}')
        else:
            self.takes += [
                f'  %v{i} = call i64 @PyLong_AsLongLong(ptr %o{i})',
                f'  %odd{i} = icmp eq i64 %v{i}, -1',
                f'  br i1 %odd{i}, label %ask{i}, label %well{i}',
                f'ask{i}:',
                f'  %wrong{i} = call ptr @PyErr_Occurred()',
                f'  %right{i} = icmp eq ptr %wrong{i}, null',
                f'  br i1 %right{i}, label %well{i}, label %failed',
                f'well{i}:',
            ]
            self.given.append(f'i64 %v{i}')

    def _look_into(self, i: int, kind: str) -> None:
        """Write the lines for an array, of which `the_ndarray` is known to be the type."""
        of = kind.removeprefix('constant ').removesuffix('[]')
        flags = READ if kind.startswith('constant') else READ | WRITE
        self._field(i, 'axes', 'i32', _AXES)
        self._field(i, 'dtype', 'ptr', _DTYPE)
        self._field(i, 'flags', 'i32', _FLAGS)
        self.checks += [
            f'  %one_axis{i} = icmp eq i32 %axes{i}, 1',
            f'  %same_dtype{i} = icmp eq ptr %dtype{i}, @the_dtype_{of}',
            f'  %own_flags{i} = and i32 %flags{i}, {READ | WRITE}',
            f'  %same_flags{i} = icmp eq i32 %own_flags{i}, {flags}',
            f'  %of_kind{i} = and i1 %one_axis{i}, %same_dtype{i}',
        ]
        self._want(f'{i}_inside', f'and i1 %of_kind{i}, %same_flags{i}')
        self._field(i, 'data', 'ptr', _DATA)
        self._field(i, 'shape', 'ptr', _SHAPE)
        self.checks.append(f'  %n{i} = load i64, ptr %shape{i}')
        size, count = f'i64 {_SIZES[of]}', f'i64 %n{i}'
        self.given += ['ptr null', 'ptr null', count, size, f'ptr %data{i}', count, size]

    def _field(self, i: int, name: str, kind: str, offset: int) -> None:
        self.checks += [
            f'  %{name}_at{i} = getelementptr inbounds i8, ptr %o{i}, i64 {offset}',
            f'  %{name}{i} = load {kind}, ptr %{name}_at{i}',
        ]

    def _want(self, i: int | str, condition: str) -> None:
        self.checks += [
            f'  %fits{i} = {condition}',
            f'  br i1 %fits{i}, label %next{i}, label %other',
            f'next{i}:',
        ]


def _processor(widest: bool) -> tuple[str, str]:
    """
    Name this processor and its features, or the one that numba was told (NUMBA_CPU_NAME,
    NUMBA_CPU_FEATURES).
    """
    name = os.environ.get('NUMBA_CPU_NAME') or ll.get_host_cpu_name()
    features = os.environ.get('NUMBA_CPU_FEATURES')
    if features is None:
        features = ll.get_host_cpu_features().flatten()
    widest = widest or _WIDE_UNITS in features.split(',')
    return name, ','.join(filter(None, (features, _WIDEST if widest else '')))


def machine_for(processor: str, features: str) -> Any:
    """Give what makes machine code that may lie anywhere; arguments as LLVM knows them."""
    ll.initialize_native_target()
    ll.initialize_native_asmprinter()
    target = ll.Target.from_triple(ll.get_process_triple())
    return target.create_target_machine(
        cpu=processor, features=features, opt=3, reloc='pic', codemodel='small'
    )


def simplify(module: Any) -> None:
    """
    Simplify each function of a module by itself, for no processor: once, see `pieces`.

    Two fifths of the bitcode are left, and two fifths of the time to make an image of it are saved
    (`stack`: 2.4 -> 1.0 MB, 5.6 -> 3.7 s); done beforehand it also shows what is long: a tick of
    `stack` takes 2 % less.
    """
    options = ll.create_pipeline_tuning_options(speed_level=1)
    options.loop_vectorization = options.slp_vectorization = False
    builder = ll.create_pass_builder(machine_for('x86-64', ''), options)
    passes = builder.getFunctionPassManager()
    for function in module.functions:
        if not function.is_declaration:
            passes.run(function, builder)


def _close(module: Any, machine: Any, symbol: str) -> None:
    """
    Optimise little at first, as numba does, mark what is long, and let nothing but the kernel be
    called from outside.
    """
    for function in module.functions:
        if not function.is_declaration:
            function.linkage = 'external' if function.name == symbol else 'linkonce_odr'
    options = ll.create_pipeline_tuning_options(speed_level=0)
    options.loop_vectorization = options.slp_vectorization = False
    builder = ll.create_pass_builder(machine, options)
    passes = builder.getModulePassManager()
    passes.add_loop_rotate_pass()
    passes.add_instruction_combine_pass()
    passes.add_jump_threading_pass()
    passes.run(module, builder)
    for function in module.functions:
        if function.is_declaration:
            continue
        if function.name != symbol:
            function.linkage = 'internal'
        if function.name == symbol or is_long(function):
            function.add_function_attribute('noinline')


def _run_on_whole(
    module: Any, machine: Any, *, speed_level: int, loops: bool, unrolls: bool
) -> None:
    """Optimise a closed module; loops: let them go over several lanes at once."""
    options = ll.create_pipeline_tuning_options(speed_level=speed_level)
    options.loop_vectorization, options.slp_vectorization = loops, False
    options.loop_unrolling = unrolls
    builder = ll.create_pass_builder(machine, options)
    run_passes(builder.getModulePassManager(), module, builder)


def is_long(function: Any) -> bool:
    """Tell whether a function is so long that it is to stay one."""
    instructions = (one for block in function.blocks for one in block.instructions)
    return next(islice(instructions, LONG, None), None) is not None
