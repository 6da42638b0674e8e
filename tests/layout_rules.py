"""Checks of the coupling rules on source text; each gives the offences it finds, as words.

They work on one parsed file at a time, so that ``test_layout.py`` can show each of them a
bad file as well as the real ones.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator

BLENDER_MODULES = {
    "bpy",
    "blf",
    "bmesh",
    "bpy_extras",
    "gpu",
    "gpu_extras",
    "mathutils",
    "bl_ui",
    "aud",
    "freestyle",
}
OWN_TOP_LEVEL = {"photon_map", "core", "addon", "bl_ext"}
TRANSPORT_LIBRARIES = {"numba", "llvmlite", "scipy", "embreex"}
#: Parts of the core that the add-on may name: the public face and the tables it fills.
ADDON_MAY_IMPORT = re.compile(
    r"core(\.(scene(\.\w+)?|settings|version|report|file_replace))?(:\w+)?"
)
MUTATORS = {
    "add", "append", "clear", "discard", "extend", "fill", "insert", "pop", "popitem", "put",
    "remove", "reverse", "setdefault", "sort", "update",
}  # fmt: skip
MUTABLE_CALLS = {
    "arange", "array", "bytearray", "Counter", "defaultdict", "deque", "dict", "empty", "full",
    "list", "ones", "set", "zeros",
}  # fmt: skip
MUTABLE_NODES = (ast.List, ast.Dict, ast.Set, ast.ListComp, ast.DictComp, ast.SetComp)


def imports(tree: ast.AST) -> Iterator[tuple[ast.stmt, str, int]]:
    """Every import: its node, ``module`` or ``module:name``, and its leading dots."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield node, alias.name, 0
        elif isinstance(node, ast.ImportFrom):
            for alias in node.names:
                yield node, f"{node.module or ''}:{alias.name}", node.level


def blender_imports(tree: ast.AST) -> list[str]:
    """Imports of Blender's modules."""
    return [
        f"line {node.lineno}: imports {name}"
        for node, name, level in imports(tree)
        if level == 0 and re.split(r"[.:]", name)[0] in BLENDER_MODULES
    ]


def climbing_imports(tree: ast.AST, depth: int) -> list[str]:
    """Relative imports that leave a package in which this file lies ``depth`` folders deep."""
    return [
        f"line {node.lineno}: imports {'.' * level}{name} from outside"
        for node, name, level in imports(tree)
        if level > depth + 1
    ]


def absolute_own_imports(tree: ast.AST) -> list[str]:
    """Imports of the package by its name; only relative ones hold under ``bl_ext`` too."""
    return [
        f"line {node.lineno}: imports {name} by name"
        for node, name, level in imports(tree)
        if level == 0 and re.split(r"[.:]", name)[0] in OWN_TOP_LEVEL
    ]


def reference_imports(tree: ast.AST) -> list[str]:
    """Imports of ``core/reference``, which no render may use."""
    return [
        f"line {node.lineno}: imports {name}"
        for node, name, _ in imports(tree)
        if "reference" in re.split(r"[.:]", name)
    ]


def originals_asked_for(tree: ast.AST) -> list[str]:
    """Where the data that an evaluated object was made from are asked for."""
    return [
        f"line {node.lineno}: .original"
        for node in ast.walk(tree)
        if isinstance(node, ast.Attribute) and node.attr == "original"
    ]


def addon_offences(tree: ast.AST, depth: int) -> list[str]:
    """Imports, in a file ``depth`` folders below ``addon/``, of the core's insides."""
    found = []
    for node, name, level in imports(tree):
        inside_root = level == depth + 2
        if level == 0 and re.split(r"[.:]", name)[0] in TRANSPORT_LIBRARIES:
            found.append(f"line {node.lineno}: imports {name}")
        elif inside_root and not name.startswith("core"):
            found.append(f"line {node.lineno}: imports {name} from the root")
        elif inside_root and not ADDON_MAY_IMPORT.fullmatch(name):
            found.append(f"line {node.lineno}: imports {name} from the core's insides")
    return found


