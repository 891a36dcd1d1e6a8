"""Confidence intervals of means within participants, of means, and of shares."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from .distributions import t_for_coverage, z_for_coverage
from .types import EPSILON, Array, Numbers

COVERAGE = 0.95
SIGNIFICANCE = 0.05


def cousineau_morey(table: ArrayLike) -> Array:
    """Half widths of the 95 % intervals of the means of the columns, within participants.

    table: (..., participants, conditions), complete. Differences between participants are removed
    from the values (Cousineau, 2005), and the variance is multiplied by k / (k - 1), where k is
    the number of columns (Morey, 2008). NaN with fewer than two rows or columns.
    """
    values = np.asarray(table, dtype=float)
    n, k = values.shape[-2:]
    if n < 2 or k < 2:
        return np.full(values.shape[:-2] + (k,), np.nan)
    rounding = (n + k) * EPSILON * np.abs(values).max(axis=(-2, -1), keepdims=True)[..., 0, :]
    values = values - values.mean(axis=(-2, -1), keepdims=True)  # rounds less
    normalised = values - values.mean(axis=-1, keepdims=True)
    sd: Array = normalised.std(axis=-2, ddof=1)
    sd = np.where(sd > rounding, sd, 0.0)
    return np.asarray(t_for_coverage(n - 1.0) * sd * np.sqrt(k / (k - 1.0) / n))


@dataclass(frozen=True)
class MeanInterval:
    """The mean of normal values, and half of its 95 % interval by Student's t."""

    mean: float  # NaN if count is 0
    half_width: float  # NaN if count is below 2
    count: int

    def excludes_zero(self) -> bool:
        """Whether the interval does not hold 0; false without an interval."""
        return abs(self.mean) > self.half_width


def mean_interval(values: ArrayLike) -> MeanInterval:
    """values: one axis; NaN are left out."""
    there = np.asarray(values, dtype=float)
    there = there[~np.isnan(there)]
    n = there.size
    mean = float(there.mean()) if n else np.nan
    if n < 2:
        return MeanInterval(mean, np.nan, n)
    half_width = t_for_coverage(n - 1.0) * there.std(ddof=1) / np.sqrt(n)
    return MeanInterval(mean, float(half_width), n)


def wilson(count: Numbers, all_: Numbers) -> tuple[Any, Any]:
    """Low and high end of Wilson's 95 % interval (1927) of the share count / all_; 0 and 1 if
    all_ is 0."""
    n = np.asarray(all_, dtype=float)
    hits = np.asarray(count, dtype=float)
    safe = np.maximum(n, 1.0)
    share, z2 = hits / safe, z_for_coverage(COVERAGE) ** 2
    centre = (share + 0.5 * z2 / safe) / (1.0 + z2 / safe)
    half = np.sqrt(z2 * (share * (1.0 - share) + 0.25 * z2 / safe) / safe) / (1.0 + z2 / safe)
    low = np.where(hits == 0, 0.0, np.maximum(0.0, centre - half))  # exact at a share of 0 or 1
    high = np.where(hits == n, 1.0, np.minimum(1.0, centre + half))
    return np.where(n > 0, low, 0.0)[()], np.where(n > 0, high, 1.0)[()]


def clopper_pearson(count: Numbers, all_: Numbers) -> tuple[Any, Any]:
    """Low and high end of the exact 95 % interval (Clopper and Pearson, 1934) of count / all_."""
    k, n = np.asarray(count, dtype=float), np.asarray(all_, dtype=float)
    tail = 0.5 * (1.0 - COVERAGE)
    low = special.betaincinv(np.maximum(k, 1.0), n - k + 1.0, tail)
    high = special.betaincinv(k + 1.0, np.maximum(n - k, 1.0), 1.0 - tail)
    return np.where(k > 0, low, 0.0)[()], np.where(k < n, high, 1.0)[()]
