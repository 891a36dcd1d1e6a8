"""Questionnaires beside the trials: read strictly; every test, median and interval is R's
(r/questionnaires.R wrote r/questionnaires.json), and those of small samples follow from definitions."""

from __future__ import annotations

import argparse
import json
import shutil
from fractions import Fraction
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from oracle_cases import table_of
from palpate.analysis.errors import InputError
from palpate.analysis.experiment import command
from palpate.analysis.experiment.questionnaires import (
    MOST_PARTICIPANTS,
    RATINGS,
    TEST_COLUMNS,
    compare,
    read_questionnaires,
)
from palpate.analysis.report import Report
from palpate.analysis.statistics import friedman, signed_rank

HERE = Path(__file__).resolve().parent / "r"
R: dict[str, Any] = json.loads((HERE / "questionnaires.json").read_text())
RELATIVE = 1e-9
HEADER = "participant,block,haptic,rotation,item,value\n"
GOOD = HEADER + "1,1,NoH,R,tlx_effort,45\n1,1,NoH,R,real,7\n2,1,NoH,R,tlx_effort,100\n"


@pytest.fixture(scope="module")
def report() -> Report:
    """Beside people.csv lies questionnaires.csv."""
    return command.run(argparse.Namespace(trials=str(HERE / "people.csv"), limit=120.0))


@pytest.fixture(scope="module")
def analysis(report: Report) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(report.files["analysis.json"])
    return found


def rows_of(rows: list[dict[str, Any]], **values: str) -> list[dict[str, Any]]:
    return [row for row in rows if all(row[name] == value for name, value in values.items())]


def assert_equal(row: dict[str, Any], expected: dict[str, Any]) -> None:
    for name, value in expected.items():
        if name not in ("pair", "p_normal"):
            assert row[name] == pytest.approx(value, rel=RELATIVE, abs=1e-12), (name, expected)


@pytest.mark.parametrize("expected", R["ratings"], ids=lambda rating: rating["rating"])
def test_every_number_is_the_one_of_r(analysis: dict[str, Any], expected: dict[str, Any]) -> None:
    tests = rows_of(analysis["rating_tests"], rating=expected["rating"])
    [found] = rows_of(tests, test="Friedman")
    assert_equal(found, expected["friedman"])
    pairs = rows_of(tests, test="Wilcoxon signed ranks")
    assert [row["pair"] for row in pairs] == [pair["pair"] for pair in expected["pairs"]]
    for row, pair in zip(pairs, expected["pairs"]):
        assert_equal(row, pair)
        # With ties, wilcox.test() has the normal approximation with a correction for continuity.
        assert row["p"] == pytest.approx(pair["p_normal"], abs=0.05)
    medians = rows_of(analysis["ratings"], rating=expected["rating"])
    assert len(medians) == 6
    for row, median in zip(medians, expected["medians"]):
        assert (row["haptic"], row["rotation"]) == (median.pop("haptic"), median.pop("rotation"))
        assert_equal(row, median)


def test_all_ratings_are_compared(analysis: dict[str, Any]) -> None:
    names = [rating["rating"] for rating in R["ratings"]]
    assert names == [rating.name for rating in RATINGS]
    assert list(dict.fromkeys(row["rating"] for row in analysis["rating_tests"])) == names
    assert len(analysis["rating_tests"]) == 8 * 16
    ties = [row for row in analysis["rating_tests"] if row["unequal"] != row["participants"]]
    assert len(ties) > 40  # and who left something out is not in all of them
    assert {row["participants"] for row in analysis["rating_tests"]} == {10, 11, 12}


@pytest.mark.parametrize("expected", R["without_ties"], ids=lambda case: len(case["differences"]))
def test_without_ties_all_is_as_wilcox_test_says(expected: dict[str, Any]) -> None:
    differences = expected["differences"]
    found = signed_rank(differences, np.zeros(len(differences)))
    for name, key in (("w", "statistic"), ("p", "p"), ("difference", "difference"),
                      ("low", "low_95"), ("high", "high_95")):
        assert getattr(found, name) == pytest.approx(expected[key], rel=RELATIVE)
    other_way = signed_rank(np.zeros(len(differences)), differences)
    assert (other_way.p, other_way.r) == (found.p, -found.r)
    assert (other_way.low, other_way.high) == (-found.high, -found.low)


