"""The film's sums over many pixels, as kernels: they run while other threads trace."""

from __future__ import annotations

import math

from ..jit import Table, kernel


@kernel
def add_samples(
    total: Table, count: Table, part_sum: Table, part_count: Table, samples: Table, light: int
) -> int:
    """Add one sample to each pixel; the number of samples that were not finite.

    All rows belong to the same pixels: ``total`` and ``samples`` (n, C), ``count`` and
    ``part_count`` (n,), ``part_sum`` (n, 3) the sum of the first ``light`` columns by
    colour. A sample with a NaN or infinity counts as black.
    """
    bad = 0
    for k in range(len(samples)):
        count[k] += 1
        part_count[k] += 1
        finite = True
        for c in range(samples.shape[1]):
            finite = finite and math.isfinite(samples[k, c])
        if not finite:
            bad += 1
            continue
        for c in range(samples.shape[1]):
            total[k, c] += samples[k, c]
        for c in range(light):
            part_sum[k, c % 3] += samples[k, c]
    return bad


@kernel
def variance_of_mean(part_sum: Table, part_count: Table, out: Table, mean: Table) -> None:
    """Mean and variance of that mean for each pixel from its replicates' scatter.

    ``part_sum`` (R, n, 3), ``part_count`` (R, n); ``out`` and ``mean`` (n, 3). With one
    replicate the variance is infinite.
    """
    for k in range(len(out)):
        total = 0
        used = 0
        for r in range(len(part_count)):
            total += part_count[r, k]
            used += 1 if part_count[r, k] > 0 else 0
        for c in range(3):
            s = 0.0
            for r in range(len(part_count)):
                s += part_sum[r, k, c]
            m = s / max(total, 1)
            mean[k, c] = m
            scatter = 0.0
            for r in range(len(part_count)):
                if part_count[r, k] > 0:
                    gap = part_sum[r, k, c] / part_count[r, k] - m
                    scatter += part_count[r, k] * gap * gap
            out[k, c] = scatter / ((used - 1) * total) if used > 1 else math.inf


@kernel
def relative_mean(variance: Table, mean: Table) -> float:
    """mean(variance / (mean^2 + 0.01 mean(mean)^2)) over (n, 3); 0 for a black image."""
    whole = 0.0
    for k in range(len(mean)):
        whole += mean[k, 0] + mean[k, 1] + mean[k, 2]
    whole /= 3.0 * len(mean)
    floor = 0.01 * whole * whole
    total = 0.0
    for k in range(len(mean)):
        for c in range(3):
            scale = mean[k, c] * mean[k, c] + floor
            if scale > 0.0:
                total += variance[k, c] / scale
    return total / (3.0 * len(mean))
