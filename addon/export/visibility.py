"""Which rays see an object: its own switches, those of its collections, and its caustics.

Also whether the camera sees a hole in its place.
"""

from __future__ import annotations

from typing import Any

from ...core.scene.tables import Visibility

_SWITCHES = {
    "visible_camera": Visibility.CAMERA,
    "visible_diffuse": Visibility.DIFFUSE,
    "visible_glossy": Visibility.GLOSSY,
    "visible_transmission": Visibility.TRANSMISSION,
    "visible_shadow": Visibility.SHADOW,
}


def object_visibility(obj: Any, layer: Any = None, parent: Any = None) -> Visibility:
    """The rays that see ``obj``, a surface or the shape of a lamp.

    ``layer``: the evaluated view layer; a collection that is "indirect only" there hides
    what it holds from the camera, one that is held out cuts a hole there, as the object's
    own switch does. ``parent``: the object that shows ``obj`` as an instance; it is that
    one's holdout which counts.
    """
    seen = Visibility(0)
    for name, bit in _SWITCHES.items():
        if getattr(obj, name):
            seen |= bit
    if layer is not None and obj.indirect_only_get(view_layer=layer):
        seen &= ~Visibility.CAMERA
    if layer is not None and (parent or obj).holdout_get(view_layer=layer):
        seen |= Visibility.HOLDOUT
    own = obj.photon_map
    if not own.casts_caustics:
        seen |= Visibility.CASTS_NONE
    if not own.shows_caustics:
        seen |= Visibility.SHOWS_NONE
    return seen
