"""Every test, mean and interval of `experiment analyse` is R's, of 12 made people (r/people.csv): some
trials were aborted, repeated, skipped, timed out, or are not there. r/people.R chose the trials and
wrote r/people.json."""

from __future__ import annotations

import argparse
import csv
import json
from pathlib import Path
from typing import Any

import pytest

from palpate.analysis.experiment import command
from palpate.analysis.report import Report

HERE = Path(__file__).resolve().parent / "r"
R: dict[str, list[dict[str, Any]]] = json.loads((HERE / "people.json").read_text())["tables"]
KEYS = {"effects": ("analysis", "outcome", "effect"),
        "comparisons": ("analysis", "outcome", "family", "pair"),
        "means": ("of", "outcome", "haptic", "rotation", "object"),
        "missing_trials": ("haptic", "rotation", "object"),
        "verdicts": ("finding", "comparison"),
        "variances": ("outcome",),
        "loss_rates": ("factor", "pair")}
# R has no numbers of the paper, and no settings.
NOT_OF_R = ("paper_", "margin", "start_orientation_deg", "scale")
RELATIVE = 1e-8
ROUNDING = 1e-12  # R's end of Wilson's interval of no timeouts, which is 0
# Five digits are kept of the noncentral t; the variances are as good as the optimiser of nlme.
# Tables with numbers that R does not compute here: sentences about the tests above, and the ratings of
# questionnaires_test.py.
OTHER_TABLES = {"operators", "findings", "differences", "ratings", "rating_tests"}
LESS = {"d_z": 1e-4, "d_z_low_95": 1e-4, "d_z_high_95": 1e-4, "sd_participants": 1e-6,
        "sd_participant_condition": 1e-6, "sd_trials": 1e-6, "share_of_participants": 1e-6}


@pytest.fixture(scope="module")
def report() -> Report:
    return command.run(argparse.Namespace(trials=str(HERE / "people.csv"), limit=120.0))


@pytest.fixture(scope="module")
def analysis(report: Report) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(report.files["analysis.json"])
    return found


def assert_as_r(analysis: dict[str, Any], table: str) -> None:
    def by_key(rows: list[dict[str, Any]]) -> dict[tuple[str, ...], dict[str, Any]]:
        return {tuple(row[name] for name in KEYS[table]): row for row in rows}

    found, expected = by_key(analysis[table]), by_key(R[table])
    assert set(found) == set(expected)
    assert len(R[table]) == len(expected) == len(analysis[table]) == len(found)
    for key, row in found.items():
        numbers = {name: value for name, value in row.items() if isinstance(value, (int, float))
                   and not isinstance(value, bool) and not name.startswith(NOT_OF_R)}
        assert set(numbers) <= set(expected[key]), key
        for name in set(expected[key]) - set(KEYS[table]):
            tolerance = LESS.get(name, RELATIVE)
            assert row[name] == pytest.approx(expected[key][name], rel=tolerance,
                                              abs=ROUNDING), (key, name)


@pytest.mark.parametrize("table", KEYS)
def test_every_number_is_the_one_of_r(analysis: dict[str, Any], table: str) -> None:
    assert_as_r(analysis, table)


def test_no_table_is_left_out(analysis: dict[str, Any]) -> None:
    tables = {name for name, value in analysis.items() if isinstance(value, list)}
    assert tables == set(KEYS) | OTHER_TABLES and set(R) == set(KEYS)
    assert {row["p"] is None for name in ("effects", "comparisons") for row in analysis[name]} == {False}


def test_cut_attempts_before_and_the_order_of_rows_change_no_number(tmp_path: Path) -> None:
    """A trial that nobody completed has an aborted attempt before, with measures; and the rows stand in
    reverse. The attempts are told by their numbers, and what was measured of a cut one counts nowhere."""
    with open(HERE / "people.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    place = ("participant", "block", "haptic", "rotation", "object", "pilot")
    done = {tuple(row[name] for name in place) for row in rows if row["status"] == "done"}
    never = [row for row in rows if tuple(row[name] for name in place) not in done]
    assert len(never) == 8 and {row["status"] for row in never} == {
        "timeout", "fault", "aborted", "skipped"}
    measures = {"total_time_s": "1", "losses_of_contact": "500", "mean_penetration_dm": "0.9",
                "mean_contact_angle_deg": "89"}
    before = [row | measures | {"status": "aborted", "reason": "lift"} for row in never]
    for row in never:
        row["attempt"] = "2"
    with open(tmp_path / "trials.csv", "w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(reversed(before + rows))
    report = command.run(argparse.Namespace(trials=str(tmp_path / "trials.csv"), limit=120.0))
    analysis = json.loads(report.files["analysis.json"])
    for table in KEYS:
        assert_as_r(analysis, table)
    [operator] = analysis["operators"]
    assert operator["repeated"]["lift"] == 8


def test_r_and_the_analysis_have_many_numbers() -> None:
    count = sum(len(row) - len(KEYS[table]) for table, rows in R.items() for row in rows)
    assert len(R["effects"]) == 60 + 6 * 15 + 7 and count > 1500


def test_the_trials_were_cut_in_every_way(analysis: dict[str, Any], report: Report) -> None:
    everything = analysis["missing_trials"][0]
    assert {name: everything[name] for name in ("done", "timeouts", "faults", "absent", "aborted",
                                                "skipped")} == {
        "done": 278, "timeouts": 4, "faults": 1, "absent": 2, "aborted": 1, "skipped": 2}
    assert everything["reasons"] == "aborted: server 1; skipped: experimenter 1, participant 1"
    [operator] = analysis["operators"]
    assert sum(operator["repeated"].values()) == 33
    assert operator["repeated"]["done"] == 3  # done, and once more
    assert analysis["pilot_rows"] == 12
    assert {row["participants"] for row in analysis["effects"]} == {None, 11, 9, 8, 6, 5}
    lines = report.text.splitlines()
    assert lines[0] == (
        "284 trials of 12 people; missing: 10 (4 timeouts, 1 fault, 2 absent, 1 aborted, 2 skipped)"
        "; repeated: 33 (late_frames 5, pointer_lock 5, hidden 4, done 3, focus 3, full_screen 3, "
        "late_ticks 3, server 3, trip 3, experimenter 1)")
    assert lines[1] == "12 rows of a pilot run: left out"


def test_the_page_says_what_was_cut_and_repeated(report: Report) -> None:
    page = report.files["report.html"]
    for sentence in ("timeouts: 4, faults: 1, absent: 2, aborted: 1, skipped: 2.",
                     "other attempts: 33 (late_frames 5, pointer_lock 5, hidden 4,",
                     ">2 (experimenter 1, participant 1)</td>", "12 rows are left out",
                     "aborted trials were cut and not completed later; skipped trials were left out"):
        assert sentence in page, sentence
