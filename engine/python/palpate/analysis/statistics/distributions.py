"""Tails and quantiles of F and t. Arguments outside a distribution's domain give NaN.

Quantiles come from the inverse of the incomplete beta function, with the tail itself as argument:
of SciPy 1.10, stats.f.isf inverts 1 - tail, which is infinite below a tail of 1e-16, and
stats.t.isf (stdtrit) is wrong by 1e-9 of 1 and more at small t. scipy.special alone is imported in a third of
the time of scipy.stats.
"""

from typing import Any

import numpy as np
from scipy import special

from .types import EPSILON, Array, Numbers

_MOST_STEPS = 20
_LEAST_LOG = float(np.log(np.finfo(float).smallest_subnormal))
_HALVINGS = 60  # leave a part of 1e-18 of the range of logarithms


def f_tail(f: Numbers, df1: Numbers, df2: Numbers) -> Any:
    """P(F > f) for Fisher's F; the degrees of freedom need not be integers."""
    return special.fdtrc(df1, df2, f)


def f_for_tail(tail: Numbers, df1: Numbers, df2: Numbers) -> Any:
    """The f with P(F > f) = tail; tail in (0, 1). Infinite beyond the largest number. The incomplete
    beta function of SciPy 1.10 leaves a relative error of 1e-10 at 1e6 degrees of freedom."""
    odds = _odds(np.divide(df1, 2.0), np.divide(df2, 2.0), np.subtract(1.0, tail), tail)
    return np.divide(df2, df1) * odds


def _odds(a: Numbers, b: Numbers, below: Numbers, above: Numbers) -> Any:
    """y / (1 - y) with the incomplete beta function I_y(a, b) = below, and above = 1 - below. Of y
    and 1 - y, the one is computed that leaves more digits: above and 1 - y, or below and y, have
    an absolute rounding."""
    y, rest = _beta_quantile(a, b, below), _beta_quantile(b, a, above)
    with np.errstate(divide="ignore", over="ignore"):  # beyond the smallest and largest numbers
        takes_y = np.divide(1.0, above) + 1.0 / rest < np.divide(1.0, below) + 1.0 / y
        return np.where(takes_y, y / (1.0 - y), (1.0 - rest) / rest)[()]


def _beta_quantile(a: Numbers, b: Numbers, p: Numbers) -> Array:
    """x with I_x(a, b) = p. That of SciPy 1.10 has an error of 3e-4 at small x, and none of its
    digits at p = 1e-30 and a = 324: the start is then found by halving the range of log x, and
    Newton's steps of log p by log x converge, because I is log-concave."""
    x = np.asarray(special.betaincinv(a, b, p))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore", under="ignore"):
        is_far = ~(np.abs(np.log(special.betainc(a, b, x) / p)) < 0.1) & ~np.isnan(x)
        if is_far.any():
            x = np.where(is_far, _between_halves(a, b, p, x.shape), x)
        for _ in range(_MOST_STEPS):
            found = special.betainc(a, b, x)
            log_density = a * np.log(x) + np.subtract(b, 1.0) * np.log1p(-x) - special.betaln(a, b)
            step = np.log(found / p) * found / np.exp(log_density)  # of log x
            moved = x * np.exp(-step)
            x = np.where((moved > 0.0) & (moved < 1.0), moved, x)
            if not (np.abs(step) > 8.0 * EPSILON).any():
                break
    return x


def _between_halves(a: Numbers, b: Numbers, p: Numbers, shape: tuple[int, ...]) -> Array:
    """x with I_x(a, b) = p, to the digits that halving leaves."""
    low, high = np.full(shape, _LEAST_LOG), np.zeros(shape)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        is_below = special.betainc(a, b, np.exp(middle)) < p
        low, high = np.where(is_below, middle, low), np.where(is_below, high, middle)
    return np.exp(high)


def t_two_sided(t: Numbers, df: Numbers) -> Any:
    """P(|T| > |t|) for Student's t."""
    return 2.0 * special.stdtr(df, -np.abs(t))


def t_tail(t: Numbers, df: Numbers) -> Any:
    """P(T > t) for Student's t."""
    return special.stdtr(df, np.negative(t))


def t_for_coverage(df: Numbers, coverage: float = 0.95) -> Any:
    """The t with P(|T| > t) = 1 - coverage; NaN unless coverage is in (0, 1) and df > 0."""
    df = np.where(np.greater(df, 0.0) & (0.0 < coverage < 1.0), df, np.nan)
    return np.sqrt(df * _odds(0.5, df / 2.0, coverage, 1.0 - coverage))[()]


def z_for_coverage(coverage: float = 0.95) -> float:
    """The z with P(|Z| > z) = 1 - coverage for the standard normal distribution."""
    return float(special.ndtri(0.5 + 0.5 * coverage))
