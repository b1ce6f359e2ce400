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
                text for LLVM (`pieces`), kept in a file: LLVM simplifies it once, by itself, and
                reads it with each kernel; no piece is checked or linked by itself
    Kernel      what Python calls, where no image can be (`images`): optimised and turned into
                machine code by numba, once, with all that it calls
    _Whole      the code of such a kernel, optimised as what it is: closed; as `image_maker` does

and of the work in Python before that,

    references  of arrays are not counted, for a kernel makes none and keeps none; one that
                allocated would now be refused
    indices     are taken as they are (`numba_lowering`): no kernel counts from the end of an
                array, and to look for that at each of thousands of accesses is most of what
                fetching a body costs; nor do parts of arrays and ranges ask
    calls       hand on two words an array, and ask nobody whether it went well (`numba_calls`)
    types       of an operator with its operands are resolved once, not at every occurrence
                (`numba_typing`); a literal argument is typed like any other number, so that no
                function is compiled once for a 0 and once for a 3
    garbage     is not looked for meanwhile: nearly all that is made is kept to the end
    passes      for closures and array expressions, which kernels do not have, are left out, that
                which says until when a variable lives, and the one for a printout of types, which
                keeps the code of every function as it was read: half of the Python objects that
                live after a compilation; others do less (`numba_passes`)

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

Pieces as text came later: cold compile of `stack` (390 functions) 17 to 18 s in place of 23 s of
processor time, on cores busier than those above, and 490 MB in place of 690, where the state
before spent 3 s on optimising, linking and checking function by function, and some 2 s on passes
that kernels do not need. Of it, `simplify` takes 2 s and gives back 1.7; without it a tick of
`stack` takes 2 % longer.

Calls, parts and ranges came last: of the text of `stack` (685 functions, 299,000 lines) half is
left, its first start takes 27.7 s in place of 35.4 s on a quiet machine, a tick of it 0.95 of
before, of a pile 0.99. LLVM makes vectors of a loop that calls only if a tuple comes back by way
of memory, and if it finds the count of a range whose end is a multiple of its step: each of the
two, left out, made a pile 1.4 times as slow.

After them, passes that ask less (`numba_passes`), one sweep over what has no loop in place of two
(`numba_typing`) and writers of calls that are looked for once (`numba_calls`): the work in Python
of a kernel with all pairs of shapes (1131 functions) takes 0.85 of before; not a letter of its
text is another one.

Pieces are simplified one by one last of all: before, each kernel simplified all that it called,
pieces of other kernels too. The first kernel takes the same time, and the next ones, of which most
pieces are known, 0.7 of before (processor time of tests that compile the second, third and fourth
kernel of all pairs of shapes: 51, 37 and 41 s before, 36, 28 and 30 s now); what is kept takes a
third of the room (`stack`: 24 and 8 MB), and the machine code is the same, byte by byte.

