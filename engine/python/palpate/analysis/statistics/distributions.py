"""Tails and quantiles of F and t. Arguments outside a distribution's domain give NaN.

scipy.special is used, not scipy.stats: it is imported in a third of the time, and its stdtrit has
errors of 2e-9, so that quantiles of t come from the incomplete beta function.
"""

from typing import Any

import numpy as np
from scipy import special

from .types import Array, Numbers


def f_tail(f: Numbers, df1: Numbers, df2: Numbers) -> Any:
    """P(F > f) for Fisher's F; the degrees of freedom need not be integers."""
    return special.fdtrc(df1, df2, f)


def f_for_tail(tail: Numbers, df1: Numbers, df2: Numbers) -> Any:
    """The f with P(F > f) = tail; tail in (0, 1)."""
    x = special.betaincinv(np.divide(df2, 2.0), np.divide(df1, 2.0), tail)
    return np.multiply(df2, 1.0 - x) / np.multiply(df1, x)


def t_two_sided(t: Numbers, df: Numbers) -> Any:
    """P(|T| > |t|) for Student's t."""
    return 2.0 * special.stdtr(df, -np.abs(t))


def t_tail(t: Numbers, df: Numbers) -> Any:
    """P(T > t) for Student's t."""
    return special.stdtr(df, np.negative(t))


def t_for_coverage(df: Numbers, coverage: float = 0.95) -> Any:
    """The t with P(|T| > t) = 1 - coverage; NaN unless coverage is in (0, 1) and df > 0."""
    df = np.where(np.greater(df, 0.0) & (0.0 < coverage < 1.0), df, np.nan)
    x: Array = special.betaincinv(df / 2.0, 0.5, 1.0 - coverage)
    return np.sqrt(df * (1.0 - x) / x)[()]


def z_for_coverage(coverage: float = 0.95) -> float:
    """The z with P(|Z| > z) = 1 - coverage for the standard normal distribution."""
    return float(special.ndtri(0.5 + 0.5 * coverage))
