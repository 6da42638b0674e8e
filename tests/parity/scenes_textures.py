"""Each use of an image texture, on a sheet under a sun of angle 0."""

from __future__ import annotations

from typing import Any

import numpy as np

from tests.parity.case import case


def picture(side: int = 8, low: float = 0.05, high: float = 0.95) -> Any:
    """Texels (side, side, 4) of random colours and alphas, the same in every run."""
    return np.random.default_rng(3).uniform(low, high, (side, side, 4))


def sheet(stage: Any, **texture: Any) -> tuple[Any, Any, Any]:
    """A lit sheet before the camera: its node tree, surface socket and image node."""
    stage.camera((0.0, -2.0, 3.0), (0.0, 0.0, 0.0))
    stage.lamp("SUN", rotation=(20.0, 30.0, 0.0), energy=3.0, angle=0.0)
    material, tree, surface = stage.nodes()
    stage.square(material, 3.0)
    color_space = texture.pop("color_space", "sRGB")
    pixels = texture.pop("pixels", None)
    node = stage.node(tree, "TexImage", **texture)
    node.image = stage.image(picture() if pixels is None else pixels, color_space)
    return tree, surface, node


def colored(stage: Any, **texture: Any) -> tuple[Any, Any]:
    """The image as colour of a diffuse sheet: its node tree and image node."""
    tree, surface, node = sheet(stage, **texture)
    body = stage.node(tree, "BsdfDiffuse", Color=node.outputs["Color"])
    tree.links.new(body.outputs[0], surface)
    return tree, node


def mapped(stage: Any, **texture: Any) -> None:
    """The same with coordinates from -0.5 to 1.5, turned: the image's outside is seen."""
    tree, node = colored(stage, **texture)
    where = stage.node(tree, "TexCoord")
    mapping = stage.node(tree, "Mapping", Vector=where.outputs["UV"])
    mapping.inputs["Location"].default_value = (-0.5, -0.3, 0.0)
    mapping.inputs["Rotation"].default_value = (0.0, 0.0, 0.2)
    mapping.inputs["Scale"].default_value = (2.0, 1.5, 1.0)
    tree.links.new(mapping.outputs[0], node.inputs["Vector"])


@case("sRGB image, linear interpolation")
def image_linear(stage: Any) -> None:
    colored(stage)


@case("sRGB image, closest texel")
def image_closest(stage: Any) -> None:
    colored(stage, interpolation="Closest")


@case("non-colour image")
def image_raw(stage: Any) -> None:
    colored(stage, color_space="Non-Color")


@case("image repeated by a Mapping node")
def image_repeat(stage: Any) -> None:
    mapped(stage, extension="REPEAT")


@case("image extended by a Mapping node")
def image_extend(stage: Any) -> None:
    mapped(stage, extension="EXTEND")


@case("image clipped by a Mapping node")
def image_clip(stage: Any) -> None:
    mapped(stage, extension="CLIP")


@case("image mirrored by a Mapping node, closest texel")
def image_mirror(stage: Any) -> None:
    mapped(stage, extension="MIRROR", interpolation="Closest")


@case("opaque image on Principled's base colour")
def image_base_color(stage: Any) -> None:
    pixels = picture()
    pixels[..., 3] = 1.0
    tree, surface, node = sheet(stage, pixels=pixels)
    body = stage.node(tree, "BsdfPrincipled", Base_Color=node.outputs["Color"], Roughness=0.6)
    tree.links.new(body.outputs[0], surface)


@case("image on Principled's roughness and metallic")
def image_roughness(stage: Any) -> None:
    stage.world((0.3, 0.4, 0.5))
    tree, surface, node = sheet(stage, pixels=picture(4, 0.3, 0.9), color_space="Non-Color")
    body = stage.node(
        tree, "BsdfPrincipled", Base_Color=(0.8, 0.5, 0.3), Roughness=node.outputs["Color"],
        Metallic=node.outputs["Alpha"],
    )  # fmt: skip
    tree.links.new(body.outputs[0], surface)


@case("image's alpha on Principled's alpha: sheet and its shadow")
def image_alpha(stage: Any) -> None:
    tree, surface, node = sheet(stage)
    body = stage.node(
        tree, "BsdfPrincipled", Base_Color=(0.2, 0.5, 0.8), Alpha=node.outputs["Alpha"],
        Specular_IOR_Level=0.0,
    )  # fmt: skip
    tree.links.new(body.outputs[0], surface)
    stage.square(stage.diffuse(0.7, 0.7, 0.7), 6.0, (0.0, 0.0, -0.7))


@case("image on emission, colour and strength")
def image_emission(stage: Any) -> None:
    tree, surface, node = sheet(stage)
    glow = stage.node(tree, "Emission", Color=node.outputs["Color"], Strength=2.0)
    tree.links.new(glow.outputs[0], surface)


@case("image as the factor of a Mix Shader")
def image_mix(stage: Any) -> None:
    tree, surface, node = sheet(stage)
    mix = stage.node(tree, "MixShader")
    one = stage.node(tree, "BsdfDiffuse", Color=(0.8, 0.3, 0.1))
    two = stage.node(tree, "BsdfDiffuse", Color=(0.1, 0.4, 0.8))
    tree.links.new(node.outputs["Color"], mix.inputs[0])
    tree.links.new(one.outputs[0], mix.inputs[1])
    tree.links.new(two.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], surface)


SOFTENED = (
    "Cycles softens bent normals of diffuse surfaces (Conty Estevez, Lecocq and Stein 2019) by "
    "G1 of GGX with alpha^2 = tan^2(lean) / 8; a sun at 0.6 rad on a normal that leans 26.2 "
    "degrees: G1 = 0.99647, Cycles / Lambert = 0.996474; ours is Lambert's cosine"
)


@case("normal map in tangent space, strength 0.7", deviation=SOFTENED)
def normal_map(stage: Any) -> None:
    pixels = picture(4, 0.3, 0.7)
    pixels[..., 2] = 0.9
    tree, surface, node = sheet(stage, pixels=pixels, color_space="Non-Color")
    bend = stage.node(tree, "NormalMap", Strength=0.7, Color=node.outputs["Color"])
    body = stage.node(tree, "BsdfDiffuse", Color=(0.8, 0.6, 0.4), Normal=bend.outputs[0])
    tree.links.new(body.outputs[0], surface)


@case("bump map, strength 0.6", deviation=SOFTENED)
def bump(stage: Any) -> None:
    rows, columns = np.mgrid[0:32, 0:32] / 32.0
    wave = 0.5 + 0.3 * np.sin(2 * np.pi * rows) * np.sin(4 * np.pi * columns)
    pixels = np.stack([wave, wave, wave, np.ones_like(wave)], axis=-1)
    tree, surface, node = sheet(stage, pixels=pixels, color_space="Non-Color")
    bend = stage.node(tree, "Bump", Strength=0.6, Distance=0.2, Height=node.outputs["Color"])
    body = stage.node(tree, "BsdfDiffuse", Color=(0.8, 0.6, 0.4), Normal=bend.outputs[0])
    tree.links.new(body.outputs[0], surface)
