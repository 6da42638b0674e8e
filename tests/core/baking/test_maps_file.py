"""The file of baked maps: what is not a whole one of this version is refused."""

from __future__ import annotations

import hashlib
import json
import os
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from photon_map.core.baking import maps_file
from photon_map.core.baking.maps_file import BakeError, BakeHeader, MapsFile, write_maps
from photon_map.core.photons.trace import PHOTON

HEADER = BakeHeader(4, 7, (30, 50), 1, {"lamp 'Key'": "ab"}, (0.1, 1 / 3, 1e9), "scene \u00fc")


def photons(count: int, seed: int) -> np.ndarray:
    generator = np.random.default_rng(seed)
    table = np.zeros(count, PHOTON)
    table["position"] = generator.normal(size=(count, 3))
    table["flux"] = generator.exponential(size=(count, 3))
    for name in ("direction", "normal"):
        way = generator.normal(size=(count, 3))
        table[name] = way / np.linalg.norm(way, axis=1, keepdims=True)
    table["part"] = generator.integers(0, 4, count)
    return table


PASSES = [(photons(k, k), photons(9 - k, 100 + k)) for k in (5, 0, 3, 9)]
PILOT = np.random.default_rng(1).normal(size=(6, 3)).astype(np.float32)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    write_maps(tmp_path / "a.pmap", HEADER, PILOT, PASSES)
    assert os.listdir(tmp_path) == ["a.pmap"]
    return tmp_path / "a.pmap"


@pytest.mark.parametrize("kept", [0, 1 << 20])
def test_a_round_trip_keeps_every_bit(path: Path, kept: int):
    file = MapsFile(path, kept)
    assert file.kept_bytes == (0 if kept == 0 else 36 * PHOTON.itemsize)
    assert file.header.fingerprint == HEADER.fingerprint
    assert (file.header.origin, file.header.scene) == (HEADER.origin, HEADER.scene)
    assert file.header.stored == ((5, 4), (0, 9), (3, 6), (9, 0))
    assert (file.pilot == PILOT).all()
    for i, wanted in enumerate(PASSES):
        for a, b in zip(file.photons(i), wanted, strict=True):
            assert a.tobytes() == b.tobytes()


def test_numpy_reads_it_too(path: Path):
    with np.load(path, allow_pickle=False) as archive:
        assert (archive["00002/global/flux"] == PASSES[2][1]["flux"]).all()


def test_a_failure_leaves_the_older_file(path: Path):
    def broken():
        yield PASSES[0]
        raise OSError(28, "No space left on device")

    before = path.read_bytes()
    with pytest.raises(OSError, match="No space left"):
        write_maps(path, HEADER, PILOT, broken())
    assert path.read_bytes() == before
    assert os.listdir(path.parent) == ["a.pmap"]


