"""Each kind of lamp and each of its options over a floor with a black shade above it."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np

from tests.parity.case import case as any_case

#: Light comes straight from the lamps: hardly a photon is needed.
case = partial(any_case, photons=1024)

FLOOR = (0.8, 0.5, 0.3)


def floor(stage: Any) -> None:
    """Camera, floor and a black square in mid-air: direct light and its shadows alone."""
    stage.camera()
    stage.square(stage.diffuse(*FLOOR), 12.0, name="Floor")
    stage.square(stage.diffuse(0.0, 0.0, 0.0), 0.8, (0.3, 0.2, 0.7), name="Shade")


@case("point lamp of radius 0", quick=True)
def point(stage: Any) -> None:
    floor(stage)
    stage.lamp("POINT", energy=100.0, shadow_soft_size=0.0, color=(1.0, 0.8, 0.6))


@case("point lamp of radius 0.5 m as a sphere (soft falloff off)")
def point_sphere(stage: Any) -> None:
    floor(stage)
    stage.lamp("POINT", energy=100.0, shadow_soft_size=0.5, use_soft_falloff=False)


@case("point lamp of radius 0.5 m with soft falloff")
def point_soft_falloff(stage: Any) -> None:
    floor(stage)
    stage.lamp("POINT", energy=100.0, shadow_soft_size=0.5, use_soft_falloff=True)


@case("floor inside of a soft point lamp's radius")
def point_soft_inside(stage: Any) -> None:
    floor(stage)
    stage.lamp(
        "POINT", (0.0, 0.0, 0.5), energy=50.0, shadow_soft_size=1.0, use_soft_falloff=True
    )


@case("point lamp with normalize off")
def point_unnormalized(stage: Any) -> None:
    floor(stage)
    stage.lamp(
        "POINT", energy=10.0, shadow_soft_size=0.4, normalize=False, use_soft_falloff=False
    )


@case("spot of radius 0, blend 0.3", quick=True)
def spot(stage: Any) -> None:
    floor(stage)
    stage.lamp(
        "SPOT", (0.3, 0.0, 2.0), (10.0, 5.0, 0.0), energy=100.0, shadow_soft_size=0.0,
        spot_size=math.radians(70.0), spot_blend=0.3,
    )  # fmt: skip


@case("spot with blend 0: a hard cone")
def spot_hard(stage: Any) -> None:
    floor(stage)
    stage.lamp(
        "SPOT", energy=100.0, shadow_soft_size=0.0, spot_size=math.radians(60.0), spot_blend=0.0
    )


@case("spot with blend 1 and radius 0.3 m, soft falloff off")
def spot_sphere(stage: Any) -> None:
    floor(stage)
    stage.lamp(
        "SPOT", energy=100.0, shadow_soft_size=0.3, spot_size=math.radians(80.0),
        spot_blend=1.0, use_soft_falloff=False,
    )  # fmt: skip


@case("spot of radius 0.3 m with soft falloff")
def spot_soft_falloff(stage: Any) -> None:
    floor(stage)
    stage.lamp(
        "SPOT", energy=100.0, shadow_soft_size=0.3, spot_size=math.radians(80.0),
        spot_blend=0.5, use_soft_falloff=True,
    )  # fmt: skip


@case("spot of uneven scale: an elliptic cone")
def spot_scaled(stage: Any) -> None:
    floor(stage)
    lamp = stage.lamp(
        "SPOT", energy=100.0, shadow_soft_size=0.0, spot_size=math.radians(70.0), spot_blend=0.2
    )
    lamp.scale = (2.0, 1.0, 1.0)


@case("sun of angle 0", quick=True)
def sun(stage: Any) -> None:
    floor(stage)
    stage.lamp("SUN", rotation=(30.0, 20.0, 0.0), energy=2.0, angle=0.0)


@case("sun of angle 30 degrees")
def sun_wide(stage: Any) -> None:
    floor(stage)
    stage.lamp("SUN", rotation=(30.0, 20.0, 0.0), energy=2.0, angle=math.radians(30.0))


@case("sun of 20 degrees with normalize off")
def sun_unnormalized(stage: Any) -> None:
    floor(stage)
    stage.lamp(
        "SUN", rotation=(30.0, 0.0, 0.0), energy=9.0, angle=math.radians(20.0), normalize=False
    )


def area(stage: Any, shape: str, **values: Any) -> Any:
    floor(stage)
    values = {"size": 1.0, "energy": 80.0, **values}
    return stage.lamp("AREA", (0.0, 0.3, 1.8), (15.0, -10.0, 20.0), shape=shape, **values)


@case("square area lamp", quick=True)
def area_square(stage: Any) -> None:
    area(stage, "SQUARE")


@case("rectangular area lamp of uneven object scale")
def area_rectangle(stage: Any) -> None:
    area(stage, "RECTANGLE", size=1.5, size_y=0.5).scale = (1.0, 2.0, 1.0)


@case("disk area lamp")
def area_disk(stage: Any) -> None:
    area(stage, "DISK")


@case("elliptic area lamp")
def area_ellipse(stage: Any) -> None:
    area(stage, "ELLIPSE", size=1.6, size_y=0.6)


@case("square area lamp of spread 60 degrees")
def area_spread(stage: Any) -> None:
    area(stage, "SQUARE", spread=math.radians(60.0))


@case("disk area lamp of spread 150 degrees")
def area_spread_disk(stage: Any) -> None:
    area(stage, "DISK", spread=math.radians(150.0))


@case("area lamp with normalize off")
def area_unnormalized(stage: Any) -> None:
    area(stage, "SQUARE", energy=20.0, normalize=False)


@case("area lamp that faces away and shows its dark back")
def area_back(stage: Any) -> None:
    stage.world((0.2, 0.2, 0.2))
    area(stage, "SQUARE").visible_camera = True


@case("exposure of 1.5 stops")
def exposure(stage: Any) -> None:
    floor(stage)
    stage.lamp("POINT", energy=30.0, shadow_soft_size=0.0, exposure=1.5)


@case("colour temperature of 3200 K, and a tint")
def temperature(stage: Any) -> None:
    floor(stage)
    stage.lamp(
        "POINT", energy=100.0, shadow_soft_size=0.0, use_temperature=True, temperature=3200.0,
        color=(0.9, 1.0, 0.7),
    )  # fmt: skip


@case("Emission node in the lamp: colour times strength")
def lamp_nodes(stage: Any) -> None:
    floor(stage)
    light = stage.lamp("POINT", energy=30.0, shadow_soft_size=0.0).data
    light.use_nodes = True
    node = light.node_tree.nodes["Emission"]
    node.inputs["Color"].default_value = (0.4, 0.9, 0.6, 1.0)
    node.inputs["Strength"].default_value = 3.0


@case("lamps that the camera sees: sphere, square and disk")
def lamps_in_view(stage: Any) -> None:
    floor(stage)
    for kind, x, values in (
        ("POINT", -1.0, {"shadow_soft_size": 0.4, "use_soft_falloff": False}),
        ("AREA", 0.0, {"shape": "SQUARE", "size": 0.6}),
        ("AREA", 1.0, {"shape": "DISK", "size": 0.6}),
    ):
        lamp = stage.lamp(kind, (x, 0.8, 0.8), (60.0, 0.0, 0.0), energy=8.0, **values)
        lamp.visible_camera = True


@case("lamp that camera and glossy rays do not see, before a mirror")
def lamp_hidden(stage: Any) -> None:
    floor(stage)
    mirror = stage.material("BsdfGlossy", Color=(0.9, 0.9, 0.9), Roughness=0.0)
    stage.square(mirror, 3.0, (0.0, 1.5, 1.0), (80.0, 0.0, 0.0))
    for x, seen in ((-0.6, False), (0.6, True)):
        lamp = stage.lamp("AREA", (x, 0.2, 1.5), energy=10.0, size=0.6)
        lamp.visible_glossy = seen


@case("object without visible_shadow: light goes through it")
def object_no_shadow(stage: Any) -> None:
    floor(stage)
    stage.scene.objects["Shade"].visible_shadow = False
    stage.lamp("AREA", (0.0, 0.0, 2.0), energy=80.0, size=0.5)


@case("object without visible_camera: only its shadow is seen")
def object_no_camera(stage: Any) -> None:
    floor(stage)
    stage.scene.objects["Shade"].visible_camera = False
    stage.lamp("AREA", (0.0, 0.0, 2.0), energy=80.0, size=0.5)


@case("emissive square", quick=True)
def mesh_square(stage: Any) -> None:
    floor(stage)
    stage.square(stage.glow(10.0, 1.0, 0.9, 0.7), 1.0, (0.0, 0.3, 1.8), (195.0, 10.0, 0.0))


@case("two emissive balls of different radiance")
def mesh_balls(stage: Any) -> None:
    floor(stage)
    stage.ball(stage.glow(10.0, 1.0, 0.9, 0.7), 0.3, (-0.7, 0.3, 0.9), 12)
    stage.ball(stage.glow(1.0, 0.4, 0.6, 1.0), 0.5, (0.9, -0.3, 0.8), 12)


@case("world of one colour over floor and shade", quick=True)
def world_color(stage: Any) -> None:
    floor(stage)
    stage.world((0.5, 0.7, 1.0), 1.5)


def sky(height: int = 16) -> Any:
    """A dim gradient with a bright patch, (h, 2h, 4)."""
    pixels = np.zeros((height, 2 * height, 4), np.float32)
    rows = np.linspace(0.2, 1.0, height)[:, None, None]
    pixels[..., :3] = rows * np.array([0.4, 0.6, 1.0])
    pixels[10:13, 5:9, :3] = (30.0, 25.0, 18.0)
    pixels[..., 3] = 1.0
    return pixels


@case("HDRI world with a bright patch")
def world_image(stage: Any) -> None:
    floor(stage)
    tree = stage.world((0.0, 0.0, 0.0))
    node = stage.node(tree, "TexEnvironment")
    node.image = stage.image(sky(), "Linear Rec.709", ".exr")
    tree.links.new(node.outputs[0], tree.nodes["Background"].inputs["Color"])


@case("HDRI world turned by a Mapping node, seen by the camera and in a mirror")
def world_image_turned(stage: Any) -> None:
    floor(stage)
    mirror = stage.material("BsdfGlossy", Color=(0.9, 0.9, 0.9), Roughness=0.0)
    stage.square(mirror, 2.0, (0.0, 0.3, 0.4), (20.0, 10.0, 0.0))
    tree = stage.world((0.0, 0.0, 0.0))
    node = stage.node(tree, "TexEnvironment")
    node.image = stage.image(sky(), "Linear Rec.709", ".exr")
    where = stage.node(tree, "TexCoord")
    mapping = stage.node(tree, "Mapping", Vector=where.outputs["Generated"])
    mapping.inputs["Rotation"].default_value = (0.0, 0.0, 1.2)
    tree.links.new(mapping.outputs[0], node.inputs["Vector"])
    tree.links.new(node.outputs[0], tree.nodes["Background"].inputs["Color"])


@case("fifty point lamps of many powers and colours", samples=128)
def many_lamps(stage: Any) -> None:
    floor(stage)
    random = np.random.default_rng(5)
    for _ in range(50):
        x, y, z, energy = random.random(4)
        stage.lamp(
            "POINT", (4 * x - 2, 4 * y - 2, 0.5 + 2 * z), energy=float(10 ** (2 * energy - 1)),
            shadow_soft_size=0.0, color=tuple(map(float, random.random(3))),
        )  # fmt: skip
