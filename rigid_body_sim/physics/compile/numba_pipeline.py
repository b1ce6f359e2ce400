# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
numba, told what a kernel does not need: the same bits, compiled in less than half of the time, and
up to a fifth faster.

A scene with contact is some hundred small functions, of which Python calls one. numba treats each
as if Python might call it: wraps it twice, optimises it together with all that it calls, turns it
into machine code, and does so again for whoever calls it. Here

    Kernel      what Python calls: optimised and turned into machine code as always, once, with
                all that it calls
    _Called     what a kernel calls: its twin, made only when a kernel names it, which ends as
                bitcode, ready to be linked into a caller

and of the work in Python before that,

    references  of arrays are not counted, for a kernel makes none and keeps none; one that
                allocated would now be refused
    indices     are taken as they are: no kernel counts from the end of an array, and to look for
                that at each of thousands of accesses is most of what fetching a body costs
    passes      for closures, `with`, array expressions, and what else kernels do not have, are
                left out
    types       of an operator with its operands are resolved once, not at every occurrence; a
                literal argument is typed like any other number, so that no function is compiled
                twice for a 0 and a 3
    garbage     is not looked for meanwhile: nearly all that is made is kept to the end

`make test-bounds` runs the tests of kernels with each index checked.

This leans on the inside of numba, and `kernels` asks another release than those it names there
for an ordinary function: that costs time, not the run.
"""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from numba.core import types
from numba.core.codegen import (
    JITCodeLibrary,
    ll,  # pyright: ignore[reportPrivateImportUsage]: llvmlite, which comes with numba
)
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import PassManager
from numba.core.registry import CPUDispatcher
from numba.core.types.functions import BaseFunction
from numba.np import arrayobj

_NOT_IN_KERNELS = {
    'WithLifting', 'InlineClosureLikes', 'RewriteDynamicRaises', 'MakeFunctionToJitFunction',
    'InlineInlinables', 'FindLiterallyCalls', 'LiteralUnroll', 'LiteralPropagationSubPipelinePass',
    'InlineOverloads', 'NopythonRewrites', 'DumpParforDiagnostics', 'AnnotateTypes',
}  # fmt: skip


class Kernel(CPUDispatcher):
    """
    A compiled function as Python calls it; a kernel that names it gets its twin.

        options : of `numba.njit`
        cached  : makes a dispatcher keep what it compiles in a folder of that name, if any
    """

    def __init__(
        self, function: Callable[..., Any], options: dict[str, Any], cached: Callable[..., None]
    ) -> None:
        options = options | {'nopython': True, 'boundscheck': None}
        options |= {'_nrt': False, 'no_cfunc_wrapper': True}
        super().__init__(function, targetoptions=options, pipeline_class=_Compiler)
        self._cached, self._twin = cached, None
        cached(self, '')

    @property
    def _numba_type_(self) -> Any:
        """What numba takes a global of this value for."""
        if self._twin is None:
            self._twin = _Called(self.py_func, self.targetoptions)
            self._cached(self._twin, 'called')
        return self._twin._numba_type_


class _Called(CPUDispatcher):
    def __init__(self, function: Callable[..., Any], options: dict[str, Any]) -> None:
        options = options | {'no_cpython_wrapper': True}
        super().__init__(function, targetoptions=options, pipeline_class=_CompilerOfCalled)

    def get_call_template(self, args: Any, kws: Any) -> Any:
        return super().get_call_template(tuple(types.unliteral(a) for a in args), kws)


class _Compiler(CompilerBase):
    def compile_extra(self, func: Any) -> Any:
        with _sparing():
            return super().compile_extra(func)

    def define_pipelines(self) -> list[PassManager]:
        short = PassManager('kernel')
        for made, description in DefaultPassBuilder.define_nopython_pipeline(self.state).passes:
            if made.__name__ not in _NOT_IN_KERNELS:
                short.add_pass(made, description)
        short.finalize()
        return [short]


class _CompilerOfCalled(_Compiler):
    def define_pipelines(self) -> list[PassManager]:
        state = self.state
        state.library = _Bitcode(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        return super().define_pipelines()


class _Bitcode(JITCodeLibrary):
    """
    A compiled function of which callers take the bitcode, and nobody the machine code.

    What numba loads of it, now and from the cache, is an empty module with the one variable that
    numba sets in every function.
    """

    def finalize(self) -> None:
        environment = [
            variable.name
            for variable in self._final_module.global_variables
            if variable.name.startswith('_ZN08NumbaEnv')
        ]
        for library in dict.fromkeys(self._linking_libraries):
            self._reload_init.update(library._reload_init)
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage == ll.Linkage.external:
                function.linkage = 'linkonce_odr'  # as many callers may bring it along
        self._shared_module = self._final_module
        empty = str(self._codegen._create_empty_module(self.name))
        empty += ''.join(f'@"{name}" = common global i8* null\n' for name in environment)
        self._final_module = ll.parse_assembly(empty)
        self._final_module.name = self.name
        self._finalize_final_module()


_function: Any = BaseFunction  # of Python, as numba types it
_resolve = _function.get_call_type
_resolved: dict[Any, Any] = {}  # during a compilation: signatures by function and operands


def _resolve_once(function: Any, context: Any, args: Any, kws: Any) -> Any:
    if kws:
        return _resolve(function, context, args, kws)
    key = function, tuple(args)
    signature = _resolved.get(key)
    if signature is None:
        signature = _resolved[key] = _resolve(function, context, args, kws)
    return signature


_arrays: Any = arrayobj  # of which one function is exchanged
_counted_from_both_ends = _arrays.fix_integer_index


def _as_it_is(context: Any, builder: Any, kind: Any, index: Any, _length: Any) -> Any:
    """Take an index of an array for one that is not negative."""
    return context.cast(builder, index, kind, types.intp if kind.signed else types.uintp)


@contextmanager
def _sparing() -> Iterator[None]:
    """
    Resolve once, take indices as they are and look for no garbage, while the outermost kernel is
    compiled.
    """
    if _function.get_call_type is _resolve_once:
        yield
        return
    collecting = gc.isenabled()
    # under numba's lock: one compilation at a time
    _function.get_call_type = _resolve_once
    _arrays.fix_integer_index = _as_it_is
    gc.disable()
    try:
        yield
    finally:
        _function.get_call_type = _resolve
        _arrays.fix_integer_index = _counted_from_both_ends
        _resolved.clear()
        if collecting:
            gc.enable()
