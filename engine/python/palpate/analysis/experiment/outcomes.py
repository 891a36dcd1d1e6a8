"""The quantities of a trial that are analysed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from palpate.analysis.numbers import with_unit


@dataclass(frozen=True)
class Outcome:
    key: str  # of the columns that with_outcomes() adds
    name: str
    unit: str  # empty for counts
    column: str  # of trials.csv
    decimals: int = 2  # for readers

    @property
    def heading(self) -> str:
        """ "Total time (s)"."""
        text = with_unit(self.name, self.unit)
        return text[0].upper() + text[1:]


TIME = Outcome("time", "total time", "s", "total_time_s")
LOSSES = Outcome("losses", "losses of contact", "", "losses_of_contact")
PENETRATION = Outcome("penetration", "mean penetration", "dm", "mean_penetration_dm", 4)
ANGLE = Outcome("angle", "mean contact angle", "deg", "mean_contact_angle_deg")
LOSS_RATE = Outcome("loss_rate", "losses of contact per second", "1/s", "losses_per_s")
LONG_LOSSES = Outcome("long_losses", "losses of contact of 100 ms or more", "", "losses_100ms")
# The time, and the time limit for a trial with the status timeout.
TIME_TO_LIMIT = Outcome("time_to_limit", "total time, timeouts as the limit", "s", "total_time_s")
# In the order of reports.
OUTCOMES = (TIME, LOSSES, PENETRATION, ANGLE, LOSS_RATE, LONG_LOSSES, TIME_TO_LIMIT)
# The three measures of the paper's MANOVA and ANOVAs.
PAPER_OUTCOMES = (TIME, LOSSES, PENETRATION)


def with_outcomes(frame: pd.DataFrame, limit_s: float) -> pd.DataFrame:
    """The trials with a column for each outcome, by its key; NaN: the trial does not have it, as no
    trial has that was not completed (except TIME_TO_LIMIT after a timeout)."""
    done = (frame["status"] == "done").to_numpy()

    def measure(column: str) -> pd.Series[float]:
        if column not in frame:
            return pd.Series(np.nan, index=frame.index)
        return frame[column].where(done)

    values = {outcome.key: measure(outcome.column) for outcome in OUTCOMES}
    values["penetration"] = values["penetration"].fillna(10.0 * measure("mean_penetration_m"))
    time_s = values["time"].where(values["time"] > 0.0)
    values["loss_rate"] = values["loss_rate"].fillna(values["losses"] / time_s)
    timeout = frame["status"] == "timeout"
    values["time_to_limit"] = values["time_to_limit"].mask(timeout, limit_s)
    return frame.assign(**values)