def test_a_damaged_byte_is_an_error_or_changes_nothing(path: Path, rng: np.random.Generator):
    whole = path.read_bytes()
    refused = 0
    for place in rng.choice(len(whole), size=200, replace=False):
        broken = bytearray(whole)
        broken[place] ^= 1 << int(rng.integers(8))
        path.write_bytes(broken)
        try:
            file = MapsFile(path)
        except BakeError as error:
            assert "a.pmap" in str(error)
            refused += 1
        else:
            for i, wanted in enumerate(PASSES):
                assert [m.tobytes() for m in file.photons(i)] == [m.tobytes() for m in wanted]
    assert refused > 50
    for length in (0, 1, 100, len(whole) // 2, len(whole) - 1):
        path.write_bytes(whole[:length])
        with pytest.raises(BakeError, match="damaged"):
            MapsFile(path)


def _rewritten(path: Path, seal: bool = True, **changes: Any) -> None:
    """Replace members, and entries of the header; None takes one out."""
    with zipfile.ZipFile(path) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    header = json.loads(members["header.json"])
    for key, value in changes.items():
        if key in header:
            header[key] = value
        elif value is None:
            del members[key]
        else:
            members[key] = value
            header["checksums"][key] = hashlib.sha256(value).hexdigest()
    members["header.json"] = json.dumps(header).encode()
    if seal:
        digest = hashlib.sha256(members["header.json"]).hexdigest()
        members["header.sha256"] = digest.encode()
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in members.items():
            archive.writestr(name, data)


def _npy(array: np.ndarray) -> bytes:
    return maps_file._npy(array)


FLUX = "00000/caustic/flux.npy"
NORMAL = "00000/caustic/normal.npy"
NAN = np.full((5, 3), np.nan, np.float32)
HUGE = _npy(np.zeros((5, 3), np.float32)).replace(b"(5, 3)", b"(9999999999999, 3)")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"version": 2}, "version 2, this Photon Map reads version 1"),
        ({"format": "something"}, "holds no photon maps"),
        ({"passes": 5}, "contradicts itself"),
        ({"passes": "many"}, "'many' stands where"),
        ({"passes": True}, "True stands where"),
        ({"stored": [[1 << 60, 0]] * 4}, "stands where a number"),
        ({"stored": [[1 << 29, 0]] * 4}, "damaged"),
        ({"emitted": [1]}, "damaged"),
        ({"origin": [0, float("nan"), 0]}, "the origin is no point"),
        ({"fingerprint": {"a": 1}}, "where a text should"),
        ({"fingerprint": 3}, "damaged"),
        ({"checksums": {}}, "damaged"),
        ({"pilot": -1}, "stands where a number"),
        ({"pilot.npy": None}, "damaged"),
        ({FLUX: None}, "damaged"),
        ({FLUX: b""}, "damaged"),
        ({FLUX: _npy(NAN)}, "is not finite"),
        ({FLUX: _npy(np.zeros((5, 3)))}, "longer than it may be|expected float32"),
        ({FLUX: _npy(np.zeros((3, 5), np.float32))}, r"expected float32\(5, 3\)"),
        ({FLUX: _npy(np.zeros((5, 3), np.float32))[:-1]}, "damaged"),
        ({FLUX: HUGE}, "expected float32"),
        ({FLUX: b"\0" * 10_000_000}, "longer than it may be"),
        ({NORMAL: _npy(np.zeros((5, 3), np.float32))}, "normal of pass 0 has not the length 1"),
        ({NORMAL: _npy(np.full((5, 3), 1e30, np.float32))}, "normal of pass 0 has not"),
        ({FLUX: _npy(np.full((5, 3), -1.0, np.float32))}, "flux of pass 0 is none"),
        ({FLUX: _npy(np.full((5, 3), 3e38, np.float32))}, "flux of pass 0 is none"),
        ({"00000/caustic/part.npy": _npy(np.full(5, 5, np.int32))}, "part of pass 0"),
        ({"00000/caustic/part.npy": _npy(np.full(5, -1, np.int32))}, "part of pass 0"),
    ],
)
def test_what_is_wrong_with_a_file_is_said(path: Path, changes: dict[str, Any], message: str):
    _rewritten(path, **changes)
    with pytest.raises(BakeError, match=message) as caught:
        MapsFile(path)
    assert str(path) in str(caught.value)


def test_the_rewriting_above_keeps_a_good_file_good(path: Path):
    _rewritten(path, **{FLUX: _npy(PASSES[0][0]["flux"])})
    assert MapsFile(path).header.passes == 4
    _rewritten(path, seal=False, seed=8)
    with pytest.raises(BakeError, match="checksum of the header"):
        MapsFile(path)


class Trap:
    """Unpickling it would make a folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def __reduce__(self):
        return os.mkdir, (str(self.folder),)


def test_nothing_is_ever_unpickled(path: Path, tmp_path: Path):
    folder = tmp_path / "sprung"
    trap = tmp_path / "trap.npy"
    np.save(trap, np.array([Trap(folder)] * 5, dtype=object), allow_pickle=True)
    _rewritten(path, **{FLUX: trap.read_bytes()})
    with pytest.raises(BakeError):
        MapsFile(path)
    assert not folder.exists()
    np.load(trap, allow_pickle=True)
    assert folder.exists(), "the trap does not work, so this test proves nothing"


def test_files_of_others_are_refused(tmp_path: Path):
    path = tmp_path / "x.pmap"
    path.write_text("not an archive")
    with pytest.raises(BakeError, match="damaged"):
        MapsFile(path)
    np.savez(tmp_path / "x.npz", header=np.zeros(3))
    with pytest.raises(BakeError, match="holds no photon maps"):
        MapsFile(tmp_path / "x.npz")
    with pytest.raises(BakeError, match="there are no photon maps"):
        MapsFile(tmp_path / "missing.pmap")
    with pytest.raises(BakeError, match="there are no photon maps"):
        MapsFile(tmp_path)
