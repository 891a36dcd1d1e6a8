"""What `palpate accuracy` measured: `accuracy.json`, with a table of levels for each knob."""

from __future__ import annotations

import json
import pathlib
import re
from dataclasses import dataclass
from typing import Any

import pandas as pd

from palpate.analysis.errors import InputError
from palpate.analysis.tables import quoted

FORMAT = "palpate-accuracy-1"


@dataclass(frozen=True)
class Knob:
    """A setting that trades time for accuracy.

    facts: its object in the file. levels: a row for each level of each method, in the order of the
    file, with the columns `method` (index), `level` (index within the method), `label`, `value` (in
    the unit of the level), `error`, `error_low`, `error_high`, `time`, `time_low`, `time_high`
    (median and quartiles over the repeats, in the units of error and time; NaN: every repeat
    failed), `iterations`, `repeats`, `failures`, `failure`, `at_floor`, `on_front`, `counts` (no
    repeat failed), `is_default`, `is_recommended` and `is_undecided` (it would be recommended, but
    the spread is wider than its effect). presets: the same for the three presets, with
    the name of the preset as the label.
    """

    facts: dict[str, Any]
    levels: pd.DataFrame
    presets: pd.DataFrame

    @property
    def methods(self) -> list[dict[str, Any]]:
        """Name, fitted and expected order (None: none) and floor of each method."""
        methods: list[dict[str, Any]] = self.facts["methods"]
        return methods

    @property
    def has_choice(self) -> bool:
        """Whether the user can choose the level or the method."""
        return not (self.facts["levels_are_given"] and self.facts["methods_are_given"])

    def row(self, of: str) -> pd.Series | None:
        """The level that is the "default", "recommended" or "undecided", or None."""
        rows = self.levels[self.levels["is_" + of]]
        return None if rows.empty else rows.iloc[0]


@dataclass(frozen=True)
class Results:
    """The whole file. facts: its other members."""

    facts: dict[str, Any]
    knobs: list[Knob]


def _level(raw: dict[str, Any]) -> dict[str, Any]:
    row = {key: value for key, value in raw.items() if key not in ("error", "time")}
    for name in ("error", "time"):
        spread = raw[name] or {}
        row |= {name: spread.get("median"), f"{name}_low": spread.get("low"),
                f"{name}_high": spread.get("high")}
    return row | {"counts": raw["failures"] == 0}


def _table(rows: list[dict[str, Any]]) -> pd.DataFrame:
    numbers = ["value", "iterations", *(f"{of}{end}" for of in ("error", "time")
                                        for end in ("", "_low", "_high"))]
    return pd.DataFrame(rows).astype(dict.fromkeys(numbers, "float64"))


def knob(raw: dict[str, Any]) -> Knob:
    """The knob of an object in the file."""
    rows = []
    for m, method in enumerate(raw["methods"]):
        for n, level in enumerate(method["levels"]):
            place = {"method": m, "level": n}
            marks = {f"is_{of}": raw[of] == place for of in ("default", "recommended", "undecided")}
            rows.append(place | _level(level) | marks)
    presets = [{"method": -1, "level": n} | _level(preset)
               for n, preset in enumerate(raw["presets"])]
    return Knob(raw, _table(rows), _table(presets))


def read(path: pathlib.Path) -> Results:
    """Read the file. Raises InputError if it is not one that `palpate accuracy` wrote."""
    try:
        raw = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(str(path), "", f"cannot be read: {error.strerror}") from None
    except ValueError:
        raise InputError(str(path), "", "is not JSON; expected accuracy.json of `palpate accuracy`"
                         ) from None
    if not isinstance(raw, dict) or raw.get("format") != FORMAT:
        raise InputError(str(path), "format", f"is not {FORMAT}",
                         "measure again with this version of the program")
    for each in raw["knobs"]:
        if not re.fullmatch("[a-z0-9_]+", each["name"]):  # a diagram has this name
            raise InputError(str(path), "name of a knob", f"is {quoted(each['name'])}; expected "
                             "lower-case letters, digits and underscores")
    return Results(raw, [knob(each) for each in raw["knobs"]])
