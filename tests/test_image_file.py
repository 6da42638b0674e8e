from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from PIL import Image

from photon_map.image_file import Frame, srgb, write_exr, write_png


def test_exr_keeps_every_bit_and_what_is_not_finite(tmp_path: Path, rng: np.random.Generator):
    layers = {
        "combined": rng.normal(size=(5, 7, 4)).astype(np.float32) * 1e6,
        "depth": np.full((5, 7, 1), np.inf, np.float32),
        "caustics": rng.random((5, 7, 3), dtype=np.float32) * np.float32(1e-30),
    }
    layers["combined"][0, 0, 0] = np.nan
    write_exr(tmp_path / "a.exr", layers, {"scene": "box"})
    with OpenEXR.File(str(tmp_path / "a.exr"), separate_channels=True) as file:
        channels = {name: channel.pixels for name, channel in file.channels().items()}
        header = dict(file.header())
    assert header["scene"] == "box"
    # Blender's linear space: Rec. 709 primaries, D65 white.
    expected = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)
    assert header["chromaticities"] == pytest.approx(expected, rel=1e-6)
    read = np.stack([channels[name] for name in "RGBA"], axis=-1)[::-1]
    assert read.tobytes() == layers["combined"].tobytes()
    assert channels["depth.Z"][::-1].tobytes() == layers["depth"].tobytes()
    assert channels["caustics.B"][::-1].tobytes() == layers["caustics"][..., 2].tobytes()


def test_a_region_lies_in_its_image_as_exr_has_it(tmp_path: Path):
    layers = {"depth": np.arange(6, dtype=np.float32).reshape(2, 3, 1)}
    # Columns 4 to 6; rows 1 and 2 from the bottom are 7 and 8 of 10 from the top.
    write_exr(tmp_path / "a.exr", layers, {}, Frame(width=20, height=10, x=4, y=1))
    with OpenEXR.File(str(tmp_path / "a.exr"), separate_channels=True) as file:
        windows = [np.array(file.header()[f"{name}Window"]) for name in ("data", "display")]
        pixels = file.channels()["depth.Z"].pixels.copy()
    assert windows[0].tolist() == [[4, 7], [6, 8]]
    assert windows[1].tolist() == [[0, 0], [19, 9]]
    assert pixels.tolist() == [[3, 4, 5], [0, 1, 2]]


def test_a_layer_of_the_wrong_shape_is_refused(tmp_path: Path):
    with pytest.raises(ValueError, match="layer 'depth'"):
        write_exr(tmp_path / "a.exr", {"depth": np.zeros((2, 2, 3), np.float32)}, {})


def test_an_exr_that_cannot_be_written_is_an_os_error(tmp_path: Path):
    pixels = np.zeros((2, 2, 4), np.float32)
    with pytest.raises(OSError, match="cannot write"):
        write_exr(tmp_path / "no" / "a.exr", {"combined": pixels}, {})


def test_srgb_at_the_values_of_the_standard():
    # IEC 61966-2-1: the two pieces meet at 0.0031308; 0.214041 displays as one half.
    linear = np.array([0.0, 0.0031308, 0.2140411, 1.0, 7.0, -1.0])
    assert srgb(linear) == pytest.approx([0, 0.04045, 0.5, 1, 1, 0], abs=1e-5)
    levels = np.arange(256) / 255
    inverse = np.where(levels <= 0.04045, levels / 12.92, ((levels + 0.055) / 1.055) ** 2.4)
    assert np.rint(srgb(inverse) * 255).tolist() == list(range(256))


def test_png_divides_by_alpha_and_survives_what_is_not_finite(tmp_path: Path):
    pixels = np.zeros((1, 4, 4), np.float32)
    pixels[0, 0] = (0.5, 0.0, 0.0, 0.5)
    pixels[0, 1] = (np.nan, np.inf, -1.0, 1.0)
    pixels[0, 2] = (1.0, 1.0, 1.0, 1.0)
    write_png(tmp_path / "a.png", pixels, {"scene": "box"})
    with Image.open(tmp_path / "a.png") as image:
        assert image.mode == "RGBA"
        assert image.info["scene"] == "box"
        read = np.asarray(image)[0].tolist()
    assert read == [[255, 0, 0, 128], [0, 255, 0, 255], [255] * 4, [0] * 4]
