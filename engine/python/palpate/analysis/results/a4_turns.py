"""Four instants of one contact: A4 turns the star until the touched wall faces the only motor."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Arc, FancyArrowPatch
from numpy.typing import NDArray

from palpate.analysis import figures
from palpate.analysis.results.picture import WIDTH_PX

TITLE = "A4 turns the star until the touched wall faces the only motor"
MOTOR, WALL = figures.COLOURS[0], figures.COLOURS[1]
_ARROW_M, _NORMAL_M, _ANGLE_M = 0.085, 0.075, 0.035  # lengths and a radius in the picture
_HEIGHT_PX = 262
Array = NDArray[np.float64]


def turned(instant: dict[str, Any], vectors: Any) -> Array:
    """Vectors (..., 2) of the scene, along the axes of the device."""
    w, z = instant["T_device_scene"]["q_wz"]
    angle = 2.0 * np.arctan2(z, w)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return np.asarray(np.asarray(vectors, dtype=float) @ turn.T)


def angle_deg(instant: dict[str, Any], axis: Any) -> float:
    """Between the contact normal and the line of the motor."""
    normal = turned(instant, instant["normal_scene"])
    cosine = abs(float(normal @ np.asarray(axis))) / float(np.linalg.norm(normal))
    return float(np.degrees(np.arccos(min(1.0, cosine))))


def touched_wall(data: dict[str, Any], instant: dict[str, Any]) -> Array:
    """The ends, (2, 2), of the side of the outline that is nearest to the proxy among those that
    have its normal."""
    first = np.asarray(data["outline_scene_m"], dtype=float)
    along = np.roll(first, -1, axis=0) - first
    length = np.linalg.norm(along, axis=1)
    along /= length[:, None]
    to_proxy = np.asarray(instant["proxy_scene_m"]) - first
    place = np.clip((to_proxy * along).sum(axis=1), 0.0, length)
    distance = np.linalg.norm(to_proxy - place[:, None] * along, axis=1)
    slants = np.abs(along @ np.asarray(instant["normal_scene"])) > 1e-3
    nearest = int(np.where(slants, np.inf, distance).argmin())
    return np.stack([first[nearest], first[nearest] + length[nearest] * along[nearest]])


def draw(data: dict[str, Any], star: list[dict[str, float]]) -> Figure:
    """data: instants, outline_scene_m and actuated_axis_device of a4.json; lengths in m. star: the
    runs without and with A4 on the whole star, of objects.json."""
    instants = data["instants"]
    figure, axes = figures.new_figure(WIDTH_PX, _HEIGHT_PX, ncols=len(instants), sharex=True,
                                      sharey=True)
    for number, (panel, instant) in enumerate(zip(axes, instants)):
        _draw_instant(panel, data, instant, number + 1 < len(instants))
    figure.legend(handles=[
        Line2D([], [], color=MOTOR, linewidth=3, marker="D", label="the only motor"),
        Line2D([], [], color=WALL, linewidth=4, label="touched wall"),
        Line2D([], [], color=WALL, linewidth=1.5, marker=">", label="contact normal"),
        Line2D([], [], color=figures.INK, marker="o", linestyle="none", label="contact"),
    ], loc="upper left", ncols=4)
    figure.text(0.01, 8 / _HEIGHT_PX, _outcome(star), fontsize=9, linespacing=1.3)
    figure.get_layout_engine().set(rect=(0.0, 36 / _HEIGHT_PX, 1.0, 1.0 - 64 / _HEIGHT_PX))
    return figure


def _outcome(star: list[dict[str, float]]) -> str:
    return "\n".join(
        f"Whole star {name} A4: mean angle {run['mean_contact_angle_deg']:.1f}°, "
        f"{run['losses_of_contact']:.0f} losses of contact, "
        f"{1000 * run['port_work_J']:.0f} mJ returned to the hand"
        for name, run in zip(("without", "with"), star))


def _draw_instant(axes: Axes, data: dict[str, Any], instant: dict[str, Any], turns: bool) -> None:
    """The star about the contact, which is at the same place in each panel."""
    axis = np.asarray(data["actuated_axis_device"], dtype=float)
    angle = angle_deg(instant, axis)
    proxy = np.asarray(instant["proxy_scene_m"])
    star = turned(instant, np.asarray(data["outline_scene_m"]) - proxy)
    wall = turned(instant, touched_wall(data, instant) - proxy)
    normal = turned(instant, instant["normal_scene"])
    axes.fill(*star.T, facecolor=figures.GRID, alpha=0.2, linewidth=0)
    axes.plot(*np.vstack([star, star[:1]]).T, color=figures.INK, linewidth=1)
    axes.plot(*wall.T, color=WALL, linewidth=4, solid_capstyle="round", label="wall")
    _arrow(axes, -_ARROW_M * axis, _ARROW_M * axis, MOTOR, "<|-|>", 2.5)
    _arrow(axes, np.zeros(2), _NORMAL_M * normal, WALL, "-|>", 1.5)
    first = np.degrees(np.arctan2(*(axis if normal @ axis >= 0.0 else -axis)[::-1]))
    last = np.degrees(np.arctan2(*normal[::-1]))
    low, high = sorted([first, first + (last - first + 180.0) % 360.0 - 180.0])
    axes.add_patch(Arc((0.0, 0.0), 2 * _ANGLE_M, 2 * _ANGLE_M, theta1=low, theta2=high,
                       color=figures.INK))
    axes.plot(0.0, 0.0, "o", color=figures.INK, markersize=5, label="contact")
    if turns:
        middle = star.mean(axis=0)
        axes.add_patch(FancyArrowPatch(middle + [0.022, -0.008], middle + [-0.008, 0.022],
                                       connectionstyle="arc3,rad=0.6", arrowstyle="-|>",
                                       mutation_scale=9, color=figures.INK, linewidth=1.5))
    axes.set_title(f"{instant['t_s']:.2f} s", loc="left", fontsize=10)
    axes.set_title(f"{angle:.0f}°", loc="right", fontsize=12, fontweight="bold")
    axes.set_xlabel(f"force rendered:\n{100 * np.cos(np.radians(angle)):.0f} %", color=MOTOR)
    axes.set(aspect="equal", xticks=[], yticks=[])
    axes.spines[["right", "top"]].set_visible(True)


def _arrow(axes: Axes, start: Array, end: Array, colour: str, style: str, width: float) -> None:
    axes.add_patch(FancyArrowPatch(start, end, arrowstyle=style, mutation_scale=9, color=colour,
                                   linewidth=width, shrinkA=0, shrinkB=0))
    axes.update_datalim([start, end])