`make test-bounds` runs the tests of kernels with each index checked.
"""

from __future__ import annotations

import gc
import pickle
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import cache
from hashlib import sha256
from itertools import chain
from pathlib import Path
from typing import Any
from weakref import WeakSet

import numba
from numba.core import cgutils, config, event, sigutils, types
from numba.core.caching import CompileResultCacheImpl, FunctionCache, UserProvidedCacheLocator
from numba.core.codegen import (
    CodeLibrary,
    JITCodeLibrary,
    ll,  # pyright: ignore[reportPrivateImportUsage]: llvmlite, which comes with numba
)
from numba.core.compiler import (
    CompilerBase,
    CompileResult,
    DefaultPassBuilder,
    Flags,
    StateDict,
    _LowerResult,
    compile_extra,
    compile_result,
)
from numba.core.compiler_lock import global_compiler_lock
from numba.core.compiler_machinery import PassManager, register_pass
from numba.core.funcdesc import PythonFunctionDescriptor
from numba.core.registry import CPUDispatcher, cpu_target
from numba.core.runtime.nrt import rtsys
from numba.core.serialize import dumps
from numba.core.typed_passes import (
    BaseNativeLowering,
    NativeLowering,
    NopythonTypeInference,
    PreLowerStripPhis,
)
from numba.core.typing.typeof import Purpose, typeof
from numba.core.untyped_passes import (
    GenericRewrites,
    IRProcessing,
    ReconstructSSA,
    TranslateByteCode,
)

from rigid_body_sim.physics.compile import numba_calls, pieces
from rigid_body_sim.physics.compile.elf import UnknownCode
from rigid_body_sim.physics.compile.image import RETURNS, of_members
from rigid_body_sim.physics.compile.image_maker import Bitcode, is_long, simplify
from rigid_body_sim.physics.compile.kernel_files import KernelFiles, names_of
from rigid_body_sim.physics.compile.numba_lowering import LowerKernel
from rigid_body_sim.physics.compile.numba_passes import (
    Assignments,
    Processing,
    Reading,
    Rewriting,
    WithoutPhis,
)
from rigid_body_sim.physics.compile.numba_typing import Inference, Typing
from rigid_body_sim.physics.compile.sources import digest_of

_ALL_CALLED: WeakSet[_Called] = WeakSet()

_RELEASES = f'numba {numba.__version__} LLVM {ll.llvm_version_info}'
_LONGEST = 100  # of the name of a function in that of a file
_RESOLVED_LATER = 'llvm.', '.numba.unresolved$'  # by LLVM; by numba, where a function calls itself
_DIGITS = 24  # of the digest in a symbol
_NOT_IN_KERNELS = {
    'InlineClosureLikes',
    'NopythonRewrites',  # of array expressions
    'IRLegalization',  # says until when a variable lives
    'AnnotateTypes',  # for a printout, for which each function would keep all its code as read
}


def _options(*, inlined: bool) -> dict[str, Any]:
    options: dict[str, Any] = {'nogil': True, 'error_model': 'numpy', 'forceinline': inlined}
    options |= {'nopython': True, 'boundscheck': None}
    return options | {'_nrt': False, 'no_cfunc_wrapper': True}


def _flags(*, inlined: bool) -> Any:
    flags: Any = Flags()
    cpu_target.options.parse_as_flags(flags, _options(inlined=inlined))
    return flags


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

    def compile(self, sig: Any) -> Any:
        return _from_source_if_unresolved(lambda: super(Kernel, self).compile(sig))


def make_ready() -> None:
    """Let numba learn its own functions, 0.2 s: for who forks before the first kernel."""
    target: Any = cpu_target
    target.typing_context.refresh()
    target.target_context.refresh()


def twin(function: Callable[..., Any], folder: Path | None, *, inlined: bool) -> Any:
    """Give what numba is to compile of a function that a kernel calls."""
    return _Called(function, _options(inlined=inlined), folder and folder / 'pieces')


def _from_source_if_unresolved(make: Callable[[], Any]) -> Any:
    """Give what is made of pieces; where those that are kept do not fit together, of new ones."""
    with global_compiler_lock:
        try:
            return make()
        except pieces.Unresolved:
            for called in _ALL_CALLED:
                called.forget()
            return make()


def linked(function: Callable[..., Any], arguments: Sequence[Any], kinds: tuple[str, ...]) -> Any:
    """
    Compile a kernel with all that it calls, as far as to bitcode: an `image_maker.Bitcode`.

    arguments : as the kernel is called with, of these kinds

    UnknownCode if numba's code of a kernel is not what an image can call.
    """
    try:
        return _from_source_if_unresolved(lambda: _linked(function, arguments, kinds))
    except pieces.Unresolved as error:
        raise UnknownCode(str(error)) from error


def _linked(function: Callable[..., Any], arguments: Sequence[Any], kinds: tuple[str, ...]) -> Any:
    took = tuple(typeof(value, Purpose.argument) for value in arguments)
    made = compile_extra(
        cpu_target.typing_context,
        cpu_target.target_context,
        function,
        args=took,
        return_type=None,
        flags=_flags(inlined=False),
        locals={},
        pipeline_class=_CompilerOfLinked,  # pyright: ignore[reportArgumentType]
    )
    returns = str(made.signature.return_type)
    if returns not in RETURNS:
        raise UnknownCode(f'{function.__name__} returns {returns}')
    whole = made.library._get_module_for_linking()
    variables = (variable.name for variable in whole.global_variables)
    if made.library._reload_init or pieces.hold_addresses(variables):
        raise UnknownCode(f'{function.__name__} holds what only this process has')
    return Bitcode((whole.as_bitcode(),), made.fndesc.llvm_func_name, of_members(kinds), returns)


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

    def _index_key(self, sig: Any, codegen: Any) -> tuple[Any, ...]:
        return *super()._index_key(sig, codegen), digest_of(self._py_func), _checks()

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep what was compiled, if there is room."""
        with suppress(OSError):
            super().save_overload(sig, data)


