"""Kd-tree or grid for photons, and bounding spheres before Embree or not.

    python benchmarks/photon_search.py [--figures]

Prints the tables of docs/search.md: processor time of one thread, best of three. With
--figures draws docs/pictures/photon_search.png and bounding_spheres.png.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import numpy as np
from figures import Search, draw_culling, draw_search
from scipy.spatial import cKDTree

from photon_map.core.geometry.intersector import Intersector
from photon_map.core.geometry.mesh import Mesh
from photon_map.core.geometry.vector import dot, read, subtract
from photon_map.core.jit import Row, Table, kernel
from photon_map.core.photons.gather import gather_irradiance
from photon_map.core.photons.photon_map import PhotonMap, build_photon_map
from photon_map.core.photons.rows import CELL
from photon_map.core.photons.sight import SIGHT
from photon_map.core.photons.trace import PHOTON, Walk
from photon_map.tests.scenes import sphere

QUERIES = 20_000
WANTED = (10, 50, 200)


@kernel
def ask_grid(
    photons: Row, places: Table, normals: Table, radius: float, sight: Table, out: Table
) -> int:
    """Irradiance at each place; photons found in all."""
    found = 0
    for k in range(len(places)):
        e, _, count = gather_irradiance(
            photons, read(places, k), read(normals, k), radius, sight
        )
        out[k] = e[0]
        found += count
    return found


def timed(work: Callable[[], object]) -> float:
    """Least processor seconds of three."""
    best = np.inf
    for _ in range(3):
        begin = time.process_time()
        work()
        best = min(best, time.process_time() - begin)
    return float(best)


def photons_of(count: int, random: np.random.Generator) -> np.ndarray:
    """Photons spread evenly over the walls of a box of edge 2."""
    rows = np.zeros(count, PHOTON)
    axis, side = random.integers(0, 3, count), random.choice((-1.0, 1.0), count)
    places = random.uniform(-1, 1, (count, 3))
    places[np.arange(count), axis] = side
    normals = np.zeros((count, 3))
    normals[np.arange(count), axis] = -side
    rows["position"], rows["normal"], rows["flux"] = places, normals, 1.0
    return rows


def search() -> list[Search]:
    """Build and ask both structures."""
    rows: list[Search] = []
    random = np.random.default_rng(1)
    for count in (10_000, 100_000, 1_000_000):
        photons = photons_of(count, random)
        order = np.arange(count, dtype=np.int64)
        chosen = np.sort(random.choice(count, min(QUERIES, count), replace=False))
        places = photons["position"][chosen].astype(np.float64)
        normals = photons["normal"][chosen].astype(np.float64)
        tree = cKDTree(photons["position"], balanced_tree=False, compact_nodes=False)
        plant = timed(
            lambda p=photons: cKDTree(p["position"], balanced_tree=False, compact_nodes=False)
        )
        for wanted in WANTED:
            radius = float(np.sqrt(24.0 * wanted / (count * np.pi)))
            if radius > 0.3:
                continue
            walk = [Walk(photons, order, 0)]
            grid: PhotonMap = build_photon_map(walk, CELL * radius)
            out = np.zeros(len(places))
            found = ask_grid(grid, places, normals, radius, np.zeros(SIGHT), out)
            sort = timed(lambda w=walk, r=radius: build_photon_map(w, CELL * r))
            ask = timed(
                lambda g=grid, p=places, n=normals, r=radius, o=out: ask_grid(
                    g, p, n, r, np.zeros(SIGHT), o
                )
            )
            ball = timed(
                lambda t=tree, p=places, r=radius: t.query_ball_point(p, r, return_length=True)
            )
            nearest = timed(lambda t=tree, p=places, k=wanted: t.query(p, k=k))
            inside = tree.query_ball_point(places, radius, return_length=True)
            each = 1e6 / len(places)
            rows.append(
                Search(
                    count, wanted, radius, sort, ask * each, plant, ball * each, nearest * each
                )
            )
            print(
                f"{count} photons, {wanted} wanted, r {radius:.4f}: found "
                f"{found / len(places):.1f} (tree {inside.mean():.1f}); grid built "
                f"{1e3 * sort:.0f} ms, asked {ask * each:.2f} us; tree built "
                f"{1e3 * plant:.0f} ms, by radius {ball * each:.2f} us, "
                f"by count {nearest * each:.2f} us",
                flush=True,
            )
    return rows


@kernel
def may_hit(spheres: Table, origins: Table, directions: Table, out: Table) -> None:
    """Whether each ray meets one of the spheres (centre, radius); unit directions."""
    for k in range(len(origins)):
        out[k] = False
        d = read(directions, k)
        o = read(origins, k)
        for s in range(len(spheres)):
            w = subtract(read(spheres, s), o)
            along = dot(w, d)
            r = spheres[s, 3]
            w2 = dot(w, w)
            if (along > 0.0 or w2 < r * r) and w2 - along * along <= r * r:
                out[k] = True
                break


def culling() -> dict[int, tuple[float, float, float]]:
    """Rays through a cloud of balls: Embree for all, or for those that meet a sphere.

    Nanoseconds a ray by bodies: Embree alone, the spheres, Embree for the rest.
    """
    rows: dict[int, tuple[float, float, float]] = {}
    random = np.random.default_rng(2)
    count = 200_000
    for bodies in (1, 10, 100):
        vertices, faces, spheres = [], [], np.zeros((bodies, 4))
        start = 0
        radius = 0.5 * bodies ** (-1 / 3)
        for k in range(bodies):
            centre = random.uniform(-1, 1, 3)
            points, corners = sphere(centre, radius, 5)
            vertices.append(points)
            faces.append(corners + start)
            start += len(points)
            spheres[k] = (*centre, radius)
        triangles = np.concatenate(faces).astype(np.int32)
        mesh = Mesh(
            np.concatenate(vertices).astype(np.float32), triangles,
            np.zeros((len(triangles), 3, 3), np.float32), np.zeros(len(triangles), np.bool_),
            np.zeros(len(triangles), np.int32), np.full(len(triangles), 31, np.int32),
        )  # fmt: skip
        intersector = Intersector(mesh)
        origins = random.normal(size=(count, 3))
        origins = 3.0 * origins / np.linalg.norm(origins, axis=1, keepdims=True)
        directions = random.uniform(-1.2, 1.2, (count, 3)) - origins
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        o, d = origins.astype(np.float32), directions.astype(np.float32)
        out = np.zeros(count, np.bool_)
        may_hit(spheres, o, d, out)
        hit = intersector.nearest(o, d).face >= 0
        assert not (hit & ~out).any()
        alone = timed(lambda i=intersector, o=o, d=d: i.nearest(o, d))
        test = timed(lambda s=spheres, o=o, d=d, out=out: may_hit(s, o, d, out))
        rest = timed(lambda i=intersector, o=o, d=d, out=out: i.nearest(o[out], d[out]))
        rows[bodies] = (1e9 * alone / count, 1e9 * test / count, 1e9 * rest / count)
        print(
            f"{bodies} bodies, {len(triangles)} triangles: {100 * hit.mean():.0f} % of rays "
            f"hit, {100 * out.mean():.0f} % meet a sphere; Embree alone "
            f"{1e9 * alone / count:.0f} ns a ray, spheres {1e9 * test / count:.0f} ns and "
            f"Embree for the rest {1e9 * rest / count:.0f} ns",
            flush=True,
        )

    return rows


def main() -> None:
    """Both comparisons."""
    parser = argparse.ArgumentParser(description="Kd-tree or grid, and bounding spheres.")
    parser.add_argument("--figures", action="store_true", help="draw the docs' figures")
    figures = parser.parse_args().figures
    rows, culled = search(), culling()
    if figures:
        draw_search(rows)
        draw_culling(culled)


if __name__ == "__main__":
    main()
