"""What a photon's event differs by from a camera path's, which goes the other way round."""

from __future__ import annotations

from ..bsdf.dispatch import eval_alike
from ..bsdf.resolve import resolve
from ..geometry.media import ior_around
from ..geometry.vector import Vector, dot, scale, vector
from ..jit import Row, Table, kernel

#: Bound on the cosine ratio of shading and geometric normal. Towards grazing it has no
#: bound and infinite variance; it is above 8 only for light within 1/8 rad of grazing.
MOST_CORRECTION = 8.0


@kernel
def adjoint_weight(
    path: Row,
    hit: Row,
    mesh: Row,
    materials: Table,
    lobes: Table,
    shading: Row,
    spare: int,
    part: int,
    wi: Vector,
    eta: float,
    weight: Vector,
) -> Vector:
    """The event's ``weight`` with its lobes worked out for a viewer in ``wi``.

    Layers, and the factor for bounces between facets, are not reciprocal: they depend on
    where the viewer is, and a photon's viewer is the one it leaves to. What a bare lobe
    scatters is: f / n^2 is the same both ways, n the index on the viewer's side (Veach
    1997, section 5.2), and ``weight`` is for flux.
    """
    wo = vector(hit.wo)
    n = vector(hit.ns)
    entering = hit.entering != 0
    before = eval_alike(path, lobes, n, wo, wi, part, eta)
    around = ior_around(materials, path, hit.row, entering)
    if dot(n, wi) < 0.0:
        n = scale(n, -1.0)
        entering = not entering
        before = scale(before, eta * eta)
    path.lobe_count = resolve(
        materials[hit.row], shading, mesh, hit.face, hit.u, hit.v, n, wi, entering, around,
        lobes, spare,
    )  # fmt: skip
    path.lobe_start = spare
    after = eval_alike(path, lobes, n, wi, wo, part, 1.0 / eta)
    return (
        weight[0] * after[0] / before[0] if before[0] > 0.0 else 0.0,
        weight[1] * after[1] / before[1] if before[1] > 0.0 else 0.0,
        weight[2] * after[2] / before[2] if before[2] > 0.0 else 0.0,
    )


@kernel
def normal_correction(hit: Row, wi: Vector) -> float:
    """Adjoint of the shading normal for the outgoing side (Veach 1997, section 5.3)."""
    cos_s = abs(dot(wi, vector(hit.ns)))
    if cos_s <= 0.0:
        return 0.0
    return min(MOST_CORRECTION, abs(dot(wi, vector(hit.ng))) / cos_s)