def _checks() -> Any:
    """Whether each index is checked: numba asks the environment, whatever the options say."""
    return getattr(config, 'BOUNDSCHECK', None)


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
        self._files = folder and _pieces_in(folder)
        _ALL_CALLED.add(self)

    def forget(self) -> None:
        """Compile from source, the next time that a caller asks."""
        self.overloads.clear()
        if self._files is not None:
            self._files.distrust()

    def get_call_template(self, args: Any, kws: Any) -> Any:
        return super().get_call_template(tuple(types.unliteral(a) for a in args), kws)

    def add_overload(self, cres: CompileResult) -> None:
        self.overloads[tuple(cres.signature.args)] = cres  # Python itself never calls it

    def compile(self, sig: Any) -> Any:
        args, returns = sigutils.normalize_signature(sig)
        if args not in self.overloads:
            with self._compiling_counter:
                place = None if self._files is None else self._place(args)
                self.add_overload(self._kept(place) or self._made(args, returns, place))
        return self.overloads[args].entry_point

    def _place(self, args: Any) -> tuple[str, str]:
        """Give the name of the file of a piece, and its key."""
        source = f'{self.py_func.__module__.rpartition(".")[2]}.{self.py_func.__qualname__}'
        told = f'{_RELEASES} python {sys.version} {self.targetoptions} {_checks()} {args}'
        return source[:_LONGEST], f'piece {source} {digest_of(self.py_func)} {told}'

    def _kept(self, place: tuple[str, str] | None) -> Any:
        found = None if self._files is None or place is None else self._files.load(*place)
        if found is None:
            return None
        piece, beside = found
        described, signature, raises = pickle.loads(beside)
        context: Any = self.targetctx
        library = _Piece(context.codegen(), described.qualname)
        library.raises = raises
        library.hold(piece)
        entry = _entry_of(context, described, library)
        return _result(context, described, signature, library, entry)

    def _made(self, args: Any, returns: Any, place: tuple[str, str] | None) -> Any:
        compiler: Any = self._compiler  # pyright: ignore[reportAttributeAccessIssue]
        told = {'dispatcher': self, 'args': args, 'return_type': returns}
        with event.trigger_event('numba:compile', data=told):  # for who counts, as numba tells it
            made = compiler.compile(args, returns)
        library = made.library
        library._ensure_finalized()
        if self._files is not None and place is not None:
            made.fndesc.typemap = made.fndesc.calltypes = None
            beside = dumps((made.fndesc, made.signature, library.raises))
            library.hold(self._files.save(*place, library.text, beside))
        return made


def _symbol(name: str, kinds: Any, *, abi_tags: Sequence[str], uid: str) -> str:
    """
    Name a piece by what it is made of. numba counts the functions of a process in its symbols: a
    text that names another one would be another text in each process.
    """
    made_of = f'{uid} {kinds} {abi_tags} {_RELEASES}'
    return f'{name}.{sha256(made_of.encode()).hexdigest()[:_DIGITS]}'


