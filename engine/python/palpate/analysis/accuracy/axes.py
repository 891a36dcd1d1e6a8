"""Logarithmic axes that also show 0, and labels that cover nothing."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from matplotlib.markers import TICKDOWN, TICKLEFT
from numpy.typing import NDArray

from palpate.analysis.figures import INK
from palpate.analysis.numbers import display_unit, short_number

Floats = NDArray[np.float64]

# Decades.
_LEAST_SPAN = 0.12  # so that noise of a few per cent looks small
_WHISKER_BEYOND = 1.5  # how far a whisker may stretch the axis beyond the values
_DECADES_FROM = 2.6  # from this span on: labels at powers of ten only
_STEPS_FROM = 0.75  # from this span on: labels at 1, 2 and 5
# Parts of the span.
_MARGIN = 0.07
_ZERO_BAND = 0.12
_LARGEST_PLAIN_POWER = 3
_FINE_LABELS = 5


def _superscript(number: int) -> str:
    return "10" + str(number).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


@dataclass
class LogAxis:
    """The range, the unit and the ticks of a logarithmic axis.

    Positions are log10 of the values in the unit `unit`; 0 has a place of its own below `band`.
    ticks: position and label, "" for a minor tick.
    """

    low: float = -1.0
    high: float = 1.0
    unit: str = ""
    factor: float = 1.0
    zero: float | None = None
    band: float | None = None
    ticks: list[tuple[float, str]] = field(default_factory=list)

    def at(self, values: Any) -> Floats:
        """The positions of values, or of ends of whiskers, within the range."""
        values = np.asarray(values, float) * self.factor
        positive = values > 0.0
        logs = np.log10(values, where=positive, out=np.zeros_like(values))
        floor = self.low if self.zero is None else self.zero
        return np.where(positive, np.clip(logs, self.low, self.high), floor)

    def name(self, ticks: Iterable[tuple[float, str]]) -> None:
        """Replace the numbers by these names of values, and widen the range for them."""
        self.ticks = [(float(self.at(value)), name) for value, name in ticks]
        more = 0.2 * (self.high - self.low)
        self.low, self.high, self.unit = self.low - more, self.high + more, ""

    def draw(self, axis: Any) -> None:
        """Set up an axis of a figure."""
        ax, is_x = axis.axes, axis.axis_name == "x"
        named = [tick for tick in self.ticks if tick[1]]
        axis.set_ticks([position for position, _ in named], [label for _, label in named])
        minor = [position for position, label in self.ticks if not label]
        zeros = [0.0] * len(minor)
        where, marker, transform = (
            ((minor, zeros), TICKDOWN, ax.get_xaxis_transform()) if is_x else
            ((zeros, minor), TICKLEFT, ax.get_yaxis_transform()))
        # One line: ticks of matplotlib would take a third of the time of a figure.
        ax.plot(*where, marker=marker, markersize=2, color=INK, linestyle="none", clip_on=False,
                transform=transform, markeredgewidth=0.6)
        (ax.set_xlim if is_x else ax.set_ylim)(self.low, self.high)
        if self.band is not None:
            span = ax.axvspan if is_x else ax.axhspan
            span(self.low, self.band, color=INK, alpha=0.07, linewidth=0)


def _decades(low: float, high: float, most_labels: int) -> list[tuple[float, str]]:
    first, last = math.ceil(low), math.floor(high)
    stride = max(1, math.ceil((last - first) / most_labels))
    plain = first >= -_LARGEST_PLAIN_POWER and last <= _LARGEST_PLAIN_POWER
    ticks = [(float(power), ("" if power % stride else
                             short_number(10.0**power) if plain else _superscript(power)))
             for power in range(first, last + 1)]
    if stride == 1:
        ticks += [(power + math.log10(digit), "")
                  for power in range(first - 1, last + 1) for digit in range(2, 10)]
    return ticks


def _steps(low: float, high: float) -> list[tuple[float, str]]:
    return [(power + math.log10(digit),
             short_number(digit * 10.0**power) if digit in (1, 2, 5) else "")
            for power in range(math.floor(low), math.floor(high) + 1) for digit in range(1, 10)]


def _fine(low: float, high: float) -> list[tuple[float, str]]:
    least = (10.0**high - 10.0**low) / _FINE_LABELS
    power = 10.0 ** math.floor(math.log10(least))
    step = next(factor * power for factor in (1, 2, 5, 10) if factor * power >= least)
    first = math.ceil(10.0**low / step)
    return [(math.log10(n * step), short_number(n * step))
            for n in range(first, math.floor(10.0**high / step) + 1)]


def log_axis(values: Any, whiskers: Any, unit: str, most_decades: int = 7) -> LogAxis:
    """The axis that shows these values, and their whiskers up to 1.5 decades beyond all values.

    unit: of the values. most_decades: how many powers of ten have room for a label.
    """
    values = np.asarray(values, float).ravel()
    positive = values[values > 0.0]
    has_zero = len(positive) < len(values)
    if len(positive) == 0:
        return LogAxis(unit=display_unit(0.0, unit)[1], zero=0.0, ticks=[(0.0, "0")])
    ends = np.asarray(whiskers, float).ravel()
    ends = np.log10(np.concatenate([positive, ends[ends > 0.0]]))
    least, most = math.log10(positive.min()), math.log10(positive.max())
    low, high = max(ends.min(), least - _WHISKER_BEYOND), min(ends.max(), most + _WHISKER_BEYOND)
    lacking = max(0.0, _LEAST_SPAN - (high - low))
    low, high = low - 0.5 * lacking, high + 0.5 * lacking
    span = high - low
    factor, name = display_unit(positive.max(), unit)
    low, high = low - _MARGIN * span, high + _MARGIN * span
    if span >= _DECADES_FROM and low + math.log10(factor) < -_LARGEST_PLAIN_POWER:
        factor, name = display_unit(0.0, unit)  # powers of ten are clearest with a plain unit
    low, high = low + math.log10(factor), high + math.log10(factor)
    if span >= _DECADES_FROM:
        ticks = _decades(low, high, most_decades)
    else:
        ticks = _steps(low, high) if span >= _STEPS_FROM else _fine(low, high)
    axis = LogAxis(low, high, name, factor)
    axis.ticks = [tick for tick in ticks if low <= tick[0] <= high]
    if has_zero:
        band = _ZERO_BAND * max(high - low, 1.0)
        zero = low - 0.5 * band
        axis.band, axis.zero, axis.low = low, zero, low - band
        axis.ticks.append((zero, "0"))
    return axis


class LabelPlaces:
    """Finds free places for labels in an area.

    Pixels, y upwards; a box is left, bottom, right, top.
    """

    _CHARACTER = 0.6  # mean width of a character over the size of the font
    _LINE_STEP, _LINE_HALF = 5.0, 2.0
    _FARTHER = (0.0, 6.0, 12.0)

    def __init__(self, width: float, height: float) -> None:
        self.area = np.array([0.0, 0.0, width, height])
        self.taken: Floats = np.empty((0, 4))

    def block(self, points: NDArray[Any], radius: float) -> None:
        """Keep labels away from these points (n x 2)."""
        self.taken = np.vstack([self.taken, np.hstack([points - radius, points + radius])])

    def block_line(self, points: Floats) -> None:
        """Keep labels away from the line through these points (n x 2)."""
        lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
        for begin, end, length in zip(points, points[1:], lengths):
            steps = 2 + int(length / self._LINE_STEP)
            self.block(np.linspace(begin, end, steps), self._LINE_HALF)

    def take(self, box: Floats) -> bool:
        """Take this place and return True, if it is free."""
        is_within = (box[:2] >= self.area[:2]).all() and (box[2:] <= self.area[2:]).all()
        overlaps = ((box[:2] < self.taken[:, 2:]) & (self.taken[:, :2] < box[2:])).all(axis=1)
        if not is_within or overlaps.any():
            return False
        self.taken = np.vstack([self.taken, box])
        return True

    def take_beside(self, point: Floats, text: str, size: float, reach: float,
                    is_urgent: bool) -> Floats | None:
        """The middle of a free place for a text beside a point, which is then taken.

        reach: from the point to the text; an urgent text may be up to 12 px farther away.
        """
        half = 0.5 * np.array([self._CHARACTER * size * len(text), size + 2.0])
        for farther in self._FARTHER if is_urgent else self._FARTHER[:1]:
            aside, above = half + reach + farther
            x, y = half * (1.0, 0.6) + 0.7 * (reach + farther)
            for shift in ((aside, 0.0), (x, y), (x, -y), (0.0, above), (0.0, -above),
                          (-aside, 0.0), (-x, y), (-x, -y)):
                middle: Floats = point + shift
                if self.take(np.concatenate([middle - half, middle + half])):
                    return middle
        return None
