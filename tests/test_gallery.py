"""docs/gallery.md is what its renders said, and lacks nothing that the report showed."""

from __future__ import annotations

import importlib
import json
import re
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[1]
SAMPLES = ROOT / "sample_blends"
#: What is drawn from several renders, and the sample that it is drawn of.
FIGURES = {"normalisation": "caustic_sphere", "lens": "lens_blur"}


@pytest.fixture
def gallery(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(str(SAMPLES))
    return importlib.import_module("gallery")


@pytest.fixture
def pictures(gallery: Any) -> dict[str, Any]:
    sections = (*gallery.REPORT, *gallery.BEYOND)
    return {picture.name: picture for section in sections for picture in section.pictures}


def test_the_page_is_what_the_renders_said(gallery: Any, pictures: dict[str, Any]):
    stored = json.loads(gallery.RENDERS.read_text("utf-8"))
    assert set(stored) == {*pictures, *FIGURES}
    results = {name: gallery.Result(**row) for name, row in stored.items()}
    page = (ROOT / "docs" / "gallery.md").read_text("utf-8")
    assert page == gallery.document(results)
    shown = re.findall(r"\]\(gallery/(\w+)\.png\)", page)
    assert sorted(shown) == sorted(stored)
    assert all((gallery.DOCS / f"{name}.png").is_file() for name in shown)
    told = re.findall(r"\d+ passes, \d+ s, error \d+\.\d %", page)
    assert len(told) == len(stored), "a picture lacks its time or its error"


def test_each_picture_has_its_sample_and_each_sample_its_picture(pictures: dict[str, Any]):
    used = {picture.sample for picture in pictures.values()} | set(FIGURES.values())
    assert used == {path.stem for path in SAMPLES.glob("*.blend")}
    scripts = {path.stem for path in (SAMPLES / "scripts").glob("*.py")}
    assert used == scripts - {"common"}
    words = (SAMPLES / "README.md").read_text("utf-8")
    assert all(f"`{name}.blend`" in words for name in used)


def test_the_figures_of_the_report_are_there(gallery: Any, pictures: dict[str, Any]):
    assert gallery.gallery_figures.FIGURES.keys() == FIGURES.keys()
    of_the_report = {picture.name for section in gallery.REPORT for picture in section.pictures}
    assert of_the_report == {
        "fresnel_without", "fresnel_with", "photons_0", "photons_15000", "corridor_draft",
        "corridor_final", "glass_70000", "glass_120000", "glass_many", "ceiling", "focus_near",
        "focus_far", "index_cuboid", "index_sphere", "mirror_wall",
    }  # fmt: skip
    # 70 000 and 120 000 caustic photons in all.
    for name, count in (("glass_70000", 70_000), ("glass_120000", 120_000)):
        chosen = pictures[name].overrides
        assert chosen["passes"] * chosen["photons_caustic"] == count
