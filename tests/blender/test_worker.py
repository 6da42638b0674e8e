"""What a viewport's worker renders first."""

from __future__ import annotations


def test_pictures_become_finer_step_by_step() -> None:
    from photon_map.addon.worker import FIRST_PIXELS, steps

    assert list(steps(1)) == [2]
    assert list(steps(650 * 470)) == [7]
    assert list(steps(1920 * 1080)) == [16, 4]
    assert all(n / next(steps(n)) ** 2 <= FIRST_PIXELS for n in range(9, 10**7, 99991))


def test_the_coarse_picture_has_few_photons() -> None:
    from photon_map.addon.worker import FIRST_PHOTONS, fewer
    from photon_map.core.settings import AUTOMATIC

    assert [fewer(n) for n in (AUTOMATIC, 0, 10, 10**6)] == [
        FIRST_PHOTONS, 0, 10, FIRST_PHOTONS,
    ]  # fmt: skip
