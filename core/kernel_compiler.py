"""Numba's compiler for kernels: the passes that they need, and what calls mean found once."""

from __future__ import annotations

import operator
from collections.abc import Callable
from copy import copy
from functools import cache
from types import BuiltinFunctionType, FunctionType
from typing import Any

from numba.core import ir, typed_passes, untyped_passes
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.datamodel import register_default
from numba.core.datamodel.models import OpaqueModel
from numba.core.ir_utils import build_definitions
from numba.core.lowering import Lower
from numba.core.rewrites import rewrite_registry
from numba.core.ssa import reconstruct_ssa
from numba.core.transforms import canonicalize_cfg
from numba.core.types.abstract import Number
from numba.core.types.functions import Function
from numba.core.types.misc import unliteral
from numba.core.types.scalars import Boolean
from numba.core.typing.context import Context


class _Remembering(Function):
    """A function of Numba's that remembers what its calls mean.

    A kernel has ``a + b`` a dozen times, each is asked for thrice, and each time Numba tries
    the rules of arrays, text, lists, dates and sets, one by one.
    """

    _found: dict[Any, Any]
    _impl_keys: dict[Any, Any]

    def get_call_type(self, context: Any, args: Any, kws: Any) -> Any:
        """The signature for arguments of these types."""
        if kws:
            return super().get_call_type(context, args, kws)
        args = tuple(args)
        if args not in self._found:
            plain = tuple(unliteral(kind) for kind in args)
            if plain != args and self._takes_for_alike(plain):
                self.get_call_type(context, plain, kws)
                self._found[args] = self._found[plain]
            else:
                signature = super().get_call_type(context, args, kws)
                self._found[args] = signature, self.get_impl_key(signature)
        signature, implementation = self._found[args]
        # Others may have been here, with implementations that suit their own options.
        self._impl_keys[signature.args] = implementation
        return signature

    def _takes_for_alike(self, kinds: tuple[Any, ...]) -> bool:
        """Whether constant numbers of ``kinds`` mean no more than others."""
        return (
            self.typing_key not in (pow, operator.pow, operator.ipow)
            and all(isinstance(kind, Number | Boolean) for kind in kinds)
            and not any(rule.prefer_literal for rule in self.templates)
        )


def _remembering(function: Any) -> Any:
    own = copy(function)
    own.__class__, own._found = _Remembering, {}
    return own


register_default(_Remembering)(OpaqueModel)  # in memory as any function: nothing


class _Typing(Context):
    """Numba's typing context, with functions that remember."""

    _remembering: dict[Any, Any]
    _attributes_found: dict[Any, Any]

    def resolve_value_type(self, val: Any) -> Any:
        """The type of a constant."""
        if not isinstance(val, BuiltinFunctionType | FunctionType | type):
            return super().resolve_value_type(val)
        kind = self._remembering.get(val)
        if kind is None:
            kind = super().resolve_value_type(val)
            if type(kind) is Function:
                kind = _remembering(kind)
            self._remembering[val] = kind
        return kind

    def resolve_getattr(self, typ: Any, attr: str) -> Any:
        """The type of the attribute; None without it."""
        found = self._attributes_found.get((typ, attr))
        if found is None:
            found = super().resolve_getattr(typ, attr)
            if found is not None:
                self._attributes_found[typ, attr] = found
        return found


@cache
def typing_of_kernels(context: Any, counted: bool) -> Any:
    """A typing context that knows all that ``context`` does, also what it learns later.

    ``counted``: for kernels whose arrays are counted, which need other implementations.
    """
    own = copy(context)
    own.__class__ = _Typing
    own._remembering, own._attributes_found = {}, {}
    return own


def _one_way_back(state: Any) -> None:
    """Loops as Numba's ``IRProcessing`` makes them."""
    state.func_ir.blocks = canonicalize_cfg(state.func_ir.blocks)
    state.func_ir.generator_info = None


def _rewrites(state: Any) -> None:
    """``GenericRewrites`` without lifetimes."""
    blocks = state.func_ir.blocks
    for kind in rewrite_registry.rewrites["before-inference"]:
        rewrite = kind(state)
        waiting = list(blocks.items())
        while waiting:
            key, block = waiting.pop()
            if rewrite.match(state.func_ir, block, state.typemap, state.calltypes):
                blocks[key] = rewrite.apply()
                waiting.append((key, blocks[key]))


def _single_assignments(state: Any) -> None:
    """``ReconstructSSA`` without lifetimes."""
    state.func_ir = reconstruct_ssa(state.func_ir)
    state.func_ir._definitions = build_definitions(state.func_ir.blocks)


def _no_phis(state: Any) -> None:
    """``PreLowerStripPhis`` without lifetimes."""
    state.func_ir = typed_passes.PreLowerStripPhis()._strip_phi_nodes(state.func_ir)
    state.func_ir._definitions = build_definitions(state.func_ir.blocks)


class _Lower(Lower):
    """Numba's way from its own code to LLVM's, without what serves reference counts."""

    def lower_inst(self, inst: Any) -> None:
        """One statement."""
        if isinstance(inst, ir.Assign):
            name = inst.target.name
            self.storevar(self.lower_assign(self.typeof(name), inst), name)
        else:
            super().lower_inst(inst)

    def storevar(self, value: Any, name: str, argidx: int | None = None) -> None:
        """Keep a variable; what it was is nobody's."""
        if name in self._singly_assigned_vars:
            self._blk_local_varmap[name] = value
        else:
            self._alloca_var(name, self.typeof(name))
            self.builder.store(value, self.getvar(name))


class _Lowering(typed_passes.BaseNativeLowering):
    """To LLVM code."""

    @property
    def lowering_class(self) -> type[Lower]:
        """What does it."""
        return _Lower


#: A kernel has no closures, ``with``, literal loops, array expressions and prange, and without
#: counts nobody asks how long a variable lives.
_STEPS: tuple[Callable[[Any], Any], ...] = (
    untyped_passes.TranslateByteCode().run_pass,
    untyped_passes.FixupArgs().run_pass,
    _one_way_back,
    _rewrites,
    _single_assignments,
    typed_passes.NopythonTypeInference().run_pass,
    _no_phis,
    _Lowering().run_pass,
    typed_passes.NoPythonBackend().run_pass,
)


class _Steps:
    """Numba's passes without the clocks, events and checks around each."""

    pipeline_name = "kernel"
    exec_times = ()

    def run(self, state: Any) -> None:
        """Compile."""
        for step in _STEPS:
            step(state)


class KernelCompiler(CompilerBase):
    """Numba's compiler with the passes that a kernel needs; all where it makes arrays."""

    def __init__(self, typing: Any, *others: Any) -> None:
        super().__init__(typing, *others)
        self.state.targetctx.typing_context = typing  # a copy's, made for this function

    def define_pipelines(self) -> list[Any]:
        """One list of passes."""
        if self.state.flags.nrt:
            return [DefaultPassBuilder.define_nopython_pipeline(self.state)]
        return [_Steps()]
