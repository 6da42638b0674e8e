"""White furnaces: what single scattering loses, what is given back, and never too much."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from photon_map.core.bsdf.albedo import albedo_ggx, albedo_tables, multiscatter_glass
from photon_map.core.bsdf.resolve import MOST_LOBES
from photon_map.core.scene import closures as c
from photon_map.core.scene import lobes as m
from photon_map.core.scene.tables import ClosureKind
from tests.statistics import same_means
from tests.surfaces import Resolver, albedo, of_lobes

COUNT = 20_000
ANGLES = (0.0, 45.0, 70.0, 85.0, 89.0)
#: What a table entry between its nodes, and the model of the bounces, may be off by.
GAIN = 0.006

#: Single scattering off white GGX: roughness, then what leaves at 0, 45, 70 and 85 degrees.
KEPT = {
    0.3: (0.990, 0.986, 0.955, 0.886),
    0.5: (0.916, 0.887, 0.839, 0.900),
    0.8: (0.555, 0.581, 0.673, 0.847),
    1.0: (0.306, 0.377, 0.532, 0.781),
}
#: The same for white glass of index 1.5, from outside.
KEPT_GLASS = {
    0.3: (0.999, 0.997, 0.984, 0.920),
    0.5: (0.992, 0.980, 0.937, 0.919),
    0.8: (0.949, 0.897, 0.812, 0.823),
    1.0: (0.894, 0.802, 0.709, 0.752),
}


@pytest.mark.parametrize("roughness", KEPT)
def test_loss_of_single_scattering_is_as_stated(roughness, rng):
    for k, degrees in enumerate(ANGLES[:4]):
        metal = of_lobes([m.ggx(1.0, roughness)], degrees)
        glass = Resolver(c.rough_glass(1.5, roughness, multiscatter=False))(degrees)
        for surface, stated in ((metal, KEPT), (glass, KEPT_GLASS)):
            found, variance = albedo(surface, COUNT, rng)
            same_means(found[0], variance[0], stated[roughness][k], floor=0.002)


@pytest.mark.parametrize("roughness", [0.0, 0.1, 0.3, 0.5, 0.8, 1.0])
def test_bounces_between_facets_give_back_what_is_lost(roughness, rng):
    white = {
        "glossy": c.glossy(1.0, roughness),
        "glass": c.rough_glass(1.5, roughness),
        "metal": c.principled(color=1.0, roughness=roughness, metallic=1.0),
        "plastic": c.principled(color=1.0, roughness=roughness),
        "frost": c.principled(color=1.0, roughness=roughness, transmission=1.0),
    }
    for name, closure in white.items():
        for degrees in ANGLES[:4]:
            for entering in (True, False):
                found, variance = albedo(Resolver(closure)(degrees, entering), COUNT, rng)
                excess = abs(found[0] - 1.0) - 4.0 * math.sqrt(variance[0])
                assert excess < 0.012, f"{name} {degrees} {entering}: {found[0]}"


def test_colour_deepens_with_the_bounces(rng):
    closure = c.glossy((0.9, 0.5, 0.1), 1.0)
    found, _ = albedo(Resolver(closure)(0.0), COUNT, rng)
    assert found[0] / 0.9 < 0.99 and found[2] / 0.1 < found[1] / 0.5 < found[0] / 0.9


@pytest.mark.parametrize("roughness", [0.05, 0.5, 1.0])
@pytest.mark.parametrize("sheen", [0.0, 1.0])
@pytest.mark.parametrize("coat", [0.0, 1.0])
def test_layers_of_white_return_no_more_than_came(roughness, sheen, coat, rng):
    for level in (0.0, 0.5, 1.0):
        closure = c.principled(
            color=1.0, roughness=roughness, sheen=sheen, sheen_roughness=0.3, coat=coat,
            coat_roughness=0.2, specular_level=level, diffuse_roughness=0.7,
        )  # fmt: skip
        for degrees in ANGLES:
            found, variance = albedo(Resolver(closure)(degrees), COUNT, rng)
            gain = GAIN if degrees < 89 else 4 * GAIN
            assert found.max() < 1.0 + gain + 4 * math.sqrt(variance.max()), (level, degrees)
            if sheen == 0.0 and degrees < 80:
                assert found.min() > 0.985, (level, degrees)


UNIT = st.floats(0.0, 1.0)


@settings(max_examples=100, deadline=None)
@given(
    color=st.tuples(UNIT, UNIT, UNIT), tint=st.tuples(UNIT, UNIT, UNIT), roughness=UNIT,
    metallic=UNIT, transmission=UNIT, alpha=UNIT, coat=UNIT, sheen=UNIT,
    level=UNIT, ior=st.floats(1.0, 3.0), degrees=st.floats(0.0, 89.99),
    entering=st.booleans(), around=st.sampled_from((1.0, 1.33)),
)  # fmt: skip
def test_any_principled_surface_is_finite_and_gains_nothing(
    color, tint, roughness, metallic, transmission, alpha, coat, sheen, level, ior, degrees,
    entering, around,
):  # fmt: skip
    closure = c.principled(
        color=color, roughness=roughness, metallic=metallic, transmission=transmission,
        alpha=alpha, coat=coat, coat_roughness=roughness / 2, sheen=sheen,
        sheen_roughness=roughness, specular_level=level, specular_tint=tint, ior=ior,
        coat_tint=tint,
    )  # fmt: skip
    surface = Resolver(closure)(degrees, entering, around)
    lobes = surface.lobes[: surface.row["lobe_count"]]
    assert len(lobes) <= MOST_LOBES
    for name in ("weight", "share", "roughness", "eta", "f0", "f90"):
        assert np.isfinite(lobes[name]).all(), name
    assert (lobes["weight"] >= 0).all() and (lobes["share"] > 0).all()
    found, variance = albedo(surface, 4000, np.random.default_rng(5))
    assert np.isfinite(found).all()
    gain = 2 * GAIN if degrees < 88 else 6 * GAIN
    assert (found < 1.0 + gain + 6 * np.sqrt(variance)).all(), found


@pytest.mark.parametrize("values", [
    {"color": 0.0}, {"metallic": 1.0, "color": 0.0}, {"alpha": 0.0},
    {"transmission": 1.0, "ior": 1.0}, {"ior": 1.0, "specular_level": 0.0},
    {"transmission": 1.0, "metallic": 1.0}, {"specular_level": 0.0},
])  # fmt: skip
def test_corners_of_the_parameters(values, rng):
    surface = Resolver(c.principled(roughness=0.3, **{"color": 1.0, **values}))(40.0)
    found, variance = albedo(surface, COUNT, rng)
    if values.get("metallic") == 1.0 and values.get("color") == 0.0:
        # Only Schlick's rise towards grazing is left of a black metal.
        assert 0.0 < found[0] < 0.01
    elif values == {"color": 0.0}:
        assert 0.04 < found[0] < 0.06
    else:
        same_means(found, variance, 1.0, floor=0.006)


def test_black_materials_have_no_lobes():
    black = c.closure(ClosureKind.DIFFUSE, color=0.0)
    hidden = c.closure(ClosureKind.DIFFUSE, factors=[c.factor(0.0)], color=1.0)
    assert Resolver(black, hidden)(30.0).row["lobe_count"] == 0


def test_mix_factors_multiply(rng):
    factors = [c.factor(0.25), c.factor(0.4, invert=True)]
    lower = c.closure(ClosureKind.DIFFUSE, factors, color=1.0)
    upper = c.closure(ClosureKind.TRANSLUCENT, [c.factor(0.25, invert=True)], color=0.8)
    found, variance = albedo(Resolver(lower, upper)(30.0), COUNT, rng)
    same_means(found, variance, 0.25 * 0.6 + 0.75 * 0.8, floor=1e-9)


def test_more_closures_than_rows_lose_the_last_ones():
    many = [c.principled(coat=0.5, sheen=0.5, metallic=0.5) for _ in range(8)]
    assert Resolver(*many)(30.0).row["lobe_count"] <= MOST_LOBES


def test_tables_hold_the_albedo_between_their_nodes(rng):
    tables = albedo_tables()
    for roughness in (0.07, 0.33, 0.61, 0.95):
        for degrees in (10.0, 52.0, 77.0, 88.0):
            cosine = math.cos(math.radians(degrees))
            found, variance = albedo(of_lobes([m.ggx(1.0, roughness)], degrees), COUNT, rng)
            read = albedo_ggx(tables, roughness**2, cosine)
            same_means(found[0], variance[0], read, floor=0.004)
            glass = Resolver(c.rough_glass(1.7, roughness, multiscatter=False))(degrees)
            found, variance = albedo(glass, COUNT, rng)
            read = 1.0 / multiscatter_glass(tables, roughness**2, cosine, 1.7, 1.0)
            same_means(found[0], variance[0], read, floor=0.006)
