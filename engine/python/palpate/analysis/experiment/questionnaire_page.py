"""What the page and the terminal say about questionnaires."""

from __future__ import annotations

from typing import Any

from palpate.analysis.numbers import (
    df_text,
    number_or_dash,
    p_number,
    p_text,
    short_number,
    with_decimals,
)
from palpate.analysis.statistics import SIGNIFICANCE

from .page_tables import Cell, Row, Table
from .questionnaires import RAW_TLX, REALISM, Compared, Questionnaires, pair_name, quartiles

MAIN = (RAW_TLX, REALISM)


def section(found: Questionnaires | None) -> dict[str, Any] | None:
    """Texts and tables of the page; None without questionnaires."""
    if found is None:
        return None
    pairs = [(each.rating, _pairs(each)) for each in found.compared]
    return {
        "file": found.file,
        "participants": found.participants,
        "medians": _medians(found.compared),
        "friedman": _friedman(found.compared),
        "pairs": [(rating.name, table) for rating, table in pairs if rating in MAIN],
        "pairs_of_scales": [(rating.name, table) for rating, table in pairs if rating not in MAIN],
    }


def terminal_lines(found: Questionnaires | None) -> list[str]:
    """ "questionnaires of 12 people: raw TLX, Friedman chi2(5) = 12.3, p = 0.031"."""
    if found is None:
        return []
    lines = []
    for test, name in ((c.friedman, c.rating.name) for c in found.compared if c.rating in MAIN):
        words = f"chi2({df_text(test.df)}) = {number_or_dash(test.chi2)}, {p_text(test.p)}"
        lines.append(f"questionnaires of {found.participants} people: {name}, "
                     f"Friedman {words}, n {test.participants}")
    return lines


def _significant(p: float) -> Cell:
    """In bold if it is."""
    text = p_number(p)
    return {"kind": "strong", "text": text} if p < SIGNIFICANCE else text


def _medians(compared: list[Compared]) -> Table:
    heads = ["rating", *(", ".join(condition) for condition in compared[0].conditions)]
    rows: list[Row] = []
    for each in compared:
        cells: list[Cell] = [each.rating.name]
        for place in range(len(each.conditions)):
            values = each.values[:, place]
            low, median, high = (number_or_dash(end) for end in quartiles(values))
            n = int((values == values).sum())
            cells.append(f"{median} ({low} to {high}), n\u00a0{n}")
        rows.append(cells)
    return Table(heads, rows)


def _friedman(compared: list[Compared]) -> Table:
    rows: list[Row] = []
    for each in compared:
        test = each.friedman
        rows.append([each.rating.name, number_or_dash(test.chi2), df_text(test.df),
                     _significant(test.p), with_decimals(test.kendall_w, 3), test.participants])
    return Table(["rating", "\u03c7\u00b2", "df", "p", "Kendall\u2019s W", "n participants"], rows)


def _pairs(compared: Compared) -> Table:
    rows: list[Row] = []
    for first, second, test, p_holm in compared.pairs:
        ends = [with_decimals(end, 1) for end in (test.low, test.high)]
        interval = f" ({ends[0]} to {ends[1]})" if "-" not in ends else ""
        rows.append([pair_name(first, second), with_decimals(test.difference, 1) + interval,
                     with_decimals(test.r, 2), "-" if test.unequal == 0 else short_number(test.w),
                     p_number(test.p), _significant(p_holm), test.unequal, test.pairs])
    heads = ["pair", "difference, 95 % interval", "r", "W+", "p", "Holm p", "n unequal",
             "n participants"]  # fmt: skip
    return Table(heads, rows)
