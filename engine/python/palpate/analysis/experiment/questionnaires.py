"""Questionnaires that people answered after each condition (`questionnaires.csv`): NASA-TLX without
weights, and how real the contacts felt. Ratings are compared by ranks (statistics/ranks.py)."""

from __future__ import annotations

import math
import os
import pathlib
from dataclasses import dataclass, replace
from itertools import combinations, product
from typing import Any

import numpy as np
import pandas as pd

from palpate.analysis import measured, tables
from palpate.analysis.errors import InputError
from palpate.analysis.statistics import Friedman, SignedRank, friedman, holm, signed_rank
from palpate.analysis.statistics.types import Array
from palpate.analysis.tables import Column

from .experiments import HAPTIC, ROTATION, SEEN, check_haptic, natural

FILE = "questionnaires.csv"  # beside the file of trials
KEY = ("participant", "haptic", "rotation", "item")  # of a rating; a file has one for each block
ROW = ("participant", "block", *KEY[1:])
# The time and memory of the exact tests grow with the third power of this number.
MOST_PARTICIPANTS = 200


@dataclass(frozen=True)
class Rating:
    """A quantity that is compared: an item, or the mean of several."""

    name: str
    items: tuple[str, ...]


TLX = {"tlx_mental": "mental demand", "tlx_physical": "physical demand",
       "tlx_temporal": "temporal demand", "tlx_performance": "performance", "tlx_effort": "effort",
       "tlx_frustration": "frustration"}  # fmt: skip
REAL = "real"
RAW_TLX = Rating("raw TLX", tuple(TLX))
REALISM = Rating("how real", (REAL,))
RATINGS = (RAW_TLX, REALISM, *(Rating(name, (item,)) for item, name in TLX.items()))


@dataclass(frozen=True)
class Compared:
    """conditions: haptic and rotation, in their order. values: (participants, conditions); NaN: not
    answered. pairs: the later condition minus the earlier one, with Holm's p over all of them."""

    rating: Rating
    conditions: list[tuple[str, str]]
    values: Array
    friedman: Friedman
    pairs: list[tuple[tuple[str, str], tuple[str, str], SignedRank, float]]


@dataclass(frozen=True)
class Questionnaires:
    """file: as the user named it. compared: the ratings that somebody gave, in the order of
    RATINGS."""

    file: str
    participants: int
    compared: list[Compared]


def columns() -> list[Column]:
    """All columns of questionnaires.csv, in their order."""
    path = pathlib.Path(__file__).with_name("questionnaire_columns.csv")
    return tables.columns_in(path.read_text(encoding="utf-8"))


def read_questionnaires(path: str | os.PathLike[str]) -> pd.DataFrame:
    """Read a questionnaires.csv, strictly: a row for each answer, with the columns participant,
    haptic, rotation, item (str), block and value (int64).

    Raises InputError with the file, the line and the column for other columns, a value that its item
    does not permit, a repeated answer, and for more than MOST_PARTICIPANTS; and as check_haptic()
    does.
    """
    rows = measured.read_rows(pathlib.Path(path), columns(), ROW)
    for line, (item, value) in enumerate(zip(rows["item"], rows["value"]), start=2):
        expected = _expected(item)
        if value not in expected:
            words = f"a whole number from {expected[0]} to {expected[-1]}"
            words += f" in steps of {expected.step}" if expected.step > 1 else ""
            error = tables.field_error(line, "value", str(value),
                                       f"{words}, because the item is {item}")
            raise InputError(os.fspath(path), error.element, error.problem)
    try:
        check_haptic(rows)
    except InputError as error:
        raise InputError(os.fspath(path), error.element, error.problem, error.hint) from None
    people = rows["participant"].nunique()
    if people > MOST_PARTICIPANTS:
        raise InputError(os.fspath(path), "column participant", f"has {people} levels; expected at "
                         f"most {MOST_PARTICIPANTS}", "divide the file")
    return rows


def _expected(item: str) -> range:
    return range(1, 8) if item == REAL else range(0, 101, 5)


