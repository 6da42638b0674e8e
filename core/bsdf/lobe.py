"""One lobe: which model it is of, and what that model scatters.

``n`` is the shading normal on the side of ``wo``; all directions point away from the
surface. A refraction's values are for radiance that leaves towards ``wo``. To add a BRDF see
``added``; a model that does more needs a branch in each function below and a ``Model``.
"""

from __future__ import annotations

import math

from ..geometry.vector import Vector, dot, scale, vector
from ..jit import Row, Table, kernel
from ..scene.tables import Fresnel, Model
from .added import eval_added, pdf_added, sample_added
from .diffuse import eval_diffuse, pdf_diffuse, sample_diffuse
from .fresnel import fresnel_dielectric, fresnel_f82, fresnel_rise, reflect, refract
from .microfacet import eval_ggx, half_reflection, pdf_ggx, sample_ggx, sample_visible_normal
from .oren_nayar import eval_oren_nayar
from .phong import eval_phong, pdf_phong, sample_phong
from .rough_dielectric import (
    eval_refraction,
    half_refraction,
    pdf_refraction,
    sample_rough_refraction,
)
from .sheen import eval_sheen, pdf_sheen, sample_sheen
from .translucent import eval_translucent, pdf_translucent, sample_translucent

DIFFUSE = int(Model.DIFFUSE)
PHONG = int(Model.PHONG)
CONDUCTOR = int(Model.CONDUCTOR)
DIELECTRIC = int(Model.DIELECTRIC)
REFRACTION = int(Model.REFRACTION)
OREN_NAYAR = int(Model.OREN_NAYAR)
GGX = int(Model.GGX)
GGX_DIELECTRIC = int(Model.GGX_DIELECTRIC)
GGX_REFRACTION = int(Model.GGX_REFRACTION)
TRANSPARENT = int(Model.TRANSPARENT)
TRANSLUCENT = int(Model.TRANSLUCENT)
SHEEN = int(Model.SHEEN)
ADDED_1 = int(Model.ADDED_1)
ADDED_2 = int(Model.ADDED_2)
NO_FRESNEL = int(Fresnel.NONE)
TRUE_FRESNEL = int(Fresnel.DIELECTRIC)
F82 = int(Fresnel.F82)
SCHLICK = int(Fresnel.SCHLICK)

#: Below this width microfacets are taken for a plane: rays have float32 directions.
LEAST_ALPHA = 1e-4
#: Rough glass of an index this near to its surroundings lets light pass straight.
LEAST_STEP = 1e-4
#: Widths up to which a lobe is narrow alone, and from which on it is wide alone.
NARROW_UP_TO = 0.03
WIDE_FROM = 0.25
_BLACK = (0.0, 0.0, 0.0)


@kernel
def mean(weight: Table) -> float:
    """Mean of the three channels."""
    return (weight[0] + weight[1] + weight[2]) / 3.0


@kernel
def is_rough_glass(model: int) -> bool:
    """Whether microfacets of the model transmit."""
    return model == GGX_DIELECTRIC or model == GGX_REFRACTION


@kernel
def is_diffuse_like(model: int) -> bool:
    """Whether the model reflects about the normal, wherever the viewer is."""
    return model == DIFFUSE or model == OREN_NAYAR or model == SHEEN


@kernel
def is_cosine(model: int) -> bool:
    """Whether ``sample_lobe`` draws by the cosine, with ``sample_diffuse``."""
    return model == DIFFUSE or model == OREN_NAYAR


@kernel
def transmits(model: int) -> bool:
    """Whether the model sends light to the other side, and not straight on."""
    return (
        model == DIELECTRIC
        or model == REFRACTION
        or model == TRANSLUCENT
        or is_rough_glass(model)
    )


@kernel
def is_delta(lobe: Row) -> bool:
    """Whether the lobe scatters into single directions."""
    model = lobe.model
    if model == GGX or is_rough_glass(model):
        if lobe.roughness < LEAST_ALPHA:
            return True
        return is_rough_glass(model) and abs(lobe.eta - 1.0) < LEAST_STEP
    return (
        model == CONDUCTOR or model == DIELECTRIC or model == REFRACTION or model == TRANSPARENT
    )


@kernel
def narrow_share(lobe: Row) -> float:
    """How much of the lobe is treated as specular: from 1 (a delta) smoothly to 0.

    It is the same seen from both sides, as a path is that counts once.
    """
    if is_delta(lobe):
        return 1.0
    model = lobe.model
    if model == PHONG:
        alpha = math.sqrt(2.0 / (lobe.exponent + 2.0))
    elif model == GGX:
        alpha = lobe.roughness
    elif is_rough_glass(model):
        # What is refracted spreads less, the less so the nearer the indices are.
        alpha = lobe.roughness * min(1.0, 2.0 * abs(lobe.eta - 1.0) / max(lobe.eta, 1.0))
    else:
        return 0.0
    x = (WIDE_FROM - alpha) / (WIDE_FROM - NARROW_UP_TO)
    x = min(1.0, max(0.0, x))
    return x * x * (3.0 - 2.0 * x)


