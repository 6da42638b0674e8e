"""What is wrong with a scene; apart from it, to be caught without loading NumPy."""

from __future__ import annotations


class SceneError(ValueError):
    """A scene that cannot be rendered; the message names the object and what to do."""
