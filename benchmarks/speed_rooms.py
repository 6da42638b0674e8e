"""Scenes lit by area lamps in rooms."""

from __future__ import annotations

import numpy as np
from speed_shapes import (
    BLUE,
    GAP,
    GREEN,
    RED,
    SIZE,
    WHITE,
    add_ceiling_lamp,
    add_room,
    ball,
    box,
    camera,
)

from photon_map.core import Scene, SceneBuilder
from photon_map.core.scene.closures import rough_glass as rough_glass_closure
from photon_map.core.scene.lobes import dielectric, diffuse, mirror


def cornell(name: str) -> SceneBuilder:
    """The box: 2 m wide, open to the camera, with its lamp in the ceiling."""
    b = SceneBuilder(name)
    white = b.add_material("white", [diffuse(WHITE)])
    walls = {"floor": white, "ceiling": white, "back": white}
    walls |= {
        "left": b.add_material("red", [diffuse(RED)]),
        "right": b.add_material("green", [diffuse(GREEN)]),
    }
    add_room(b, (-1, -1, -1), (1, 1, 1), walls)
    add_ceiling_lamp(b, (0, 0, 1), 0.6, 0.6, 12.0)
    b.set_camera(camera((0, -4.9, 0), (0, 0, 0), SIZE, SIZE, fov=np.radians(27)))
    return b


def turned(mesh: tuple, angle: float, place: tuple[float, float, float]) -> tuple:
    """A mesh turned by ``angle`` degrees about z, then moved to ``place``."""
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    points = mesh[0] @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    return points + np.asarray(place), mesh[1]


def diffuse_box() -> Scene:
    """Cornell's box with two white blocks."""
    b = cornell("diffuse box")
    white = b.add_material("blocks", [diffuse(WHITE)])
    low, high = box((-0.3, -0.3, 0), (0.3, 0.3, 0.6)), box((-0.3, -0.3, 0), (0.3, 0.3, 1.2))
    b.add_mesh("low", *turned(low, -17, (0.35, -0.35, -1 + GAP)), white)
    b.add_mesh("high", *turned(high, 18, (-0.35, 0.35, -1 + GAP)), white)
    return b.build()


def glass_box() -> Scene:
    """Cornell's box with a glass and a mirror sphere."""
    b = cornell("glass box")
    glass = b.add_material("glass", [dielectric(1.5)])
    silver = b.add_material("silver", [mirror(0.9)])
    b.add_mesh("glass ball", *ball((0.42, -0.35, -0.6), 0.39), glass)
    b.add_mesh("mirror ball", *ball((-0.45, 0.3, -0.6), 0.39), silver)
    return b.build()


def rough_glass() -> Scene:
    """Cornell's box with a ball of frosted glass."""
    b = cornell("rough glass")
    frosted = rough_glass_closure(1.5, 0.3, multiscatter=False)
    b.add_mesh(
        "ball", *ball((0.1, -0.2, -0.5), 0.48), b.add_material("frost", closures=[frosted])
    )
    return b.build()


def corridor() -> Scene:
    """A corridor with a mirror at its end, glass in the middle, and a wide open lens."""
    b = SceneBuilder("corridor with lens blur")
    white = b.add_material("white", [diffuse(WHITE)])
    walls = {
        "floor": white, "ceiling": white, "front": b.add_material("blue", [diffuse(BLUE)]),
        "left": b.add_material("red", [diffuse(RED)]),
        "right": b.add_material("green", [diffuse(GREEN)]),
    }  # fmt: skip
    low, high = (-1.2, -1.2, 0.0), (1.2, 4.7, 2.2)
    add_room(b, low, high, walls)
    silver = b.add_material("silver", [mirror(0.9)])
    add_room(b, low, high, {"back": silver})
    glass = b.add_material("glass", [dielectric(1.5)])
    b.add_mesh("glass ball", *ball((-0.5, 1.7, 0.4 + GAP), 0.4), glass)
    b.add_mesh("mirror ball", *ball((0.6, 2.6, 0.35 + GAP), 0.35), silver)
    block = box((-0.2, -0.2, 0), (0.2, 0.2, 0.5))
    b.add_mesh("block", *turned(block, 25, (0.55, 0.9, GAP)), white)
    add_ceiling_lamp(b, (0, 1.2, 2.2), 0.35, 0.35, 22.0)
    add_ceiling_lamp(b, (0, 3.4, 2.2), 0.35, 0.35, 22.0)
    b.set_camera(
        camera(
            (0, -0.9, 1.25), (0, 3.0, 0.86), SIZE, SIZE, fov=np.radians(60),
            lens_radius=0.05, focus_distance=2.6,
        )
    )  # fmt: skip
    return b.build()


