"""The world: radiance from everywhere that nothing covers, uniform or by a map all around.

Directions are drawn from a mixture: a uniform part (the darkest cell of the map) by the
cosine, the rest by the map's cells, in each uniform in solid angle. The map's colours are
interpolated, a cell's weight is their mean over it: where there is light there is density.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.vector import Vector, dot, to_world, vector
from ..jit import Row, Table, kernel
from ..sampling.distributions import cumulative, probability, sample_discrete
from ..sampling.warps import INV_PI, sample_cosine_hemisphere, sample_sphere
from ..scene.scene import Scene

#: Most cells of the distribution; a larger map's texels are taken together.
MOST_CELLS = 1 << 23


class World(NamedTuple):
    """The surroundings as kernels see them.

    radiance (3,): all of it, or what ``map`` (h, w, 3) is times; rotation (3, 3) into the
    map; rows (H,) and columns (H, W): cumulative shares of the cells; flat: share of the
    uniform part; mean: mean radiance of the channels; visibility: ``tables.Visibility``.
    """

    radiance: NDArray[np.float64]
    map: NDArray[np.float32]
    rotation: NDArray[np.float64]
    rows: NDArray[np.float64]
    columns: NDArray[np.float64]
    flat: float
    mean: float
    visibility: int


def world_of(scene: Scene) -> World:
    """Weigh the cells of the scene's map, if it has one."""
    texels = np.ascontiguousarray(scene.world_map)
    rows, columns, flat, mean = np.zeros(0), np.zeros((0, 0)), 1.0, 1.0
    factor = scene.world
    mean = float(factor.mean())
    if texels.size:
        cells = cell_means((texels * factor.astype(np.float32)).mean(axis=2))
        solid = np.diff(_sines(len(cells)))[:, None] / (2.0 * cells.shape[1])
        least = float(cells.min())
        mean = float((cells * solid).sum())
        flat = least / mean if mean > 0 else 1.0
        weight = (cells - least) * solid
        rows = cumulative(weight.sum(axis=1))
        columns = _cumulative_rows(weight)
    return World(
        radiance=factor.copy(),
        map=texels,
        rotation=scene.world_rotation.copy(),
        rows=rows,
        columns=columns,
        flat=min(1.0, flat),
        mean=mean,
        visibility=int(scene.world_visibility[0]),
    )


