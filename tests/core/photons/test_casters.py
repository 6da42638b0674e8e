"""Which rough glass casts caustics: all that the camera pass treats as narrow in part."""

from __future__ import annotations

import pytest

from photon_map.core.photons.casters import caster_strength
from photon_map.core.scene.builder import SceneBuilder, dielectric
from photon_map.core.scene.closures import rough_glass


def strength(ior: float, roughness: float, around: float = 0.0) -> float:
    b = SceneBuilder("casters")
    b.add_material("rough", closures=[rough_glass(ior, roughness)], ior=ior)
    if around:
        b.add_material("around", [dielectric(around)])
    return float(caster_strength(b.build())[0])


@pytest.mark.parametrize("ior", [1.1, 1.3, 1 / 1.3])
def test_rough_glass_of_a_near_index_refracts_narrowly(ior: float) -> None:
    assert 0.0 < strength(ior, 0.6) <= 1.0
    assert strength(ior, 0.6) > strength(2.4, 0.6)


def test_very_rough_glass_of_a_far_index_is_no_caster() -> None:
    assert strength(2.4, 0.8) == 0.0


def test_a_medium_of_nearly_the_same_index_around_makes_it_narrow() -> None:
    assert strength(2.4, 0.8, around=2.35) > 0.5
