"""Means of the canonical protocol over participants."""

from __future__ import annotations

import pathlib
from dataclasses import dataclass

import numpy as np
import pandas as pd

from palpate.analysis import measured, tables
from palpate.analysis.statistics import t_for_coverage
from palpate.analysis.tables import Column

MOTIONS = ("pressed", "stroked")
STILL, TURNING = "NoR", "R"
RATIO, SHARE = "along_over_into", "share_within_30deg"
RATIO_SHOWN = 4.0  # tan a is 4 at 76 deg: all angles of the plan that ships but 90 deg are below
DECIMALS = 3  # of what a table shows
LEAST_HALF_WIDTH = 0.5 * 10.0 ** -DECIMALS  # of an interval that is shown
KEY = ("participant", "angle_deg", "motion", "rotation")


def columns() -> list[Column]:
    """All columns of canonical.csv, in their order."""
    path = pathlib.Path(__file__).with_name("columns.csv")
    return tables.columns_in(path.read_text(encoding="utf-8"))


def read_canonical(path: pathlib.Path) -> pd.DataFrame:
    """Read a canonical.csv: a row for each trial; NaN where a measure has no value."""
    return measured.read_rows(path, columns(), KEY)


def means_of(rows: pd.DataFrame, measure: str, motion: str) -> pd.DataFrame:
    """The participants' means of a measure for one motion.

    Returns a row for each angle (index: angle_deg, ascending) and, for each rotation, the columns
    count, mean (NaN without a value) and half_width: half of the mean's 95 % interval (Student's
    t), NaN below two participants.
    """
    of_motion = rows[rows["motion"] == motion]
    found = of_motion.groupby(["angle_deg", "rotation"])[measure].agg(["count", "mean", "std"])
    found["half_width"] = (t_for_coverage(found["count"] - 1.0) * found["std"]
                           / np.sqrt(found["count"].clip(lower=1)))
    return found.drop(columns="std").unstack("rotation").swaplevel(axis=1)


@dataclass(frozen=True)
class RatioAxis:
    """The vertical axis of the ratio. tan a has no limit, and R would be invisible beside it: the
    axis ends above R and above RATIO_SHOWN, and NoR and tan a are cut there."""

    top: float
    is_cut: bool  # whether a mean of NoR is above the end


ABOVE_HIGHEST = 0.08  # the range of an axis ends above the highest value by this share
_LEAST_TOP = 0.5


def ratio_axis(means: pd.DataFrame) -> RatioAxis:
    """means: those of RATIO (means_of)."""
    def highest(rotation: str) -> float:
        of = means[rotation]
        return float(np.nanmax([0.0, *(of["mean"] + of["half_width"].fillna(0.0))]))

    still, turning = highest(STILL), highest(TURNING)
    shown = min(max(still, turning), max(turning, RATIO_SHOWN))
    top = max(shown, _LEAST_TOP) * (1.0 + ABOVE_HIGHEST)
    return RatioAxis(top, bool((means[STILL]["mean"] > top).any()))
