"""Results of a run that the program measured: a table with all columns, and `run.json`."""

from __future__ import annotations

import json
import math
import pathlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import pandas as pd

from palpate.analysis import tables
from palpate.analysis.errors import InputError
from palpate.analysis.tables import Column


@dataclass(frozen=True)
class Run:
    """What `run.json` says of a run."""

    plan: str  # name
    seed: int
    operator: str  # name
    operator_version: int
    version: str  # of Palpate


def read_run(path: pathlib.Path) -> Run:
    """Read a `run.json`. Raises InputError for anything but a run."""
    try:
        content = json.loads(tables.read_text(path))
    except ValueError as error:
        raise InputError(str(path), "", f"is not JSON: {error}") from None

    def entry(kind: type, *keys: str) -> Any:
        value = content
        for key in keys:
            value = value.get(key) if isinstance(value, Mapping) else None
        if type(value) is not kind:
            expected = "a text" if kind is str else "a whole number"
            raise InputError(str(path), "/" + "/".join(keys), f"is no value; expected {expected}",
                             "name a folder of results of `experiment`")
        return value

    return Run(entry(str, "plan", "name"), entry(int, "seed"), entry(str, "operator", "name"),
               entry(int, "operator", "version"), entry(str, "version"))


def read_rows(path: pathlib.Path, columns: Sequence[Column], key: Sequence[str]) -> pd.DataFrame:
    """Read a table whose first line has the names of these columns.

    Returns a row for each line: whole numbers as int64, numbers as float64 (NaN for an empty
    field), words as str. Raises InputError, which names the line and the column, for a field that
    its column does not permit, and for two rows with the same values of the columns `key`.
    """
    try:
        return _rows_in(tables.read_text(path), columns, key)
    except InputError as error:
        raise InputError(str(path), error.element, error.problem, error.hint) from None


def _rows_in(text: str, columns: Sequence[Column], key: Sequence[str]) -> pd.DataFrame:
    lines = tables.lines_of(text)
    names = [column.name for column in columns]
    _, header = next(lines)
    if header != names:
        raise InputError("", "line 1", "has other columns; expected " + ",".join(names))
    readers = [(column, column.reader(), math.nan if column.values.startswith("number") else "")
               for column in columns]
    rows, numbers = [], []
    for line, fields in lines:
        if len(fields) != len(names):
            raise InputError("", f"line {line}", f"has {len(fields)} fields; expected "
                                                 f"{len(names)}, as in the first line")
        row: list[Any] = []
        for (column, read, blank), field in zip(readers, fields):
            try:
                row.append(blank if field in column.blanks else read(field))
            except ValueError as expected:
                raise tables.field_error(line, column.name, field, str(expected)) from None
        rows.append(row)
        numbers.append(line)
    if not rows:
        raise InputError("", "", "has no row; expected a line for each row below the first line")
    table = pd.DataFrame(rows, columns=names)
    again = table.duplicated(list(key))
    if again.any():
        where = " ".join(str(table[name][again.idxmax()]) for name in key)
        raise InputError("", f"line {numbers[int(again.idxmax())]}", f"has {', '.join(key)} "
                         f"{where} again; expected each once", "remove one of the lines")
    return table
