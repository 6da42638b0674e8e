"""What a file says of its Cryptomatte passes: which names their numbers stand for."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from .passes import MATTES

if TYPE_CHECKING:
    from ..core import Scene


def matte_stamps(view_layer: Any, scene: Scene) -> dict[str, str]:
    """Metadata by key, as the Cryptomatte specification 1.2 has it (section "Metadata")."""
    from ..core import name_bits

    names = {
        "matte_object": scene.object_names,
        "matte_material": scene.material_names,
        "matte_asset": scene.object_assets,
    }
    stamps: dict[str, str] = {}
    for entry in MATTES:
        if not getattr(view_layer, entry.toggle):
            continue
        full = f"{view_layer.name}.{entry.name}"
        key = f"cryptomatte/{name_bits(full):08x}"[:-1]
        manifest = {name: f"{name_bits(name):08x}" for name in names[entry.layer]}
        stamps |= {
            f"{key}/name": full,
            f"{key}/hash": "MurmurHash3_32",
            f"{key}/conversion": "uint32_to_float32",
            f"{key}/manifest": json.dumps(manifest, ensure_ascii=False),
        }
    return stamps
