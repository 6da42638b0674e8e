"""Runs the tests of this folder inside Blender, one process for each file.

``bpy`` cannot be unloaded, has crashed or hung at exit in some versions, and holds one scene
for the whole process. So pytest starts itself again for each file of this folder, with
``PHOTON_MAP_IN_BLENDER`` set and a time limit, and reports what came out test by test. Set
that variable yourself to debug in one process:

    PHOTON_MAP_IN_BLENDER=1 pytest tests/blender/test_export_mesh.py -k mirrored

In Blender's process the fixture ``bpy`` gives the module with an empty scene and the add-on
registered from this checkout.
"""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from tests.blender.fake_core import FakeCore
from tests.blender.support import ROOT, add_camera

FLAG = "PHOTON_MAP_IN_BLENDER"
IN_BLENDER = FLAG in os.environ
TIMEOUT = 500.0
EXIT_STATUS = pytest.StashKey[int]()
OUTCOMES = pytest.StashKey[dict[Path, dict[str, tuple[str, str]]]]()


def load_package() -> ModuleType:
    """The checkout as package ``photon_map``, whatever its folder is called."""
    if "photon_map" not in sys.modules:
        spec = importlib.util.spec_from_file_location(
            "photon_map", ROOT / "__init__.py", submodule_search_locations=[str(ROOT)]
        )
        assert spec is not None and spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        sys.modules["photon_map"] = module
        spec.loader.exec_module(module)
    return sys.modules["photon_map"]


@pytest.fixture
def bpy() -> Iterator[Any]:
    """Blender with an empty scene and the add-on, None outside Blender's process."""
    if not IN_BLENDER:
        yield None
        return
    import bpy

    package = load_package()
    from photon_map.addon import is_registered

    if not is_registered():
        package.register()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.render.engine = "PHOTONMAP"
    yield bpy


@pytest.fixture
def core(bpy: Any, monkeypatch: pytest.MonkeyPatch) -> Any:
    """A fake core in place of the real one, and a scene of 40 x 30 pixels and 4 passes."""
    if bpy is None:
        return None
    import photon_map.core

    fake = FakeCore()
    # Into the dictionary: looking at the real one first would import Numba.
    monkeypatch.setitem(vars(photon_map.core), "render", fake.render)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 40, 30
    scene.render.resolution_percentage = 100
    scene.photon_map.passes = 4
    add_camera(bpy)
    return fake


@pytest.hookimpl(tryfirst=True)
def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> bool | None:
    """Outside Blender: take the outcome from the process that runs this file's tests."""
    if IN_BLENDER:
        return None
    session = pyfuncitem.session
    outcomes = session.config.stash.setdefault(OUTCOMES, {})
    path = pyfuncitem.path
    if path not in outcomes:
        outcomes[path] = run_file(path, [item for item in session.items if item.path == path])
    outcome, text = outcomes[path].get(
        pyfuncitem.name, ("failed", outcomes[path].get("", ("", ""))[1])
    )
    if outcome == "skipped":
        pytest.skip(text)
    if outcome == "failed":
        pytest.fail(text, pytrace=False)
    return True


def run_file(path: Path, items: list[pytest.Item]) -> dict[str, tuple[str, str]]:
    """Outcome and text of each test by name; that of the process by the name ""."""
    names = [f"{path}::{item.nodeid.split('::', 1)[1]}" for item in items]
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "report.xml"
        environment = {**os.environ, FLAG: "1", "BLENDER_USER_RESOURCES": folder}
        command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"]
        command += [f"--rootdir={ROOT}", f"--junitxml={report}", *names]
        try:
            process = subprocess.run(
                command, cwd=ROOT, env=environment, timeout=TIMEOUT,
                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace",
            )  # fmt: skip
            output = f"Blender's process ended with {process.returncode}\n{process.stdout}"
        except subprocess.TimeoutExpired as expired:
            shown = (expired.stdout or b"").decode(errors="replace")
            output = f"Blender's process did not end in {TIMEOUT:.0f} s\n{shown}"
        outcomes = {"": ("failed", output[-6000:])}
        if report.is_file():
            for case in ElementTree.parse(report).iter("testcase"):
                outcomes[case.get("name", "")] = _outcome(case)
    return outcomes


def _outcome(case: ElementTree.Element) -> tuple[str, str]:
    for child in case:
        if child.tag in ("failure", "error"):
            printed = "".join(case.findtext(tag) or "" for tag in ("system-out", "system-err"))
            return "failed", f"{child.text}\n{printed[-4000:]}"
        if child.tag == "skipped":
            return "skipped", child.get("message", "")
    return "passed", ""


def pytest_sessionfinish(session: pytest.Session, exitstatus: int) -> None:
    session.config.stash[EXIT_STATUS] = int(exitstatus)


@pytest.hookimpl(trylast=True)
def pytest_unconfigure(config: pytest.Config) -> None:
    """Leave Blender's process at once: bpy 4.2 and 4.5 crash or hang when they tidy up."""
    if IN_BLENDER:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(config.stash.get(EXIT_STATUS, 1))
