# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What numba's code of a kernel is made of: the same as of any function, in fewer words.

    numbers of arrays   are read and written where the index says, from the start of the array
    parts of arrays     begin where the first index says, and end where the second says, or with
                        the array: nobody asks whether one of them counts from the end
    ranges              are counted down, by a step that is a constant
    calls               of pieces are those of `numba_calls`
    variables           are forgotten as they are, and have a place in memory only if more than one
                        block uses them

With NUMBA_BOUNDSCHECK each index is checked.
"""

from __future__ import annotations

import operator
from functools import partial
from typing import Any

from llvmlite import ir as llvm
from numba.core import cgutils, errors, ir, types
from numba.core.lowering import Lower
from numba.cpython.builtins import do_minmax
from numba.np import arrayobj

from rigid_body_sim.physics.compile import numba_calls

OF_NUMBERS = {min: operator.lt, max: operator.gt, int: None}
_POWERS = {operator.pow, operator.ipow}  # of which numba knows some by their exponent
_OPERATORS: dict[Any, Any] = {}
_NAMES = ir.Global, ir.FreeVar, ir.Var
_INDEX = llvm.IntType(64)
_END = 2**63 - 1  # of a part that ends with its array
_NOTHING = llvm.FunctionType(llvm.VoidType(), [])
_ITER, _STOP, _STEP, _COUNT = range(4)  # of an iterator over a range, as numba keeps it


class LowerKernel(Lower):
    """The body of one function; see this module."""

    def _find_singly_assigned_variable(self) -> None:
        """Find the variables that are assigned once, and used in that block alone after it."""
        times: dict[str, int] = {}
        elsewhere: set[str] = set()
        for block in self.blocks.values():
            here: set[str] = set()
            for inst in block.body:
                if isinstance(inst, ir.Assign):
                    elsewhere.update(n for n in _names_in(inst.value) if n not in here)
                    name = inst.target.name
                    times[name] = times.get(name, 0) + 1
                    here.add(name)
                else:
                    elsewhere.update(v.name for v in inst.list_vars() if v.name not in here)
        self._singly_assigned_vars = {
            name for name, count in times.items() if count == 1 and name not in elsewhere
        }
        self._blk_local_varmap: dict[str, Any] = {}
        self._dispatchers: dict[str, Any] = {}  # by variable: written only where one is a value

    def lower_block(self, block: Any) -> None:
        try:
            for inst in block.body:
                self.loc = inst.loc
                self.lower_inst(inst)
        except Exception:
            error = partial(errors.LoweringError, loc=self.loc)
            context: Any = errors
            with context.new_error_context('lowering at {loc}', loc=self.loc, errcls_=error):
                raise

    def storevar(self, value: Any, name: str, argidx: Any = None) -> None:
        if name in self._singly_assigned_vars:
            self._blk_local_varmap[name] = value
        else:
            self.builder.store(value, self.getvar(name))

    def loadvar(self, name: str) -> Any:
        if name in self._blk_local_varmap:
            return self._blk_local_varmap[name]
        if name in self._dispatchers:
            return self.lower_assign(self.typeof(name), self._dispatchers[name])
        return self.builder.load(self.getvar(name))

    def alloca(self, name: str, type: Any) -> Any:
        return cgutils.alloca_once(self.builder, self.context.get_value_type(type), name=name)

    def lower_call(self, resty: Any, expr: Any) -> Any:
        called, signature = self.typeof(expr.func.name), self.fndesc.calltypes[expr]
        if expr.target is not None or not isinstance(called, types.Dispatcher | types.Function):
            return super().lower_call(resty, expr)
        if isinstance(signature.return_type, types.Phantom):
            return self.context.get_dummy_value()
        given = self.fold_call_args(called, signature, expr.args, expr.vararg, expr.kws)
        result = self._call(called, signature, given)
        if result is None:
            result = self.context.get_dummy_value()
        return self.context.cast(self.builder, result, signature.return_type, resty)

    @property
    def _disable_sroa_like_opt(self) -> bool:
        return False

    def _call(self, called: Any, signature: Any, given: Any) -> Any:
        key = getattr(called, 'typing_key', None)
        if key in OF_NUMBERS and is_of_numbers(signature):
            if key is int:
                kinds = signature.args[0], signature.return_type
                return self.context.cast(self.builder, given[0], *kinds)
            return do_minmax(self.context, self.builder, signature.args, given, OF_NUMBERS[key])
        if key is slice and signature.return_type == types.slice2_type and len(given) == 2:
            return self._slice(signature, given)
        if key is range and signature.return_type == types.range_state64_type:
            return self._range(given)
        implementation = self.context.get_function(called, signature)
        return implementation(self.builder, given, self.loc)

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

    def _slice(self, signature: Any, given: Any) -> Any:
        """Give begin, end and step of a part; what is not said is as numba has it."""
        default = llvm.Constant(_INDEX, 0), llvm.Constant(_INDEX, _END)
        begin, end = (
            instead if kind == types.none else value
            for kind, value, instead in zip(signature.args, given, default, strict=True)
        )
        return self._struct(types.slice2_type, [begin, end, llvm.Constant(_INDEX, 1)])

    def _struct(self, kind: Any, members: Any) -> Any:
        whole = self.context.get_constant_undef(kind)
        for i, member in enumerate(members):
            whole = self.builder.insert_value(whole, member, i)
        return whole

    def _range(self, given: Any) -> Any:
        """Give start, stop and step."""
        start, stop = ([llvm.Constant(_INDEX, 0), *given] if len(given) == 1 else given)[:2]
        step = given[2] if len(given) == 3 else llvm.Constant(_INDEX, 1)
        return self._struct(types.range_state64_type, [start, stop, step])

    def _counts_by_one(self, var: Any) -> bool:
        """Tell whether a range is known to have no other step."""
        try:
            return len(self.func_ir.get_definition(var).args) < 3
        except (KeyError, AttributeError):  # not defined once, or handed on
            return False

    def _begin_range(self, state: Any, *, by_one: bool) -> Any:
        """Give what counts a range down: how often to go on, and the number that is next."""
        builder = self.builder
        start, stop, step = (builder.extract_value(state, i) for i in range(3))
        left = builder.sub(stop, start)
        if not by_one:
            left = self._steps_in(left, step)
        place, count = (cgutils.alloca_once(builder, _INDEX) for _ in range(2))
        builder.store(start, place)
        builder.store(left, count)
        return self._struct(types.range_iter64_type, [place, stop, step, count])

    def _steps_in(self, width: Any, step: Any) -> Any:
        """Give how many steps a range takes, in the words by which LLVM finds four in 4 s by s."""
        builder, zero = self.builder, llvm.Constant(_INDEX, 0)
        with builder.if_then(builder.icmp_unsigned('==', step, zero), likely=False):
            # no kernel steps by nothing: Python would raise an error
            builder.call(builder.module.declare_intrinsic('llvm.trap', fnty=_NOTHING), [])
            builder.unreachable()
        is_wide = builder.icmp_signed('>', width, zero)
        rest = builder.srem(width, step)
        rest = builder.select(is_wide, rest, builder.neg(rest))
        more = builder.zext(builder.icmp_signed('>', rest, zero), _INDEX)
        count = builder.add(builder.sdiv(width, step), more)
        is_away = builder.xor(is_wide, builder.icmp_signed('>', step, zero))
        return builder.select(is_away, zero, count)

    def _go_on(self, iterator: Any) -> Any:
        """Give the next number of a range, and whether there is one."""
        builder: Any = self.builder
        place, step, count = (builder.extract_value(iterator, i) for i in (_ITER, _STEP, _COUNT))
        left, number = builder.load(count), builder.load(place)
        is_one = builder.icmp_signed('>', left, llvm.Constant(_INDEX, 0))
        with builder.if_then(is_one):
            builder.store(builder.sub(left, llvm.Constant(_INDEX, 1), flags=['nsw']), count)
            builder.store(builder.add(number, step), place)
        return self._struct(types.Pair(types.int64, types.boolean), [number, is_one])

    def _member(self, row: Any, count: int, place: Any) -> Any:
        """Give the member of a tuple that has a number; the last one if there is none."""
        builder = self.builder
        blocks = [builder.append_basic_block('member') for _ in range(count)]
        after = builder.append_basic_block('after')
        choice = builder.switch(place, blocks[-1])
        for number, block in enumerate(blocks[:-1]):
            choice.add_case(llvm.Constant(_INDEX, number), block)
        found = []
        for number, block in enumerate(blocks):
            builder.position_at_end(block)
            found.append(builder.extract_value(row, number))
            builder.branch(after)
        builder.position_at_end(after)
        member = builder.phi(found[0].type)
        for value, block in zip(found, blocks, strict=True):
            member.add_incoming(value, block)
        return member

    def _next_member(self, iterator: Any, kind: Any) -> Any:
        """Give the next member of a tuple, and whether there is one."""
        builder, count = self.builder, kind.container.count
        place, row = (builder.extract_value(iterator, i) for i in range(2))
        number = builder.load(place)
        is_one = builder.icmp_signed('<', number, llvm.Constant(_INDEX, count))
        member = self._member(row, count, number)
        builder.store(builder.add(number, llvm.Constant(_INDEX, 1)), place)
        return self._struct(types.Pair(kind.container.dtype, types.boolean), [member, is_one])

    def lower_expr(self, resty: Any, expr: Any) -> Any:
        if expr.op == 'static_getitem' and self._is_number(expr.value, expr.index_var):
            return self.lower_getitem(resty, expr, expr.value, expr.index_var, None)
        if expr.op == 'getiter' and self.typeof(expr.value.name) == types.range_state64_type:
            by_one = self._counts_by_one(expr.value)
            return self._begin_range(self.loadvar(expr.value.name), by_one=by_one)
        if expr.op == 'iternext' and self.typeof(expr.value.name) == types.range_iter64_type:
            return self._go_on(self.loadvar(expr.value.name))
        if expr.op == 'iternext' and _iterates_over_row(self.typeof(expr.value.name)):
            return self._next_member(self.loadvar(expr.value.name), self.typeof(expr.value.name))
        return super().lower_expr(resty, expr)

    def _kind_of(self, var: Any) -> Any:
        return None if var is None else self.typeof(var.name)

    def lower_getitem(self, resty: Any, expr: Any, value: Any, index: Any, signature: Any) -> Any:
        kind, of = self.typeof(value.name), self._kind_of(index)
        checks = self.context.enable_boundscheck
        if isinstance(of, types.Integer) and _is_row(kind) and not checks:
            place = self.context.cast(self.builder, self.loadvar(index.name), of, types.intp)
            member = self._member(self.loadvar(value.name), kind.count, place)
            return self.context.cast(self.builder, member, kind.dtype, resty)
        if of == types.slice2_type and numba_calls.is_plain(kind) and numba_calls.is_plain(resty):
            bounds = self.loadvar(index.name)
            begin, end = (self.builder.extract_value(bounds, i) for i in range(2))
            return numba_calls.part(self.builder, self.loadvar(value.name), begin, end)
        if not self._is_number(value, index):
            return super().lower_getitem(resty, expr, value, index, signature)
        pointer = self._pointer(value, index, kind)
        item = arrayobj.load_item(self.context, self.builder, kind, pointer)
        return self.context.cast(self.builder, item, kind.dtype, resty)

    def lower_inst(self, inst: Any) -> Any:
        if isinstance(inst, ir.Assign):
            name = inst.target.name
            kind = self.typeof(name)
            if isinstance(kind, types.Dispatcher) and isinstance(inst.value, _NAMES):
                self._dispatchers[name] = inst
                return None
            return self.storevar(self.lower_assign(kind, inst), name)
        if isinstance(inst, ir.Del):
            return None
        if isinstance(inst, ir.StaticSetItem) and self._is_number(inst.target, inst.index_var):
            return self.lower_setitem(inst.target, inst.index_var, inst.value, None)
        if isinstance(inst, ir.SetItem):
            signature = self.fndesc.calltypes[inst]
            return self.lower_setitem(inst.target, inst.index, inst.value, signature)
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


def _is_row(kind: Any) -> bool:
    """Whether something is a tuple of members of one type."""
    return isinstance(kind, types.UniTuple | types.NamedUniTuple) and kind.count > 0


def _iterates_over_row(kind: Any) -> bool:
    return isinstance(kind, types.UniTupleIter) and kind.container.count > 0


def is_of_numbers(signature: Any) -> bool:
    """Whether a call is one that `numba_typing.Typing` has typed: others have taken a tuple."""
    return signature.pysig is None and all(isinstance(a, types.Number) for a in signature.args)


def _names_in(value: Any) -> list[str]:
    """Name the variables of what is assigned."""
    if isinstance(value, ir.Var):
        return [value.name]
    return [one.name for one in value.list_vars()] if isinstance(value, ir.Inst) else []
