"""Compares strategies on the same hands and scenes: means, paired differences, and which is best.

The value of a hand is the mean over its trials; a trial without a value is left out. A mean is over
hands that have a value, and its interval is Student's t over hands. A difference is paired: the
value of a hand is the mean of the differences between trials on the same scene, for which both
strategies have a value.

Hands with equal values have no interval: without a measured spread, Student's t would give a width
of 0, which a few hands do not justify. A technique without a value by a measure is not ranked by
it, and one that would be ranked alone is not the best.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from palpate.analysis.statistics import t_for_coverage
from palpate.analysis.strategies.measures import MEASURES, TRAVEL, Array, values_of

REFERENCES = ("none", "full")  # not ranked: they need no motor, or all of them
OTHERS = ("mask", "a4")  # to which differences are computed
_ENDS = {"done": "done", "timeouts": "timeout", "faults": "fault"}


@dataclass(frozen=True)
class Comparison:
    """The results of one following. An empty scene stands for all scenes together."""

    following: str
    hands: int
    workspace_m: float  # the least extent of the device's workspace
    strategies: pd.DataFrame  # how the trials of each strategy ended, and the device's travel
    means: pd.DataFrame  # every mean with its differences to mask and to a4, and its standing

    @property
    def scenes(self) -> list[str]:
        """All together first; the rest only if there are several."""
        return list(self.means["scene"].unique())

    @property
    def incomplete(self) -> list[str]:
        """Strategies that are not comparable."""
        return list(self.strategies.loc[~is_comparable(self.strategies), "strategy"])

    @property
    def a4_losses(self) -> pd.DataFrame:
        """The rows of `means` in which another strategy is better than a4: the interval of the
        difference to a4 lies on the better side of 0."""
        means = self.means
        losses = means[(means["scene"] == "") & (means["minus_a4"] < -means["a4_half_width"])
                       & ~means["strategy"].isin(self.incomplete)]
        return losses.iloc[:0] if "a4" in self.incomplete else losses

    @property
    def a4_undecided(self) -> pd.DataFrame:
        """The rows of `means` in which another strategy has the better value, but no interval of
        the difference to a4: it is equal in all hands, or known of one."""
        means = self.means
        return means[(means["scene"] == "") & (means["minus_a4"] < 0.0)
                     & means["a4_half_width"].isna()
                     & ~means["strategy"].isin(self.incomplete) & ("a4" not in self.incomplete)]


def role_of(strategy: str) -> str:
    return "reference" if strategy in REFERENCES else "technique"


def is_comparable(counts: pd.DataFrame) -> "pd.Series[bool]":
    """Whether at least 90 % of the trials were completed."""
    return counts["done"] * 10 >= counts["trials"] * 9


def _mean(values: Array) -> tuple[Array, Array]:
    """The mean over the last axis but one, without NaN, and of how many values it is."""
    counts = np.count_nonzero(~np.isnan(values), axis=-2)
    return np.nansum(values, axis=-2) / np.where(counts, counts, np.nan), counts


def intervals(values: Array, size: Array | float = 0.0) -> tuple[Array, Array, Array]:
    """Mean over hands, half of its 95 % interval, and number of hands.

    values: (..., hands, cells, strategies). size: the largest value that was subtracted to get
    them; a deviation rounds hands + 2 times, so that a smaller half width is one of equal values.
    Equal values have no interval (NaN), and neither has a single one.
    """
    of_hand, _ = _mean(values)
    mean, hands = _mean(of_hand)
    squares = np.nansum((of_hand - mean[..., None, :]) ** 2, axis=-2)
    degrees = np.where(hands > 1, hands - 1.0, np.nan)
    half_width = t_for_coverage(degrees) * np.sqrt(squares / degrees / np.maximum(hands, 1))
    largest = np.maximum(np.abs(np.nan_to_num(of_hand)).max(axis=-2, initial=0.0), size)
    rounding = (hands + 2) * np.finfo(float).eps * largest
    return mean, np.where(half_width <= rounding, np.nan, half_width), hands


def _differences(values: Array, others: Array) -> tuple[Array, Array, Array]:
    size: Array = np.abs(np.nan_to_num(values)).max(axis=(1, 2, 3), initial=0.0)
    return intervals(values - others, size[:, None])


def _counts(trials: pd.DataFrame, strategies: Sequence[str], workspace_m: float) -> pd.DataFrame:
    ends = pd.crosstab(trials["strategy"], trials["status"]).reindex(
        index=strategies, columns=list(_ENDS.values()), fill_value=0)
    # Of trials that were not completed, too: a scene that runs away is a reason for that.
    travel_m, of_strategy = trials[TRAVEL], trials["strategy"]
    beyond = (travel_m > workspace_m).groupby(of_strategy).sum().reindex(strategies, fill_value=0)
    largest_m = travel_m.groupby(of_strategy).max().reindex(strategies)
    return pd.DataFrame({"strategy": strategies, "role": [role_of(each) for each in strategies],
                         "trials": ends.sum(axis=1).to_numpy(),
                         **{name: ends[status].to_numpy() for name, status in _ENDS.items()},
                         "beyond_workspace": beyond.to_numpy(),
                         "largest_travel_m": largest_m.to_numpy()})


def _standings(values: Array, is_ranked: Array) -> NDArray[np.str_]:
    """"best", "tied" or "" by measure and strategy: pairs of the same hands decide, because the
    means may be of other trials where some are missing. is_ranked: (measures, strategies); one
    alone is not the best."""
    means, _, _ = intervals(values)
    best = np.where(is_ranked, means, np.inf).argmin(axis=-1)[:, None]
    behind, half_width, _ = _differences(
        values, np.take_along_axis(values, best[:, None, None, :], axis=-1))
    is_best = np.arange(values.shape[-1]) == best
    is_tied = ~(behind > half_width)  # also without an interval
    is_ranked = is_ranked & (np.count_nonzero(is_ranked, axis=-1) > 1)[:, None]
    return np.where(is_ranked, np.where(is_best, "best", np.where(is_tied, "tied", "")), "")


def _means(values: Array, counts: pd.DataFrame, scene: str) -> pd.DataFrame:
    """A row for each measure and strategy. values: (measures, hands, cells, strategies)."""
    names = list(counts["strategy"])
    mean, half_width, hands = intervals(values)
    table = pd.DataFrame([
        (scene, measure.name, measure.column, measure.unit, measure.better, name, role)
        for measure in MEASURES for name, role in zip(names, counts["role"])],
        columns=["scene", "measure", "column", "unit", "better", "strategy", "role"])
    table["hands"], table["mean"], table["half_width"] = (
        each.ravel() for each in (hands, mean, half_width))
    for other in OTHERS:
        of_other = values[..., [names.index(other)]] if other in names else np.nan * values
        is_compared = (table["strategy"] != other) & (other in names)
        columns = (f"minus_{other}", f"{other}_half_width", f"{other}_hands")
        for column, cells in zip(columns, _differences(values, of_other)):
            table[column] = pd.Series(cells.ravel()).where(is_compared)
        table[columns[-1]] = table[columns[-1]].astype("Int64")
    is_technique = (counts["role"] == "technique") & is_comparable(counts)
    table["standing"] = _standings(values, is_technique.to_numpy() & (hands > 0)).ravel()
    return table


def compare(trials: pd.DataFrame, strategies: Sequence[str], scenes: Sequence[str],
            following: str, workspace_m: float) -> Comparison:
    """trials: of read_trials(), with the travel; those of other followings, of practice and of other strategies are
    left out. strategies, scenes (objects): names in the order of tables. workspace_m: as in
    Comparison."""
    trials = trials[(trials["following"] == following) & (trials["block"] > 0)
                    & trials["strategy"].isin(strategies)]
    values, objects = values_of(trials, strategies)
    counts = _counts(trials, strategies, workspace_m)
    tables = []
    for scene in ["", *(scenes if len(scenes) > 1 else ())]:
        cells = np.array([scene in ("", each) for each in objects])
        tables.append(_means(values[:, :, cells], counts, scene))
    return Comparison(following, trials["participant"].nunique(), workspace_m, counts,
                      pd.concat(tables, ignore_index=True))


def leaders(entries: pd.DataFrame) -> str:
    """The techniques that lead by a measure: "a4", "a4 (tied: cd)", "tie of all", "-", each with
    those that have no value: "mask (tied: cd; no value: a4)", "- (only mask; no value: a4)"."""
    techniques = entries[entries["role"] == "technique"]
    has_value = techniques["hands"] > 0
    only, missing = (", ".join(techniques.loc[each, "strategy"])
                     for each in (has_value, ~has_value))
    best, tied = (", ".join(entries.loc[entries["standing"] == standing, "strategy"])
                  for standing in ("best", "tied"))
    is_tie = is_tie_of_all(entries)
    notes = [f"tied: {tied}"] if tied and not is_tie else []
    if has_value.sum() == 1:
        notes.append(f"only {only}")
    if has_value.any() and not has_value.all():
        notes.append(f"no value: {missing}")
    lead = "tie of all" if is_tie else best or "-"
    return lead + (f" ({'; '.join(notes)})" if notes else "")


def missing_by(comparison: Comparison, strategy: str) -> list[str]:
    """The measures by which this strategy has no value, and another one has."""
    means = comparison.means[comparison.means["scene"] == ""]
    of_any = means.groupby("measure", sort=False)["hands"].sum()
    of_one = means[means["strategy"] == strategy].set_index("measure")["hands"]
    return [name for name in of_one.index if of_one[name] == 0 < of_any[name]]


def is_tie_of_all(entries: pd.DataFrame) -> bool:
    """There are several techniques with a value, and all of them lead."""
    ranked = entries[(entries["role"] == "technique") & (entries["hands"] > 0)]
    leading = (entries["standing"] != "").sum()
    return bool(leading > 1 and (ranked["standing"] != "").all())
