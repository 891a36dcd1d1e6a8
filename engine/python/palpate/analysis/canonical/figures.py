"""The figures of the canonical protocol: a measure over the angle of the wall."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from palpate.analysis import figures
from palpate.analysis.canonical.means import (
    ABOVE_HIGHEST, LEAST_HALF_WIDTH, STILL, TURNING, ratio_axis)

_WIDTH_PX, _HEIGHT_PX = 340, 330  # so narrow that texts are readable on a phone
_BESIDE_ANGLES_DEG = 4.0
# The whiskers stand this far beside their point, of NoR on its left and of R on its right: behind
# the point they would be hidden.
_WHISKERS_BESIDE_DEG = 2.0


def angle_figure(means: pd.DataFrame, motion: str, is_ratio: bool) -> Figure:
    """A measure for one motion, without and with rotation, over the angle.

    means: as means_of() returns them. Whiskers are 95 % intervals of the mean over participants.
    They are cut at 0, and those of the share at 1: an interval within the possible means covers as
    often as the whole one. The ratio has the curve tan a beside them, and its axis is that of
    ratio_axis().
    """
    figure, ax = figures.new_figure(_WIDTH_PX, _HEIGHT_PX)
    top = ratio_axis(means).top if is_ratio else 1.0 + ABOVE_HIGHEST
    if is_ratio:
        angles_deg = np.linspace(0.0, np.degrees(np.arctan(top)), 181)
        ax.plot(angles_deg, np.tan(np.radians(angles_deg)), color=figures.INK, alpha=0.6,
                linestyle="--", label="tan a: the motor alone, wall at rest")
    most = np.inf if is_ratio else 1.0
    _draw(ax, means[STILL], top, most, "NoR: the wall stands still", 0)
    _draw(ax, means[TURNING], top, most, "R: A4 turns the wall", 1)
    ax.set_title(f"{motion.capitalize()}: simulated operators")
    ax.set_xlim(-_BESIDE_ANGLES_DEG, 90.0 + _BESIDE_ANGLES_DEG)
    ax.set_ylim(0.0, top)
    ax.set_xticks(range(0, 91, 15))
    ax.grid(visible=False, axis="x")
    ax.set_xlabel("angle a of the wall to the motor (deg)")
    ax.set_ylabel("force along the wall / into the hand" if is_ratio else "share within 30 deg")
    ax.legend(loc="upper left", bbox_to_anchor=(-0.1, -0.15))
    return figure


def _draw(ax: Any, means: pd.DataFrame, top: float, most: float, label: str, number: int) -> None:
    """most: of the measure, where its whiskers end. Without rotation there is no line between the
    points: it would leave tan a, and slope where the share jumps. Its points are larger and open,
    so that they are visible behind the others."""
    shown = means[means["mean"] <= top]
    colour = figures.COLOURS[number]
    beside_deg = _WHISKERS_BESIDE_DEG if number else -_WHISKERS_BESIDE_DEG
    if len(spread := shown[shown["half_width"] >= LEAST_HALF_WIDTH]):
        mean, half = spread["mean"].to_numpy(), spread["half_width"].to_numpy()
        sides = np.minimum(half, [mean, np.maximum(most - mean, 0.0)])
        ax.errorbar(spread.index + beside_deg, mean, sides, fmt="none", ecolor=colour)
    ax.plot(shown.index, shown["mean"], color=colour, label=label, clip_on=False,
            marker=figures.MARKERS[number], linestyle="-" if number else "none",
            markersize=5 if number else 8, markerfacecolor=colour if number else "none")
