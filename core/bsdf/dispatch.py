"""The lobes of a surface as one BSDF in two parts, and the only way to them.

A *surface* is any row with ``lobe_start`` and ``lobe_count``: a slice of a lobe table. Its
lobes are shared out between two parts by ``narrow_share``: what is NARROW scatters like a
mirror or smooth glass (deltas are wholly so), what is WIDE like a diffuse surface. The sum
of both parts is the BSDF, so nothing jumps with roughness. Photons share the same lobes out
in another way: caustic photons follow what is CASTING, the rest is SPREADING. Transparent
lobes are in neither: their rays go on as if there were no surface. ``n`` is the shading
normal on the side of ``wo``; all directions point away from the surface.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..geometry.vector import Vector, add, dot, scale, vector
from ..jit import Row, Table, kernel
from ..scene.tables import Visibility
from .fresnel import fresnel_dielectric, reflect, refract
from .lobe import (
    DIELECTRIC,
    DIFFUSE,
    REFRACTION,
    TRANSLUCENT,
    TRANSPARENT,
    casting_share,
    eval_lobe,
    is_cosine,
    is_delta,
    is_diffuse_like,
    is_rough_glass,
    narrow_share,
    pdf_lobe,
    sample_delta,
    sample_lobe,
    transmits,
)

WIDE = 0
NARROW = 1
SPREADING = 2
CASTING = 3
_BLACK = (0.0, 0.0, 0.0)
_DIFFUSE_BIT = int(Visibility.DIFFUSE)
_GLOSSY_BIT = int(Visibility.GLOSSY)
_TRANSMISSION_BIT = int(Visibility.TRANSMISSION)


@kernel
def part_share(lobe: Row, part: int) -> float:
    """Share of a lobe that belongs to ``part``."""
    if lobe.model == TRANSPARENT:
        return 0.0
    if part == WIDE or part == NARROW:
        sharp = narrow_share(lobe)
    else:
        sharp = casting_share(lobe)
    return sharp if part == NARROW or part == CASTING else 1.0 - sharp


@kernel
def _part_weight(surface: Row, lobes: Table, part: int) -> float:
    """What the lobes of a part are drawn by, summed."""
    total = 0.0
    for k in range(surface.lobe_start, surface.lobe_start + surface.lobe_count):
        total += lobes[k].share * part_share(lobes[k], part)
    return total


@kernel
def lobe_weights(surface: Row, lobes: Table) -> tuple[float, float]:
    """How much the wide and the narrow part scatter: estimates to choose between them."""
    return _part_weight(surface, lobes, WIDE), _part_weight(surface, lobes, NARROW)


@kernel
def photon_weights(surface: Row, lobes: Table) -> tuple[float, float]:
    """As ``lobe_weights``, of the spreading and the casting part."""
    return _part_weight(surface, lobes, SPREADING), _part_weight(surface, lobes, CASTING)


@kernel
def pass_weight(surface: Row, lobes: Table) -> Vector:
    """Share of light that goes straight through, per channel."""
    total = _BLACK
    for k in range(surface.lobe_start, surface.lobe_start + surface.lobe_count):
        if lobes[k].model == TRANSPARENT:
            total = add(total, vector(lobes[k].weight))
    return total


@kernel
def is_twosided(surface: Row, lobes: Table) -> bool:
    """Whether light from behind is scattered widely to the viewer."""
    for k in range(surface.lobe_start, surface.lobe_start + surface.lobe_count):
        if transmits(lobes[k].model) and narrow_share(lobes[k]) < 1.0:
            return True
    return False


@kernel
def part_bit(surface: Row, lobes: Table, part: int, transmitted: bool) -> int:
    """``Visibility`` bit of the rays that a part sends out on one side."""
    diffuse = False
    refracting = False
    for k in range(surface.lobe_start, surface.lobe_start + surface.lobe_count):
        lobe = lobes[k]
        if lobe.share * part_share(lobe, part) <= 0.0:
            continue
        diffuse = diffuse or is_diffuse_like(lobe.model)
        refracting = refracting or (transmits(lobe.model) and lobe.model != TRANSLUCENT)
    if transmitted:
        return _TRANSMISSION_BIT if refracting else _DIFFUSE_BIT
    return _DIFFUSE_BIT if diffuse else _GLOSSY_BIT


@kernel
def is_lambertian(surface: Row, lobes: Table) -> bool:
    """Whether the wide part is Lambertian reflection alone (its value is a constant)."""
    for k in range(surface.lobe_start, surface.lobe_start + surface.lobe_count):
        if lobes[k].model != DIFFUSE and part_share(lobes[k], WIDE) > 0.0:
            return False
    return True


@kernel
def albedo_nonspecular(surface: Row, lobes: Table) -> Vector:
    """Summed weights of the wide shares of all lobes."""
    total = _BLACK
    for k in range(surface.lobe_start, surface.lobe_start + surface.lobe_count):
        total = add(total, scale(vector(lobes[k].weight), part_share(lobes[k], WIDE)))
    return total


@kernel
def eval_part(
    surface: Row, lobes: Table, n: Vector, wo: Vector, wi: Vector, part: int
) -> Vector:
    """BSDF value of a part [1/sr] without the cosine and without deltas.

    ``wi`` may lie below ``n``. For radiance that leaves towards ``wo``: a refraction holds
    its factor 1 / eta^2.
    """
    total = _BLACK
    for k in range(surface.lobe_start, surface.lobe_start + surface.lobe_count):
        share = part_share(lobes[k], part)
        if share > 0.0:
            total = add(total, scale(eval_lobe(lobes[k], n, wo, wi), share))
    return total


@kernel
def eval_alike(
    surface: Row, lobes: Table, n: Vector, wo: Vector, wi: Vector, part: int, eta: float
) -> Vector:
    """As ``eval_part``; below ``n`` of those lobes alone that scale radiance by 1 / eta^2."""
    total = _BLACK
    below = dot(n, wi) < 0.0
    for k in range(surface.lobe_start, surface.lobe_start + surface.lobe_count):
        share = part_share(lobes[k], part)
        own = lobes[k].eta if is_rough_glass(lobes[k].model) else 1.0
        # Seen from the other side the ratio is the inverse, but for rounding.
        if share > 0.0 and (not below or abs(own - eta) < 1e-6 * eta):
            total = add(total, scale(eval_lobe(lobes[k], n, wo, wi), share))
    return total


@kernel
def pdf_part(surface: Row, lobes: Table, n: Vector, wo: Vector, wi: Vector, part: int) -> float:
    """Density per solid angle of what ``sample_part`` draws, deltas left out."""
    total = 0.0
    pdf_w = 0.0
    for k in range(surface.lobe_start, surface.lobe_start + surface.lobe_count):
        share = lobes[k].share * part_share(lobes[k], part)
        if share > 0.0:
            total += share
            pdf_w += share * pdf_lobe(lobes[k], n, wo, wi)
    return pdf_w / total if total > 0.0 else 0.0


@kernel
def _choose(surface: Row, lobes: Table, part: int, u: float) -> tuple[int, float, float]:
    """Draw a lobe of a part: (its row or -1, probability, what is left of ``u``)."""
    total = _part_weight(surface, lobes, part)
    rest = u * total
    chosen = -1
    share = 0.0
    for k in range(surface.lobe_start, surface.lobe_start + surface.lobe_count):
        s = lobes[k].share * part_share(lobes[k], part)
        if s <= 0.0:
            continue
        chosen = k
        share = s
        if rest < s:
            break
        rest -= s
    if chosen < 0:
        return -1, 0.0, 0.0
    return chosen, share / total, min(rest / share, 1.0 - 1e-12)


@kernel
def cosine_share(surface: Row, lobes: Table, part: int) -> float:
    """Probability that ``sample_part`` takes a lobe that is drawn by the cosine."""
    total = 0.0
    found = 0.0
    for k in range(surface.lobe_start, surface.lobe_start + surface.lobe_count):
        share = lobes[k].share * part_share(lobes[k], part)
        total += share
        if is_cosine(lobes[k].model):
            found += share
    return found / total if total > 0.0 else 0.0


@kernel
def draws_cosine(surface: Row, lobes: Table, part: int, u: float) -> bool:
    """Whether ``sample_part`` takes such a lobe with ``u``."""
    k, _, _ = _choose(surface, lobes, part, u)
    return k >= 0 and is_cosine(lobes[k].model)


@kernel
def _eta_of(lobe: Row, entering: bool, n_around: float) -> float:
    """Ratio n transmitted / n incident of a hit: resolved lobes know it."""
    if is_rough_glass(lobe.model):
        return lobe.eta
    if lobe.model == DIELECTRIC or lobe.model == REFRACTION:
        return lobe.ior / n_around if entering else n_around / lobe.ior
    return 1.0


def smooth_glass(materials: NDArray[np.void], lobes: NDArray[np.void]) -> NDArray[np.bool_]:
    """Which ``materials`` (M,) are smooth glass and nothing else, the same everywhere."""
    only = (materials["lobe_count"] == 1) & (materials["closure_count"] == 0)
    only &= materials["passes"] == 0
    only &= (materials["normal_texture"] < 0) & (materials["bump_texture"] < 0)
    only[only] = lobes["model"][materials["lobe_start"][only]] == DIELECTRIC
    return np.asarray(only)


@kernel
def reflected_share(
    surface: Row,
    lobes: Table,
    n: Vector,
    ng: Vector,
    wo: Vector,
    entering: bool,
    n_around: float,
) -> float:
    """Share that smooth glass, the only lobe there, reflects: the chance of ``sample_part``.

    0 where one of the two branches is not there, and where a shading normal would send one
    through the face ``ng``.
    """
    if dot(n, wo) <= 0.0:
        return 0.0
    eta = _eta_of(lobes[surface.lobe_start], entering, n_around)
    share, cos_t = fresnel_dielectric(dot(wo, n), eta)
    if share >= 1.0 or cos_t <= 0.0:
        return 0.0
    if dot(reflect(wo, n), ng) <= 0.0 or dot(refract(wo, n, eta, cos_t), ng) >= 0.0:
        return 0.0
    return share


@kernel
def _weight_of(
    surface: Row, lobes: Table, n: Vector, wo: Vector, wi: Vector, part: int, eta: float
) -> Vector:
    """Weight f |cos| / pdf over those lobes of a part that would scale radiance alike.

    Flux goes without the radiance factor 1 / eta^2; lobes of another factor have their
    own samples, so the sum over all samples is right for both.
    """
    total = 0.0
    pdf_w = 0.0
    f = _BLACK
    below = dot(n, wi) < 0.0
    for k in range(surface.lobe_start, surface.lobe_start + surface.lobe_count):
        lobe = lobes[k]
        share = part_share(lobe, part)
        if share <= 0.0:
            continue
        total += lobe.share * share
        if below and (lobe.eta if is_rough_glass(lobe.model) else 1.0) != eta:
            continue
        pdf_w += lobe.share * share * pdf_lobe(lobe, n, wo, wi)
        f = add(f, scale(eval_lobe(lobe, n, wo, wi), share))
    if pdf_w <= 0.0:
        return _BLACK
    factor = eta * eta if below else 1.0
    return scale(f, factor * abs(dot(n, wi)) * total / pdf_w)


@kernel
def sample_part(
    surface: Row,
    lobes: Table,
    n: Vector,
    wo: Vector,
    entering: bool,
    n_around: float,
    part: int,
    u_lobe: float,
    u: float,
    v: float,
) -> tuple[bool, Vector, Vector, float, bool, float]:
    """Draw a direction: (possible, wi, weight, pdf_w, transmitted, eta).

    ``n_around``: index of the medium on the other side of the material's own one.
    ``weight``: f |cos| / pdf of the part, for a delta its weight over its probability; in
    both cases for flux. Radiance is divided by ``eta``^2, which is 1 unless refracted.
    ``pdf_w``: as ``pdf_part``, 0 for a delta.
    """
    k, prob, u_rest = _choose(surface, lobes, part, u_lobe)
    if k < 0 or dot(n, wo) <= 0.0:
        return False, wo, _BLACK, 0.0, False, 1.0
    lobe = lobes[k]
    eta = _eta_of(lobe, entering, n_around)
    if is_delta(lobe):
        ok, wi, weight, transmitted = sample_delta(lobe, n, wo, eta, u)
        weight = scale(weight, part_share(lobe, part) / prob)
        return ok, wi, weight, 0.0, transmitted, (eta if transmitted else 1.0)
    ok, wi, transmitted = sample_lobe(lobe, n, wo, u_rest, u, v)
    if not transmitted:
        eta = 1.0
    if not ok:
        return False, wi, _BLACK, 0.0, transmitted, eta
    pdf_w = pdf_part(surface, lobes, n, wo, wi, part)
    weight = _weight_of(surface, lobes, n, wo, wi, part, eta)
    return pdf_w > 0.0, wi, weight, pdf_w, transmitted, eta
