"""The parts of the variance of trials, by restricted maximum likelihood (REML).

y = cell + u(person) + w(person, condition) + e(trial), all normal and independent. A cell is a
condition and an item, such as an object and a block; its mean is fixed. The other expected mean
squares are v_e = e, v_pc = e + m w and v_p = v_pc + k m u, with k conditions of m items.

Without missing trials the criterion is the sum of d (log v + MS / v) over p, pc and e, d being the
degrees of freedom, with v_p >= v_pc >= v_e. In log v it is convex, so that the minimum is unique:
MS itself, and where that is not in order, neighbours are pooled by their degrees of freedom until
it is (Thompson, 1962, "The problem of negative estimates of variance components", Annals of
Mathematical Statistics 33). A variance whose mean square is below the next one is therefore 0.

With missing trials the criterion is minimised over log(v_pc / v_e) and log(v_p / v_pc), with the
least squares of the cells and e eliminated (Patterson and Thompson, 1971; Lindstrom and Bates,
1988). Statsmodels (MixedLM) has this model with dense matrices only: 0.1 s a person and measure.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import linalg, optimize
from scipy.sparse.csgraph import connected_components

from .types import EPSILON, Array

# With missing trials, matrices of cells x cells are factorised about 30 times: a second for this.
MOST_CELLS = 400
# Of two expected mean squares, with missing trials: two of them leave 4 of 16 digits.
_MOST_RATIO = 1e6


@dataclass(frozen=True)
class Parts:
    """Variances; NaN if the trials do not determine them."""

    participants: float  # u
    participant_condition: float  # w
    trials: float  # e


_UNKNOWN = Parts(np.nan, np.nan, np.nan)


def parts_of_variance(trials: Array) -> Parts:
    """trials: (people, conditions, items); NaN: missing."""
    there = ~np.isnan(trials)
    used = trials[there.any(axis=(1, 2))][:, there.any(axis=(0, 2))][:, :, there.any(axis=(0, 1))]
    has = ~np.isnan(used)
    if min(used.shape) < 2 or not _is_determined(has):
        return _UNKNOWN
    largest = np.abs(used[has]).max()
    scale = largest if largest > 0.0 else 1.0
    used = used / scale  # no square overflows
    found = _balanced(used) if has.all() else _unbalanced(used, has)
    return Parts(*(float(part) for part in found * scale**2))


def _balanced(y: Array) -> Array:
    n, k, m = y.shape
    y = y - y.mean(axis=0)
    of_cells = y.mean(axis=2)
    of_people = of_cells.mean(axis=1)
    squares = [k * m * np.square(of_people).sum(),
               m * np.square(of_cells - of_people[:, None]).sum(),
               np.square(y - of_cells[:, :, None]).sum()]  # fmt: skip
    df = (n - 1.0) * np.array([1.0, k - 1.0, k * (m - 1.0)])
    # A deviation from means is a sum of at most all trials of a cell and of a person.
    rounding = (n + k * m) * EPSILON
    if not squares[2] > y.size * rounding**2:
        return np.full(3, np.nan)
    v_p, v_pc, v_e = pooled(np.array(squares) / df, df)
    return np.array([(v_p - v_pc) / (k * m), (v_pc - v_e) / m, v_e])


def pooled(mean_squares: Array, df: Array) -> Array:
    """The mean squares in descending order: neighbours that are not are replaced by their mean,
    with df as weights, until all are."""
    blocks: list[tuple[float, float, int]] = []
    for square, weight in zip(mean_squares, df):
        block = (float(square), float(weight), 1)
        while blocks and blocks[-1][0] < block[0]:
            other = blocks.pop()
            weights = other[1] + block[1]
            mean = (other[0] * other[1] + block[0] * block[1]) / weights
            block = (mean, weights, other[2] + block[2])
        blocks.append(block)
    return np.repeat([block[0] for block in blocks], [block[2] for block in blocks])


def _is_determined(has: Any) -> bool:
    """Whether each part has degrees of freedom: the model with cells and a mean for each person in
    a condition leaves some, and so do those that are without the latter, and without people."""
    n, k, m = has.shape
    within = sum(_rank(has[:, c]) for c in range(k))
    between = _rank(has.reshape(n, k * m))
    cells = int(has.any(axis=0).sum())
    return bool(has.sum() > within > between > cells)


def _rank(has: Any) -> int:
    """Of a row for each trial with the indicators of its row and column in `has`."""
    rows, columns = has[has.any(axis=1)], has.any(axis=0)
    part = rows[:, columns].astype(float)
    n, m = part.shape
    graph = np.block([[np.zeros((n, n)), part], [part.T, np.zeros((m, m))]])
    return int(n + m - connected_components(graph, directed=False)[0])


def _unbalanced(y: Array, has: Any) -> Array:
    if has.any(axis=0).sum() > MOST_CELLS:
        return np.full(3, np.nan)
    model = _Profile(y, has)
    most = np.log(_MOST_RATIO)
    x = optimize.minimize(model.criterion, [1.0, 1.0], jac=True, method="L-BFGS-B",
                          bounds=[(0.0, most)] * 2, options={"ftol": 0.0, "gtol": 1e-7}).x
    if not x.max() < most:
        return np.full(3, np.nan)
    free = x > 0.0
    if free.any():  # the criterion rounds earlier than its gradient

        def gradient(inner: Array) -> Array:
            at = x.copy()
            at[free] = inner
            return np.asarray(model.criterion(at)[1][free])

        x[free] = optimize.root(gradient, x[free], tol=1e-12).x
    return model.parts(x)


class _Profile:
    """The criterion, -2 log of the restricted likelihood without constants.

    With e = 1 the covariance of trials is V = I + w Z Z' + u P P'. Its inverse has a closed form by
    person: with n the trials of a person in a condition, r = 1 / (1 + w n) and
    b = u / (1 + u sum(r n)), it is I - w Z diag(r) Z' - (Z r) b (Z r)'.
    """

    def __init__(self, y: Array, has: Any) -> None:
        used = has.any(axis=0)  # (conditions, items)
        self._has = has.astype(float)
        self._used = np.flatnonzero(used)
        self._counts = self._has.sum(axis=2)
        self._of_cells = self._has.sum(axis=0).ravel()[self._used]
        with np.errstate(invalid="ignore"):
            means = np.where(has, y, 0.0).sum(axis=0) / self._has.sum(axis=0)
        centred = np.where(has, y - means, 0.0)
        self._ss = np.square(centred).sum()
        self._sums = centred.sum(axis=2)
        self._df = int(has.sum()) - len(self._used)
        self._k = has.shape[1]
        self._m = has.sum() / np.count_nonzero(self._counts)

    def _ratios(self, x: Array) -> tuple[float, float]:
        """w and u."""
        return (float(np.expm1(x[0]) / self._m),
                float(np.exp(x[0]) * np.expm1(x[1]) / (self._k * self._m)))

    def criterion(self, x: Array) -> tuple[float, Array]:
        """x: log(v_pc / v_e) and log(v_p / v_pc) without missing trials. Also the gradient."""
        value, (by_w, by_u) = self._at(*self._ratios(x))
        w = np.exp(x[0]) / self._m
        u, more = self._ratios(x)[1], w * np.exp(x[1]) / self._k
        return value, np.array([by_w * w + by_u * u, by_u * more])

    def parts(self, x: Array) -> Array:
        w, u = self._ratios(x)
        e = self._solve(w, u)[3] / self._df
        return np.array([u * e, w * e, e])

    def _weights(self, w: float, u: float) -> tuple[Array, Array, Array]:
        """r, sum(r n) of each person, and b."""
        r = 1.0 / (1.0 + w * self._counts)
        of_people = (r * self._counts).sum(axis=1)
        return r, of_people, u / (1.0 + u * of_people)

    def _solve(self, w: float, u: float) -> tuple[Any, Array, Array, float]:
        """The Cholesky factor of X' V^-1 X, its part X' Z r, the residuals summed by person and
        condition, and their weighted sum of squares."""
        r, _, b = self._weights(w, u)
        n, k, m = self._has.shape
        of_people = (r[:, :, None] * self._has).reshape(n, k * m)
        blocks = np.einsum("ic,ica,icb->cab", w * r, self._has, self._has, optimize=True)
        normal = -linalg.block_diag(*blocks)[np.ix_(self._used, self._used)]
        of_people = of_people[:, self._used]
        normal -= of_people.T @ (b[:, None] * of_people)
        normal[np.diag_indices_from(normal)] += self._of_cells
        total = (r * self._sums).sum(axis=1)
        right = -((w * r * self._sums)[:, :, None] * self._has).sum(axis=0).ravel()[self._used]
        right -= of_people.T @ (b * total)
        factor = linalg.cho_factor(normal, lower=True)
        effects = np.zeros(k * m)
        effects[self._used] = found = linalg.cho_solve(factor, right)
        ss = self._ss - (w * r * np.square(self._sums)).sum() - (b * np.square(total)).sum()
        residuals = self._sums - np.einsum("icm,cm->ic", self._has, effects.reshape(k, m))
        return factor, of_people, residuals, float(ss - right @ found)

    def _at(self, w: float, u: float) -> tuple[float, tuple[float, float]]:
        """The criterion, and its derivatives by w and u."""
        r, of_people, b = self._weights(w, u)
        factor, rows, residuals, ss = self._solve(w, u)
        value = -np.log(r).sum() + np.log1p(u * of_people).sum() + self._df * np.log(ss)
        value += 2.0 * np.log(np.diagonal(factor[0])).sum()
        # Z' V^-1 and P' V^-1 of the residuals and of the cells, and the diagonals of
        # Z' V^-1 Z - Z' V^-1 X (X' V^-1 X)^-1 X' V^-1 Z and of the same with P.
        shrink = 1.0 / (1.0 + u * of_people)
        total = (r * residuals).sum(axis=1)
        n_r = self._counts * r
        by_z = r * residuals - n_r * (b * total)[:, None]
        by_p = shrink * total
        n, k, m = self._has.shape
        cells = np.zeros((n, k, k, m))
        cells[:, range(k), range(k)] = r[:, :, None] * self._has
        cells = cells.reshape(n, k, k * m)[:, :, self._used]
        cells -= n_r[:, :, None] * (b[:, None] * rows)[:, None, :]
        of_z = n_r - b[:, None] * np.square(n_r)
        traces = (of_z.sum() - _norm(factor, cells.reshape(n * k, -1)),
                  (shrink * of_people).sum() - _norm(factor, shrink[:, None] * rows))
        squares = np.square(by_z).sum(), np.square(by_p).sum()
        by_w, by_u = (float(trace - self._df * square / ss)
                      for trace, square in zip(traces, squares))
        return float(value), (by_w, by_u)


def _norm(factor: Any, rows: Array) -> float:
    """The trace of rows A^-1 rows', with A = L L'."""
    half = linalg.solve_triangular(factor[0], rows.T, lower=True)
    return float(np.square(half).sum())
