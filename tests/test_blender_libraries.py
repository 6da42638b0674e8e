from __future__ import annotations

import sys

import pytest

from photon_map import blender_libraries
from photon_map.blender_libraries import BlenderMissingError, import_blender, missing_packages


def test_the_package_of_a_library_is_named(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(blender_libraries, "find_spec", lambda name: None)
    reason = "libxkbcommon.so.0: cannot open shared object file: No such file or directory"

    def fail(name: str) -> None:
        raise ImportError(reason)

    monkeypatch.setattr(blender_libraries.importlib, "import_module", fail)
    with pytest.raises(BlenderMissingError, match="apt-get install libxkbcommon0"):
        import_blender()
    assert missing_packages(reason) == ["libxkbcommon0"]
    assert missing_packages("libunknown.so.3: cannot open shared object file") == []


def test_without_bpy_it_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.setitem(sys.modules, "bpy", None)
    monkeypatch.setattr(blender_libraries, "find_spec", lambda name: None)
    with pytest.raises(BlenderMissingError, match=r"pip install 'photon-map\[blender\]'"):
        import_blender()
    assert blender_libraries.main() == 1
    assert capsys.readouterr().out == ""
