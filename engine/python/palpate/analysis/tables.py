"""Reads comma-separated values as the program writes them, strictly.

The columns, whether they are required, and their values follow from `columns.csv`, which the
program writes beside every table.
"""

from __future__ import annotations

import csv
import math
import os
import pathlib
import re
import stat
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from palpate.analysis.errors import InputError, printable
from palpate.analysis.numbers import as_printed

MOST_BYTES = 1 << 28
MOST_NAME_BYTES = 100
_SHOWN_BYTES = 120  # of a field in a message
_NUMBER = re.compile(r"-?(?:(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|inf(?:inity)?|nan(?:\(\w*\))?)",
                     re.I | re.A)
_WHOLE = re.compile(r"-?\d+", re.A)
_RFC = "write comma-separated values as in RFC 4180"

Cell = str | int | float | None


def quoted(text: str) -> str:
    """A field in quotes, shortened, for a message."""
    raw = text.encode("utf-8", "surrogateescape")
    if len(raw) > _SHOWN_BYTES:
        text = raw[:_SHOWN_BYTES].decode("utf-8", "surrogateescape") + "..."
    return f'"{text}"'


def read_text(path: str | os.PathLike[str]) -> str:
    """The text of a regular file, without a byte order mark; bytes that are not UTF-8 are kept."""
    name = os.fspath(path)
    try:
        mode = os.stat(name).st_mode
        if not stat.S_ISREG(mode):
            kind = "is a folder" if stat.S_ISDIR(mode) else "is not a regular file"
            raise InputError(name, "", kind + "; expected a file" * stat.S_ISDIR(mode))
        if os.path.getsize(name) > MOST_BYTES:
            raise InputError(name, "", f"is larger than {MOST_BYTES} bytes", "divide the file")
        raw = pathlib.Path(name).read_bytes()
    except OSError as error:
        raise InputError(name, "", f"cannot be opened: {error.strerror}") from error
    if (zero := raw.find(b"\0")) >= 0:
        raise InputError(name, f"byte {zero}", "is zero; expected text",
                         "save the table as comma-separated text in UTF-8")
    return raw.decode("utf-8", "surrogateescape").removeprefix("\ufeff")


def lines_of(text: str) -> Iterator[tuple[int, list[str]]]:
    """Each line's number and fields. Errors: what breaks RFC 4180."""
    if '"' not in text and "\r" not in text:
        for number, line in enumerate(text.removesuffix("\n").split("\n"), 1):
            yield number, line.split(",")
        return
    _check_marks(text)
    number = 1
    for fields in csv.reader(_kept_lines(text), strict=True):
        yield number, fields or [""]
        number += 1 + sum(field.count("\n") for field in fields)


def _kept_lines(text: str) -> list[str]:
    return re.findall(r"[^\n]*\n|[^\n]+", text)


_FIELD = re.compile(r'"(?P<inside>(?:[^"]|"")*)(?P<end>"?)|(?P<plain>[^,\n\r"]*)')


def _check_marks(text: str) -> None:
    line, at = 1, 0
    while at < len(text):
        field = _FIELD.match(text, at)
        assert field is not None
        behind = field.end()
        begin, line = line, line + text.count("\n", at, behind)
        ends = behind == len(text) or text[behind] in ",\n" or text.startswith("\r\n", behind)
        if field["inside"] is not None and not field["end"]:
            problem = "has a quotation mark without its partner; expected two"
        elif ends:
            line += behind < len(text) and text[behind] != ","
            at = behind + (2 if text.startswith("\r\n", behind) else 1)
            continue
        elif field["inside"] is not None:
            problem = ("has text behind a closing quotation mark; expected a comma or the end of "
                       "the line")
        elif text[behind] == '"':
            problem = "has a quotation mark within a field; expected a quoted field"
        else:
            problem = ("has a carriage return within a field; expected LF or CRLF at the end of a "
                       "line")
        raise InputError("", f"line {begin}", problem, _RFC)


def number_in(field: str) -> float | None:
    """The number that the field is, also nan and inf; None for anything else."""
    if not _NUMBER.fullmatch(field):
        return None
    value = float(field.partition("(")[0])
    is_lost = math.isinf(value) or value == 0.0  # beyond the range of a double
    if is_lost and re.search(r"[1-9]", re.split("[eE]", field)[0]):
        return None
    return value


