"""The measures by which strategies are compared."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

Array = NDArray[np.float64]

TRAVEL = "device_travel_m"  # is compared with the workspace, too
_SHOWN = {"m": ("mm", 1e3), "J": ("mJ", 1e3), "1": ("%", 100.0)}


@dataclass(frozen=True)
class Measure:
    """A column of trials.csv. Lower is better, or, of works and forces that differ from those of a
    complete device in either direction, nearer to 0: then the magnitude of a trial's value counts.
    """

    name: str
    column: str
    unit: str  # of the column; empty for counts
    nearer_to_zero: bool = False

    @property
    def better(self) -> str:
        return "nearer to 0" if self.nearer_to_zero else "lower"

    @property
    def shown_unit(self) -> str:
        return _SHOWN.get(self.unit, (self.unit, 1.0))[0]

    @property
    def shown_per_unit(self) -> float:
        """A value of the column times this has the shown unit."""
        return _SHOWN.get(self.unit, (self.unit, 1.0))[1]

    @property
    def heading(self) -> str:
        """"contact angle, deg"; "losses of contact"."""
        return f"{self.name}, {self.shown_unit}" if self.unit else self.name


MEASURES = (  # in the order of tables, as in engine/trials/compare/compared_measures.cpp
    Measure("contact angle", "mean_contact_angle_deg", "deg"),
    Measure("penetration", "mean_penetration_m", "m"),
    Measure("total time", "total_time_s", "s"),
    Measure("losses of contact", "losses_of_contact", ""),
    Measure("losses of 0.1 s", "losses_100ms", ""),
    Measure("timeouts", "status", "1"),
    Measure("ghost force", "mean_ghost_force_N", "N"),
    Measure("missing force", "mean_missing_force_N", "N", nearer_to_zero=True),
    Measure("port work", "port_work_J", "J"),
    Measure("work lost", "work_lost_J", "J", nearer_to_zero=True),
    Measure("work along the wall", "wall_work_J", "J"),
    Measure("work of one contact", "largest_contact_work_J", "J"),
    Measure("empty turns", "empty_turns", ""),
    Measure("mean drift", "mean_drift_m", "m"),
    Measure("worst drift", "worst_drift_m", "m"),
    Measure("governed ticks", "governor_share", "1"),
    Measure("energy of turning", "turning_energy_J", "J"),
    Measure("device travel", TRAVEL, "m"),
)
BY_NAME = {measure.name: measure for measure in MEASURES}
BY_COLUMN = {measure.column: measure for measure in MEASURES}


def measured(trials: pd.DataFrame) -> pd.DataFrame:
    """The values of the measures: a row for each trial, a column for each name.

    timeouts: 1 after a timeout, otherwise 0. Any other measure has no value (NaN) unless the trial
    is done.
    """
    is_done = trials["status"] == "done"
    values = pd.DataFrame(index=trials.index)
    for measure in MEASURES:
        if measure.column == "status":
            values[measure.name] = (trials["status"] == "timeout").astype(float)
        elif measure.column in trials:
            column = trials[measure.column].where(is_done)
            values[measure.name] = column.abs() if measure.nearer_to_zero else column
        else:
            values[measure.name] = np.nan
    return values


def values_of(trials: pd.DataFrame, strategies: Sequence[str]) -> tuple[Array, list[str]]:
    """The values as an array (measures, hands, cells, strategies), and the object of each cell.

    A cell is an object and a block of it; what was not measured is NaN.
    """
    keys = ["participant", "object", "block", "attempt", "strategy"]
    table = measured(trials).set_index(pd.MultiIndex.from_frame(trials[keys]))
    hands = trials["participant"].unique()
    cells = pd.MultiIndex.from_frame(trials[keys[1:4]].drop_duplicates())
    rows = pd.MultiIndex.from_tuples([(hand, *cell) for hand in hands for cell in cells],
                                     names=keys[:4])
    wide = table.unstack("strategy").reindex(rows)
    columns = pd.MultiIndex.from_product([BY_NAME, strategies])
    values = wide.reindex(columns=columns).to_numpy(dtype=float)
    shape = (len(hands), len(cells), len(MEASURES), len(strategies))
    return values.reshape(shape).transpose(2, 0, 1, 3), list(cells.get_level_values("object"))
