"""The tables of the page: texts by row, beside the paper's numbers."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from palpate.analysis.numbers import (
    as_printed,
    df_text,
    number_or_dash,
    p_number,
    with_decimals,
    with_unit,
)
from palpate.analysis.statistics import SIGNIFICANCE, Term, effect_name

from .analysis import ExperimentAnalysis, OperatorAnalysis
from .experiments import Experiment
from .outcomes import ANGLE, PENETRATION, Outcome
from .paper import MANOVA, MEANS, F
from .primary import Primary
from .tables import levels_of_means, paper_mean, trial_means

MINUS, PLUS_MINUS, FIRM = "\u2212", "\u00b1", "\u00a0"  # FIRM: a space without a line break
FIXED_HEADS = ["F", "df", "p", "partial \u03b7\u00b2", "n"]
REPEATED_HEADS = ["F", "df", "p", "GG \u03b5", "GG p", "gen. \u03b7\u00b2", "n"]
FIXED_GROUP = ("as the paper did it (n trials)", len(FIXED_HEADS))
REPEATED_GROUP = ("repeated measures (n participants)", len(REPEATED_HEADS))

Cell = str | int | dict[str, str]  # a dict: a text and a kind
Row = list[Cell] | str  # a text: the heading of the rows below it


@dataclass(frozen=True)
class Table:
    """groups: titles above the heads, each with a number of columns."""

    heads: list[str]
    rows: list[Row]
    groups: list[tuple[str, int]] = field(default_factory=list)


def _strong(words: str, is_strong: bool) -> Cell:
    return {"kind": "strong", "text": words} if is_strong else words


def quiet(words: str, is_quiet: bool = True) -> Cell:
    """In the quiet colour."""
    return {"kind": "quiet", "text": words} if is_quiet else words


def _of_paper(words: str) -> Cell:
    return quiet(words, bool(words))


def _p(p: float) -> Cell:
    """In bold if it is significant."""
    return _strong(p_number(p), p < SIGNIFICANCE)


def _df(test: Any) -> str:
    return f"{df_text(test['df1'])}, {df_text(test['df2'])}"


def interval(mean: float, half_width: float, decimals: int) -> str:
    """ "27.1 \u00b1 0.5"; without the half width if it is NaN."""
    words = with_decimals(mean, decimals)
    if np.isnan(half_width):
        return words
    return f"{words} {PLUS_MINUS} {with_decimals(half_width, decimals)}"


def mean_sd(pair: tuple[float, float] | None) -> str:
    """The paper's: "27.5 (15)"."""
    return "{} ({})".format(*map(as_printed, pair)) if pair else ""


def _level_name(levels: dict[str, str]) -> str:
    return ", ".join(levels.values()) or "all trials"


def trial_means_table(experiment: Experiment) -> Table:
    """Means and standard deviations of all trials at each level."""
    heads = ["level", "n trials"]
    levels = levels_of_means(experiment)
    rows: list[list[Cell]] = [[_level_name(at), experiment.done(at)] for at in levels]
    for outcome in experiment.reported_outcomes():
        means = trial_means(experiment, outcome)
        heads.append(with_unit(outcome.name, outcome.unit))
        for row, mean in zip(rows, means.itertuples()):
            words = f"{with_decimals(mean.mean, outcome.decimals)}{FIRM}"
            words += f"({with_decimals(mean.sd, outcome.decimals)})"
            row.append(words if mean.n == row[1] else f"{words}, n{FIRM}{mean.n}")
        at = zip(means["Haptic"], means["Rotation"], means["Object"])
        papers = [paper_mean(experiment, outcome, *levels) for levels in at]
        if any(papers):
            heads.append("the paper")
            for row, paper in zip(rows, papers):
                row.append(_of_paper(mean_sd(paper).replace(" ", FIRM)))
    return Table(heads, list(rows))


def participant_means(each: OperatorAnalysis) -> Table:
    """Means of participants with their 95 % intervals."""
    primaries = each.primary.values()
    levels = [at for at in levels_of_means(each.experiment) if at and "Object" not in at]
    heads = [with_unit(primary.outcome.name, primary.outcome.unit) for primary in primaries]
    rows: list[Row] = [
        [_level_name(at), *(_participant_mean(primary, at) for primary in primaries)]
        for at in levels
    ]
    return Table(["level", *heads], rows)


def _participant_mean(primary: Primary, at: dict[str, str]) -> str:
    mean = primary.mean(**{factor.lower(): level for factor, level in at.items()})
    if mean is None:
        return "-"
    words = interval(mean["mean"], mean["half_width"], primary.outcome.decimals)
    return f"{words}, n {mean['participants']}"


