"""Compiles kernels in a quarter of the time that Numba takes, to the same machine code.

Numba makes of every function a library of its own: optimised, wrapped for Python and for C,
made into machine code and written to the cache, although most of ours are only called by
other kernels, which take them in as LLVM code and optimise them again. Here a function that
a kernel calls stays LLVM code, and one that Python calls takes in all that it needs, each
once, and is optimised, made into machine code and written to the cache alone. While that is
done by one thread, others lower the next kernels (``core/ahead.py`` asks for them).

Uses Numba's inner classes; its version is pinned. What holds outwards: any Numba function
may call a kernel, and a kernel any Numba function; who listens to Numba's events hears of
each function that is compiled.
"""

from __future__ import annotations

import threading
from concurrent.futures import CancelledError
from contextvars import ContextVar
from typing import Any

from numba.core.compiler import Flags, compile_extra
from numba.core.compiler_lock import global_compiler_lock
from numba.core.dispatcher import OmittedArg
from numba.core.event import trigger_event
from numba.core.registry import CPUDispatcher
from numba.core.sigutils import normalize_signature
from numba.core.types.misc import Omitted, unliteral
from numba.core.types.scalars import Integer

from .kernel_compiler import KernelCompiler, typing_of_kernels
from .kernel_library import CountedWhole, Part, Whole

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
        self._making = threading.Lock()
        self._counted = bool(self.targetoptions.get("_nrt", True))

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
                    part = self._compiled(kinds, Part)
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
            with self._making:
                if kinds not in self._wholes:
                    self._wholes[kinds] = self._whole(kinds)
                    codes = [kind._code for kind in kinds]
                    self._insert(codes, self._wholes[kinds].entry_point, False)
                return self._wholes[kinds].entry_point
        finally:
            self._types_active_call.clear()

    def _whole(self, kinds: tuple[Any, ...]) -> Any:
        """The whole kernel, from the cache or compiled into it."""
        with global_compiler_lock:
            _check_wanted()  # the render may have been cancelled meanwhile
            whole = self._cache.load_overload(kinds, self.targetctx)
            if whole is not None:
                return whole
            with self._compiling_counter:
                whole = self._compiled(kinds, CountedWhole if self._counted else Whole)
            task = None if self._counted else whole.library.task()
        if task is not None:
            task.run()  # others may compile meanwhile
        with global_compiler_lock:
            if task is not None:
                library = task.library()
                entry = self.targetctx.get_executable(library, whole.fndesc, whole.environment)
                whole = whole._replace(library=library, entry_point=entry)
            for environment in whole._find_referenced_environments():
                whole.library.codegen.set_env(environment.env_name, environment)
            self._cache.save_overload(kinds, whole)
        return whole

    def _compiled(self, kinds: tuple[Any, ...], library_class: type[Any]) -> Any:
        flags = Flags()
        self.targetdescr.options.parse_as_flags(flags, self.targetoptions)
        flags.no_cfunc_wrapper = True
        flags.no_cpython_wrapper = library_class is Part
        flags.no_compile = library_class is not CountedWhole
        library = library_class(self.targetctx.codegen(), self.py_func.__qualname__)
        library.enable_object_caching()
        details = {"dispatcher": self, "args": kinds, "return_type": None}
        with trigger_event("numba:compile", data=details):
            return compile_extra(
                typing_of_kernels(self.typingctx, self._counted),
                self.targetctx,
                self.py_func,
                args=kinds,
                return_type=None,
                flags=flags,
                locals={},
                library=library,
                pipeline_class=KernelCompiler,
            )
