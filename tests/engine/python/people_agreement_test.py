"""Every test, mean and interval of `experiment analyse` is R's, of 12 made people (r/people.csv): some
trials were aborted, repeated, skipped, timed out, or are not there. r/people.R chose the trials and
wrote r/people.json."""

from __future__ import annotations

import argparse
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
LESS = {"d_z": 1e-4, "d_z_low_95": 1e-4, "d_z_high_95": 1e-4, "sd_participants": 1e-6,
        "sd_participant_condition": 1e-6, "sd_trials": 1e-6, "share_of_participants": 1e-6}


@pytest.fixture(scope="module")
def report() -> Report:
    return command.run(argparse.Namespace(trials=str(HERE / "people.csv"), limit=120.0))


@pytest.fixture(scope="module")
def analysis(report: Report) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(report.files["analysis.json"])
    return found


@pytest.mark.parametrize("table", KEYS)
def test_every_number_is_the_one_of_r(analysis: dict[str, Any], table: str) -> None:
    def by_key(rows: list[dict[str, Any]]) -> dict[tuple[str, ...], dict[str, Any]]:
        return {tuple(row[name] for name in KEYS[table]): row for row in rows}

    found, expected = by_key(analysis[table]), by_key(R[table])
    assert set(found) == set(expected) and len(R[table]) == len(expected)
    for key, row in found.items():
        numbers = {name: value for name, value in row.items() if isinstance(value, (int, float))
                   and not isinstance(value, bool) and not name.startswith(NOT_OF_R)}
        assert set(numbers) <= set(expected[key]), key
        for name in set(expected[key]) - set(KEYS[table]):
            tolerance = LESS.get(name, RELATIVE)
            assert row[name] == pytest.approx(expected[key][name], rel=tolerance,
                                              abs=ROUNDING), (key, name)


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
