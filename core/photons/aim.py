"""Aims caustic photons at the casters: the surfaces that reflect or refract in one direction.

Casters are bounded by spheres. From a local light each sphere is a cone, sampled
*uniformly in solid angle*; for a distant light each is a disc across the beam. Cones and
discs overlap, so their densities are mixed. (The student's report drew points inside the
spheres instead and did not divide by that density.)
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.mesh import Mesh
from ..geometry.vector import Vector, along, dot, read, scale, subtract, to_world
from ..jit import Table, kernel
from ..lights.light_set import LightSet, photon_factors, photon_shares
from ..sampling.warps import one_minus_cos, sample_cone, sample_disk
from ..scene.scene import Scene
from ..scene.tables import Visibility
from .casters import caster_strength
from .emission_histogram import EmissionHistogram, no_histogram

#: Most spheres in use; more casters than that are merged by nearness.
MOST_SPHERES = 64
#: Share of the aim that is spread over the spheres by strength alone, the rest goes by
#: strength and the size seen.
EVEN = 0.5


class Aim(NamedTuple):
    """Spheres (C, 5) f8 around the casters: centre, radius, strength; light shares (N+2,).

    ``histogram``: what has been learnt of the numbers that choose where to aim at them.
    """

    spheres: NDArray[np.float64]
    light_cdf: NDArray[np.float64]
    histogram: EmissionHistogram = no_histogram()


def aim_at(scene: Scene, mesh: Mesh, lights: LightSet) -> Aim:
    """Bound the casters and share the photons out by what each light sends their way."""
    strength = caster_strength(scene)
    casts = (mesh.visible & Visibility.CASTS_NONE) == 0
    faces = np.flatnonzero(casts)
    faces = faces[strength[mesh.material[faces]] > 0] if len(strength) else faces[:0]
    spheres: list[NDArray[np.float64]] = []
    for object_id in np.unique(scene.face_object[faces]):
        own = faces[scene.face_object[faces] == object_id]
        strong = strength[mesh.material[own]].max()
        spheres += [np.array([*sphere, strong]) for sphere in _bound(mesh, own)]
    table = _merge(np.array(spheres).reshape(-1, 5))
    useful = _useful_power(lights, table) * photon_factors(scene)
    return Aim(table, photon_shares(useful))


def _sphere(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Sphere about the middle of the box of ``points`` (3, n)."""
    # A coordinate at a time: numpy is slow along axes of three.
    middle = np.array([(row.min() + row.max()) / 2 for row in points])
    x, y, z = ((row - m) ** 2 for row, m in zip(points, middle, strict=True))
    radius = math.sqrt((x + y + z).max())
    return np.array([*middle, radius * (1 + 1e-6) + 1e-12])


def _bound(mesh: Mesh, faces: NDArray[np.intp]) -> list[NDArray[np.float64]]:
    """Spheres around ``faces``, cut in two while that makes the target clearly smaller."""
    corners = np.ascontiguousarray(mesh.vertices[mesh.faces[faces]].T, dtype=np.float64)
    return _halves(corners)


