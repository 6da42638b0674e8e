"""Each camera option before glowing squares: only the camera can be wrong here."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

from tests.parity.case import case as any_case

#: These scenes render fast: many samples, for sharp comparisons.
case = partial(any_case, passes=256, samples=512)
COLORS = ((1.0, 0.2, 0.1), (0.2, 1.0, 0.3), (0.1, 0.3, 1.0), (1.0, 0.9, 0.2), (0.8, 0.2, 0.9))


def squares(stage: Any) -> None:
    """25 glowing squares at distances of 3 to 7 m before a dim world, camera not set."""
    stage.world((0.1, 0.12, 0.15))
    for i in range(25):
        x, z = i % 5 - 2, i // 5 - 2
        place = (x * 0.8, (i * 7 % 25) / 6.0, z * 0.8)
        glow = stage.glow(1.0 + i % 3, *COLORS[i % 5])
        stage.square(glow, 0.6, place, (90.0, 0.0, 10.0 * i))


def view(stage: Any, **values: Any) -> Any:
    squares(stage)
    return stage.camera((0.0, -3.0, 0.2), (0.0, 0.0, 0.0), **{"lens": 28.0, **values})


@case("perspective camera", quick=True)
def camera(stage: Any) -> None:
    view(stage)


@case("lens shift")
def camera_shift(stage: Any) -> None:
    view(stage, shift_x=0.2, shift_y=-0.1)


@case("sensor fit AUTO of a wide image", size=(40, 24))
def camera_wide(stage: Any) -> None:
    view(stage, shift_x=0.1)


@case("sensor fit AUTO of a high image", size=(24, 40))
def camera_high(stage: Any) -> None:
    view(stage, shift_y=0.1)


@case("sensor fit VERTICAL of a wide image", size=(40, 24))
def camera_fit_vertical(stage: Any) -> None:
    view(stage, sensor_fit="VERTICAL", sensor_height=20.0, shift_y=0.1)


@case("sensor fit HORIZONTAL of a high image", size=(24, 40))
def camera_fit_horizontal(stage: Any) -> None:
    view(stage, sensor_fit="HORIZONTAL", sensor_width=30.0, shift_x=0.1)


@case("pixel aspect 2 to 1, lens shift")
def camera_aspect(stage: Any) -> None:
    stage.scene.render.pixel_aspect_x = 2.0
    view(stage, shift_x=0.1, shift_y=0.1)


@case("camera of uneven scale")
def camera_scaled(stage: Any) -> None:
    view(stage).scale = (0.5, 2.0, 3.0)


@case("orthographic camera with shift")
def camera_ortho(stage: Any) -> None:
    view(stage, type="ORTHO", ortho_scale=4.0, shift_x=0.1)


@case("orthographic camera, wide image", size=(40, 24))
def camera_ortho_wide(stage: Any) -> None:
    view(stage, type="ORTHO", ortho_scale=4.0)


@case("clip start and end")
def camera_clip(stage: Any) -> None:
    view(stage, clip_start=3.8, clip_end=5.9)


@case("clip start and end, orthographic")
def camera_ortho_clip(stage: Any) -> None:
    view(stage, type="ORTHO", ortho_scale=4.0, clip_start=3.8, clip_end=5.9)


def blurred(stage: Any, camera: Any, **values: Any) -> None:
    dof = camera.data.dof
    dof.use_dof = True
    dof.focus_distance = 4.5
    dof.aperture_fstop = 0.08
    for key, value in values.items():
        setattr(dof, key, value)


@case("depth of field, round aperture")
def dof(stage: Any) -> None:
    blurred(stage, view(stage))


@case("depth of field, six blades, rotated")
def dof_blades(stage: Any) -> None:
    blurred(stage, view(stage), aperture_blades=6, aperture_rotation=math.radians(20.0))


@case("depth of field, three blades")
def dof_three_blades(stage: Any) -> None:
    blurred(stage, view(stage), aperture_blades=3)


@case("depth of field, aperture ratio 2")
def dof_ratio(stage: Any) -> None:
    blurred(stage, view(stage), aperture_ratio=2.0)


@case("depth of field, aperture ratio 0.5 with four rotated blades")
def dof_ratio_blades(stage: Any) -> None:
    blurred(
        stage, view(stage), aperture_ratio=0.5, aperture_blades=4,
        aperture_rotation=math.radians(30.0),
    )  # fmt: skip


@case("depth of field, focus on an object off the axis, lens shift")
def dof_object(stage: Any) -> None:
    camera = view(stage, shift_x=0.1)
    blurred(stage, camera, focus_object=stage.scene.objects["Square.007"])


@case("depth of field, orthographic")
def dof_ortho(stage: Any) -> None:
    blurred(stage, view(stage, type="ORTHO", ortho_scale=4.0), aperture_fstop=3.0)
