"""Photon maps of many passes in one file: a zip of ``.npy`` columns and a JSON header.

``numpy.load`` reads it too. Nothing in it is ever unpickled; every member is held to the
type and length that the header gives, the header to limits of its own, and all bytes to
their checksums, so that a stranger's file can neither run code nor fill the memory.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
import zipfile
import zlib
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..file_replace import replacing
from ..photons.trace import PHOTON
from ..sampling.rng import REPLICATES
from ..scene.scene import SceneError

FORMAT = "photon_map photon maps"
FORMAT_VERSION = 1

#: Passes that a bake may have, bytes of its header, photons of one kind and pass.
MOST_PASSES = 1 << 16
_MOST_HEADER = 1 << 26
_MOST_PHOTONS = 1 << 30
#: Maps of at most so many bytes are kept in memory once they are checked.
MOST_KEPT = 1 << 29
_KINDS = ("caustic", "global")
_PILOT = "pilot.npy"
_FIELDS = PHOTON.names or ()
#: Parts of lobes that a photon may name (``bsdf.dispatch``).
_PARTS = 5
_NPY_HEADER = 256
#: What float32 makes of unit vectors, and the brightest photon [W] that is still light.
_LENGTH_SLACK = 1e-4
_MOST_FLUX = 1e24
#: No maps are compressed by more: their positions have random digits.
_MOST_RATIO = 50
_BROKEN = (
    zipfile.BadZipFile, zlib.error, EOFError, KeyError, MemoryError, NotImplementedError,
    OSError, RecursionError, RuntimeError, TypeError, ValueError, AttributeError,
)  # fmt: skip


#: The (caustic, global) photons of one pass.
Maps: TypeAlias = tuple[NDArray[np.void], NDArray[np.void]]


class BakeError(SceneError):
    """Photon maps that cannot be used; the message names the file and what to do."""


@dataclass(frozen=True)
class BakeHeader:
    """What a file of maps says of itself.

    ``passes``: how many, a multiple of ``rng.REPLICATES``; ``emitted``: paths a pass, by
    kind (caustic, global); ``stored``: photons of each pass, by kind; ``pilot``: global
    photons of the pilot pass; ``fingerprint``: see ``fingerprint``; ``origin``: the point that
    positions are relative to [m, world].
    """

    passes: int
    seed: int
    emitted: tuple[int, int]
    tracing_version: int
    fingerprint: dict[str, str]
    origin: tuple[float, float, float]
    scene: str = ""
    pilot: int = 0
    stored: tuple[tuple[int, int], ...] = ()
    checksums: dict[str, str] = field(default_factory=dict)


def write_maps(
    path: str | os.PathLike[str],
    header: BakeHeader,
    pilot: NDArray[np.float64],
    passes: Iterable[Maps],
) -> BakeHeader:
    """Write the (caustic, global) photons of each pass; the file appears whole or not at all.

    ``pilot`` (P, 3): where those of the pilot pass lie. Returns ``header`` with what was
    counted. Raises ``OSError``.
    """
    stored: list[tuple[int, int]] = []
    checksums: dict[str, str] = {}

    def put(archive: zipfile.ZipFile, member: str, column: NDArray) -> None:
        data = _npy(column)
        checksums[member] = hashlib.sha256(data).hexdigest()
        archive.writestr(member, data)

    with replacing(path) as part:
        with zipfile.ZipFile(part, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
            put(archive, _PILOT, pilot.astype(np.float32))
            for i, maps in enumerate(passes):
                stored.append((len(maps[0]), len(maps[1])))
                for kind, photons in zip(_KINDS, maps, strict=True):
                    for name in _FIELDS:
                        put(archive, _member(i, kind, name), photons[name])
            whole = replace(header, pilot=len(pilot), stored=tuple(stored), checksums=checksums)
            text = json.dumps({"format": FORMAT, "version": FORMAT_VERSION, **vars(whole)})
            archive.writestr("header.json", text)
            archive.writestr("header.sha256", hashlib.sha256(text.encode()).hexdigest())
    return whole


class MapsFile:
    """An open file of maps; ``photons`` may be asked by several threads.

    Raises ``BakeError`` when the file is damaged, foreign or of another version, ``OSError``
    when it cannot be read. All of it is checked once, here, and kept in memory when it takes
    no more than ``most_kept`` bytes.
    """

    def __init__(self, path: str | os.PathLike[str], most_kept: int = MOST_KEPT) -> None:
        self.path = Path(path)
        self.most_kept = most_kept
        if not self.path.is_file():
            raise BakeError(f"there are no photon maps '{self.path}'")
        self._kept: list[Maps] = []
        self.header, self.pilot = self._guarded(self._check)

    @property
    def kept_bytes(self) -> int:
        """Memory of the photons that are kept."""
        return sum(photons.nbytes for maps in self._kept for photons in maps)

    def photons(self, i: int) -> Maps:
        """The (caustic, global) photons of pass ``i``, ``PHOTON`` rows by path and depth."""
        if self._kept:
            return self._kept[i]
        maps: Maps = self._guarded(lambda archive: _read_pass(archive, i, self.header))
        return maps

    def _guarded(self, work: Any) -> Any:
        try:
            with zipfile.ZipFile(self.path) as archive:
                return work(archive)
        except BakeError:
            raise
        except _BROKEN as error:
            reason = " ".join(str(error).split()) or type(error).__name__
            raise BakeError(f"photon maps '{self.path}' are damaged: {reason}") from error

    def _check(self, archive: zipfile.ZipFile) -> tuple[BakeHeader, NDArray[np.float32]]:
        header = _read_header(archive, str(self.path))
        count = header.pilot + sum(map(sum, header.stored))
        if count * PHOTON.itemsize > _MOST_RATIO * (self.path.stat().st_size + 4096):
            raise ValueError("the header promises more photons than the file can hold")
        pilot = np.zeros((header.pilot, 3), np.float32)
        _fill(archive, _PILOT, pilot, header)
        for i in range(header.passes):
            maps = _read_pass(archive, i, header)
            if count * PHOTON.itemsize <= self.most_kept:
                self._kept.append(maps)
        return header, pilot


def _read_pass(archive: zipfile.ZipFile, i: int, header: BakeHeader) -> Maps:
    """Both maps of pass ``i``, every number of them fit for kernels."""
    maps = []
    for kind, count in zip(_KINDS, header.stored[i], strict=True):
        photons = np.zeros(count, PHOTON)
        for name in _FIELDS:
            _fill(archive, _member(i, kind, name), photons[name], header)
        part = photons["part"]
        if count and not 0 <= part.min() <= part.max() < _PARTS:
            raise ValueError(f"a part of pass {i} is unknown")
        for name in ("direction", "normal"):
            length = np.linalg.norm(photons[name].astype(np.float64), axis=1)
            if (abs(length - 1.0) > _LENGTH_SLACK).any():
                raise ValueError(f"a {name} of pass {i} has not the length 1")
        flux = photons["flux"]
        if count and not 0.0 <= flux.min() <= flux.max() <= _MOST_FLUX:
            raise ValueError(f"a flux of pass {i} is none")
        photons.setflags(write=False)
        maps.append(photons)
    return maps[0], maps[1]


def _fill(archive: zipfile.ZipFile, member: str, column: NDArray, header: BakeHeader) -> None:
    """Read ``member`` into ``column``, whose type and shape it must have."""
    data = _bytes(archive, member, column.nbytes + _NPY_HEADER)
    if hashlib.sha256(data).hexdigest() != header.checksums[member]:
        raise ValueError(f"the checksum of {member} is wrong")
    column[...] = _column(data, column)
    if column.dtype.kind == "f" and not np.isfinite(column).all():
        raise ValueError(f"a number of {member} is not finite")


def _read_header(archive: zipfile.ZipFile, name: str) -> BakeHeader:
    if "header.json" not in archive.namelist():
        raise BakeError(f"'{name}' holds no photon maps of Photon Map")
    text = _bytes(archive, "header.json", _MOST_HEADER)
    data = json.loads(text)
    if not isinstance(data, dict) or data.pop("format", None) != FORMAT:
        raise BakeError(f"'{name}' holds no photon maps of Photon Map")
    version = data.pop("version", None)
    if version != FORMAT_VERSION:
        raise BakeError(
            f"photon maps '{name}' are of version {version}, this Photon Map reads version "
            f"{FORMAT_VERSION}; bake them again with this one"
        )
    seal = _bytes(archive, "header.sha256", 64)
    if hashlib.sha256(text).hexdigest().encode() != seal:
        raise ValueError("the checksum of the header is wrong")
    return _checked(data)


def _checked(data: dict[str, Any]) -> BakeHeader:
    """The header with its types; kernels and loops trust what it says."""
    header = BakeHeader(
        passes=_whole(data["passes"], 1, MOST_PASSES),
        seed=_whole(data["seed"], 0, 2**31 - 1),
        emitted=_pair(data["emitted"]),
        tracing_version=_whole(data["tracing_version"], 0, 2**31),
        fingerprint=_texts(data["fingerprint"]),
        origin=tuple(float(x) for x in data["origin"]),  # type: ignore[arg-type]
        scene=str(data["scene"]),
        pilot=_whole(data["pilot"], 0, _MOST_PHOTONS),
        stored=tuple(_pair(pair) for pair in data["stored"]),
        checksums=_texts(data["checksums"]),
    )
    if len(header.stored) != header.passes or header.passes % REPLICATES:
        raise ValueError("the header contradicts itself about the passes")
    if len(header.origin) != 3 or not np.isfinite(header.origin).all():
        raise ValueError("the origin is no point")
    return header


def _whole(value: object, low: int, high: int) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or not low <= value <= high:
        raise ValueError(f"{value!r} stands where a number from {low} to {high} should")
    return value


def _pair(value: Any) -> tuple[int, int]:
    first, second = value
    return _whole(first, 0, _MOST_PHOTONS), _whole(second, 0, _MOST_PHOTONS)


def _texts(value: Any) -> dict[str, str]:
    if not all(isinstance(text, str) for text in value.values()):
        raise TypeError("something else stands where a text should")
    return dict(value)


def _member(i: int, kind: str, name: str) -> str:
    return f"{i:05d}/{kind}/{name}.npy"


def _npy(column: NDArray) -> bytes:
    stream = io.BytesIO()
    np.lib.format.write_array(stream, np.ascontiguousarray(column), allow_pickle=False)
    return stream.getvalue()


def _bytes(archive: zipfile.ZipFile, member: str, most: int) -> bytes:
    """A member's bytes; its directory entry says how many, and zipfile reads no more."""
    if archive.getinfo(member).file_size > most:
        raise ValueError(f"{member} is longer than it may be")
    return archive.read(member)


def _column(data: bytes, like: NDArray) -> NDArray:
    """The array in ``data`` when it has shape and type of ``like``: checked before reading."""
    stream = io.BytesIO(data)
    if np.lib.format.read_magic(stream) != (1, 0):
        raise ValueError("an array of another version of NumPy's format")
    shape, fortran, dtype = np.lib.format.read_array_header_1_0(stream)
    if (shape, fortran, dtype) != (like.shape, False, like.dtype):
        raise ValueError(f"an array {dtype}{shape}, expected {like.dtype}{like.shape}")
    rest = stream.read()
    return np.frombuffer(rest, dtype).reshape(shape)
