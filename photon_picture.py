"""Photons as a coloured cloud of points: a ``.ply`` file, or a picture from the camera.

PLY is written here: of the packages that Photon Map takes none can (Blender can, where
there is one), and its binary form is a header and one NumPy table.
"""

from __future__ import annotations

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
_CORNER = np.dtype(
    [("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("red", "u1"), ("green", "u1"), ("blue", "u1")]
)
_EDGE = np.dtype([("vertex1", "<i4"), ("vertex2", "<i4")])
_PLY_TYPES = {"<f4": "float", "|u1": "uchar", "<i4": "int"}


def write_ply(path: Path, view: PhotonView, by: str) -> None:
    """Write every photon to ``path``, binary PLY 1.0; raises ``OSError``."""
    points = np.zeros(len(view.position), _POINT)
    for name, column in zip("xyz", view.position.T, strict=True):
        points[name] = column
    for name, column in zip(("nx", "ny", "nz"), view.normal.T, strict=True):
        points[name] = column
    from .core.photon_shades import photon_colours

    shades = np.rint(255 * photon_colours(view, by)).astype(np.uint8)
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
    _write(path, comments, [(f"vertex {len(points)}", columns, points)])


def write_paths(
    path: Path, ways: list[NDArray[np.float64]], shades: NDArray[np.float64]
) -> None:
    """Write the way (n, 3) of each photon as a chain of edges in its colour (N, 3)."""
    lengths = np.array([len(way) for way in ways], np.int64)
    points = np.zeros(lengths.sum(), _CORNER)
    every = np.concatenate([np.zeros((0, 3)), *ways])
    for name, column in zip("xyz", every.T, strict=True):
        points[name] = column
    bytes_ = np.rint(255 * shades).astype(np.uint8)
    for name, column in zip(("red", "green", "blue"), bytes_.T, strict=True):
        points[name] = np.repeat(column, lengths)
    ends = np.cumsum(lengths) - 1
    begins = np.setdiff1d(np.arange(len(points)), ends)
    edges = np.zeros(len(begins), _EDGE)
    edges["vertex1"], edges["vertex2"] = begins, begins + 1
    parts = []
    for name, table in (("vertex", points), ("edge", edges)):
        names = table.dtype.names or ()
        columns = [f"property {_PLY_TYPES[table.dtype[n].str]} {n}" for n in names]
        parts.append((f"{name} {len(table)}", columns, table))
    _write(path, [], parts)


def _write(
    path: Path, comments: list[str], parts: list[tuple[str, list[str], NDArray[np.void]]]
) -> None:
    """A binary PLY 1.0 of some elements: count, properties, table."""
    head = ["ply", "format binary_little_endian 1.0", *comments]
    for element, columns, _ in parts:
        head += [f"element {element}", *columns]
    text = "\n".join(line.replace("\n", " ") for line in [*head, "end_header"]) + "\n"
    path.write_bytes(text.encode("ascii") + b"".join(table.tobytes() for _, _, table in parts))


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
