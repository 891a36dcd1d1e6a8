"""Rankings of conditions, and whether they hold at the points of a sweep."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from palpate.analysis.statistics import t_for_coverage
from palpate.analysis.sweep.points import HAPTICS, MEASURES, ROTATIONS, Measure, Sweep

Level = tuple[tuple[str, str], ...]  # its cells: (haptic, rotation)
_TIME, _LOSSES, _PENETRATION, _ANGLE = MEASURES


@dataclass(frozen=True)
class Ranking:
    """An order of two or three conditions by the mean of a measure.

    ascending: the conditions in the order that is claimed. The value of a condition for a
    participant is the mean of its cells.
    """

    measure: Measure
    effect: str
    ascending: dict[str, Level]
    statement: str
    is_of_paper: bool = True  # otherwise: A4 improves the measure of UaH
    by_construction: str = ""  # why a simulated person cannot show this order; "": it can

    @property
    def name(self) -> str:
        """For example "total time, Haptic"."""
        return f"{self.measure.name}, {self.effect}"

    @property
    def order(self) -> str:
        """For example "H < UaH < NoH"."""
        return " < ".join(self.ascending)


def _haptic(measure: Measure, statement: str, by_construction: str = "") -> Ranking:
    levels = {name: tuple((name, rotation) for rotation in ROTATIONS) for name in reversed(HAPTICS)}
    return Ranking(measure, "Haptic", levels, statement, by_construction=by_construction)


def _rotation(measure: Measure, statement: str, by_construction: str = "") -> Ranking:
    levels = {name: tuple((haptic, name) for haptic in HAPTICS) for name in ROTATIONS}
    return Ranking(measure, "Rotation", levels, statement, by_construction=by_construction)


_IN_UAH: dict[str, Level] = {name: (("UaH", name),) for name in reversed(ROTATIONS)}

# Those that the paper reports (Lécuyer et al., 2005), then, for each other measure, that A4 makes
# it smaller in UaH. The paper reports the latter for the contact angle.
RANKINGS = (
    _haptic(_TIME, "H is quickest, then UaH, then NoH"),
    _rotation(_TIME, "rotation takes longer",
              "a person goes on at the same pace while the scene turns; only one with the following "
              "frozen falls behind it"),
    _haptic(_LOSSES, "H loses contact least often, then UaH, then NoH",
            "a person does not use the force that is felt to stay at the wall; it only pushes the "
            "hand away from it"),
    _rotation(_LOSSES, "with rotation, contact is lost more often"),
    _haptic(_PENETRATION, "H is least deep, then UaH, then NoH"),
    Ranking(_ANGLE, "Rotation", _IN_UAH, "in UaH, rotation makes the angle smaller"),
    *(Ranking(measure, "A4 in UaH", _IN_UAH, f"in UaH, rotation makes the {measure.name} smaller",
              is_of_paper=False) for measure in (_TIME, _LOSSES, _PENETRATION)),
)


def _rounding(values: pd.DataFrame, participants: pd.Series) -> pd.Series:
    """The largest difference of two means that rounding can make, by point.

    A mean over `participants` of means over up to three cells is at most (participants + 5)
    roundings away from its value, each of half an epsilon of the largest value; two means differ.
    """
    largest = values.abs().max(axis=1).groupby("point").max()
    return np.finfo(float).eps * largest * (participants + 5)


def at_points(ranking: Ranking, sweep: Sweep) -> pd.DataFrame:
    """Where a ranking holds.

    Returns a row for each point (index: its number) and the columns participants; holds (1, 0, or
    NaN where no participant counts); is_clear; and the mean of each condition over participants.

    A participant counts if each cell of the ranking has a value (`cell_means`) and one trial of
    these cells was done: all conditions are thus compared by the same trials. A ranking holds if
    each mean is below the next one, by more than rounding. This is clear, more than noise of the
    persons, if the 95 % intervals (Student's t) of the paired differences of neighbours exclude 0;
    of a ranking that fails, that of a reversed pair.
    """
    cells = sweep.cells[ranking.measure.column]
    of_ranking = [cell for level in ranking.ascending.values() for cell in level]
    levels = pd.DataFrame({name: cells[list(level)].mean(axis=1, skipna=False)
                           for name, level in ranking.ascending.items()})
    levels = levels[(sweep.done[of_ranking] > 0).any(axis=1)].dropna()
    steps = levels.diff(axis=1).iloc[:, 1:].groupby("point")
    step, count = steps.mean(), steps.size()
    rounding = _rounding(levels, count)
    half_width = steps.std().mul(t_for_coverage(count - 1.0) / np.sqrt(count), axis=0)
    half_width = half_width.add(rounding, axis=0)  # NaN below two participants
    holds = step.gt(rounding, axis=0).all(axis=1)
    is_clear = np.where(holds, (step > half_width).all(axis=1), (step < -half_width).any(axis=1))
    found = levels.groupby("point").mean().assign(holds=holds.astype(float), is_clear=is_clear)
    found = found.reindex(sweep.points.index)
    found["is_clear"] = found["is_clear"].eq(True)
    return found.assign(participants=count.reindex(found.index).fillna(0).astype(int))
