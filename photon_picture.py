"""Photons as a coloured cloud of points: a ``.ply`` file, or a picture from the camera.

PLY is written here: of the packages that Photon Map takes none can (Blender can, where
there is one), and its binary form is a header and one NumPy table.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from .core.photon_view import PhotonView

_POINT = np.dtype(
    [
        ("x", "<f4"), ("y", "<f4"), ("z", "<f4"),
        ("nx", "<f4"), ("ny", "<f4"), ("nz", "<f4"),
        ("red", "u1"), ("green", "u1"), ("blue", "u1"),
        ("power", "<f4"), ("caustic", "u1"), ("bounce", "<i4"), ("light", "<i4"),
        ("caster", "<i4"),
    ]
)  # fmt: skip
_PLY_TYPES = {"<f4": "float", "|u1": "uchar", "<i4": "int"}
#: Colours of things that are told apart, and of none (-1).
_NONE = (0.35, 0.35, 0.35)


def colours(view: PhotonView, by: str) -> NDArray[np.float64]:
    """Display colours (N, 3), 0..1, by ``power``, ``bounce``, ``caster`` or ``light``.

    Power goes from dark to bright over the 2nd to 98th percentile of its logarithm.
    """
    from matplotlib import colormaps

    if by == "power":
        power = np.log(np.maximum(view.flux.mean(axis=1), 1e-30).astype(np.float64))
        low, high = np.percentile(power, (2, 98)) if len(power) else (0.0, 1.0)
        share = (power - low) / (high - low) if high > low else np.full_like(power, 0.5)
        return np.asarray(colormaps["inferno"](0.15 + 0.85 * share.clip(0, 1)))[:, :3]
    if by == "bounce":
        return np.asarray(colormaps["viridis"](view.bounce.clip(0, 6) / 6))[:, :3]
    index = view.caster if by == "caster" else view.light
    table = np.asarray(colormaps["tab10"](np.arange(10)))[:, :3]
    return np.where(index[:, None] >= 0, table[index % 10], _NONE)


def legend(view: PhotonView, by: str) -> list[tuple[str, int]]:
    """What the colours stand for and how many photons each has, most first."""
    names: Callable[[int], str]
    if by == "caster":
        index, names = view.caster, lambda k: view.objects[k] if k >= 0 else "none"
    elif by == "light":
        index, names = view.light, lambda k: view.lights[k]
    else:
        index, names = view.bounce, lambda k: f"bounce {k}"
    values, counts = np.unique(index, return_counts=True)
    found = [(names(int(k)), int(n)) for k, n in zip(values, counts, strict=True)]
    return sorted(found, key=lambda entry: (-entry[1], entry[0]))


def write_ply(path: Path, view: PhotonView, by: str) -> None:
    """Write every photon to ``path``, binary PLY 1.0; raises ``OSError``."""
    points = np.zeros(len(view.position), _POINT)
    for name, column in zip("xyz", view.position.T, strict=True):
        points[name] = column
    for name, column in zip(("nx", "ny", "nz"), view.normal.T, strict=True):
        points[name] = column
    shades = np.rint(255 * colours(view, by)).astype(np.uint8)
    for name, column in zip(("red", "green", "blue"), shades.T, strict=True):
        points[name] = column
    points["power"] = view.flux.mean(axis=1)
    for name in ("caustic", "bounce", "light", "caster"):
        points[name] = getattr(view, name)
    names = [f"light {k} {name}" for k, name in enumerate(view.lights)]
    names += [f"caster {k} {name}" for k, name in enumerate(view.objects)]
    comments = [f"comment {name.encode('ascii', 'replace').decode()}" for name in names]
    assert _POINT.names is not None
    columns = [f"property {_PLY_TYPES[_POINT[name].str]} {name}" for name in _POINT.names]
    head = ["ply", "format binary_little_endian 1.0", *comments]
    head += [f"element vertex {len(points)}", *columns, "end_header"]
    text = "\n".join(line.replace("\n", " ") for line in head) + "\n"
    path.write_bytes(text.encode("ascii") + points.tobytes())


def picture(
    shades: NDArray[np.float64], pixels: NDArray[np.int32], width: int, height: int
) -> NDArray[np.uint8]:
    """Points of ``shades`` (n, 3) at ``pixels`` (n, 2) on black, as (height, width, 3).

    Rows go from the top; several in one pixel show their mean.
    """
    total = np.zeros((height, width, 3))
    count = np.zeros((height, width, 1))
    np.add.at(total, (pixels[:, 1], pixels[:, 0]), shades)
    np.add.at(count, (pixels[:, 1], pixels[:, 0]), 1.0)
    mean = total / np.maximum(count, 1.0)
    return np.rint(255 * mean[::-1]).astype(np.uint8)
