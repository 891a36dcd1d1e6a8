"""Numbers and sentences about a comparison of strategies, for readers."""

from __future__ import annotations

import numpy as np
import pandas as pd

from palpate.analysis import numbers
from palpate.analysis.strategies.comparison import Comparison, is_tie_of_all, missing_by
from palpate.analysis.strategies.measures import BY_NAME, TRAVEL, Measure

NOT_JUDGED = "a4 is not compared: it completed too few trials"
SIMULATED_HANDS = ("The hands are simulated: the intervals speak of seeds and of the ranges in the "
                   "operator file, not of people.")
_HEADING_COLUMNS = 26
_LEAST_COLUMNS = 9


def _digits_after_point(largest: float) -> int:
    """Three digits."""
    return int(np.clip(2 - np.floor(np.log10(largest)), 0, 4)) if largest > 0.0 else 0


def shown_decimals(measure: Measure, means: "pd.Series[float]") -> int:
    """How many decimals show the means of a measure with three digits."""
    return _digits_after_point(float(means.abs().max()) * measure.shown_per_unit)


def shown_mean(measure: Measure, mean: float, decimals: int) -> str:
    """In the shown unit: "12.3"; "-" without a value."""
    text = numbers.with_decimals(mean * measure.shown_per_unit, decimals)
    return text if len(text) == 1 or text.strip("-0.") else text.lstrip("-")


def shown_interval(measure: Measure, mean: float, half_width: float, decimals: int,
                   plus_minus: str, hands: int) -> str:
    """"-1.23 ± 0.45"; "0.00 (equal)" of hands with the same value; the mean alone of one hand."""
    text = shown_mean(measure, mean, decimals)
    if np.isnan(half_width):
        return text + " (equal)" * (hands > 1)
    half = numbers.with_decimals(half_width * measure.shown_per_unit, decimals)
    return f"{text} {plus_minus} {half}"


def losses_by_strategy(comparison: Comparison,
                       plus_minus: str) -> list[tuple[str, str, list[str]]]:
    """The strategies to which a4 loses, with a note and their measures: "full", " (a reference)",
    then "port work -52.1 ± 3.2 mJ"."""
    return _by_strategy(comparison.a4_losses, comparison, plus_minus)


def undecided_by_strategy(comparison: Comparison) -> list[tuple[str, str, list[str]]]:
    """The same of better values without an interval: "losses of 0.1 s -5.00 (equal in 2 hands)"."""
    return _by_strategy(comparison.a4_undecided, comparison, "")


def _by_strategy(rows: pd.DataFrame, comparison: Comparison,
                 plus_minus: str) -> list[tuple[str, str, list[str]]]:
    texts: dict[tuple[str, str], list[str]] = {}
    for name in comparison.means["strategy"].unique():
        for row in rows[rows["strategy"] == name].itertuples():
            measure = BY_NAME[row.measure]
            decimals = _digits_after_point(abs(row.minus_a4) * measure.shown_per_unit)
            text = shown_interval(measure, row.minus_a4, row.a4_half_width, decimals, plus_minus, 0)
            text = f"{measure.name} {text} {measure.shown_unit}".rstrip()
            if np.isnan(row.a4_half_width):
                hands = row.a4_hands
                text += " (1 hand)" if hands == 1 else f" (equal in {hands} hands)"
            to = (name, " (a reference)" if row.role == "reference" else "")
            texts.setdefault(to, []).append(text)
    return [(name, note, measures) for (name, note), measures in texts.items()]


def workspace_lines(comparison: Comparison) -> list[str]:
    """A line for each strategy that left the workspace, as in engine/trials/compare."""
    lines, workspace_mm = [], 1e3 * comparison.workspace_m
    for row in comparison.strategies.itertuples():
        if row.beyond_workspace == 0:
            continue
        beyond_mm = 1e3 * (row.largest_travel_m - comparison.workspace_m)
        by = numbers.with_decimals(beyond_mm, _digits_after_point(beyond_mm))
        lines.append(f"beyond the workspace of {workspace_mm:g} mm: {row.strategy} in "
                     f"{row.beyond_workspace} of {row.trials} trials, by up to {by} mm")
    return lines


def is_beyond_workspace(comparison: Comparison, measure: str, strategy: str) -> bool:
    """Whether this is the travel of a strategy that left the workspace."""
    counts = comparison.strategies
    beyond = counts.loc[counts["beyond_workspace"] > 0, "strategy"]
    return BY_NAME[measure].column == TRAVEL and strategy in set(beyond)


def incomplete_lines(comparison: Comparison) -> list[str]:
    counts = comparison.strategies.set_index("strategy")
    return [f"not comparable: {counts.at[name, 'done']} of {counts.at[name, 'trials']} trials of "
            f"{name} ended at the red sphere; expected 90 %" for name in comparison.incomplete]


def _means_lines(comparison: Comparison) -> list[str]:
    means = comparison.means[comparison.means["scene"] == ""]
    names = means["strategy"].unique()
    heads = [(name, colon + setting) for name, colon, setting in
             (name.partition(":") for name in names)]  # ":0.25" is on a line of its own
    widths = [max(_LEAST_COLUMNS, *(len(part) + 2 for part in head)) for head in heads]
    lines = [title.ljust(_HEADING_COLUMNS)
             + "".join(part.rjust(width) + "  " for part, width in zip(parts, widths))
             for title, parts in zip((f"mean over {comparison.hands} hands", ""), zip(*heads))
             if any(parts)]
    for name, entries in means.groupby("measure", sort=False):
        measure = BY_NAME[name]
        decimals = shown_decimals(measure, entries["mean"])
        marks = {"": "  "} if is_tie_of_all(entries) else {"best": " *", "tied": " ="}
        line = measure.heading.ljust(_HEADING_COLUMNS)
        for row, width in zip(entries.itertuples(), widths):
            mark = marks.get(row.standing, "  ")
            if is_beyond_workspace(comparison, name, row.strategy):
                mark = (mark.strip() + "!").rjust(2)
            line += shown_mean(measure, row.mean, decimals).rjust(width) + mark
        lines.append(line)
    return [line.rstrip() for line in lines]


def comparison_text(comparison: Comparison) -> str:
    """For a terminal: the means of all scenes together, the leaders, where a4 loses, and strategies
    whose trials are not comparable."""
    lines = _means_lines(comparison)
    lines.append("* best technique; = tied: the 95 % interval of the paired difference holds 0, or "
                 "there is none")
    lines.append("- no value: not ranked")
    lines += [f"! {line}" for line in workspace_lines(comparison)]
    if "a4" in comparison.incomplete:
        lines.append(NOT_JUDGED)
    elif "a4" in set(comparison.means["strategy"]):
        losses = losses_by_strategy(comparison, "+-")
        lines.append("a4 loses (paired difference to a4):" if losses else "a4 loses by no measure")
        lines += [f"  to {name}{note}: {', '.join(measures)}" for name, note, measures in losses]
        undecided = undecided_by_strategy(comparison)
        lines += ["undecided, because no spread is measured (paired difference to a4):"] * bool(
            undecided)
        lines += [f"  to {name}{note}: {', '.join(measures)}" for name, note, measures in undecided]
        missing = missing_by(comparison, "a4")
        lines += [f"not compared, because a4 has no value: {', '.join(missing)}"] * bool(missing)
    return "\n".join(lines + incomplete_lines(comparison)) + "\n"
