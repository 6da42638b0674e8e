"""Texture lookups: closed forms at texel centres and borders, and what must always hold."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from photon_map.core.bsdf.albedo import no_albedo_tables
from photon_map.core.scene.tables import (
    CLOSURE,
    IMAGE,
    PARAM,
    TEXTURE,
    Channel,
    Extension,
    ImageKind,
)
from photon_map.core.textures.sampling import (
    param_color,
    param_number,
    sample_texture,
    sample_uv,
    srgb_to_linear,
)
from photon_map.core.textures.shading import ShadingTables

IDENTITY = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]


def tables(pixels: np.ndarray, kind: ImageKind, **use: object) -> ShadingTables:
    """One image of ``pixels`` (H, W, 4) and one use of it, and one triangle of UVs."""
    image = np.zeros(1, IMAGE)
    image["height"], image["width"] = pixels.shape[:2]
    image["kind"] = kind
    texture = np.zeros(1, TEXTURE)
    texture["to_image"] = IDENTITY
    for key, value in use.items():
        texture[key] = value
    floats = kind in (ImageKind.FLOATS, ImageKind.SRGB_FLOATS)
    flat = pixels.reshape(-1, 4)
    return ShadingTables(
        closures=np.zeros(0, CLOSURE),
        textures=texture,
        images=image,
        texels8=np.zeros((0, 4), np.uint8) if floats else flat.astype(np.uint8),
        texels32=flat.astype(np.float32) if floats else np.zeros((0, 4), np.float32),
        uvs=np.array([[[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]]], np.float32),
        albedo=no_albedo_tables(),
    )


#: Two rows of three texels, all different.
PIXELS = np.arange(24.0).reshape(2, 3, 4)


def test_linear_interpolation_meets_the_texels_at_their_middles_and_means_between() -> None:
    shading = tables(PIXELS, ImageKind.FLOATS)
    for j in range(2):
        for i in range(3):
            got = sample_uv(shading, 0, (i + 0.5) / 3, (j + 0.5) / 2)
            assert got == pytest.approx(PIXELS[j, i], abs=1e-9)
    assert sample_uv(shading, 0, 1 / 3, 0.25) == pytest.approx(PIXELS[0, :2].mean(axis=0))
    assert sample_uv(shading, 0, 1 / 3, 0.5) == pytest.approx(PIXELS[:, :2].mean(axis=(0, 1)))


def test_closest_is_constant_on_each_texel() -> None:
    shading = tables(PIXELS, ImageKind.FLOATS, interpolation=1)
    for x in (0.001, 0.5, 0.999):
        assert sample_uv(shading, 0, (1 + x) / 3, (1 + x) / 2) == tuple(PIXELS[1, 1])


#: What row of a picture of 3 shows at the places -4 .. 6.
SHOWN = {
    Extension.REPEAT: [2, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0],
    Extension.EXTEND: [0, 0, 0, 0, 0, 1, 2, 2, 2, 2, 2],
    Extension.CLIP: [None] * 4 + [0, 1, 2] + [None] * 4,
    Extension.MIRROR: [2, 2, 1, 0, 0, 1, 2, 2, 1, 0, 0],
}


@pytest.mark.parametrize("extension", Extension)
@pytest.mark.parametrize("interpolation", [0, 1])
def test_extensions(extension: Extension, interpolation: int) -> None:
    shading = tables(PIXELS, ImageKind.FLOATS, extension=extension, interpolation=interpolation)
    texels = [
        np.zeros(4) if i is None else PIXELS[0, i].astype(float) for i in SHOWN[extension]
    ]
    for place, expected in zip(range(-4, 7), texels, strict=True):
        got = sample_uv(shading, 0, (place + 0.5) / 3, 0.25)
        assert got == pytest.approx(expected, abs=1e-9)
    if interpolation == 0:  # halfway from one texel to the next, over the borders too
        for place in range(-4, 6):
            middle = (texels[place + 4] + texels[place + 5]) / 2
            got = sample_uv(shading, 0, (place + 1) / 3, 0.25)
            assert got == pytest.approx(middle, abs=1e-9)


def test_bytes_are_filtered_as_stored_and_decoded_afterwards() -> None:
    pixels = np.array([[[0, 255, 128, 0], [255, 255, 64, 255]]])
    srgb = sample_uv(tables(pixels, ImageKind.SRGB_BYTES), 0, 0.5, 0.5)
    plain = sample_uv(tables(pixels, ImageKind.BYTES), 0, 0.5, 0.5)
    stored = [0.5, 1.0, 96 / 255, 0.5]
    assert plain == pytest.approx(stored)
    assert srgb == pytest.approx([*map(srgb_to_linear, stored[:3]), 0.5])
    assert srgb_to_linear(0.5) == pytest.approx(0.21404114)
    assert srgb_to_linear(0.04) == pytest.approx(0.04 / 12.92)
    assert srgb_to_linear(-1.0) == 0.0


def test_alpha_is_divided_out_between_filter_and_decoding() -> None:
    pixels = np.array([[[0.25, 0.5, 0.0, 0.5], [0.0, 0.0, 0.0, 0.0]]])
    shading = tables(pixels, ImageKind.SRGB_FLOATS, unassociate=1)
    assert sample_uv(shading, 0, 0.5, 0.5) == pytest.approx([srgb_to_linear(0.5), 1.0, 0, 0.25])
    assert sample_uv(shading, 0, 0.75, 0.5) == (0.0, 0.0, 0.0, 0.0)


def test_coordinates_go_through_the_faces_uvs_and_the_mapping() -> None:
    turn = [[0.0, 1.0, 0.0], [2.0, 0.0, 0.125]]
    shading = tables(PIXELS, ImageKind.FLOATS, to_image=turn)
    assert sample_texture(shading, 0, 0, 0.2, 0.3) == sample_uv(shading, 0, 0.2, 0.3)
    plain = tables(PIXELS, ImageKind.FLOATS)
    assert sample_uv(shading, 0, 0.2, 0.3) == pytest.approx(
        sample_uv(plain, 0, 0.3, 2 * 0.2 + 0.125)
    )


def test_a_missing_uv_set_is_the_origin() -> None:
    shading = tables(PIXELS, ImageKind.FLOATS, uv=7)
    assert sample_texture(shading, 0, 0, 0.2, 0.3) == sample_uv(shading, 0, 0.0, 0.0)


def test_parameters() -> None:
    pixels = np.array([[[0.5, 0.25, 0.125, 0.75]]])
    shading = tables(pixels, ImageKind.FLOATS)
    param = np.zeros(1, PARAM)
    param["value"] = (2.0, 4.0, 8.0)
    param["texture"] = -1
    assert param_color(shading, param[0], 0, 0.1, 0.1) == (2.0, 4.0, 8.0)
    assert param_number(shading, param[0], 0, 0.1, 0.1) == 2.0
    param["texture"] = 0
    assert param_color(shading, param[0], 0, 0.1, 0.1) == pytest.approx([1.0, 1.0, 1.0])
    luma = 0.2126 * 0.5 + 0.7152 * 0.25 + 0.0722 * 0.125
    expected = {
        Channel.COLOR: luma,
        Channel.LUMINANCE: luma,
        Channel.ALPHA: 0.75,
        Channel.RED: 0.5,
        Channel.GREEN: 0.25,
        Channel.BLUE: 0.125,
    }
    for channel in Channel:
        param["channel"] = channel
        number = expected[channel]
        assert param_number(shading, param[0], 0, 0.1, 0.1) == pytest.approx(2 * number)
        if channel != Channel.COLOR:
            got = param_color(shading, param[0], 0, 0.1, 0.1)
            assert got == pytest.approx([2 * number, 4 * number, 8 * number])


COORDINATES = st.floats(allow_nan=True, allow_infinity=True)


@settings(max_examples=300, deadline=None, derandomize=True)
@given(COORDINATES, COORDINATES, st.sampled_from(Extension), st.integers(0, 1))
def test_any_coordinate_gives_a_mean_of_texels(
    s: float, t: float, extension: Extension, interpolation: int
) -> None:
    shading = tables(PIXELS, ImageKind.FLOATS, extension=extension, interpolation=interpolation)
    got = np.array(sample_uv(shading, 0, s, t))
    assert np.isfinite(got).all()
    low = 0.0 if extension == Extension.CLIP else PIXELS[..., 0].min()
    assert low - 1e-6 <= got[0] <= PIXELS[..., 0].max() + 1e-6


@settings(max_examples=200, deadline=None, derandomize=True)
@given(
    st.floats(-3, 3),
    st.floats(-3, 3),
    st.sampled_from([Extension.REPEAT, Extension.EXTEND, Extension.CLIP, Extension.MIRROR]),
)
def test_linear_lookups_are_continuous(s: float, t: float, extension: Extension) -> None:
    shading = tables(PIXELS, ImageKind.FLOATS, extension=extension)
    here = np.array(sample_uv(shading, 0, s, t))
    near = np.array(sample_uv(shading, 0, s + 1e-7, t - 1e-7))
    # The steepest slope: all of the range within one texel, in x and in y.
    assert abs(here - near).max() <= 23.0 * (3 + 2) * 1.1e-7 + 1e-9


@settings(max_examples=100, deadline=None, derandomize=True)
@given(st.floats(0, 1), st.floats(0, 1), st.integers(-3, 3))
def test_repeating_has_its_period(s: float, t: float, periods: int) -> None:
    shading = tables(PIXELS, ImageKind.FLOATS)
    here = sample_uv(shading, 0, s, t)
    assert sample_uv(shading, 0, s + periods, t) == pytest.approx(here, abs=1e-9)
    assert not any(map(math.isnan, here))
