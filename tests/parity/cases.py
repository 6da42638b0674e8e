"""All scenes of the suite, by name."""

from __future__ import annotations

from tests.parity import (
    scenes_camera,
    scenes_deviations,
    scenes_lights,
    scenes_lobes,
    scenes_mixtures,
    scenes_textures,
)
from tests.parity.case import cases_of

GROUPS = {
    "lights": cases_of(scenes_lights),
    "lobes": cases_of(scenes_lobes),
    "camera": cases_of(scenes_camera),
    "textures": cases_of(scenes_textures),
    "mixtures": cases_of(scenes_mixtures),
    "where Cycles differs": cases_of(scenes_deviations),
}
CASES = {name: case for group in GROUPS.values() for name, case in group.items()}
