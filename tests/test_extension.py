"""The manifest's wheels, and what `make extension` takes of them."""

from __future__ import annotations

import importlib.util
import sys
import tomllib
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

ROOT = Path(__file__).parents[1]
TEXT = (ROOT / "blender_manifest.toml").read_text("utf-8")
PACKAGES = {"embreex", "llvmlite", "numba", "scipy"}


@pytest.fixture(scope="module")
def extension() -> ModuleType:
    """``tools/extension.py``, which is no package."""
    spec = importlib.util.spec_from_file_location("extension", ROOT / "tools/extension.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["extension"] = module
    spec.loader.exec_module(module)
    return module


def test_every_platform_and_python_has_all_packages(extension: Any) -> None:
    targets: dict[str, set[str]] = {}
    for wheel in extension.listed_wheels(TEXT):
        targets.setdefault(wheel.target, set()).add(wheel.package)
    platforms = tomllib.loads(TEXT)["platforms"]
    wanted = {f"{p}-{python}" for p in platforms for python in ("cp311", "cp313")}
    # Debian's Blender 5.2 runs in the system's Python.
    assert set(targets) == wanted | {"linux-x64-cp314"}
    assert all(packages == PACKAGES for packages in targets.values())


def test_wheels_have_the_versions_that_the_tests_run_with(extension: Any) -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    pins = [*project["dependencies"], *project["optional-dependencies"]["dev"]]
    for wheel in extension.listed_wheels(TEXT):
        old = wheel.python == "cp311"
        fitting = [
            pin.partition(";")[0].strip()
            for pin in pins
            if pin.startswith(f"{wheel.package}==")
            and (";" not in pin or ("<" in pin.partition(";")[2]) == old)
        ]
        # llvmlite comes with numba, which wants exactly one series of it.
        assert fitting == [f"{wheel.package}=={wheel.version}"] or wheel.package == "llvmlite"


def test_an_archive_lists_only_its_own_wheels(extension: Any) -> None:
    for target in {wheel.target for wheel in extension.listed_wheels(TEXT)}:
        own = extension.narrowed(TEXT, target)
        values = tomllib.loads(own)
        assert values["platforms"] == [target.rpartition("-")[0]]
        assert {wheel.target for wheel in extension.listed_wheels(own)} == {target}
        assert {wheel.package for wheel in extension.listed_wheels(own)} == PACKAGES
        others = {**tomllib.loads(TEXT), "wheels": None, "platforms": None}
        assert {**values, "wheels": None, "platforms": None} == others