def compare(rows: pd.DataFrame, file: str) -> Questionnaires:
    """rows: of read_questionnaires(). The answers of a participant in several blocks are averaged."""
    people = sorted(set(rows["participant"]), key=natural)
    there = set(zip(rows["haptic"], rows["rotation"]))
    conditions = [each for each in product((*HAPTIC, *SEEN), ROTATION) if each in there]
    answers, unit = _over_blocks(rows)
    compared = []
    for rating in RATINGS:
        keys = [(p, *c, i) for p, c, i in product(people, conditions, rating.items)]
        index = pd.MultiIndex.from_tuples(keys, names=KEY)
        table = answers.reindex(index).to_numpy().reshape(len(people), len(conditions), -1)
        if not np.isnan(sums := table.sum(axis=2)).all():
            compared.append(_compared(rating, conditions, sums, unit))
    return Questionnaires(file, len(people), compared)


def _over_blocks(rows: pd.DataFrame) -> tuple[pd.Series[float], int]:
    """Means over the blocks that a participant rated, by KEY, times a whole number, the second value.
    All products are whole: means have a rounding, which could part ties."""
    groups = rows.groupby(list(KEY))["value"]
    count = groups.count()
    unit = math.lcm(*(int(n) for n in count.unique()))
    return (groups.sum() * (unit // count)).astype(float), unit


def _compared(rating: Rating, conditions: list[tuple[str, str]], sums: Array, unit: int) -> Compared:
    """sums: of the items, times the unit. Unlike their means, they have no rounding."""
    places = list(combinations(range(len(conditions)), 2))
    tests = [signed_rank(sums[:, j], sums[:, i]) for i, j in places]
    p_holm = holm([test.p for test in tests])
    n = len(rating.items) * unit
    pairs = [(conditions[i], conditions[j],
              replace(test, difference=test.difference / n, low=test.low / n, high=test.high / n),
              float(p))
             for (i, j), test, p in zip(places, tests, p_holm)]  # fmt: skip
    return Compared(rating, conditions, sums / n, friedman(sums), pairs)


def beside(trials: str) -> Questionnaires | None:
    """Those of the file beside the trials; None if there is none."""
    path = os.path.join(os.path.dirname(trials), FILE)
    return compare(read_questionnaires(path), path) if os.path.lexists(path) else None


# Tables

RATING_COLUMNS = "rating haptic rotation n median low_quartile high_quartile mean".split()
TEST_COLUMNS = ("test rating pair statistic df p p_holm effect_size difference low_95 high_95 "
                "participants unequal").split()  # fmt: skip


def pair_name(first: tuple[str, str], second: tuple[str, str]) -> str:
    """ "H, R - NoH, R"."""
    return f"{', '.join(second)} - {', '.join(first)}"


def quartiles(values: Array) -> Array:
    """Low quartile, median and high quartile, between ranks by linear interpolation; NaN without a
    value."""
    there = values[~np.isnan(values)]
    return np.asarray(np.quantile(there, [0.25, 0.5, 0.75]) if len(there) else [np.nan] * 3)


def ratings_table(found: Questionnaires | None) -> pd.DataFrame:
    """A row for each rating and condition."""
    rows: list[list[Any]] = []
    for compared in found.compared if found else ():
        for place, condition in enumerate(compared.conditions):
            values = compared.values[:, place]
            low, median, high = quartiles(values)
            there = values[~np.isnan(values)]
            mean = there.mean() if len(there) else np.nan
            rows.append([compared.rating.name, *condition, len(there), median, low, high, mean])
    return pd.DataFrame(rows, columns=RATING_COLUMNS)


def tests_table(found: Questionnaires | None) -> pd.DataFrame:
    """A row for each test. effect_size: Kendall's W, or the rank biserial r."""
    rows: list[dict[str, Any]] = []
    for compared in found.compared if found else ():
        name, test = compared.rating.name, compared.friedman
        rows.append({"test": "Friedman", "rating": name, "statistic": test.chi2, "df": test.df,
                     "p": test.p, "effect_size": test.kendall_w,
                     "participants": test.participants})
        for first, second, pair, p_holm in compared.pairs:
            rows.append({"test": "Wilcoxon signed ranks", "rating": name,
                         "pair": pair_name(first, second), "statistic": pair.w, "p": pair.p,
                         "p_holm": p_holm, "effect_size": pair.r, "difference": pair.difference,
                         "low_95": pair.low, "high_95": pair.high, "participants": pair.pairs,
                         "unequal": pair.unequal})
    table = pd.DataFrame(rows, columns=TEST_COLUMNS)
    return table.astype({"participants": "Int64", "unequal": "Int64"})
