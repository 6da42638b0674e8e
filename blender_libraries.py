"""Brings in Blender's Python module, or says what the system lacks for it.

The ``bpy`` wheel carries Blender but not the window system's libraries, which it loads even
though it never opens a window. ``python -m photon_map.blender_libraries`` prints the missing
Debian packages, one a line, and ends with 1 when there are some or bpy cannot be imported.
"""

from __future__ import annotations

import importlib
import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

#: Debian package of each shared library that bpy 4.2 to 5.2 loads from the system.
PACKAGES = {
    "libX11.so.6": "libx11-6",
    "libXi.so.6": "libxi6",
    "libXxf86vm.so.1": "libxxf86vm1",
    "libXfixes.so.3": "libxfixes3",
    "libXrender.so.1": "libxrender1",
    "libSM.so.6": "libsm6",
    "libICE.so.6": "libice6",
    "libxkbcommon.so.0": "libxkbcommon0",
    "libGL.so.1": "libgl1",
    "libEGL.so.1": "libegl1",
    "libgomp.so.1": "libgomp1",
}


class BlenderMissingError(ImportError):
    """Blender's module cannot be imported; the message says what to install."""


def import_blender() -> None:
    """Import ``bpy``; raises ``BlenderMissingError``."""
    try:
        importlib.import_module("bpy")
    except ModuleNotFoundError as error:
        raise BlenderMissingError(
            "a .blend needs Blender's module, bpy, for Python 3.11 or 3.13: "
            f"pip install 'photon-map[blender]' ({error})"
        ) from error
    except ImportError as error:
        packages = missing_packages(str(error))
        remedy = f"; on Debian: apt-get install {' '.join(packages)}" if packages else ""
        raise BlenderMissingError(
            f"Blender's module cannot be loaded: {error}{remedy}"
        ) from error


def missing_packages(reason: str = "") -> list[str]:
    """Debian packages of the libraries that bpy does not find, and that ``reason`` names."""
    return sorted({PACKAGES[name] for name in _missing(reason) if name in PACKAGES})


def _missing(reason: str) -> set[str]:
    """Names of the shared libraries that the loader does not find for bpy."""
    names = set(re.findall(r"(\S+\.so[.\d]*): cannot open", reason))
    spec = find_spec("bpy")
    if spec is None or not spec.submodule_search_locations or not sys.platform == "linux":
        return names
    for folder in spec.submodule_search_locations:
        for library in Path(folder).glob("__init__*.so"):
            listing = subprocess.run(["ldd", library], capture_output=True, text=True)
            names.update(re.findall(r"(\S+) => not found", listing.stdout))
    return names


def main() -> int:
    """Print the missing packages; 0 when bpy can be imported."""
    try:
        import_blender()
    except BlenderMissingError as error:
        for package in missing_packages(str(error)):
            print(package)
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
