"""`palpate.analysis strategies FOLDER`: the page of a comparison of strategies."""

from __future__ import annotations

import argparse
import json
import pathlib
from typing import Any

import pandas as pd

from palpate.analysis import numbers, tables
from palpate.analysis.errors import InputError
from palpate.analysis.report import Report
from palpate.analysis.strategies.comparison import Comparison, compare
from palpate.analysis.strategies.measures import TRAVEL
from palpate.analysis.strategies.report_page import comparison_page
from palpate.analysis.strategies.text import SIMULATED_HANDS, comparison_text
from palpate.analysis.trials import read_trials

_LOSSES = {"following": "following", "measure": "measure", "unit": "unit", "strategy": "strategy",
           "role": "role", "minus_a4": "minus_a4", "a4_half_width": "half_width"}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("folder", type=pathlib.Path, help="the folder of a comparison")
    parser.add_argument("--scene", action="append", help="a scene, as the user named it")
    parser.add_argument("--operator", help="the operator, as the user named it")
    parser.add_argument("--json", action="store_true", help="print comparison.json")


def run(arguments: argparse.Namespace) -> Report:
    """Read FOLDER/plan.json and FOLDER/trials/trials.csv."""
    folder: pathlib.Path = arguments.folder
    plan = _plan(folder / "plan.json")
    path = folder / "trials" / "trials.csv"
    trials = read_trials(path)
    if TRAVEL not in trials:
        raise InputError(str(path), f"line 1, column {TRAVEL}", "is missing; expected this column",
                         "run palpate compare again")
    comparisons = [compare(trials, plan["strategies"], sorted(plan["objects"]), following,
                           plan["device"]["workspace_m"])
                   for following in plan["followings"]]
    settings = {
        "scenes": arguments.scene or [each["file"] for each in plan["objects"].values()],
        "operator": arguments.operator or plan["operator"], "hands": plan["participants"],
        "seed": plan["seed"], "device": plan["device"]}
    return _report(settings, comparisons, arguments.json)


def _plan(path: pathlib.Path) -> dict[str, Any]:
    try:
        plan: dict[str, Any] = json.loads(tables.read_text(path))
        for key in ("strategies", "objects", "followings", "operator", "participants", "seed",
                    "device"):
            plan[key]
        plan["device"]["workspace_m"] + 0.0
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(str(path), "", f"is not a plan of palpate compare ({error!r})",
                         "run palpate compare again") from error
    return plan


def _report(settings: dict[str, Any], comparisons: list[Comparison], as_json: bool) -> Report:
    every = {
        "strategies": _joined(comparisons, [each.strategies for each in comparisons]),
        "means": _joined(comparisons, [each.means for each in comparisons]),
        "a4_losses": _joined(comparisons, [each.a4_losses for each in comparisons])[
            list(_LOSSES)].rename(columns=_LOSSES)}
    document = numbers.json_text({
        "palpate_comparison": 1, **settings,
        "comparable": {each.following: not each.incomplete for each in comparisons},
        **{name: _rows(table) for name, table in every.items()}})
    files = {"report.html": comparison_page(settings, comparisons), "comparison.json": document}
    for file, name in (("comparison.csv", "means"), ("a4_losses.csv", "a4_losses")):
        table = every[name]
        files[file] = numbers.csv_text(list(table), (list(row.values()) for row in _rows(table)))
    return Report(files, document if as_json else _text(settings, comparisons))


def _joined(comparisons: list[Comparison], of_each: list[pd.DataFrame]) -> pd.DataFrame:
    parts = [table.assign(following=each.following) for each, table in zip(comparisons, of_each)]
    table = pd.concat(parts, ignore_index=True)
    return table[["following", *(name for name in table if name != "following")]]


def _rows(table: pd.DataFrame) -> list[dict[str, Any]]:
    return [dict(zip(table, (None if pd.isna(cell) else cell for cell in row)))
            for row in table.itertuples(index=False)]


def _text(settings: dict[str, Any], comparisons: list[Comparison]) -> str:
    first = comparisons[0]
    text = (f"{', '.join(settings['scenes'])}: {first.strategies['trials'].sum()} trials of "
            f"{first.hands} hands of {settings['operator']}, seed {settings['seed']}\n")
    for each in comparisons:
        text += f"\nfollowing {each.following}\n" * (len(comparisons) > 1) + comparison_text(each)
    return text + SIMULATED_HANDS + "\n"
