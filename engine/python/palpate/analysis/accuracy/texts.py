"""The sentences of the page of accuracy. All are plain text."""

from __future__ import annotations

import math
from typing import Any

import pandas as pd

from palpate.analysis.accuracy.results import Knob
from palpate.analysis.numbers import display_unit, human, short_number

FLOOR = "\u2264 "  # an error at the floor is at most the floor


def sentence(text: str) -> str:
    """The text with a full stop, if it has no end."""
    return text if text.endswith((".", "!", "?")) else text + "."


def whole_sentence(text: str) -> str:
    """The text as a sentence of its own; empty for an empty one."""
    return sentence(text[0].upper() + text[1:]) if text else ""


def order_number(order: float) -> str:
    """A fitted order with two decimals."""
    return f"{0.0 if abs(order) < 0.005 else order:.2f}"


def error(knob: Knob, level: pd.Series) -> str:
    """The error of a level with its unit, "≤" at the floor."""
    return (FLOOR if level["at_floor"] else "") + human(level["error"], knob.facts["error"]["unit"])


def time(knob: Knob, level: pd.Series) -> str:
    """The time of a level with its unit."""
    return human(level["time"], knob.facts["time"]["unit"])


def spread(level: pd.Series, of: str, unit: str) -> tuple[str, str]:
    """Median with its unit, and the quartiles in this unit: ("278 ns", "[270, 290]")."""
    low, high = level[of + "_low"], level[of + "_high"]
    median = human(level[of], unit)
    if low == high:
        return median, ""
    factor, _ = display_unit(level[of], unit)
    return median, f"[{short_number(low * factor)}, {short_number(high * factor)}]"


def factor(times: float | None) -> str:
    """By how much something is worse, with two digits; None: without bound."""
    if times is None:
        return "without bound"
    percent = math.floor(100.0 * (times - 1.0) + 0.5)
    if percent < 1:
        return "less than 1 %"
    if percent < 100:
        return f"{percent} %"
    digit = 10.0 ** (math.floor(math.log10(times)) - 1)
    return short_number(math.floor(times / digit + 0.5) * digit) + " times"


def place(knob: Knob, level: pd.Series) -> str:
    """A level, with its method if the knob has several."""
    if len(knob.methods) == 1:
        return str(level["label"])
    return f"{knob.methods[level['method']]['name']}, {level['label']}"


def order_summary(knob: Knob) -> list[str]:
    """Fitted and expected order of each method that has one."""
    lines = []
    for method in knob.methods:
        fitted, expected = method["order"], method["expected_order"]
        if fitted is None and expected is None:
            continue
        text = f"{method['name']}: " if len(knob.methods) > 1 else ""
        text += "not fitted" if fitted is None else order_number(fitted)
        lines.append(text + ("" if expected is None else f"\u00a0/\u00a0{short_number(expected)}"))
    return lines or ["-"]


def method_heading(knob: Knob, method: dict[str, Any]) -> str:
    """A method with its order and its floor."""
    text = str(method["name"])
    fitted, expected = method["order"], method["expected_order"]
    if fitted is not None:
        text += ", order " + order_number(fitted)
    if expected is not None:
        text += (" (theory " if fitted is not None else ", order not fitted (theory ")
        text += short_number(expected) + ")"
    if method["floor"] > 0.0:
        text += ", floor " + human(method["floor"], knob.facts["error"]["unit"])
    return text


def _reason(knob: Knob, level: pd.Series) -> str:
    facts = knob.facts
    if facts["decided_by"]:
        return (f'The knob "{facts["decided_by"]}" decides, because this knob measures only a part '
                "of the error.")
    among = " of the methods at this level" if facts["levels_are_given"] else ""
    bound = math.inf if facts["enough"] is None else facts["enough"]
    enough = human(bound, facts["error"]["unit"])
    if level["error"] > bound:
        text = f"Its error is the smallest{among}; none is down to {enough}"
    elif level["is_default"]:
        text = (f"The default: no level{among} with an error of at most {enough} is clearly "
                "quicker, or as quick and clearly more accurate")
    else:
        text = (f"It is the quickest{among} with an error of at most {enough}, or as quick and "
                "more accurate")
    because = facts["enough_because"]
    return f"{text}: {sentence(because)}" if because else text + "."


def recommendation(knob: Knob) -> str:
    """The recommended level, its figures and the reason."""
    if not knob.has_choice:
        return whole_sentence(knob.facts["enough_because"])
    level, undecided = knob.row("recommended"), knob.row("undecided")
    if undecided is not None:
        figures = f"{error(knob, undecided)}, {time(knob, undecided)}"
        return (f"none: {place(knob, undecided)} ({figures}) and the default overlap within their "
                "quartiles, in error and in time. The default stays; measure again on an idle "
                "machine.")
    if level is None:
        return "none: every level failed"
    return (f"{place(knob, level)} ({error(knob, level)}, {time(knob, level)}). "
            f"{_reason(knob, level)}")


def default_verdict(knob: Knob) -> str:
    """Whether the default is on the front; if not, by how much and why it is the default."""
    level = knob.row("default")
    if not knob.has_choice or level is None:
        return ""
    if knob.facts["default_on_front"]:
        return f"{place(knob, level)}, on the front."
    behind, better = knob.facts["default_behind"], knob.facts["better_than_default"]
    text = (f"{place(knob, level)}, not on the front: {better} is better in time or error, by "
            f"{'any factor' if behind is None else factor(behind)}, and worse in neither.")
    because = knob.facts["default_because"]
    return f"{text} Why it is the default: {sentence(because)}" if because else text


def failures(knob: Knob) -> list[str]:
    """A line for each level and preset of which a repeat failed."""
    def line(name: str, level: pd.Series) -> str:
        return (f"{name}: {level['failures']} of {level['repeats']} repeats, {level['failure']}")

    failed = knob.levels[~knob.levels["counts"]]
    lines = [line(f"{knob.methods[level['method']]['name']}, {level['label']}", level)
             for _, level in failed.iterrows()]
    presets = knob.presets[~knob.presets["counts"]]
    return lines + [line(f"preset {level['label']}", level) for _, level in presets.iterrows()]


def caption(knob: Knob) -> str:
    """What the figures of a knob show, with n and the meaning of whiskers."""
    facts, levels, presets = knob.facts, knob.levels, knob.presets
    text = f"Points are medians of {levels['repeats'].iloc[0]} repeats, whiskers quartiles. "
    if not knob.has_choice:
        text += "Neither level nor curve is a choice: labels name the curves. "
    elif facts["levels_are_given"]:
        text += "The level is not a choice: grey rings mark the best curves at each level. "
    elif facts["methods_are_given"]:
        text += "The curve is not a choice: grey rings mark the Pareto front of each curve. "
    else:
        text += "Grey: the Pareto front and its levels. "
    counting = levels[levels["counts"]]
    if levels["at_floor"].any():
        text += "Open points are at the floor. "
        if counting["at_floor"].all():
            text += "All levels are: they differ in time alone. "
    shown = [counting[["error", "time", "value"]], presets[presets["counts"]][["error", "time"]]]
    if not (counting["error"] > 0.0).any():
        text += "No level has an error above 0. "
    elif any((numbers <= 0.0).to_numpy().any() for numbers in shown):
        text += "A grey band holds values of exactly 0, which a logarithmic axis cannot show. "
    if len(counting) < len(levels):
        text += "Failed levels are not drawn; they are listed below. "
    return text.rstrip()
