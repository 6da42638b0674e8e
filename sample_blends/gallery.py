"""Renders the gallery: the report's figures and further scenes, each with time and error.

    python sample_blends/gallery.py [NAME ...]

Writes docs/gallery/NAME.png, keeps what each render said in docs/gallery/renders.json, and
makes docs/gallery.md of all of it. With names, only those are rendered again.
"""

from __future__ import annotations

import argparse
import json
import textwrap
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import gallery_figures

if TYPE_CHECKING:
    from photon_map.core import Update

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs" / "gallery"
RENDERS = DOCS / "renders.json"
SIZE = (320, 240)
PASSES = 32


@dataclass(frozen=True)
class Picture:
    """One render: a sample, its frame, fields of ``Settings``, and what is seen."""

    name: str
    sample: str
    words: str
    frame: int | None = None
    overrides: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Section:
    """Pictures that belong together under one heading."""

    title: str
    words: str
    pictures: tuple[Picture, ...]


@dataclass(frozen=True)
class Result:
    """What a render said of itself, and what the caption says first of a figure."""

    passes: int
    seconds: float
    relative_error: float
    rays: int
    words: str = ""


#: Of pictures that are dark but for a small part, whose noise would be seen.
MORE = {"passes": 96}
#: As few as tell an error; their photons together are as many as the report had.
FOUR_PASSES = {"passes": 4, "gather_rays": 8}
REPORT = (
    Section(
        "Figure 1: Fresnel's terms",
        "The report's cuboid without and with Fresnel weighting. Without (Blender's Refraction "
        "shader) nothing is mirrored, and light that would be reflected totally ends: those "
        "sides are black, where the report still followed it. With Fresnel's terms the sides "
        "show both walls by total reflection, and the front a little of what is before it.",
        (
            Picture("fresnel_without", "fresnel_cuboid", "refraction alone", 1),
            Picture("fresnel_with", "fresnel_cuboid", "with Fresnel's terms", 2),
        ),
    ),
    Section(
        "Figure 2: without and with global photons",
        "The report's room was black where no lamp shone with 0 photons and lit with 15 000. "
        "The box here has an area lamp; its ceiling and the balls' shadows show the same.",
        (
            Picture("photons_0", "cornell_glass", "0 photons", None, {"photons_global": 0}),
            Picture(
                "photons_15000",
                "cornell_glass",
                "15 000 global photons a pass",
                None,
                {"photons_global": 15_000},
            ),
        ),
    ),
    Section(
        "Corridor: draft and final",
        "The report's draft was noisy at blurred edges. Two passes here, then many.",
        (
            Picture("corridor_draft", "cornell_corridor", "draft", None, {"passes": 2}),
            Picture("corridor_final", "cornell_corridor", "final", None, {"passes": 96}),
        ),
    ),
    Section(
        "70 000 and 120 000 caustic photons",
        "As many as the report had, in four passes, since one pass cannot tell its error. The "
        "number changes the noise and not the brightness.",
        (
            Picture(
                "glass_70000",
                "glass_caustics",
                "70 000",
                None,
                FOUR_PASSES | {"photons_caustic": 17_500},
            ),
            Picture(
                "glass_120000",
                "glass_caustics",
                "120 000",
                None,
                FOUR_PASSES | {"photons_caustic": 30_000},
            ),
            Picture("glass_many", "glass_caustics", "many passes"),
        ),
    ),
    Section(
        "Ceiling caustics from blue reflectors",
        "Four white point lamps; what blue mirrors send to the ceiling is blue.",
        (Picture("ceiling", "mirror_caustics", "four lamps"),),
    ),
    Section(
        "Depth of field",
        "The plane of focus at the nearest and at the farthest sphere.",
        (
            Picture("focus_near", "dof_near_far", "near", 1),
            Picture("focus_far", "dof_near_far", "far", 2),
        ),
    ),
    Section(
        "Index 1.52",
        "The cuboid's sides show red and green by total reflection; what its front mirrors of "
        "the blue wall behind the camera is faint. The sphere has the green wall at its rim "
        "and its caustic beside it.",
        (
            Picture("index_cuboid", "index_152", "cuboid", 1),
            Picture("index_sphere", "index_152", "sphere", 2),
        ),
    ),
    Section(
        "A mirror for a back wall",
        "The wall behind the camera is blue and comes back by the mirror.",
        (Picture("mirror_wall", "mirror_wall", "mirror wall"),),
    ),
)

