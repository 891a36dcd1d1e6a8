"""What a sweep shows: the means along one parameter, where rankings flip, and where they hold."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from palpate.analysis.statistics import SIGNIFICANCE, wilson
from palpate.analysis.sweep import chance, rankings
from palpate.analysis.sweep.points import CELLS, MEASURES, Parameter, Sweep
from palpate.analysis.sweep.rankings import RANKINGS, Ranking

Row = dict[str, Any]
Rows = list[Row]
LOW, HIGH = "low half", "high half"
# The tables and their columns.
COLUMNS = {
    "one_at_a_time": ("parameter", "level", "point", "measure", "haptic", "rotation",
                      "trials_of_point", "done_of_point", "participants", "mean", "sd"),
    "flips": ("parameter", "ranking", "order", "from", "to", "holds_at_from", "holds_at_to",
              "is_clear"),
    "rankings": ("ranking", "order", "is_of_paper", "points", "untestable", "holds", "share", "low",
                 "high", "decisive_parameters", "p"),
    "halves": ("ranking", "parameter", "part", "points", "holds", "share", "difference"),
}


@dataclass(frozen=True)
class Findings:
    """The tables of a sweep, each a list of rows with the columns that COLUMNS has.

    one_at_a_time: the means at the levels of each parameter. flips: between two levels of a
    parameter, a ranking begins to hold or ceases to. rankings: the share of the points of the
    hypercube at which a ranking holds. halves: this share in the parts of the hypercube by one
    parameter.
    """

    one_at_a_time: Rows
    flips: Rows
    rankings: Rows
    halves: Rows

    def tables(self) -> dict[str, Rows]:
        """The tables by name, for files: each row has its cells in the order of COLUMNS."""
        return {name: [{column: row[column] for column in columns} for row in vars(self)[name]]
                for name, columns in COLUMNS.items()}


def axis_of(sweep: Sweep, parameter: Parameter) -> list[int]:
    """The points at which this parameter alone varies, by ascending value: those of its levels,
    and the base plan's, unless its participants have different values."""
    points = sweep.points
    is_base = (points["block"] == "base") & points[parameter.name].notna()
    on_axis = points[is_base | (points["parameter"] == parameter.name)]
    return [int(p) for p in on_axis[parameter.name].sort_values(kind="stable").index]


def _level_rows(sweep: Sweep, parameter: Parameter) -> Rows:
    """Means over the participants who have a value, with their standard deviations (n - 1)."""
    found: Rows = []
    for point in axis_of(sweep, parameter):
        of_point = sweep.points.loc[point]
        for measure in MEASURES:
            cells = sweep.cells[measure.column].loc[point]
            count, mean, sd = cells.count(), cells.mean(), cells.std()
            found += [{"parameter": parameter.name, "point": point, "measure": measure.column,
                       "level": parameter.cell(of_point[parameter.name]), "haptic": cell[0],
                       "rotation": cell[1], "trials_of_point": int(of_point["trials"]),
                       "done_of_point": int(of_point["done"]), "participants": int(count[cell]),
                       "mean": mean[cell], "sd": sd[cell]} for cell in CELLS]
    return found


def _flip_rows(sweep: Sweep, parameter: Parameter, ranking: Ranking, at: pd.DataFrame) -> Rows:
    """Each flip is against the last level at which the ranking is testable; it is clear if the
    ranking is at both levels."""
    along = at.loc[axis_of(sweep, parameter)].dropna(subset=["holds"])
    values = sweep.points[parameter.name]
    pairs = zip(along.index, along.index[1:])
    return [{"parameter": parameter.name, "ranking": ranking.name, "order": ranking.order,
             "from": parameter.cell(values[a]), "to": parameter.cell(values[b]),
             "holds_at_from": int(at["holds"][a]), "holds_at_to": int(at["holds"][b]),
             "is_clear": int(at["is_clear"][a] and at["is_clear"][b])}
            for a, b in pairs if at["holds"][a] != at["holds"][b]]


