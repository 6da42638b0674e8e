"""Constant shader nodes as lobes, for the reference: only what needs no layers and tables."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..scene.scene import Scene, SceneError
from ..scene.tables import LOBE, ClosureKind, Model
from .bounces import bounces_of, no_bounces

_MODELS = (
    (ClosureKind.DIFFUSE, Model.DIFFUSE),
    (ClosureKind.GLOSSY, Model.GGX),
    (ClosureKind.GLASS, Model.GGX_DIELECTRIC),
    (ClosureKind.REFRACTION, Model.GGX_REFRACTION),
    (ClosureKind.TRANSPARENT, Model.TRANSPARENT),
    (ClosureKind.TRANSLUCENT, Model.TRANSLUCENT),
)
_BETWEEN_FACETS = (ClosureKind.GLOSSY, ClosureKind.GLASS)


def plain_tables(
    scene: Scene,
) -> tuple[NDArray[np.void], NDArray[np.void], NDArray[np.float64]]:
    """Materials and lobes of ``scene`` with every closure turned into a lobe.

    The third table (lobes, 2, NODES, 3) is that of ``bounces_of`` for each lobe. Raises
    ``SceneError`` for what the reference does not know: textures and layered nodes, and
    bounces between facets where glass lies in something else than air.
    """
    plain = np.tile(no_bounces(), (len(scene.lobes), 1, 1, 1))
    if not len(scene.closures):
        return scene.materials, scene.lobes, plain
    materials, lobes = scene.materials.copy(), [scene.lobes]
    count, bounces = len(scene.lobes), [plain]
    alone = int((scene.materials["ior"] > 0).sum()) == 1
    for material in materials:
        start, some = int(material["closure_start"]), int(material["closure_count"])
        if not some:
            continue
        closures = scene.closures[start : start + some]
        made = [(c, row) for c in closures if (row := _lobe(c)) is not None]
        rows = np.array([row for _, row in made], LOBE)
        bounces += [_bounces(c, row, alone)[None] for c, row in made]
        material["lobe_start"], material["lobe_count"] = count, len(rows)
        count += len(rows)
        lobes.append(rows)
    return materials, np.concatenate(lobes), np.concatenate(bounces)


def _bounces(closure: np.void, row: np.void, alone: bool) -> NDArray[np.float64]:
    """The table of one lobe; ``alone``: no other medium may lie around its glass."""
    if closure["kind"] not in _BETWEEN_FACETS or closure["distribution"] != 1:
        return no_bounces()
    if closure["kind"] == ClosureKind.GLASS and not alone:
        raise SceneError("the reference has light between facets for glass in air alone")
    return bounces_of(row, closure["color"]["value"])


def _lobe(closure: np.void) -> Any:
    kind = ClosureKind(closure["kind"])
    if kind == ClosureKind.EMISSION:
        return None
    model = dict(_MODELS).get(kind)
    used = [closure["color"], closure["roughness"]]
    used += [f["param"] for f in closure["factors"][: closure["factor_count"]]]
    if model is None or any(p["texture"] >= 0 for p in used):
        raise SceneError(f"the reference renders no {kind.name} shader with these inputs")
    share = 1.0
    for given in closure["factors"][: closure["factor_count"]]:
        value = float(given["param"]["value"][0])
        share *= 1.0 - value if given["invert"] else value
    row = np.zeros((), LOBE)
    roughness = float(closure["roughness"]["value"][0])
    if model == Model.DIFFUSE and roughness >= 1e-5:
        model = Model.OREN_NAYAR
        row["f0"] = np.clip(closure["color"]["value"], 0.0, 1.0)
    row["model"] = int(model)
    row["weight"] = share * closure["color"]["value"]
    row["roughness"] = roughness if model == Model.OREN_NAYAR else roughness**2
    row["ior"] = row["eta"] = closure["ior"]
    row["f90"] = 1.0
    return row[()]