@kernel
def casting_share(lobe: Row) -> float:
    """How much of the lobe caustic photons follow: all of a rough mirror and rough glass.

    What such a body sends on lies within its lobe, where a gather ray seldom meets it. A
    coat mirrors too little light to be worth the photons.
    """
    coat = lobe.fresnel == TRUE_FRESNEL or lobe.fresnel == SCHLICK
    if is_rough_glass(lobe.model) or (lobe.model == GGX and not coat):
        return 1.0
    return narrow_share(lobe)


@kernel
def reflectance(lobe: Row, cos_h: float) -> Vector:
    """Fresnel reflectance of a GGX facet that is seen at ``cos_h``; 1 without Fresnel."""
    kind = lobe.fresnel
    if lobe.model == GGX_DIELECTRIC and kind != SCHLICK:
        kind = TRUE_FRESNEL
    if kind == TRUE_FRESNEL:
        f = fresnel_dielectric(cos_h, lobe.eta)[0]
        return f, f, f
    if kind == F82:
        return (
            fresnel_f82(cos_h, lobe.f0[0], lobe.f90[0]),
            fresnel_f82(cos_h, lobe.f0[1], lobe.f90[1]),
            fresnel_f82(cos_h, lobe.f0[2], lobe.f90[2]),
        )
    if kind == SCHLICK:
        s = fresnel_rise(cos_h, lobe.eta)
        a = lobe.f0
        if lobe.model == GGX_DIELECTRIC:
            return a[0] + (1.0 - a[0]) * s, a[1] + (1.0 - a[1]) * s, a[2] + (1.0 - a[2]) * s
        b = lobe.f90
        return (
            a[0] + (b[0] - a[0]) * s,
            a[1] + (b[1] - a[1]) * s,
            a[2] + (b[2] - a[2]) * s,
        )
    return 1.0, 1.0, 1.0


@kernel
def transmittance(lobe: Row, cos_h: float) -> Vector:
    """What a facet of rough glass lets pass: 1 - reflectance, tinted by ``f90``."""
    if lobe.model == GGX_REFRACTION:
        f, cos_t = fresnel_dielectric(cos_h, lobe.eta)
        return _BLACK if f >= 1.0 and cos_t == 0.0 else (1.0, 1.0, 1.0)
    r = reflectance(lobe, cos_h)
    t = lobe.f90
    return (1.0 - r[0]) * t[0], (1.0 - r[1]) * t[1], (1.0 - r[2]) * t[2]


@kernel
def _reflect_prob(lobe: Row, cos_h: float) -> float:
    """Probability of reflection at a facet of rough glass."""
    if lobe.model == GGX_REFRACTION:
        return 0.0
    r = reflectance(lobe, cos_h)
    t = transmittance(lobe, cos_h)
    a = r[0] + r[1] + r[2]
    b = t[0] + t[1] + t[2]
    return a / (a + b) if a + b > 0.0 else 1.0


@kernel
def _times(a: Table, b: Vector, s: float) -> Vector:
    return a[0] * b[0] * s, a[1] * b[1] * s, a[2] * b[2] * s


@kernel
def eval_lobe(lobe: Row, n: Vector, wo: Vector, wi: Vector) -> Vector:
    """BSDF value [1/sr] without the cosine; deltas give nothing."""
    model = lobe.model
    w = lobe.weight
    if dot(n, wo) <= 0.0 or is_delta(lobe):
        return _BLACK
    if dot(n, wi) <= 0.0:
        if model == TRANSLUCENT:
            return scale(vector(w), eval_translucent())
        if is_rough_glass(model):
            f = eval_refraction(n, wo, wi, lobe.roughness, lobe.eta)
            if f > 0.0:
                cos_h = dot(wo, half_refraction(n, wo, wi, lobe.eta))
                return _times(w, transmittance(lobe, cos_h), f)
        return _BLACK
    if model == DIFFUSE:
        return scale(vector(w), eval_diffuse())
    if model == OREN_NAYAR:
        return _times(w, eval_oren_nayar(n, wo, wi, lobe.roughness, vector(lobe.f0)), 1.0)
    if model == PHONG:
        return scale(vector(w), eval_phong(n, wo, wi, lobe.exponent))
    if model == SHEEN:
        return scale(vector(w), eval_sheen(n, wo, wi, lobe.f0[0], lobe.f0[1]))
    if model == GGX or model == GGX_DIELECTRIC:
        f = eval_ggx(n, wo, wi, lobe.roughness)
        return _times(w, reflectance(lobe, dot(wo, half_reflection(wo, wi))), f)
    if model == ADDED_1 or model == ADDED_2:
        return eval_added(model == ADDED_1, lobe, n, wo, wi)
    return _BLACK


