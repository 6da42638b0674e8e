"""Compiles kernels in a third of the time that Numba takes, to the same machine code.

Numba makes of every function a library of its own: optimised, wrapped for Python and for C,
made into machine code and written to the cache, although most of ours are only called by
other kernels, which take them in as LLVM code and optimise them again. Here a function that
a kernel calls stays LLVM code, and one that Python calls takes in all that it needs, each
once, and is optimised, made into machine code and written to the cache alone.

Uses Numba's inner classes; its version is pinned. What holds outwards: any Numba function
may call a kernel, and a kernel any Numba function; who listens to Numba's events hears of
each function that is compiled.
"""

from __future__ import annotations

import threading
from concurrent.futures import CancelledError
from contextvars import ContextVar
from typing import Any

from llvmlite.binding import Linkage
from numba.core import typed_passes, untyped_passes
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder, Flags, compile_extra
from numba.core.compiler_lock import global_compiler_lock
from numba.core.compiler_machinery import PassManager
from numba.core.dispatcher import OmittedArg
from numba.core.event import trigger_event
from numba.core.registry import CPUDispatcher
from numba.core.sigutils import normalize_signature
from numba.core.types.misc import Omitted, unliteral
from numba.core.types.scalars import Integer

_INT64 = Integer("int64")

#: Set when the render that a thread works for has been cancelled.
_STOP: ContextVar[threading.Event | None] = ContextVar("stop", default=None)


def obey(stop: threading.Event) -> None:
    """Have this thread load and compile no more kernels once ``stop`` is set.

    Calls that would have to then raise ``CancelledError``.
    """
    _STOP.set(stop)


def _check_wanted() -> None:
    stop = _STOP.get()
    if stop is not None and stop.is_set():
        raise CancelledError


#: Passes that change nothing in a kernel: it has no closures, ``with``, literal loops,
#: array expressions or prange.
_NEEDLESS = {
    untyped_passes.WithLifting,
    untyped_passes.RewriteSemanticConstants,
    untyped_passes.DeadBranchPrune,
    untyped_passes.RewriteDynamicRaises,
    untyped_passes.MakeFunctionToJitFunction,
    untyped_passes.InlineInlinables,
    untyped_passes.FindLiterallyCalls,
    untyped_passes.LiteralUnroll,
    untyped_passes.LiteralPropagationSubPipelinePass,
    typed_passes.AnnotateTypes,
    typed_passes.InlineOverloads,
    typed_passes.NopythonRewrites,
    typed_passes.DumpParforDiagnostics,
}


class _Part(JITCodeLibrary):
    """A function that kernels call: LLVM code as it was lowered, without its callees."""

    _shared_module: Any

    def finalize(self) -> None:
        """Close it; no machine code is made."""
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage == Linkage.external:
                # May be defined in many modules, and dropped where nothing calls it.
                function.linkage = "linkonce_odr"
        self._finalized = True

    def add_llvm_module(self, module: Any) -> None:
        """Take in ``module`` as it is: the kernel that needs it optimises it."""
        module.data_layout = self._codegen._data_layout
        self._final_module.link_in(module)

    def _get_module_for_linking(self) -> Any:
        """With all callees, as Numba's own libraries have them."""
        self._ensure_finalized()
        if self._shared_module is None:
            self._shared_module = self._final_module.clone()
            for other in _link_needed(self, self._shared_module):
                self._shared_module.link_in(other._get_module_for_linking(), preserve=True)
        return self._shared_module


class _Whole(JITCodeLibrary):
    """A kernel that Python calls, with all that it calls."""

    def finalize(self) -> None:
        """Take in each needed part once, optimise, make machine code."""
        self._linking_libraries = _link_needed(self, self._final_module)
        for function in self._final_module.functions:
            if function.linkage == Linkage.linkonce_odr and not function.is_declaration:
                # Nobody else calls it: LLVM then drops the arguments that it does not use. A
                # table is seven words, the lights are two hundred, and each call pushed them.
                # Private, as the name of an internal one stays known to the loader, which
                # would take it for what plain Numba functions call, arguments missing.
                function.linkage = "private"
        super().finalize()


class _Uncounted(_Whole):
    """The same without reference counts: Numba's cheap first round is for pruning those."""

    def _optimize_final_module(self) -> None:
        manager, builder = self._codegen._module_pass_manager()
        manager.run(self._final_module, builder)


