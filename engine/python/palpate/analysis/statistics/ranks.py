"""Tests of ratings, by ranks: Friedman's of several conditions, and Wilcoxon's of pairs.

SciPy's exact distribution of Wilcoxon's test is for differences without ties, which ratings have;
here it is that of the ranks that there are.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats

from .intervals import COVERAGE
from .types import Array


@dataclass(frozen=True)
class Friedman:
    """Friedman's test (1937), with ties, by the chi-squared distribution; NaN with fewer than two
    participants or three conditions, and if nobody rates two conditions differently."""

    participants: int
    chi2: float
    df: float
    p: float
    kendall_w: float  # agreement between participants: chi2 / (participants (conditions - 1))


def friedman(table: ArrayLike) -> Friedman:
    """table: (participants, conditions); participants with a NaN are left out."""
    values = np.asarray(table, dtype=float)
    values = values[~np.isnan(values).any(axis=1)]
    n, k = values.shape
    if n < 2 or k < 3 or not np.ptp(values, axis=1).any():
        return Friedman(n, np.nan, k - 1.0, np.nan, np.nan)
    test = stats.friedmanchisquare(*values.T)
    chi2 = float(test.statistic)
    return Friedman(n, chi2, k - 1.0, float(test.pvalue), chi2 / (n * (k - 1.0)))


@dataclass(frozen=True)
class SignedRank:
    """Wilcoxon's signed-rank test (1945) of paired values.

    Pairs that are equal are left out of w, p and r; ties have their mean rank. Equal means equal to
    the bit: values of a scale are whole numbers, and their sums.
    w: the sum of the ranks of positive differences. p: two-sided, of the exact distribution of w if
    each difference were as likely negative. r: the matched-pairs rank biserial correlation, (w -
    sum of the negative ranks) / sum of all ranks (Kerby, 2014, "The simple difference formula",
    Comprehensive Psychology 3). These are NaN without unequal pairs.
    difference: Hodges and Lehmann's estimate (1963), the median of the means of any two differences
    (and of each with itself), of all pairs; low, high: its interval by the exact distribution of
    signed ranks without ties, which covers at least 95 %. NaN with fewer than 6 pairs.
    """

    pairs: int
    unequal: int
    w: float
    p: float
    r: float
    difference: float
    low: float
    high: float


def signed_rank(a: ArrayLike, b: ArrayLike) -> SignedRank:
    """Of a - b: values of the same participants in the same order; pairs with a NaN are left out."""
    both = np.stack([np.asarray(a, dtype=float), np.asarray(b, dtype=float)])
    both = both[:, ~np.isnan(both).any(axis=0)]
    n = both.shape[1]
    if n == 0:
        return SignedRank(0, 0, *[np.nan] * 6)
    differences = both[0] - both[1]
    difference, low, high = _hodges_lehmann(differences)
    unequal = differences[differences != 0.0]
    if len(unequal) == 0:
        return SignedRank(n, 0, np.nan, np.nan, np.nan, difference, low, high)
    ranks = stats.rankdata(np.abs(unequal))
    w, total = float(ranks[unequal > 0.0].sum()), float(ranks.sum())
    return SignedRank(n, len(unequal), w, _p(ranks, w), (2.0 * w - total) / total, difference, low,
                      high)  # fmt: skip


def _distribution(ranks: Array) -> Array:
    """The probability of each sum of twice the ranks, which are whole numbers: each rank is in the
    sum or not, with equal chance."""
    chances: Array = np.ones(1)
    for rank in np.rint(2.0 * ranks).astype(int):
        chances = 0.5 * (np.pad(chances, (0, rank)) + np.pad(chances, (rank, 0)))
    return chances


def _p(ranks: Array, w: float) -> float:
    chances, at = _distribution(ranks), round(2.0 * w)
    return float(min(1.0, 2.0 * min(chances[: at + 1].sum(), chances[at:].sum())))


@cache
def _place(n: int) -> int:
    """The largest number k with P(W < k) <= 2.5 % for the signed ranks of n differences without
    ties: the ends of the interval are the kth smallest and largest mean of two differences."""
    below = np.cumsum(_distribution(np.asarray(range(1, n + 1), dtype=float))[::2])
    return int(np.searchsorted(below, 0.5 * (1.0 - COVERAGE), side="right"))


def _hodges_lehmann(differences: Array) -> tuple[float, float, float]:
    n = len(differences)
    i, j = np.triu_indices(n)
    means = np.sort(0.5 * (differences[i] + differences[j]))
    place = _place(n)
    if place == 0:
        return float(np.median(means)), np.nan, np.nan
    return float(np.median(means)), float(means[place - 1]), float(means[-place])
