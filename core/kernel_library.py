"""LLVM code of kernels: parts that only kernels call, and wholes that Python calls.

llvmlite lets one thread at a time into LLVM, and so it stays: past its lock Blender crashed
once while another thread linked modules. But what takes long
here, making a whole into machine code, needs no lock of Numba's, so that meanwhile other
threads lower the next kernel.
"""

from __future__ import annotations

from typing import Any

from llvmlite import binding, ir
from llvmlite.binding import Linkage
from numba.core import config
from numba.core.cgutils import normalize_ir_text
from numba.core.codegen import JITCodeLibrary

_ENVIRONMENT = "_ZN08NumbaEnv"


class Part(JITCodeLibrary):
    """A function that kernels call: LLVM code as it was lowered, without its callees."""

    _shared_module: Any

    def finalize(self) -> None:
        """Close it; no machine code is made."""
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage == Linkage.external:
                # May be defined in many modules, and dropped where nothing calls it.
                function.linkage = "linkonce_odr"
        self._finalized = True

    def add_ir_module(self, ir_module: Any) -> None:
        """Take in ``ir_module`` as it is: the kernel that needs it optimises it."""
        module = binding.parse_assembly(normalize_ir_text(str(ir_module)))
        module.data_layout = self._codegen._data_layout
        self._final_module.link_in(module)

    def _get_module_for_linking(self) -> Any:
        """With all callees, as Numba's own libraries have them."""
        self._ensure_finalized()
        if self._shared_module is None:
            self._shared_module = self._final_module.clone()
            for other in _needed(self):
                self._shared_module.link_in(_code(other), preserve=True)
        return self._shared_module


def _needed(library: Any) -> list[Any]:
    """All that ``library`` calls, each once."""
    found: dict[Any, None] = {}
    waiting = list(library._linking_libraries)
    while waiting:
        one = waiting.pop()
        if one not in found and one is not library:
            found[one] = None
            if isinstance(one, Part):
                waiting.extend(one._linking_libraries)
    return list(found)


def _code(library: Any) -> Any:
    """LLVM code of a part alone, of others with all that they call."""
    if isinstance(library, Part):
        return library._final_module
    return library._get_module_for_linking()


def _joined(libraries: list[Any]) -> Any:
    """One module of all, in their order; None of none.

    By twos: to link something LLVM looks through all that is there already.
    """
    parts: list[tuple[int, Any]] = []
    for library in libraries:
        size, module = 1, _code(library).clone()
        for function in module.functions:
            if function.linkage == Linkage.linkonce_odr and not function.is_declaration:
                function.linkage = "weak_odr"  # kept, though nothing calls it yet
        while parts and parts[-1][0] <= size:
            before, first = parts.pop()
            first.link_in(module)
            size, module = size + before, first
        parts.append((size, module))
    while len(parts) > 1:
        _, last = parts.pop()
        parts[-1][1].link_in(last)
    return parts[0][1] if parts else None


def _link_parts(library: Any) -> None:
    """Put all that ``library`` needs into its module, for itself alone."""
    module = library._final_module
    parts = _joined(_needed(library))
    library._linking_libraries = []
    if parts is not None:
        module.link_in(parts)
    for function in module.functions:
        if not function.is_declaration and function.linkage in _SHARED:
            # Nobody else calls it: LLVM then drops the arguments that it does not use. A
            # table is seven words, the lights are two hundred, and each call pushed them.
            # Private, as the name of an internal one stays known to the loader, which
            # would take it for what plain Numba functions call, arguments missing.
            function.linkage = "private"


_SHARED = Linkage.linkonce_odr, Linkage.weak_odr


class CountedWhole(JITCodeLibrary):
    """A kernel that Python calls and that makes arrays, with all that it calls."""

    def finalize(self) -> None:
        """Take in each needed part once, optimise, make machine code."""
        others = [one for one in _needed(self) if not isinstance(one, Part)]
        _link_parts(self)
        # The library that counts references tells what must be done when it is loaded.
        self._reload_init.update(*(one._reload_init for one in others))
        super().finalize()


class Whole(Part):
    """A kernel that Python calls, with all that it calls; machine code is made apart."""

    def task(self) -> Task:
        """What remains to be done for its machine code, which takes long."""
        _link_parts(self)
        return Task(self)


class Task:
    """Making machine code of a whole: ``run`` by one thread, beside all others."""

    def __init__(self, whole: Whole) -> None:
        codegen = whole._codegen
        self._name, self._codegen = whole.name, codegen
        code = whole._final_module.as_bitcode()
        # In LLVM's own context: what is freed with another one in one go of the garbage
        # collector, which has no order, may be freed after it.
        self._module = binding.parse_bitcode(code)
        options: dict[str, Any] = {"opt": config.OPT}
        codegen._customize_tm_options(options)
        target = binding.Target.from_triple(binding.get_process_triple())
        self._machine = target.create_target_machine(**options)
        tuning = binding.create_pipeline_tuning_options()
        tuning.speed_level = config.OPT
        tuning.loop_vectorization, tuning.slp_vectorization = True, False
        self._builder = binding.create_pass_builder(self._machine, tuning)
        self._passes = self._builder.getModulePassManager()

    def run(self) -> None:
        """Optimise, make machine code."""
        self._passes.run(self._module, self._builder)
        self._code: bytes = self._machine.emit_object(self._module)

    def library(self) -> Any:
        """The library of the machine code, as it will be loaded from the cache next time."""
        code = self._code
        names = self._contents()
        loaded = self._codegen.unserialize_library((self._name, "object", (code, names)))
        # What Numba reads when it writes the library to the cache.
        loaded._compiled_object, loaded._final_module = code, loaded._shared_module
        return loaded

    def _contents(self) -> bytes:
        """A module that has the names alone of what others see of the machine code.

        Numba keeps LLVM code there, for those who want to take the kernel into theirs; these
        take the part.
        """
        names = ir.Module(self._name)
        names.triple = binding.get_process_triple()
        for function in self._module.functions:
            if not function.is_declaration and function.linkage == Linkage.external:
                one = ir.Function(names, ir.FunctionType(ir.VoidType(), ()), function.name)
                ir.IRBuilder(one.append_basic_block()).ret_void()
        for variable in self._module.global_variables:
            if variable.name.startswith(_ENVIRONMENT):
                one = ir.GlobalVariable(names, ir.IntType(8).as_pointer(), variable.name)
                one.linkage = "common"
                one.initializer = ir.Constant(one.value_type, None)
        code: bytes = binding.parse_assembly(str(names)).as_bitcode()
        return code
