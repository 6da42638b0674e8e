"""The render engine as Blender sees it: attributes and callbacks, nothing else."""

from __future__ import annotations

from typing import Any

import bpy

from .passes import register_passes
from .report import ExportError, guarded


class PhotonMapEngine(bpy.types.RenderEngine):
    """Renders with ``photon_map.core``; one object lives for one render of one frame."""

    bl_idname = "PHOTONMAP"
    bl_label = "Photon Map"
    bl_use_preview = False
    bl_use_postprocess = True
    bl_use_eevee_viewport = True
    bl_use_shading_nodes_custom = False

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.failure = ""
        self.failure_shown = False

    def update_render_passes(self, scene: Any = None, renderlayer: Any = None) -> None:
        """Tell Blender the passes of a view layer, for its compositor and its files."""
        with guarded(self):
            register_passes(self, scene, renderlayer)

    def render(self, depsgraph: Any) -> None:
        """Render one view layer of one frame, unless an earlier one failed."""
        if self.failure_shown:
            return
        with guarded(self):
            if self.failure:  # Blender drops what was reported before this callback
                raise ExportError(self.failure)
            from .final import render_final

            render_final(self, depsgraph)
        self.failure_shown = bool(self.failure)