@kernel
def pdf_lobe(lobe: Row, n: Vector, wo: Vector, wi: Vector) -> float:
    """Density of ``sample_lobe`` per solid angle, for what ends on the right side of ``n``."""
    model = lobe.model
    if is_delta(lobe):
        return 0.0
    if dot(n, wi) <= 0.0:
        if model == TRANSLUCENT:
            return pdf_translucent(n, wi)
        if is_rough_glass(model):
            pdf_w = pdf_refraction(n, wo, wi, lobe.roughness, lobe.eta)
            if pdf_w > 0.0:
                cos_h = dot(wo, half_refraction(n, wo, wi, lobe.eta))
                return pdf_w * (1.0 - _reflect_prob(lobe, cos_h))
        return 0.0
    if model == SHEEN:
        return pdf_sheen(n, wo, wi, lobe.f0[0], lobe.f0[1])
    if is_diffuse_like(model):
        return pdf_diffuse(n, wi)
    if model == PHONG:
        return pdf_phong(n, wo, wi, lobe.exponent)
    if model == GGX:
        return pdf_ggx(n, wo, wi, lobe.roughness)
    if model == GGX_DIELECTRIC:
        pdf_w = pdf_ggx(n, wo, wi, lobe.roughness)
        return pdf_w * _reflect_prob(lobe, dot(wo, half_reflection(wo, wi)))
    if model == ADDED_1 or model == ADDED_2:
        return pdf_added(model == ADDED_1, lobe, n, wo, wi)
    return 0.0


@kernel
def sample_lobe(
    lobe: Row, n: Vector, wo: Vector, u_event: float, u: float, v: float
) -> tuple[bool, Vector, bool]:
    """Direction from a lobe that is no delta: (possible, wi, transmitted)."""
    model = lobe.model
    if model == PHONG:
        wi = sample_phong(n, wo, lobe.exponent, u, v)
    elif model == TRANSLUCENT:
        return True, sample_translucent(n, u, v), True
    elif model == SHEEN:
        wi = sample_sheen(n, wo, lobe.f0[0], lobe.f0[1], u, v)
    elif model == GGX:
        wi = sample_ggx(n, wo, lobe.roughness, u, v)
    elif model == GGX_REFRACTION:
        wi, possible = sample_rough_refraction(n, wo, lobe.roughness, lobe.eta, u, v)
        return possible and dot(n, wi) < 0.0, wi, True
    elif model == GGX_DIELECTRIC:
        h = sample_visible_normal(n, wo, lobe.roughness, u, v)
        cos_h = dot(wo, h)
        if u_event < _reflect_prob(lobe, cos_h):
            wi = reflect(wo, h)
            return dot(n, wi) > 0.0, wi, False
        wi = refract(wo, h, lobe.eta, fresnel_dielectric(cos_h, lobe.eta)[1])
        return dot(n, wi) < 0.0, wi, True
    elif model == ADDED_1 or model == ADDED_2:
        wi = sample_added(model == ADDED_1, lobe, n, wo, u, v)
    else:
        wi = sample_diffuse(n, u, v)
    return dot(n, wi) > 0.0, wi, False


@kernel
def sample_delta(
    lobe: Row, n: Vector, wo: Vector, eta: float, u: float
) -> tuple[bool, Vector, Vector, bool]:
    """Event of a delta lobe: (possible, wi, weight per channel, transmitted).

    ``eta`` is that of the hit. The weight has no radiance factor and holds the lobe's own.
    """
    model = lobe.model
    w = lobe.weight
    cos_o = dot(n, wo)
    if model == CONDUCTOR:
        return True, reflect(wo, n), vector(w), False
    if model == GGX:
        return True, reflect(wo, n), _times(w, reflectance(lobe, cos_o), 1.0), False
    f, cos_t = fresnel_dielectric(cos_o, eta)
    total = f >= 1.0 and cos_t == 0.0
    if model == REFRACTION or model == GGX_REFRACTION:
        if total:
            return False, wo, _BLACK, True
        return True, refract(wo, n, eta, cos_t), vector(w), True
    if model == DIELECTRIC:
        if u < f:
            return True, reflect(wo, n), vector(w), False
        return True, refract(wo, n, eta, cos_t), vector(w), True
    prob = _reflect_prob(lobe, cos_o)
    if u < prob:
        return True, reflect(wo, n), _times(w, reflectance(lobe, cos_o), 1.0 / prob), False
    weight = _times(w, transmittance(lobe, cos_o), 1.0 / (1.0 - prob))
    return not total, refract(wo, n, eta, cos_t), weight, True
