"""`compare` against what the C++ printed and wrote (oracle/README.md).

The C++ tuned `anisotropic`: for each measure, its column had the E that was best on other hands. Now no
strategy is tuned, so that what follows from the tuning is left out here: the column, its key and table,
the role of a value of E, and the standings beside it.

Three things changed since. Hands with equal values had an interval of width 0 and have none now (null):
what was decided by it alone is named in EQUAL. A technique that is ranked alone was the best, and no
longer is. The travel of the device is new; the trials of the oracle get an empty column.
"""

import argparse
import csv
import json
import re
from collections import defaultdict

import pytest

from numbers_agree import RELATIVE
from oracle_cases import cases, table_of
from page_text import visible_text
from palpate.analysis.strategies import command, report_page
from palpate.analysis.strategies.measures import TRAVEL

INPUT_ROUNDING = 5e-13  # the trials of the oracle have 12 digits
# Of a half width of two hands: two roundings each of two strategies, times half of Student's t of 12.7; a
# value may be larger than its mean.
ROUNDINGS = 50
HALF_WIDTHS = {"half_width", "mask_half_width", "a4_half_width"}
# Case, scene, measure and strategy: behind the best one by the same count in each of two or three hands.
EQUAL = {("literature", "lock", "losses of 0.1 s", "a4"), ("two_hands", "", "losses of 0.1 s", "a4")}
NEW_COUNTS = ("beyond_workspace", "largest_travel_m")
NUMBERS = {"minus_mask", "mask_half_width", "minus_a4", "a4_half_width", "mean", "half_width"}


def is_tuned(case):
    return "tuning-plan.json" in case.expected


@pytest.fixture(name="made", scope="module", params=cases("compare", refused=False), ids=lambda c: c.name)
def made_report(request, tmp_path_factory):
    """The case, its report without figures, and the names of its strategies."""
    case, folder = request.param, tmp_path_factory.mktemp("comparison")
    for name in ("plan.json", "trials/trials.csv"):
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_bytes(case.expected[name])
    header, *trials = table_of(case.text("trials/trials.csv"))
    with (folder / "trials/trials.csv").open("w", encoding="utf-8", newline="") as file:
        csv.writer(file).writerows([header + [TRAVEL], *(row + [""] for row in trials)])
    plan = json.loads((folder / "plan.json").read_text())
    words = [str(folder)] + [word for name in case.arguments if name.endswith(".glb")
                             for word in ("--scene", name)]
    if "--operator" in case.arguments:
        words += ["--operator", case.arguments[case.arguments.index("--operator") + 1]]
    if "--json" in case.arguments:
        words.append("--json")
    parser = argparse.ArgumentParser()
    command.add_arguments(parser)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(report_page, "_figures", lambda means: [])
        return case, command.run(parser.parse_args(words)), plan["strategies"]


def untuned(rows, tuned):
    """The rows without what follows from the tuning."""
    kept = []
    for row in rows:
        if tuned and row["strategy"] == "anisotropic":
            continue
        row = {key: value for key, value in row.items() if key != "tuned_to"}
        if tuned and row["strategy"].startswith("anisotropic:"):
            row["role"] = "technique"
        if tuned and "standing" in row:
            row["standing"] = ""
        kept.append(row)
    return kept


def as_now(document, case_name, tuned):
    """The document of the oracle with what changed since."""
    comparable = {(row["following"], row["strategy"]) for row in document["strategies"]
                  if row["done"] * 10 >= row["trials"] * 9}
    ranked = defaultdict(set)
    for row in document["means"]:
        if row["role"] == "technique" and row["hands"] > 0 and (
                row["following"], row["strategy"]) in comparable:
            ranked[row["following"], row["scene"], row["measure"]].add(row["strategy"])
    for row in document["means"]:
        if len(ranked[row["following"], row["scene"], row["measure"]]) == 1:
            row["standing"] = ""
        if (case_name, row["scene"], row["measure"], row["strategy"]) in EQUAL:
            assert row["standing"] == ""
            row["standing"] = "tied"
        for key in HALF_WIDTHS:
            if row[key] is not None and row[key] <= INPUT_ROUNDING * abs(row["mean"]):
                row[key] = None
    document["a4_losses"] = [row for row in document["a4_losses"] if row["half_width"] != 0.0]
    return document


def assert_travel_is_unknown(document):
    """Nothing is said of what was not measured."""
    for row in document["strategies"]:
        assert (row["beyond_workspace"], row["largest_travel_m"]) == (0, None)
    of_travel = [row for row in document["means"] if row["measure"] == "device travel"]
    assert of_travel and all(row["hands"] == 0 and row["standing"] == "" for row in of_travel)


def without_travel(document):
    return {**document,
            "strategies": [{key: row[key] for key in row if key not in NEW_COUNTS}
                           for row in document["strategies"]],
            "means": [row for row in document["means"] if row["measure"] != "device travel"]}