def manova(each: OperatorAnalysis) -> Table | None:
    """Wilks' lambda of every effect; None if the paper's analysis is not possible."""
    if each.paper is None:
        return None
    rows: list[Row] = []
    for term, test in zip(each.paper.manova.index, each.paper.manova.to_dict("records")):
        papers = ("", "", "")
        if term in MANOVA:
            wilks_lambda, f, df2 = MANOVA[term]
            papers = (f"{wilks_lambda:.3f}", f"{f:.3f}", df_text(df2))
        ours = [with_decimals(test["wilks_lambda"], 3), number_or_dash(test["f"]), _df(test)]
        row = [effect_name(term), *map(_of_paper, papers), *ours, _p(test["p"])]
        rows.append([*row, each.paper.trials])
    wilks = "Wilks\u2019 \u03bb"
    heads = ["effect", wilks, "F", "df2", wilks, "F", "df", "p", "n"]
    return Table(heads, rows, [("", 1), ("the paper", 3), ("this file (n trials)", 5)])


def _paper_f(outcome: Outcome, term: Any) -> Cell:
    f = F.get((outcome, term))
    return _of_paper(as_printed(f[0]) + (f" ({f[1]})" if f[1] else "")) if f else ""


def _repeated(effect: Any) -> list[Cell]:
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


def _fixed(each: OperatorAnalysis, outcome: Outcome, term: Term) -> list[Cell]:
    """The paper's F, and that of its analysis of this file."""
    assert each.paper is not None
    anova = each.paper.anovas[outcome]
    papers = _paper_f(outcome, term)
    if term not in anova.index:
        return [papers, *["-"] * len(FIXED_HEADS)]
    test = anova.loc[[term]].iloc[0]
    eta2 = with_decimals(test["partial_eta2"], 3)
    return [papers, number_or_dash(test["f"]), _df(test), _p(test["p"]), eta2, each.paper.trials]


def effects(each: OperatorAnalysis, primary: Primary) -> Table:
    """Every F of an outcome: as the paper did it, and by repeated measures."""
    has_fixed = each.paper is not None and primary.outcome in each.paper.anovas
    rows: list[Row] = []
    for effect in primary.effects.to_dict("records"):
        fixed = _fixed(each, primary.outcome, effect["term"]) if has_fixed else []
        rows.append([effect_name(effect["term"]), *fixed, *_repeated(effect)])
    if not has_fixed:
        return Table(["effect", *REPEATED_HEADS], rows, [("", 1), REPEATED_GROUP])
    heads = ["effect", "F", *FIXED_HEADS, *REPEATED_HEADS]
    return Table(heads, rows, [("", 1), ("the paper", 1), FIXED_GROUP, REPEATED_GROUP])


def angle_effects(angle: Primary) -> Table:
    """Every F of the contact angle of UaH."""
    rows: list[Row] = [
        [effect_name(effect["term"]), _paper_f(ANGLE, effect["term"]), *_repeated(effect)]
        for effect in angle.effects.to_dict("records")
    ]
    heads = ["effect", "F(1, 9)", *REPEATED_HEADS]
    return Table(heads, rows, [("", 1), ("the paper", 1), REPEATED_GROUP])


def pairs(primary: Primary) -> Table | None:
    """Paired t tests with Holm's adjustment; None without a pair."""
    rows: list[Row] = []
    decimals = primary.outcome.decimals + 1
    for family, of_family in primary.pairs.groupby("family", sort=False, observed=True):
        rows.append(str(family))
        for pair in of_family.to_dict("records"):
            difference = interval(pair["difference"], pair["half_width"], decimals)
            df = "-" if np.isnan(pair["df"]) else df_text(pair["df"])
            test = [number_or_dash(pair["t"]), df, p_number(pair["p"]), _p(pair["p_holm"])]
            rows.append([pair["pair"], difference, _size(pair), *test, pair["pairs"]])
    heads = ["pair", "difference, 95 % interval", "d, 95 % interval", "t", "df", "p", "Holm p"]
    heads.append("n participants")
    return Table(heads, rows) if rows else None


def _size(pair: Any) -> str:
    """ "1.2 (0.4 to 2)"; "-"."""
    if np.isnan(pair["d_z"]):
        return "-"
    d, low, high = (number_or_dash(pair[name]) for name in ("d_z", "d_z_low", "d_z_high"))
    return f"{d} ({low} to {high})"


