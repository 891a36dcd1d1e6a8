"""What accuracy costs: the error over the time of the main knobs."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator
from numpy.typing import NDArray

from palpate.analysis import figures, numbers
from palpate.analysis.results.picture import WIDTH_PX

TITLE = ("Error over time of the main knobs: a mark for each level, with the quartiles of both; "
         "a ring marks the default")
_PANEL_PX, _AROUND_PX = 250, 20
# From how many decades on an axis has marks at which digits.
_DIGITS = ((2.5, (1.0,)), (0.8, (1.0, 2.0, 5.0)), (0.4, (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0)),
           (0.0, (1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0)))
Array = NDArray[np.float64]


def draw(table: pd.DataFrame) -> Figure:
    """A panel for each knob, a curve for each method.

    table: knob, title, method, error, error_low, error_high (quartiles), error_name, error_unit,
    the same of time, and is_default. An error of 0 is at the lower end of its axis.
    """
    knobs = list(table["knob"].unique())
    rows = math.ceil(len(knobs) / 2)
    columns = min(2, len(knobs))
    figure, axes = figures.new_figure(WIDTH_PX * columns / 2, _AROUND_PX + _PANEL_PX * rows,
                                      nrows=rows, ncols=columns, squeeze=False)
    for knob, panel in zip(knobs, axes.flat):
        _draw_knob(panel, table[table["knob"] == knob])
    for panel in axes.flat[len(knobs):]:
        panel.set_axis_off()
    return figure


def _shown(levels: pd.DataFrame, of: str, factor: float) -> tuple[Array, float]:
    """Value, lower and upper quartile of each level, and the place of 0 on a logarithmic axis (NaN:
    no value is 0)."""
    values = levels[[of, f"{of}_low", f"{of}_high"]].to_numpy(float) * factor
    least = values[values > 0.0].min(initial=np.inf)
    place = 0.2 * least if np.isfinite(least) else 1.0
    is_zero = values <= 0.0
    return np.where(is_zero, place, values), place if is_zero.any() else np.nan


def _draw_knob(axes: Axes, levels: pd.DataFrame) -> None:
    first = levels.iloc[0]
    values, zeros = {}, {}
    for of in ("time", "error"):
        factor, unit = numbers.display_unit(float(levels[of].max()), first[f"{of}_unit"])
        values[of], zeros[of] = _shown(levels, of, factor)
        label = numbers.with_unit(first[f"{of}_name"], unit)
        axes.set_xlabel(label) if of == "time" else axes.set_ylabel(label)
    axes.set_xscale("log")
    axes.set_yscale("log")
    for number, method in enumerate(levels["method"].unique()):
        of_method = (levels["method"] == method).to_numpy()
        (x, x_low, x_high), (y, y_low, y_high) = (values[of][of_method].T
                                                  for of in ("time", "error"))
        axes.errorbar(x, y, xerr=np.abs([x - x_low, x_high - x]),
                      yerr=np.abs([y - y_low, y_high - y]), elinewidth=0.8, capsize=2,
                      color=figures.COLOURS[number % 6], marker=figures.MARKERS[number % 6],
                      markersize=4, label=method.replace("-", " "))
    usual = levels["is_default"].to_numpy(bool)
    if usual.any():
        axes.plot(values["time"][usual, 0], values["error"][usual, 0], "o", markersize=11,
                  color=figures.INK, markerfacecolor="none", label="default")
    _mark(axes.xaxis, axes.get_xlim(), zeros["time"])
    _mark(axes.yaxis, axes.get_ylim(), zeros["error"])
    axes.set_title(first["title"], loc="left")
    axes.legend()


def _mark(axis: Axis, limits: tuple[float, float], zero: float) -> None:
    """Marks the powers of ten of a wide axis, and numbers between them on a narrow one."""
    low, high = limits
    decades = np.log10(high / low)
    digits = next(digits for least, digits in _DIGITS if decades > least)
    stride = np.ceil(decades / 6)
    powers = np.arange(np.floor(np.log10(low)), np.ceil(np.log10(high)) + 1)
    powers = powers[powers % stride == 0]
    places = [digit * 10.0**power for power in powers for digit in digits]
    least = low if np.isnan(zero) else 3.0 * zero
    places = [place for place in places if least <= place <= high]
    labels = [numbers.short_number(place) for place in places]
    if not np.isnan(zero):
        places, labels = [zero, *places], ["0", *labels]
    axis.set_ticks(places, labels)
    axis.set_minor_locator(NullLocator())
