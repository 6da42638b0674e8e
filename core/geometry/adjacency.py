"""How faces hang together, worked out face by face: a million take tenths of a second.

NumPy's way, with sorts of all sides and vectors for each of them, takes seconds. ``vertices``
are (V, 3) f8, ``faces`` and ``place`` (F, 3) integers: see ``Surfaces``.
"""

from __future__ import annotations

import math

import numpy as np

from ..jit import Table, kernel


@kernel
def fill_normals(vertices: Table, faces: Table, out: Table) -> None:
    """Write the unit normals by winding to ``out`` (F, 3); 0 of a face without area."""
    for f in range(len(faces)):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        ux = vertices[b, 0] - vertices[a, 0]
        uy = vertices[b, 1] - vertices[a, 1]
        uz = vertices[b, 2] - vertices[a, 2]
        vx = vertices[c, 0] - vertices[a, 0]
        vy = vertices[c, 1] - vertices[a, 1]
        vz = vertices[c, 2] - vertices[a, 2]
        x = uy * vz - uz * vy
        y = uz * vx - ux * vz
        z = ux * vy - uy * vx
        scale = 1.0 / max(math.sqrt(x * x + y * y + z * z), 1e-300)
        out[f, 0] = x * scale
        out[f, 1] = y * scale
        out[f, 2] = z * scale


@kernel
def number_places(vertices: Table, bits: Table, slots: Table, place: Table) -> int:
    """Number the places of ``vertices`` (V, 3) in the order of the first at each; how many.

    ``bits`` (V, 3) u4 of theirs; ``slots`` (S,): a hash table of -1 with room for more than V,
    S a power of two. NaN is a place of its own.
    """
    mask = np.uint64(len(slots) - 1)
    count = 0
    for v in range(len(vertices)):
        mixed = np.uint64(0)
        for k in range(3):
            mixed = (mixed ^ np.uint64(bits[v, k])) * np.uint64(0x9E3779B97F4A7C15)
            mixed ^= mixed >> np.uint64(29)
        slot = np.int64(mixed & mask)
        while slots[slot] >= 0:
            other = slots[slot]
            if (
                vertices[other, 0] == vertices[v, 0]
                and vertices[other, 1] == vertices[v, 1]
                and vertices[other, 2] == vertices[v, 2]
            ):
                break
            slot = (slot + 1) % len(slots)
        if slots[slot] >= 0:
            place[v] = place[slots[slot]]
        else:
            slots[slot] = v
            place[v] = count
            count += 1
    return count


@kernel
def _root(above: Table, k: int) -> int:
    """The place that stands for all that ``k`` is connected with; the way is shortened."""
    while above[k] != k:
        above[k] = above[above[k]]
        k = above[k]
    return k


@kernel
def connect(place: Table, part: Table) -> int:
    """Number the connected parts of the places (P,) that faces (F, 3) share.

    ``part`` (P,) gets their numbers, in the order of their lowest places. Returns how many.
    Tarjan 1975, "Efficiency of a good but not linear set union algorithm", paths halved.
    """
    for k in range(len(part)):
        part[k] = k
    for f in range(len(place)):
        a = _root(part, place[f, 0])
        for k in range(1, 3):
            b = _root(part, place[f, k])
            # The lowest place stands for all, so that it comes first below.
            if a < b:
                part[b] = a
            elif b < a:
                part[a] = b
                a = b
    count = 0
    for k in range(len(part)):
        if part[k] == k:
            part[k] = -1 - count
            count += 1
        else:
            # It stands for k and is lower: its number is there already.
            part[k] = part[part[k]]
    for k in range(len(part)):
        part[k] = -1 - part[k]
    return count


