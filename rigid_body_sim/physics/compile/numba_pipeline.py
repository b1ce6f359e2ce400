# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
numba, told what a kernel does not need: the same bits, compiled in less than half of the time, and
up to a quarter faster.

A scene with contact is some hundred small functions, of which Python calls one. numba treats each
as if Python might call it: wraps it twice, optimises it together with all that it calls, turns it
into machine code, and does so again for whoever calls it. Here

    linked      what Python calls, as bitcode with all that it calls: `image_maker` makes an image
                of it, which needs no numba any more
    _Called     what a kernel calls: its twin, made only when a kernel names it, which ends as
                bitcode, ready to be linked into a caller
    Kernel      what Python calls, where no image can be (`images`): optimised and turned into
                machine code by numba, once, with all that it calls
    _Whole      the code of such a kernel, optimised as what it is: closed; as `image_maker` does

and of the work in Python before that,

    references  of arrays are not counted, for a kernel makes none and keeps none; one that
                allocated would now be refused
    indices     are taken as they are: no kernel counts from the end of an array, and to look for
                that at each of thousands of accesses is most of what fetching a body costs
    types       of an operator with its operands are resolved once, not at every occurrence; a
                literal argument is typed like any other number, so that no function is compiled
                once for a 0 and once for a 3
    garbage     is not looked for meanwhile: nearly all that is made is kept to the end
    passes      for closures and array expressions, which kernels do not have, are left out, and
                the one for a printout of types, which keeps the code of every function as it was
                read: half of the Python objects that live after a compilation

What each part earns: processor time of the cold compile of `stack`, of its tick, and of a tick of
`pile_of_1000`, with that part alone left out. Medians of two or three runs on two busy cores
(x86-64, Python 3.12, numba 0.68), of which one differs from the next by up to a tenth:

                            cold compile        tick of stack     tick of the pile
    all parts               14.1 s              10.8 us           1060 us
    no twins                21.5 s   + 53 %     11.2 us   +  4 %  1040 us    - 2 %
    their machine code too  17.2 s   + 22 %     11.3 us   +  4 %  1040 us    - 2 %
    references counted      14.2 s   +  1 %     14.1 us   + 31 %  1100 us    + 4 %
    indices wrapped         17.3 s   + 23 %     13.6 us   + 26 %  1100 us    + 4 %
    types every time        18.1 s   + 28 %     11.2 us   +  4 %  1060 us      0 %
    all passes              14.8 s   +  5 %     11.3 us   +  5 %  1070 us    + 1 %

numba alone, measured once: 36.8 s and 14.3 us. Free bodies (`ten_bodies` under dmv6) compile in
0.8 s and tick in 0.36 us, whatever is left out. The passes earn less than the rest; to leave them
out takes one line, in numba's own way. Measured since vectors are tuples, of 13.2 s
with all parts: with literals typed each by itself and garbage looked for 18.9 s (297 functions in
place of 266), with garbage looked for alone 15.8 s. That pause is the one thing here that all
threads of the process share: their garbage waits some seconds.

`_Whole` came later; with and without it, side by side (processor time, medians of five): tick of
`stack` 9.3 and 10.1 us, of 1000 boxes 0.94 and 1.02 ms, 1000 free bodies 9.5 and 10.5 us, two
bodies under implicit_midpoint 0.99 and 1.35 us, cold compile of `stack` the same. LONG may be 40
to 250; without that bound a tick of `stack` takes 21.7 us, and with no function of more than
LONG = 0 instructions inlined but those that ask for it, 10.6 us.

Nothing inside numba is replaced, and no setting of numba is changed, so that
functions of the program that compile beside, or are called by a kernel, stay what numba makes of
them: a dispatcher, a pipeline, a lowering, a typing context and a cache of kernels' own extend
numba's classes. They lean on its inside still, and `kernels` asks another release than those it
names there for an ordinary function: that costs time, not the run.