def _halves(corners: NDArray[np.float64], depth: int = 0) -> list[NDArray[np.float64]]:
    """Spheres around triangles with ``corners`` (3 coordinates, 3 corners, n)."""
    whole = _sphere(corners.reshape(3, -1))
    if corners.shape[2] < 2 or depth >= 4:
        return [whole]
    centroid = (corners[:, 0] + corners[:, 1] + corners[:, 2]) / 3
    axis = int(np.argmax([np.ptp(row) for row in centroid]))
    order = np.argsort(centroid[axis], kind="stable")
    parts = [corners[..., part] for part in np.split(order, [len(order) // 2])]
    if sum(_sphere(part.reshape(3, -1))[3] ** 2 for part in parts) > 0.8 * whole[3] ** 2:
        return [whole]
    return _halves(parts[0], depth + 1) + _halves(parts[1], depth + 1)


def _merge(spheres: NDArray[np.float64]) -> NDArray[np.float64]:
    """At most ``MOST_SPHERES``: neighbours by k-means share a sphere around them."""
    if len(spheres) <= MOST_SPHERES:
        return spheres
    from scipy.cluster.vq import kmeans2

    _, label = kmeans2(spheres[:, :3], MOST_SPHERES, minit="++", seed=1)
    merged = []
    for k in np.unique(label):
        group = spheres[label == k]
        middle = (group[:, :3].min(axis=0) + group[:, :3].max(axis=0)) / 2
        reach = np.sqrt(((group[:, :3] - middle) ** 2).sum(axis=1)) + group[:, 3]
        merged.append([*middle, reach.max(), group[:, 4].max()])
    return np.array(merged)


def _useful_power(lights: LightSet, spheres: NDArray[np.float64]) -> NDArray[np.float64]:
    """About the flux of each light entry (N+2,) that meets a caster."""
    useful = np.zeros(len(lights.power))
    for k, power in enumerate(lights.power):
        if power <= 0 or len(spheres) == 0:
            continue
        if lights.distant[k]:
            area = (spheres[:, 4] * spheres[:, 3] ** 2).sum()
            part = min(1.0, area / lights.radius**2)
        else:
            distance2 = ((spheres[:, :3] - lights.place[k]) ** 2).sum(axis=1)
            reach2 = (spheres[:, 3] + lights.size[k]) ** 2
            sine2 = np.minimum(1.0, reach2 / np.maximum(distance2, 1e-300))
            cap = 0.5 * (1 - np.sqrt(1 - sine2))
            part = min(1.0, float((spheres[:, 4] * cap).sum()))
        useful[k] = power * part
    return useful


@kernel
def cone_of(spheres: Table, k: int, anchor: Vector, margin: float) -> tuple[Vector, float]:
    """Axis and versine (1 - cos) of the cone of beams that can meet sphere ``k``."""
    to_centre = subtract(read(spheres, k), anchor)
    d2 = dot(to_centre, to_centre)
    reach = spheres[k, 3] + margin
    if d2 <= reach * reach:
        return (0.0, 0.0, 1.0), 2.0
    return scale(to_centre, 1.0 / math.sqrt(d2)), one_minus_cos(reach * reach / d2)


@kernel
def _weight(spheres: Table, k: int, anchor: Vector, normal: Vector, margin: float) -> float:
    """Versine of cone ``k`` times its strength, 0 when it lies behind a one-sided light."""
    if dot(normal, normal) > 0.0:
        if dot(subtract(read(spheres, k), anchor), normal) <= -spheres[k, 3]:
            return 0.0
    return cone_of(spheres, k, anchor, margin)[1] * spheres[k, 4]


@kernel
def aim_local(
    spheres: Table,
    anchor: Vector,
    normal: Vector,
    margin: float,
    u_cone: float,
    u: float,
    v: float,
) -> tuple[Vector, float]:
    """Direction from ``anchor`` towards the casters: (w, pdf_w); pdf 0 when none is ahead."""
    total = 0.0
    strength = 0.0
    for k in range(len(spheres)):
        weight = _weight(spheres, k, anchor, normal, margin)
        total += weight
        if weight > 0.0:
            strength += spheres[k, 4]
    if total <= 0.0:
        return (0.0, 0.0, 1.0), 0.0
    chosen = -1
    before = 0.0
    for k in range(len(spheres)):
        weight = _weight(spheres, k, anchor, normal, margin)
        if weight <= 0.0:
            continue
        chosen = k
        before += EVEN * spheres[k, 4] / strength + (1.0 - EVEN) * weight / total
        if u_cone < before:
            break
    axis, versine = cone_of(spheres, chosen, anchor, margin)
    w = to_world(sample_cone(versine, u, v), axis)
    pdf_w = 0.0
    for k in range(len(spheres)):
        weight = _weight(spheres, k, anchor, normal, margin)
        if weight <= 0.0:
            continue
        axis, versine = cone_of(spheres, k, anchor, margin)
        gap = subtract(w, axis)
        # 1 - cos of the angle between unit vectors, exact when it is tiny.
        if k == chosen or 0.5 * dot(gap, gap) <= versine:
            prob = EVEN * spheres[k, 4] / strength + (1.0 - EVEN) * weight / total
            pdf_w += prob / (2.0 * math.pi * versine)
    return w, pdf_w


@kernel
def aim_distant(spheres: Table, w: Vector, u_disc: float, u: float, v: float) -> Any:
    """Point of a beam along ``w`` that can meet a caster: (point, pdf_a across the beam)."""
    total = 0.0
    strength = 0.0
    count = len(spheres)
    for k in range(count):
        total += spheres[k, 4] * spheres[k, 3] * spheres[k, 3]
        strength += spheres[k, 4]
    chosen = -1
    before = 0.0
    for k in range(count):
        chosen = k
        before += _share(spheres, k, strength, total)
        if u_disc < before:
            break
    x, y = sample_disk(u, v)
    r = spheres[chosen, 3]
    across = to_world((r * x, r * y, 0.0), w)
    centre = read(spheres, chosen)
    p = (centre[0] + across[0], centre[1] + across[1], centre[2] + across[2])
    pdf_a = 0.0
    for k in range(count):
        gap = subtract(p, read(spheres, k))
        h = dot(gap, w)
        side = along(gap, w, -h)
        r2 = spheres[k, 3] * spheres[k, 3]
        if k == chosen or dot(side, side) <= r2:
            pdf_a += _share(spheres, k, strength, total) / (math.pi * r2)
    return p, pdf_a


@kernel
def _share(spheres: Table, k: int, strength: float, total: float) -> float:
    """Probability of the disc of sphere ``k`` across a beam."""
    own = spheres[k, 4]
    return EVEN * own / strength + (1.0 - EVEN) * own * spheres[k, 3] * spheres[k, 3] / total
