# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
How numba finds the types of a kernel, in less of its time:

    operators   and their operands are resolved once for all kernels, not at every occurrence
    min, max    and int of numbers have their types at once: numba compiles a function for each
    sweeps      over a function without a loop are one: numba goes over it until nothing changes,
                at least twice
    warnings    of a function that is typed are nobody's: numba catches them statement by statement
"""

from __future__ import annotations

import operator
from contextlib import AbstractContextManager, nullcontext
from typing import Any

from numba.core import errors, types
from numba.core.compiler_machinery import register_pass
from numba.core.typed_passes import NopythonTypeInference
from numba.core.typeinfer import TypeInferer
from numba.core.types.functions import BaseFunction
from numba.core.typing.context import Context
from numba.core.typing.templates import signature as signature_of

from rigid_body_sim.physics.compile.numba_lowering import OF_NUMBERS


class Typing(Context):
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
            signature = self._of_numbers(func, args)
            signature = signature or super().resolve_function_type(func, args, kws)
            self._known[func, args] = signature
        return signature

    def _of_numbers(self, func: Any, args: Any) -> Any:
        """Give the types of what numba would compile a function for."""
        if getattr(func, 'typing_key', None) not in OF_NUMBERS or not args:
            return None
        took = [types.unliteral(a) for a in args]
        if not all(isinstance(a, types.Integer | types.Float) for a in took):
            return None
        if func.typing_key is not int:
            result = self.unify_types(*took) if len(took) > 1 else None
        elif len(took) == 1:
            result = took[0] if isinstance(took[0], types.Integer) else types.intp
        else:
            result = None
        return None if result is None else signature_of(result, *took)

    def resolve_setitem(self, target: Any, index: Any, value: Any) -> Any:
        key = operator.setitem, (target, index, value)
        if key not in self._known:
            self._known[key] = super().resolve_setitem(target, index, value)
        return self._known[key]


@register_pass(mutates_CFG=True, analysis_only=False)
class Inference(NopythonTypeInference):
    """The types of all variables and calls of a function."""

    _name = 'kernel_type_inference'

    def run_pass(self, state: Any) -> Any:
        """Find them."""
        func_ir, context = state.func_ir, state.typingctx
        inferer = _Inferer(context, func_ir, _NotCaught())
        with context.callstack.register(
            state.targetctx.target, inferer, func_ir.func_id, state.args
        ):
            for index, (name, kind) in enumerate(zip(func_ir.arg_names, state.args, strict=True)):
                inferer.seed_argument(name, index, kind)
            if state.return_type is not None:
                inferer.seed_return(state.return_type)
            inferer.build_constraint()
            inferer.propagate()
            state.typemap, state.return_type, state.calltypes = inferer.unify()
        if isinstance(state.return_type, types.Array | types.Function | types.Phantom):
            raise errors.NumbaTypeError(f'a kernel returns no {state.return_type}')
        return True


class _Inferer(TypeInferer):
    def propagate(self, raise_errors: bool = True) -> Any:
        """Go over all statements until no type changes."""
        if _goes_forward(self.blocks) and not self.constraints.propagate(self):
            return None  # whatever a statement takes was typed before it
        return super().propagate(raise_errors)


def _goes_forward(blocks: Any) -> bool:
    """Tell whether a function has no loop, and its blocks come in the order in which they run."""
    place = {label: number for number, label in enumerate(blocks)}
    return all(
        place[target] > place[label]
        for label, block in blocks.items()
        for target in block.terminator.get_targets()
    )


class _NotCaught:
    """Stands for what numba catches warnings with."""

    def catch_warnings(
        self, filename: Any = None, lineno: Any = None
    ) -> AbstractContextManager[None]:
        return nullcontext()
