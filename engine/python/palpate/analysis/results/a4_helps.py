"""Which assumption decides whether A4 helps: the shares of a sweep, by assumption and measure."""

from __future__ import annotations

from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from palpate.analysis import figures

TITLE = "Which assumption decides whether A4 helps"
SHARE, DECIDES = figures.COLOURS[0], figures.COLOURS[1]
_NARROW_PX = 400  # readable on a phone
_LOOKS: dict[str, dict[str, Any]] = {
    "low half": dict(marker="o", markerfacecolor="none"), "high half": dict(marker="o"),
    "word": dict(marker="|", markersize=10, markeredgewidth=3)}


def draw(shares: pd.DataFrame, measures: pd.DataFrame, notes: list[str]) -> Figure:
    """A panel for each measure, a row for each assumption.

    shares: measure, assumption (its words), part ("low half", "high half" or "word"), share of the
    testable points at which A4 makes the measure smaller, decides (0 or 1). measures: measure, share
    of all points, and low and high end of its 95 % interval (Wilson). notes: lines below.
    """
    assumptions = list(shares["assumption"].unique())
    below = 46 + 13 * len(notes)
    height = below + 62 + 22 * len(assumptions)
    figure, axes = figures.new_figure(_NARROW_PX, height, ncols=len(measures), sharey=True,
                                      squeeze=False)
    for panel, whole in zip(axes[0], measures.itertuples()):
        panel.axvspan(100 * whole.low, 100 * whole.high, color=figures.GRID, alpha=0.25,
                      linewidth=0)
        panel.axvline(100 * whole.share, color=figures.INK, linewidth=0.8, linestyle="--")
        _draw_shares(panel, shares[shares["measure"] == whole.measure], assumptions)
        panel.set_title(whole.measure, loc="left")
        panel.set_xlim(-6, 106)
        panel.set_xticks([0, 50, 100], ["0 %", "", "100 %"])
    axes[0, 0].set_yticks(range(len(assumptions)), assumptions)
    axes[0, 0].set_ylim(len(assumptions) - 0.5, -0.5)
    figure.legend(handles=_legend(), loc="lower left", ncols=2,
                  bbox_to_anchor=(0.0, (below - 40) / height))
    figure.text(0.01, 6 / height, "\n".join(notes), fontsize=9, linespacing=1.3)
    figure.get_layout_engine().set(rect=(0.0, below / height, 1.0, 1.0 - below / height))
    return figure


def _draw_shares(axes: Axes, shares: pd.DataFrame, assumptions: list[str]) -> None:
    for assumption, parts in shares.groupby("assumption", sort=False):
        row = assumptions.index(assumption)
        decides = bool(parts["decides"].iloc[0])
        colour = DECIDES if decides else SHARE
        percent = 100 * parts["share"]
        axes.plot([percent.min(), percent.max()], [row, row], color=colour,
                  linewidth=3 if decides else 1.5, label="_range")
        for part, look in _LOOKS.items():
            of = percent[parts["part"] == part]
            if not of.empty:
                axes.plot(of, [row] * len(of), linestyle="none", color=colour, label=part,
                          **{"markersize": 7, **look})


def _legend() -> list[Line2D]:
    names = {"low half": "low half", "high half": "high half", "word": "one word"}
    lines = [Line2D([], [], linestyle="none", color=SHARE, label=names[part],
                    **{"markersize": 7, **look}) for part, look in _LOOKS.items()]
    return lines + [Line2D([], [], color=DECIDES, linewidth=3, marker="o", markersize=7,
                           label="decides most (p < 0.05)")]
