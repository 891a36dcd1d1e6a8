"""The page of an analysis: what the template `experiment.html.j2` shows."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd
from markupsafe import Markup
from matplotlib.figure import Figure

from palpate.analysis import page
from palpate.analysis.figures import svg
from palpate.analysis.numbers import (
    as_printed,
    df_text,
    number_or_dash,
    p_number,
    with_decimals,
    with_unit,
)
from palpate.analysis.statistics import SIGNIFICANCE, effect_name

from . import plots, text
from .analysis import ExperimentAnalysis, OperatorAnalysis
from .experiments import ROTATION, Experiment
from .findings import VERDICTS, FindingResult
from .outcomes import ANGLE, PENETRATION, TIME, Outcome
from .paper import FINDINGS, MANOVA, MEANS, F
from .primary import Primary
from .tables import levels_of_means, paper_mean, trial_means

Cell = str | dict[str, str] | int
Row = list[Cell] | str  # a text: the heading of the rows below it
MINUS, PLUS_MINUS = "\u2212", "\u00b1"

FIXED_HEADS = ["F", "df", "p", "partial \u03b7\u00b2", "n"]
REPEATED_HEADS = ["F", "df", "p", "GG \u03b5", "GG p", "gen. \u03b7\u00b2", "n"]
FIXED_GROUP = ("as the paper did it (n trials)", len(FIXED_HEADS))
REPEATED_GROUP = ("repeated measures (n participants)", len(REPEATED_HEADS))
NOT_DRAWN = "figure: no participant has completed trials in all its conditions"


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
        differences=_differences(analysis) if analysis.variants > 1 else None,
        is_simulated=analysis.has_simulated,
        has_adaptations=any(
            e.is_simulated and e.variant.view == "still" for e in analysis.experiments
        ),
        facts=_facts(analysis, file, limit_s),
    )
    return html, warnings


# Cells


def strong(words: str, is_strong: bool) -> Cell:
    return {"kind": "strong", "text": words} if is_strong else words


def of_paper(words: str) -> Cell:
    """In the quiet colour."""
    return {"kind": "quiet", "text": words} if words else ""


def _p(p: float) -> Cell:
    """In bold if it is significant."""
    return strong(p_number(p), p < SIGNIFICANCE)


def _df(test: Any) -> str:
    return f"{df_text(test['df1'])}, {df_text(test['df2'])}"


def _interval(mean: float, half_width: float, decimals: int) -> str:
    """ "27.1 ± 0.5"; without the half width if it is NaN."""
    words = with_decimals(mean, decimals)
    return words if np.isnan(half_width) else (
        f"{words} {PLUS_MINUS} {with_decimals(half_width, decimals)}"
    )


def _mean_sd(mean_sd: tuple[float, float] | None) -> str:
    """The paper's: "27.5 (15)"."""
    return "{} ({})".format(*map(as_printed, mean_sd)) if mean_sd else ""


def _table(heads: list[str], rows: list[Row], groups: list[tuple[str, int]] | None = None) -> Any:
    return {"heads": heads, "rows": rows, "groups": groups or []}


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
        "lists": [each for each in lists if each[0] != VERDICTS[2] or counts[VERDICTS[2]]],
        "columns": text.columns_text(analysis),
        "flips": [FINDINGS[i].name for i in differing],
        "are_followings": not (analysis.has_people or analysis.variants > 1),
        "heads": [(e.name, e.is_simulated) for e in analysis.experiments],
        "rows": [
            {
                "finding": finding,
                "printed": _lines(finding.printed),
                "flips": i in differing,
                "results": [_result(each.findings[i]) for each in analysis.operators],
            }
            for i, finding in enumerate(FINDINGS)
        ],
    }


def _lines(words: str) -> list[str]:
    """Statistics and means on a line each, without a line break within a p value."""
    words = words.replace("p = ", "p\u00a0=\u00a0").replace("p < ", "p\u00a0<\u00a0")
    return words.split("; ")


