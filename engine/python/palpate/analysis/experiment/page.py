"""The page of an analysis: what the template `experiment.html.j2` shows."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import pandas as pd
from markupsafe import Markup
from matplotlib.figure import Figure

from palpate.analysis import page
from palpate.analysis.figures import svg
from palpate.analysis.numbers import number_or_dash
from palpate.analysis.statistics import MOST_CELLS

from . import page_tables, plots, questionnaire_page, text
from .analysis import ExperimentAnalysis, OperatorAnalysis
from .experiments import ROTATION
from .findings import FindingResult
from .outcomes import PAPER_OUTCOMES, PENETRATION, TIME, Outcome
from .paper import FINDINGS, MEANS, equivalence_margin
from .primary import Primary, residuals
from .verdicts import NOT_TESTABLE, VERDICTS

NOT_DRAWN = "no participant has completed trials in all its conditions"


def report_page(
    analysis: ExperimentAnalysis, file: str, limit_s: float
) -> tuple[str, list[str]]:
    """The document, and a warning for each figure that could not be drawn. file: as the user named
    it."""
    warnings: list[str] = []
    operators = [_operator(each, warnings) for each in analysis.operators]
    title = "The paper\u2019s experiment"
    title += f" with {text.who(analysis)}" if analysis.has_simulated else ": analysis of trials"
    html = page.page(
        "experiment.html.j2",
        title=title,
        answer=_answer(analysis),
        operators=operators,
        differences=page_tables.differences(analysis) if analysis.variants > 1 else None,
        questionnaires=questionnaire_page.section(analysis.questionnaires),
        is_simulated=analysis.has_simulated,
        has_adaptations=any(
            e.is_simulated and e.variant.view == "still" for e in analysis.experiments
        ),
        margins=[
            f"{o.name} {number_or_dash(equivalence_margin(o))} {o.unit}".rstrip()
            for o in PAPER_OUTCOMES
        ],
        facts=_facts(analysis, file, limit_s),
    )
    return html, warnings


# The answer


def _answer(analysis: ExperimentAnalysis) -> dict[str, Any]:
    leading = analysis.operators[0]
    counts = text.verdict_counts(leading)
    lists = [(verdict, text.findings_with(leading, verdict)) for verdict in VERDICTS]
    differing = analysis.differing()
    return {
        "findings": len(FINDINGS),
        "counts": text.verdict_counts_text(leading),
        "whose": leading.whose_trials,
        "lists": [each for each in lists if each[0] != NOT_TESTABLE or counts[NOT_TESTABLE]],
        "columns": text.columns_text(analysis),
        "flips": [FINDINGS[i].name for i in differing],
        "are_followings": not (analysis.has_people or analysis.variants > 1),
        "by_construction": [
            (finding.name, reason) for finding, reason in text.built_so(analysis).items()
        ],
        "spread": _spread(analysis),
        "heads": [(e.name, e.is_simulated) for e in analysis.experiments],
        "rows": [
            {
                "finding": finding,
                "printed": _lines(finding.printed),
                "flips": i in differing,
                "is_built_so": finding in text.built_so(analysis),
                "results": [_result(each.findings[i]) for each in analysis.operators],
            }
            for i, finding in enumerate(FINDINGS)
        ],
    }


def _spread(analysis: ExperimentAnalysis) -> dict[str, Any] | None:
    """The scatter of the first simulated persons, in mm by force; None without penetration."""
    for each in analysis.operators:
        primary = each.primary.get(PENETRATION)
        if each.experiment.is_simulated and primary:
            sds = pd.DataFrame(100.0 * primary.cells.mean(axis=2)).std()
            by_force = zip(each.experiment.levels["Haptic"], sds)
            words = [f"{level} {number_or_dash(sd)}" for level, sd in by_force]
            return {"whose": each.experiment.name, "by_force": words}
    return None


def _lines(words: str) -> list[page_tables.Cell]:
    """Statistics and means on a line each, without a line break within a p value. What is the
    paper's has the quiet colour."""
    words = words.replace("p = ", "p\u00a0=\u00a0").replace("p < ", "p\u00a0<\u00a0")
    return [page_tables.quiet(line, line.startswith("the paper ")) for line in words.split("; ")]


def _result(result: FindingResult) -> dict[str, Any]:
    papers = result.by_the_papers_test
    return {
        "verdict": result.verdict,
        "kind": dict(zip(VERDICTS, ("good", "bad", "warn", "quiet")))[result.verdict],
        "because": _lines(result.because),
        "as_paper": papers if papers != result.verdict else None,
    }


# An operator