def many_lights() -> Scene:
    """64 small lamps of many colours and powers over blocks in a closed hall.

    The camera sees none of them: pixels that a lamp touches would drown all the rest.
    """
    b = SceneBuilder("64 lights")
    white = b.add_material("white", [diffuse(WHITE)])
    add_room(
        b, (-3, -3, 0), (3, 3, 2),
        dict.fromkeys(("floor", "ceiling", "back", "left", "right", "front"), white),
    )  # fmt: skip
    for i in range(5):
        block = box((-0.22, -0.22, 0), (0.22, 0.22, 0.35 + 0.2 * i))
        place = (-1.9 + 0.95 * i, 0.8 - 0.5 * (i % 2), GAP)
        b.add_mesh(f"block {i}", *turned(block, 23 * i, place), white)
    random = np.random.default_rng(64)
    for i in range(64):
        x, y = -2.6 + 5.2 * (i % 8) / 7, -2.6 + 5.2 * (i // 8) / 7
        radiance = random.uniform(0.1, 1.0, 3) * 10.0 ** random.uniform(1.0, 2.5)
        add_ceiling_lamp(b, (x, y, 2), 0.06, 0.06, radiance)
    b.set_camera(camera((0, -2.8, 1.6), (0, 0.4, 0.3), SIZE, SIZE, fov=np.radians(50)))
    return b.build()


def door_slit() -> Scene:
    """A room whose only light comes through the slit of a door from the next one."""
    b = SceneBuilder("door slit")
    white = b.add_material("white", [diffuse(WHITE)])
    low, high = (-1.5, -1.5, 0), (4.0, 1.5, 2.2)
    sides = dict.fromkeys(("floor", "ceiling", "front", "back", "right"), white)
    add_room(b, low, high, sides | {"left": b.add_material("warm", [diffuse((0.7, 0.5, 0.3))])})
    # A wall of 10 cm with a door of 65 cm that leaves 37 cm open.
    b.add_mesh("wall", *box((1.5, -1.6, -0.1), (1.6, -0.4, 2.3)), white)
    b.add_mesh("wall 2", *box((1.5, 0.62, -0.1), (1.6, 1.6, 2.3)), white)
    b.add_mesh("lintel", *box((1.5, -0.4, 2.0), (1.6, 0.62, 2.3)), white)
    door = box((0.0, -0.65, 0.005), (0.05, 0.0, 1.995))
    b.add_mesh("door", *turned(door, 0, (1.525, 0.25, 0)), white)
    b.add_mesh("table", *box((-0.6, -0.3, 0.45), (0.4, 0.5, 0.5)), white)
    b.add_mesh("globe", *ball((-0.1, 0.1, 0.7), 0.2, 4), b.add_material("red", [diffuse(RED)]))
    add_ceiling_lamp(b, (2.8, 0, 2.2), 0.6, 0.6, 400.0)
    b.set_camera(camera((-1.2, -1.3, 1.4), (1.0, 0.5, 0.7), SIZE, SIZE, fov=np.radians(75)))
    return b.build()
