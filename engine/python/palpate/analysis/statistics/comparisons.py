"""Comparisons of pairs of means."""

from collections.abc import Hashable
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy import special

from .distributions import t_for_coverage, t_two_sided
from .intervals import COVERAGE
from .types import EPSILON, Array


@dataclass(frozen=True)
class PairedT:
    """A t test of paired values. t, p, half_width and standard_error are NaN if all differences are
    equal to within rounding, or if there are fewer than two pairs."""

    pairs: int
    difference: float  # mean of a - b; NaN without a pair
    t: float
    df: float
    p: float  # two-sided
    half_width: float  # of the 95 % interval of the difference
    standard_error: float


def paired_t(a: ArrayLike, b: ArrayLike) -> PairedT:
    """a, b: values of the same participants in the same order; pairs with a NaN are left out."""
    both = np.stack([np.asarray(a, dtype=float), np.asarray(b, dtype=float)])
    both = both[:, ~np.isnan(both).any(axis=0)]
    n = both.shape[1]
    if n == 0:
        return PairedT(0, *[np.nan] * 6)
    rounding = (n + 2.0) * EPSILON * np.abs(both).max()  # a deviation rounds n + 2 times
    differences = both[0] - both[1]
    mean = float(differences.mean())
    mean = mean if abs(mean) > rounding else 0.0
    squares = float(np.square(differences - mean).sum())
    if n < 2 or not squares > n * rounding**2:
        return PairedT(n, mean, np.nan, n - 1.0, np.nan, np.nan, np.nan)
    error = np.sqrt(squares / (n - 1.0) / n)
    t = mean / error
    half_width = float(t_for_coverage(n - 1.0) * error)
    p = float(t_two_sided(t, n - 1.0))
    return PairedT(n, mean, float(t), n - 1.0, p, half_width, float(error))


def standardized(test: PairedT) -> tuple[float, float, float]:
    """The difference in standard deviations of the differences (Cohen's d_z = t / sqrt(n)), and the
    low and high end of its 95 % interval by the noncentral t, to 5 digits; NaN without a t."""
    if np.isnan(test.t):
        return np.nan, np.nan, np.nan
    root, tail = np.sqrt(test.pairs), 0.5 * (1.0 - COVERAGE)
    ends = [special.nctdtrinc(test.df, p, test.t) for p in (1.0 - tail, tail)]
    d, low, high = (float(f"{value / root:.5g}") for value in (test.t, *ends))
    return d, low, high


def fisher_plsd(
    means: "pd.Series[float]", counts: "pd.Series[int]", mean_square_error: float, error_df: float
) -> pd.DataFrame:
    """Fisher's protected least significant difference, one row for each pair of levels.

    means, counts: by level. The caller checks that the F of the factor is significant, which is the
    protection. Columns: first, second (levels), difference (first - second), t, p (two-sided, not
    adjusted), least_significant (the least difference with p <= 0.05).
    """
    pairs: list[tuple[Hashable, Hashable]] = list(combinations(means.index, 2))
    first, second = [list(side) for side in zip(*pairs)]
    errors = np.sqrt(
        mean_square_error * (1.0 / counts[first].to_numpy() + 1.0 / counts[second].to_numpy())
    )
    differences = means[first].to_numpy() - means[second].to_numpy()
    t = differences / errors
    return pd.DataFrame(
        {
            "first": first,
            "second": second,
            "difference": differences,
            "t": t,
            "p": t_two_sided(t, error_df),
            "least_significant": t_for_coverage(error_df) * errors,
        }
    )


def holm(p: ArrayLike) -> Array:
    """Holm's step-down adjustment (1979) of the p values of one family, in the order of p. A NaN
    stays NaN and does not count as a test."""
    raw = np.asarray(p, dtype=float)
    order = np.argsort(raw, kind="stable")[: np.count_nonzero(~np.isnan(raw))]
    adjusted = np.full(raw.shape, np.nan)
    factors = np.arange(order.size, 0, -1)
    adjusted[order] = np.minimum(1.0, np.maximum.accumulate(factors * raw[order]))
    return adjusted
