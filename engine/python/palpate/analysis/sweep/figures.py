"""The figures of a sweep."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from palpate.analysis import figures
from palpate.analysis.sweep import points
from palpate.analysis.sweep.findings import Rows
from palpate.analysis.sweep.points import MEASURES, Measure, Parameter

# Flips by the place of the level after them: number, and whether the flip is clear.
Marks = dict[int, list[tuple[int, bool]]]
_BETWEEN = 0.05  # between conditions, in levels
_MARGIN = 0.08  # of the vertical range
_WIDTH_PX, _HEIGHT_PX = 350, 700  # so narrow that texts are readable on a phone


def axis_figure(levels: pd.DataFrame, flips: Rows, parameter: Parameter, base: int) -> Figure:
    """One parameter alone: a panel for each measure, below each other.

    levels: rows of the table one_at_a_time of this parameter, by ascending level. flips: those of
    the table flips; a flip is marked with its place in this list, counted from 1. base: the number
    of the base plan's point.

    A panel has the means of the six conditions at each level, with their standard deviations over
    participants, and a vertical line where a ranking of this measure flips: solid if the flip is
    clear, otherwise dashed, with its number in parentheses. A level at which trials are missing is
    shaded, and its tick says how many were done.
    """
    figure, axes = figures.new_figure(_WIDTH_PX, _HEIGHT_PX, nrows=len(MEASURES), sharex=True)
    of_level = levels.drop_duplicates("point").reset_index(drop=True)
    for ax, measure in zip(axes, MEASURES):
        lacks = of_level.index[of_level["done_of_point"] < of_level["trials_of_point"]]
        for place in lacks:
            ax.axvspan(place - 0.5, place + 0.5, color=figures.GRID,
                       alpha=figures.GRID_ALPHA, linewidth=0)
        _draw_means(ax, levels[levels["measure"] == measure.column], list(of_level["point"]))
        _draw_flips(ax, _marks(flips, list(of_level["level"]), measure))
        ax.set_ylabel(measure.title)
        ax.grid(visible=False, axis="x")
    ticks = [_tick(of, parameter, base) for _, of in of_level.iterrows()]
    axes[-1].set_xticks(of_level.index, ticks)
    axes[-1].set_xlim(-0.5, len(of_level) - 0.5)
    axes[-1].set_xlabel(parameter.title)
    axes[0].legend(loc="lower center", bbox_to_anchor=(0.45, 1.09), ncol=3)
    figure.align_ylabels(axes)
    return figure


def _tick(of_level: Any, parameter: Parameter, base: int) -> str:
    level, trials, done = (of_level[key] for key in ("level", "trials_of_point", "done_of_point"))
    lines = [level if isinstance(level, str) else parameter.text(level)]
    lines += ["(base)"] * (of_level["point"] == base)
    lines += [f"{done}/{trials}"] * (done < trials)
    return "\n".join(lines)


def _draw_means(ax: Any, of_measure: pd.DataFrame, order: Sequence[int]) -> None:
    """The colour says the force; open points and a dashed line are without rotation."""
    low, high = np.inf, -np.inf
    for c, (haptic, rotation) in enumerate(points.CELLS):
        is_here = (of_measure["haptic"] == haptic) & (of_measure["rotation"] == rotation)
        of = of_measure[is_here].set_index("point").loc[list(order)]
        x = np.arange(len(of)) + _BETWEEN * (c - 0.5 * (len(points.CELLS) - 1))
        number = points.HAPTICS.index(haptic)
        colour, is_still = figures.COLOURS[number], rotation == "NoR"
        if (spread := of["sd"].notna().to_numpy()).any():
            ax.errorbar(x[spread], of["mean"][spread], of["sd"][spread], fmt="none", ecolor=colour,
                        elinewidth=1, alpha=0.5)
        there = of["mean"].notna().to_numpy()
        ax.plot(x[there], of["mean"][there], color=colour, marker=figures.MARKERS[number],
                linestyle="--" if is_still else "-", markerfacecolor="none" if is_still else colour,
                label=f"{haptic}, {rotation}")
        reach = of["sd"].fillna(0.0)
        low, high = min(low, (of["mean"] - reach).min()), max(high, (of["mean"] + reach).max())
    if np.isfinite([low, high]).all():
        margin = _MARGIN * (high - low if high > low else max(high, 1.0))
        ax.set_ylim(max(0.0, low - margin) if low >= 0.0 else low - margin, high + margin)


def _marks(flips: Rows, levels: list[str | float], measure: Measure) -> Marks:
    marks: Marks = {}
    for number, flip in enumerate(flips, 1):
        if flip["ranking"].startswith(measure.name + ","):
            marks.setdefault(levels.index(flip["to"]), []).append((number, bool(flip["is_clear"])))
    return marks


def _draw_flips(ax: Any, marks: Marks) -> None:
    for place, flips in marks.items():
        label = ", ".join(str(n) if is_clear else f"({n})" for n, is_clear in flips)
        is_clear = any(clear for _, clear in flips)
        ax.axvline(place - 0.5, color=figures.INK, linewidth=1.2,
                   linestyle="-" if is_clear else "--")
        ax.text(place - 0.5, 1.01, label, transform=ax.get_xaxis_transform(), ha="center")
