"""`compare` against what the C++ printed and wrote (oracle/README.md).

The C++ tuned `anisotropic`: for each measure, its column had the E that was best on other hands. Now no
strategy is tuned, so that what follows from the tuning is left out here: the column, its key and table,
the role of a value of E, and the standings beside it.
"""

import argparse
import json
from collections import defaultdict

import pytest

from numbers_agree import RELATIVE
from oracle_cases import cases, table_of
from page_text import visible_text
from palpate.analysis.strategies import command, report_page

INPUT_ROUNDING = 5e-13  # the trials of the oracle have 12 digits
# Of a half width of two hands: two roundings each of two strategies, times half of Student's t of 12.7; a
# value may be larger than its mean.
ROUNDINGS = 50
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
    found, expected = json.loads(report.files["comparison.json"]), case.json("comparison.json")
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
        assert len(rows) == 1 + len(found[name])
        for row, other in zip(rows[1:], found[name]):
            assert [cell if isinstance(value, str) else float(cell) if cell else None
                    for cell, value in zip(row, other.values())] == list(other.values())


def test_texts_are_the_same_where_nothing_was_tuned(made):
    case, report, strategies = made
    if is_tuned(case):
        return
    if not any(":" in name for name in strategies):  # such a name has two lines now
        assert case.stdout.startswith(report.text)
    lost = set(visible_text(case.text("report.html"))) - set(visible_text(report.files["report.html"]))
    # A half width of 24.05 s, which 12 digits round down.
    assert lost == ({"total time, s | -3.0 ± 24.0 | - | -3.2 ± 24.1"} if case.name == "two_hands"
                    else set())
