"""Numbers as texts: for readers (three digits and a suitable unit), for JSON and for CSV.

Numbers of results have `DIGITS` significant digits: what a sum of double precision keeps on every
version of NumPy and SciPy, so that the same input prints the same digits. NaN and infinite values
are `null` in JSON and empty fields in CSV.
"""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

DIGITS = 10

_PREFIXES = (("M", "M", 1e6), ("k", "k", 1e3), ("", "", 1.0), ("m", "m", 1e-3), ("u", "µ", 1e-6),
             ("n", "n", 1e-9))  # as written in a unit, as shown, factor
_BASES = ("Hz", "m", "s", "N", "J", "W")
_ROUNDS_TO_NEXT = 0.9995  # a number that rounds to 1000 gets the next unit
_LEAST_OF_SMALLEST = 1e-3  # of the smallest prefixed unit; below, a power of ten is clearer


def settled(value: float) -> float:
    """The number with two digits more than results have.

    The exact value of a sum is often a tie, such as 0.09375, and the last bits of its rounding
    would decide between 0.0937 and 0.0938. They differ between versions of libraries.
    """
    return float(f"{value:.{DIGITS + 2}g}")


def short_number(value: float) -> str:
    """Three digits, or all digits of the integer part: "0.0123", "134", "20480", "1.2e-7"."""
    value = settled(value)
    if value == 0.0:
        return "0"
    if not math.isfinite(value):
        return "unbounded" if value > 0.0 else "none"
    size = abs(value)
    if not 1e-3 <= size < 1e6:
        mantissa, _, exponent = f"{value:.3g}".partition("e")
        return f"{mantissa}e{int(exponent)}" if exponent else mantissa
    decimals = max(0, 3 - (math.floor(math.log10(size)) + 1))
    text = f"{value:.{decimals}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def number_or_dash(value: float | None) -> str:
    """Three digits; "-" where there is no value."""
    return "-" if value is None or math.isnan(value) else short_number(value)


def with_decimals(value: float, decimals: int) -> str:
    """A number with this many decimals; "-" for NaN."""
    return "-" if math.isnan(value) else f"{settled(value):.{decimals}f}"


def p_number(p: float) -> str:
    """A probability: "0.012"; "< 0.001"; "-" for NaN."""
    if math.isnan(p):
        return "-"
    return "< 0.001" if p < 0.001 else with_decimals(p, 3 if p < 0.0995 else 2)


def p_text(p: float) -> str:
    """A probability with its name: "p = 0.012"; "p < 0.001"."""
    number = p_number(p)
    return f"p {number}" if number.startswith("<") else f"p = {number}"


def df_text(df: float) -> str:
    """Degrees of freedom: "2", "1572.3"."""
    return with_decimals(df, 0 if abs(df - round(df)) < 0.05 else 1)


def f_text(f: float, df1: float, df2: float) -> str:
    """An F with its degrees of freedom: "F(2, 18) = 12.3"."""
    return f"F({df_text(df1)}, {df_text(df2)}) = {number_or_dash(f)}"


def display_unit(typical: float, unit: str) -> tuple[float, str]:
    """Factor and name of the unit that suits a number of this size: (1e6, "µm") for 1.3e-6 "m".

    The unit changes if it is m, s, N, J, W or Hz, with or without a prefix, alone or as a
    numerator ("N/m"); any other unit is kept.
    """
    head, slash, rest = unit.partition("/")
    base = next((b for b in _BASES if head.endswith(b)), None)
    if base is None:
        return 1.0, unit
    written = head[: len(head) - len(base)]
    own = next((factor for w, _, factor in _PREFIXES if w == written), None)
    if own is None:
        return 1.0, unit
    size = abs(typical) * own
    if not size >= _LEAST_OF_SMALLEST * _PREFIXES[-1][2]:
        return own, base + slash + rest
    for _, shown, factor in _PREFIXES:
        too_large = factor > 1.0 and base in ("m", "s")  # no kilometres
        if not too_large and size >= _ROUNDS_TO_NEXT * factor:
            return own / factor, shown + base + slash + rest
    _, shown, factor = _PREFIXES[-1]
    return own / factor, shown + base + slash + rest


def human(value: float, unit: str) -> str:
    """A number with its unit: "1.3 µs". Zero has no unit: "0"."""
    if value == 0.0:
        return "0"
    factor, name = display_unit(value, unit)
    number = short_number(value * factor)
    return f"{number} {name}" if name else number


def with_unit(name: str, unit: str) -> str:
    """A quantity with its unit: "depth error (µm)", or the name alone."""
    return f"{name} ({unit})" if unit else name


def rounded(value: float) -> float:
    """The number with `DIGITS` significant digits."""
    return float(f"{settled(value):.{DIGITS}g}") + 0.0  # no -0


def plain(value: Any) -> Any:
    """A value for JSON: rounded numbers, None for what is not finite, lists and dicts of these."""
    if isinstance(value, Mapping):
        return {str(key): plain(each) for key, each in value.items()}
    if isinstance(value, str):
        return value.encode("utf-8", "replace").decode()  # a name of a file need not be UTF-8
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    if isinstance(value, (int, np.integer)):
        return int(value)
    if isinstance(value, (float, np.floating)):
        number = rounded(float(value))
        return number if math.isfinite(number) else None
    if isinstance(value, np.ndarray) or (
        isinstance(value, Iterable) and not isinstance(value, str)
    ):
        return [plain(each) for each in value]
    return value


def json_line(value: Any) -> str:
    """JSON on one line."""
    return json.dumps(plain(value), ensure_ascii=False, allow_nan=False, separators=(",", ":"))


def json_text(value: Mapping[str, Any]) -> str:
    """A JSON document: each key on a line of its own, and each row of a table, too."""
    parts = []
    for key, each in value.items():
        is_table = isinstance(each, Sequence) and not isinstance(each, str) and len(each) > 0
        if is_table and all(isinstance(row, Mapping) for row in each):
            text = "[\n   " + ",\n   ".join(json_line(row) for row in each) + "\n ]"
        else:
            text = json_line(each)
        parts.append(f"{json_line(str(key))}: {text}")
    return "{" + ",\n ".join(parts) + "}\n"


def csv_text(columns: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """Comma-separated values (RFC 4180, lines end with LF); None and NaN are empty fields."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(columns)
    for row in rows:
        writer.writerow("" if cell is None else cell for cell in map(plain, row))
    return out.getvalue()


def as_printed(value: float) -> str:
    """The fewest digits that identify the number, as in the paper and in plans: "836.377", "25"."""
    fixed = np.format_float_positional(value, trim="-")
    scientific = np.format_float_scientific(value, trim="-")
    return scientific if len(scientific) < len(fixed) else fixed
