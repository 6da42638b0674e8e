"""Emitted flux is what is absorbed and what escapes; nothing is made or lost on the way."""

from __future__ import annotations

import numpy as np
import pytest

from photon_map.core import Settings
from photon_map.core.photon_pass import Batch, trace_batch
from photon_map.core.prepared import prepare
from photon_map.core.scene.builder import SceneBuilder, dielectric, diffuse, mirror, phong
from photon_map.tests import scenes

PHOTONS = 40000
#: Flux [W] that each light sends into the scene, per channel.
LIGHTS = {
    "point": lambda b: b.add_point_light("l", (0, 0, 0.5), 2.0, 0.1) or 8 * np.pi,
    "area": lambda b: b.add_area_light("l", scenes.DOWN, 3.0, 0.5, 0.4) or 0.6 * np.pi,
    "disk": lambda b: (
        b.add_area_light("l", scenes.DOWN, 3.0, 0.5, 0.4, disk=True) or 0.15 * np.pi**2
    ),
    "spot": lambda b: (
        b.add_spot_light("l", scenes.DOWN, 2.0, 0.5) or 4 * np.pi * (1 - np.cos(0.5))
    ),
}


@pytest.mark.parametrize("light", LIGHTS)
@pytest.mark.parametrize("albedo", [0.01, 0.5, 0.9])
def test_closed_box_absorbs_what_is_emitted(light, albedo):
    b = SceneBuilder("box")
    wall = b.add_material("wall", [diffuse(albedo)])
    b.add_mesh("walls", *scenes.box((-1, -1, -1), (1, 1, 1)), wall)
    flux = LIGHTS[light](b)
    b.set_camera(scenes.camera((0, 0, 0), (1, 0, 0), 4, 4))
    settings = Settings(photon_depth=400)
    prepared = prepare(b.build(), settings)
    walk = trace_batch(prepared, settings, 0, Batch(False, 0, PHOTONS, PHOTONS))
    # A photon is stored with its whole flux at each wall, 1 - albedo of which stays there.
    absorbed = (1 - albedo) * walk.photons["flux"][:, 0].sum(dtype=np.float64)
    # Without glass all photons have the same flux: walks have a geometric length.
    spread = np.sqrt(albedo / PHOTONS)
    assert absorbed == pytest.approx(flux, rel=3.3 * spread + 1e-4)


@pytest.mark.parametrize(
    "lobes", [[mirror(0.8)], [dielectric(1.5)], [phong(0.7, 20)], [diffuse(0.4), mirror(0.5)]]
)
def test_a_body_in_a_closed_room_makes_no_flux(lobes):
    """A grey room round a body: what the walls and the body absorb is what is emitted."""
    b = SceneBuilder("room")
    wall = b.add_material("wall", [diffuse(0.5)])
    body = b.add_material("body", lobes)
    b.add_mesh("walls", *scenes.box((-1, -1, -1), (1, 1, 1)), wall)
    b.add_mesh("body", *scenes.sphere((0, 0, -0.4), 0.4, 2), body)
    b.add_point_light("lamp", (0, 0, 0.5), 1.0)
    b.set_camera(scenes.camera((0, 0, 0.9), (0, 0, 0), 4, 4))
    settings = Settings(photon_depth=400)
    prepared = prepare(b.build(), settings)
    walls = []
    for i in range(16):
        walk = trace_batch(prepared, settings, i, Batch(False, 0, 4000, 4000))
        p = walk.photons["position"]
        on_wall = np.abs(np.abs(p).max(axis=1) - 1) < 1e-4
        walls.append(0.5 * walk.photons["flux"][on_wall, 0].sum(dtype=np.float64))
    absorbed, error = np.mean(walls), np.std(walls, ddof=1) / 4
    flux = 4 * np.pi
    albedo = sum(lobe.weight[0] for lobe in lobes)
    if albedo == 1.0:
        # 3.7 sigma at 15 degrees of freedom: 0.002.
        assert abs(absorbed - flux) < 3.7 * error
    else:
        assert absorbed < flux + 3.7 * error
        # The body hides a twelfth of the sphere of directions and lets the albedo through.
        assert absorbed > 0.8 * flux
    assert error < 0.01 * flux
