"""Compares the numbers of two results, and names the place of each difference.

    assert_agree(json.loads(found), case.json("analysis.json"))
    assert_tables_agree(rows, case.csv("effects.csv"), zeros=[Zero("*column f*", 1e-20, "...")])
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Any

RELATIVE = 1e-9
# Distribution functions of two libraries agree less well in the far tail.
TAIL, RELATIVE_IN_TAIL = 1e-12, 1e-6
_P_VALUE = re.compile(r"(^|_)p(_|$)")
MOST_SHOWN = 30


@dataclass(frozen=True)
class Zero:
    """Numbers that are 0 in exact arithmetic, and are the rounding of a library in both results.

    paths: a pattern of fnmatch. within: the largest rounding. why: the reason why they are 0.
    """

    paths: str
    within: float
    why: str


def is_p_value(name: str) -> bool:
    """Whether a key or a column is a p-value: p, gg_p, p_holm."""
    return bool(_P_VALUE.search(name))


def _numbers_agree(found: float, expected: float, name: str) -> bool:
    if found == expected or (math.isnan(found) and math.isnan(expected)):
        return True
    if not (math.isfinite(found) and math.isfinite(expected)):
        return False
    in_tail = is_p_value(name) and abs(expected) < TAIL
    relative = RELATIVE_IN_TAIL if in_tail else RELATIVE
    return abs(found - expected) <= relative * max(abs(found), abs(expected))


def _number_difference(
    found: float, expected: float, path: str, name: str, zeros: Sequence[Zero]
) -> str | None:
    if _numbers_agree(found, expected, name):
        return None
    for zero in zeros:
        if fnmatchcase(path, zero.paths) and max(abs(found), abs(expected)) <= zero.within:
            return None
    size = max(abs(found), abs(expected))
    share = abs(found - expected) / size
    return f"{path}: is {found!r}; expected {expected!r} (relative {share:.2g})"


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def differences(
    found: Any, expected: Any, zeros: Sequence[Zero] = (), path: str = "$", name: str = ""
) -> Iterator[str]:
    """The differences of two JSON trees, one line each, such as "$.effects[3].p: is 1; expected 2".

    Keys and strings must be equal, in any order of keys; numbers agree to RELATIVE, p-values below
    TAIL to RELATIVE_IN_TAIL. 1 and 1.0 are the same number.
    """
    if _is_number(found) and _is_number(expected):
        difference = _number_difference(found, expected, path, name, zeros)
        if difference:
            yield difference
    elif isinstance(found, dict) and isinstance(expected, dict):
        for key in expected.keys() | found.keys():
            if key not in found or key not in expected:
                yield f"{path}.{key}: is {'missing' if key in expected else 'not expected'}"
        for key in expected.keys() & found.keys():
            yield from differences(found[key], expected[key], zeros, f"{path}.{key}", key)
    elif isinstance(found, list) and isinstance(expected, list):
        if len(found) != len(expected):
            yield f"{path}: has {len(found)} elements; expected {len(expected)}"
        for i, pair in enumerate(zip(found, expected)):
            yield from differences(*pair, zeros, f"{path}[{i}]", name)
    elif type(found) is not type(expected) or found != expected:
        yield f"{path}: is {found!r}; expected {expected!r}"


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def table_differences(
    found: Sequence[Sequence[str]], expected: Sequence[Sequence[str]], zeros: Sequence[Zero] = ()
) -> Iterator[str]:
    """The differences of two tables whose first rows are the names of the columns, such as
    "line 3, column p: is 1; expected 2"."""
    if not found or list(found[0]) != list(expected[0]):
        yield f"line 1: is {found[:1]}; expected {expected[:1]}"
        return
    if len(found) != len(expected):
        yield f"has {len(found)} lines; expected {len(expected)}"
    for line, (cells, others) in enumerate(zip(found, expected), start=1):
        if len(cells) != len(others):
            yield f"line {line}: has {len(cells)} fields; expected {len(others)}"
        for column, cell, other in zip(expected[0], cells, others):
            if cell == other:
                continue
            path = f"line {line}, column {column}"
            numbers = _number(cell), _number(other)
            if numbers[0] is None or numbers[1] is None:
                yield f"{path}: is {cell!r}; expected {other!r}"
                continue
            difference = _number_difference(numbers[0], numbers[1], path, column, zeros)
            if difference:
                yield difference


_NUMBER_IN_TEXT = re.compile(r"(?<![\w.])[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")


def numbers_in(text: str) -> list[float]:
    """The numbers of a text, in their order."""
    return [float(number) for number in _NUMBER_IN_TEXT.findall(text.replace("\u2212", "-"))]


def _assert_none(found: Iterator[str], what: str) -> None:
    lines = list(found)
    shown = lines[:MOST_SHOWN] + (["..."] if len(lines) > MOST_SHOWN else [])
    assert not lines, f"{what}: {len(lines)} differences\n" + "\n".join(shown)


def assert_agree(found: Any, expected: Any, zeros: Sequence[Zero] = (), what: str = "JSON") -> None:
    _assert_none(differences(found, expected, zeros), what)


def assert_tables_agree(
    found: Sequence[Sequence[str]],
    expected: Sequence[Sequence[str]],
    zeros: Sequence[Zero] = (),
    what: str = "table",
) -> None:
    _assert_none(table_differences(found, expected, zeros), what)