@dataclass(frozen=True)
class Column:
    """A line of `columns.csv`."""

    name: str
    unit: str
    is_required: bool
    values: str
    meaning: str = ""

    @property
    def blanks(self) -> tuple[str, ...]:
        """The fields that stand for no value."""
        if self.values.endswith(" or empty or NA"):
            return ("", "NA")
        return ("",) if self.values.endswith(" or empty") else ()

    @property
    def is_text(self) -> bool:
        """Whether the values are texts or names of levels."""
        return self.values.partition(" ")[0] not in ("whole", "number")

    def reader(self) -> Callable[[str], Cell]:
        """A function that returns the value of a field; ValueError says what was expected."""
        kind, _, rest = self.values.removesuffix(" or NA").removesuffix(" or empty").partition(" ")
        if kind == "text":
            return _read_name
        if kind == "whole":
            return _whole_reader(rest)
        if kind == "number":
            return _number_reader(rest)
        return _level_reader(kind.split("|"))


def _read_name(field: str) -> str:
    size = len(field.encode("utf-8", "surrogateescape"))
    if not 0 < size <= MOST_NAME_BYTES or field.strip(" ") != field or printable(field) != field:
        raise ValueError(f"a name of 1 to {MOST_NAME_BYTES} bytes in UTF-8, without blanks around "
                         "it and control characters")
    return field


def _whole_reader(limits: str) -> Callable[[str], int]:
    least, _, most = limits.partition("..")

    def read(field: str) -> int:
        if _WHOLE.fullmatch(field) and (not limits or int(least) <= int(field) <= int(most)):
            return int(field)
        raise ValueError(f"a whole number from {least} to {most}" if limits else "a whole number")

    return read


def _number_reader(limits: str) -> Callable[[str], float]:
    low, _, high = limits.lstrip(">").partition("..")
    least, most = float(low or "-inf"), float(high or "inf")
    expected = "a finite number"
    if low:
        expected = f"a number above {low}" if limits.startswith(">") else f"a number from {low}"
        expected += f" and at most {high}" if limits.startswith(">") and high else ""
        expected = f"a number of at least {low}" if not high and ">" not in limits else expected
        expected += f" to {high}" if high and ">" not in limits else ""
    elif high:
        expected = f"a number of at most {high}"

    def read(field: str) -> float:
        value = number_in(field)
        above = value is not None and (value > least if limits.startswith(">") else value >= least)
        if value is None or not math.isfinite(value) or not above or value > most:
            raise ValueError(expected)
        return value

    return read


def _level_reader(names: Sequence[str]) -> Callable[[str], str]:
    """A name may have the range of a number behind it: "a4-passive:0..1000"."""
    ranges = dict(name.split(":") for name in names if ":" in name)

    def has_number(field: str) -> bool:
        name, _, text = field.partition(":")
        value = number_in(text) if name in ranges else None
        low, high = ranges.get(name, "0..0").split("..")
        return value is not None and float(low) <= value <= float(high) and as_printed(value) == text

    def read(field: str) -> str:
        if field not in names and not has_number(field):
            raise ValueError(" or ".join(filter(None, (", ".join(names[:-1]), names[-1]))))
        return field

    return read


def columns_in(text: str) -> list[Column]:
    """The columns that the text of a `columns.csv` lists."""
    rows = csv.DictReader(text.splitlines())
    return [Column(row["name"], row["unit"], row["presence"] == "required", row["values"],
                   row["meaning"]) for row in rows]


def field_error(line: int, column: str, found: str, expected: str, hint: str = "") -> InputError:
    """A field that is refused."""
    return InputError("", f"line {line}, column {column}",
                      f"is {quoted(found)}; expected {expected}", hint)


def places_of(columns: Sequence[Column], header: list[str]) -> dict[str, int]:
    """The place of each column that the first line of a file has."""
    places = {}
    for column in columns:
        found = header.count(column.name)
        element = f"line 1, column {column.name}"
        if found == 1:
            places[column.name] = header.index(column.name)
        elif found > 1:
            raise InputError("", element, "is present more than once; expected once",
                             "remove or rename one of the columns")
        elif column.is_required:
            hint = "the first line must have the names of the columns"
            if len(header) == 1 and ";" in header[0]:
                hint = "separate the columns by commas, not by semicolons"
            raise InputError("", element, "is missing; expected this column", hint)
    return places