def parts_of(values: pd.Series, parameter: Parameter) -> pd.Series:
    """The part of each point of the hypercube by a parameter; no value: it is in no part.

    Each word is a part. Of numbers, the parts are the points with the first half of the values that
    occur in ascending order and those with the last half; the middle of an odd number of values
    belongs to neither.
    """
    if parameter.words:
        dtype = pd.CategoricalDtype([parameter.words[int(v)] for v in np.unique(values)])
        return values.map(parameter.text).astype(dtype)
    present, place = np.unique(values, return_inverse=True)
    half = len(present) // 2
    names = np.where(place < half, LOW, np.where(place >= len(present) - half, HIGH, ""))
    return pd.Series(names, values.index).astype(pd.CategoricalDtype([LOW, HIGH]))


def _difference(shares: pd.Series) -> float:
    """Of two parts, the last share minus the first; of more, the largest minus the smallest."""
    if shares.count() < 2:
        return np.nan
    return float(shares.iloc[1] - shares.iloc[0] if len(shares) == 2 else np.ptp(shares.dropna()))


def _half_rows(ranking: Ranking, parameter: Parameter, holds: pd.Series, parts: pd.Series) -> Rows:
    counts = holds.groupby(parts, observed=False).agg(["count", "sum"])
    shares = counts["sum"] / counts["count"]
    difference = _difference(shares)
    return [{"ranking": ranking.name, "parameter": parameter.name, "part": part,
             "points": int(of["count"]), "holds": int(of["sum"]), "share": shares[part],
             "difference": difference} for part, of in counts.iterrows()]


def _decisive(ranking: Ranking, holds: pd.Series, parts: dict[str, pd.Series],
              halves: Rows) -> tuple[float, list[str]]:
    """The p of the largest difference of all parameters (NaN if none differs), and the parameters
    that have it, several if equal; none if p is not significant."""
    sizes = {row["parameter"]: abs(row["difference"]) for row in halves}
    differences = pd.Series(sizes, dtype=float)
    largest = differences.max()
    if not largest > 0.0:
        return np.nan, []
    testable = holds.notna().to_numpy()
    splits = [part.cat.codes.to_numpy()[testable] for part in parts.values()]
    p = chance.largest_difference_p(splits, holds[testable].to_numpy() > 0, ranking.name)
    most = differences[differences >= largest - chance.ROUNDING].index
    return p, list(most) if p < SIGNIFICANCE else []


def _ranking_row(ranking: Ranking, holds: pd.Series, p: float, decisive: list[str]) -> Row:
    points, held = int(holds.count()), int(holds.sum())
    low, high = wilson(held, points) if points else (np.nan, np.nan)
    return {"ranking": ranking.name, "order": ranking.order,
            "is_of_paper": int(ranking.is_of_paper), "points": points,
            "untestable": len(holds) - points, "holds": held,
            "share": held / points if points else np.nan, "low": low, "high": high,
            "decisive_parameters": " ".join(decisive), "p": p}


def findings_of(sweep: Sweep) -> Findings:
    hypercube = sweep.points[sweep.points["block"] == "hypercube"]
    parts = {p.name: parts_of(hypercube[p.name], p) for p in sweep.varied}
    at_points = [(ranking, rankings.at_points(ranking, sweep)) for ranking in RANKINGS]
    shares, halves = [], []
    for ranking, at in at_points:
        holds = at["holds"].loc[hypercube.index]
        rows = [row for parameter in sweep.varied
                for row in _half_rows(ranking, parameter, holds, parts[parameter.name])]
        shares.append(_ranking_row(ranking, holds, *_decisive(ranking, holds, parts, rows)))
        halves += rows
    return Findings([row for p in sweep.varied for row in _level_rows(sweep, p)],
                    [row for p in sweep.varied for ranking, at in at_points
                     for row in _flip_rows(sweep, p, ranking, at)], shares, halves)
