"""The engine's name and version: the only place where they are written."""

from __future__ import annotations

ENGINE = "Photon Map"
VERSION = "0.1.0"