def _result(result: FindingResult) -> dict[str, Any]:
    differs = result.as_paper is not None and result.as_paper != result.verdict
    return {
        "verdict": result.verdict,
        "kind": dict(zip(VERDICTS, ("good", "bad", "quiet")))[result.verdict],
        "because": _lines(result.because),
        "as_paper": result.as_paper if differs else None,
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
            _panel(each, _of_haptic(each, outcome), anchor, name, f"Figure 6, {outcome.name}", warnings)
            for outcome, name in ((TIME, "time"), (PENETRATION, "depth"))
        ],
        "by_rotation": [_paper_by_rotation(outcome) for outcome in (TIME, PENETRATION)],
        "figure_7": _figure_7(each, angle, anchor, warnings) if angle else None,
        "means": _trial_means(experiment),
        "participant_means": _participant_means(each),
        "effects": [(heading, _effects(each, primary)) for heading, primary in outcomes],
        "angle_effects": _angle_effects(angle) if angle else None,
        "pairs": [(heading, _pairs(primary)) for heading, primary in outcomes],
        "plsd": _plsd(each),
        "manova": _manova(each),
        "missing_trials": _missing(experiment),
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


def _of_haptic(each: OperatorAnalysis, outcome: Outcome) -> Callable[[], Figure] | None:
    """None if no participant has completed trials in all conditions."""
    primary, levels = each.primary.get(outcome), each.experiment.levels
    if primary is None or primary.mean(levels["Haptic"][0], levels["Rotation"][0]) is None:
        return None
    means = primary.means[(primary.means[["Haptic", "Rotation"]] != "all").all(axis=1)]
    return lambda: plots.by_rotation_and_haptic(means, outcome, levels, each.whose_trials)


def _paper_by_rotation(outcome: Outcome) -> str:
    """ "total time NoR 25.14 (12.041), R 29.15 (15.972) s"."""
    means = ", ".join(f"{level} {_mean_sd(MEANS[outcome, level])}" for level in ROTATION)
    return f"{outcome.name} {means} {outcome.unit}"


def _figure_7(
    each: OperatorAnalysis, angle: Primary, anchor: str, warnings: list[str]
) -> dict[str, Any]:
    whose = "simulated operators" if each.experiment.is_simulated else "people of this file"
    draw = None
    if len(angle.means):
        label = f"{whose}, 95 % interval"
        draw = lambda: plots.angle_by_rotation(angle.means, each.whose_trials, label)  # noqa: E731
    rows: list[Row] = []
    for level in each.experiment.levels["Rotation"]:
        mean = angle.mean(rotation=level)
        ours = "-" if mean is None else f"{_interval(mean['mean'], mean['half_width'], 1)} deg"
        rows.append([level, ours, f"{_mean_sd(MEANS[ANGLE, level])} deg"])
    heads = ["rotation", f"this file, mean {PLUS_MINUS} 95 % interval", "the paper, mean (sd)"]
    panel = _panel(each, draw, anchor, "angle", "Figure 7, contact angle of UaH", warnings)
    return {"panel": panel, "table": _table(heads, rows)}


def _level_name(levels: dict[str, str]) -> str:
    return ", ".join(levels.values()) or "all trials"


def _trial_means(experiment: Experiment) -> dict[str, Any]:
    heads = ["level", "n trials"]
    levels = levels_of_means(experiment)
    rows: list[list[Cell]] = [[_level_name(at), experiment.done(at)] for at in levels]
    for outcome in experiment.reported_outcomes():
        means = trial_means(experiment, outcome)
        papers = [
            paper_mean(experiment, outcome, m["Haptic"], m["Rotation"], m["Object"])
            for _, m in means.iterrows()
        ]
        heads.append(with_unit(outcome.name, outcome.unit))
        heads += ["the paper"] if any(papers) else []
        for row, (_, mean), paper in zip(rows, means.iterrows(), papers):
            words = "{} ({})".format(
                *(with_decimals(mean[name], outcome.decimals) for name in ("mean", "sd"))
            )
            row.append(words if mean["n"] == row[1] else f"{words}, n {mean['n']}")
            if any(papers):
                row.append(of_paper(_mean_sd(paper)))
    return _table(heads, list(rows))


