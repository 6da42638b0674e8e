"""Camera paths at the lens, before their first surface."""

from __future__ import annotations

from ..camera.lens import camera_ray
from ..geometry.vector import Vector, store
from ..jit import Row, Table, kernel
from ..sampling.rng import CAMERA, camera_2d, stream
from ..scene.tables import Visibility
from .records import FILTER, LENS

_CAMERA_BIT = int(Visibility.CAMERA)


@kernel
def start_paths(
    camera: Row,
    camera_media: Table,
    x0: int,
    y0: int,
    width: int,
    image_width: int,
    seed: int,
    ids: Table,
    numbers: Table,
    origins: Table,
    directions: Table,
    paths: Table,
) -> None:
    """Camera rays of pixels ``ids`` (n,) of a region, the paths ``numbers`` (n,) of them.

    The region begins at pixel (x0, y0) and is ``width`` wide. A pixel's random numbers
    hang on its place in the whole image, so a border render shows the same picture.
    """
    for k in range(len(ids)):
        pixel = ids[k]
        i = numbers[k]
        x = x0 + pixel % width
        y = y0 + pixel // width
        key = stream(seed, CAMERA, i, y * image_width + x)
        pixel_key = stream(seed, CAMERA, -1, y * image_width + x)
        u_x, u_y = camera_2d(i, pixel_key, FILTER)
        u_lens = v_lens = 0.5
        if camera.lens_radius > 0.0:
            u_lens, v_lens = camera_2d(i, pixel_key, LENS)
        o, d, before, reach = camera_ray(camera, x, y, u_x, u_y, u_lens, v_lens)
        path = paths[k]
        path.key = key
        path.pixel_key = pixel_key
        path.slot = k
        path.number = i
        begin_path(path, camera_media, o, d, before, reach)
        store(origins[k], o)
        store(directions[k], d)


@kernel
def begin_path(
    path: Row, camera_media: Table, o: Vector, d: Vector, before: float, reach: float
) -> None:
    """A camera path about to leave ``o`` along ``d``; see ``camera_ray``."""
    path.depth = 0
    path.steps = 0
    path.forced = 0
    path.portion = 1.0
    path.event = _CAMERA_BIT
    path.length = before
    path.begun = 0.0
    path.reach = reach
    path.since = 0.0
    path.pdf_w = 0.0
    store(path.beta, (1.0, 1.0, 1.0))
    store(path.direction, d)
    store(path.origin, o)
    path.media_count = camera_media[0]
    for j in range(camera_media[0]):
        path.media[j] = camera_media[1 + j]