def strings(tree: ast.AST, wanted: set[str]) -> list[str]:
    """String constants that are one of ``wanted``."""
    return [
        f"line {node.lineno}: says {node.value!r}"
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant) and node.value in wanted
    ]


def top_level_imports(tree: ast.Module) -> list[str]:
    """Imports that run when the file is imported."""
    found = []
    for statement in tree.body:
        if not isinstance(statement, (ast.FunctionDef, ast.AsyncFunctionDef)):
            nodes = (
                n for n in ast.walk(statement) if isinstance(n, (ast.Import, ast.ImportFrom))
            )
            found += [f"line {node.lineno}: import at module level" for node in nodes]
    return found


def kernels_with_names(tree: ast.Module) -> list[str]:
    """Kernels in a file that knows models or light kinds by name."""
    enums = [
        name for _, name, _ in imports(tree) if name.split(":")[-1] in ("Model", "LightKind")
    ]
    kernels = [
        node.name
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef)
        and any(ast.unparse(d).split(".")[-1] == "kernel" for d in node.decorator_list)
    ]
    return [f"kernel {kernel} beside {enum}" for kernel in kernels for enum in enums]


def mutable_state(tree: ast.Module) -> list[str]:
    """State that outlives a call: ``global``, mutable module variables, edited constants.

    A table (list, dict, array) may stand at module level under a name in capitals when
    nothing in the file edits it.
    """
    found = []
    for statement in tree.body:
        if isinstance(statement, (ast.Assign, ast.AnnAssign)) and _is_mutable(statement.value):
            targets = (
                statement.targets if isinstance(statement, ast.Assign) else [statement.target]
            )
            for name in (ast.unparse(target) for target in targets):
                if name != "__all__" and not name.strip("_").isupper():
                    found.append(f"line {statement.lineno}: {name} is mutable")
    for node in ast.walk(tree):
        if isinstance(node, ast.Global):
            found.append(f"line {node.lineno}: global {', '.join(node.names)}")
        for edited in _edited(node):
            if isinstance(edited, ast.Name) and re.fullmatch(r"_?[A-Z][A-Z0-9_]+", edited.id):
                found.append(f"line {edited.lineno}: edits {edited.id}")
    return found


def _is_mutable(value: ast.expr | None) -> bool:
    if isinstance(value, ast.Call):
        return ast.unparse(value.func).split(".")[-1] in MUTABLE_CALLS
    return isinstance(value, MUTABLE_NODES)


def _edited(node: ast.AST) -> Iterator[ast.expr]:
    """What a statement or call changes in place."""
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
        if node.func.attr in MUTATORS:
            yield node.func.value
    elif isinstance(node, (ast.Assign, ast.Delete)):
        for target in node.targets:
            if isinstance(target, (ast.Subscript, ast.Attribute)):
                yield target.value
    elif isinstance(node, ast.AugAssign):
        target = node.target
        yield target.value if isinstance(target, (ast.Subscript, ast.Attribute)) else target


def long_functions(tree: ast.AST, limit: int) -> list[str]:
    """Functions of more than ``limit`` lines."""
    return [
        f"line {node.lineno}: {node.name} has {node.end_lineno - node.lineno + 1} lines"
        for node in ast.walk(tree)
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef))
        and (node.end_lineno or 0) - node.lineno + 1 > limit
    ]


def machine_traces(text: str) -> list[str]:
    """Folders of one machine, and addresses, that would hold nowhere else."""
    patterns = (
        r"(?<![\w.~/}])/(?:home|root|work|mnt|media|Users|opt)/[\w.]+",
        r"\b[A-Z]:\\\\?\w+",
        r"\bpypi\.(?:org|python)|pythonhosted|--(?:extra-)?index-url|--find-links",
        r"\b(?:https?|ftp|ssh)://(?!doi\.org/)[^\s\"'<>)]+",
    )
    return [
        f"line {text.count(chr(10), 0, match.start()) + 1}: {match[0]}"
        for pattern in patterns
        for match in re.finditer(pattern, text)
    ]
