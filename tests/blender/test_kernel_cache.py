"""Compiled kernels lie in the extension's own folder, which Blender removes with it."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest


@pytest.fixture
def variable(bpy: Any, monkeypatch: pytest.MonkeyPatch) -> str:
    """The name of the variable, which is not set; the test may set it."""
    if bpy is None:
        return ""
    from photon_map.addon.kernel_cache import VARIABLE

    monkeypatch.setenv(VARIABLE, "restored after the test")
    monkeypatch.delenv(VARIABLE)
    return str(VARIABLE)


def test_an_extension_compiles_into_its_user_folder(bpy: Any, variable: str) -> None:
    from photon_map.addon.kernel_cache import use_extension_folder

    use_extension_folder("bl_ext.user_default.photon_map")
    folder = Path(os.environ[variable])
    assert folder.is_dir()
    assert folder.parts[-4:] == (".user", "user_default", "photon_map", "kernels")
    from photon_map.core.jit import cache_root

    assert cache_root() == folder


def test_a_chosen_folder_wins(bpy: Any, variable: str) -> None:
    from photon_map.addon.kernel_cache import use_extension_folder

    os.environ[variable] = "chosen"
    use_extension_folder("bl_ext.user_default.photon_map")
    assert os.environ[variable] == "chosen"


def test_a_package_keeps_the_users_cache(bpy: Any, variable: str) -> None:
    from photon_map.addon.kernel_cache import use_extension_folder

    use_extension_folder()
    assert variable not in os.environ
