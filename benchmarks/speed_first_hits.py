"""Which pixels see nothing but diffuse surfaces at first."""

from __future__ import annotations

import numpy as np
from embreex import rtcore_scene
from embreex.mesh_construction import TriangleMesh
from numpy.typing import NDArray
from scipy.ndimage import binary_erosion
from speed_parts import Parts

#: Rays along the side of a pixel.
RAYS = 8


def diffuse_pixels(parts: Parts) -> NDArray[np.bool_]:
    """Mask (h, w), row 0 at the top; pixels beside others are left out, for what lies between
    the rays. A lens would blur the mask: ``ValueError``."""
    camera = parts.camera
    if camera.lens_radius > 0:
        raise ValueError("which pixels are diffuse is not told through a lens")
    tracer = rtcore_scene.EmbreeScene()
    corners = np.concatenate([s.vertices[s.faces] for s in parts.surfaces])
    TriangleMesh(tracer, corners.astype(np.float32))
    plain = np.concatenate(
        [np.full(len(s.faces), s.matter.kind in ("diffuse", "glow")) for s in parts.surfaces]
    )
    height, width = camera.height, camera.width
    x = ((np.arange(width * RAYS) + 0.5) / (width * RAYS) * 2 - 1)[None, :]
    y = (1 - (np.arange(height * RAYS) + 0.5) / (height * RAYS) * 2)[:, None] * height / width
    half = camera.sensor_width / (2 * camera.lens)
    ways = np.stack(np.broadcast_arrays(half * x, half * y, -1.0), axis=-1).reshape(-1, 3)
    matrix = np.asarray(camera.matrix, float)
    ways = (ways @ matrix[:3, :3].T).astype(np.float32)
    origins = np.broadcast_to(matrix[:3, 3].astype(np.float32), ways.shape)
    met = tracer.run(np.ascontiguousarray(origins), ways)
    seen = np.where(met >= 0, plain[met], True)
    whole = seen.reshape(height, RAYS, width, RAYS).all(axis=(1, 3))
    mask: NDArray[np.bool_] = binary_erosion(whole, np.ones((3, 3)), border_value=1)
    return mask
