"""Whether two engines show the same picture, within a stated confidence.

Three questions to each scene, of independent seeds of both engines:

- **mean**: do the image's means differ by at most 0.5 % in every channel? A channel below a
  tenth of the brightest one is held to 0.5 % of that tenth.
- **blocks**: t-tests (Welch) of the means of 8x8-pixel blocks, Holm-corrected over the
  blocks and channels of the scene. What photon maps gave may be biased (the gather radius is
  not zero after a finite number of passes), so a block may differ by `PHOTON_BIAS` of that
  part; and every block by `ROUNDING` of the image's mean, for tables and float32.
- **sharpness**: the standard error of the mean's difference must be below a third of what is
  allowed, or the test would say nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import stats

Image = NDArray[np.float64]

#: Allowed difference of the image's mean.
MEAN = 0.005
#: Probability that one right scene fails by chance; 200 scenes then fail with 4 %.
LEVEL = 2e-4
BLOCK = 8
#: Allowed bias of what photon maps gave to a block, as a share of it.
PHOTON_BIAS = 0.02
#: Allowed difference of any block, as a share of the image's mean.
ROUNDING = 0.001


@dataclass(frozen=True)
class Verdict:
    """Outcome of one scene: ``state`` is "pass", "fail", "noisy", or of
    the runner "unsupported", "error" or "differs" (and Cycles is not the judge).

    ``difference`` (ours - theirs) / theirs per channel; ``error`` its standard error;
    ``z`` the largest deviation of a block in standard errors, beyond what is allowed;
    ``p`` its Holm-corrected probability; ``photons`` the share of light by photon maps.
    """

    state: str
    difference: tuple[float, float, float] = (0.0, 0.0, 0.0)
    error: float = 0.0
    z: float = 0.0
    p: float = 1.0
    photons: float = 0.0
    why: str = ""


def blocks(images: Image) -> Image:
    """Means (..., rows, columns, 3) of blocks of images (..., h, w, 3)."""
    *more, height, width, channels = images.shape
    shape = (*more, height // BLOCK, BLOCK, width // BLOCK, BLOCK, channels)
    return images.reshape(shape).mean(axis=(-4, -2))


def welch(ours: Image, theirs: Image, allowed: Image) -> tuple[Image, Image]:
    """t and p of |mean(ours) - mean(theirs)| > allowed, seeds along the first axis."""
    errors = [x.var(axis=0, ddof=1) / len(x) for x in (ours, theirs)]
    total = errors[0] + errors[1]
    excess = np.abs(ours.mean(axis=0) - theirs.mean(axis=0)) - allowed
    with np.errstate(divide="ignore", invalid="ignore"):
        t = np.where(excess > 0, excess / np.sqrt(total), 0.0)
        shares = sum(e**2 / (len(x) - 1) for e, x in zip(errors, (ours, theirs), strict=True))
        freedom = np.where(shares > 0, total**2 / shares, 1.0)
    return t, 2.0 * stats.t.sf(t, np.maximum(freedom, 1.0))


def compare(ours: Image, theirs: Image, photons: Image) -> Verdict:
    """Judge images (seeds, h, w, 3) of two engines; ``photons`` (h, w, 3) as in ``Verdict``."""
    if not (np.isfinite(ours).all() and np.isfinite(theirs).all()):
        return Verdict("fail", why="a pixel is NaN or infinite")
    means, others = ours.mean(axis=(1, 2)), theirs.mean(axis=(1, 2))
    scale = np.maximum(others.mean(axis=0), 0.1 * others.mean(axis=0).max())
    if scale.max() <= 0:
        return Verdict("fail", why="Cycles' image is black")
    difference = (means.mean(axis=0) - others.mean(axis=0)) / scale
    variance = sum(x.var(axis=0, ddof=1) / len(x) for x in (means, others))
    error = float((np.sqrt(variance) / scale).max())
    allowed = PHOTON_BIAS * blocks(photons) + ROUNDING * others.mean()
    t, p = welch(blocks(ours), blocks(theirs), allowed)
    # Holm: the smallest p of a family of n counts n times.
    corrected = min(1.0, float(p.min()) * p.size)
    share = float(photons.mean() / ours.mean()) if ours.mean() > 0 else 0.0
    facts: dict[str, Any] = {
        "difference": tuple(float(d) for d in difference), "error": error,
        "z": float(t.max()), "p": corrected, "photons": share,
    }  # fmt: skip
    reasons = []
    worst = float(np.abs(difference).max())
    if worst > MEAN:
        reasons.append(f"mean differs by {100 * worst:.2f} %")
    if corrected < LEVEL:
        row, column, channel = np.unravel_index(int(p.argmin()), p.shape)
        reasons.append(
            f"block ({row}, {column}) channel {channel}: z = {t.max():.1f}, p = {corrected:.1g}"
        )
    if reasons:
        return Verdict("fail", why="; ".join(reasons), **facts)
    if error > MEAN / 3:
        return Verdict("noisy", why=f"standard error {100 * error:.2f} %", **facts)
    return Verdict("pass", **facts)