def _entry_of(context: Any, described: Any, library: Any) -> object:
    """Let numba know a piece: give that by which it finds it."""
    entry = object()
    if library.raises:
        context.insert_user_function(entry, described, [library])
    else:
        write: Any = numba_calls.caller(described, library)
        context._defns[entry].append(write, write.signature)
    return entry


def _result(
    context: Any, described: Any, signature: Any, library: Any, entry: Any
) -> CompileResult:
    return compile_result(
        typing_context=context.typing_context, target_context=context, entry_point=entry,
        library=library, signature=signature, objectmode=False, lifted=(), fndesc=described,
        reload_init=[], metadata={},
    )  # fmt: skip


@cache
def _pieces_in(folder: Path) -> pieces.PieceFiles:
    return pieces.PieceFiles(folder)


@register_pass(mutates_CFG=True, analysis_only=False)
class _Lowering(BaseNativeLowering):
    _name = 'kernel_lowering'

    @property
    def lowering_class(self) -> Any:
        return LowerKernel

    def run_pass(self, state: Any) -> Any:
        if not isinstance(state.library, _Piece):
            return super().run_pass(state)
        context, flags = state.targetctx, state.flags
        described = PythonFunctionDescriptor.from_specialized_function(
            state.func_ir, state.typemap, state.return_type, state.calltypes,
            mangler=_symbol, inline=flags.forceinline, noalias=flags.noalias,
            abi_tags=[flags.get_mangle_string()],
        )  # fmt: skip
        try:
            lower = self._lowered(state, numba_calls.of_pieces(context), described)
        except numba_calls.Raises:
            state.library.raises = True
            lower = self._lowered(state, context, described)
        entry = _entry_of(context, described, state.library)
        state['cr'] = _LowerResult(described, lower.call_helper, entry, lower.env)
        return True

    def _lowered(self, state: Any, context: Any, described: Any) -> Any:
        if state.library.raises and isinstance(context, numba_calls.ContextOfPieces):
            raise numba_calls.Raises('what Python calls')
        lower = LowerKernel(context, state.library, described, state.func_ir, state.metadata)
        with context.push_code_library(state.library):
            lower.lower()
        return lower


_OWN_PASSES = {
    TranslateByteCode: Reading,
    IRProcessing: Processing,
    ReconstructSSA: Assignments,
    GenericRewrites: Rewriting,
    NopythonTypeInference: Inference,
    PreLowerStripPhis: WithoutPhis,
    NativeLowering: _Lowering,
}
_typing = cache(Typing)  # one context for all kernels


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
        return [_passes()]


class _Passes(PassManager):
    """Passes one after the other; numba tells listeners of each, and asks whether it was legal."""

    def _runPass(self, index: int, pss: Any, internal_state: Any) -> None:  # pyright: ignore[reportIncompatibleVariableOverride]  # noqa: N802
        pss.analysis = self._analysis
        pss.run_initialization(internal_state)
        pss.run_pass(internal_state)
        pss.run_finalizer(internal_state)


@cache
def _passes() -> PassManager:
    """Give the passes of all kernels: numba's, without those that kernels do not need."""
    state = StateDict(func_ir=None, flags=_flags(inlined=False))
    passes = _Passes('kernel')
    for made, description in DefaultPassBuilder.define_nopython_pipeline(state).passes:
        if made.__name__ not in _NOT_IN_KERNELS:
            passes.add_pass(_OWN_PASSES.get(made, made), description)
    passes.finalize()
    return passes


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
        _want_whole(module)  # what is not there would be jumped to all the same
        simplify(module)
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


