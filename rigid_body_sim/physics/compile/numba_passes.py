# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What numba makes of the bytecode of a kernel before it is typed, and what it removes after: passes
that take the place of numba's own, without what no kernel asks for.

    reading     looks for lists, dictionaries and `with`, which numba reads in two steps, only
                where there are any
    rewriting   of constant indices and exponents is done as numba does it
    blocks      are brought in order; until when a variable lives is of no interest to
                `numba_lowering`, which is most of the work of numba's passes
"""

from __future__ import annotations

import opcode
from functools import cache
from types import CodeType
from typing import Any

from numba.core import errors, ir, ir_utils
from numba.core.compiler_machinery import register_pass
from numba.core.interpreter import Interpreter
from numba.core.rewrites.registry import rewrite_registry
from numba.core.ssa import reconstruct_ssa
from numba.core.transforms import canonicalize_cfg
from numba.core.typed_passes import PreLowerStripPhis
from numba.core.untyped_passes import (
    GenericRewrites,
    IRProcessing,
    ReconstructSSA,
    TranslateByteCode,
)

_MENDED = 'LIST', 'DICT', 'MAP', 'WITH', 'FINALLY', '_EX'  # in names of operations


@register_pass(mutates_CFG=True, analysis_only=False)
class Reading(TranslateByteCode):
    """Statements of a function, from its bytecode."""

    _name = 'kernel_reading'

    def run_pass(self, state: Any) -> Any:
        """Read them."""
        state['func_ir'] = _Interpreter(state['func_id']).interpret(state['bc'])
        return True


class _Interpreter(Interpreter):
    def post_process(self, peepholes: Any, func_ir: Any) -> Any:
        if not _is_mended(func_ir.func_id.code):
            return func_ir
        return super().post_process(peepholes, func_ir)


@cache
def _is_mended(code: CodeType) -> bool:
    """Tell whether a function makes what numba reads in two steps."""
    if getattr(code, 'co_exceptiontable', b''):
        return True
    names = {opcode.opname[operation] for operation in code.co_code[::2]}
    return any(word in name for name in names for word in _MENDED)


@register_pass(mutates_CFG=True, analysis_only=False)
class Rewriting(GenericRewrites):
    """What numba writes in another way before it looks for types."""

    _name = 'kernel_rewriting'

    def run_pass(self, state: Any) -> Any:
        """Rewrite it, until nothing is left to rewrite."""
        blocks = state.func_ir.blocks
        for made in rewrite_registry.rewrites['before-inference']:
            rewrite = made(state)
            ahead = list(blocks.items())
            while ahead:
                label, block = ahead.pop()
                if rewrite.match(state.func_ir, block, state.typemap, state.calltypes):
                    blocks[label] = rewrite.apply()
                    blocks[label].verify()
                    ahead.append((label, blocks[label]))
        _shape(state.func_ir)
        return True


@register_pass(mutates_CFG=False, analysis_only=False)
class Processing(IRProcessing):
    _name = 'kernel_processing'

    def run_pass(self, state: Any) -> Any:
        _shape(state.func_ir)
        for block in state.func_ir.blocks.values():
            _order_handed_on(block.body)
        return True


@register_pass(mutates_CFG=False, analysis_only=False)
class Assignments(ReconstructSSA):
    _name = 'kernel_assignments'

    def run_pass(self, state: Any) -> Any:
        state.func_ir = reconstruct_ssa(state.func_ir)
        state.func_ir._definitions = ir_utils.build_definitions(state.func_ir.blocks)
        _shape(state.func_ir)
        return True


@register_pass(mutates_CFG=False, analysis_only=False)
class WithoutPhis(PreLowerStripPhis):
    _name = 'kernel_without_phis'

    def run_pass(self, state: Any) -> Any:
        state.func_ir = self._strip_phi_nodes(state.func_ir)
        state.func_ir._definitions = ir_utils.build_definitions(state.func_ir.blocks)
        _shape(state.func_ir)
        return True


def _shape(func_ir: Any) -> None:
    """Bring blocks in order; until when a variable lives is of no interest to `LowerKernel`."""
    if func_ir.is_generator:
        raise errors.UnsupportedError('a kernel is no generator', func_ir.loc)
    func_ir.blocks = canonicalize_cfg(func_ir.blocks)
    func_ir.generator_info = None


def _order_handed_on(body: list[Any]) -> None:
    """Order what a block hands on to the next by name: numba goes by the hashes of strings."""
    begin = end = len(body) - 1
    while begin and isinstance(body[begin - 1], ir.Assign) and _is_handed_on(body[begin - 1]):
        begin -= 1
    body[begin:end] = sorted(body[begin:end], key=lambda one: one.target.name)


def _is_handed_on(assigned: Any) -> bool:
    return assigned.target.name.startswith('$phi')