def _operator(each: OperatorAnalysis, warnings: list[str]) -> dict[str, Any]:
    experiment = each.experiment
    whose = each.whose_trials
    anchor = re.sub(r"[^A-Za-z0-9.-]", "", experiment.name.replace(" ", "-").replace("+", "p"))
    angle = each.angle_of_uah
    outcomes = [(primary.outcome.heading, primary) for primary in each.primary.values()]
    return {
        "title": whose[0].upper() + whose[1:],
        "whose": whose,
        "anchor": anchor,
        "counts": experiment.total,
        "missing": experiment.missing,
        "planned": experiment.total["done"] + experiment.missing,
        "participants": len(experiment.participants),
        "limit": number_or_dash(experiment.limit_s),
        "notes": each.notes,
        "paper_problem": each.paper_problem,
        "has_paper": each.paper is not None,
        "figure_6": [
            _panel(each, _of_haptic(each, o), anchor, name, f"Figure 6, {o.name}", warnings)
            for o, name in ((TIME, "time"), (PENETRATION, "depth"))
        ],
        "by_rotation": [_paper_by_rotation(outcome) for outcome in (TIME, PENETRATION)],
        "figure_7": _figure_7(each, angle, anchor, warnings) if angle else None,
        "means": page_tables.trial_means_table(experiment),
        "participant_means": page_tables.participant_means(each),
        "effects": [(heading, page_tables.effects(each, p)) for heading, p in outcomes],
        "angle_effects": page_tables.angle_effects(angle) if angle else None,
        "pairs": [(heading, page_tables.pairs(p)) for heading, p in outcomes],
        "plsd": [
            (outcome.heading, page_tables.plsd(outcome, pairs))
            for outcome, pairs in (each.paper.plsd.items() if each.paper else ())
        ],
        "manova": page_tables.manova(each),
        "variances": page_tables.variances(each),
        "most_cells": MOST_CELLS,
        "loss_rates": page_tables.loss_rates(each),
        "dispersion": number_or_dash(each.loss_rates.dispersion) if each.loss_rates else "",
        "loss_trials": each.loss_rates.trials if each.loss_rates else 0,
        "residuals": _residuals(each, anchor),
        "missing_trials": page_tables.missing(experiment),
    }


def _panel(
    each: OperatorAnalysis,
    draw: Callable[[], Figure] | None,
    anchor: str,
    name: str,
    title: str,
    warnings: list[str],
) -> Markup | str:
    """The picture, or a sentence in its place."""
    whose = f"{title}, {each.whose_trials}"
    if draw is None:
        warnings.append(f"{whose}: is not drawn: {NOT_DRAWN}")
        return f"{title}: no diagram: {NOT_DRAWN}"
    identifier = re.sub(r"[^A-Za-z0-9-]", "-", anchor)
    return svg(draw(), f"{identifier}-{name}", whose)


def _residuals(each: OperatorAnalysis, anchor: str) -> list[Markup | str]:
    """Pictures of the residuals of the paper's outcomes."""
    pictures: list[Markup | str] = []
    identifier = re.sub(r"[^A-Za-z0-9-]", "-", anchor)
    for outcome in PAPER_OUTCOMES:
        rest = residuals(each.experiment, outcome)
        if outcome in each.primary and len(rest):
            figure = plots.residual_quantiles(rest, outcome, each.whose_trials)
            name = f"Residuals, {outcome.name}, {each.whose_trials}"
            pictures.append(svg(figure, f"{identifier}-residuals-{outcome.key}", name))
    return pictures


def _of_haptic(each: OperatorAnalysis, outcome: Outcome) -> Callable[[], Figure] | None:
    """None if no participant has completed trials in all conditions."""
    primary, levels = each.primary.get(outcome), each.experiment.levels
    if primary is None or primary.mean(levels["Haptic"][0], levels["Rotation"][0]) is None:
        return None
    means = primary.means[(primary.means[["Haptic", "Rotation"]] != "all").all(axis=1)]
    return lambda: plots.by_rotation_and_haptic(means, outcome, levels, each.whose_trials)


def _paper_by_rotation(outcome: Outcome) -> str:
    """ "total time NoR 25.14 (12.041), R 29.15 (15.972) s"."""
    means = ", ".join(f"{level} {page_tables.mean_sd(MEANS[outcome, level])}" for level in ROTATION)
    return f"{outcome.name} {means} {outcome.unit}"


def _figure_7(
    each: OperatorAnalysis, angle: Primary, anchor: str, warnings: list[str]
) -> dict[str, Any]:
    whose = "simulated operators" if each.experiment.is_simulated else "people of this file"
    draw = None
    if len(angle.means):
        label = f"{whose}, 95 % interval"
        draw = lambda: plots.angle_by_rotation(angle.means, each.whose_trials, label)  # noqa: E731
    panel = _panel(each, draw, anchor, "angle", "Figure 7, contact angle of UaH", warnings)
    return {"panel": panel, "table": page_tables.angle_means(each.experiment, angle)}


def _facts(analysis: ExperimentAnalysis, file: str, limit_s: float) -> list[tuple[str, str]]:
    facts = [("File", file)]
    for kind, experiments in text.kinds(analysis):
        is_simulated = experiments[0].is_simulated
        of = f", {kind}" if len(text.kinds(analysis)) > 1 else ""
        is_several = len({experiment.variant for experiment in experiments}) > 1
        trials = f"{text.trials_text(experiments)} (practice is left out)"
        names = "Followings" if not is_several else "Followings and settings"
        facts += [
            (f"Trials{of}", trials),
            (f"Missing trials{of}", text.missing_text(experiments)),
            *_row(f"Repeated attempts{of}", text.repeated_text(experiments)),
            (
                "Operators" if is_simulated else "Participants",
                str(text.most_participants(experiments)),
            ),
            (names, text.names_of(experiments) if is_simulated or is_several else ""),
        ]
    pilots = f"{analysis.pilot_rows} rows are left out" if analysis.pilot_rows else ""
    facts += _row("Pilot run", pilots)
    blocks = len(analysis.experiments[0].levels["Trial"])
    return [*facts, ("Blocks", str(blocks)), ("Time limit", f"{number_or_dash(limit_s)} s")]


def _row(name: str, value: str) -> list[tuple[str, str]]:
    """None without a value."""
    return [(name, value)] if value else []
