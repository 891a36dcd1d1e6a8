"""The figures of accuracy: error over time and over level of a knob, and all knobs in one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from markupsafe import Markup, escape
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from palpate.analysis import figures
from palpate.analysis.accuracy import texts
from palpate.analysis.accuracy.axes import LabelPlaces, LogAxis, log_axis
from palpate.analysis.accuracy.results import Knob
from palpate.analysis.errors import printable
from palpate.analysis.figures import COLOURS, INK, MARKERS
from palpate.analysis.numbers import short_number, with_unit

# Pixels.
WIDTH = 430.0
# On the right, half of a label at the end of an axis has room.
_LEFT, _RIGHT, _TOP, _AREA_HEIGHT = 70.0, 18.0, 24.0, 270.0
_BELOW, _LEGEND_ROW = 56.0, 15.0  # to the legend; a line of it
_SMALL = 8.5  # font
_POINT, _RING, _RECOMMENDED = 4.0, 7.0, 10.0  # radii
_LABEL_GAP = 3.0

# Characters; longer texts are cut, and the tables have them in full.
_LONGEST_LEGEND, _LONGEST_OF_TWO, _LONGEST_LABEL, _LONGEST_LINE = 56, 30, 24, 42
_MOST_NAMED_LEVELS = 3
_SLOPE_BELOW = 0.06  # of the axis

_GREY = "#7c7c7c"
_PRESET_MARKERS = ("v", "s", "D")  # open and larger than points
_FRONT_LINE: dict[str, Any] = {"color": _GREY, "alpha": 0.35, "linewidth": 5}
_FRONT_RING: dict[str, Any] = {"marker": "o", "markersize": 11, "color": _GREY, "linestyle": "none",
                               "markerfacecolor": "none"}
_RECOMMENDED_RING = _FRONT_RING | {"markersize": 17, "color": INK}
_SLOPE: dict[str, Any] = {"color": INK, "linestyle": (0, (5, 3)), "linewidth": 1.2}


def _cut(text: str, longest: int) -> str:
    return text if len(text) <= longest else text[:longest] + "…"


def _axis_name(name: str, unit: str) -> str:
    """The name of an axis with its unit, in two lines if it is long."""
    text = with_unit(printable(name), unit)
    if len(text) > _LONGEST_LINE and (space := text.rfind(" ", 0, len(text) // 2 + 2)) > 0:
        return _cut(text[:space], _LONGEST_LINE) + "\n" + _cut(text[space + 1:], _LONGEST_LINE)
    return _cut(text, _LONGEST_LINE)


def _curve(method: int) -> dict[str, Any]:
    turn = method // len(COLOURS)
    return {"color": COLOURS[method % len(COLOURS)],
            "marker": MARKERS[(method + turn) % len(MARKERS)],
            "linestyle": ("-", "--", ":")[turn % 3]}


def _preset(preset: int) -> dict[str, Any]:
    return {"marker": _PRESET_MARKERS[preset], "markersize": 10, "color": INK,
            "markerfacecolor": "none", "linestyle": "none"}


class _Diagram:
    """The axes of both panels of a knob, and its levels that count, with positions on them."""

    def __init__(self, knob: Knob) -> None:
        self.knob = knob
        self.levels = knob.levels[knob.levels["counts"]]
        self.presets = knob.presets[knob.presets["counts"]]
        self.axes = {of: log_axis(np.concatenate([self.levels[of], self.presets[of]]),
                                  self.levels[[of + "_low", of + "_high"]],
                                  knob.facts[of]["unit"]) for of in ("error", "time")}
        self.axes["value"] = log_axis(self.levels["value"], [], knob.facts["level"]["unit"])
        self._name_levels()
        # If all errors are at the floor, they do not distinguish levels.
        above = ~self.levels["at_floor"].astype(bool) & (self.levels["error"] > 0.0)
        self.up_of_levels = "error" if above.any() else "time"

    def _name_levels(self) -> None:
        """Two or three levels are rather kinds than numbers, and have names."""
        names = self.levels.drop_duplicates("value").sort_values("value")
        if not 0 < len(names) <= _MOST_NAMED_LEVELS:
            return
        axis = self.axes["value"]
        px = (WIDTH - _LEFT - _RIGHT) / (1.4 * (axis.high - axis.low))
        places = px * axis.at(names["value"])
        halves = 0.5 * (5.4 * names["label"].str.len().to_numpy(float) + 6.0)
        if (np.diff(places) >= halves[1:] + halves[:-1]).all():
            axis.name(zip(names["value"], names["label"]))

    def across(self, panel: str) -> LogAxis:
        return self.axes["time" if panel == "time" else "value"]

    def up_name(self, panel: str) -> str:
        return "error" if panel == "time" else self.up_of_levels

    def placed(self, panel: str, levels: pd.DataFrame) -> pd.DataFrame:
        """Levels with their positions x, x_low, x_high, y, y_low, y_high in a panel."""
        x, y = self.across(panel), self.axes[self.up_name(panel)]
        across = ("time", "time_low", "time_high") if panel == "time" else ("value",) * 3
        up = [self.up_name(panel) + end for end in ("", "_low", "_high")]
        return levels.assign(**{name: x.at(levels[of]) for name, of in
                                zip(("x", "x_low", "x_high"), across)},
                             **{name: y.at(levels[of]) for name, of in
                                zip(("y", "y_low", "y_high"), up)})


def _front(knob: Knob, placed: pd.DataFrame) -> pd.DataFrame:
    """The corners of the Pareto front, from the quickest to the most accurate level."""
    if knob.facts["levels_are_given"] or knob.facts["methods_are_given"]:
        return placed.iloc[:0]
    front = placed[placed["on_front"]].sort_values(["x", "y"], ascending=[True, False])
    before = front["y"].cummin().shift(fill_value=math.inf)
    return front[front["y"] <= before]  # levels tied with the front may lie behind it


def _legend_of(knob: Knob, panel: str, presets: pd.DataFrame) -> list[tuple[str, dict[str, Any]]]:
    entries: list[tuple[str, dict[str, Any]]] = []
    for m, method in enumerate(knob.methods):
        if panel == "time":
            failed = (~knob.levels["counts"] & (knob.levels["method"] == m)).sum()
            suffix = f" ({failed} failed)" if failed else ""
        else:
            suffix = _order_text(method)
        room = _LONGEST_LEGEND - min(len(suffix), _LONGEST_LEGEND // 2)
        entries.append((_cut(method["name"], room) + suffix, _curve(m)))
    if panel == "level":
        if any(method["expected_order"] is not None for method in knob.methods):
            entries.append(("slope of the order in theory", _SLOPE))
        return entries
    given = knob.facts["levels_are_given"]
    if not given and not knob.facts["methods_are_given"]:
        entries.append(("Pareto front", _FRONT_LINE))
    if knob.has_choice:
        entries.append(("best at its level" if given else "on the front", _FRONT_RING))
        if knob.facts["recommended"] is not None:
            entries.append(("recommended", _RECOMMENDED_RING))
    return entries + [(f"preset {label}", _preset(n))
                      for n, label in zip(presets["level"], presets["label"])]


def _order_text(method: dict[str, Any]) -> str:
    fitted, expected = method["order"], method["expected_order"]
    if fitted is None and expected is None:
        return ""
    text = ": no order fitted" if fitted is None else f": order {texts.order_number(fitted)}"
    return text + ("" if expected is None else f" (theory {short_number(expected)})")


class _Panel:
    """One panel: "time" shows errors over times, "level" errors (or times) over levels."""

    def __init__(self, diagram: _Diagram, panel: str) -> None:
        self.diagram, self.knob, self.panel = diagram, diagram.knob, panel
        self.levels = diagram.placed(panel, diagram.levels)
        self.presets = diagram.placed(panel, diagram.presets)
        entries = _legend_of(self.knob, panel, self.presets)
        columns = 2 if max(len(text) for text, _ in entries) <= _LONGEST_OF_TWO else 1
        rows = math.ceil(len(entries) / columns)
        height = _TOP + _AREA_HEIGHT + _BELOW + _LEGEND_ROW * rows + 8.0
        self.figure, self.ax = figures.new_figure(WIDTH, height)
        self.figure.set_layout_engine("none")
        self.size = np.array([WIDTH - _LEFT - _RIGHT, _AREA_HEIGHT])
        self.ax.set_position((_LEFT / WIDTH, 1.0 - (_TOP + _AREA_HEIGHT) / height,
                              self.size[0] / WIDTH, _AREA_HEIGHT / height))
        self.places = LabelPlaces(*self.size)
        self._draw_axes()
        self.figure.legend([Line2D([], [], **style) for _, style in entries],
                           [text for text, _ in entries], loc="upper left", ncol=columns,
                           bbox_to_anchor=(0.01, (height - _TOP - _AREA_HEIGHT - _BELOW + 8.0)
                                           / height),
                           fontsize=9, handlelength=2.4, borderaxespad=0.0, markerscale=0.7)

    def _draw_axes(self) -> None:
        x, y = self.diagram.across(self.panel), self.diagram.axes[self.up]
        x.draw(self.ax.xaxis)
        y.draw(self.ax.yaxis)
        facts = self.knob.facts
        across = facts["time" if self.panel == "time" else "level"]["name"]
        self.ax.set_xlabel(_axis_name(across, x.unit))
        self.ax.set_ylabel(_axis_name(facts[self.up]["name"], y.unit))
        self.ax.set_title(f"{self.up} against {self.panel}")

    @property
    def up(self) -> str:
        return self.diagram.up_name(self.panel)

    def px(self, points: Any) -> Any:
        """Positions on the axes (n x 2) as pixels of the area, y upwards."""
        low = np.array([self.ax.get_xlim()[0], self.ax.get_ylim()[0]])
        high = np.array([self.ax.get_xlim()[1], self.ax.get_ylim()[1]])
        return (np.asarray(points, float) - low) / (high - low) * self.size

    def block(self) -> None:
        """Keep labels away from points, whiskers and curves."""
        self.places.block(self.px(self.levels[["x", "y"]]), _POINT)
        self.places.block(self.px(self.levels.loc[self.levels["on_front"], ["x", "y"]]), _RING)
        for _, row in self.levels.iterrows():
            self.places.block_line(self.px([[row.x_low, row.y], [row.x_high, row.y]]))
            self.places.block_line(self.px([[row.x, row.y_low], [row.x, row.y_high]]))
        for _, curve in self._unbroken():
            self.places.block_line(self.px(curve[["x", "y"]]))
        if self.panel == "time":
            front = _front(self.knob, self.levels)[["x", "y"]].to_numpy(float)
            corners = np.column_stack([front[1:, 0], front[:-1, 1]])
            steps = np.stack([front[:-1], corners], axis=1).reshape(-1, 2)
            self.places.block_line(self.px(np.vstack([steps, front[-1:]])))
            self.places.block(self.px(self.presets[["x", "y"]]), 8.0)

    def _unbroken(self) -> list[tuple[int, pd.DataFrame]]:
        """The parts of each curve between its failed levels."""
        gap = self.levels["level"].diff().fillna(1) != 1
        parts = [self.levels["method"], gap.cumsum()]
        return [(key[0], part) for key, part in self.levels.groupby(parts, sort=False)]

    def draw_floors(self) -> None:
        if self.up != "error":
            return
        axis = self.diagram.axes["error"]
        for floor in sorted({m["floor"] for m in self.knob.methods if m["floor"] > 0.0}):
            y = math.log10(floor * axis.factor)
            if not axis.low <= y <= axis.high:
                continue
            self.ax.axhline(y, color=_GREY, linewidth=1.2, linestyle=(0, (6, 4)))
            line = self.px([[0.0, y]])[0][1]
            for x in np.arange(self.size[0] - 20.0, 20.0, -12.0):
                boxes = [np.array([x - 15, line + side - 6, x + 15, line + side + 6])
                         for side in (9.0, -9.0)]
                box = next((box for box in boxes if self.places.take(box)), None)
                if box is not None:
                    self._write("floor", 0.5 * (box[:2] + box[2:]))
                    break
            self.places.block_line(np.array([[0.0, line], [self.size[0], line]]))

    def _write(self, text: str, middle: Any) -> None:
        self.ax.text(*(middle / self.size), text, transform=self.ax.transAxes, ha="center",
                     va="center", fontsize=_SMALL)

    def draw_labels(self) -> None:
        """The recommended level and the default first; where nothing is a choice, the methods."""
        names_methods = not self.knob.has_choice
        farthest = 3 if names_methods else 1 if self.knob.facts["levels_are_given"] else 2
        urgency = np.select([self.levels["is_recommended"], self.levels["is_default"],
                             self.levels["on_front"]], [0, 1, 2], 3)
        wishes = self.levels.assign(urgency=urgency)
        if names_methods:
            wishes = wishes[wishes["level"] == self.knob.facts["default"]["level"]]
        for _, row in wishes.sort_values("urgency", kind="stable").iterrows():
            text = self.knob.methods[row["method"]]["name"] if names_methods else row["label"]
            text = _cut(text, _LONGEST_LABEL)
            if row["is_default"] and not names_methods:
                text += " (default)"
            radius = _RECOMMENDED if row["urgency"] == 0 else _RING if row["on_front"] else _POINT
            middle = self.places.take_beside(self.px([[row.x, row.y]])[0], text, _SMALL,
                                             radius + _LABEL_GAP, row["urgency"] <= farthest)
            if middle is not None:
                self._write(text, middle)

    def draw_front(self) -> None:
        front = _front(self.knob, self.levels)
        self.ax.step(front["x"], front["y"], where="post", **_FRONT_LINE)
        if self.knob.has_choice:
            on_front = self.levels[self.levels["on_front"]]
            self.ax.plot(on_front["x"], on_front["y"], **_FRONT_RING)

    def draw_curves(self) -> None:
        width = 0.8 if self.knob.facts["levels_are_given"] else 1.5
        for m, part in self._unbroken():
            style = _curve(m)
            self.ax.errorbar(part["x"], part["y"],
                             xerr=np.abs([part["x"] - part["x_low"], part["x_high"] - part["x"]]),
                             yerr=np.abs([part["y"] - part["y_low"], part["y_high"] - part["y"]]),
                             color=style["color"], linestyle=style["linestyle"], linewidth=width,
                             elinewidth=0.8, capsize=2.0)
            for is_open in (False, True):
                points = part[part["at_floor"].astype(bool) == is_open]
                self.ax.plot(points["x"], points["y"], color=style["color"], linestyle="none",
                             marker=style["marker"],
                             markerfacecolor="none" if is_open else style["color"])

    def draw_marks(self) -> None:
        """The recommended level, and the presets."""
        if self.knob.has_choice:
            best = self.levels[self.levels["is_recommended"]]
            self.ax.plot(best["x"], best["y"], **_RECOMMENDED_RING)
        if self.panel == "time":
            for _, preset in self.presets.iterrows():
                self.ax.plot(preset["x"], preset["y"], **_preset(preset["level"]))

    def draw_slopes(self) -> None:
        """Lines of the orders in theory, below the levels; only their slope has a meaning."""
        below = _SLOPE_BELOW * np.ptp(self.ax.get_ylim())
        for m, method in enumerate(self.knob.methods):
            above = (self.levels["error"] > 0.0) & ~self.levels["at_floor"].astype(bool)
            above &= self.levels["value"] > 0.0
            fitted = self.levels[above & (self.levels["method"] == m)]
            if method["expected_order"] is None or len(fitted) < 2:
                continue
            x = fitted["x"].iloc[[0, -1]]
            y = fitted["y"].mean() - below + method["expected_order"] * (x - fitted["x"].mean())
            self.ax.plot(x, y, scalex=False, scaley=False, **_SLOPE)


def _drawn(diagram: _Diagram, panel: str) -> Figure:
    drawing = _Panel(diagram, panel)
    drawing.block()
    drawing.draw_floors()
    if panel == "time":
        drawing.draw_labels()
        drawing.draw_front()
    drawing.draw_curves()
    drawing.draw_marks()
    if panel == "level":
        drawing.draw_slopes()
    return drawing.figure


def work_precision(knob: Knob) -> tuple[Figure, Figure]:
    """Errors over times, and errors over levels.

    Points are medians over the repeats, whiskers quartiles; both axes are logarithmic, with a grey
    band for values of exactly 0. Open points are at the floor. The second figure shows times where
    no error is above the floor.
    """
    diagram = _Diagram(knob)
    return _drawn(diagram, "time"), _drawn(diagram, "level")


def side_by_side(pictures: Sequence[Markup], title: str) -> str:
    """Elements of `figures.svg()` beside one another, below a title, as a document of its own."""
    head, gap = 30.0, 8.0
    sizes = [figures.size(picture) for picture in pictures]
    width = sum(each for each, _ in sizes) + gap * (len(sizes) - 1)
    heading = (f'<text x="{0.5 * width:g}" y="20" text-anchor="middle" fill="currentColor" '
               f'font-family="DejaVu Sans, sans-serif" font-size="14">{escape(printable(title))}'
               "</text>")
    parts = [figures.placed(picture, sum(each + gap for each, _ in sizes[:n]), head)
             for n, picture in enumerate(pictures)]
    return figures.document(width, head + max(each for _, each in sizes), title, [heading, *parts])


def overview_table(knobs: list[Knob]) -> pd.DataFrame:
    """A row for each knob with a choice and a recommendation, in the order of the file.

    `title`; `error_*` of the default and of the recommended level over the error that is small
    enough for a hand (median, `_low`, `_high`; NaN where every error is); `time_*` over the median
    time of the default; `is_default`: the recommended level is the default.
    """
    rows = []
    for knob in knobs:
        default, best = knob.row("default"), knob.row("recommended")
        if not knob.has_choice or default is None or best is None or not default["time"] > 0.0:
            continue
        enough = knob.facts["enough"] or math.nan
        row: dict[str, Any] = {"title": knob.facts["title"], "is_default": best["is_default"]}
        for name, level in (("default", default), ("best", best)):
            for end in ("", "_low", "_high"):
                row[f"error_{name}{end}"] = level["error" + end] / enough
                row[f"time_{name}{end}"] = level["time" + end] / default["time"]
        rows.append(row)
    return pd.DataFrame(rows)


def overview(table: pd.DataFrame) -> Figure:
    """Error over what is small enough, and time over that of the default, of each knob."""
    row_px, left, gap, right = 19.0, 168.0, 14.0, 8.0
    height = 62.0 + row_px * len(table)
    whole = WIDTH + 60.0
    figure, (errors, times) = figures.new_figure(whole, height, ncols=2, sharey=True)
    figure.set_layout_engine("none")
    width = 0.5 * (whole - left - gap - right)
    for n, ax in enumerate((errors, times)):
        ax.set_position(((left + n * (width + gap)) / whole, 38.0 / height, width / whole,
                         row_px * len(table) / height))
    _overview_panel(errors, table, "error", "error over what is small enough")
    _overview_panel(times, table, "time", "time over the default's")
    errors.set_yticks(range(len(table)), [_cut(printable(t), 30) for t in table["title"]])
    errors.set_ylim(len(table) - 0.5, -0.5)
    times.tick_params(labelleft=False, left=False)
    handles = [Line2D([], [], **_DEFAULT_POINT), Line2D([], [], **_BEST_POINT)]
    figure.legend(handles, ["default", "recommended"], loc="upper right", ncol=2,
                  bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2)
    return figure


_DEFAULT_POINT: dict[str, Any] = {"marker": "o", "color": COLOURS[0], "linestyle": "none"}
_BEST_POINT: dict[str, Any] = {"marker": "o", "markersize": 10, "color": COLOURS[1],
                               "markerfacecolor": "none", "linestyle": "none"}


def _overview_panel(ax: Any, table: pd.DataFrame, of: str, name: str) -> None:
    names = ("default", "best")
    shown = table.dropna(subset=[f"{of}_default"])
    axis = log_axis(np.concatenate([*(shown[f"{of}_{n}"] for n in names), [1.0]]),
                    shown[[f"{of}_{n}{end}" for n in names for end in ("_low", "_high")]], "", 4)
    axis.draw(ax.xaxis)
    ax.axvline(0.0, color=INK, linewidth=1.0)
    ax.set_xlabel(name, fontsize=9)
    y = shown.index.to_numpy(float)
    for n, style in zip(names, (_DEFAULT_POINT, _BEST_POINT)):
        x, low, high = (axis.at(shown[f"{of}_{n}{end}"]) for end in ("", "_low", "_high"))
        ax.errorbar(x, y, xerr=np.abs([x - low, high - x]), fmt="none", ecolor=style["color"],
                    elinewidth=1.0, capsize=2.0)
        ax.plot(x, y, **style)