def _participant_means(each: OperatorAnalysis) -> dict[str, Any]:
    primaries = each.primary.values()
    rows: list[Row] = []
    for at in levels_of_means(each.experiment):
        if not at or "Object" in at:
            continue
        row: list[Cell] = [_level_name(at)]
        for primary in primaries:
            mean = primary.mean(**{factor.lower(): level for factor, level in at.items()})
            row.append(
                "-"
                if mean is None
                else _interval(mean["mean"], mean["half_width"], primary.outcome.decimals)
                + f", n {mean['participants']}"
            )
        rows.append(row)
    heads = [with_unit(primary.outcome.name, primary.outcome.unit) for primary in primaries]
    return _table(["level", *heads], rows)


def _manova(each: OperatorAnalysis) -> dict[str, Any] | None:
    if each.paper is None:
        return None
    rows: list[Row] = []
    for term, test in each.paper.manova.iterrows():
        printed = MANOVA.get(term)  # type: ignore[call-overload]
        papers = (f"{printed[0]:.3f}", f"{printed[1]:.3f}", df_text(printed[2])) if printed else ()
        rows.append(
            [
                effect_name(term),  # type: ignore[arg-type]
                *map(of_paper, papers or ("", "", "")),
                with_decimals(test["wilks_lambda"], 3),
                number_or_dash(test["f"]),
                _df(test),
                _p(test["p"]),
                each.paper.trials,
            ]
        )
    wilks = "Wilks\u2019 \u03bb"
    heads = ["effect", wilks, "F", "df2", wilks, "F", "df", "p", "n"]
    return _table(heads, rows, [("", 1), ("the paper", 3), ("this file (n trials)", 5)])


def _paper_f(outcome: Outcome, term: Any) -> Cell:
    f = F.get((outcome, term))
    return of_paper(as_printed(f[0]) + (f" ({f[1]})" if f[1] else "")) if f else ""


def _repeated(effect: pd.Series[Any]) -> list[Cell]:
    if np.isnan(effect["f"]):
        return [*["-"] * 6, int(effect["participants"])]
    return [
        number_or_dash(effect["f"]),
        _df(effect),
        p_number(effect["p"]),
        with_decimals(effect["epsilon"], 3),
        _p(effect["p_gg"]),
        with_decimals(effect["generalized_eta2"], 3),
        int(effect["participants"]),
    ]


def _effects(each: OperatorAnalysis, primary: Primary) -> dict[str, Any]:
    anova = each.paper.anovas.get(primary.outcome) if each.paper else None
    rows: list[Row] = []
    for _, effect in primary.effects.iterrows():
        row: list[Cell] = [effect_name(effect["term"])]
        if anova is not None and each.paper:
            row.append(_paper_f(primary.outcome, effect["term"]))
            if effect["term"] in anova.index:
                test = anova.loc[[effect["term"]]].iloc[0]
                row += [
                    number_or_dash(test["f"]),
                    _df(test),
                    _p(test["p"]),
                    with_decimals(test["partial_eta2"], 3),
                    each.paper.trials,
                ]
            else:
                row += ["-"] * len(FIXED_HEADS)
        rows.append(row + _repeated(effect))
    if anova is None:
        return _table(["effect", *REPEATED_HEADS], rows, [("", 1), REPEATED_GROUP])
    heads = ["effect", "F", *FIXED_HEADS, *REPEATED_HEADS]
    return _table(heads, rows, [("", 1), ("the paper", 1), FIXED_GROUP, REPEATED_GROUP])


def _angle_effects(angle: Primary) -> dict[str, Any]:
    rows: list[Row] = [
        [effect_name(effect["term"]), _paper_f(ANGLE, effect["term"]), *_repeated(effect)]
        for _, effect in angle.effects.iterrows()
    ]
    heads = ["effect", "F(1, 9)", *REPEATED_HEADS]
    return _table(heads, rows, [("", 1), ("the paper", 1), REPEATED_GROUP])


