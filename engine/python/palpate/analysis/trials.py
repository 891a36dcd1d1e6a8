"""Trials of an experiment, by people or by simulated persons: `trials.csv`."""

from __future__ import annotations

import math
import os
import pathlib
from collections.abc import Callable

import pandas as pd

from palpate.analysis import tables
from palpate.analysis.errors import InputError
from palpate.analysis.tables import Cell, Column, field_error

MOST_TRIALS = 1 << 18
_OTHER_MEANING = "rename the column if it has another meaning"
_STRATEGY = "an empty field, or the name of a strategy, such as a4"
# What an empty field of these columns stands for: what the paper did.
AS_IN_PAPER: dict[str, Cell] = {"view": "turning", "align": "nearest",
                                "start_orientation_deg": 0.0, "scale": 1.0}
_ABSENT: dict[str, Cell] = {"following": "", "strategy": "", "trial": 0, "attempt": 1,
                            **AS_IN_PAPER, "pilot": 0, "reason": ""}
_KEY = ("following", "participant", "block", "haptic", "rotation", "strategy", "object", "attempt",
        "view", "align", "start_orientation_deg", "scale", "pilot")
_CUT = ("aborted", "skipped")  # statuses that have a reason
# The columns that only live trials have.
_LIVE = ("pilot", "input", "motion", "reason", "returns_shown", "clutches", "pictures",
         "longest_picture_s", "css_px_per_mm")
_STILL = ("adapts-0", "adapts-0.5", "adapts-1")  # followings whose display does not turn


def columns() -> list[Column]:
    """All columns of trials.csv, in their order, with those of comparisons."""
    path = pathlib.Path(__file__).with_name("columns.csv")
    return tables.columns_in(path.read_text(encoding="utf-8"))


def measures() -> list[str]:
    """The names of the columns that hold a measure."""
    names = [column.name for column in columns()]
    return names[names.index("status") + 1: names.index("strategy")]


def read_trials(path: str | os.PathLike[str]) -> pd.DataFrame:
    """Read the trials of a file, strictly.

    Returns a row for each trial, in the order of the file, and all columns of `columns.csv` that
    identify a trial, `pilot` (1: of a pilot run) and `reason` (why a trial was cut); of the measures
    and of the other columns of live trials, those that the file has. Texts are str (empty: no
    value), `block`, `trial`, `attempt` and `pilot` are int64, other numbers are float64 (NaN: no
    value) in the unit that their name ends with.

    Raises InputError (one line with the file, the line and the column) for what breaks RFC 4180,
    for a missing or repeated column, a value that `columns.csv` does not permit, a measure that is
    not finite in a trial that is done, a reason in a trial that was not cut, and for a trial that
    occurs twice. Other columns are ignored.
    """
    text = tables.read_text(path)
    try:
        return _parsed(text)
    except InputError as error:
        raise InputError(os.fspath(path), error.element, error.problem, error.hint) from None


class _Reader:
    """Reads the fields of a line into a row."""

    def __init__(self, header: list[str]) -> None:
        all_columns = columns()
        self.places = tables.places_of(all_columns, header)
        present = [column for column in all_columns if column.name in self.places]
        first = ("following", "participant", "block", "trial")
        self.measures = [name for name in measures() if name in self.places]
        order = {**dict.fromkeys(first), "strategy": None,
                 **dict.fromkeys(c.name for c in present if c.name not in self.measures)}
        by_name = {column.name: column for column in present}
        self.cells: list[tuple[str, int, tuple[str, ...], Callable[[str], Cell]]] = [
            (name, self.places[name], by_name[name].blanks, by_name[name].reader())
            for name in order if name in by_name]
        self.measure_cells = [(name, self.places[name], "0.." in by_name[name].values)
                              for name in self.measures]
        live = [by_name[name] for name in _LIVE if name in by_name and name != "pilot"]
        self.live_numbers = [column.name for column in live if not column.is_text]
        self.absent = {**_ABSENT, **{c.name: "" if c.is_text else math.nan for c in live}}

    def row(self, line: int, fields: list[str]) -> dict[str, Cell]:
        row = dict(self.absent)
        for name, place, blanks, read in self.cells:
            field = fields[place]
            if name == "reason":
                _check_reason(line, field, str(row["status"]), read)
            if field in blanks:
                continue
            if name in ("haptic", "rotation") and row["strategy"]:
                if field:
                    raise field_error(line, name, field,
                                      f"an empty field, because strategy is {row['strategy']}")
                row[name] = ""
                continue
            try:
                row[name] = read(field)
            except ValueError as error:
                expected = _STRATEGY if name == "strategy" else str(error)
                hint = _OTHER_MEANING if name in (*AS_IN_PAPER, "strategy", *_LIVE) else ""
                raise field_error(line, name, field, expected, hint) from None
        _check_view(line, row)
        for name, place, not_negative in self.measure_cells:
            row[name] = _measure(line, name, fields[place], not_negative, row["status"] == "done")
        return row


