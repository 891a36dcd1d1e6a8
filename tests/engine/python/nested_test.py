"""The parts of the variance of trials: mean squares and their pooling on complete trials, the
optimiser on trials with gaps, and what cannot be determined."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy import stats

from palpate.analysis.statistics import nested
from palpate.analysis.statistics.nested import parts_of_variance, pooled

SEED = 50_002


def made(rng, people, conditions, items, u, w, e):
    shape = (people, conditions, items)
    return (100.0 + 10.0 * rng.standard_normal((1, *shape[1:]))
            + np.sqrt(u) * rng.standard_normal((people, 1, 1))
            + np.sqrt(w) * rng.standard_normal((people, conditions, 1))
            + np.sqrt(e) * rng.standard_normal(shape))


def values(parts):
    return [parts.participants, parts.participant_condition, parts.trials]


def mean_squares(y):
    """By the definitions; and the degrees of freedom."""
    n, k, m = y.shape
    cell, item = y.mean(axis=2, keepdims=True), y.mean(axis=0, keepdims=True)
    person, condition = cell.mean(axis=1, keepdims=True), cell.mean(axis=0, keepdims=True)
    df = np.array([n - 1, (n - 1) * (k - 1), k * (n - 1) * (m - 1)])
    ss = [k * m * np.square(person - y.mean()).sum(),
          m * np.square(cell - person - condition + y.mean()).sum(),
          np.square(y - cell - item + condition).sum()]
    return ss / df, df


# The last ones are at the edge: the optimiser and the mean squares must agree there, too.
CASES = [(6, 6, 4, 4, 3, 2), (10, 6, 12, 1, 5, 60), (41, 2, 3, 4, 3, 2), (3, 2, 2, 1, 1, 1),
         (6, 6, 4, 4, 0, 2), (6, 6, 4, 0, 3, 2), (6, 6, 4, 0, 0, 2), (4, 6, 2, 0, 0, 1)]


@pytest.mark.parametrize("case", CASES, ids=str)
def test_complete_trials_give_pooled_mean_squares_and_so_does_the_optimiser(case):
    rng = np.random.default_rng(SEED)
    print("seed", SEED)
    _, k, m = case[:3]
    for _ in range(5):
        y = made(rng, *case)
        ms, df = mean_squares(y)
        found = values(parts_of_variance(y))
        raw = [(ms[0] - ms[1]) / (k * m), (ms[1] - ms[2]) / m, ms[2]]
        if min(raw) >= 0.0:
            assert found == pytest.approx(raw, rel=1e-9, abs=1e-12)
        p, pc, e = pooled(ms, df)
        assert found == pytest.approx([(p - pc) / (k * m), (pc - e) / m, e], rel=1e-9, abs=1e-12)
        by_optimiser = nested._unbalanced(y, np.ones(y.shape, dtype=bool))
        assert found == pytest.approx(by_optimiser, rel=1e-8, abs=1e-9)


# No other point in order is as likely: sum of d (log v + MS / v).
def test_pooling_maximises_the_restricted_likelihood():
    rng = np.random.default_rng(SEED)
    for ms, df in (([1.0, 2.0, 3.0], [3, 15, 72]), ([5.0, 1.0, 2.0], [3, 15, 72]),
                   ([1.0, 4.0, 2.0], [9, 5, 7]), ([4.0, 3.0, 3.5], [2, 2, 40])):
        ms, df = np.array(ms), np.array(df, dtype=float)

        def criterion(v, ms=ms, df=df):
            return (df * (np.log(v) + ms / v)).sum(axis=-1)

        best = pooled(ms, df)
        assert all(a >= b for a, b in pairwise(best))
        others = np.sort(best * np.exp(0.2 * rng.standard_normal((2000, 3))), axis=1)[:, ::-1]
        assert (criterion(others) >= criterion(best)).all()


def test_pooling_by_hand():
    assert pooled(np.array([1.0, 4.0, 2.0]), np.array([1.0, 2.0, 7.0])).tolist() == [3.0, 3.0, 2.0]
    assert pooled(np.array([1.0, 2.0, 3.0]), np.array([1.0, 1.0, 2.0])).tolist() == [2.25] * 3


# By the definition: the likelihood of contrasts that are free of the cells, with dense matrices.
def dense_criterion(y, parts):
    people, conditions, items = y.shape
    place = np.indices(y.shape).reshape(3, -1)[:, ~np.isnan(y).ravel()]
    i, c, a = place
    cell = c * items + a
    x = (cell[:, None] == np.unique(cell)).astype(float)
    both = i * conditions + c
    v = (parts[0] * (i[:, None] == i) + parts[1] * (both[:, None] == both)
         + parts[2] * np.eye(len(i)))
    free = np.linalg.svd(x, full_matrices=True)[0][:, x.shape[1]:].T
    covariance = free @ v @ free.T
    return -2.0 * stats.multivariate_normal(None, covariance).logpdf(free @ y[tuple(place)])


def test_parts_of_trials_with_gaps_are_the_most_likely():
    rng = np.random.default_rng(SEED)
    y = made(rng, 5, 3, 4, 4.0, 3.0, 2.0)
    y[rng.uniform(size=y.shape) < 0.2] = np.nan
    best = values(parts_of_variance(y))
    least = dense_criterion(y, best)
    for j in range(3):
        up, down = (dense_criterion(y, [p * (1.0 + h * (i == j)) for i, p in enumerate(best)])
                    for h in (1e-3, -1e-3))
        assert up > least < down
        assert abs(up - down) / (up + down - 2.0 * least) < 1e-2  # the minimum is within 1e-5


# 200 people with gaps: beside the truth by less than three of its standard errors.
def test_many_people_with_gaps():
    rng = np.random.default_rng(SEED)
    y = made(rng, 200, 6, 4, 4.0, 3.0, 2.0)
    y[rng.uniform(size=y.shape) < 0.05] = np.nan
    u, w, e = values(parts_of_variance(y))
    v_p, v_pc = 2.0 + 4 * 3.0 + 24 * 4.0, 2.0 + 4 * 3.0
    assert u == pytest.approx(4.0, abs=3.0 * np.sqrt(2.0 / 199) * v_p / 24)
    assert w == pytest.approx(3.0, abs=3.0 * np.sqrt(2.0 / 995) * v_pc / 4)
    assert e == pytest.approx(2.0, abs=3.3 * np.sqrt(2.0 / 3300) * 2.0)


def test_scale_and_missing_rows_do_not_matter():
    rng = np.random.default_rng(SEED)
    y = made(rng, 5, 3, 4, 4.0, 3.0, 2.0)
    expected = np.array(values(parts_of_variance(y)))
    assert values(parts_of_variance(1e9 * y)) == pytest.approx(1e18 * expected)
    more = np.full((6, 4, 5), np.nan)
    more[:5, :3, :4] = y
    assert values(parts_of_variance(more)) == pytest.approx(expected)


@pytest.mark.parametrize("name", ["one person", "one condition", "one item", "constant",
                                  "no scatter of trials", "a condition for each person",
                                  "an item for each person", "too many cells"])
def test_what_trials_do_not_determine_is_unknown(name):
    y = made(np.random.default_rng(SEED), 4, 4, 4, 4.0, 3.0, 2.0)
    if name.startswith("one"):
        y = {"person": y[:1], "condition": y[:, :1], "item": y[:, :, :1]}[name.split()[1]]
    elif name == "constant":
        y = np.full_like(y, 0.1)
    elif name == "no scatter of trials":
        y = np.repeat(y[:, :, :1], 4, axis=2)
    elif name == "a condition for each person":
        y[~np.eye(4, dtype=bool)] = np.nan
    elif name == "an item for each person":
        y[~np.eye(4, dtype=bool)[:, None].repeat(4, axis=1)] = np.nan
    else:
        y = np.full((2, 2, nested.MOST_CELLS), 1.0) + np.arange(2.0)[:, None, None]
        y[0, 0, 0] = np.nan
    assert np.isnan(values(parts_of_variance(y))).all()
