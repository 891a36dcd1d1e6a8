"""The figure of a comparison: what each strategy differs from one of them, by one measure."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from palpate.analysis import figures
from palpate.analysis.strategies.measures import BY_NAME
from palpate.analysis.strategies.text import shown_decimals, shown_mean

SHOWN = ("contact angle", "penetration", "losses of contact", "port work")  # the measures
BETTER, WORSE, UNDECIDED = figures.COLOURS[2], figures.COLOURS[1], figures.INK
_WIDTH_PX, _ROW_PX, _AROUND_PX = 400, 19, 78


def baseline(means: pd.DataFrame) -> str:
    """The strategy at 0: a4, or else mask; empty if there is neither."""
    return next((other for other in ("a4", "mask") if other in set(means["strategy"])), "")


def _shown(entries: pd.DataFrame, other: str) -> pd.DataFrame:
    """Place and half width of each mark, and its colour by the side of 0 of its interval."""
    if not other:
        return pd.DataFrame({"x": entries["mean"], "half": entries["half_width"],
                             "colour": UNDECIDED})
    x, half = entries[f"minus_{other}"], entries[f"{other}_half_width"]
    colour = np.select([x < -half, x > half], [BETTER, WORSE], UNDECIDED)
    return pd.DataFrame({"x": x.where(entries["strategy"] != other, 0.0), "half": half,
                         "colour": colour})


def differences_figure(entries: pd.DataFrame, other: str) -> Figure:
    """A figure of its own of what draw_differences() draws."""
    figure, axes = figures.new_figure(_WIDTH_PX, _AROUND_PX + _ROW_PX * len(entries))
    draw_differences(axes, entries, other)
    return figure


def draw_differences(axes: Axes, entries: pd.DataFrame, other: str) -> None:
    """The paired differences to `other` by one measure, in its shown unit; without it, the means.

    entries: rows of Comparison.means of one scene and measure. A row has the mean over hands beside
    its name, and half of a 95 % interval on each side of its mark. The mark of a reference is open;
    a strategy without a value has none.
    """
    measure = BY_NAME[entries["measure"].iloc[0]]
    decimals = shown_decimals(measure, entries["mean"])
    marks = _shown(entries, other)
    for row, (mark, role) in enumerate(zip(marks.itertuples(), entries["role"])):
        if np.isnan(mark.x):
            continue
        half = 0.0 if np.isnan(mark.half) else mark.half
        axes.errorbar(mark.x * measure.shown_per_unit, row, xerr=half * measure.shown_per_unit,
                      fmt="o", color=mark.colour, markeredgecolor=mark.colour,
                      markerfacecolor="none" if role == "reference" else mark.colour)
    if other:
        axes.axvline(0.0, color=figures.INK, linewidth=0.8, linestyle="--")
    axes.set_yticks(range(len(entries)), [
        f"{name}\u2003{shown_mean(measure, mean, decimals)}"
        for name, mean in zip(entries["strategy"], entries["mean"])])
    axes.set_ylim(len(entries) - 0.4, -0.6)
    axes.set_title(measure.heading, loc="left")
    unit = f", {measure.shown_unit}" if measure.shown_unit else ""
    axes.set_xlabel((f"difference to {other}" if other else "mean") + unit)