def test_the_p_of_ties_is_the_share_of_all_signs() -> None:
    rng = np.random.default_rng(51)  # the seed
    for n in range(1, 9):
        d = rng.choice([-20, -15, -10, -5, 5, 10, 15, 20], n).astype(float)
        ranks = np.array([(np.abs(d) < size).sum() + 0.5 * ((np.abs(d) == size).sum() + 1)
                          for size in np.abs(d)])
        signs = np.array(list(product((0, 1), repeat=n)))
        sums, w = signs @ ranks, ranks[d > 0].sum()
        p = min(1.0, 2.0 * min((sums <= w).mean(), (sums >= w).mean()))
        found = signed_rank(d, np.zeros(n))
        assert (found.p, found.w) == (p, w), d
        assert found.r == pytest.approx((w - ranks[d < 0].sum()) / ranks.sum())
        assert np.isnan(found.low) == (n < 6)


def test_what_the_answers_do_not_determine_has_no_number() -> None:
    equal = signed_rank([5.0, 10.0, np.nan], [5.0, 10.0, 3.0])
    assert (equal.pairs, equal.unequal, equal.difference) == (2, 0, 0.0)
    assert np.isnan([equal.p, equal.w, equal.r, equal.low]).all()
    nobody = signed_rank([np.nan], [1.0])
    assert nobody.pairs == 0 and np.isnan(nobody.difference)
    for table in ([[1, 2, 3]], [[1, 2], [2, 3], [4, 5]], [[4, 4, 4], [2, 2, 2]],
                  [[1, 2, np.nan], [3, 2, 1]]):
        assert np.isnan(friedman(table).p)


def test_friedman_agrees_with_its_definition() -> None:
    table = np.array([[1.0, 2.0, 4.0], [10.0, 20.0, 15.0], [3.0, 5.0, 9.0], [7.0, 8.0, 30.0]])
    ranks = table.argsort(axis=1).argsort(axis=1) + 1.0
    chi2 = 12.0 / (4 * 3 * 4) * np.square(ranks.sum(axis=0)).sum() - 3.0 * 4 * 4
    found = friedman(table)
    assert (found.chi2, found.df) == (pytest.approx(chi2), 2.0)
    assert found.kendall_w == pytest.approx(chi2 / 8.0)


def test_blocks_are_averaged_without_rounding(tmp_path: Path) -> None:
    """Means over two or three blocks, of which a rounded one would part equal differences: W+ of exact
    fractions."""
    rng = np.random.default_rng(52)  # the seed
    means: dict[str, list[Fraction]] = {"NoR": [], "R": []}
    lines = []
    for person in range(40):
        blocks = range(1, 3 + person % 2)
        for rotation, of_people in means.items():
            values = rng.integers(1, 8, len(blocks)).tolist()
            of_people.append(Fraction(sum(values), len(values)))
            lines += [f"{person},{block},H,{rotation},real,{value}\n"
                      for block, value in zip(blocks, values)]
    (tmp_path / "q.csv").write_text(HEADER + "".join(lines))
    [compared] = compare(read_questionnaires(tmp_path / "q.csv"), "q.csv").compared
    d = [after - before for before, after in zip(means["NoR"], means["R"]) if after != before]
    ranks = [sum(abs(x) < abs(of) for x in d) + Fraction(sum(abs(x) == abs(of) for x in d) + 1, 2)
             for of in d]
    assert len(set(ranks)) < len(d) - 10  # ties
    [(_, _, test, _)] = compared.pairs
    assert test.unequal == len(d)
    assert test.w == float(sum(rank for rank, x in zip(ranks, d) if x > 0))
    assert compared.values == pytest.approx(np.array([means["NoR"], means["R"]], dtype=float).T)


# --- The file

def refusal(text: str, folder: Path) -> str:
    path = folder / "q.csv"
    path.write_text(text)
    with pytest.raises(InputError) as refused:
        read_questionnaires(path)
    return str(refused.value).replace(str(path), "q.csv")


def test_answers_are_read(tmp_path: Path) -> None:
    path = tmp_path / "q.csv"
    path.write_text(GOOD)
    rows = read_questionnaires(path)
    assert rows["value"].to_list() == [45, 7, 100] and rows["value"].dtype.kind == "i"
    found = compare(rows, "q.csv")
    assert [each.rating.name for each in found.compared] == ["how real", "effort"]  # no raw TLX


