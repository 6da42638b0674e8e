"""The film's sums over many pixels, as kernels: they run while other threads trace."""

from __future__ import annotations

import math

from ..jit import Table, kernel


@kernel
def add_samples(
    total: Table,
    count: Table,
    part_sum: Table,
    part_count: Table,
    shrink: Table,
    samples: Table,
    light: int,
) -> int:
    """Add one sample to each pixel; the number of samples that were not finite.

    All rows belong to the same pixels: ``samples`` (n, C + 3), ``total`` (n, C),
    ``count`` and ``part_count`` (n,), ``part_sum`` (n, 3) the sum of the first ``light``
    columns by colour, ``shrink`` (n, 3) that of the last three. A sample with a NaN or
    infinity counts as black.
    """
    columns = total.shape[1]
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
        for c in range(columns):
            total[k, c] += samples[k, c]
        for c in range(3):
            shrink[k, c] += samples[k, columns + c]
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
def bias_square(shrink: Table, part_count: Table, factor: float, out: Table) -> None:
    """Squared bias of each pixel, (n, 3), without the noise of its estimate.

    ``shrink`` (2, n, 3): what the estimates lose when their radius shrinks, summed over
    the even and over the odd replicates of ``part_count`` (R, n). The two halves have
    nothing in common but their mean, so their product is its square in expectation; a
    single one may be negative.
    """
    for k in range(len(out)):
        even = 0
        odd = 0
        for r in range(0, len(part_count), 2):
            even += part_count[r, k]
            odd += part_count[r + 1, k]
        for c in range(3):
            a = shrink[0, k, c] / max(even, 1)
            b = shrink[1, k, c] / max(odd, 1)
            out[k, c] = factor * factor * a * b


@kernel
def relative_mean(square: Table, mean: Table, skew: float) -> float:
    """mean(q + skew q^2), q = square / (mean^2 + 0.01 mean(mean)^2), over (n, 3).

    0 for a black image. ``skew`` undoes, to first order, that a pixel whose bright samples
    have come stands out in ``square`` and is weighed by a ``mean`` too large.
    """
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
                q = square[k, c] / scale
                total += q + skew * q * q
    return total / (3.0 * len(mean))
