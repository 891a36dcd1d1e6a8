"""`experiment analyse` against what the C++ printed and wrote (oracle/README.md).

The verdicts are of another method since then (experiment_analysis_test.py), so that of the findings
only the paper's statements and the verdicts by the paper's own test are compared, and of the page
what is below the box.
"""

from __future__ import annotations

import argparse
import json
import re
from collections import Counter

import pytest
from markupsafe import Markup

from numbers_agree import Zero, assert_agree, assert_tables_agree
from oracle_cases import cases, table_of
from page_text import visible_text
from palpate.analysis.errors import InputError
from palpate.analysis.experiment import command, page
from palpate.analysis.experiment.tables import TABLES

WIDER = ("comparisons", "missing_trials")  # tables with new columns before the last ones
LATER = ("verdicts", "variances", "loss_rates", "ratings", "rating_tests")  # tables
LATER_KEYS = (*LATER, "pilot_rows")
# Effect sizes; trials that only people have.
LATER_COLUMNS = {"comparisons": ("d_z", "d_z_low_95", "d_z_high_95"),
                 "missing_trials": ("aborted", "skipped", "reasons")}
# People lead since then, and the texts count people and simulated persons apart.
MIXED = {"people_and_simulated", "people_and_simulated_with_both_views"}
# The program refuses these before it starts Python.
BY_THE_PROGRAM = {"refused_canonical_file", "refused_limit"}
ZEROS = [
    Zero("*.f", 1e-26, "an effect of 0"),
    Zero("*_eta2", 1e-26, "an effect of 0"),
    Zero("*.sd", 1e-12, "of equal values"),
    Zero("*.half_width_95", 1e-13, "of equal values"),
    Zero("*.difference", 1e-13, "of equal values"),
    Zero("*.p", 1e-300, "C++ has 0 for probabilities below the normal numbers"),
]
# Of small_scatter, values of 1e6 and more differ by 1e-3: their means keep few digits of that.
# Of nearly_collinear, see below. Table, the analysis of its rows, tolerance.
IN_FEWER_DIGITS = {
    "small_scatter": [("comparisons", "plsd", 1e-5), ("comparisons", "paired t", 1e-5),
                      ("means", None, 1e-5)],
    "nearly_collinear": [("effects", "manova", 1e-3)],
}
# Wilks' lambda of Haptic in `nearly_collinear`, computed with 40 digits from the definition. The C++
# multiplied residuals, which loses half of the digits, and had 0.799491256382.
LAMBDA_OF_NEARLY_COLLINEAR = 0.799488753742507


def no_drawing(figure, name, title):
    return Markup("<svg></svg>")


# The note on several attempts, before the last completed one counted.
ATTEMPTS = "Of several attempts at a trial the last one counts; rows of earlier attempts: {}."


def run(case, folder, monkeypatch):
    case.put_inputs(folder)
    monkeypatch.chdir(folder)
    file = next(word for word in case.arguments if word.endswith(".csv"))
    limit = 120.0
    if "--limit" in case.arguments:
        limit = float(case.arguments[case.arguments.index("--limit") + 1])
    return command.run(argparse.Namespace(trials=file, limit=limit))


@pytest.mark.parametrize("case", cases("analyse", refused=False), ids=lambda case: case.name)
def test_report_has_the_numbers_and_texts(case, tmp_path, monkeypatch):
    monkeypatch.setattr(page, "svg", no_drawing)
    report = run(case, tmp_path, monkeypatch)
    assert sorted(report.files) == sorted([*case.results, *(f"{name}.csv" for name in LATER)])
    if case.name not in MIXED:
        found_line = report.text.splitlines()[0].partition("; repeated: ")[0]
        assert case.stdout.splitlines()[0] == found_line
    warnings = [f"palpate: warning: {line}" for line in report.warnings]
    expected = case.stderr.replace("is not drawn: figure: ", "is not drawn: ").splitlines()
    assert Counter(warnings) == Counter(expected)
    found, expected = json.loads(report.files["analysis.json"]), case.json("analysis.json")
    assert [name for name in found if name not in LATER_KEYS] == list(expected)
    for name in LATER_KEYS:
        del found[name]
    for name in found:
        if f"{name}.csv" in report.files:
            rows = table_of(report.files[f"{name}.csv"])
            heads = list(found[name][0]) if found[name] else rows[0]
            if expected[name] and name != "findings":
                assert heads[: len(expected[name][0])] == list(expected[name][0]) or name in WIDER
            texts = [heads, *([cell(row[head]) for head in heads] for row in found[name])]
            assert_tables_agree(rows, texts, [], name)
    for table, names in LATER_COLUMNS.items():
        for row in found[table]:
            for name in names:
                del row[name]
    if case.name in MIXED:
        for each in (found, expected):
            each["operators"].sort(key=whose)
            for name in set(each) & set(TABLES):
                each[name].sort(key=whose)
    align(case, found, expected)
    assert_agree(found, expected, ZEROS, case.name)
    if case.name not in MIXED:
        assert_has_lines(sections(report.files["report.html"]), sections(case.text("report.html").replace(": figure: ", ": ")))


