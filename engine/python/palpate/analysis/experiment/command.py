"""`experiment`: compares trials, of people or simulated, with the paper's results."""

from __future__ import annotations

import argparse

from palpate.analysis.errors import InputError
from palpate.analysis.numbers import csv_text, json_text
from palpate.analysis.report import Report
from palpate.analysis.trials import read_trials

from . import page, questionnaires, tables, text
from .analysis import analyse_trials, check_rows


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--trials", required=True, help="file of trials (trials.csv)")
    parser.add_argument("--limit", type=float, default=120.0, help="time limit of a trial, s")


def run(arguments: argparse.Namespace) -> Report:
    """Writes report.html, analysis.json and a CSV file for each table.

    Raises InputError as read_trials(), check_rows(), analyse_trials() and, if there are
    questionnaires beside the trials, read_questionnaires() do.
    """
    frame = read_trials(arguments.trials)
    try:
        check_rows(frame, arguments.limit)
        analysis = analyse_trials(frame, arguments.limit)
    except InputError as error:
        error.path = error.path or arguments.trials
        raise
    analysis.questionnaires = questionnaires.beside(arguments.trials)
    html, warnings = page.report_page(analysis, arguments.trials, arguments.limit)
    found = tables.tables_of(analysis)
    document = tables.document(analysis, found, arguments.trials, arguments.limit)
    files = {"report.html": html, "analysis.json": json_text(document)}
    for name, table in found.items():
        rows = (row.values() for row in tables.rows_of(table))
        files[f"{name}.csv"] = csv_text(list(table.columns), rows)  # type: ignore[arg-type]
    return Report(files, text.terminal_text(analysis), warnings)
