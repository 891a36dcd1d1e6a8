"""The page of a comparison of strategies."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pandas as pd
from markupsafe import Markup

from palpate.analysis import numbers, page
from palpate.analysis.strategies.comparison import Comparison, is_tie_of_all, leaders
from palpate.analysis.strategies.measures import BY_NAME
from palpate.analysis.strategies.text import (
    SIMULATED_HANDS,
    losses_by_strategy,
    shown_decimals,
    shown_interval,
)

_PLUS_MINUS = "\u00b1"
Row = dict[str, Any]  # of Comparison.means or .tuning
Table = dict[str, Any]  # heads and rows


def comparison_page(settings: dict[str, Any], comparisons: list[Comparison]) -> str:
    """An HTML document that begins with the best technique by each measure and with the measures in
    which A4 loses; then follow all means and paired differences, the tuning, each scene, and how to
    read them."""
    first = comparisons[0]
    facts = [("Scenes", ", ".join(settings["scenes"])),
             ("Hands", f"{settings['hands']} of {settings['operator']}"),
             ("Seed", settings["seed"]),
             ("Seed of the tuning", settings.get("tuning_seed", "")),
             *((name, numbers.json_line(value)) for name, value in settings["device"].items())]
    return page.page(
        "strategies.html.j2", hands=settings["hands"], facts=facts,
        simulated_hands=SIMULATED_HANDS, incomplete=first.incomplete,
        best=_leaders_table(first.means[first.means["scene"] == ""]),
        has_a4="a4" in set(first.means["strategy"]),
        losses=losses_by_strategy(first, _PLUS_MINUS),
        followings=[_following(each) for each in comparisons])


def _following(comparison: Comparison) -> dict[str, Any]:
    outcomes = comparison.strategies.drop(columns="role")
    return {"name": comparison.following, "outcomes": outcomes.to_numpy().tolist(),
            "scenes": [_scene(comparison, scene) for scene in comparison.scenes]}


def _scene(comparison: Comparison, scene: str) -> dict[str, Any]:
    means = comparison.means[comparison.means["scene"] == scene]
    names = set(means["strategy"])
    tuning = comparison.tuning[comparison.tuning["scene"] == scene]
    return {
        "name": scene, "leaders": _leaders_table(means),
        "means": _table(means, "mean", "half_width", _mean_cell),
        "differences": [
            (other, _table(means, f"minus_{other}", f"{other}_half_width", _difference_cell(other)))
            for other in ("mask", "a4") if other in names],
        "tuning": None if tuning.empty else _table(
            tuning.assign(role="level", standing=""), "mean", "half_width", _tuning_cell)}


def _leaders_table(means: pd.DataFrame) -> list[tuple[str, str]]:
    return [(BY_NAME[name].heading, leaders(entries))
            for name, entries in means.groupby("measure", sort=False)]


def _level_head(strategy: str) -> str:
    return "E = " + strategy.partition(":")[2]


def _table(means: pd.DataFrame, mean: str, half_width: str,
           cell: Callable[[str, Row, bool], str]) -> Table:
    """A row for each measure, a column for each strategy. mean, half_width: the columns of an
    interval. cell: what is shown of its text, its row, and whether all techniques are tied."""
    strategies = means.drop_duplicates("strategy")
    heads = [_level_head(row.strategy) if row.role == "level" else row.strategy
             for row in strategies.itertuples()]
    rows = []
    for name, entries in means.groupby("measure", sort=False):
        measure, is_tie = BY_NAME[name], is_tie_of_all(entries)
        decimals = shown_decimals(measure, entries["mean"])
        rows.append([measure.heading, *(
            cell(shown_interval(measure, row[mean], row[half_width], decimals, _PLUS_MINUS), row,
                 is_tie) for row in entries.to_dict("records"))])
    return {"heads": ["measure", *heads], "rows": rows}


def _marked(text: str, kind: str) -> Markup:
    return Markup('<strong class="{}">{}</strong>').format(kind, text)


def _mean_cell(text: str, row: Row, is_tie: bool) -> str:
    if row["standing"] == "best" and not is_tie:
        text = _marked(text, "best")
    elif row["standing"] == "tied" and not is_tie:
        text += " ="
    if row["tuned_to"]:
        text += Markup('<span class="spread"><br>{}</span>').format(_level_head(row["tuned_to"]))
    return text


def _difference_cell(other: str) -> Callable[[str, Row, bool], str]:
    """Bold if the interval does not hold 0; green if the strategy is better, red if worse."""

    def cell(text: str, row: Row, is_tie: bool) -> str:
        difference = row[f"minus_{other}"]
        if not abs(difference) > row[f"{other}_half_width"]:
            return text
        return _marked(text, "good" if difference < 0.0 else "bad")

    return cell


def _tuning_cell(text: str, row: Row, is_tie: bool) -> str:
    return _marked(text, "best") if row["chosen"] else text