`make test-bounds` runs the tests of kernels with each index checked.
"""

from __future__ import annotations

import gc
import operator
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import numba
from numba.core import cgutils, ir, types
from numba.core.caching import CompileResultCacheImpl, FunctionCache, UserProvidedCacheLocator
from numba.core.codegen import (
    JITCodeLibrary,
    ll,  # pyright: ignore[reportPrivateImportUsage]: llvmlite, which comes with numba
)
from numba.core.compiler import CompilerBase, DefaultPassBuilder, Flags, compile_extra
from numba.core.compiler_lock import global_compiler_lock
from numba.core.compiler_machinery import PassManager, register_pass
from numba.core.lowering import Lower
from numba.core.registry import CPUDispatcher, cpu_target
from numba.core.typed_passes import BaseNativeLowering, NativeLowering
from numba.core.types.functions import BaseFunction
from numba.core.typing.context import Context
from numba.core.typing.typeof import Purpose, typeof
from numba.np import arrayobj

from rigid_body_sim.physics.compile.elf import UnknownCode
from rigid_body_sim.physics.compile.image import RETURNS, of_members
from rigid_body_sim.physics.compile.image_maker import Bitcode, is_long
from rigid_body_sim.physics.compile.kernel_files import KernelFiles, names_of

_POWERS = {operator.pow, operator.ipow}  # of which numba knows some by their exponent
_OPERATORS: dict[Any, Any] = {}

_RELEASES = f'numba {numba.__version__} LLVM {ll.llvm_version_info}'
_NOT_IN_KERNELS = {
    'InlineClosureLikes',
    'NopythonRewrites',  # of array expressions
    'AnnotateTypes',  # for a printout, for which each function would keep all its code as read
}


def _options(*, inlined: bool) -> dict[str, Any]:
    options: dict[str, Any] = {'nogil': True, 'error_model': 'numpy', 'forceinline': inlined}
    options |= {'nopython': True, 'boundscheck': None}
    return options | {'_nrt': False, 'no_cfunc_wrapper': True}


class Kernel(CPUDispatcher):
    """
    A compiled function as Python calls it by way of numba.

        inlined : whether it is to disappear inside its caller
        folder  : keeps what is compiled, if any
    """

    def __init__(
        self, function: Callable[..., Any], folder: Path | None, *, inlined: bool
    ) -> None:
        options = _options(inlined=inlined)
        super().__init__(function, targetoptions=options, pipeline_class=_CompilerOfKernel)
        if folder is not None:
            self._cache = _cache_in(folder)(function)


def make_ready() -> None:
    """Let numba learn its own functions, 0.2 s: for who forks before the first kernel."""
    target: Any = cpu_target
    target.typing_context.refresh()
    target.target_context.refresh()


def twin(function: Callable[..., Any], folder: Path | None, *, inlined: bool) -> Any:
    """Give what numba is to compile of a function that a kernel calls."""
    return _Called(function, _options(inlined=inlined), folder and folder / 'called')


def linked(function: Callable[..., Any], arguments: Sequence[Any], kinds: tuple[str, ...]) -> Any:
    """
    Compile a kernel with all that it calls, as far as to bitcode: an `image_maker.Bitcode`.

    arguments : as the kernel is called with, of these kinds

    UnknownCode if numba's code of a kernel is not what an image can call.
    """
    took = tuple(typeof(value, Purpose.argument) for value in arguments)
    flags: Any = Flags()
    cpu_target.options.parse_as_flags(flags, _options(inlined=False))
    flags.no_compile = flags.no_cpython_wrapper = True
    with global_compiler_lock:
        made = compile_extra(
            cpu_target.typing_context,
            cpu_target.target_context,
            function,
            args=took,
            return_type=None,
            flags=flags,
            locals={},
            pipeline_class=_CompilerOfLinked,  # pyright: ignore[reportArgumentType]
        )
        returns = str(made.signature.return_type)
        if returns not in RETURNS:
            raise UnknownCode(f'{function.__name__} returns {returns}')
        name = made.fndesc.llvm_func_name
        return Bitcode(made.library.whole(), name, of_members(kinds), returns)


class _Locator(UserProvidedCacheLocator):
    """Where a folder of ours keeps a function: numba's setting for all functions is left alone."""

    folder: Path

    def __init__(self, py_func: Any, py_file: str) -> None:
        super().__init__(py_func, py_file)
        self._cache_path = str(self.folder / self.get_suitable_cache_subpath(py_file))

    @classmethod
    def from_function(cls, py_func: Any, py_file: str) -> Any:
        return super(UserProvidedCacheLocator, cls).from_function(py_func, py_file)


