"""Names of the film's layers and their channels."""

from __future__ import annotations

#: Layers whose sum is the picture.
LIGHT_LAYERS = ("emission", "direct", "caustics", "indirect")

#: The picture apart by what its light did at the first surface: diffuse, glossy or
#: transmitted, straight from a light or not (``Settings.light_kinds``). Divided by the
#: colour of that kind, so that (direct + indirect) x colour, summed over the kinds, and
#: "seen_emission" and "environment" make the picture.
KINDS = ("diffuse", "glossy", "transmission")
KIND_COLORS = tuple(f"{kind}_color" for kind in KINDS)
KIND_LAYERS = tuple(f"{kind}_{way}" for way in ("direct", "indirect") for kind in KINDS)


def group_layer(group: str, caustics: bool = False) -> str:
    """The layer of a group of lights: all of its light, or its caustics."""
    return f"{'caustics' if caustics else 'combined'} of {group}"


def aov_layer(name: str) -> str:
    """The layer of a value of the user's own: red, green, blue and how much has one."""
    return f"aov {name}"


#: Data of the surfaces that the camera sees at once, traced on demand (``first_hits``): of
#: one path ("place": the face's number and 1, and the barycentrics of its corners 1 and 2), ...
SINGLE_LAYERS = {
    "position": 3, "distance": 1, "object_index": 1, "material_index": 1, "place": 3,
}  # fmt: skip
#: ... averaged over the passes, ...
MEAN_LAYERS = {
    "mist": 1, "uv": 3, "diffuse_color": 3, "glossy_color": 3, "transmission_color": 3,
    "seen_emission": 3, "environment": 3,
}  # fmt: skip
#: ... where the camera's path ends at a surface that is no mirror and no clear glass, ...
END_LAYERS = {"end_normal": 3, "end_depth": 1, "end_albedo": 3}
#: ... and which names share a pixel, by their hashes and coverages, two channels a name.
MATTE_LAYERS = ("matte_object", "matte_material", "matte_asset")
#: Photons that a pass stores around a place [1/m^2], of both maps, where the camera's path
#: asks for them: at the first surface that is no mirror and no clear glass.
DENSITY_LAYER = "photon_density"
FIRST_HIT_LAYERS = (
    *SINGLE_LAYERS, *MEAN_LAYERS, *END_LAYERS, *MATTE_LAYERS, DENSITY_LAYER,
)  # fmt: skip
