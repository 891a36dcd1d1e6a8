"""The primary analysis: repeated measures on the cell means of participants.

A cell is one participant in one condition; its value is the mean of the completed trials. No
missing trial is replaced by a number: an effect, a comparison or a mean is computed from the
participants who have all cells that it needs, and states their number.
"""

from __future__ import annotations

from dataclasses import astuple, dataclass
from itertools import combinations

import numpy as np
import pandas as pd

from palpate.analysis.statistics import (
    PairedT,
    Term,
    all_terms,
    cousineau_morey,
    holm,
    paired_t,
    repeated_measures_of,
    standardized,
)
from palpate.analysis.statistics.types import EPSILON, Array

from .experiments import CONDITION, FACTORS, Experiment
from .outcomes import Outcome

EFFECT = ["f", "df1", "df2", "p", "epsilon", "p_gg", "generalized_eta2"]


@dataclass(frozen=True)
class Primary:
    """only_haptic: the level of Haptic that is analysed alone.

    effects: `term`, `participants` and EFFECT, which are NaN if fewer than two participants have
    all cells, or if the effect is the same for all of them.
    pairs: `family`, `pair`, the attributes of PairedT, `p_holm`, adjusted within the family, and
    `d_z`, `d_z_low` and `d_z_high` (standardized()).
    cells: the participants' means by participant, Haptic and Rotation; NaN: not all conditions.
    means: `Haptic`, `Rotation` ("all": over all levels), `mean`, `half_width` (Cousineau-Morey) and
    `participants`; the levels of Haptic, those of Rotation, then their combinations. The means of
    a group are of the same participants; without any, it has no rows.
    """

    outcome: Outcome
    only_haptic: str | None
    effects: pd.DataFrame
    pairs: pd.DataFrame
    means: pd.DataFrame
    cells: Array

    def effect(self, term: Term) -> pd.Series[float] | None:
        found = self.effects[self.effects["term"] == term]
        return found.iloc[0] if len(found) else None

    def mean(self, haptic: str = "all", rotation: str = "all") -> pd.Series[float] | None:
        at = (self.means["Haptic"] == haptic) & (self.means["Rotation"] == rotation)
        found = self.means[at]
        return found.iloc[0] if len(found) else None


def analyse_repeated_measures(
    experiment: Experiment, outcome: Outcome, only_haptic: str | None = None
) -> Primary:
    """The analysis of an outcome that the trials have."""
    grid, levels = experiment.grid(outcome), dict(experiment.levels)
    if only_haptic:
        grid = grid[:, [levels["Haptic"].index(only_haptic)]]
        levels["Haptic"] = [only_haptic]
    cells = _mean_of_those_there(grid)
    sizes = {factor: len(levels[factor]) for factor in FACTORS if len(levels[factor]) > 1}
    effects = _effects(cells, {name: k for name, k in sizes.items() if name in CONDITION})
    if "Trial" in sizes:
        with_trial = _effects(grid, sizes)
        effects += [row for row in with_trial if "Trial" in row["term"]]  # type: ignore[operator]
    by_levels = cells.mean(axis=3)  # participant, Haptic, Rotation
    return Primary(
        outcome,
        only_haptic,
        pd.DataFrame(effects, columns=["term", "participants", *EFFECT]),
        _pairs(by_levels, levels),
        _means(by_levels, levels, only_haptic),
        by_levels,
    )


def residuals(experiment: Experiment, outcome: Outcome) -> pd.Series[float]:
    """Of the participants who have all conditions: their means of conditions, without the mean of
    the participant and that of the condition. Empty with fewer than two of them, and if they are
    rounding."""
    cells = _mean_of_those_there(experiment.grid(outcome))
    table: Array = cells.reshape(len(cells), -1)
    table = table[~np.isnan(table).any(axis=1)]
    if len(table) < 2 or table.shape[1] < 2:
        return pd.Series(dtype=float)
    rest = table - table.mean(axis=1, keepdims=True) - table.mean(axis=0) + table.mean()
    rounding = sum(table.shape) * EPSILON * np.abs(table).max()
    return pd.Series(rest.ravel() if np.abs(rest).max() > rounding else [], dtype=float)


def _mean_of_those_there(grid: Array) -> Array:
    """The means over the last axis without NaN; NaN where nothing else is."""
    there = np.count_nonzero(~np.isnan(grid), axis=-1)
    return np.asarray(np.nansum(grid, axis=-1) / np.where(there > 0, there, np.nan))


def _effects(values: Array, sizes: dict[str, int]) -> list[dict[str, object]]:
    if not sizes:
        return []
    table: Array = values.reshape(len(values), -1)
    table = table[~np.isnan(table).any(axis=1)]
    rows: list[dict[str, object]] = [
        {"term": term, "participants": len(table)} for term in all_terms(list(sizes))
    ]
    if len(table) < 2:
        return rows
    for row, effect in zip(rows, repeated_measures_of(table, sizes).effects):
        if not np.isnan(effect.f):
            row.update({name: float(getattr(effect, name)) for name in EFFECT})
    return rows


def _pairs(by_levels: Array, levels: dict[str, list[str]]) -> pd.DataFrame:
    haptic, rotation = levels["Haptic"], levels["Rotation"]
    of_haptic = by_levels.mean(axis=2)
    rows = []
    for i, j in combinations(range(len(haptic)), 2):
        test = paired_t(of_haptic[:, j], of_haptic[:, i])
        rows.append(("levels of Haptic", f"{haptic[j]} - {haptic[i]}", test))
    if len(rotation) > 1:
        rows += [
            (
                "R - NoR within each level of Haptic",
                f"R - NoR in {level}",
                paired_t(by_levels[:, h, 1], by_levels[:, h, 0]),
            )
            for h, level in enumerate(haptic)
        ]
    sizes = ["d_z", "d_z_low", "d_z_high"]
    columns = ["family", "pair", *PairedT.__dataclass_fields__, *sizes]
    values = [(family, pair, *astuple(test), *standardized(test)) for family, pair, test in rows]
    pairs = pd.DataFrame(values, columns=columns)
    p_holm = [holm(group) for _, group in pairs.groupby("family", sort=False, observed=True)["p"]]
    return pairs.assign(p_holm=np.concatenate([*p_holm, np.empty(0)]))


def _means(
    by_levels: Array, levels: dict[str, list[str]], only_haptic: str | None
) -> pd.DataFrame:
    haptic, rotation = levels["Haptic"], levels["Rotation"]
    both = [(h, r) for h in haptic for r in rotation]
    groups = [
        ([(h, "all") for h in haptic], by_levels.mean(axis=2)),
        ([("all", r) for r in rotation], by_levels.mean(axis=1)),
        (both, by_levels.reshape(len(by_levels), -1)),
    ]
    rows: list[tuple[str, str, float, float, int]] = []
    for names, values in groups[1:2] if only_haptic else groups:
        complete = values[~np.isnan(values).any(axis=1)]
        if len(complete) == 0:
            continue
        halves = cousineau_morey(complete)
        for name, mean, half in zip(names, complete.mean(axis=0), halves):
            rows.append((*name, float(mean), float(half), len(complete)))
    return pd.DataFrame(rows, columns=["Haptic", "Rotation", "mean", "half_width", "participants"])
