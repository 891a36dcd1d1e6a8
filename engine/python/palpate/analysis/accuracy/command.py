"""`accuracy FOLDER`: the page and the figures of what `palpate accuracy` measured."""

from __future__ import annotations

import argparse
import pathlib
from collections.abc import Sequence
from typing import Any

from palpate.analysis import figures, page
from palpate.analysis.accuracy import figures as drawing
from palpate.analysis.accuracy import results, scene, texts, zones
from palpate.analysis.accuracy.results import Knob, Results
from palpate.analysis.numbers import human, short_number
from palpate.analysis.report import Report


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("results", type=pathlib.Path,
                        help="folder with accuracy.json and stiffness.svg")


def run(arguments: argparse.Namespace) -> Report:
    """Make report.html, and a diagram for each knob, named after it."""
    measured = results.read(arguments.results / "accuracy.json")
    panels = zones.panels(arguments.results / "stiffness.svg")
    chapters, files = [], {}
    for n, knob in enumerate(measured.knobs):
        chapter = _chapter(knob, f"knob-{n + 1}")
        chapters.append(chapter)
        files[f"{knob.facts['name']}.svg"] = drawing.side_by_side(chapter["figures"],
                                                                  knob.facts["title"])
    files["report.html"] = page.page("accuracy.html.j2", **_content(measured, panels, chapters))
    return Report(files)


def _content(measured: Results, panels: Sequence[Any], chapters: list[dict[str, Any]]
             ) -> dict[str, Any]:
    facts = measured.facts
    table = drawing.overview_table(measured.knobs)
    picture = None if table.empty else figures.svg(
        drawing.overview(table), "overview", "Error and time of the recommended levels")
    stiffness = facts["stiffness"] | {"rate": human(facts["stiffness"]["rate_Hz"], "Hz")}
    return {
        "title": "What accuracy costs in time",
        "advice": facts["advice"],
        "overview": picture,
        "overview_knobs": len(table),
        "overview_has_zero": bool((table.filter(regex="^(error|time)_(default|best)$") <= 0.0)
                                  .to_numpy().any()),
        "repeats": facts["repeats"],
        "scene": facts["scene"] and scene.content(facts["scene"]),
        "stiffness": stiffness,
        "zones": panels[:-1],
        "zones_legend": panels[-1],
        "chapters": chapters,
        "presets": [preset["label"] for preset in measured.knobs[0].facts["presets"]]
        if measured.knobs else [],
        "facts": [(fact["name"], fact["value"]) for fact in facts["facts"]],
    }


def _chapter(knob: Knob, anchor: str) -> dict[str, Any]:
    facts = knob.facts
    curves = f"{len(knob.methods)} curve" + ("" if len(knob.methods) == 1 else "s")
    names = [f"{facts['title']}: {facts['error']['name']} against {facts[of]['name']}, {curves}"
             for of in ("time", "level")]
    pictures = [figures.svg(figure, f"{anchor}-{panel}", name) for figure, panel, name in
                zip(drawing.work_precision(knob), "tl", names)]
    default, best = knob.row("default"), knob.row("recommended")
    return {
        "anchor": anchor,
        "title": facts["title"],
        "paragraphs": [("Workload", texts.whole_sentence(facts["workload"])),
                       ("Errors are against", texts.whole_sentence(facts["reference"])),
                       ("Floor", texts.whole_sentence(facts["floor_is"]))],
        "figures": pictures,
        "caption": texts.caption(knob),
        "verdicts": [("Recommended", texts.recommendation(knob)),
                     ("Default", texts.default_verdict(knob))],
        "failures": texts.failures(knob),
        "has_choice": knob.has_choice,
        "default_on_front": facts["default_on_front"],
        "behind": f"{texts.factor(facts['default_behind'])} behind {facts['better_than_default']}",
        "default_because": facts["default_because"],
        "recommended": "-" if not knob.has_choice else "none" if best is None
        else texts.place(knob, best),
        "default": texts.place(knob, default) if default is not None else "-",
        "presets": [(texts.error(knob, level), texts.time(knob, level)) if level["counts"] else None
                    for _, level in knob.presets.iterrows()],
        "orders": texts.order_summary(knob),
        "heads": [facts["error"]["name"], facts["time"]["name"], facts["level"]["name"]],
        "methods": _methods(knob),
    }


def _methods(knob: Knob) -> list[dict[str, Any]]:
    """The rows of the table of levels: each method, then the presets."""
    rows = [{"heading": texts.method_heading(knob, method),
             "levels": [_level(knob, level) for _, level in
                        knob.levels[knob.levels["method"] == m].iterrows()]}
            for m, method in enumerate(knob.methods)]
    presets = [_level(knob, level) for _, level in knob.presets.iterrows()]
    return rows + [{"heading": "presets, at the default", "levels": presets}]


def _level(knob: Knob, level: Any) -> dict[str, Any]:
    is_preset = level["method"] < 0
    was_measured = level["repeats"] > level["failures"]
    is_best = not is_preset and knob.has_choice and level["is_recommended"]
    marks = [("recommended", "best", is_best),
             ("default", "link", not is_preset and level["is_default"]),
             ("front", "quiet", not is_preset and knob.has_choice and level["on_front"]),
             ("floor", "warn", not is_preset and level["at_floor"]),
             ("failed" if is_preset else f"{level['failures']} of {level['repeats']} failed", "bad",
              not level["counts"])]
    spreads = [texts.spread(level, of, knob.facts[of]["unit"]) if was_measured else None
               for of in ("error", "time")]
    return {
        "label": level["label"],
        "marks": [(text, kind) for text, kind, has in marks if has],
        "is_best": is_best,
        "spreads": spreads,
        "at_floor": texts.FLOOR if level["at_floor"] else "",
        "iterations": short_number(level["iterations"]) if was_measured else "-",
        "value": "" if is_preset else human(level["value"], knob.facts["level"]["unit"]),
    }
