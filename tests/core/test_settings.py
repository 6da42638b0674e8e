from __future__ import annotations

import math
from dataclasses import FrozenInstanceError, fields, replace

import pytest

from photon_map.core.settings import Settings, SettingsError


def test_defaults_are_valid_and_frozen():
    settings = Settings()
    assert settings.thread_count >= 1
    assert replace(settings, threads=3).thread_count == 3
    with pytest.raises(FrozenInstanceError):
        settings.passes = 2  # type: ignore[misc]


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("passes", 0),
        ("seconds", -1.0),
        ("error_goal", -0.1),
        ("seed", -1),
        ("seed", 2**31),
        ("threads", -1),
        ("photons_global", -2),
        ("photons_caustic", -2),
        ("gather_rays", 0),
        ("light_samples", 0),
        ("light_samples", 1025),
        ("camera_depth", 0),
        ("photon_depth", 0),
        ("min_throughput", 1.5),
        ("caustic_radius", 0.0),
        ("alpha", 0.0),
        ("filter_width", 0.0),
        ("chunk_size", 0),
    ],
)
def test_a_value_out_of_range_is_named_with_its_range(name: str, value: float):
    with pytest.raises(SettingsError, match=rf"{name} is {value}, it must be from \S+ to \S+"):
        Settings(**{name: value})


def test_no_number_setting_takes_nan_or_infinity():
    numbers = [f.name for f in fields(Settings) if isinstance(f.default, (int, float))]
    for name in ("adaptive", "transparent", "draft", "focus", "guide", "learn_aim"):
        numbers.remove(name)
    assert len(numbers) >= 14
    for name in numbers:
        for value in (math.nan, math.inf):
            with pytest.raises(SettingsError, match=name):
                Settings(**{name: value})


@pytest.mark.parametrize("region", [(0, 0, 0, 5), (5, 0, 2, 3), (-1, 0, 2, 2), (0, 3, 4, 3)])
def test_a_region_without_pixels_is_refused(region: tuple[int, int, int, int]):
    with pytest.raises(SettingsError, match="has no pixel"):
        Settings(region=region)


def test_an_unknown_filter_is_refused():
    with pytest.raises(SettingsError, match="pixel_filter is 'MITCHELL'"):
        Settings(pixel_filter="MITCHELL")  # type: ignore[arg-type]
