"""The film's sums over many pixels, as kernels: they run while other threads trace."""

from __future__ import annotations

import math

from ..jit import Table, kernel

#: Squared relative error of one pixel, at most: a lamp that one replicate alone has found in
#: a dark glass would else outweigh the whole image.
MOST = 25.0


@kernel
def add_samples(
    total: Table,
    count: Table,
    part_sum: Table,
    part_count: Table,
    part_caustics: Table,
    shrink: Table,
    ids: Table,
    samples: Table,
    light: int,
    caustics: int,
) -> int:
    """Add samples to the pixels ``ids`` (n,); the number of samples that were not finite.

    ``samples`` (n, C + 3); of all pixels: ``total`` (m, C), ``count`` and ``part_count``
    (m,), ``part_sum`` (m, 3) the sum of the first ``light`` columns by colour,
    ``part_caustics`` (m,) that of the three from ``caustics`` on, ``shrink`` (m, 3) that of
    the last three. A sample with a NaN or infinity counts as black.
    """
    columns = total.shape[1]
    bad = 0
    for row in range(len(samples)):
        k = ids[row]
        count[k] += 1
        part_count[k] += 1
        finite = True
        for c in range(samples.shape[1]):
            finite = finite and math.isfinite(samples[row, c])
        if not finite:
            bad += 1
            continue
        for c in range(columns):
            total[k, c] += samples[row, c]
        for c in range(3):
            shrink[k, c] += samples[row, columns + c]
        for c in range(light):
            part_sum[k, c % 3] += samples[row, c]
        for c in range(caustics, caustics + 3):
            part_caustics[k] += samples[row, c]
    return bad


@kernel
def scatter_of_parts(
    part_sum: Table, part_caustics: Table, part_count: Table, share: float, out: Table
) -> None:
    """Variance of the light of one path of each pixel, (n,), from its replicates' scatter.

    ``part_sum`` (R, n, 3) and ``part_caustics`` (R, n), which is a part of it: sums over
    ``part_count`` (R, n) paths; of the variance of caustics only a ``share`` counts. 0 with
    one replicate.
    """
    for k in range(len(out)):
        total = 0
        used = 0
        mean = 0.0
        caustic = 0.0
        for r in range(len(part_count)):
            total += part_count[r, k]
            used += 1 if part_count[r, k] > 0 else 0
            caustic += part_caustics[r, k]
            mean += part_sum[r, k, 0] + part_sum[r, k, 1] + part_sum[r, k, 2]
        mean = (mean - caustic) / max(total, 1)
        caustic /= max(total, 1)
        scatter = 0.0
        for r in range(len(part_count)):
            n = part_count[r, k]
            if n > 0:
                own = part_caustics[r, k]
                other = part_sum[r, k, 0] + part_sum[r, k, 1] + part_sum[r, k, 2] - own
                other = other / n - mean
                own = own / n - caustic
                scatter += n * (other * other + share * own * own)
        out[k] = scatter / (used - 1) if used > 1 else 0.0


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

    ``shrink`` (R, n, 3): what the estimates lose when their radius shrinks, summed over
    the passes of each replicate, of which ``part_count`` (R, n) tells the number. Two of them
    have nothing in common but their mean, so their product is its square in expectation; a
    single one may be negative.
    """
    for k in range(len(out)):
        for c in range(3):
            total = 0.0
            squares = 0.0
            used = 0
            for r in range(len(part_count)):
                if part_count[r, k] > 0:
                    s = shrink[r, k, c] / part_count[r, k]
                    total += s
                    squares += s * s
                    used += 1
            pairs = max(1, used * (used - 1))
            out[k, c] = factor * factor * (total * total - squares) / pairs


@kernel
def crossed_means(
    part_sum: Table, part_count: Table, shrink: Table, sharpen: float
) -> tuple[float, float]:
    """Means over (n, 3) of a pixel's variance and of its squared ``shrink``, each relative.

    Each replicate's part of the variance, and each product of two replicates' ``shrink``, is
    weighed by the light m of the other replicates: over m^2 + 0.01 mean^2, so that what
    chance brings to the ones is not weighed by itself. For the products, m is sharpened by
    what the discs lost, ``sharpen`` times. No pixel counts for more than ``MOST``.
    ``part_sum`` and ``shrink`` (R, n, 3),
    ``part_count`` (R, n) with passes in each replicate.
    """
    parts = len(part_count)
    pixels = part_sum.shape[1]
    whole = 0.0
    for k in range(pixels):
        count = 0
        s = 0.0
        for r in range(parts):
            count += part_count[r, k]
            s += part_sum[r, k, 0] + part_sum[r, k, 1] + part_sum[r, k, 2]
        whole += s / max(count, 1)
    whole /= 3.0 * pixels
    floor = 0.01 * whole * whole
    variance = 0.0
    product = 0.0
    for k in range(pixels):
        count = 0
        for r in range(parts):
            count += part_count[r, k]
        for c in range(3):
            total = 0.0
            lost = 0.0
            for r in range(parts):
                total += part_sum[r, k, c]
                lost += shrink[r, k, c]
            if total <= 0.0:
                continue
            mean = total / count
            own = 0.0
            pairs = 0.0
            for i in range(parts):
                n = part_count[i, k]
                light = (total - part_sum[i, k, c]) / (count - n)
                gap = part_sum[i, k, c] / n - mean
                own += n * gap * gap / ((parts - 1) * count * (light * light + floor))
                if lost == 0.0:
                    continue
                for j in range(i):
                    m = part_count[j, k]
                    light = total - part_sum[i, k, c] - part_sum[j, k, c]
                    light -= sharpen * (lost - shrink[i, k, c] - shrink[j, k, c])
                    light = max(0.0, light / (count - n - m))
                    pair = shrink[i, k, c] / n * (shrink[j, k, c] / m)
                    pairs += 2.0 * pair / (parts * (parts - 1) * (light * light + floor))
            variance += min(own, MOST)
            product += min(max(pairs, -MOST), MOST)
    size = 3.0 * pixels
    return variance / size, product / size


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