@pytest.mark.parametrize(("old", "new", "problem"), [
    ("45", "47", 'line 2, column value: is "47"; expected a whole number from 0 to 100 in steps of 5'
                 ", because the item is tlx_effort"),
    (",7", ",8", 'line 3, column value: is "8"; expected a whole number from 1 to 7, because the '
                 "item is real"),
    (",7", ",0", 'line 3, column value: is "0"; expected a whole number from 1 to 7, because the '
                 "item is real"),
    ("45", "105", 'line 2, column value: is "105"; expected a whole number from 0 to 100'),
    ("45", "4.5", 'line 2, column value: is "4.5"; expected a whole number from 0 to 100'),
    ("45", "", 'line 2, column value: is ""; expected a whole number from 0 to 100'),
    ("real", "Real", 'line 3, column item: is "Real"; expected tlx_mental, tlx_physical, '
                     "tlx_temporal, tlx_performance, tlx_effort, tlx_frustration or real"),
    ("1,1,NoH", "1,0,NoH", 'line 2, column block: is "0"; expected a whole number from 1 to 1000000'),
    ("1,NoH", "1,UaR", 'line 2, column haptic: is "UaR"; expected NoH, UaH, H, seen-UaH or seen-H'),
    ("2,1,NoH", "1,1,NoH", "line 4: has participant, block, haptic, rotation, item 1 1 NoH R tlx_effort again; "
                       "expected each once (remove one of the lines)"),
    (",value", ",answer", "line 1: has other columns; expected participant,block,haptic,rotation,item,"
                          "value"),
    (",7\n", "\n", "line 3: has 5 fields; expected 6, as in the first line"),
    (GOOD, HEADER, "has no row; expected a line for each row below the first line"),
    (GOOD, "", "line 1: has other columns; expected participant,block,haptic,rotation,item,value"),
])
def test_a_broken_file_is_refused(tmp_path: Path, old: str, new: str, problem: str) -> None:
    assert refusal(GOOD.replace(old, new, 1), tmp_path) == f"q.csv: {problem}"


def test_too_many_participants_are_refused(tmp_path: Path) -> None:
    lines = [f"{n},1,NoH,R,real,4\n" for n in range(MOST_PARTICIPANTS + 1)]
    assert "expected at most 200" in refusal(HEADER + "".join(lines), tmp_path)


def test_a_broken_file_beside_the_trials_is_refused_by_its_name(tmp_path: Path) -> None:
    shutil.copy(HERE / "people.csv", tmp_path / "trials.csv")
    (tmp_path / "questionnaires.csv").write_text(GOOD.replace("45", "46"))
    with pytest.raises(InputError) as refused:
        command.run(argparse.Namespace(trials=str(tmp_path / "trials.csv"), limit=120.0))
    assert refused.value.path == str(tmp_path / "questionnaires.csv")


# --- The page

def test_the_page_and_the_terminal_show_them(report: Report) -> None:
    page = report.files["report.html"]
    shown = page[page.index('id="questionnaires"'):]
    for text in ("12 participants answered", "Kendall\u2019s W", "<h4>raw TLX</h4>", "W+",
                 "<h4>how real</h4>", "Pairs of the six scales", "H, R - NoH, NoR"):
        assert text in shown, text
    [line] = [line for line in report.text.splitlines() if "raw TLX" in line]
    assert line == ("questionnaires of 12 people: raw TLX, Friedman chi2(5) = 41.6, p < 0.001, n 10")
    assert table_of(report.files["rating_tests.csv"])[0] == TEST_COLUMNS


def test_without_them_the_tables_are_empty_and_the_page_says_nothing(tmp_path: Path) -> None:
    shutil.copy(HERE / "people.csv", tmp_path / "trials.csv")
    report = command.run(argparse.Namespace(trials=str(tmp_path / "trials.csv"), limit=120.0))
    assert len(table_of(report.files["ratings.csv"])) == 1
    assert len(table_of(report.files["rating_tests.csv"])) == 1
    assert 'id="questionnaires"' not in report.files["report.html"]
    assert "questionnaires of" not in report.text
