"""Power over the number of people."""

from __future__ import annotations

from dataclasses import dataclass

import pandas as pd
from matplotlib.figure import Figure

from palpate.analysis.figures import COLOURS, INK, new_figure

from .answers import POWERS, Answers
from .contrasts import together
from .texts import assumption_text

# Pixels. A panel is so narrow that its texts stay readable on a phone.
_WIDTH, _HEIGHT, _LEGEND_ROW = 384, 270, 17
# Noises that differ by less than this share have the same curve: far below the error of a million
# data sets, 1e-3.
_SAME_NOISE = 1e-6


@dataclass(frozen=True)
class Panel:
    """table: one row for each curve and number of people, with label, colour (0, 1, ...),
    is_dashed, participants, power, low and high (the 95 % interval)."""

    title: str
    table: pd.DataFrame


def drawn_assumptions(answers: Answers) -> list[int]:
    """All of one or two; otherwise those with the least, a middle and the most noise. One, if the
    noise of all is equal."""
    order = answers.by_noise
    noise = answers.study.assumptions["noise"]
    if noise.max() - noise.min() <= _SAME_NOISE * noise.max():
        return order[:1]
    return order if len(order) <= 2 else [order[0], order[len(order) // 2], order[-1]]


def panels(answers: Answers) -> list[Panel]:
    """A panel for each effect, with a curve for each drawn assumption, corrected and uncorrected;
    then one for each family of several pairs, with the middle one of the drawn assumptions."""
    drawn = drawn_assumptions(answers)
    tests = answers.study.contrasts
    found = []
    for group in together(tests):
        first = tests[group[0]]
        if not first.family:
            curves = [_effect_curve(answers, drawn, i, t, group)
                      for i in range(len(drawn)) for t in reversed(group)]
            found.append(Panel(first.name, pd.concat(curves)))
        elif len(group) > 1:  # a single pair is the effect of Rotation again
            model = drawn[len(drawn) // 2]
            curves = [_curve(answers, model, t, tests[t].name, i, False)
                      for i, t in enumerate(group)]
            found.append(Panel(f"{first.family}, Holm", pd.concat(curves)))
    return found


def _effect_curve(
    answers: Answers, drawn: list[int], i: int, test: int, group: list[int]
) -> pd.DataFrame:
    """Corrected tests, the last of their group, are lines; uncorrected ones dashed, if there are
    both."""
    is_dashed = test != group[-1]
    label = answers.study.contrasts[test].correction
    if len(drawn) > 1:
        place = "least noise" if i == 0 else "most noise" if i + 1 == len(drawn) else "middle"
        label = f"{place}: {assumption_text(answers.study, drawn[i])}"
        label = "the same, uncorrected" if is_dashed else label
    return _curve(answers, drawn[i], test, label, i, is_dashed)


def _curve(
    answers: Answers, model: int, test: int, label: str, colour: int, is_dashed: bool
) -> pd.DataFrame:
    values = {name: getattr(answers, each)[model, test]
              for name, each in (("power", "share"), ("low", "low"), ("high", "high"))}
    people = range(2, answers.most + 1)
    # A label may occur twice ("the same, uncorrected"); the curve is told by its place.
    return pd.DataFrame({"curve": f"{colour} {is_dashed}", "label": label, "colour": colour,
                         "is_dashed": is_dashed, "participants": people, **values})


def draw(panel: Panel) -> Figure:
    curves = list(panel.table.groupby("curve", sort=False))
    figure, axes = new_figure(_WIDTH, _HEIGHT + _LEGEND_ROW * len(curves))
    for power in POWERS:
        axes.axhline(power, color=INK, linewidth=0.8, linestyle=":")
    for _, rows in curves:
        style = rows.iloc[0]
        colour = COLOURS[style["colour"]]
        people = rows["participants"]
        axes.fill_between(people, rows["low"], rows["high"], color=colour, alpha=0.25, linewidth=0)
        axes.plot(people, rows["power"], label=style["label"], color=colour,
                  linestyle="--" if style["is_dashed"] else "-")
    axes.set(title=panel.title, xlabel="number of people", ylabel="power",
             xlim=(0, panel.table["participants"].max()), ylim=(0, 1.02))
    axes.legend(loc="upper left", bbox_to_anchor=(-0.13, -0.19), borderaxespad=0)
    return figure