def cell_means(brightness: NDArray[np.float32]) -> NDArray[np.float64]:
    """Mean of the bilinear picture over each texel's square, (h, w) -> (H, W).

    A texel's neighbours count 1/8 to each side. Both ways wrap around, as in Cycles.
    """
    values = brightness.astype(np.float64)
    for axis in (0, 1):
        values = 0.75 * values + 0.125 * (np.roll(values, 1, axis) + np.roll(values, -1, axis))
    height, width = values.shape
    block = 1
    while height * width > MOST_CELLS * block * block and height > block and width > block:
        block *= 2
    # Cells must cover the map evenly: a map of other sizes loses its last block size.
    while height % block or width % block:
        block //= 2
    return values.reshape(height // block, block, width // block, block).mean(axis=(1, 3))


def _sines(rows: int) -> NDArray[np.float64]:
    """Sine of the latitude at the edges of ``rows`` rows."""
    return -np.cos(np.pi * np.arange(rows + 1) / rows)


def _cumulative_rows(weight: NDArray[np.float64]) -> NDArray[np.float64]:
    """``cumulative`` of each row."""
    return np.array([cumulative(row) for row in weight])


@kernel
def _turned(rotation: Table, d: Vector) -> Vector:
    return (
        rotation[0, 0] * d[0] + rotation[0, 1] * d[1] + rotation[0, 2] * d[2],
        rotation[1, 0] * d[0] + rotation[1, 1] * d[1] + rotation[1, 2] * d[2],
        rotation[2, 0] * d[0] + rotation[2, 1] * d[1] + rotation[2, 2] * d[2],
    )


@kernel
def place_on_map(world: Row, d: Vector) -> tuple[float, float]:
    """Column and row of the direction ``d``, in [0, 1] of the map's width and height."""
    q = _turned(world.rotation, d)
    column = 0.5 - math.atan2(q[1], q[0]) / (2.0 * math.pi)
    return column, 0.5 + math.atan2(q[2], math.sqrt(q[0] * q[0] + q[1] * q[1])) / math.pi


@kernel
def world_radiance(world: Row, d: Vector) -> Vector:
    """Radiance that arrives from the direction ``d``."""
    factor = vector(world.radiance)
    height, width, _ = world.map.shape
    if height == 0:
        return factor
    column, row = place_on_map(world, d)
    x = column * width - 0.5
    y = row * height - 0.5
    x0 = math.floor(x)
    y0 = math.floor(y)
    s = x - x0
    t = y - y0
    c0 = int(x0) % width
    c1 = (int(x0) + 1) % width
    r0 = int(y0) % height
    r1 = (int(y0) + 1) % height
    a = (1.0 - s) * (1.0 - t)
    b = s * (1.0 - t)
    c = (1.0 - s) * t
    e = s * t
    m = world.map
    return (
        factor[0] * (a * m[r0, c0, 0] + b * m[r0, c1, 0] + c * m[r1, c0, 0] + e * m[r1, c1, 0]),
        factor[1] * (a * m[r0, c0, 1] + b * m[r0, c1, 1] + c * m[r1, c0, 1] + e * m[r1, c1, 1]),
        factor[2] * (a * m[r0, c0, 2] + b * m[r0, c1, 2] + c * m[r1, c0, 2] + e * m[r1, c1, 2]),
    )


@kernel
def _cell_solid_angle(world: Row, row: int) -> float:
    height, width = world.columns.shape
    low = -math.cos(math.pi * row / height)
    high = -math.cos(math.pi * (row + 1) / height)
    return 2.0 * math.pi * (high - low) / width


@kernel
def sample_map(world: Row, u: float, v: float) -> tuple[Vector, float]:
    """Direction by the cells' weights: (wi, pdf_w of this part of the mixture)."""
    height, width = world.columns.shape
    row = sample_discrete(world.rows, u)
    prob = probability(world.rows, row)
    before = world.rows[row] - prob
    u = min(max((u - before) / prob, 0.0), 1.0) if prob > 0.0 else 0.5
    shares = world.columns[row]
    column = sample_discrete(shares, v)
    share = probability(shares, column)
    before = shares[column] - share
    v = min(max((v - before) / share, 0.0), 1.0) if share > 0.0 else 0.5
    low = -math.cos(math.pi * row / height)
    high = -math.cos(math.pi * (row + 1) / height)
    z = low + u * (high - low)
    r = math.sqrt(max(0.0, 1.0 - z * z))
    phi = 2.0 * math.pi * (0.5 - (column + v) / width)
    q = (r * math.cos(phi), r * math.sin(phi), z)
    m = world.rotation
    wi = (
        m[0, 0] * q[0] + m[1, 0] * q[1] + m[2, 0] * q[2],
        m[0, 1] * q[0] + m[1, 1] * q[1] + m[2, 1] * q[2],
        m[0, 2] * q[0] + m[1, 2] * q[1] + m[2, 2] * q[2],
    )
    return wi, prob * share / _cell_solid_angle(world, row)


@kernel
def pdf_map(world: Row, wi: Vector) -> float:
    """Density of ``sample_map`` per solid angle."""
    height, width = world.columns.shape
    if height == 0:
        return 0.0
    x, y = place_on_map(world, wi)
    row = min(int(y * height), height - 1)
    column = min(int(x * width), width - 1)
    prob = probability(world.rows, row) * probability(world.columns[row], column)
    return prob / _cell_solid_angle(world, row)


@kernel
def sample_world(world: Row, n: Vector, u: float, v: float) -> tuple[Vector, float]:
    """Direction for a surface of normal ``n``: (wi, pdf_w)."""
    if u < world.flat:
        wi = to_world(sample_cosine_hemisphere(u / world.flat, v), n)
    else:
        wi, _ = sample_map(world, (u - world.flat) / (1.0 - world.flat), v)
    return wi, pdf_world(world, n, wi)


@kernel
def pdf_world(world: Row, n: Vector, wi: Vector) -> float:
    """Density of ``sample_world`` per solid angle."""
    flat = world.flat * max(0.0, dot(n, wi)) * INV_PI
    if world.flat >= 1.0:
        return flat
    return flat + (1.0 - world.flat) * pdf_map(world, wi)


@kernel
def sample_beam(world: Row, u: float, v: float) -> tuple[Vector, float]:
    """Direction towards where light comes from, for photons: (wi, pdf_w)."""
    if u < world.flat:
        wi = sample_sphere(u / world.flat, v)
    else:
        wi, _ = sample_map(world, (u - world.flat) / (1.0 - world.flat), v)
    pdf_w = world.flat / (4.0 * math.pi)
    if world.flat < 1.0:
        pdf_w += (1.0 - world.flat) * pdf_map(world, wi)
    return wi, pdf_w
