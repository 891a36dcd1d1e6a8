"""At which stiffness, delay and rate a contact of a device with motors is calm."""

from __future__ import annotations

from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from palpate.analysis import figures
from palpate.analysis.results.picture import WIDTH_PX

TITLE = "Stiffness, delay and rate at which a contact is calm"
STABLE, CONTROLLED, TRIPPED, BROKEN = (figures.COLOURS[n] for n in (2, 0, 3, 1))
# Outcome, words, and the look of its mark.
OUTCOMES: dict[str, tuple[str, dict[str, Any]]] = {
    "stable": ("at rest by itself", dict(marker="o", color=STABLE)),
    "calm by the controller": ("at rest by the controller", dict(marker="o", color=CONTROLLED)),
    "tripped": ("tripped, with the reason", dict(marker="^", color=TRIPPED)),
    "refused": ("refused", dict(marker="o", color=figures.INK, markerfacecolor="none",
                                markersize=3, markeredgewidth=0.7)),
    "swings": ("promise broken", dict(marker="x", color=BROKEN, markeredgewidth=2)),
    "returns energy": ("promise broken", dict(marker="x", color=BROKEN, markeredgewidth=2)),
}
_LEGEND = 0.14  # of the height
_LONGEST_MS, _LEAST_N_PER_M, _MOST_N_PER_M = 5.0, 100.0, 20000.0


def draw(cases: pd.DataFrame, zones: pd.DataFrame) -> Figure:
    """A panel for each rate.

    cases: rate_Hz, delay_ms, stiffness_N_per_m, outcome; a mark for each simulated contact. zones:
    rate_Hz, delay_ms, stable_N_per_m and calm_N_per_m, the limits of a bare tip, which are lines.
    """
    rates = sorted(zones["rate_Hz"].unique())
    figure, axes = figures.new_figure(WIDTH_PX, 500, nrows=2, ncols=2, sharex=True, sharey=True)
    for rate_Hz, panel in zip(rates, axes.flat):
        _draw_zones(panel, zones[zones["rate_Hz"] == rate_Hz])
        _draw_cases(panel, cases[cases["rate_Hz"] == rate_Hz])
        panel.set_title(f"{rate_Hz:,.0f} Hz", loc="left")
    for panel in axes[:, 0]:
        panel.set_ylabel("stiffness, N/m")
    for panel in axes[-1]:
        panel.set_xlabel("delay, ms")
    handles = {line.get_label(): line for panel in axes.flat for line in panel.get_lines()
               if not line.get_label().startswith("_")}
    figure.legend(handles.values(), handles.keys(), loc="lower left", ncols=2)
    figure.get_layout_engine().set(rect=(0.0, _LEGEND, 1.0, 1.0 - _LEGEND))
    return figure


def _draw_zones(axes: Axes, zones: pd.DataFrame) -> None:
    delay, stable, calm = (zones[name] for name in ("delay_ms", "stable_N_per_m", "calm_N_per_m"))
    axes.fill_between(delay, _LEAST_N_PER_M, stable, color=STABLE, alpha=0.18, linewidth=0)
    axes.fill_between(delay, stable, calm, color=CONTROLLED, alpha=0.18, linewidth=0)
    axes.plot(delay, stable, color=STABLE, label="below, the loop comes to rest by itself")
    axes.plot(delay, calm, color=CONTROLLED, label="below, only by the controller; above, refused")
    axes.set_yscale("log")
    axes.set_xlim(0, _LONGEST_MS)
    axes.set_ylim(_LEAST_N_PER_M, _MOST_N_PER_M)
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.0f}"))


def _draw_cases(axes: Axes, cases: pd.DataFrame) -> None:
    for outcome, (words, look) in OUTCOMES.items():
        of = cases[cases["outcome"] == outcome]
        if not of.empty:
            axes.plot(of["delay_ms"], of["stiffness_N_per_m"].clip(_LEAST_N_PER_M, _MOST_N_PER_M),
                      linestyle="none", label=words, **{"markersize": 3.5, **look})