class _Cache(FunctionCache):
    """Keeps what is compiled of one function in files that are whole or not read."""

    def __init__(self, function: Any) -> None:
        super().__init__(function)
        self._cache_file = KernelFiles(*names_of(self), _RELEASES)

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep what was compiled, if there is room."""
        with suppress(OSError):
            super().save_overload(sig, data)


@cache
def _cache_in(folder: Path) -> Callable[[Any], FunctionCache]:
    locator = type('_LocatorOfFolder', (_Locator,), {'folder': folder})
    kept = type('_Kept', (CompileResultCacheImpl,), {'_locator_classes': [locator]})
    return type('_CacheInFolder', (_Cache,), {'_impl_class': kept})


class _Called(CPUDispatcher):
    def __init__(
        self, function: Callable[..., Any], options: dict[str, Any], folder: Path | None
    ) -> None:
        options = options | {'no_cpython_wrapper': True}
        super().__init__(function, targetoptions=options, pipeline_class=_CompilerOfCalled)
        if folder is not None:
            self._cache = _cache_in(folder)(function)

    def get_call_template(self, args: Any, kws: Any) -> Any:
        return super().get_call_template(tuple(types.unliteral(a) for a in args), kws)


class _Typing(Context):
    """The types of operators with their operands, found once; all else as numba's own context."""

    def __init__(self, common: Any) -> None:
        self.__dict__ |= vars(common)
        self._known: dict[Any, Any] = {}

    def resolve_function_type(self, func: Any, args: Any, kws: Any) -> Any:
        other = isinstance(func, types.Type) and not isinstance(func, BaseFunction)
        if kws or other or not all(isinstance(a, types.Type) for a in args):
            return super().resolve_function_type(func, args, kws)
        signature = self._known.get((func, args))
        if signature is None:
            signature = super().resolve_function_type(func, args, kws)
            self._known[func, args] = signature
        return signature

    def resolve_setitem(self, target: Any, index: Any, value: Any) -> Any:
        key = operator.setitem, (target, index, value)
        if key not in self._known:
            self._known[key] = super().resolve_setitem(target, index, value)
        return self._known[key]


class _Lower(Lower):
    """Numbers of arrays are read and written where the index says, from the start of the array."""

    def lower_binop(self, resty: Any, expr: Any, op: Any) -> Any:
        signature = self.fndesc.calltypes[expr]
        kinds = signature.args
        if op in _POWERS or not all(isinstance(a, types.Number | types.Boolean) for a in kinds):
            return super().lower_binop(resty, expr, op)
        known = _OPERATORS.get((op, kinds))
        context, builder = self.context, self.builder
        if known is None:
            function = context.typing_context.resolve_value_type(op)
            resolved = function.get_call_type(context.typing_context, kinds, {})
            known = _OPERATORS[op, kinds] = function, resolved
        operands = [
            context.cast(builder, self.loadvar(side.name), self.typeof(side.name), kind)
            for side, kind in zip((expr.lhs, expr.rhs), kinds, strict=True)
        ]
        result = context.get_function(*known)(builder, operands)
        return context.cast(builder, result, signature.return_type, resty)

    def _is_number(self, array: Any, index: Any) -> bool:
        kind = self.typeof(array.name)
        return (
            index is not None
            and isinstance(kind, types.Array)
            and kind.ndim == 1
            and kind.layout == 'C'
            and isinstance(self.typeof(index.name), types.Integer)
        )

    def _pointer(self, array: Any, index: Any, kind: Any) -> Any:
        context, builder = self.context, self.builder
        model, held = context.data_model_manager[kind], self.loadvar(array.name)
        of = self.typeof(index.name)
        place = context.cast(
            builder, self.loadvar(index.name), of, types.intp if of.signed else types.uintp
        )
        if context.enable_boundscheck:
            size = builder.extract_value(model.get(builder, held, 'shape'), 0)
            cgutils.do_boundscheck(context, builder, place, size, 0)
        return builder.gep(model.get(builder, held, 'data'), [place])

    def lower_expr(self, resty: Any, expr: Any) -> Any:
        if expr.op == 'static_getitem' and self._is_number(expr.value, expr.index_var):
            return self.lower_getitem(resty, expr, expr.value, expr.index_var, None)
        return super().lower_expr(resty, expr)

    def lower_getitem(self, resty: Any, expr: Any, value: Any, index: Any, signature: Any) -> Any:
        if not self._is_number(value, index):
            return super().lower_getitem(resty, expr, value, index, signature)
        kind = self.typeof(value.name)
        pointer = self._pointer(value, index, kind)
        item = arrayobj.load_item(self.context, self.builder, kind, pointer)
        return self.context.cast(self.builder, item, kind.dtype, resty)

    def lower_inst(self, inst: Any) -> Any:
        if isinstance(inst, ir.StaticSetItem) and self._is_number(inst.target, inst.index_var):
            return self.lower_setitem(inst.target, inst.index_var, inst.value, None)
        return super().lower_inst(inst)

    def lower_setitem(
        self, target_var: Any, index_var: Any, value_var: Any, signature: Any
    ) -> Any:
        if not self._is_number(target_var, index_var):
            return super().lower_setitem(target_var, index_var, value_var, signature)
        kind = self.typeof(target_var.name)
        pointer = self._pointer(target_var, index_var, kind)
        number = self.loadvar(value_var.name)
        number = self.context.cast(self.builder, number, self.typeof(value_var.name), kind.dtype)
        arrayobj.store_item(self.context, self.builder, kind, number, pointer)
        return None