def _pairs(primary: Primary) -> dict[str, Any] | None:
    rows: list[Row] = []
    for family, pairs in primary.pairs.groupby("family", sort=False):
        rows.append(str(family))
        for _, pair in pairs.iterrows():
            rows.append(
                [
                    pair["pair"],
                    _interval(
                        pair["difference"], pair["half_width"], primary.outcome.decimals + 1
                    ),
                    number_or_dash(pair["t"]),
                    "-" if np.isnan(pair["df"]) else df_text(pair["df"]),
                    p_number(pair["p"]),
                    _p(pair["p_holm"]),
                    int(pair["pairs"]),
                ]
            )
    heads = ["pair", "difference, 95 % interval", "t", "df", "p", "Holm p", "n participants"]
    return _table(heads, rows) if rows else None


def _plsd(each: OperatorAnalysis) -> list[tuple[str, dict[str, Any] | None]]:
    tables: list[tuple[str, dict[str, Any] | None]] = []
    for outcome, pairs in each.paper.plsd.items() if each.paper else ():
        rows: list[Row] = []
        for factor, of_factor in pairs.groupby("factor", sort=False) if len(pairs) else ():
            rows.append(str(factor))
            for _, pair in of_factor.iterrows():
                rows.append(
                    [
                        f"{pair['first']} {MINUS} {pair['second']}",
                        with_decimals(pair["difference"], outcome.decimals + 1),
                        with_decimals(pair["least_significant"], outcome.decimals + 1),
                        number_or_dash(pair["t"]),
                        _p(pair["p"]),
                    ]
                )
        heads = ["pair", "difference", "least significant", "t", "p"]
        tables.append((outcome.heading, _table(heads, rows) if rows else None))
    return tables


def _missing(experiment: Experiment) -> dict[str, Any]:
    rows: list[Row] = []
    for levels, counts in experiment.counts.iterrows():
        share = "-"
        if not np.isnan(counts["share"]):
            percent = [with_decimals(100.0 * counts[end], 1) for end in ("share", "low", "high")]
            share = "{} % [{}, {}]".format(*percent)
        name = "all trials" if levels[0] == "all" else ", ".join(levels)  # type: ignore[index]
        done, timeouts, faults, absent = (
            int(counts[key]) for key in ("done", "timeouts", "faults", "absent")
        )
        rows.append([name, done, timeouts, share, faults, absent])
    share_head = "share of timeouts, 95 % interval"
    heads = ["condition", "completed", "timeouts", share_head, "faults", "absent"]
    return _table(heads, rows)


# The differences and the facts


def _differences(analysis: ExperimentAnalysis) -> dict[str, Any]:
    outcomes = list(dict.fromkeys(each.outcome for each in analysis.differences))
    cells: dict[tuple[str, str], dict[Outcome, Cell]] = {}
    for each in analysis.differences:
        test = each.test
        words = _interval(test.difference, test.half_width, 4 if each.outcome is PENETRATION else 2)
        cell: Cell = "-"
        if test.pairs:
            excludes_zero = abs(test.difference) > test.half_width
            cell = strong(f"{words} ({test.pairs})", excludes_zero)
        pair = f"{each.second.name} {MINUS} {each.first.name}"
        cells.setdefault((pair, f"{each.haptic}, {each.rotation}"), {})[each.outcome] = cell
    rows: list[Row] = []
    before = ""
    for (pair, condition), values in cells.items():
        of_outcomes = [values.get(outcome, "-") for outcome in outcomes]
        rows.append(["" if pair == before else pair, condition, *of_outcomes])
        before = pair
    return _table(["difference", "condition", *(o.heading for o in outcomes)], rows)


def _facts(analysis: ExperimentAnalysis, file: str, limit_s: float) -> list[tuple[str, str]]:
    is_several = analysis.variants > 1
    blocks = len(analysis.experiments[0].levels["Trial"])
    return [
        ("File", file),
        ("Trials", f"{text.all_trials(analysis)} (practice is left out)"),
        ("Missing trials", text.missing_text(analysis)),
        (
            "Operators" if analysis.has_simulated else "Participants",
            str(text.most_participants(analysis)),
        ),
        (
            "Followings and settings" if is_several else "Followings",
            text.names_of(analysis) if analysis.has_simulated or is_several else "",
        ),
        ("Blocks", str(blocks)),
        ("Time limit", f"{number_or_dash(limit_s)} s"),
    ]
