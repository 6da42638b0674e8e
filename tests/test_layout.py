"""The coupling rules of CONTRIBUTING.md: each on the real tree, and shown able to fail."""

from __future__ import annotations

import ast
import subprocess
import sys
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from photon_map.core.version import VERSION
from tests import layout_rules as rules

ROOT = Path(__file__).parents[1]
CODE = ("core", "addon")
SCRIPTS = ("benchmarks", "sample_blends", "tests", "tools")
LONGEST_FILE = 350
LONGEST_FUNCTION = 80


def sources(*folders: str) -> Iterator[Path]:
    """Python files of the repo in ``folders``; "" is the root itself, without what is below.

    Presets are left out: Blender executes them, they are no modules.
    """
    for folder in folders:
        found = ROOT.glob("*.py") if folder == "" else (ROOT / folder).rglob("*.py")
        yield from sorted(path for path in found if "presets" not in path.parent.parts)


def offences(files: Iterator[Path], rule: Callable[[ast.Module, Path], list[str]]) -> list[str]:
    checked = [(path, rule(ast.parse(path.read_text("utf-8")), path)) for path in files]
    assert checked, "there is no file to check"
    return [f"{path.relative_to(ROOT)} {text}" for path, found in checked for text in found]


def depth(path: Path, folder: str) -> int:
    """How many folders ``path`` lies below ``folder``."""
    return len(path.relative_to(ROOT / folder).parts) - 1


def test_core_has_no_import_of_blender():
    assert not offences(sources("core"), lambda tree, _: rules.blender_imports(tree))
    assert rules.blender_imports(ast.parse("def f():\n    from bpy.types import Mesh"))
    assert rules.blender_imports(ast.parse("import numpy, mathutils"))


def test_core_imports_nothing_from_outside_itself():
    found = offences(
        sources("core"), lambda tree, path: rules.climbing_imports(tree, depth(path, "core"))
    )
    assert not found
    assert rules.climbing_imports(ast.parse("from ...addon import job"), 1)
    assert not rules.climbing_imports(ast.parse("from ..settings import Settings"), 1)


def test_a_final_renders_export_asks_for_no_originals():
    # They may be deleted meanwhile. A viewport's memory is used on Blender's thread alone.
    files = (path for path in sources("addon/export") if path.name != "memory.py")
    assert not offences(files, lambda tree, _: rules.originals_asked_for(tree))
    assert rules.originals_asked_for(ast.parse("obj.original.photon_map"))


IMPORT_ALL_OF_CORE = """
import importlib, pkgutil, sys

class Blocked:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in {blocked!r}:
            raise ImportError(name + " is blocked here")

sys.meta_path.insert(0, Blocked())
core = importlib.import_module("photon_map.core")
names = [m.name for m in pkgutil.walk_packages(core.__path__, "photon_map.core.")]
for name in names:
    importlib.import_module(name)
assert not [name for name in sys.modules if name.startswith("photon_map.addon")]
{more}
print(len(names))
"""


def run_python(code: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", code]
    return subprocess.run(command, capture_output=True, text=True, timeout=300, cwd=ROOT.parent)


def test_every_core_module_can_be_imported_without_blender():
    code = IMPORT_ALL_OF_CORE.format(blocked=sorted(rules.BLENDER_MODULES), more="")
    done = run_python(code)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) >= 15
    broken = IMPORT_ALL_OF_CORE.format(
        blocked=sorted(rules.BLENDER_MODULES), more="importlib.import_module('bpy')"
    )
    assert "bpy is blocked here" in run_python(broken).stderr


def test_only_relative_imports_inside_the_package():
    assert not offences(sources("", *CODE), lambda tree, _: rules.absolute_own_imports(tree))
    assert rules.absolute_own_imports(ast.parse("from photon_map.core import Scene"))
    assert rules.absolute_own_imports(ast.parse("import core.scene"))
    assert not rules.absolute_own_imports(ast.parse("from ..core import Scene"))


def test_addon_takes_only_the_cores_public_face():
    found = offences(
        sources("addon"), lambda tree, path: rules.addon_offences(tree, depth(path, "addon"))
    )
    assert not found
    assert rules.addon_offences(ast.parse("import numba"), 0)
    assert rules.addon_offences(ast.parse("from ...core.photons.emit import emit"), 1)
    assert rules.addon_offences(ast.parse("from ..cli import app"), 0)
    assert not rules.addon_offences(ast.parse("from ...core.scene.tables import LIGHT"), 1)
    assert not rules.addon_offences(ast.parse("from ..core import render"), 0)


IMPORT_ALL_OF_ADDON = """
import bpy, importlib, pkgutil, sys
addon = importlib.import_module("photon_map.addon")
names = [m.name for m in pkgutil.walk_packages(addon.__path__, "photon_map.addon.")]
for name in names:
    importlib.import_module(name)
print(len(names), *(name for name in {heavy!r} if name in sys.modules))
sys.stdout.flush()
"""


