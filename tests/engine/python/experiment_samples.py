"""Analyses and reports of made rows of trials, for tests."""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import pandas as pd

from palpate.analysis.experiment import command
from palpate.analysis.experiment.analysis import ExperimentAnalysis, OperatorAnalysis, analyse_trials
from palpate.analysis.report import Report
from palpate.analysis.trials import read_trials
from sample_trials import COLUMNS, trials_csv

LIMIT_S = 120.0
ALL_FOLLOWINGS = ("delayed", "predict", "replan", "frozen")
LIVE = ("pilot", "reason")
VARIANT = ("view", "align", "start_orientation_deg", "scale")


def frame_of(rows) -> pd.DataFrame:
    """What read_trials() makes of a file with these rows."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "trials.csv")
        path.write_text(trials_csv(rows, COLUMNS + VARIANT + LIVE))
        return read_trials(path)


def analysed_all(rows) -> ExperimentAnalysis:
    return analyse_trials(frame_of(rows), LIMIT_S)


def analysed(rows) -> OperatorAnalysis:
    return analysed_all(rows).operators[0]


def written(rows, folder: Path, name="trials.csv", limit_s=LIMIT_S, columns=COLUMNS) -> Report:
    """The report of a file with these rows; `name` as the user names it."""
    path = folder / name
    path.write_text(trials_csv(rows, columns + VARIANT + LIVE))
    report = command.run(argparse.Namespace(trials=str(path), limit=limit_s))
    for file, text in report.files.items():
        report.files[file] = text.replace(str(path), name)
    return report


def where(rows, **values):
    """The rows with these values."""
    return [row for row in rows if all(row.get(k) == v for k, v in values.items())]


def without(rows, **values):
    left_out = where(rows, **values)
    return [row for row in rows if not any(row is other for other in left_out)]


def end_as(status, rows):
    """Ends trials so: they have no measure."""
    for row in rows:
        kept = COLUMNS[: COLUMNS.index("status")]
        for column in [c for c in row if c not in kept + VARIANT + LIVE]:
            del row[column]
        row["status"] = status
