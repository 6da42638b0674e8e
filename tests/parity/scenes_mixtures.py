"""Things together: interreflection, glass over a floor, media in each other, instances."""

from __future__ import annotations

from typing import Any

from tests.parity.case import case


def room(stage: Any) -> None:
    """An open box of coloured walls with an area lamp under its ceiling."""
    stage.camera((0.0, -3.8, 1.0), (0.0, 0.0, 1.0), lens=35.0)
    white = stage.diffuse(0.7, 0.7, 0.7)
    stage.square(white, 2.0, (0.0, 0.0, 0.0), name="Floor")
    stage.square(white, 2.0, (0.0, 0.0, 2.0), (180.0, 0.0, 0.0), name="Ceiling")
    stage.square(white, 2.0, (0.0, 1.0, 1.0), (90.0, 0.0, 0.0), name="Back")
    stage.square(stage.diffuse(0.7, 0.1, 0.1), 2.0, (-1.0, 0.0, 1.0), (0.0, 90.0, 0.0))
    stage.square(stage.diffuse(0.1, 0.6, 0.1), 2.0, (1.0, 0.0, 1.0), (0.0, -90.0, 0.0))
    stage.lamp("AREA", (0.0, 0.0, 1.98), energy=20.0, size=0.6)


@case("diffuse room: interreflection", passes=64, samples=128)
def diffuse_room(stage: Any) -> None:
    room(stage)


@case("diffuse room, a plate under its lamp, which casts no shadows", passes=64, samples=128)
def shadowless_room(stage: Any) -> None:
    room(stage)
    stage.square(stage.diffuse(0.5, 0.5, 0.5), 0.8, (0.0, 0.0, 1.3))
    stage.scene.objects["Lamp"].data.use_shadow = False


@case("room with a mirror ball and a diffuse cube", passes=64, samples=256)
def mirror_room(stage: Any) -> None:
    room(stage)
    shiny = stage.material("BsdfAnisotropic", Color=(0.9, 0.9, 0.9), Roughness=0.0)
    stage.ball(shiny, 0.4, (-0.4, 0.3, 0.45))
    stage.cube(stage.diffuse(0.6, 0.6, 0.2), 0.6, (0.4, -0.2, 0.3))


@case("room with a rough metal ball (roughness 0.4)", passes=64, samples=256)
def metal_room(stage: Any) -> None:
    room(stage)
    metal = stage.material(
        "BsdfAnisotropic", Color=(0.9, 0.8, 0.6), Roughness=0.4, distribution="GGX"
    )
    stage.ball(metal, 0.45, (0.0, 0.2, 0.5))


def floor(stage: Any) -> None:
    """A floor under one large square of light: caustics that a path tracer finds too."""
    stage.camera((0.0, -4.0, 2.5), (0.0, 0.0, 0.4))
    stage.square(stage.diffuse(0.7, 0.6, 0.5), 8.0, name="Floor")
    stage.square(stage.glow(3.0, 1.0, 0.95, 0.9), 3.0, (0.0, 0.0, 3.0), (180.0, 0.0, 0.0))


def glass(stage: Any, ior: float = 1.5, *color: float) -> Any:
    return stage.material("BsdfGlass", Color=color or (1.0, 1.0, 1.0), Roughness=0.0, IOR=ior)


@case("glass cube over a floor: refracted light and caustics", passes=64, samples=512)
def glass_over_floor(stage: Any) -> None:
    floor(stage)
    stage.cube(glass(stage), 1.0, (0.0, 0.0, 0.8))


@case("smooth-shaded diffuse ball on a floor", passes=64, samples=128)
def smooth_ball(stage: Any) -> None:
    floor(stage)
    stage.ball(stage.diffuse(0.3, 0.5, 0.7), 0.6, (0.0, 0.0, 0.7), 48, smooth=True)


@case("rough glass ball over a floor", passes=64, samples=512)
def rough_glass_over_floor(stage: Any) -> None:
    floor(stage)
    rough = stage.material(
        "BsdfGlass", Color=(1.0, 1.0, 1.0), Roughness=0.4, IOR=1.5, distribution="GGX"
    )
    stage.ball(rough, 0.6, (0.0, 0.0, 0.8), 16)


@case("glass ball inside of a hollow glass ball, an air gap between", passes=32, samples=128)
def nested_gap(stage: Any) -> None:
    from tests.parity.scenes_lobes import studio

    studio(stage)
    clear = glass(stage, 1.5)
    stage.ball(clear, 1.0)
    inner = stage.ball(clear, 0.8)
    inner.data.flip_normals()
    stage.ball(glass(stage, 1.33, 0.8, 0.9, 1.0), 0.6)


@case("absorbing glass: Volume Absorption of density 0.8", samples=256)
def absorption(stage: Any) -> None:
    from tests.parity.scenes_lobes import studio

    studio(stage)
    material, tree, surface = stage.nodes()
    body = stage.node(tree, "BsdfGlass", Color=(1.0, 1.0, 1.0), Roughness=0.0, IOR=1.4)
    tree.links.new(body.outputs[0], surface)
    inside = stage.node(tree, "VolumeAbsorption", Color=(0.8, 0.4, 0.2), Density=0.8)
    volume = surface.node.inputs["Volume"]
    tree.links.new(inside.outputs[0], volume)
    stage.ball(material)


@case("instances of a mesh: linked, scaled, mirrored and by a collection")
def instances(stage: Any) -> None:
    floor(stage)
    first = stage.cube(stage.diffuse(0.7, 0.2, 0.2), 0.5, (-1.0, 0.0, 0.4))
    second = first.copy()
    second.location, second.scale = (0.0, 0.4, 0.5), (1.0, -1.5, 0.7)
    second.rotation_euler = (0.3, 0.5, 0.2)
    stage.link(second)
    group = stage.collection_instance(first.data)
    group.location, group.scale = (1.0, -0.3, 0.5), (1.2, 0.8, 1.5)


@case("two materials on one mesh, two lamps, a dim world", passes=48, samples=128)
def two_materials(stage: Any) -> None:
    stage.camera((0.0, -4.0, 2.5), (0.0, 0.0, 0.4))
    stage.world((0.1, 0.1, 0.15))
    stage.square(stage.diffuse(0.6, 0.6, 0.6), 8.0)
    ball = stage.ball(stage.diffuse(0.8, 0.2, 0.2), 0.7, (0.0, 0.0, 0.8))
    ball.data.materials.append(stage.diffuse(0.2, 0.3, 0.8))
    for i, face in enumerate(ball.data.polygons):
        face.material_index = i % 2
    stage.lamp("AREA", (1.5, -0.5, 2.0), (0.0, 30.0, 0.0), energy=30.0, size=0.8)
    stage.lamp("SUN", rotation=(-40.0, -10.0, 0.0), energy=0.8, angle=0.1)
