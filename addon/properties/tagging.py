"""Tells Blender that an ID has changed when a script sets one of our properties.

Edits in the interface do so by themselves. Without, evaluated copies keep the old value.
"""

from __future__ import annotations

from typing import Any


def tag_owner(properties: Any, _context: Any) -> None:
    """Have the ID that ``properties`` belong to evaluated anew: an update of a property."""
    properties.id_data.update_tag()
