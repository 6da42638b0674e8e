"""Random small scenes: finite, not negative, no crash, no hang, flux never grows."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from photon_map.core import Settings
from photon_map.core.photon_pass import Batch, trace_batch
from photon_map.core.prepared import prepare
from photon_map.core.scene.builder import (
    SceneBuilder,
    dielectric,
    diffuse,
    mirror,
    phong,
    refraction,
)
from photon_map.core.scene.scene import Scene
from photon_map.tests import scenes
from photon_map.tests.stability.support import film_of

UNIT = st.floats(0.0, 1.0)
PLACE = st.tuples(*(st.floats(-2.0, 2.0, allow_subnormal=False),) * 3)
#: Sizes over twelve decades, and nothing.
SIZE = st.one_of(st.just(0.0), st.integers(-6, 0).map(lambda k: 10.0**k))
INDEX = st.one_of(
    st.sampled_from([1.0, 1 - 1e-6, 1 + 1e-6, 1.5, 0.2, 4.0]), st.floats(0.3, 3.0)
)
LOBE = st.one_of(
    UNIT.map(diffuse),
    UNIT.map(mirror),
    st.builds(phong, UNIT, st.sampled_from([0.0, 1.0, 30.0, 1e4])),
    st.builds(dielectric, INDEX, UNIT),
    st.builds(refraction, INDEX, UNIT),
)


class Small(NamedTuple):
    """A scene that prints itself in the words of its making."""

    scene: Scene
    story: list[Any]

    def __repr__(self) -> str:
        return f"Small({self.story})"


@st.composite
def small_scene(draw, single_lobe=False):
    """A few bodies, triangles (some degenerate), lamps of all kinds, and a camera."""
    story: list[Any] = []

    def pick(strategy):
        story.append(draw(strategy))
        return story[-1]

    b = SceneBuilder("random")
    for k in range(pick(st.integers(1, 4))):
        lobes = pick(
            st.lists(LOBE, min_size=int(single_lobe), max_size=1 if single_lobe else 2)
        )
        # No more light may leave than comes in.
        lobes = [lobe.scaled(1 / len(lobes)) for lobe in lobes]
        glow = pick(st.sampled_from([0.0, 0.0, 1.0, 1e6]))
        material = b.add_material(f"m{k}", lobes, emission=glow)
        at, kind = pick(PLACE), pick(st.integers(0, 3))
        if kind == 0:
            mesh = scenes.sphere(at, pick(st.sampled_from([1e-4, 0.3, 1.5])), 1)
        elif kind == 1:
            low, size = np.array(at), pick(st.sampled_from([1e-5, 0.5, 4.0]))
            mesh = scenes.box(low, low + (1.0, 0.7, size))
        elif kind == 2:
            mesh = np.array([pick(PLACE) for _ in range(3)]), np.array([[0, 1, 2]])
        else:
            mesh = scenes.plane(3.0, at[2])
        normals = scenes.sphere_normals(mesh, at) if kind == 0 and not single_lobe else None
        faces = mesh[1][:, ::-1] if pick(st.booleans()) and normals is None else mesh[1]
        b.add_mesh(f"o{k}", mesh[0], faces, material, normals)
    for k in range(pick(st.integers(0, 3))):
        power = pick(st.sampled_from([1e-9, 1.0, 1e9]))
        matrix = scenes.look_at(pick(PLACE), (0.1, 0.2, 0.3))
        kind = pick(st.integers(0, 3))
        if kind == 0:
            b.add_point_light(f"l{k}", pick(PLACE), power, pick(SIZE))
        elif kind == 1:
            b.add_spot_light(f"l{k}", matrix, power, pick(st.floats(0.01, 1.5)),
                             pick(UNIT), pick(SIZE))  # fmt: skip
        elif kind == 2:
            b.add_sun_light(f"l{k}", matrix, power, pick(SIZE))
        else:
            b.add_area_light(f"l{k}", matrix, power, max(pick(SIZE), 1e-6), 0.3,
                             pick(st.booleans()))  # fmt: skip
    b.set_world(pick(st.sampled_from([0.0, 0.0, 1.0])))
    b.set_camera(scenes.camera(pick(PLACE), (0.05, 0.0, 0.1), 5, 4, fov=1.2))
    return Small(b.build(), story)


QUIET = settings(
    max_examples=60, deadline=None, suppress_health_check=list(HealthCheck), database=None
)


@QUIET
@given(small_scene(), st.integers(0, 1000))
def test_any_scene_gives_a_finite_picture(small, seed):
    film_of(
        small.scene, passes=2, seed=seed, photons_global=512, photons_caustic=512, threads=1
    )


@QUIET
@given(small_scene(single_lobe=True), st.booleans())
def test_the_flux_of_a_photon_never_grows(small, caustic):
    options = Settings(photon_depth=16)
    prepared = prepare(small.scene, options)
    walk = trace_batch(prepared, options, 0, Batch(caustic, 0, 256, 256))
    flux = walk.photons["flux"].astype(np.float64)
    assert np.isfinite(flux).all() and (flux >= 0).all()
    for name in ("position", "direction", "normal"):
        assert np.isfinite(walk.photons[name]).all()
    order = np.argsort(walk.order)
    path, most = walk.order[order] // options.photon_depth, flux[order].max(axis=1)
    same = path[1:] == path[:-1]
    assert (most[1:][same] <= most[:-1][same] * (1 + 1e-5)).all()
