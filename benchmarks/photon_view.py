"""How long it takes to look at photons: tracing, colouring, writing, picking a place.

    python benchmarks/photon_view.py

Of the glass box with 8192, 100 000 and 1 000 000 emitted photons a kind. Processor seconds of
one thread, kernels compiled before. Prints the table of docs/photon_view.md.
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import numpy as np

from photon_map.core import Settings, ViewedPass, photon_colours
from photon_map.photon_picture import write_ply
from photon_map.tests.scenes import cornell_glass

SIZE = 96
COUNTS = (8192, 100_000, 1_000_000)
#: Pixels that are picked: places of the floor, the caustic, the walls.
PICKED = ((48, 20), (30, 25), (66, 25), (48, 70), (10, 48), (86, 48))


def main() -> None:
    """Trace, colour, write and pick."""
    scene = cornell_glass(SIZE, smooth=True, subdivisions=3)
    plain = Settings(threads=1)
    ViewedPass(scene, plain)
    for count in COUNTS:
        settings = Settings(photons_caustic=count, photons_global=count, threads=1)
        marks = [time.process_time()]
        viewed = ViewedPass(scene, settings)
        marks.append(time.process_time())
        for by in ("power", "bounce", "caster", "light"):
            photon_colours(viewed.view, by)
        marks.append(time.process_time())
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "points.ply"
            write_ply(path, viewed.view, "caster")
            size = path.stat().st_size
        marks.append(time.process_time())
        found = []
        for x, y in PICKED:
            begin = time.process_time()
            place = viewed.place_at(*viewed.ray_of(x + 0.5, y + 0.5))
            assert place is not None
            rows = np.concatenate([disc.rows for disc in viewed.discs(place)])
            viewed.paths(rows)
            found.append((time.process_time() - begin, len(rows)))
        picking, inside = np.median(found, axis=0)
        trace, colour, write = np.diff(marks)
        print(
            f"{count} emitted a kind: {len(viewed.view.position)} stored, "
            f"traced {trace:.2f} s, coloured {1e3 * colour / 4:.0f} ms, "
            f"written {write:.2f} s and {size / 1e6:.1f} MB, "
            f"picked {1e3 * picking:.0f} ms with {inside:.0f} photons and their paths",
            flush=True,
        )


if __name__ == "__main__":
    main()
