"""The scenes of the benchmark, and who renders them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import speed_caustics as caustics
import speed_rooms as rooms

from photon_map.core import Scene

LUXCORE = ("luxcore_path", "luxcore_bidir", "luxcore_vm")


@dataclass(frozen=True)
class Case:
    """One scene.

    ``peers``: engines it is compared with; ``target``: largest share of the best peer's time
    to relMSE 0.01 that was asked for; ``judge``: the engine of the reference, ``diffuse_judge``
    of its pixels that see diffuse surfaces alone, if another; ``quick``: the peers of
    ``make bench-quick``, none when the scene is not in it.
    """

    name: str
    title: str
    build: Callable[[], Scene]
    peers: tuple[str, ...]
    target: float
    judge: str
    quick: tuple[str, ...] = ()
    diffuse_judge: str = ""

    @property
    def judges(self) -> tuple[str, ...]:
        """The engines of the reference."""
        return (self.judge, self.diffuse_judge) if self.diffuse_judge else (self.judge,)


_ALL = (
    Case(
        "diffuse_box", "Diffuse box", rooms.diffuse_box,
        ("mitsuba", "cycles", "luxcore_bidir"), 1 / 2, "mitsuba", ("mitsuba",),
    ),
    Case(
        "glass_box", "Glass and mirror box", rooms.glass_box,
        ("luxcore_vm", "luxcore_path", "mitsuba", "cycles"), 1 / 8, "mitsuba", ("luxcore_vm",),
    ),
    Case(
        "point_light", "Point light and glass", caustics.point_light,
        ("luxcore_vm", "luxcore_path", "luxcore_bidir", "povray"), 1 / 8, "luxcore_finer",
        ("luxcore_path",), "mitsuba_light",
    ),
    Case(
        "nephroid", "Nephroid ring", caustics.nephroid,
        ("luxcore_vm", "luxcore_path"), 1 / 12, "luxcore_finer",
        ("luxcore_path",), "mitsuba_light",
    ),
    Case(
        "pool", "Wavy pool", caustics.pool,
        ("luxcore_path", "luxcore_vm"), 1 / 30, "luxcore_fine", ("luxcore_path",),
    ),
    Case(
        "corridor", "Corridor with lens blur", rooms.corridor,
        ("mitsuba", "cycles", "luxcore_vm"), 1 / 10, "mitsuba",
    ),
    Case(
        "magnifier", "Caustic through a magnifier", caustics.magnifier,
        ("luxcore_vm", "luxcore_path", "cycles", "mitsuba"), 1 / 40, "mitsuba",
    ),
    Case(
        "door_slit", "Room lit through a door slit", rooms.door_slit,
        ("mitsuba", "cycles"), 1 / 6, "mitsuba",
    ),
    Case(
        "many_lights", "64 lights", rooms.many_lights,
        ("mitsuba", "cycles"), 1 / 5, "mitsuba",
    ),
    Case(
        "hdri_glass", "HDRI and glass", caustics.hdri_glass,
        ("mitsuba", "cycles", "luxcore_path"), 1 / 2, "cycles",
    ),
    Case(
        "rough_glass", "Rough glass", rooms.rough_glass,
        ("mitsuba", "cycles"), 1 / 2, "mitsuba",
    ),
    Case(
        "million", "A million triangles", caustics.million,
        ("mitsuba", "cycles"), 1 / 2, "mitsuba",
    ),
)  # fmt: skip

CASES = {case.name: case for case in _ALL}
