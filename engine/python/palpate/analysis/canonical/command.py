"""`palpate.analysis canonical FOLDER`: the page of a canonical run."""

from __future__ import annotations

import argparse
import math
import pathlib
from typing import Any

import numpy as np
import pandas as pd

from palpate.analysis import figures, measured, numbers, page
from palpate.analysis.canonical.figures import angle_figure
from palpate.analysis.canonical.means import (
    DECIMALS, LEAST_HALF_WIDTH, MOTIONS, RATIO, SHARE, STILL, TURNING, means_of, ratio_axis,
    read_canonical)
from palpate.analysis.report import Report

_NO_CONTACT = ("no trial touched the wall without a fault and within its ends, so that there is "
               "nothing to draw")
_NO_RATIO = "no trial has a force into the hand, so that there is no ratio"
_NAMES = {RATIO: ("ratio", "Force along over force into"), SHARE: ("share", "Share within 30 deg")}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("folder", type=pathlib.Path, help="folder with canonical.csv and run.json")


def run(arguments: argparse.Namespace) -> Report:
    rows = read_canonical(arguments.folder / "canonical.csv")
    return report(rows, measured.read_run(arguments.folder / "run.json"))


def report(rows: pd.DataFrame, ran: measured.Run) -> Report:
    ratio, share = _section(rows, RATIO), _section(rows, SHARE)
    no_ratio = rows[rows[RATIO].isna() & rows[SHARE].notna()]
    is_across = (no_ratio["angle_deg"] == 90.0) & (no_ratio["rotation"] == STILL)
    text = page.page(
        "canonical.html.j2", title="The canonical wall, with simulated operators", ratio=ratio,
        share=share, is_cut=any(ratio_axis(means_of(rows, RATIO, m)).is_cut for m in MOTIONS),
        is_missing_across=is_across.any(), is_missing_elsewhere=not is_across.all(),
        facts=_facts(rows, ran))
    reasons = [ratio["reason"], share["reason"], *(p["reason"] for p in ratio["panels"]),
               *(p["reason"] for p in share["panels"])]
    return Report({"canonical.html": text}, warnings=list(dict.fromkeys(filter(None, reasons))))


def _section(rows: pd.DataFrame, measure: str) -> dict[str, Any]:
    """What the page shows of a measure. reason: why there is no figure; "": there is one."""
    has_contact = rows[SHARE].notna().any()
    reason = "" if rows[measure].notna().any() else _NO_RATIO if has_contact else _NO_CONTACT
    operators = rows["participant"].nunique()
    return {"reason": reason, "operators": operators,
            "panels": [_panel(rows, measure, motion, has_figure=not reason) for motion in MOTIONS],
            "tables": [(motion.capitalize(), _table(means_of(rows, measure, motion), operators))
                       for motion in MOTIONS]}


def _panel(rows: pd.DataFrame, measure: str, motion: str, *, has_figure: bool) -> dict[str, Any]:
    id_, name = _NAMES[measure]
    means = means_of(rows, measure, motion)
    if not has_figure:
        return {"picture": "", "reason": ""}
    if not means.xs("count", axis=1, level=1).to_numpy().any():
        return {"picture": "", "reason": f"{name}, {motion}: is not drawn: no trial has a value"}
    figure = angle_figure(means, motion, is_ratio=measure == RATIO)
    return {"picture": figures.svg(figure, f"{id_}-{motion}", f"{name}, {motion}"), "reason": ""}


def _cell(means: pd.Series, operators: int) -> tuple[str, str]:
    """A mean with half of its interval; and how many operators have a value, if not all have."""
    count = int(means["count"])
    if count == 0:
        return "-", ""
    text = numbers.with_decimals(means["mean"], DECIMALS)
    if means["half_width"] >= LEAST_HALF_WIDTH:
        text += f" ± {numbers.with_decimals(means['half_width'], DECIMALS)}"
    return text, f"n = {count}" if count < operators else ""


def _table(means: pd.DataFrame, operators: int) -> list[dict[str, Any]]:
    """One row an angle."""
    return [{"angle": f"{angle_deg!r}".removesuffix(".0"),
             "tangent": numbers.with_decimals(math.nan if angle_deg >= 90.0 else
                                              np.tan(np.radians(angle_deg)), DECIMALS),
             "cells": [_cell(row[STILL], operators), _cell(row[TURNING], operators)]}
            for angle_deg, row in means.iterrows()]


def _facts(rows: pd.DataFrame, ran: measured.Run) -> list[tuple[str, str]]:
    without = int(rows[SHARE].isna().sum())
    return [("Plan", ran.plan), ("Seed", str(ran.seed)),
            ("Operators", f"{rows['participant'].nunique()} of {ran.operator}"),
            ("Trials", str(len(rows))),
            ("Trials without a result", "none" if without == 0 else
             f"{without} (no contact, a fault, or a hand beyond an end of the wall)")]