def _link_needed(library: Any, module: Any) -> list[Any]:
    """Link every part that ``library`` needs into ``module``; its other libraries."""
    seen: set[Any] = {library}
    others: list[Any] = []
    waiting = list(library._linking_libraries)
    while waiting:
        needed = waiting.pop()
        if needed in seen:
            continue
        seen.add(needed)
        if isinstance(needed, _Part):
            module.link_in(needed._final_module, preserve=True)
            waiting.extend(needed._linking_libraries)
        else:
            others.append(needed)
    return others


class _Passes(PassManager):
    """Numba's passes without the clocks, events and checks around each."""

    def _runPass(self, index: int, one: Any, state: Any) -> None:
        one.analysis = self._analysis
        one.run_initialization(state)
        one.run_pass(state)
        one.run_finalizer(state)


class _KernelCompiler(CompilerBase):
    """Numba's compiler with the passes that a kernel needs; all where it makes arrays."""

    def define_pipelines(self) -> list[Any]:
        """One list of passes."""
        usual = DefaultPassBuilder.define_nopython_pipeline(self.state)
        if self.state.flags.nrt:
            return [usual]
        passes = _Passes("kernel")
        passes.passes = [one for one in usual.passes if one[0] not in _NEEDLESS]
        passes.finalize()
        return [passes]


def _wide(kind: Any) -> Any:
    """The type that a callee takes ``kind`` as: constants and int32 as int64.

    One version of each function serves all its callers; LLVM knows constants by itself.
    """
    kind = unliteral(kind)
    return _INT64 if getattr(kind, "signed", False) else kind


class KernelDispatcher(CPUDispatcher):
    """A compiled function, as Numba's; ``overloads`` has the parts, for other kernels."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self._wholes: dict[tuple[Any, ...], Any] = {}

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """How another function calls this one."""
        _, kinds = self._compiler.fold_argument_types(args, kws)
        return super().get_call_template(tuple(_wide(kind) for kind in kinds), {})

    def compile(self, sig: Any) -> Any:
        """A part for these argument types; the key by which callers find it."""
        with global_compiler_lock:
            kinds = tuple(normalize_signature(sig)[0])
            if kinds not in self.overloads:
                with self._compiling_counter:
                    part = self._compiled(kinds, _Part)
                key = object()
                self.targetctx.insert_user_function(key, part.fndesc, [part.library])
                self.overloads[kinds] = part._replace(entry_point=key)
            return self.overloads[kinds].entry_point

    def _compile_for_args(self, *args: Any, **kws: Any) -> Any:
        """Called by Python with argument types that it has not been called with before."""
        assert not kws
        self._compilation_chain_init_hook()
        kinds = tuple(
            Omitted(a.value) if isinstance(a, OmittedArg) else self.typeof_pyval(a)
            for a in args
        )
        try:
            _check_wanted()
            with global_compiler_lock:
                _check_wanted()  # others may have compiled meanwhile
                if kinds not in self._wholes:
                    self._wholes[kinds] = self._loaded(kinds)
                    codes = [kind._code for kind in kinds]
                    self._insert(codes, self._wholes[kinds].entry_point, False)
                return self._wholes[kinds].entry_point
        finally:
            self._types_active_call.clear()

    def _loaded(self, kinds: tuple[Any, ...]) -> Any:
        """The whole kernel, from the cache or compiled into it."""
        whole = self._cache.load_overload(kinds, self.targetctx)
        if whole is None:
            counted = self.targetoptions.get("_nrt", True)
            with self._compiling_counter:
                whole = self._compiled(kinds, _Whole if counted else _Uncounted)
            for environment in whole._find_referenced_environments():
                whole.library.codegen.set_env(environment.env_name, environment)
            self._cache.save_overload(kinds, whole)
        return whole

    def _compiled(self, kinds: tuple[Any, ...], library_class: type[Any]) -> Any:
        flags = Flags()
        self.targetdescr.options.parse_as_flags(flags, self.targetoptions)
        flags.no_cfunc_wrapper = True
        flags.no_cpython_wrapper = flags.no_compile = library_class is _Part
        library = library_class(self.targetctx.codegen(), self.py_func.__qualname__)
        library.enable_object_caching()
        details = {"dispatcher": self, "args": kinds, "return_type": None}
        with trigger_event("numba:compile", data=details):
            return compile_extra(
                self.typingctx,
                self.targetctx,
                self.py_func,
                args=kinds,
                return_type=None,
                flags=flags,
                locals={},
                library=library,
                pipeline_class=_KernelCompiler,
            )
