"""Blender's evaluated scene to the core's frozen ``Scene``: one file per kind of data."""
