"""The example of docs/brdf.md, added to a copy of the engine as that page says."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
PAGE = ROOT / "docs" / "brdf.md"

CHECK = """
import numpy as np
from photon_map.core.bsdf.lobe import eval_lobe, narrow_share, pdf_lobe, sample_lobe
from photon_map.core.scene.lobes import Lobe, lobe_row
from photon_map.core.scene.tables import LOBE, Model

K = 2.5
lobes = np.array([lobe_row(Lobe(Model.ADDED_1, (0.6, 0.1, 1.0), exponent=K))], LOBE)
lobe, n = lobes[0], (0.0, 0.0, 1.0)
assert narrow_share(lobe) == 0.0
generator = np.random.default_rng(5)
for angle in (0.1, 0.8, 1.3):
    wo = (np.sin(angle), 0.0, np.cos(angle))
    points = generator.random((400, 3))
    for u_event, u, v in points:
        ok, wi, transmitted = sample_lobe(lobe, n, wo, u_event, u, v)
        assert ok and not transmitted
        weight = np.array(eval_lobe(lobe, n, wo, wi)) * wi[2] / pdf_lobe(lobe, n, wo, wi)
        np.testing.assert_allclose(weight, np.array((0.6, 0.1, 1.0)) * wo[2] ** (K - 1))
        np.testing.assert_allclose(eval_lobe(lobe, n, wi, wo), eval_lobe(lobe, n, wo, wi))
    # The density is 1 over the hemisphere: midpoints in cos and phi.
    cosines, phis = (np.arange(200) + 0.5) / 200, 2 * np.pi * (np.arange(8) + 0.5) / 8
    total = 0.0
    for c in cosines:
        s = np.sqrt(1 - c * c)
        for phi in phis:
            total += pdf_lobe(lobe, n, wo, (s * np.cos(phi), s * np.sin(phi), c))
    assert abs(total * 2 * np.pi / (200 * 8) - 1) < 1e-3
other = lobes.copy()
other["model"] = int(Model.ADDED_2)
assert eval_lobe(other[0], n, n, n) == (0.0, 0.0, 0.0), "a free place reflects nothing"
print("checked")
"""

RENDER = """
import numpy as np
from photon_map.core import CameraData, SceneBuilder, Settings, render

builder = SceneBuilder("velvet")
{material}
corners = [(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)]
builder.add_mesh("floor", corners, [(0, 1, 2), (0, 2, 3)], velvet)
builder.add_point_light("lamp", (3.0, 0.0, 2.0), 5.0)
matrix = np.eye(4)
matrix[2, 3] = 4.0
# So far a lens that all pixels look at one place.
builder.set_camera(CameraData(width=3, height=3, matrix=matrix, lens=360000.0))
settings = Settings(passes=4, photons_global=0, pixel_filter="BOX")
*_, last = render(builder.build(), settings)
# Seen from straight above, 2 m below the lamp and 3 m beside it.
cosine, way2 = 2 / np.sqrt(13), 13.0
expected = np.array((0.6, 0.1, 0.2)) * 3 / (2 * np.pi) * cosine * 5.0 * cosine / way2
np.testing.assert_allclose(last.film.resolve("direct")[1, 1], expected, rtol=2e-3)
print("checked")
"""


def blocks() -> list[str]:
    return re.findall(r"```python\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)


def run_with_the_example(folder: Path, code: str) -> None:
    package = folder / "photon_map"
    package.mkdir()
    shutil.copytree(ROOT / "core", package / "core", ignore=shutil.ignore_patterns("*.pyc"))
    (package / "__init__.py").write_text("")
    file, line, _ = blocks()
    (package / "core" / "bsdf" / "minnaert.py").write_text(file, "utf-8")
    registry = package / "core" / "bsdf" / "added.py"
    text = registry.read_text("utf-8")
    assert text.count("from . import nothing as added_1\n") == 1
    registry.write_text(text.replace("from . import nothing as added_1\n", line), "utf-8")
    environment = {
        **os.environ, "PYTHONPATH": str(folder), "PHOTON_MAP_CACHE_DIR": str(folder / "cache")
    }  # fmt: skip
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=500, cwd=folder,
        env=environment,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "checked" in done.stdout


def test_the_example_scatters_as_it_says(tmp_path: Path):
    run_with_the_example(tmp_path, CHECK)


@pytest.mark.slow
def test_the_example_renders_its_closed_form(tmp_path: Path):
    run_with_the_example(tmp_path, RENDER.format(material=blocks()[2]))
