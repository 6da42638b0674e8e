"""The suite's own judgement, on pictures whose difference is known."""

from __future__ import annotations

import numpy as np
import pytest

from tests.parity.compare import BLOCK, LEVEL, MEAN, blocks, compare

NONE = np.zeros((32, 32, 3))


def noisy(rng: np.random.Generator, noise: float = 0.05, seeds: int = 8) -> np.ndarray:
    """Images (seeds, 32, 32, 3) of mean 1 but for a gradient."""
    truth = np.linspace(0.5, 1.5, 32)[None, :, None, None] * np.ones((1, 1, 32, 3))
    return truth * rng.normal(1.0, noise, (seeds, 32, 32, 3))


def test_two_runs_of_one_thing_pass(rng: np.random.Generator) -> None:
    for _ in range(50):
        assert compare(noisy(rng), noisy(rng), NONE).state == "pass"


def test_a_mean_that_is_off_fails(rng: np.random.Generator) -> None:
    verdict = compare(noisy(rng) * (1.0 + 1.5 * MEAN), noisy(rng), NONE)
    assert verdict.state == "fail"
    assert verdict.difference[0] == pytest.approx(1.5 * MEAN, abs=5 * verdict.error)


def test_a_block_that_is_off_fails_though_the_mean_is_right(rng: np.random.Generator) -> None:
    ours = noisy(rng)
    ours[:, :BLOCK, :BLOCK, 1] *= 1.05
    ours[:, BLOCK : 2 * BLOCK, :BLOCK, 1] *= 0.96
    verdict = compare(ours, noisy(rng), NONE)
    assert verdict.state == "fail"
    assert verdict.p < LEVEL
    assert "block" in verdict.why


def test_photon_layers_may_be_a_little_biased(rng: np.random.Generator) -> None:
    ours = noisy(rng, 0.01)
    ours[:, :BLOCK, :BLOCK] *= 1.015
    assert compare(ours, noisy(rng, 0.01), NONE).state == "fail"
    assert compare(ours, noisy(rng, 0.01), np.ones((32, 32, 3))).state == "pass"


def test_noise_that_would_hide_an_error_is_no_pass(rng: np.random.Generator) -> None:
    assert compare(noisy(rng, 3.0), noisy(rng, 0.01), NONE).state in ("noisy", "fail")


def test_broken_pixels_fail(rng: np.random.Generator) -> None:
    ours = noisy(rng)
    ours[0, 3, 3, 0] = np.nan
    assert compare(ours, noisy(rng), NONE).state == "fail"
    assert compare(noisy(rng), np.zeros((8, 32, 32, 3)), NONE).state == "fail"


def test_blocks_are_means_of_their_pixels() -> None:
    image = np.arange(16 * 24 * 3, dtype=float).reshape(1, 16, 24, 3)
    means = blocks(image)
    assert means.shape == (1, 2, 3, 3)
    assert means[0, 1, 2, 0] == pytest.approx(image[0, 8:, 16:, 0].mean())
