"""The steps of a proxy that slides into a groove.

The groove is two walls through the origin, in millimetres and in the plane across the groove. The
steps are computed as the god-object takes them: the goal is projected onto the contact planes, and
the first wall in the way stops the proxy a stand-off before and adds its plane. In the plane each
step has a closed form.
"""

from __future__ import annotations

import textwrap

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, Wedge
from numpy.typing import NDArray

from palpate.analysis import figures
from palpate.analysis.results.picture import WIDTH_PX

TITLE = "A proxy slides into a groove in five steps"
Array = NDArray[np.float64]

WALL_SLOPES_DEG = np.array([-36.0, 50.0])  # of the left and of the right wall
STAND_OFF_MM = 0.75  # much larger than the engine's, to be visible
OLD_PROXY_MM = np.array([-5.6, 8.2])
GOAL_MM = np.array([0.7, -4.6])
LOW_MM, HIGH_MM = np.array([-8.2, -5.6]), np.array([6.2, 9.4])
PROXY, GOAL, PLANES = figures.COLOURS[0], figures.COLOURS[4], figures.COLOURS[2:0:-1]

TEXT = (
    "The tick starts at the old proxy. The goal, the device's point in the scene, lies inside the "
    "solid.",
    "The proxy moves straight towards the goal. The first wall stops it a stand-off before the "
    "surface and adds contact plane 1.",
    "The proxy slides along plane 1 towards the point of the plane that is nearest to the goal.",
    "The second wall stops the slide a stand-off before its surface and adds contact plane 2.",
    "The proxy rests at the nearest point to the goal that neither plane forbids. Certificate: the "
    "lag, from proxy to goal, lies between the directions into both walls (shaded), so no free "
    "direction leads nearer to the goal.",
)
NOTE = "Section across the groove. The stand-off is drawn far too large: in the engine it is invisible."


def normals() -> Array:
    """Of both walls, into the free space: (2, 2)."""
    slopes = np.radians(WALL_SLOPES_DEG)
    return np.stack([-np.sin(slopes), np.cos(slopes)], axis=1)


def height(point: Array, normal: Array) -> float:
    """Over the plane that lies a stand-off in front of the wall, mm."""
    return float(point @ normal) - STAND_OFF_MM


def _stopped_at(start: Array, end: Array, normal: Array) -> Array:
    """Where the segment meets the plane."""
    first, last = height(start, normal), height(end, normal)
    return start + first / (first - last) * (end - start)


def steps() -> tuple[Array, Array, Array, Array]:
    """The old proxy, where the first wall stops it, the nearest point of plane 1 to the goal, and
    the rest, mm."""
    first, second = normals()
    stopped = _stopped_at(OLD_PROXY_MM, GOAL_MM, first)
    nearest = GOAL_MM - height(GOAL_MM, first) * first
    rest = _stopped_at(stopped, nearest, second)
    # The certificate: the lag is a sum of the inward normals with positive factors.
    assert (np.linalg.solve(-normals().T, GOAL_MM - rest) > 0.0).all()
    return OLD_PROXY_MM, stopped, nearest, rest


def draw() -> Figure:
    """The walls, planes and steps on the left, and what the numbers mean on the right."""
    figure, (axes, words) = figures.new_figure(WIDTH_PX, 390, ncols=2, width_ratios=[1.25, 1])
    _draw_walls(axes)
    _draw_steps(axes)
    axes.set(aspect="equal", xlim=(LOW_MM[0], HIGH_MM[0]), ylim=(LOW_MM[1], HIGH_MM[1]))
    for each in (axes, words):
        each.set_axis_off()
    lines = 0.0
    for number, text in enumerate((*TEXT, NOTE), 1):
        wrapped = textwrap.wrap(text, 36)
        at = (0.09, 1.0 - 0.0375 * lines)
        words.text(*at, "\n".join(wrapped), va="top", fontsize=9, linespacing=1.25,
                   transform=words.transAxes)
        if number <= len(TEXT):
            words.text(0.02, at[1] - 0.002, str(number), va="top", ha="center", fontsize=9,
                       color=PROXY, fontweight="bold", transform=words.transAxes)
        lines += len(wrapped) + 0.6
    return figure


