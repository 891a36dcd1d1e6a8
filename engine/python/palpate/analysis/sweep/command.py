"""`palpate.analysis sweep FOLDER`: the page and the tables of a sweep."""

from __future__ import annotations

import argparse
import pathlib
from typing import Any

import pandas as pd

from palpate.analysis import figures, measured, numbers, page
from palpate.analysis.report import Report
from palpate.analysis.sweep import findings, points, texts
from palpate.analysis.sweep.figures import axis_figure
from palpate.analysis.sweep.findings import Findings
from palpate.analysis.sweep.points import Parameter, Sweep
from palpate.analysis.sweep.rankings import RANKINGS


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("folder", type=pathlib.Path, help="folder with sweep.csv and run.json")


def run(arguments: argparse.Namespace) -> Report:
    sweep = points.read_sweep(arguments.folder / "sweep.csv")
    ran = measured.read_run(arguments.folder / "run.json")
    return report(sweep, ran)


def report(sweep: Sweep, ran: measured.Run) -> Report:
    found = findings.findings_of(sweep)
    tables = found.tables()
    files = {"report.html": _page(sweep, found, ran),
             "sweep_results.json": numbers.json_text(
                 {"palpate_sweep_results": 1, "name": ran.plan, **tables})}
    for name, rows in tables.items():
        cells = (list(row.values()) for row in rows)
        files[f"{name}.csv"] = numbers.csv_text(findings.COLUMNS[name], cells)
    return Report(files, texts.terminal(sweep, found))


def _page(sweep: Sweep, found: Findings, ran: measured.Run) -> str:
    rankings = [{"ranking": ranking, "share": texts.share(row),
                 "decisive": texts.decisive(found, row, sweep.parameters),
                 "parts": [(p.label, texts.parts_by(found, ranking.name, p.name),
                            p.name in row["decisive_parameters"].split()) for p in sweep.varied]}
                for ranking, row in zip(RANKINGS, found.rankings)]
    blocks = sweep.points["block"].value_counts()
    return page.page(
        "sweep.html.j2", title=f"Which assumptions about the hand decide: {ran.plan}",
        construction=texts.construction(found, sweep), chance=texts.CHANCE, persons=texts.persons(sweep), shares=texts.SHARES,
        points=blocks["hypercube"], rankings=rankings, flips=texts.flips(found.flips),
        axes=[_axis(sweep, found, parameter) for parameter in sweep.varied],
        facts=_facts(sweep, ran, blocks))


def _axis(sweep: Sweep, found: Findings, parameter: Parameter) -> dict[str, Any]:
    levels = pd.DataFrame([r for r in found.one_at_a_time if r["parameter"] == parameter.name])
    flips = [row for row in found.flips if row["parameter"] == parameter.name]
    base = int((sweep.points["block"] == "base").idxmax())
    figure = axis_figure(levels, flips, parameter, base)
    title = f"The measures of the six conditions by {parameter.name}"
    return {"name": parameter.name, "label": parameter.label,
            "picture": figures.svg(figure, parameter.name.replace("_", "-"), title),
            "missing": texts.missing(sweep, parameter), "n": texts.participants(levels),
            "count": texts.flips(flips),
            "flips": [(texts.flip(row, parameter), row["is_clear"]) for row in flips]}


def _facts(sweep: Sweep, ran: measured.Run, blocks: Any) -> list[tuple[str, str]]:
    counts = points.counts(sweep.rows)
    return [("Sweep", ran.plan),
            ("Points", f"{blocks.get('base', 0)} base, {blocks.get('one_at_a_time', 0)} one at a "
                       f"time, {blocks['hypercube']} of the hypercube"),
            ("Trials", f"{counts['trials']}, of which {counts['done']} ended at the red sphere"),
            ("Operator", f"{ran.operator}, version {ran.operator_version}"),
            ("Palpate", ran.version),
            *((f"Drawn {p.name}", texts.drawn(sweep, p)) for p in sweep.varied)]
