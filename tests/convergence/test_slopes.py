"""Each layer's error falls as its theory says, and never stops at a floor."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from photon_map.tests.convergence.slopes import borders, fit, measure, snapshots


@pytest.mark.parametrize("layer", ["emission", "direct"])
def test_layers_without_photons_fall_as_one_over_the_passes_or_faster(layer):
    """-1 for independent samples; scrambled Sobol points do better where light is smooth.

    So -0.9 is the bound on the slow side, at a level of 0.5 %, and there is none on the other
    (Owen 1997: up to -3 for smooth integrands).
    """
    found = measure(layer, seeds=6, passes=(4, 8, 16, 32, 64, 128))
    assert found.high < -0.9
    # No bias: what is left of it is within the noise of its estimate.
    assert (found.bias2[-2:] < 0.5 * found.variance[-2:]).all()


def test_corners_and_edges_of_a_glowing_box_are_not_dark():
    """Discs stick out over them by up to three quarters: 3 % of all light, were it lost."""
    scene, truth = borders()
    means = np.array(
        [snapshots(scene, "indirect", (16,), k, photons_global=8192).mean() for k in range(8)]
    )
    error = means.std(ddof=1) / np.sqrt(8) / truth.mean()
    assert error < 0.006, "the test would see nothing"
    # t of 7 degrees of freedom at a level of 0.1 %.
    assert abs(means.mean() / truth.mean() - 1) < 5.4 * error


@pytest.mark.slow
def test_even_discs_of_caustics_fall_as_their_radius_lets_them():
    """Noise and squared bias both go as i^(-2/3) at alpha 2/3 (Knaus and Zwicker 2011)."""
    found = measure("even discs", seeds=8)
    assert -0.75 <= found.slope <= -0.6
    assert found.high - found.low < 0.3
    assert found.last < -0.5, "it stops at a floor"
    assert fit(found.passes, found.variance) < -0.55
    assert fit(found.passes, np.maximum(found.bias2, 1e-12)) < -0.4


@pytest.mark.slow
def test_crowded_discs_of_caustics_fall_as_one_over_the_passes():
    """A crowded disc is r_0 sqrt(8 / n) wide in all passes until those that shrink are smaller.

    They are r_0 (i^-1/3)^1/2 at alpha 2/3, so the crowded ones stay through pass (n / 8)^3:
    means of equal estimates, whose variance goes as 1 / i, with the bias of a small disc.
    Here n is about 350 under the pane, and the passes would be 80 000.
    """
    found = measure("crowded discs", seeds=8)
    assert -1.05 <= found.slope <= -0.9
    assert found.high - found.low < 0.3
    assert found.last < -0.9
    # The bias that stays is that of discs of 8 photons in 350, a fortieth of the area.
    assert (found.bias2 < 0.1 * found.mse).all()


@pytest.mark.slow
def test_connected_caustics_fall_as_one_over_the_passes():
    """Photons connected with the camera blur nothing: noise alone is left."""
    found = measure("caustics", seeds=8)
    assert -1.15 <= found.slope <= -0.85
    assert found.high - found.low < 0.3
    assert found.last < -0.8, "it stops at a floor"
    assert (found.bias2 < 0.1 * found.mse).all()


@pytest.mark.slow
@pytest.mark.parametrize("case", ["indirect", "borders"])
def test_the_indirect_layer_falls_as_one_over_the_passes(case):
    """Noise goes as i^-0.95, with the area of the discs; the bias is below it throughout."""
    found = measure(case, seeds=8)
    assert -1.05 <= found.slope <= -0.9
    assert found.high - found.low < 0.3
    assert found.last < -0.8, "it stops at a floor"
    # The mean is true to its standard error: t of 7 degrees of freedom at a level of 0.1 %.
    reach = stats.t.ppf(0.9995, 7) * found.offset_error
    assert (np.abs(found.offset) < reach).all()
    assert found.offset_error[-1] < 0.002, "the test would see nothing"
