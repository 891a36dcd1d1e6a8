"""The report of a study: one page for readers."""

from __future__ import annotations

from typing import Any

from markupsafe import Markup

from palpate.analysis.figures import svg
from palpate.analysis.numbers import number_or_dash
from palpate.analysis.page import page

from . import figures, texts
from .answers import POWERS, Answers


def page_of(answers: Answers, notes: list[str]) -> str:
    """An HTML document that needs no other file."""
    study = answers.study
    panels = figures.panels(answers)
    pictures = [svg(figures.draw(panel), f"p{i}", f"power of {panel.title}")
                for i, panel in enumerate(panels)]
    drawn = [texts.assumption_text(study, model) for model in figures.drawn_assumptions(answers)]
    return page(
        "power.html.j2",
        title=f"How many people: {study.measure.outcome.name}",
        number=texts.answer_number(answers),
        rest=texts.answer_rest(answers),
        sets=answers.sets,
        heads=[f"people for a power of {power}" for power in POWERS] + texts.heads(answers)[-1:],
        lines=[[_cell(text) for text in line] for line in texts.lines(answers)],
        notes=notes,
        has_one_noise=answers.has_one_noise,
        most=answers.most,
        pictures=pictures,
        drawn=drawn,
        assumptions=len(study.assumptions),
        grids=_grids(answers),
        pilot=_pilot(answers),
        facts=texts.facts(answers),
    )


def _cell(text: str) -> str | Markup:
    """The interval of a number, in parentheses, is smaller and stays on one line."""
    value, parenthesis, interval = text.partition("(")
    if not parenthesis:
        return text
    return Markup('{}<span class="interval">{}</span>').format(value, f"({interval}")


def _grids(answers: Answers) -> list[dict[str, Any]]:
    """For each test, and each source of the error: the smallest numbers, w downwards and u to the
    right. Empty with one assumption."""
    assumed = answers.study.assumptions
    us, ws = sorted(set(assumed["share_u"])), sorted(set(assumed["share_w"]))
    place = {(source, u, w): model for model, (source, u, w) in enumerate(
        assumed[["error_from", "share_u", "share_w"]].itertuples(index=False))}

    def cell(source: str, u: float, w: float, t: int) -> str | Markup:
        model = place.get((source, u, w))
        if model is None:
            return ""
        numbers = (texts.people_text(answers, n[model, t], t) for n in answers.people.values())
        return Markup('{} <span class="spread">/ {}</span>').format(*numbers)

    return [
        {
            "test": test.title,
            "heads": ["share of w", *(f"u {number_or_dash(u)}" for u in us)],
            "tables": [
                (source, [[number_or_dash(w), *(cell(source, u, w, t) for u in us)] for w in ws])
                for source in sorted(set(assumed["error_from"]))
            ],
        }
        for t, test in enumerate(answers.study.contrasts)
        if len(assumed) > 1 and not answers.is_null[t]
    ]


def _pilot(answers: Answers) -> dict[str, Any] | None:
    study, pilot = answers.study, answers.study.pilot
    if pilot is None:
        return None
    parts = {"u": ("u, between people", "p"), "w": ("w, people x conditions", "pc"),
             "e": ("e, trials", "e")}
    names = study.measure.design.conditions
    means = [f"{name} {number_or_dash(mean)}" for name, mean in zip(names, pilot.means)]
    return {
        "parts": [
            [title, number_or_dash(pilot.mean_squares[part]), pilot.df[part],
             number_or_dash(pilot.raw[name]), number_or_dash(pilot.variances[name])]
            for name, (title, part) in parts.items()
        ],
        "conditions": len(names),
        "m": number_or_dash(pilot.m),
        "means": ", ".join(means),
        "pairs": texts.pilot_pairs(study),
    }
