"""Where compiled kernels are kept when this runs as an extension."""

from __future__ import annotations

import os

import bpy

#: Read by ``core.jit``.
VARIABLE = "PHOTON_MAP_CACHE_DIR"


def use_extension_folder(package: str = __package__.rpartition(".")[0]) -> None:
    """Have the core keep its kernels in the extension's folder, which Blender clears away.

    To be called before the first import of the core's kernels. Outside of Blender's
    extensions, and where the user has chosen a folder, nothing changes.
    """
    if VARIABLE not in os.environ and package.startswith("bl_ext."):
        os.environ[VARIABLE] = bpy.utils.extension_path_user(
            package, path="kernels", create=True
        )
