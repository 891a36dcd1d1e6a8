"""The page of a comparison of strategies."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pandas as pd
from markupsafe import Markup

from palpate.analysis import figures, numbers, page
from palpate.analysis.strategies.comparison import (
    OTHERS,
    Comparison,
    is_tie_of_all,
    leaders,
    missing_by,
)
from palpate.analysis.strategies.differences_figure import SHOWN, baseline, differences_figure
from palpate.analysis.strategies.measures import BY_COLUMN, BY_NAME, TRAVEL
from palpate.analysis.strategies.names import meaning
from palpate.analysis.strategies.text import (
    SIMULATED_HANDS,
    is_beyond_workspace,
    losses_by_strategy,
    shown_decimals,
    shown_interval,
    shown_mean,
    undecided_by_strategy,
    workspace_lines,
)

_PLUS_MINUS = "\u00b1"
Row = dict[str, Any]  # of Comparison.means
Table = dict[str, Any]  # heads and rows


def comparison_page(settings: dict[str, Any], comparisons: list[Comparison]) -> str:
    """An HTML document that begins with a figure, the best technique by each measure and the
    measures in which A4 loses; then follow what each column is, all means and paired differences,
    each scene, and how to read them."""
    first = comparisons[0]
    facts = [("Scenes", ", ".join(settings["scenes"])),
             ("Hands", f"{settings['hands']} of {settings['operator']}"),
             ("Seed", settings["seed"]),
             *((name, numbers.json_line(value)) for name, value in settings["device"].items())]
    means = first.means[first.means["scene"] == ""]
    return page.page(
        "strategies.html.j2", hands=settings["hands"], facts=facts,
        simulated_hands=SIMULATED_HANDS, incomplete=first.incomplete, other=baseline(means),
        figures=_figures(means), best=_leaders_table(means),
        columns=[(name, meaning(name)) for name in first.strategies["strategy"]],
        has_a4="a4" in set(means["strategy"]),
        losses=losses_by_strategy(first, _PLUS_MINUS), undecided=undecided_by_strategy(first),
        missing=missing_by(first, "a4"), beyond=workspace_lines(first),
        followings=[_following(each) for each in comparisons])


def _figures(means: pd.DataFrame) -> list[Markup]:
    other = baseline(means)
    return [figures.svg(differences_figure(means[means["measure"] == name], other),
                        f"measure-{number}", f"{name} of each strategy")
            for number, name in enumerate(SHOWN)]


def _following(comparison: Comparison) -> dict[str, Any]:
    counts = comparison.strategies
    travel_m, travel = counts["largest_travel_m"], BY_COLUMN[TRAVEL]
    decimals = shown_decimals(travel, travel_m)
    outcomes = counts.drop(columns="role").assign(
        largest_travel_m=[shown_mean(travel, each, decimals) for each in travel_m])
    return {"name": comparison.following, "outcomes": outcomes.to_numpy().tolist(),
            "scenes": [_scene(comparison, scene) for scene in comparison.scenes]}


def _scene(comparison: Comparison, scene: str) -> dict[str, Any]:
    means = comparison.means[comparison.means["scene"] == scene]
    names = set(means["strategy"])
    return {
        "name": scene, "leaders": _leaders_table(means),
        "means": _table(means, "mean", "half_width", "hands",
                        _mean_cell(comparison if not scene else None)),
        "differences": [
            (other, _table(means, f"minus_{other}", f"{other}_half_width", f"{other}_hands",
                           _difference_cell(other)))
            for other in OTHERS if other in names]}


def _leaders_table(means: pd.DataFrame) -> list[tuple[str, str]]:
    return [(BY_NAME[name].heading, leaders(entries))
            for name, entries in means.groupby("measure", sort=False)]


def _table(means: pd.DataFrame, mean: str, half_width: str, hands: str,
           cell: Callable[[str, Row, bool], str]) -> Table:
    """A row for each measure, a column for each strategy. mean, half_width, hands: the columns of
    an interval. cell: what is shown of its text, its row, and whether all techniques are tied."""
    rows = []
    for name, entries in means.groupby("measure", sort=False):
        measure, is_tie = BY_NAME[name], is_tie_of_all(entries)
        decimals = shown_decimals(measure, entries["mean"])
        rows.append([measure.heading, *(
            cell(shown_interval(measure, row[mean], row[half_width], decimals, _PLUS_MINUS,
                                0 if pd.isna(row[hands]) else row[hands]), row, is_tie)
            for row in entries.to_dict("records"))])
    return {"heads": ["measure", *means["strategy"].unique()], "rows": rows}


def _marked(text: str, kind: str) -> Markup:
    return Markup('<strong class="{}">{}</strong>').format(kind, text)


def _mean_cell(comparison: Comparison | None) -> Callable[[str, Row, bool], str]:
    """Of all scenes together, "!" marks a travel beyond the workspace. comparison: None for one
    scene."""

    def cell(text: str, row: Row, is_tie: bool) -> str:
        if row["standing"] == "best" and not is_tie:
            text = _marked(text, "best")
        elif row["standing"] == "tied" and not is_tie:
            text += " ="
        if comparison and is_beyond_workspace(comparison, row["measure"], row["strategy"]):
            text += " !"
        return text

    return cell


def _difference_cell(other: str) -> Callable[[str, Row, bool], str]:
    """Bold if the interval does not hold 0; green if the strategy is better, red if worse."""

    def cell(text: str, row: Row, is_tie: bool) -> str:
        difference = row[f"minus_{other}"]
        if not abs(difference) > row[f"{other}_half_width"]:
            return text
        return _marked(text, "good" if difference < 0.0 else "bad")

    return cell