def whose(row):
    return row["following"], row["view"], row["scale"]


def sections(html):
    """The lines of the operators and of the facts, without explanations of methods."""
    operators = html[html.index('<section class="operator"'): html.index('<section id="explanations"')]
    facts = html[html.index('<section id="facts"'):]
    lines = visible_text(operators) + visible_text(facts)
    changed = ("Significant p values are bold. The", "Paired t tests of", "Of several attempts")
    return [without_size(line) for line in lines if not line.startswith(changed)]


def without_size(line):
    """A row of pairs without its effect size, which came later."""
    cells = line.split(" | ")
    if len(cells) == 8 and (" - " in cells[0] or cells[0] == "pair"):
        del cells[2]
    return " | ".join(cells)


def cell(value):
    return "" if value is None else value if isinstance(value, str) else f"{value:.12g}"


def align(case, found, expected):
    """Takes known differences away, after it has judged them."""
    for each in found["operators"]:
        repeated = sum(each.pop("repeated").values())
        each["notes"] = [ATTEMPTS.format(repeated) if note.startswith("Of several attempts") else note
                         for note in each["notes"]]
    for each in expected["operators"] + found["operators"]:
        if case.name == "names_with_markup":
            # The C++ compared signed bytes, so that other letters than ASCII came first.
            each["participants"].sort()
    for rows in (found["findings"], expected["findings"]):
        for row in rows:
            papers = row.pop("verdict_of_the_papers_analysis", None)
            row.setdefault("verdict_by_the_papers_test", papers)
            for name in ("verdict", "because", "differs_between_followings"):
                del row[name]
            if row["finding"] == "losses of contact, Rotation x Haptic":
                del row["paper_statement"]
    if case.name == "nearly_collinear":
        mine = found["effects"][0]["wilks_lambda"]
        assert mine == pytest.approx(LAMBDA_OF_NEARLY_COLLINEAR, rel=1e-9)
    for table, analysis, relative in IN_FEWER_DIGITS.get(case.name, []):
        for mine, theirs in zip(found[table], expected[table]):
            for name, value in theirs.items() if theirs.get("analysis") == analysis else ():
                if isinstance(value, float):
                    assert mine[name] == pytest.approx(value, rel=relative)
                    theirs[name] = mine[name]


NUMBER = re.compile(r"\d+(?:\.\d+)?(?:e-?\d+)?")


def are_close(found, expected):
    """Whether numbers differ at most by one in the last printed digit, as of 22.125; what is 0 in
    exact arithmetic may be a rounding."""
    if NUMBER.sub("#", found) != NUMBER.sub("#", expected):
        return False
    for mine, theirs in zip(NUMBER.findall(found), NUMBER.findall(expected)):
        decimals = len(theirs.partition(".")[2])
        if abs(float(mine) - float(theirs)) > 1.01 * 10.0**-decimals:
            return False
    return True


def assert_has_lines(found, expected):
    """The expected lines are among the found ones, in their order."""
    rest = iter(found)
    for line in expected:
        assert any(mine == line or are_close(mine, line) for mine in rest), line


@pytest.mark.parametrize("case", cases("analyse", refused=True), ids=lambda case: case.name)
def test_refusal_is_the_same_line(case, tmp_path, monkeypatch):
    if case.name in BY_THE_PROGRAM:
        pytest.skip("refused by the program")
    with pytest.raises(InputError) as refused:
        run(case, tmp_path, monkeypatch)
    # Two forces that are seen came later.
    expected = case.stderr.replace("NoH, UaH or H", "NoH, UaH, H, seen-UaH or seen-H")
    assert f"palpate: {refused.value}\n" == expected