def _draw_walls(axes: Axes) -> None:
    ends = np.array([LOW_MM[0], HIGH_MM[0]])
    surface = np.column_stack([ends, ends * np.tan(np.radians(WALL_SLOPES_DEG))])
    corners = [surface[0], [0.0, 0.0], surface[1], [HIGH_MM[0], LOW_MM[1]], LOW_MM]
    axes.fill(*np.array(corners).T, facecolor=figures.GRID, alpha=0.2, linewidth=0)
    axes.plot(*np.array(corners[:3]).T, color=figures.INK, linewidth=2)
    axes.text(-7.6, 2.4, "solid", color=figures.INK)
    second = normals()[1]
    foot = 6.2 * np.array([second[1], -second[0]])
    _arrow(axes, foot, foot + STAND_OFF_MM * second, figures.INK, "<|-|>", 1.0)
    axes.text(HIGH_MM[0], foot[1] - 1.0, "stand-off", ha="right")


def _draw_steps(axes: Axes) -> None:
    old, stopped, nearest, rest = steps()
    first, second = normals()
    for number, (normal, border) in enumerate(zip((first, second), (LOW_MM[0], HIGH_MM[0]))):
        along = np.array([normal[1], -normal[0]])
        ends = (rest - np.sign(border) * 1.6 * along, rest + (border - rest[0]) / along[0] * along)
        axes.plot(*np.array(ends).T, color=PLANES[number], linewidth=1.2, linestyle=(0, (5, 3)))
    into = np.degrees(np.arctan2(-normals()[:, 1], -normals()[:, 0]))
    axes.add_patch(Wedge(rest, 2.0, *sorted(into), facecolor=GOAL, alpha=0.25, linewidth=0))
    for number, normal in enumerate((first, second)):
        _arrow(axes, rest, rest - 2.0 * normal, PLANES[number], "-|>", 1.5)
    for start, end in ((stopped, GOAL_MM), (GOAL_MM, nearest), (rest, nearest)):
        axes.plot(*np.array([start, end]).T, color=figures.INK, linewidth=0.9, linestyle=":")
    axes.plot(*nearest, "o", color=figures.INK, markerfacecolor="none", markersize=5)
    _arrow(axes, old, stopped, PROXY, "-|>", 2.0)
    _arrow(axes, stopped, rest, PROXY, "-|>", 2.0)
    _arrow(axes, rest, GOAL_MM, GOAL, "-|>", 1.5)
    axes.plot(*GOAL_MM, "o", color=GOAL, markersize=6)
    middle = 0.5 * (stopped + rest)
    places = (old + [-0.55, 0.35], stopped + [-0.65, -0.2], middle + 0.6 * first,
              rest + [0.1, 0.85], rest + [-0.75, 0.0])
    for number, place in enumerate(places, 1):
        axes.text(*place, str(number), color=PROXY, fontweight="bold", ha="center", va="center")
    axes.text(old[0] + 0.4, old[1], "old proxy", color=PROXY, va="center")
    axes.text(GOAL_MM[0] + 0.5, GOAL_MM[1], "goal", color=GOAL, va="center")
    axes.text(HIGH_MM[0], nearest[1] - 0.9, "nearest point\nof plane 1", ha="right", va="top")
    axes.text(-8.0, 7.0, "plane 1", color=PLANES[0])
    axes.text(4.7, 8.2, "plane 2", color=PLANES[1], ha="right")


def _arrow(axes: Axes, start: Array, end: Array, colour: str, style: str, width: float) -> None:
    axes.add_patch(FancyArrowPatch(start, end, arrowstyle=style, mutation_scale=9, color=colour,
                                   linewidth=width, shrinkA=0, shrinkB=0))