def assert_rows_agree(found, expected, sizes):
    assert len(found) == len(expected)
    for row, other in zip(found, expected):
        assert list(row) == list(other)
        size = sizes[row.get("following"), row.get("scene", ""), row.get("measure")]
        for key, value in other.items():
            if key in NUMBERS and value is not None:
                within = RELATIVE * abs(value) + ROUNDINGS * INPUT_ROUNDING * size
                assert row[key] == pytest.approx(value, rel=0.0, abs=within), (row, key)
            else:
                assert row[key] == value, (row, key)


def test_report_has_the_numbers(made):
    case, report, strategies = made
    tuned = is_tuned(case)
    whole = json.loads(report.files["comparison.json"])
    assert_travel_is_unknown(whole)
    found, expected = without_travel(whole), as_now(case.json("comparison.json"), case.name, tuned)
    tables = ("strategies", "means", "a4_losses")
    assert list(found) == [key for key in expected if key not in ("tuning", "tuning_seed")]
    for key in found:
        if key not in tables and not (tuned and key == "comparable"):
            assert found[key] == expected[key]
    sizes = defaultdict(float)
    for row in expected["means"]:
        key = (row["following"], row["scene"], row["measure"])
        sizes[key] = max(sizes[key], abs(row["mean"] or 0.0), row["half_width"] or 0.0)
    for name in tables:
        of_found = untuned(found[name], tuned)
        if tuned and name == "a4_losses":
            of_found = [row for row in of_found if row["strategy"] in strategies
                        and not row["strategy"].startswith("anisotropic:")]
        assert_rows_agree(of_found, untuned(expected[name], tuned), sizes)
    for file, name in (("comparison.csv", "means"), ("a4_losses.csv", "a4_losses")):
        rows = table_of(report.files[file])
        assert len(rows) == 1 + len(whole[name])
        for row, other in zip(rows[1:], whole[name]):
            assert [cell if isinstance(value, str) else float(cell) if cell else None
                    for cell, value in zip(row, other.values())] == list(other.values())


def plain_lines(text):
    """Lines without the marks of the standings, which test_report_has_the_numbers compares."""
    legend = "* best technique; = tied: the 95 % interval of the paired difference holds 0"
    return [legend if line.startswith(legend) else re.sub(r"(?<=[\d-]) [*=](?= |$)", "  ", line).rstrip()
            for line in text.splitlines()]


NEW_LINES = ("device travel, mm ", "- no value: not ranked", "not compared, because a4 has no value: ")
# One difference of -5 in both hands is no longer a loss.
OF_TWO_HANDS = {"a4 loses (paired difference to a4):", "  to mask: losses of 0.1 s -5.00 +- 0.00",
                "a4 loses by no measure", "  to mask: losses of 0.1 s -5.00 (equal in 2 hands)",
                "undecided, because no spread is measured (paired difference to a4):"}
# The verdict on an a4 that completed too few trials.
OF_SLOW_HANDS = {"a4 loses by no measure", "a4 is not compared: it completed too few trials"}
OTHERS = {"two_hands": OF_TWO_HANDS, "slow_hands": OF_SLOW_HANDS, "very_slow_hands": OF_SLOW_HANDS}
NEW_NOTES = ("Green: the best technique.", "Bold: the interval does not hold 0.", "Techniques are tied if")


def as_equal(lines):
    return {re.sub(r" ± 0(\.0+)?(?![\d.])", " (equal)", line) for line in lines}


def as_it_was(line):
    """The forms that a line of a page may have had: without the travel, without a note on who is ranked,
    and with the best of one."""
    ends = re.sub(r"^((?:\S+)(?: \| [a-z\d]+){4}) \| (?:0|beyond the workspace) \| .*$", r"\1", line)
    return {line, ends, re.sub(r" \(no value: .*\)$", "", line), re.sub(r" \(only .*\)$", "", line),
            re.sub(r"\| - \(only ([^;]*?)(;.*)?\)$", r"| \1", line)}


def test_texts_are_the_same_where_nothing_was_tuned(made):
    case, report, strategies = made
    if is_tuned(case):
        return
    if not any(":" in name for name in strategies):  # such a name has two lines now
        others = OTHERS.get(case.name, set())
        found, expected = ([line for line in plain_lines(text)
                            if not line.startswith(NEW_LINES) and line not in others]
                           for text in (report.text, case.stdout))
        assert found == expected[:len(found)] and len(found) > 10
    found = {old for line in as_equal(visible_text(report.files["report.html"])) for old in as_it_was(line)}
    lost = {line for line in as_equal(visible_text(case.text("report.html"))) - found
            if not line.startswith(NEW_NOTES)}
    if OTHERS.get(case.name) is OF_SLOW_HANDS:
        assert "By no measure." in lost
        lost -= {"By no measure."}
    # What follows from a difference of -5.
    assert lost == ({"losses of 0.1 s | 8.0 ± 25.4 | 13.0 ± 25.4 | 10.0 ± 38.1 =",
                     "losses of 0.1 s | mask (tied: cd)", "to mask: losses of 0.1 s -5.00 (equal)",
                     "Each number is the paired difference to a4 with half of its 95 % interval."}
                    if case.name == "two_hands" else set())