def _check_reason(line: int, field: str, status: str, read: Callable[[str], Cell]) -> None:
    if (field != "") == (status in _CUT):
        return
    expected = "an empty field"
    if not field:
        try:
            read(field)
        except ValueError as error:
            expected = str(error)
    raise field_error(line, "reason", field, f"{expected}, because the status is {status}")


def _check_view(line: int, row: dict[str, Cell]) -> None:
    expected = "still" if row["following"] in _STILL else "turning"
    if row["following"] and row["view"] != expected:
        raise field_error(line, "view", str(row["view"]),
                          f"{expected}, because the following is {row['following']}")


def _measure(line: int, name: str, field: str, not_negative: bool, is_done: bool) -> float:
    if field in ("", "NA"):
        return math.nan
    value = tables.number_in(field)
    if value is None:
        raise field_error(line, name, field, "a number, such as 0.25, or an empty field")
    if not_negative and value < 0.0:
        raise field_error(line, name, field, "a number of at least 0, or an empty field")
    if math.isfinite(value):
        return value
    if is_done:
        raise field_error(line, name, field, "a finite number, because the status is done",
                          "leave the field empty if the measure is undefined")
    return math.nan


def _described(row: dict[str, Cell]) -> str:
    parts = [row["following"] or None, f"participant {row['participant']}", f"block {row['block']}",
             row["strategy"] or f"{row['haptic']}, {row['rotation']}", row["object"],
             f"attempt {row['attempt']}", row["view"], row["align"],
             f"{row['start_orientation_deg']:g} deg", f"scale {row['scale']:g}",
             "pilot" if row["pilot"] else None]
    return ", ".join(str(part) for part in parts if part is not None)


def _parsed(text: str) -> pd.DataFrame:
    lines = tables.lines_of(text)
    _, header = next(lines) if text else (0, [])
    if not header:
        raise InputError("", "", "is empty; expected a line with the names of columns")
    reader = _Reader(header)
    rows: list[dict[str, Cell]] = []
    line_of: dict[tuple[Cell, ...], int] = {}
    for line, fields in lines:
        if fields == [""]:
            continue
        if len(fields) != len(header):
            raise InputError("", f"line {line}", f"has {len(fields)} fields; expected "
                                                 f"{len(header)}, as in the first line")
        if len(rows) == MOST_TRIALS:
            raise InputError("", f"line {line}", "is beyond the limit; expected at most "
                                                 f"{MOST_TRIALS} trials", "divide the file")
        row = reader.row(line, fields)
        first = line_of.setdefault(tuple(row[name] for name in _KEY), line)
        if first != line:
            raise InputError("", f"line {line}", f"has the trial of line {first} again: "
                             f"{_described(row)}; expected each trial once",
                             "remove one of the lines, or number the attempts")
        rows.append(row)
    if not rows:
        raise InputError("", "", "has no trial; expected a line for each trial below the first "
                                 "line")
    return pd.DataFrame(rows).astype(dict.fromkeys(reader.live_numbers, float))
