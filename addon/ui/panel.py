"""What the engine's panels have in common."""

from __future__ import annotations

from typing import Any

ENGINE = "PHOTONMAP"


class PhotonMapPanel:
    """A panel of the properties editor that only this engine shows."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    COMPAT_ENGINES = {ENGINE}
    layout: Any

    @classmethod
    def poll(cls, context: Any) -> bool:
        return context.engine in cls.COMPAT_ENGINES

    def column(self, heading: str = "") -> Any:
        """A column with names on the left, as in Blender's own panels."""
        self.layout.use_property_split = True
        self.layout.use_property_decorate = False
        return self.layout.column(heading=heading)


def draw_nodes(layout: Any, owner: Any, tree: Any | None, name: str) -> None:
    """The nodes that lead to the input ``name`` of the output that the export reads."""
    if tree is None:
        layout.prop(owner, "use_nodes", icon="NODETREE")
        return
    output = tree.get_output_node("CYCLES")
    if output is None:
        layout.label(text="No output node")
    else:
        layout.use_property_split = True
        layout.template_node_view(tree, output, output.inputs[name])


def draw_light_group(layout: Any, context: Any, owner: Any) -> None:
    """The light group of ``owner``, an object or a world, among those of the view layer."""
    layout.prop_search(
        owner, "lightgroup", context.view_layer, "lightgroups", text="Light Group",
        results_are_suggestions=True,
    )  # fmt: skip