def plsd(outcome: Outcome, pairs_of_outcome: pd.DataFrame) -> Table | None:
    """Fisher's PLSD of an outcome; None if no factor has a significant F."""
    rows: list[Row] = []
    decimals = outcome.decimals + 1
    heading = None
    for pair in pairs_of_outcome.to_dict("records"):
        if pair["factor"] != heading:
            heading = pair["factor"]
            rows.append(heading)
        widths = [with_decimals(pair[k], decimals) for k in ("difference", "least_significant")]
        name = f"{pair['first']} {MINUS} {pair['second']}"
        rows.append([name, *widths, number_or_dash(pair["t"]), _p(pair["p"])])
    return Table(["pair", "difference", "least significant", "t", "p"], rows) if rows else None


def variances(each: OperatorAnalysis) -> Table:
    """The parts of the variance of trials: standard deviations."""
    rows: list[Row] = []
    for outcome, parts in each.variances.items():
        sds = (parts.participants, parts.participant_condition, parts.trials)
        share = with_decimals(100.0 * parts.share_of_participants, 0)
        row = [outcome.heading, *map(number_or_dash, sds), share if share == "-" else f"{share} %"]
        rows.append([*row, parts.n_trials, parts.n_participants])
    heads = ["measure", "SD between participants", "SD of a participant in a condition",
             "SD of trials", "share of participants", "n trials", "n participants"]  # fmt: skip
    return Table(heads, rows)


def loss_rates(each: OperatorAnalysis) -> Table | None:
    """Ratios of losses per time."""
    if each.loss_rates is None:
        return None
    rows: list[Row] = [
        [ratio["pair"], with_decimals(ratio["ratio"], 3),
         f"{with_decimals(ratio['low'], 3)} to {with_decimals(ratio['high'], 3)}", _p(ratio["p"])]
        for ratio in each.loss_rates.ratios.to_dict("records")
    ]  # fmt: skip
    return Table(["pair", "ratio of losses per second", "95 % interval", "p"], rows)


def missing(experiment: Experiment) -> Table:
    """How the trials ended, of all conditions together and by condition. Columns of what no trial
    is are left out, if only people's trials can have them."""
    rows: list[Row] = []
    later = [name for name in ("aborted", "skipped") if experiment.total[name]]
    for levels, counts in zip(experiment.counts.index, experiment.counts.to_dict("records")):
        share = "-"
        if not np.isnan(counts["share"]):
            ends = (with_decimals(100.0 * counts[end], 1) for end in ("share", "low", "high"))
            share = "{} % [{}, {}]".format(*ends)
        name = "all trials" if levels[0] == "all" else ", ".join(levels)
        ended = [counts[status] for status in ("done", "timeouts", "faults", "absent")]
        rows.append([name, *ended[:2], share, *ended[2:], *(_cut(counts, name) for name in later)])
    share_head = "share of timeouts, 95 % interval"
    heads = ["condition", "completed", "timeouts", share_head, "faults", "absent", *later]
    return Table(heads, rows)


def _cut(counts: Any, status: str) -> Cell:
    """ "2 (focus 1, hidden 1)"."""
    reasons = dict(part.split(": ") for part in counts["reasons"].split("; ") if part)
    return f"{counts[status]} ({reasons[status]})" if status in reasons else int(counts[status])


def angle_means(experiment: Experiment, angle: Primary) -> Table:
    """Beside Figure 7."""
    rows: list[Row] = []
    for level in experiment.levels["Rotation"]:
        mean = angle.mean(rotation=level)
        ours = "-" if mean is None else f"{interval(mean['mean'], mean['half_width'], 1)} deg"
        rows.append([level, ours, f"{mean_sd(MEANS[ANGLE, level])} deg"])
    heads = ["rotation", f"this file, mean {PLUS_MINUS} 95 % interval", "the paper, mean (sd)"]
    return Table(heads, rows)


def differences(analysis: ExperimentAnalysis) -> Table:
    """Between variants; in bold if the interval does not hold 0."""
    outcomes = list(dict.fromkeys(each.outcome for each in analysis.differences))
    cells: dict[tuple[str, str], dict[Outcome, Cell]] = {}
    for each in analysis.differences:
        test = each.test
        words = interval(test.difference, test.half_width, 4 if each.outcome is PENETRATION else 2)
        cell: Cell = "-"
        if test.pairs:
            excludes_zero = abs(test.difference) > test.half_width
            cell = _strong(f"{words} ({test.pairs})", excludes_zero)
        pair = f"{each.second.name} {MINUS} {each.first.name}"
        cells.setdefault((pair, f"{each.haptic}, {each.rotation}"), {})[each.outcome] = cell
    rows: list[Row] = []
    before = ""
    for (pair, condition), values in cells.items():
        of_outcomes = [values.get(outcome, "-") for outcome in outcomes]
        rows.append(["" if pair == before else pair, condition, *of_outcomes])
        before = pair
    return Table(["difference", "condition", *(o.heading for o in outcomes)], rows)
