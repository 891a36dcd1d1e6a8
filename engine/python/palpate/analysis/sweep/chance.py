"""How often chance alone makes the largest of many differences as large as the one found."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from palpate.analysis.draws import key_hash, mt19937_64

Places = npt.NDArray[np.intp]
PERMUTATIONS = 2000
# Of the difference of two shares: each quotient and the difference is at most 1 and is rounded by
# at most half an epsilon, in the deal that was found and in another one.
ROUNDING = 3.0 * np.finfo(float).eps


def _orders(count: int, key: str) -> Places:
    """The order of the points in each permutation: a row each. Each shuffles the one before."""
    draws = mt19937_64(key_hash("largest difference", key), PERMUTATIONS * (count - 1))
    others = draws.reshape(PERMUTATIONS, count - 1) % np.arange(count, 1, -1, dtype=np.uint64)
    all_rows = np.arange(PERMUTATIONS)
    swaps = np.tile(np.arange(count), (PERMUTATIONS, 1))
    for draw, last in enumerate(range(count - 1, 0, -1)):
        other = others[:, draw].astype(np.intp)
        swaps[all_rows, other], swaps[:, last] = swaps[:, last], swaps[all_rows, other]
    order = np.arange(count)
    for row in swaps:
        row[:] = order = order[row]
    return swaps


def _largest_difference(splits: Sequence[Places], holds: npt.NDArray[np.bool_]) -> Any:
    """holds: a row for each deal. Returns the largest difference of each."""
    largest = np.zeros(len(holds))
    for part_of in splits:
        is_in = part_of[:, None] == np.unique(part_of[part_of >= 0])
        shares = holds @ is_in.astype(float) / is_in.sum(axis=0)
        if shares.shape[1] > 1:
            largest = np.maximum(largest, shares.max(axis=1) - shares.min(axis=1))
    return largest


def largest_difference_p(splits: Sequence[Places], holds: npt.NDArray[np.bool_], key: str) -> float:
    """A permutation test over several splits of points into parts at once.

    splits: of each, the part of each point; -1: the point is in no part. A split's difference is
    the largest minus the smallest share, over its parts, of the points that hold; the statistic is
    the largest difference of all splits. Each of `PERMUTATIONS` deals gives `holds` to the points
    anew. p is the share of these deals, with the one that was found counted among them, whose
    statistic is at least the one found. key: the random numbers follow from it.
    """
    found = _largest_difference(splits, holds[None])[0]
    deals = holds[_orders(len(holds), key)] if len(holds) > 1 else holds[None]
    largest = _largest_difference(splits, deals)
    count = PERMUTATIONS * np.mean(largest >= found - ROUNDING)
    return float((1 + round(count)) / (PERMUTATIONS + 1))