@register_pass(mutates_CFG=True, analysis_only=False)
class _Lowering(BaseNativeLowering):
    _name = 'kernel_lowering'

    @property
    def lowering_class(self) -> Any:
        return _Lower


_typing = cache(_Typing)  # one context for all kernels


class _Compiler(CompilerBase):
    def __init__(self, typingctx: Any, *arguments: Any) -> None:
        super().__init__(_typing(typingctx), *arguments)

    def compile_extra(self, func: Any) -> Any:
        if not gc.isenabled():  # also while an outer kernel compiles: under numba's lock
            return super().compile_extra(func)
        gc.disable()
        try:
            return super().compile_extra(func)
        finally:
            gc.enable()

    def define_pipelines(self) -> list[PassManager]:
        short = PassManager('kernel')
        for made, description in DefaultPassBuilder.define_nopython_pipeline(self.state).passes:
            if made.__name__ not in _NOT_IN_KERNELS:
                short.add_pass(_Lowering if made is NativeLowering else made, description)
        short.finalize()
        return [short]


class _CompilerOfKernel(_Compiler):
    def define_pipelines(self) -> list[PassManager]:
        state = self.state
        state.library = _Whole(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        return super().define_pipelines()


class _Whole(JITCodeLibrary):
    """
    A kernel with all that it calls, which nobody else calls: LLVM drops the arguments that are not
    used, of each array five words out of seven. Left alone it would then make one function of all
    that is called once, and lose sight of what is in registers; so what is long stays a function.
    """

    def _optimize_final_module(self) -> None:
        codegen, module = self._codegen, self._final_module
        cheap, builder = codegen._module_pass_manager(
            loop_vectorize=False, slp_vectorize=False, opt=0, cost='cheap'
        )
        cheap.run(module, builder)
        for function in module.functions:
            if not function.is_declaration and function.linkage == ll.Linkage.linkonce_odr:
                function.linkage = 'internal'
                if is_long(function):
                    function.add_function_attribute('noinline')
        full, builder = codegen._module_pass_manager()
        full.run(module, builder)


class _CompilerOfLinked(_Compiler):
    def define_pipelines(self) -> list[PassManager]:
        state = self.state
        state.library = _Linked(state.targetctx.codegen(), state.func_id.func_qualname)
        return super().define_pipelines()


class _Linked(JITCodeLibrary):
    """A kernel with all that it calls, of which nobody here makes machine code."""

    def whole(self) -> bytes:
        """Give its bitcode; UnknownCode if it holds an address of this process."""
        self._codegen._check_llvm_bugs()
        module = self._final_module
        for library in dict.fromkeys(self._linking_libraries):
            module.link_in(library._get_module_for_linking(), preserve=True)
        if self._reload_init or any(
            variable.name.startswith('numba.dynamic.globals')
            for variable in module.global_variables
        ):
            raise UnknownCode(f'{self.name} holds what only this process has')
        return module.as_bitcode()


class _CompilerOfCalled(_Compiler):
    def define_pipelines(self) -> list[PassManager]:
        state = self.state
        state.library = _Bitcode(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.is_wide = 'lanes' in state.func_id.arg_names
        state.library.enable_object_caching()
        return super().define_pipelines()


class _Bitcode(JITCodeLibrary):
    """
    A compiled function of which callers take the bitcode, and nobody the machine code.

    What numba loads of it, now and from the cache, is an empty module with the one variable that
    numba sets in every function.

    is_wide : it loops over lanes and stays a function: inlined, all its arrays would be one, which
              takes more checks for overlap than LLVM makes, and SIMD would be lost
    """

    is_wide = False

    def finalize(self) -> None:
        environment = [
            variable.name
            for variable in self._final_module.global_variables
            if variable.name.startswith('_ZN08NumbaEnv')
        ]
        for function in self._final_module.functions:  # its own: what it calls is so already
            if not function.is_declaration and function.linkage == ll.Linkage.external:
                function.linkage = 'linkonce_odr'  # as many callers may bring it along
                if self.is_wide:
                    function.add_function_attribute('noinline')
        for library in dict.fromkeys(self._linking_libraries):
            self._reload_init.update(library._reload_init)
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._shared_module = self._final_module
        empty = str(self._codegen._create_empty_module(self.name))
        empty += ''.join(f'@"{name}" = common global i8* null\n' for name in environment)
        self._final_module = ll.parse_assembly(empty)
        self._final_module.name = self.name
        self._finalize_final_module()