@pytest.mark.blender
def test_importing_the_addon_loads_no_transport_library():
    """Blender imports every enabled add-on at its start: that must stay cheap."""
    done = run_python(IMPORT_ALL_OF_ADDON.format(heavy=sorted(rules.TRANSPORT_LIBRARIES)))
    assert done.returncode == 0, done.stderr
    count, *loaded = done.stdout.split()
    assert int(count) >= 10
    assert loaded == []


def test_core_knows_no_pass_names_of_blender():
    tree = ast.parse((ROOT / "addon/passes.py").read_text("utf-8"))
    rows = [
        [ast.literal_eval(argument) for argument in node.args]
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and ast.unparse(node.func) == "RenderPass"
    ]
    names = {name for row in rows for name in row[1:3]}
    assert {"Combined", "DiffDir"} <= names
    assert not offences(sources("core"), lambda tree, _: rules.strings(tree, names))
    assert rules.strings(ast.parse("x = {'DiffDir': 3}"), names)


def test_reference_is_for_tests_and_benchmarks_only():
    files = (path for path in sources("", *CODE) if "reference" not in path.parts)
    assert not offences(files, lambda tree, _: rules.reference_imports(tree))
    assert rules.reference_imports(ast.parse("from .reference import path_tracer"))
    assert rules.reference_imports(ast.parse("from . import reference"))


def test_kernels_know_no_names_of_models_and_lights_outside_dispatch():
    files = (
        path
        for path in sources("core")
        if path.name not in ("dispatch.py", "lobe.py") and "reference" not in path.parts
    )
    assert not offences(files, lambda tree, _: rules.kernels_with_names(tree))
    bad = "from ..scene.tables import Model\n@kernel\ndef f(x): return x"
    assert rules.kernels_with_names(ast.parse(bad))


def test_core_has_no_module_level_mutable_state():
    assert not offences(sources("core"), lambda tree, _: rules.mutable_state(tree))


@pytest.mark.parametrize(
    "bad",
    [
        "cache = {}",
        "cache: dict[str, int] = dict()",
        "buffer = np.zeros(3)",
        "TABLE = {}\ndef f(): TABLE['x'] = 1",
        "TABLE = []\ndef f(): TABLE.append(1)",
        "COUNT = 0\ndef f():\n    global COUNT\n    COUNT = 1",
        "from .x import TABLE\ndef f(): TABLE.clear()",
        "TABLE = np.ones(2)\ndef f(): TABLE[0] += 1",
    ],
)
def test_mutable_state_is_seen(bad: str):
    assert rules.mutable_state(ast.parse(bad))


def test_constants_are_no_mutable_state():
    good = "_RANGES: dict = {'a': 1}\nnames = ('a',)\ndef f():\n    x = []\n    x.append(1)"
    assert not rules.mutable_state(ast.parse(good))


def test_the_root_imports_nothing_at_module_level():
    files = iter([ROOT / "__init__.py"])
    assert not offences(files, lambda tree, _: rules.top_level_imports(tree))
    assert rules.top_level_imports(ast.parse("if True:\n    from . import core"))
    assert not rules.top_level_imports(ast.parse("def register():\n    from . import addon"))


def test_files_and_functions_stay_short():
    counts = {
        path: path.read_text("utf-8").count("\n") for path in sources("", *CODE, *SCRIPTS)
    }
    assert not {str(p.relative_to(ROOT)): n for p, n in counts.items() if n > LONGEST_FILE}
    assert not offences(
        sources("", *CODE), lambda tree, _: rules.long_functions(tree, LONGEST_FUNCTION)
    )
    assert rules.long_functions(ast.parse("def f():\n" + "    x = 1\n" * 80), LONGEST_FUNCTION)


def test_nothing_ties_the_repo_to_one_machine():
    own = (Path(__file__), Path(rules.__file__))
    texts = [*sources("", *CODE, *SCRIPTS), ROOT / "Makefile", ROOT / ".ci/run"]
    texts += [*ROOT.glob("*.toml"), *ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]
    found = {
        str(path.relative_to(ROOT)): traces
        for path in texts
        if path not in own and (traces := rules.machine_traces(path.read_text("utf-8")))
    }
    assert not found


@pytest.mark.parametrize(
    "bad", ["open('/home/me/x')", "see https://example.org", "pip --index-url x", r"C:\\Users"]
)
def test_traces_of_a_machine_are_seen(bad: str):
    assert rules.machine_traces(bad)


def test_pyproject_names_every_package_and_no_other():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    listed = project["tool"]["setuptools"]["packages"]
    found = ["photon_map"] + [
        ".".join(("photon_map", *path.parent.relative_to(ROOT).parts))
        for path in sources(*CODE)
        if path.name == "__init__.py"
    ]
    assert listed == sorted(found)
    folders = {path.parent for path in sources(*CODE)}
    assert not [folder for folder in folders if not (folder / "__init__.py").exists()]


def test_the_extension_and_the_package_have_one_version():
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text())
    assert manifest["version"] == VERSION