BEYOND = (
    Section("Pool", "The sun through waves.", (Picture("pool", "pool", "pool"),)),
    Section(
        "Nephroid", "A brass ring in the sun: half a nephroid, its cusp at half the radius.",
        (Picture("nephroid", "nephroid_ring", "ring"),),
    ),
    Section(
        "Whisky with ice", "Glass, drink and ice inside of each other.",
        (Picture("whisky", "whisky_glass", "tumbler", None, MORE),),
    ),
    Section(
        "Magnifier", "A caustic seen through a lens: a path tracer's hardest case.",
        (Picture("magnifier", "magnifier", "lens", None, MORE),),
    ),
    Section(
        "Prisms", "One bends its beam, one turns it around by total reflection.",
        (Picture("prism", "prism", "prisms", None, MORE),),
    ),
    Section(
        "Cut stones", "Index 2.42 clear, index 1.77 red.", (Picture("gem", "gem", "stones"),)
    ),
    Section(
        "Behind frosted glass", "A small lamp behind a rough pane.",
        (Picture("frosted", "frosted_lamp", "pane", None, MORE),),
    ),
    Section(
        "Through a keyhole", "All light in the room came through the keyhole.",
        (Picture("keyhole", "keyhole", "keyhole"),),
    ),
)  # fmt: skip


def render_picture(picture: Picture) -> Result:
    """Render one of the gallery through Blender; its PNG appears whole or not at all."""
    from photon_map.addon import headless

    done = headless.render_file(
        ROOT / "sample_blends" / f"{picture.sample}.blend",
        frame=picture.frame,
        size=SIZE,
        overrides={"passes": PASSES, **picture.overrides},
        png_path=DOCS / f"{picture.name}.png",
    )
    return result_of([done.update])


def result_of(updates: list[Update], words: str = "") -> Result:
    """What renders of one picture said: time and rays of all, the largest error."""
    seconds = round(sum(update.seconds for update in updates), 1)
    error = max(update.relative_error for update in updates)
    rays = sum(int(update.film.statistics.rays) for update in updates)
    return Result(updates[0].passes, seconds, error, rays, words)


def document(results: dict[str, Result]) -> str:
    """The page, of what the renders said."""
    text = [
        "# Gallery",
        "",
        fill(
            f"Made by `make gallery` from `sample_blends/`, {SIZE[0]}x{SIZE[1]} pixels. Below "
            "each picture stand its passes, the seconds of rendering on two cores, and the "
            "error that the render stated of itself: noise and bias of a typical pixel."
        ),
        "",
        "## The report's figures",
    ]
    for section in REPORT:
        text += section_lines(section, results)
    text += [gallery_figures.page(figure_captions(results)), "## Beyond the report"]
    for section in BEYOND:
        text += section_lines(section, results)
    return "\n".join(text).rstrip() + "\n"


def figure_captions(results: dict[str, Result]) -> dict[str, str]:
    """What stands below the figures that are no plain renders."""
    made = {name: results[name] for name in gallery_figures.FIGURES if name in results}
    captions = {name: f"{told(result)}, {result.words}" for name, result in made.items()}
    return {**dict.fromkeys(gallery_figures.FIGURES, ""), **captions}


def section_lines(section: Section, results: dict[str, Result]) -> list[str]:
    """A heading, a table of pictures, and what is to be seen."""
    shown = [picture for picture in section.pictures if picture.name in results]
    if not shown:
        return []
    pictures = " | ".join(f"![{p.words}](gallery/{p.name}.png)" for p in shown)
    captions = " | ".join(f"{p.words}: {told(results[p.name])}" for p in shown)
    bar = "|".join("---" for _ in shown)
    table = [f"| {pictures} |", f"|{bar}|", f"| {captions} |"]
    return ["", f"### {section.title}", "", fill(section.words), "", *table]


def fill(words: str) -> str:
    """Lines of the usual length."""
    return textwrap.fill(words, 96, break_on_hyphens=False)


def told(result: Result) -> str:
    """Passes, time and error in words."""
    error = f"error {100 * result.relative_error:.1f} %"
    return f"{result.passes} passes, {result.seconds:.0f} s, {error}"


def main() -> None:
    """Render what was asked for, then write the page."""
    parser = argparse.ArgumentParser(description="Render the gallery of docs/gallery.md.")
    parser.add_argument("names", nargs="*", help="pictures to render again; all without")
    parser.add_argument("--page", action="store_true", help="make the page alone anew")
    given = parser.parse_args()
    wanted = ["nothing"] if given.page else given.names
    pictures = {p.name: p for section in (*REPORT, *BEYOND) for p in section.pictures}
    unknown = set(given.names) - set(pictures) - set(gallery_figures.FIGURES)
    if unknown:
        raise SystemExit(f"no picture is called {', '.join(sorted(unknown))}")
    DOCS.mkdir(exist_ok=True)
    names = [*pictures, *gallery_figures.FIGURES]
    results = {}
    if RENDERS.exists():
        stored = json.loads(RENDERS.read_text("utf-8"))
        results = {name: Result(**row) for name, row in stored.items() if name in names}
    for name in names:
        if wanted and name not in wanted:
            continue
        if name in pictures:
            results[name] = render_picture(pictures[name])
        else:
            results[name] = result_of(*gallery_figures.FIGURES[name](DOCS / f"{name}.png"))
        rows = {key: asdict(results[key]) for key in names if key in results}
        RENDERS.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
        print(f"{name}: {told(results[name])}", flush=True)
    (ROOT / "docs" / "gallery.md").write_text(document(results), encoding="utf-8")


if __name__ == "__main__":
    main()