@kernel
def sort_sides(place: Table, begin: Table, sides: Table, of: Table, start: Table) -> int:
    """Sort the sides of faces (F, 3) by the places of their ends, the lower one first.

    ``begin`` (P + 1,): zeros; ``sides`` (3F,), ``of`` (F, 3), ``start`` (3F + 1,): see
    ``Edges``. Returns how many edges there are; those of one edge keep their order.
    """
    for f in range(len(place)):
        for k in range(3):
            begin[min(place[f, k], place[f, (k + 1) % 3]) + 1] += 1
    for p in range(1, len(begin)):
        begin[p] += begin[p - 1]
    for f in range(len(place)):
        for k in range(3):
            p = min(place[f, k], place[f, (k + 1) % 3])
            sides[begin[p]] = 3 * f + k
            begin[p] += 1
    # Each ``begin`` has become the next one's.
    count = first = 0
    for p in range(len(begin) - 1):
        last = begin[p]
        for i in range(first + 1, last):
            side = sides[i]
            high = _higher(place, side)
            j = i - 1
            while j >= first and _higher(place, sides[j]) > high:
                sides[j + 1] = sides[j]
                j -= 1
            sides[j + 1] = side
        for i in range(first, last):
            side = sides[i]
            if i == first or _higher(place, side) != _higher(place, sides[i - 1]):
                start[count] = i
                count += 1
            of[side // 3, side % 3] = count - 1
        first = last
    start[count] = len(sides)
    return count


@kernel
def _higher(place: Table, side: int) -> int:
    """The higher one of the places at the ends of a side."""
    f, k = side // 3, side % 3
    return max(place[f, k], place[f, (k + 1) % 3])


@kernel
def _fill_inward(
    vertices: Table, faces: Table, normals: Table, side: int, out: Table, row: int
) -> None:
    """Write the unit vector in a face's plane, inwards from its ``side``, to ``out[row]``."""
    f, k = side // 3, side % 3
    a, b = faces[f, k], faces[f, (k + 1) % 3]
    dx = vertices[b, 0] - vertices[a, 0]
    dy = vertices[b, 1] - vertices[a, 1]
    dz = vertices[b, 2] - vertices[a, 2]
    x = normals[f, 1] * dz - normals[f, 2] * dy
    y = normals[f, 2] * dx - normals[f, 0] * dz
    z = normals[f, 0] * dy - normals[f, 1] * dx
    scale = 1.0 / max(math.sqrt(x * x + y * y + z * z), 1e-300)
    out[row, 0] = x * scale
    out[row, 1] = y * scale
    out[row, 2] = z * scale


@kernel
def mark_ends(
    vertices: Table,
    faces: Table,
    normals: Table,
    chosen: Table,
    sides: Table,
    start: Table,
    bend: float,
    inward: Table,
    owner: Table,
    ends: Table,
) -> None:
    """Set ``ends`` (N,) of sides of ``chosen`` (F,) faces that no other one goes on from.

    ``sides`` (N,) in the order of their edges, edge e's from ``start[e]`` on; it goes on where
    their inward vectors have a cosine below ``bend``. ``inward`` (M, 3) and ``owner`` (M,) are
    overwritten; of an edge with more sides than M those M apart are not compared.
    """
    most = len(inward)
    for e in range(len(start) - 1):
        count = 0
        for i in range(start[e], start[e + 1]):
            if not chosen[sides[i] // 3]:
                ends[i] = False
                continue
            row = count % most
            owner[row] = i
            ends[i] = True
            _fill_inward(vertices, faces, normals, sides[i], inward, row)
            for j in range(max(0, count - most + 1), count):
                other = j % most
                cosine = (
                    inward[row, 0] * inward[other, 0]
                    + inward[row, 1] * inward[other, 1]
                    + inward[row, 2] * inward[other, 2]
                )
                if cosine < bend:
                    ends[i] = ends[owner[other]] = False
            count += 1


@kernel
def fill_boxes(vertices: Table, faces: Table, body: Table, boxes: Table) -> None:
    """Grow ``boxes`` (B, 2, 3), lowest and highest corner, to hold the faces of each body."""
    for f in range(len(faces)):
        box = body[f]
        for corner in range(3):
            for k in range(3):
                x = vertices[faces[f, corner], k]
                boxes[box, 0, k] = min(boxes[box, 0, k], x)
                boxes[box, 1, k] = max(boxes[box, 1, k], x)


@kernel
def mark_near(
    vertices: Table, faces: Table, body: Table, boxes: Table, reach: float, near: Table
) -> None:
    """Set ``near`` (F,) of faces whose box is within ``reach`` of that of another body."""
    for f in range(len(faces)):
        for box in range(len(boxes)):
            if box == body[f]:
                continue
            meets = True
            for k in range(3):
                x, y, z = (
                    vertices[faces[f, 0], k],
                    vertices[faces[f, 1], k],
                    vertices[faces[f, 2], k],
                )
                meets = (
                    meets
                    and min(x, y, z) <= boxes[box, 1, k] + reach
                    and max(x, y, z) >= boxes[box, 0, k] - reach
                )
            if meets:
                near[f] = True
                break