class _CompilerOfCalled(_Compiler):
    def define_pipelines(self) -> list[PassManager]:
        state = self.state
        state.func_id.unique_id = digest_of(state.func_id.func)
        state.library = _Piece(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.is_wide = 'lanes' in state.func_id.arg_names
        return super().define_pipelines()


class _CompilerOfLinked(_CompilerOfCalled):
    def define_pipelines(self) -> list[PassManager]:
        passes = super().define_pipelines()
        self.state.library.raises = True
        return passes


class _Piece(CodeLibrary):
    """
    A function that kernels call: text for LLVM, which nobody reads before a kernel is whole.

    is_wide : it loops over lanes and stays a function: inlined, all its arrays would be one, which
              takes more checks for overlap than LLVM makes, and SIMD would be lost
    raises  : it is called as numba does, for it may raise an error, or Python calls it
    """

    is_wide = False
    raises = False

    def __init__(self, codegen: Any, name: str) -> None:
        super().__init__(codegen, name)
        self._libraries: dict[CodeLibrary, None] = {}
        self._shared_module: Any = None
        self.text: pieces.Piece | None = None

    def add_ir_module(self, ir_module: Any) -> None:
        for value in ir_module.functions:
            if not value.is_declaration:
                value.linkage = 'linkonce_odr'  # as many callers may bring it along
                if self.is_wide:
                    set.add(value.attributes, 'noinline')
        self._parts = _taken_apart(ir_module)

    def add_linking_library(self, library: CodeLibrary) -> None:
        if library is not rtsys.library:  # no piece allocates
            self._libraries[library] = None

    def finalize(self) -> None:
        foreign, needs = {}, []
        library: Any
        for library in self._libraries:
            library._ensure_finalized()
            if isinstance(library, _Piece):
                assert library.text is not None
                needs.append(library.text)
            else:
                self._reload_init.update(library._reload_init)
                bitcode = library._get_module_for_linking().as_bitcode()
                foreign[sha256(bitcode).hexdigest()] = bitcode
        self.hold(pieces.Piece(*self._parts, foreign, tuple(needs)))

    def hold(self, text: pieces.Piece) -> None:
        """Take the text of the function."""
        self.text, self._finalized = text, True

    def get_function(self, name: str) -> Any:
        return self._get_module_for_linking().get_function(name)

    def get_llvm_str(self) -> Any:
        return str(self._get_module_for_linking())

    def get_asm_str(self) -> Any:
        raise NotImplementedError  # nobody makes machine code of it

    def _get_module_for_linking(self) -> Any:
        if self._shared_module is None:
            self._ensure_finalized()
            assert self.text is not None
            self._shared_module = _module_of(self._codegen, [self.text])
        return self._shared_module


def _module_of(codegen: Any, texts: Sequence[pieces.Piece]) -> Any:
    """
    Let LLVM read texts, with all that they need.

    Unresolved if they name what nobody defines.
    """
    module = ll.parse_assembly(pieces.joined(str(codegen._create_empty_module('kernel')), texts))
    foreign = {name: one for text in pieces.in_order(texts) for name, one in text.foreign.items()}
    for bitcode in foreign.values():
        called = ll.parse_bitcode(bitcode)
        simplify(called)
        module.link_in(called)
    _want_whole(module)
    return module


def _want_whole(module: Any) -> None:
    """Unresolved if a module names what neither it defines nor this process has."""
    missing = [
        value.name
        for value in chain(module.functions, module.global_variables)
        if value.is_declaration
        and not value.name.startswith(_RESOLVED_LATER)
        and ll.address_of_symbol(value.name) is None
    ]
    if missing:
        raise pieces.Unresolved(f'nobody defines {", ".join(sorted(missing))}')


def _taken_apart(module: Any) -> tuple[dict[str, str], dict[str, str]]:
    """Simplify a module of llvmlite; give what it defines, and what it declares: `pieces`."""
    if module.namedmetadata or module.get_identified_types():
        raise UnknownCode(f'{module.name} holds what a piece cannot')
    read = ll.parse_assembly(cgutils.normalize_ir_text(str(module)), ll.create_context())
    simplify(read)
    return pieces.taken_apart(str(read))
