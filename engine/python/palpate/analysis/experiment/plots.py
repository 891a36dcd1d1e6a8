"""The figures of the page, after Figures 6 and 7 of the paper. Each is a function of a table of
means of participants (Primary.means)."""

from __future__ import annotations

import textwrap
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from scipy import special

from palpate.analysis.figures import COLOURS, MARKERS, new_figure
from palpate.analysis.numbers import number_or_dash, with_unit

from .experiments import SEEN
from .outcomes import ANGLE, Outcome
from .paper import MEANS

# Pixels. So narrow that the texts stay readable on a phone.
WIDTH, HEIGHT = 390, 340
MOST_LETTERS = 50  # of a line of the title
DODGE, PAPER_DODGE = 0.06, 0.18  # between curves, and of the paper's means, in levels
PAPER_COLOUR = "#7c7c7c"  # a contrast of 4 on white and on dark ground
# The vertical axis begins at 0 if the lowest value is less than this share of the highest one.
NEAR_ZERO = 0.4
MARGIN = 0.1  # of the range of the values, on each side

HAPTIC_TICKS = {"NoH": "NoH\nno force", "UaH": "UaH\nactuated axis", "H": "H\nfull force",
                "seen-UaH": "seen-UaH\nactuated axis", "seen-H": "seen-H\nfull force"}
ROTATION_TEXTS = {"NoR": "the scene stands still", "R": "the scene turns"}


def by_rotation_and_haptic(
    means: pd.DataFrame, outcome: Outcome, levels: dict[str, list[str]], whose: str
) -> Figure:
    """A panel of Figure 6: an outcome at each level of Haptic, one curve for each level of
    Rotation, with 95 % intervals; beside them the paper's means over both rotations, if it has
    them. whose: the trials, for the title."""
    figure, axes = new_figure(WIDTH, HEIGHT)
    draw_by_rotation_and_haptic(axes, means, outcome, levels, whose)
    return figure


def draw_by_rotation_and_haptic(
    axes: Any, means: pd.DataFrame, outcome: Outcome, levels: dict[str, list[str]], whose: str
) -> None:
    """The same into the axes of a figure with several panels."""
    haptic, rotation = levels["Haptic"], levels["Rotation"]
    lows, highs = [], []
    for r, level in enumerate(rotation):
        rows = means[means["Rotation"] == level].set_index("Haptic").reindex(haptic)
        style = 1 if level == "R" else 0
        halves = rows["half_width"].fillna(0.0)
        axes.errorbar(
            [h + DODGE * (2.0 * r - 1.0) for h in range(len(haptic))],
            rows["mean"],
            yerr=halves,
            fmt=f"-{MARKERS[style]}",
            color=COLOURS[style],
            label=f"{level}: {ROTATION_TEXTS[level]}",
        )
        lows.append((rows["mean"] - halves).min())
        highs.append((rows["mean"] + halves).max())
    papers = [(h, MEANS[outcome, level][0]) for h, level in enumerate(haptic)
              if (outcome, level) in MEANS and not set(SEEN) & set(haptic)]  # fmt: skip
    if papers:
        _put_paper(axes, papers, "the paper's people, mean of NoR and R")
        lows.append(min(mean for _, mean in papers))
        highs.append(max(mean for _, mean in papers))
    n = int(means["participants"].iloc[0])
    _frame(axes, [HAPTIC_TICKS[level] for level in haptic], min(lows), max(highs))
    _name(axes, outcome, "commanded force (Haptic)", f"{outcome.name}: {whose}", n)


def angle_by_rotation(means: pd.DataFrame, whose: str, label: str) -> Figure:
    """Figure 7: the mean contact angle of UaH without and with rotation, beside the paper's.
    label: of the points."""
    figure, axes = new_figure(WIDTH, HEIGHT)
    halves = means["half_width"].fillna(0.0)
    places = range(len(means))
    style = {"fmt": f"-{MARKERS[0]}", "color": COLOURS[0], "label": label}
    axes.errorbar(list(places), means["mean"], yerr=halves, **style)
    papers = [MEANS[ANGLE, level] for level in means["Rotation"]]
    _put_paper(
        axes,
        [(place, mean) for place, (mean, _) in zip(places, papers)],
        "the paper's people, standard deviation",
        [sd for _, sd in papers],
    )
    low = min((means["mean"] - halves).min(), min(mean - sd for mean, sd in papers))
    high = max((means["mean"] + halves).max(), max(mean + sd for mean, sd in papers))
    _frame(axes, [f"{r}\n{ROTATION_TEXTS[r]}" for r in means["Rotation"]], low, high)
    n = int(means["participants"].iloc[0])
    _name(axes, ANGLE, "rotation of the scene", f"contact angle in UaH: {whose}", n)
    return figure


def residual_quantiles(residuals: pd.Series[float], outcome: Outcome, whose: str) -> Figure:
    """Residuals against the quantiles of the normal distribution, both in standard deviations: on
    the line if they are normal."""
    figure, axes = new_figure(WIDTH, HEIGHT)
    values = np.sort(residuals.to_numpy()) / residuals.std()
    n = len(values)
    quantiles = special.ndtri((np.arange(n) + 0.5) / n)
    axes.plot(quantiles, values, "o", markersize=3, color=COLOURS[0], label=f"{n} residuals")
    ends = quantiles[[0, -1]]
    axes.plot(ends, ends, "--", color=PAPER_COLOUR, label="normal distribution")
    axes.set_xlabel("normal quantile (standard deviations)")
    axes.set_ylabel("residual (standard deviations)")
    title = f"{outcome.name[0].upper()}{outcome.name[1:]}: {whose}"
    sd = f"{number_or_dash(float(residuals.std()))} {outcome.unit}".rstrip()
    axes.set_title(f"{textwrap.fill(title, MOST_LETTERS)}\nstandard deviation {sd}", loc="left")
    axes.legend(loc="upper left")
    return figure


def _put_paper(
    axes: Any, points: list[tuple[int, float]], label: str, spread: list[float] | None = None
) -> None:
    axes.errorbar(
        [place + PAPER_DODGE for place, _ in points],
        [mean for _, mean in points],
        yerr=spread,
        fmt=MARKERS[3],
        markersize=8,
        markerfacecolor="none",
        color=PAPER_COLOUR,
        label=label,
    )


def _frame(axes: Any, ticks: list[str], low: float, high: float) -> None:
    margin = MARGIN * ((high - low) or max(abs(high), 1.0))
    from_zero = low >= 0.0 and low - margin < NEAR_ZERO * high
    axes.set_ylim(0.0 if from_zero else low - margin, high + margin)
    axes.set_xticks(range(len(ticks)), ticks)
    axes.set_xlim(-0.5, len(ticks) - 0.5)
    axes.grid(False, axis="x")


def _name(axes: Any, outcome: Outcome, across: str, title: str, n: int) -> None:
    axes.set_xlabel(across)
    axes.set_ylabel(with_unit(outcome.name, outcome.unit))
    title = textwrap.fill(title[0].upper() + title[1:], MOST_LETTERS)
    axes.set_title(f"{title}\nn = {n} participants", loc="left")
    axes.legend(loc="upper left", bbox_to_anchor=(-0.05, -0.2), borderaxespad=0.0)
