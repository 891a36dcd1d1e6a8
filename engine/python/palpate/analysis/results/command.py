"""`palpate.analysis results TABLES`: pictures of committed results (benchmarks/update_results.py)."""

from __future__ import annotations

import argparse
import json
import pathlib
from collections.abc import Callable
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from palpate.analysis import tables
from palpate.analysis.errors import InputError
from palpate.analysis.report import Report
from palpate.analysis.results import (
    a4_helps,
    a4_turns,
    accuracy,
    budgets,
    calm_chart,
    groove,
    strategies,
)
from palpate.analysis.results.picture import picture

# Title, and what draws the figure from the content of a table.
FIGURES: dict[str, tuple[str, Callable[[Any], Figure]]] = {
    "accuracy": (accuracy.TITLE, lambda rows: accuracy.draw(pd.DataFrame(rows))),
    "budgets": (budgets.TITLE, lambda rows: budgets.draw(pd.DataFrame(rows))),
    "calm_chart": (calm_chart.TITLE, lambda of: calm_chart.draw(
        pd.DataFrame(of["cases"]), pd.DataFrame(of["zones"]))),
    "a4_helps": (a4_helps.TITLE, lambda of: a4_helps.draw(
        pd.DataFrame(of["shares"]), pd.DataFrame(of["measures"]), of["notes"])),
    "a4_turns": (a4_turns.TITLE, lambda of: a4_turns.draw(of["data"], of["star"])),
    "strategies": (strategies.TITLE, lambda rows: strategies.draw(pd.DataFrame(rows).astype(
        {name: float for name in strategies.NUMBERS}))),
    "groove": (groove.TITLE, lambda of: groove.draw()),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("tables", type=pathlib.Path,
                        help="JSON: for each file to write, the kind of the figure and its table")


def run(arguments: argparse.Namespace) -> Report:
    try:
        wanted = json.loads(tables.read_text(arguments.tables))
        files = {}
        for file, (kind, table) in wanted.items():
            title, draw = FIGURES[kind]
            files[file] = picture(draw(table), title)
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(str(arguments.tables), "", f"is not a file of tables ({error!r})") from error
    return Report(files)
