"""Fixed effects of a factorial experiment, for any number of responses at once.

Sums of squares are of type III: with sum-to-zero contrasts, the full model is compared with the
model without the term. On balanced data they are the usual sums of squares.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from .distributions import f_tail
from .terms import Term, all_terms
from .types import EPSILON, Array


class DesignError(ValueError):
    """The rows of a design do not determine its terms, or leave no error. str(): what the design
    has, and what was expected."""


@dataclass(frozen=True)
class FixedEffect:
    """F of one response in a term; NaN if the model leaves no error."""

    f: Any
    df1: float
    df2: float
    p: Any
    partial_eta2: Any  # F df1 / (F df1 + df2)


@dataclass(frozen=True)
class Wilks:
    """Wilks' lambda = |E| / |E + H| and its F."""

    wilks_lambda: Any
    f: Any
    df1: float
    df2: float  # need not be an integer
    p: Any


def rao(wilks_lambda: Any, responses: int, effect_df: int, error_df: int) -> Wilks:
    """Rao's approximation (1951) of the distribution of lambda by F; exact if responses or
    effect_df is at most 2."""
    p, q, v = responses, effect_df, error_df
    denominator = p * p + q * q - 5.0
    t = np.sqrt((p * p * q * q - 4.0) / denominator) if denominator > 0.0 else 1.0
    df1, df2 = float(p * q), float((v - 0.5 * (p - q + 1.0)) * t - 0.5 * (p * q - 2.0))
    root = np.power(wilks_lambda, 1.0 / t)
    f = (1.0 - root) / root * df2 / df1
    return Wilks(wilks_lambda, f, df1, df2, f_tail(f, df1, df2))


@dataclass(frozen=True)
class Fit:
    """A fitted model of r responses. What the model leaves, residuals (..., rows, r), and what each
    term adds to all others, term_parts (..., df, r): the sums of squares and cross products of
    these are the matrices E and H."""

    residuals: Array
    term_parts: dict[Term, Array]
    error_df: int
    rounding_ss: Array  # (..., r): a sum of squares up to this is rounding

    @cached_property
    def error_sscp(self) -> Array:
        return _sscp(self.residuals)

    def term_sscp(self, term: Term) -> Array:
        return _sscp(self.term_parts[term])

    @cached_property
    def _error_root(self) -> Array:
        """R with R^T R = E. Products of residuals would lose half of the digits of nearly collinear
        responses."""
        return np.asarray(np.linalg.qr(self.residuals, mode="r"))

    def mean_square_error(self, response: int = 0) -> Any:
        return self.error_sscp[..., response, response] / self.error_df

    def effect(self, term: Term, response: int = 0) -> FixedEffect:
        parts = self.term_parts[term]
        df1, df2 = float(parts.shape[-2]), float(self.error_df)
        rounding = self.rounding_ss[..., response]
        error = self.error_sscp[..., response, response]
        error = np.where(error > rounding, error, np.nan)
        ss = np.square(parts[..., response]).sum(axis=-1)
        ss = np.where(ss > rounding, ss, 0.0)
        f = (ss / df1 / (error / df2))[()]
        return FixedEffect(f, df1, df2, f_tail(f, df1, df2), f * df1 / (f * df1 + df2))

    def wilks(self, term: Term) -> Wilks:
        """Requires singular_response() to be None."""
        parts = self.term_parts[term]
        both = np.linalg.qr(np.concatenate([self._error_root, parts], axis=-2), mode="r")
        ratios = _diagonal(self._error_root) / _diagonal(both)
        ratio = np.minimum(np.square(np.prod(ratios, axis=-1)), 1.0)
        return rao(ratio, parts.shape[-1], parts.shape[-2], self.error_df)

    def singular_response(self) -> int | None:
        """The first response that is constant within the cells of the design, or a linear
        combination of the responses before it, to within rounding; not of a stack."""
        rows, responses = self.residuals.shape
        root = self._error_root
        ss = np.square(root).sum(axis=0)
        constant = np.flatnonzero(~(ss > self.rounding_ss))
        if constant.size:
            return int(constant[0])
        # The share of a response's variance that the responses before it do not explain. Sums of
        # `rows` products round that often.
        unexplained = np.square(np.diagonal(root)) / ss
        combined = np.flatnonzero(~(unexplained > rows * responses * EPSILON))
        return int(combined[0]) if combined.size else None


class Design:
    """The design of an experiment, factorised once for any number of data sets."""

    def __init__(
        self, frame: pd.DataFrame, factors: Sequence[str], terms: Sequence[Term] | None = None
    ) -> None:
        """frame: the level of each factor in each row; each factor has at least two levels.
        terms: the full model if not given. Raises DesignError if the rows do not determine all
        terms (for example because a cell is empty), or leave no degree of freedom."""
        self.terms = list(terms) if terms is not None else all_terms(factors)
        codes = {name: _sum_to_zero(frame[name]) for name in factors}
        blocks: list[Array] = [np.ones((len(frame), 1))]
        blocks += [reduce(_products, [codes[name] for name in term]) for term in self.terms]
        x = np.hstack(blocks)
        rows, columns = x.shape
        if rows <= columns:
            raise DesignError(
                f"has {rows} rows; expected more than the {columns} parameters of the model"
            )
        rank = int(np.linalg.matrix_rank(x))
        if rank < columns:
            raise DesignError(f"determines {rank} parameters; expected all {columns}")
        self._model, r = np.linalg.qr(x)
        # Least squares gives the parameters as L y. The hypothesis that those of a term are 0 has
        # the sum of squares of the projection of y on the rows of L that belong to the term.
        by_column = np.linalg.solve(r, self._model.T)
        ends = np.cumsum([block.shape[1] for block in blocks])
        self._bases = {
            term: np.linalg.qr(by_column[start:end].T)[0]
            for term, start, end in zip(self.terms, ends, ends[1:])
        }

    def fit(self, responses: ArrayLike) -> Fit:
        """responses: (..., rows, r), finite."""
        values = np.asarray(responses, dtype=float)
        y = values - values.mean(axis=-2, keepdims=True)  # the mean is in the model: rounds less
        rows, parameters = self._model.shape
        residuals = y - self._model @ (self._model.T @ y)
        # A residual is a sum of `parameters` products with sums of `rows` terms.
        rounding = (rows + parameters) * EPSILON * np.abs(values).max(axis=-2)
        return Fit(
            residuals,
            {term: basis.T @ y for term, basis in self._bases.items()},
            rows - parameters,
            rows * np.square(rounding),
        )


def _sum_to_zero(levels: "pd.Series[Any]") -> Array:
    """A column for each level but the last, which is -1 in all columns."""
    category = levels.astype("category").cat
    k = len(category.categories)
    coding = np.vstack([np.eye(k - 1), -np.ones((1, k - 1))])
    return np.asarray(coding[category.codes.to_numpy()])


def _products(a: Array, b: Array) -> Array:
    """The products of each column of a with each column of b."""
    return np.asarray((a[:, :, None] * b[:, None, :]).reshape(len(a), -1))


def _sscp(parts: Array) -> Array:
    return np.asarray(np.swapaxes(parts, -2, -1) @ parts)


def _diagonal(root: Any) -> Array:
    return np.asarray(np.abs(np.diagonal(root, axis1=-2, axis2=-1)))
