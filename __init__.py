"""Photon Map: a photon-mapping render engine, as a Blender extension and a Python package.

Nothing is imported here at module level, so ``photon_map.core`` works without Blender.
"""


def register() -> None:
    """Register the add-on with the running Blender."""
    from . import addon

    addon.register()


def unregister() -> None:
    """Take the add-on out of the running Blender."""
    from . import addon

    addon.unregister()
