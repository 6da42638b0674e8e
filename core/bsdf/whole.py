"""A material's lobes without parts: all that are no delta count as wide.

It goes when nobody calls it any more.
"""

from __future__ import annotations

from ..geometry.vector import Vector, dot, vector
from ..jit import Row, Table, kernel
from .conductor import sample_conductor
from .dielectric import sample_dielectric, sample_refraction
from .diffuse import eval_diffuse, pdf_diffuse, sample_diffuse
from .lobe import CONDUCTOR, DIELECTRIC, DIFFUSE, PHONG, REFRACTION, mean
from .phong import eval_phong, pdf_phong, sample_phong


@kernel
def is_specular(model: int) -> bool:
    """Whether the model scatters into single directions (a Dirac delta)."""
    return model == CONDUCTOR or model == DIELECTRIC or model == REFRACTION


@kernel
def whole_weights(material: Row, lobes: Table) -> tuple[float, float]:
    """Total mean weight of the non-specular and of the specular lobes."""
    smooth = 0.0
    rough = 0.0
    for k in range(material.lobe_start, material.lobe_start + material.lobe_count):
        if is_specular(lobes[k].model):
            smooth += mean(lobes[k].weight)
        else:
            rough += mean(lobes[k].weight)
    return rough, smooth


@kernel
def eval_nonspecular(material: Row, lobes: Table, n: Vector, wo: Vector, wi: Vector) -> Vector:
    """BSDF value of the non-specular lobes [1/sr], without the cosine."""
    r = g = b = 0.0
    if dot(n, wi) <= 0.0 or dot(n, wo) <= 0.0:
        return r, g, b
    for k in range(material.lobe_start, material.lobe_start + material.lobe_count):
        model = lobes[k].model
        if model == DIFFUSE:
            f = eval_diffuse()
        elif model == PHONG:
            f = eval_phong(n, wo, wi, lobes[k].exponent)
        else:
            continue
        w = lobes[k].weight
        r += w[0] * f
        g += w[1] * f
        b += w[2] * f
    return r, g, b


@kernel
def pdf_nonspecular(material: Row, lobes: Table, n: Vector, wo: Vector, wi: Vector) -> float:
    """Density of ``sample_nonspecular`` per solid angle."""
    if dot(n, wi) <= 0.0:
        return 0.0
    total = 0.0
    pdf_w = 0.0
    for k in range(material.lobe_start, material.lobe_start + material.lobe_count):
        model = lobes[k].model
        share = mean(lobes[k].weight)
        if model == DIFFUSE:
            pdf_w += share * pdf_diffuse(n, wi)
        elif model == PHONG:
            pdf_w += share * pdf_phong(n, wo, wi, lobes[k].exponent)
        else:
            continue
        total += share
    if total <= 0.0:
        return 0.0
    return pdf_w / total


@kernel
def sample_nonspecular(
    material: Row, lobes: Table, n: Vector, wo: Vector, u_lobe: float, u: float, v: float
) -> Vector:
    """Direction from one non-specular lobe, chosen by mean weight; may lie below ``n``."""
    rough, _ = whole_weights(material, lobes)
    rest = u_lobe * rough
    chosen = -1
    for k in range(material.lobe_start, material.lobe_start + material.lobe_count):
        share = mean(lobes[k].weight)
        if is_specular(lobes[k].model) or share <= 0.0:
            continue
        chosen = k
        if rest < share:
            break
        rest -= share
    if chosen >= 0 and lobes[chosen].model == PHONG:
        return sample_phong(n, wo, lobes[chosen].exponent, u, v)
    return sample_diffuse(n, u, v)


@kernel
def sample_specular(
    material: Row,
    lobes: Table,
    n: Vector,
    wo: Vector,
    entering: bool,
    n_around: float,
    u_lobe: float,
    u: float,
) -> tuple[bool, Vector, Vector, bool, float]:
    """Draw one specular event: (possible, wi, weight, transmitted, eta).

    ``n_around`` is the index of the medium on the other side of the material's own one.
    ``weight`` divides by the lobe's probability among the specular lobes and carries no
    radiance factor; ``eta`` is 1 for a reflection.
    """
    _, smooth = whole_weights(material, lobes)
    nothing = (0.0, 0.0, 0.0)
    rest = u_lobe * smooth
    chosen = -1
    for k in range(material.lobe_start, material.lobe_start + material.lobe_count):
        share = mean(lobes[k].weight)
        if not is_specular(lobes[k].model) or share <= 0.0:
            continue
        chosen = k
        if rest < share:
            break
        rest -= share
    if chosen < 0:
        return False, wo, nothing, False, 1.0
    lobe = lobes[chosen]
    prob = mean(lobe.weight) / smooth
    w = vector(lobe.weight)
    weight = (w[0] / prob, w[1] / prob, w[2] / prob)
    if lobe.model == CONDUCTOR:
        return True, sample_conductor(n, wo), weight, False, 1.0
    eta = lobe.ior / n_around if entering else n_around / lobe.ior
    if lobe.model == DIELECTRIC:
        wi, transmitted = sample_dielectric(n, wo, eta, u)
        return True, wi, weight, transmitted, (eta if transmitted else 1.0)
    wi, possible = sample_refraction(n, wo, eta)
    return possible, wi, weight, True, eta
