"""Each layer's error falls as its theory says, and never stops at a floor."""

from __future__ import annotations

import numpy as np
import pytest

from photon_map.tests import scenes
from photon_map.tests.convergence.slopes import fit, measure, slope_of, snapshots


@pytest.mark.parametrize("layer", ["emission", "direct"])
def test_layers_without_photons_fall_as_one_over_the_passes_or_faster(layer):
    # -1 for independent samples; scrambled Sobol points do better where light is smooth.
    found = measure(layer, seeds=6, passes=(4, 8, 16, 32, 64, 128))
    assert found.high < -0.9
    # No bias: what is left of it is within the noise of its estimate.
    assert (found.bias2[-2:] < 0.5 * found.variance[-2:]).all()


@pytest.mark.slow
def test_the_caustic_layer_falls_as_its_radius_lets_it():
    """Noise and squared bias both go as i^(-2/3) at alpha 2/3 (Knaus and Zwicker 2011)."""
    found = measure("caustics", seeds=8, passes=(4, 8, 16, 32, 64, 128, 256))
    assert -0.75 <= found.slope <= -0.6 or (found.low < -0.6 and found.high > -0.75)
    assert found.high - found.low < 0.3
    assert found.last < -0.5, "it stops at a floor"
    assert fit(found.passes, found.variance) < -0.55
    assert fit(found.passes, np.maximum(found.bias2, 1e-12)) < -0.4


@pytest.mark.slow
def test_the_indirect_layer_falls_where_no_edge_is_near():
    """In a ball all gather rays see the same: photon noise alone, i^(-alpha)."""
    found = measure("indirect", seeds=6, passes=(4, 8, 16, 32, 64, 128))
    assert found.low < -2 / 3 + 0.1 and found.high < -0.45
    assert found.last < -0.45, "it stops at a floor"


@pytest.mark.slow
def test_the_bias_of_the_indirect_layer_falls_at_edges():
    """In a glowing box discs stick out over the edges: less and less of each disc's light."""
    passes = (8, 64, 512)
    truth = np.full((8, 8), 0.5)
    scene = scenes.furnace_box(0.5, 1.0, 8)
    runs = np.array(
        [snapshots(scene, "indirect", passes, k, photons_global=8192) for k in range(4)]
    )
    found = slope_of("indirect", runs, truth, passes)
    assert found.last < -0.35, "it stops at a floor"
    means = np.abs(runs.mean(axis=(0, 2, 3)) / 0.5 - 1)
    assert means[2] < 0.7 * means[0] or means[2] < 0.003
