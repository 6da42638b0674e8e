"""A scene made ready for its passes: centred, committed to Embree, lights weighed."""

from __future__ import annotations

from threading import Event
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .bsdf.dispatch import smooth_glass
from .bsdf.resolve import MOST_LOBES
from .camera.perspective import CameraTables, camera_tables
from .camera_pass.first_hit_tables import FirstHitTables
from .camera_pass.guide import Guide, no_guide
from .film.filters import filter_table
from .geometry.intersector import Intersector
from .geometry.media import STACK, enclosing_media
from .geometry.mesh import Centre, Mesh, centre_of, centred_mesh
from .geometry.touching import overlapped
from .lights.light_set import LightSet, light_set
from .photons.aim import Aim, aim_at
from .photons.casters import receiver_materials
from .photons.focus import Focus, no_focus
from .scene.alike import alike
from .scene.scene import Scene, SceneError
from .scene.tables import LOBE, Visibility
from .settings import Settings
from .textures.shading import ShadingTables, shading_tables

#: What a scene's mesh hangs on, beside which materials refract.
_FACES = (
    "vertices", "faces", "corner_normals", "face_material", "face_object", "object_visibility",
)  # fmt: skip


class Prepared(NamedTuple):
    """What every pass reads; nothing in it changes during a render.

    ``light_media`` (N+2, 1 + STACK) i4 and ``camera_media`` (1 + STACK,): count and rows
    of the media that the light or the camera stands in. ``receivers`` (M,) bool: the
    materials that photons are stored on; ``glass`` (M,) those that camera paths may split at.
    ``first_hits``: None when no layer needs it
    ``focus``: where photons crowd, ``guide``: where indirect light comes from, once known.
    ``face_object`` (F,) i4.
    """

    mesh: Mesh
    face_object: NDArray[np.int32]
    centre: Centre
    materials: NDArray[np.void]
    lobes: NDArray[np.void]
    lights: LightSet
    light_media: NDArray[np.int32]
    camera: CameraTables
    camera_media: NDArray[np.int32]
    aim: Aim
    intersector: Intersector
    shading: ShadingTables
    has_sieves: bool
    receivers: NDArray[np.bool_]
    glass: NDArray[np.bool_]
    first_hits: FirstHitTables | None = None
    focus: Focus = no_focus()
    guide: Guide = no_guide()

    def lobe_room(self, surfaces: int) -> NDArray[np.void]:
        """The lobe table, with room behind it for those worked out at ``surfaces`` hits.

        There is always room for two more. Scenes whose materials are all constant need none.
        """
        if len(self.shading.closures) == 0:
            return self.lobes
        table = np.empty(len(self.lobes) + (surfaces + 2) * MOST_LOBES, LOBE)
        table[: len(self.lobes)] = self.lobes
        return table


def prepare(
    scene: Scene,
    settings: Settings,
    stop: Event | None = None,
    like: tuple[Scene, Prepared] | None = None,
) -> Prepared:
    """Build the tables and the ray tracer of ``scene``; raises ``SceneError``.

    Setting ``stop`` later ends all work on rays (``Intersector``). ``like``: another scene and
    what was made of it, whose mesh is taken where the faces are the same.
    """
    if scene.camera is None:
        raise SceneError(
            f"scene '{scene.name}' has no camera: add one and make it the scene's camera"
        )
    centre, mesh, intersector = _traced_mesh(scene, stop, like)
    lights = light_set(scene, mesh, centre)
    materials = scene.materials.copy()
    light_media = np.zeros((len(lights.power), 1 + STACK), np.int32)
    for entry in range(len(scene.lights)):
        if not lights.distant[entry]:
            light_media[entry] = _media_at(intersector, mesh, materials, lights.place[entry])
    camera, camera_media = _seen_from(scene, settings, centre, intersector, mesh, materials)
    return Prepared(
        mesh=mesh,
        face_object=scene.face_object,
        centre=centre,
        materials=materials,
        lobes=scene.lobes.copy(),
        lights=lights,
        light_media=light_media,
        camera=camera,
        camera_media=camera_media,
        aim=aim_at(scene, mesh, lights),
        intersector=intersector,
        shading=shading_tables(scene),
        has_sieves=_has_sieves(scene, mesh),
        receivers=receiver_materials(scene),
        glass=smooth_glass(materials, scene.lobes),
        first_hits=_first_hits(scene, settings, centre),
    )


def _traced_mesh(
    scene: Scene, stop: Event | None, like: tuple[Scene, Prepared] | None
) -> tuple[Centre, Mesh, Intersector]:
    """The centred faces of ``scene``, in Embree; those of ``like`` if they are the same."""
    refracts = scene.materials["ior"] > 0
    if like is not None:
        other, made = like
        same = np.array_equal(refracts, other.materials["ior"] > 0)
        if same and alike(scene, other, _FACES):
            return made.centre, made.mesh, made.intersector.stopped_by(stop)
    centre = centre_of(scene)
    mesh = overlapped(centred_mesh(scene, centre), scene.face_object, refracts)
    return centre, mesh, Intersector(mesh, stop)


def with_camera(
    prepared: Prepared, scene: Scene, settings: Settings, stop: Event | None = None
) -> Prepared:
    """``prepared``, of the same scene with another camera or other settings, for ``scene``."""
    intersector = prepared.intersector.stopped_by(stop)
    camera, camera_media = _seen_from(
        scene, settings, prepared.centre, intersector, prepared.mesh, prepared.materials
    )
    first_hits = _first_hits(scene, settings, prepared.centre)
    return prepared._replace(
        intersector=intersector, camera=camera, camera_media=camera_media, first_hits=first_hits
    )


def _first_hits(scene: Scene, settings: Settings, centre: Centre) -> FirstHitTables | None:
    if not settings.first_hit and not settings.aovs:
        return None
    return FirstHitTables.of(scene, centre.origin, settings.aovs)


def _seen_from(
    scene: Scene,
    settings: Settings,
    centre: Centre,
    intersector: Intersector,
    mesh: Mesh,
    materials: NDArray[np.void],
) -> tuple[CameraTables, NDArray[np.int32]]:
    """The camera's tables, and the media that it stands in."""
    assert scene.camera is not None
    camera = camera_tables(
        scene.camera, centre, filter_table(settings.pixel_filter, settings.filter_width)
    )
    return camera, _media_at(intersector, mesh, materials, camera.position)


def _media_at(
    intersector: Intersector,
    mesh: Mesh,
    materials: NDArray[np.void],
    point: NDArray[np.float64],
) -> NDArray[np.int32]:
    """Count and rows of the media around ``point``."""
    row = np.zeros(1 + STACK, np.int32)
    if len(materials) and bool((materials["ior"] > 0).any()):
        inside = enclosing_media(intersector, mesh, materials, point)
        row[0] = len(inside)
        row[1 : 1 + len(inside)] = inside
    return row


def _has_sieves(scene: Scene, mesh: Mesh) -> bool:
    """Whether some face lets a shadow ray through."""
    if len(mesh.visible) == 0:
        return False
    hidden = bool(((mesh.visible & int(Visibility.SHADOW)) == 0).any())
    return hidden or bool((scene.materials["passes"][mesh.material] != 0).any())
