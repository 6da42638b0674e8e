"""Renders the BRDF that docs/brdf.md adds, and compares the picture with its closed form.

    python benchmarks/added_brdf.py

Puts the page's example into a copy of the engine as `tests/core/bsdf/test_added.py` does,
renders white balls of k = 1 (Lambert's law), 2 and 4 in the light of a sun behind the camera,
and draws docs/pictures/added_brdf.png: the balls, and their brightness from the middle to the
rim beside the formula. Prints the largest difference.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from tests.core.bsdf.test_added import run_with_the_example  # noqa: E402
from tests.scenes import look_at, sphere, sphere_normals  # noqa: E402

EXPONENTS = (1.0, 2.0, 4.0)
#: Pixels a side, width of the picture [radii].
SIDE, WIDE = 129, 2.2
RENDER = """
import numpy as np
from photon_map.core import CameraData, SceneBuilder, Settings, render
from photon_map.core.scene.lobes import Lobe
from photon_map.core.scene.tables import Model

ball = np.load("ball.npz")
images = []
for k in ball["exponents"]:
    builder = SceneBuilder("ball")
    white = builder.add_material("white", [Lobe(Model.ADDED_1, (1.0, 1.0, 1.0), exponent=k)])
    builder.add_mesh("ball", ball["vertices"], ball["faces"], white, ball["normals"])
    # A lamp so far away that its rays are parallel; irradiance pi.
    builder.add_point_light("sun", (0.0, 0.0, 1e4), np.pi * 1e8)
    builder.set_camera(
        CameraData(
            kind="ORTHOGRAPHIC", ortho_scale=float(ball["wide"]), matrix=ball["matrix"],
            width=int(ball["side"]), height=int(ball["side"]),
        )
    )
    settings = Settings(
        passes=16, photons_global=0, photons_caustic=0, pixel_filter="BOX", filter_width=1.0
    )
    *_, last = render(builder.build(), settings)
    images.append(last.film.resolve("direct")[..., 0])
np.save("images.npy", np.stack(images))
print("checked")
"""


def rendered() -> np.ndarray:
    """The balls (K, h, w), rendered by a copy of the engine with the example in it."""
    mesh = sphere((0.0, 0.0, 0.0), 1.0, 5)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        np.savez(
            folder / "ball.npz", vertices=mesh[0], faces=mesh[1], exponents=EXPONENTS,
            normals=sphere_normals(mesh, (0.0, 0.0, 0.0)), side=SIDE, wide=WIDE,
            matrix=look_at((0.0, 0.0, 5.0), (0.0, 0.0, 0.0), up=(0, 1, 0)),
        )  # fmt: skip
        run_with_the_example(folder, RENDER)
        return np.asarray(np.load(folder / "images.npy"))


def main() -> None:
    """Render, compare, draw."""
    images = rendered()
    figure = Figure(figsize=(9.0, 2.4), layout="constrained")
    *balls, profile = figure.subplots(1, 4, width_ratios=(1, 1, 1, 1.5))
    across = (np.arange(SIDE) + 0.5 - SIDE / 2) * WIDE / SIDE
    inside = abs(across) < 0.97
    cosine = np.sqrt(1 - across[inside] ** 2)
    for k, image, axis in zip(EXPONENTS, images, balls, strict=True):
        axis.imshow(image, origin="lower", cmap="gray", vmin=0.0, vmax=2.5)
        axis.set_title(f"k = {k:g}" + (" (Lambert)" if k == 1 else ""), fontsize=9)
        axis.set(xticks=[], yticks=[])
        # Irradiance pi cos from the side of the camera: f pi cos.
        wanted = (k + 1) / 2 * cosine ** (2 * k - 1)
        seen = image[SIDE // 2, inside]
        profile.plot(across[inside], wanted, color="0.6", lw=3)
        profile.plot(across[inside], seen, lw=1, label=f"k = {k:g}")
        worst = float(abs(seen - wanted).max())
        print(f"k {k:g}: largest difference {worst:.4f} of {wanted.max():.2f}", flush=True)
    profile.set(xlabel="place across the ball [radii]", ylabel="radiance (grey: formula)")
    profile.legend(fontsize=7)
    figure.savefig(
        ROOT / "docs" / "pictures" / "added_brdf.png", dpi=90, metadata={"Software": None}
    )


if __name__ == "__main__":
    main()
