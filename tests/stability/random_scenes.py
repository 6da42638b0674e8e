"""Random small scenes: every kind of surface, texture, medium, lamp and camera there is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from hypothesis import strategies as st

from photon_map.core.scene.builder import (
    SceneBuilder,
    dielectric,
    diffuse,
    mirror,
    phong,
    refraction,
    translucent,
    transparent,
)
from photon_map.core.scene.camera_data import CameraData
from photon_map.core.scene.closures import closure, factor
from photon_map.core.scene.scene import Scene
from photon_map.core.scene.tables import Channel, ClosureKind, Extension, ImageKind, Visibility
from photon_map.tests import scenes

UNIT = st.floats(0.0, 1.0)
COLOR = st.tuples(UNIT, UNIT, UNIT)
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
MORE_LOBES = st.one_of(LOBE, UNIT.map(translucent), UNIT.map(transparent))
ROUGHNESS = st.sampled_from([0.0, 1e-3, 0.2, 0.5, 1.0])
SEEN_BY = st.one_of(
    st.just(Visibility.ALL), st.integers(0, 31).map(lambda bits: Visibility(bits))
)
#: Outer numbers of textures: black, white, beyond, and none at all.
TEXEL = st.sampled_from([0.0, 0.5, 1.0, 7.0, -1.0, np.nan, np.inf])
Pick = Callable[[Any], Any]


class Small(NamedTuple):
    """A scene that prints itself in the words of its making."""

    scene: Scene
    story: list[Any]

    def __repr__(self) -> str:
        return f"Small({self.story})"


@st.composite
def small_scene(draw, plain=False):
    """A few bodies, triangles (some degenerate), lamps of all kinds, and a camera.

    ``plain`` bodies are flat and have one lobe each: they never scatter more than comes in.
    """
    story: list[Any] = []

    def pick(strategy):
        story.append(draw(strategy))
        return story[-1]

    b = SceneBuilder("random")
    textures = [] if plain else _textures(b, pick)
    for k in range(pick(st.integers(1, 4))):
        nodes = not plain and pick(st.booleans())
        row = _noded(b, k, pick, textures) if nodes else _plain(b, k, pick, plain)
        _body(b, k, pick, row, plain)
    for k in range(pick(st.integers(0, 3))):
        _lamp(b, k, pick)
    sky = pick(st.sampled_from([0.0, 0.0, 1.0]))
    picture = [[[1.0, 0.0, 2.0]] * 3, [[0.0, 1e4, 0.0]] * 3]
    b.set_world(sky, picture if not plain and pick(st.booleans()) else None)
    b.set_camera(_camera(pick))
    return Small(b.build(), story)


def _textures(b: SceneBuilder, pick: Pick) -> list[int]:
    """Uses of one small picture, or none."""
    rows = []
    for _ in range(pick(st.integers(0, 2))):
        height, width = pick(st.integers(1, 3)), pick(st.integers(1, 3))
        kind = pick(st.sampled_from(ImageKind))
        size = height * width * 4
        if kind in (ImageKind.FLOATS, ImageKind.SRGB_FLOATS):
            texels = pick(st.lists(TEXEL, min_size=size, max_size=size))
        else:
            texels = pick(st.lists(st.integers(0, 255), min_size=size, max_size=size))
        image = b.pictures.add_image(np.reshape(texels, (height, width, 4)), kind)
        rows.append(
            b.pictures.add_texture(
                image, extension=pick(st.sampled_from(Extension)),
                closest=pick(st.booleans()), unassociate=pick(st.booleans()),
            )
        )  # fmt: skip
    return rows


def _medium(pick: Pick) -> dict[str, Any]:
    """Absorption and priority of what lies behind a surface."""
    return {
        "absorption": pick(st.sampled_from([0.0, 0.0, 1.0, 1e6])),
        "priority": pick(st.integers(0, 2)),
    }


def _plain(b: SceneBuilder, k: int, pick: Pick, single: bool) -> int:
    """A material of constant lobes."""
    lobes = pick(
        st.lists(LOBE, min_size=1, max_size=1) if single else st.lists(MORE_LOBES, max_size=2)
    )
    # No more light may leave than comes in.
    lobes = [lobe.scaled(1 / len(lobes)) for lobe in lobes]
    glow = pick(st.sampled_from([0.0, 0.0, 1.0, 1e6]))
    return b.add_material(f"m{k}", lobes, emission=glow, **_medium(pick))


def _noded(b: SceneBuilder, k: int, pick: Pick, textures: list[int]) -> int:
    """A material of one or two mixed shader nodes, some of their inputs by textures."""
    row_of = st.sampled_from([-1, *textures])

    def driven(strategy: Any) -> Any:
        return (pick(strategy), pick(row_of), pick(st.sampled_from(Channel)))

    def node(factors: list[Any]) -> Any:
        kind = pick(st.sampled_from(ClosureKind))
        values = {
            "color": driven(COLOR), "roughness": driven(ROUGHNESS), "ior": pick(INDEX),
            "distribution": pick(st.integers(0, 1)),
        }  # fmt: skip
        if kind == ClosureKind.PRINCIPLED:
            values |= {name: driven(UNIT) for name in ("metallic", "transmission", "alpha")}
            names = ("coat", "coat_roughness", "sheen", "sheen_roughness", "specular_level")
            values |= {name: pick(UNIT) for name in names}
            values["diffuse_roughness"] = pick(UNIT)
        return closure(kind, factors, **values)

    if pick(st.booleans()):
        share = driven(UNIT)
        nodes = [node([_factor(share, False)]), node([_factor(share, True)])]
    else:
        nodes = [node([])]
    normal, bump = pick(row_of), pick(row_of)
    return b.add_material(
        f"m{k}", closures=nodes, normal_texture=normal, bump_texture=bump,
        normal_strength=pick(st.sampled_from([0.0, 1.0, 5.0])),
        bump_strength=pick(UNIT), bump_distance=pick(st.sampled_from([1e-3, 1.0])),
        **_medium(pick),
    )  # fmt: skip


def _factor(share: Any, invert: bool) -> Any:
    value, texture, channel = share
    row = factor(value, invert)
    row["param"]["texture"], row["param"]["channel"] = texture, int(channel)
    return row


def _body(b: SceneBuilder, k: int, pick: Pick, material: int, plain: bool) -> None:
    """A ball, a box, a triangle, a floor, or one of them spoilt; whole, flipped or shared."""
    at, kind = pick(PLACE), pick(st.integers(0, 4))
    if kind == 0:
        mesh = scenes.sphere(at, pick(st.sampled_from([1e-4, 0.3, 1.5])), 1)
    elif kind == 1:
        low, size = np.array(at), pick(st.sampled_from([1e-5, 0.5, 4.0]))
        mesh = scenes.box(low, low + (1.0, 0.7, size))
    elif kind == 2:
        mesh = np.array([pick(PLACE) for _ in range(3)]), np.array([[0, 1, 2]])
    elif kind == 3:
        mesh = scenes.plane(3.0, at[2])
    else:
        # Corners at the same place, in one line, and nowhere.
        points, faces = scenes.box(at, np.array(at) + 1.0)
        points[pick(st.integers(0, 7))] = pick(st.sampled_from([np.nan, np.inf, points[0, 0]]))
        mesh = points, np.concatenate([faces, [[0, 0, 1], [2, 2, 2]]])
    normals = scenes.sphere_normals(mesh, at) if kind == 0 and not plain else None
    faces = mesh[1][:, ::-1] if pick(st.booleans()) and normals is None else mesh[1]
    uvs = None
    if pick(st.booleans()):
        uvs = np.nan_to_num(mesh[0][faces][..., :2], posinf=0.0)
        uvs = uvs * pick(st.sampled_from([0.0, 1.0, 1e6]))
    seen = Visibility.ALL if plain else pick(SEEN_BY)
    b.add_mesh(f"o{k}", mesh[0], faces, material, normals, uvs, seen)


def _lamp(b: SceneBuilder, k: int, pick: Pick) -> None:
    """A lamp of any kind and size."""
    power = pick(st.sampled_from([1e-9, 1.0, 1e9]))
    matrix = scenes.look_at(pick(PLACE), (0.1, 0.2, 0.3))
    kind, name = pick(st.integers(0, 3)), f"l{k}"
    soft = {"soft": pick(st.integers(0, 1))}
    if kind == 0:
        b.add_point_light(name, pick(PLACE), power, pick(SIZE), pick(SEEN_BY), **soft)
    elif kind == 1:
        b.add_spot_light(name, matrix, power, pick(st.floats(0.01, 1.5)), pick(UNIT),
                         pick(SIZE), pick(SEEN_BY), size_x=pick(st.floats(0.1, 2.0)),
                         **soft)  # fmt: skip
    elif kind == 2:
        b.add_sun_light(name, matrix, power, pick(SIZE), pick(SEEN_BY))
    else:
        b.add_area_light(name, matrix, power, max(pick(SIZE), 1e-6), 0.3, pick(st.booleans()),
                         pick(SEEN_BY), spread=pick(st.floats(0.01, np.pi)))  # fmt: skip


def _camera(pick: Pick) -> CameraData:
    """Perspective or orthographic, with or without a lens, clipped or not."""
    camera = scenes.camera(pick(PLACE), (0.05, 0.0, 0.1), 5, 4, fov=1.2)
    kind = pick(st.sampled_from(["PERSPECTIVE", "ORTHOGRAPHIC"]))
    camera = replace(camera, kind=kind, ortho_scale=pick(st.sampled_from([1e-3, 3.0])))
    if pick(st.booleans()):
        camera = replace(
            camera, lens_radius=pick(SIZE), focus_distance=pick(st.sampled_from([1e-3, 2.0])),
            blades=pick(st.integers(0, 6)), blade_ratio=pick(st.sampled_from([0.5, 1.0, 2.0])),
        )  # fmt: skip
    if pick(st.booleans()):
        camera = replace(camera, clip_start=0.1, clip_end=pick(st.sampled_from([0.2, 3.0])))
    return camera
