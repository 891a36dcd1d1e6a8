"""The points of a sweep and their means, from `sweep.csv`."""

from __future__ import annotations

import functools
import pathlib
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from palpate.analysis import measured, numbers, tables
from palpate.analysis.errors import InputError
from palpate.analysis.tables import Column

HAPTICS = ("NoH", "UaH", "H")
ROTATIONS = ("NoR", "R")
CELLS = pd.MultiIndex.from_product([HAPTICS, ROTATIONS], names=["haptic", "rotation"])
KEY = ("point", "participant", "haptic", "rotation")
TIME = "total_time_s"
# Symbols of the documents.
_SYMBOLS = {"sight_delay_s": "tau", "intention_noise_m": "s", "force_noise": "c",
            "press_depth_m": "D", "hand_stiffness_N_per_m": "K_h", "speed_m_per_s": "v0",
            "stiffness_N_per_m": "K", "comfortable_depth_m": "e0"}

_OWN = "; empty: each participant's own"  # in the meaning of a parameter's column


@dataclass(frozen=True)
class Measure:
    """A measure of trials: its name, its unit ("": none) and its column."""

    name: str
    unit: str
    column: str

    @property
    def title(self) -> str:
        return numbers.with_unit(self.name, self.unit)


MEASURES = (Measure("total time", "s", TIME), Measure("losses of contact", "", "losses_of_contact"),
            Measure("mean penetration", "dm", "mean_penetration_dm"),
            Measure("mean contact angle", "deg", "mean_contact_angle_deg"))


@dataclass(frozen=True)
class Parameter:
    """A parameter that a sweep can vary. Its value is a number, or the place of one of `words`."""

    name: str
    unit: str
    meaning: str
    words: tuple[str, ...]  # empty: a number

    @property
    def label(self) -> str:
        """Name and symbol: "sight_delay_s (tau)"."""
        symbol = _SYMBOLS.get(self.name)
        return f"{self.name} ({symbol})" if symbol else self.name

    @property
    def title(self) -> str:
        """Meaning, symbol and unit: "noise of the intended position s (m)"."""
        text = " ".join(filter(None, (self.meaning, _SYMBOLS.get(self.name))))
        return numbers.with_unit(text, "" if self.unit == "1" else self.unit)

    def text(self, value: float) -> str:
        """A value for readers: "0.117", "delayed"."""
        return self.words[int(value)] if self.words else numbers.short_number(value)

    def cell(self, value: float) -> str | float:
        """A value for a table: a number or a word."""
        return self.words[int(value)] if self.words else value


@dataclass(frozen=True)
class Sweep:
    """The rows of `sweep.csv`, and what follows from them.

    points: by number: block, parameter (that varies; "": none), the value of each parameter (NaN:
    each participant has its own), trials, done. cells: of each measure, by point and participant
    (rows) and condition (columns, CELLS); NaN where `cell_means` has no value. done: the numbers of
    trials, with the same rows and columns.
    """

    rows: pd.DataFrame
    parameters: dict[str, Parameter]
    points: pd.DataFrame
    cells: dict[str, pd.DataFrame]
    done: pd.DataFrame

    @functools.cached_property
    def varied(self) -> list[Parameter]:
        """The parameters that the sweep varies."""
        there = set(self.points["parameter"])
        return [self.parameters[name] for name in self.parameters if name in there]


def columns() -> list[Column]:
    """All columns of sweep.csv, in their order."""
    path = pathlib.Path(__file__).with_name("columns.csv")
    return tables.columns_in(path.read_text(encoding="utf-8"))


def all_parameters() -> dict[str, Parameter]:
    """The parameters by name, in the order of the columns."""
    names = [column.name for column in columns()]
    own = columns()[names.index("parameter") + 1: names.index("participant")]
    return {c.name: Parameter(c.name, c.unit, c.meaning.removesuffix(_OWN), _words(c)) for c in own}


def _words(column: Column) -> tuple[str, ...]:
    kind = column.values.removesuffix(" or empty")
    return () if kind.startswith("number") else tuple(kind.split("|"))


def cell_means(rows: pd.DataFrame, column: str) -> pd.Series:
    """The value of each row in rankings and figures.

    It does not depend on which trials a condition makes too hard to complete: the time counts the
    limit for a timeout; another measure has a value only if all trials were done. None has a value
    (NaN) if a trial ended with a fault.
    """
    mean, timeouts = rows[column], rows["timeouts"]
    ended = rows["done"] + timeouts
    with_limit = mean.fillna(0.0) * rows["done"] + rows["limit_s"] * timeouts
    timed_out = with_limit / ended.where(ended > 0) if column == TIME else np.nan
    lacks = (rows["trials"] == 0) | (rows["faults"] > 0) | ((rows["done"] > 0) & mean.isna())
    return mean.where(timeouts == 0, timed_out).mask(lacks)


def by_cell(rows: pd.DataFrame, values: pd.Series) -> pd.DataFrame:
    """Values of rows, by point and participant (rows) and condition (columns, CELLS)."""
    table = rows[list(KEY)].assign(value=values)
    return table.pivot(index=list(KEY[:2]), columns=list(KEY[2:]),
                       values="value").reindex(columns=CELLS)


def sweep_of(rows: pd.DataFrame) -> Sweep:
    """rows: the columns of sweep.csv, words of parameters as in the file."""
    parameters = all_parameters()
    places = {p.name: rows[p.name].map({word: float(i) for i, word in enumerate(p.words)})
              for p in parameters.values() if p.words}
    rows = rows.assign(**places)
    of_point = rows.groupby("point", sort=True)
    points = of_point[["block", "parameter", *parameters]].first()
    points[list(parameters)] = points[list(parameters)].astype(float)
    points[["trials", "done"]] = of_point[["trials", "done"]].sum()
    cells = {m.column: by_cell(rows, cell_means(rows, m.column)) for m in MEASURES}
    return Sweep(rows, parameters, points, cells, by_cell(rows, rows["done"]).fillna(0.0))


def read_sweep(path: pathlib.Path) -> Sweep:
    """Read a sweep.csv. Raises InputError, which names the line or the point, and the column."""
    rows = measured.read_rows(path, columns(), KEY)
    of_point = ["block", "parameter", *all_parameters()]
    unequal = rows.groupby("point")[of_point].nunique(dropna=False) > 1
    for point, column in unequal.stack()[lambda found: found].index:
        raise InputError(str(path), f"point {point}, column {column}",
                         "has several values; expected one for all rows of a point")
    sweep = sweep_of(rows)
    for parameter in sweep.varied:
        points = sweep.points
        sets = (points["block"] == "hypercube") | (points["parameter"] == parameter.name)
        lacks = sets & points[parameter.name].isna()
        if lacks.any():
            raise InputError(str(path), f"point {lacks.idxmax()}, column {parameter.name}",
                             "is empty; expected a value, because the point sets it")
    return sweep


def counts(rows: pd.DataFrame) -> Mapping[str, int]:
    """How the trials ended."""
    return {name: int(rows[name].sum()) for name in ("trials", "done", "timeouts", "faults")}
