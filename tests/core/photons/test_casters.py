"""Which surfaces cast caustics: what caustic photons follow in part."""

from __future__ import annotations

import pytest

from photon_map.core.photons.casters import caster_strength, receiver_materials
from photon_map.core.scene.builder import SceneBuilder
from photon_map.core.scene.closures import glossy, principled, rough_glass


def scene_of(closure):
    b = SceneBuilder("casters")
    b.add_material("tested", closures=[closure])
    return b.build()


def strength(closure) -> float:
    return float(caster_strength(scene_of(closure))[0])


@pytest.mark.parametrize("roughness", [0.0, 0.2, 0.6, 1.0])
def test_mirrors_and_glass_cast_caustics_however_rough_they_are(roughness: float) -> None:
    assert strength(rough_glass(1.1, roughness)) == strength(rough_glass(2.4, 0.0)) > 0.0
    assert strength(glossy(0.8, roughness)) == pytest.approx(0.8)
    assert strength(principled(metallic=1.0, color=0.5, roughness=roughness)) > 0.4


def test_a_coat_is_a_caster_while_it_is_sharp() -> None:
    values = [strength(principled(roughness=r)) for r in (0.0, 0.2, 0.4, 0.5)]
    assert values == sorted(values, reverse=True)
    assert values[0] > 0.03 and values[-1] == 0.0


def test_rough_mirrors_and_glass_show_caustics() -> None:
    for closure in (rough_glass(1.5, 0.5), glossy(0.8, 0.5), principled()):
        assert receiver_materials(scene_of(closure))[0]
    assert not receiver_materials(scene_of(glossy(0.8, 0.0)))[0]
