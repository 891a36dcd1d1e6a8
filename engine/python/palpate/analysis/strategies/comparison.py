"""Compares strategies on the same hands and scenes: means, paired differences, ranks, tuning.

The value of a hand is the mean over its trials; a trial without a value is left out. A mean is over
hands that have a value, and its interval is Student's t over hands. A difference is paired: the
value of a hand is the mean of the differences between trials on the same scene, for which both
strategies have a value.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from palpate.analysis.statistics import t_for_coverage
from palpate.analysis.strategies.measures import MEASURES, Array, values_of

TUNED = "anisotropic"  # stands for the best of several values of E
REFERENCES = ("none", "full")  # not ranked: they need no motor, or all of them
LEAST_DONE = 0.9  # the share of its trials that a strategy must complete to be comparable
COUNTS = ("trials", "done", "timeouts", "faults")
TUNING = ("scene", "measure", "unit", "strategy", "hands", "mean", "half_width", "chosen")


@dataclass(frozen=True)
class Compared:
    """What is compared: names, in the order of tables."""

    strategies: Sequence[str]
    scenes: Sequence[str]  # objects
    levels: Sequence[str] = field(default_factory=list)  # values of E; empty: nothing is tuned

    @property
    def contenders(self) -> list[tuple[str, str]]:
        """Names and roles: reference, technique, or a level, which is ranked only as TUNED."""
        roles = [(name, "reference" if name in REFERENCES else "technique")
                 for name in self.strategies]
        return roles + bool(self.levels) * [(TUNED, "technique")] + [
            (level, "level") for level in self.levels]


@dataclass(frozen=True)
class Comparison:
    """The results of one following. An empty scene stands for all scenes together."""

    following: str
    hands: int
    strategies: pd.DataFrame  # how the trials of each strategy ended
    means: pd.DataFrame  # every mean with its differences to mask and to a4, and its standing
    tuning: pd.DataFrame  # every level by every measure on the hands that tune

    @property
    def scenes(self) -> list[str]:
        """All together first; the rest only if there are several."""
        return list(self.means["scene"].unique())

    @property
    def incomplete(self) -> list[str]:
        """Strategies that are not comparable. A level counts only if a measure chose it."""
        chosen = self.tuning.loc[self.tuning["chosen"] == 1, "strategy"]
        counts = self.strategies[(self.strategies["role"] != "level")
                                 | self.strategies["strategy"].isin(chosen)]
        return list(counts.loc[~_is_comparable(counts), "strategy"])

    @property
    def a4_losses(self) -> pd.DataFrame:
        """The rows of `means` in which another strategy is better than a4: the interval of the
        difference to a4 lies on the better side of 0."""
        out, means = self.incomplete, self.means
        losses = means[(means["scene"] == "") & (means["role"] != "level")
                       & (means["minus_a4"] < -means["a4_half_width"])
                       & ~means["strategy"].isin(out) & ~means["tuned_to"].isin(out)]
        return losses.iloc[:0] if "a4" in out else losses


def _is_comparable(counts: pd.DataFrame) -> "pd.Series[bool]":
    return counts["done"] * 10 >= counts["trials"] * round(10 * LEAST_DONE)


def _mean(values: Array, axis: int) -> tuple[Array, Array]:
    """The mean without NaN, and of how many values it is; NaN if there is none."""
    counts = np.count_nonzero(~np.isnan(values), axis=axis)
    return np.nansum(values, axis=axis) / np.where(counts, counts, np.nan), counts


def intervals(values: Array, size: Array | float = 0.0) -> tuple[Array, Array, Array]:
    """Mean over hands, half of its 95 % interval, and number of hands.

    values: (..., hands, cells, strategies). size: the largest value that was subtracted to get
    them; a deviation rounds hands + 2 times, so that a smaller half width is 0.
    """
    of_hand, _ = _mean(values, -2)
    mean, hands = _mean(of_hand, -2)
    squares = np.nansum((of_hand - mean[..., None, :]) ** 2, axis=-2)
    degrees = np.where(hands > 1, hands - 1.0, np.nan)
    half_width = t_for_coverage(degrees) * np.sqrt(squares / degrees / np.maximum(hands, 1))
    largest = np.maximum(np.abs(np.nan_to_num(of_hand)).max(axis=-2, initial=0.0), size)
    rounding = (hands + 2) * np.finfo(float).eps * largest
    return mean, np.where(half_width <= rounding, 0.0, half_width), hands


def _counts(trials: pd.DataFrame, contenders: Sequence[tuple[str, str]]) -> pd.DataFrame:
    rows = []
    for name, role in contenders:
        ended = trials.loc[trials["strategy"] == name, "status"].value_counts()
        rows.append((name, role, ended.sum(), *(ended.get(status, 0)
                                                for status in ("done", "timeout", "fault"))))
    return pd.DataFrame(rows, columns=["strategy", "role", *COUNTS])


def _selected(trials: pd.DataFrame, following: str, names: Sequence[str]) -> pd.DataFrame:
    return trials[(trials["following"] == following) & (trials["block"] > 0)
                  & trials["strategy"].isin(names)]


def _distance_from_one(level: str) -> float:
    """How far E is from 1, in powers of 2."""
    return abs(float(np.log2(float(level.partition(":")[2]))))


def _tune(values: Array, is_comparable: Sequence[bool], levels: Sequence[str],
          scene: str) -> tuple[pd.DataFrame, list[int]]:
    """The means of the levels, and the place of the best one by each measure.

    The best mean of those that completed their trials; of equal ones, the nearest to E = 1.
    """
    means, half_widths, hands = intervals(values)
    chosen = []
    for row in means:
        keys = [(1, 0, 0.0, 0.0) if np.isnan(mean) else
                (0, int(not done), mean, _distance_from_one(level))
                for mean, done, level in zip(row, is_comparable, levels)]
        chosen.append(min(range(len(keys)), key=lambda place: keys[place]))
    table = pd.DataFrame([
        (scene, measure.name, measure.unit, level, hands[i, j], means[i, j], half_widths[i, j],
         int(chosen[i] == j))
        for i, measure in enumerate(MEASURES) for j, level in enumerate(levels)],
        columns=list(TUNING))
    return table, chosen


def _standings(values: Array, is_ranked: Array) -> NDArray[np.str_]:
    """"best", "tied" or "" by measure and contender: pairs of the same hands decide, because the
    means may be of other trials where some are missing. is_ranked: (measures, contenders)."""
    means, _, _ = intervals(values)
    best = np.where(is_ranked, means, np.inf).argmin(axis=-1)[:, None]
    others = np.take_along_axis(values, best[:, None, None, :], axis=-1)
    behind, half_width, _ = intervals(values - others, _size(values))
    is_best = np.arange(values.shape[-1]) == best
    is_tied = ~(behind > half_width)  # also without an interval
    names = np.where(is_best, "best", np.where(is_tied, "tied", ""))
    return np.where(is_ranked, names, "")


def _size(values: Array) -> Array:
    """The largest value of each measure."""
    largest: Array = np.abs(np.nan_to_num(values)).max(axis=(1, 2, 3), initial=0.0)
    return largest[:, None]


def _means(values: Array, compared: Compared, tuned: Sequence[str], is_comparable: Array,
           scene: str) -> pd.DataFrame:
    """A row for each measure and contender. values: (measures, hands, cells, contenders)."""
    contenders = compared.contenders
    names, roles = [name for name, _ in contenders], np.array([role for _, role in contenders])
    mean, half_width, hands = intervals(values)
    table = pd.DataFrame([
        (scene, measure.name, measure.column, measure.unit, measure.better, name,
         tuned[i] if name == TUNED else "", role)
        for i, measure in enumerate(MEASURES) for name, role in contenders],
        columns=["scene", "measure", "column", "unit", "better", "strategy", "tuned_to", "role"])
    table["hands"], table["mean"], table["half_width"] = (
        each.ravel() for each in (hands, mean, half_width))
    for other in ("mask", "a4"):
        if other in names:
            of_other = values[..., [names.index(other)]]
            difference, half, pairs = intervals(values - of_other, _size(values))
        else:
            difference, half, pairs = (np.full(mean.shape, np.nan) for _ in range(3))
        is_compared = (table["strategy"] != other) & (other in names)
        for column, cells in ((f"minus_{other}", difference), (f"{other}_half_width", half),
                              (f"{other}_hands", pairs)):
            table[column] = pd.Series(cells.ravel()).where(is_compared)
        table[f"{other}_hands"] = table[f"{other}_hands"].astype("Int64")
    is_ranked = (roles == "technique") & (hands > 0) & is_comparable
    table["standing"] = _standings(values, is_ranked).ravel()
    return table


def compare(trials: pd.DataFrame, tuning_trials: pd.DataFrame | None, compared: Compared,
            following: str) -> Comparison:
    """trials: of read_trials(), of all strategies and levels. tuning_trials: of the levels, by
    other hands. For each measure, and for each scene and all together, TUNED is the level with the
    best mean in tuning_trials."""
    names = [*compared.strategies, *compared.levels]
    trials = _selected(trials, following, names)
    values, objects = values_of(trials, names)
    counts = _counts(trials, [(n, role) for n, role in compared.contenders if n != TUNED])
    is_comparable = _is_comparable(counts).to_numpy()
    if compared.levels and tuning_trials is not None:
        tuning_trials = _selected(tuning_trials, following, compared.levels)
        tuning_values, tuning_objects = values_of(tuning_trials, compared.levels)
        is_tunable = list(_is_comparable(_counts(
            tuning_trials, [(level, "level") for level in compared.levels])))
    tables, tunings = [], [pd.DataFrame(columns=list(TUNING))]
    for scene in ["", *(compared.scenes if len(compared.scenes) > 1 else ())]:
        cells = np.array([scene in ("", each) for each in objects])
        of_scene = values[:, :, cells]
        places = np.tile(np.arange(len(names)), (len(MEASURES), 1))
        tuned: list[str] = []
        if compared.levels:
            cells = np.array([scene in ("", each) for each in tuning_objects])
            tuning, chosen = _tune(tuning_values[:, :, cells], is_tunable, compared.levels, scene)
            tunings.append(tuning)
            tuned = [compared.levels[place] for place in chosen]
            first = len(compared.strategies)
            places = np.insert(places, first, first + np.array(chosen), axis=1)
        contenders = np.take_along_axis(of_scene, places[:, None, None, :], axis=-1)
        tables.append(_means(contenders, compared, tuned, is_comparable[places], scene))
    tuning = pd.concat(tunings[1:] or tunings, ignore_index=True)
    return Comparison(following, trials["participant"].nunique(), counts,
                      pd.concat(tables, ignore_index=True), tuning)


def leaders(entries: pd.DataFrame) -> str:
    """The techniques that lead by a measure: "a4", "a4 (tied: cd)", "tie of all", "-"."""
    best, tied = (", ".join(entries.loc[entries["standing"] == standing, "strategy"])
                  for standing in ("best", "tied"))
    if is_tie_of_all(entries):
        return "tie of all"
    return (best or "-") + (f" (tied: {tied})" if tied else "")


def is_tie_of_all(entries: pd.DataFrame) -> bool:
    """There are several techniques with a value, and all of them lead."""
    ranked = entries[(entries["role"] == "technique") & (entries["hands"] > 0)]
    leading = (entries["standing"] != "").sum()
    return bool(leading > 1 and (ranked["standing"] != "").all())

