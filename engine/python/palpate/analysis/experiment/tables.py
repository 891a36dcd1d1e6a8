"""All numbers of an analysis, for other programs: tables, which are CSV files and keys in
JSON."""

from __future__ import annotations

from collections.abc import Hashable
from itertools import product
from typing import Any

import numpy as np
import pandas as pd

from palpate.analysis.statistics import effect_name
from palpate.analysis.statistics.types import Array

from .analysis import ExperimentAnalysis, OperatorAnalysis
from .experiments import CONDITION, VARIANT, Experiment
from .outcomes import ANGLE, PAPER_OUTCOMES, Outcome
from .paper import MANOVA, MEANS, F
from .primary import Primary
from .questionnaires import ratings_table, tests_table

COLUMNS = {
    "effects": """following analysis outcome effect wilks_lambda f df1 df2 p gg_epsilon gg_p
        partial_eta2 generalized_eta2 trials participants paper_lambda paper_f paper_p""",
    "comparisons": """following analysis outcome unit family pair difference half_width_95 t df p
        p_holm least_significant_difference participants d_z d_z_low_95 d_z_high_95""",
    "means": """following of outcome unit haptic rotation object n mean sd half_width_95 paper_mean
        paper_sd""",
    "missing_trials": """following haptic rotation object done timeouts faults absent aborted
        skipped reasons timeout_share timeout_share_low timeout_share_high""",
    "findings": """following finding paper_statement paper_figures verdict because
        verdict_by_the_papers_test differs_between_followings""",
    "verdicts": """following finding comparison unit difference low_95 high_95 margin p p_holm
        participants paper_difference paper_low_95 paper_high_95 verdict""",
    "variances": """following outcome unit sd_participants sd_participant_condition sd_trials
        share_of_participants trials participants""",
    "loss_rates": "following factor pair ratio low_95 high_95 p df dispersion trials",
}
DIFFERENCES = """following view align start_orientation_deg scale other_following other_view
    other_align other_start_orientation_deg other_scale outcome unit haptic rotation difference
    half_width_95 t df p participants"""
TABLES = (*COLUMNS, "differences", "ratings", "rating_tests")
COUNTS = ["trials", "participants", "n", "done", "timeouts", "faults", "absent",
          "aborted", "skipped"]  # fmt: skip
SHARES = {"share": "timeout_share", "low": "timeout_share_low", "high": "timeout_share_high"}
MEAN_LEVELS = (["Haptic"], ["Rotation"], ["Object"], ["Haptic", "Rotation"])


def tables_of(analysis: ExperimentAnalysis) -> dict[str, pd.DataFrame]:
    """Every F, every comparison, every mean, the missing trials by condition, the verdicts with
    the comparisons that they need, the differences between variants, which are none in a file with
    one variant, and ratings with their tests, which are none without questionnaires."""
    makers = (
        _effects,
        _comparisons,
        _means,
        _missing,
        _findings,
        _verdicts,
        _variances,
        _loss_rates,
    )
    tables = {}
    for (name, columns), maker in zip(COLUMNS.items(), makers):
        frames = [_of(each, maker(analysis, each)) for each in analysis.operators]
        tables[name] = _shaped(_stacked(frames), [*columns.split(), *VARIANT])
    tables["differences"] = _shaped(_differences(analysis), DIFFERENCES.split())
    tables["ratings"] = ratings_table(analysis.questionnaires)
    tables["rating_tests"] = tests_table(analysis.questionnaires)
    return tables


def rows_of(table: pd.DataFrame) -> list[dict[Hashable, Any]]:
    """One dict a row; None for what is undefined."""
    values = table.astype(object)
    records: list[dict[Hashable, Any]] = values.where(values.notna(), None).to_dict("records")
    return records


def _stacked(frames: list[pd.DataFrame]) -> pd.DataFrame:
    """The rows of all frames. Columns have no type, because one may have no value in a frame."""
    filled = [frame.astype(object) for frame in frames if len(frame)]
    return pd.concat(filled, ignore_index=True) if filled else pd.DataFrame(*frames[:1])


def _shaped(frame: pd.DataFrame, columns: list[str]) -> pd.DataFrame:
    shaped = frame.reindex(columns=columns).reset_index(drop=True)
    return shaped.astype({name: "Int64" for name in COUNTS if name in columns})


def _of(each: OperatorAnalysis, frame: pd.DataFrame) -> pd.DataFrame:
    return frame.assign(following=each.experiment.who, **each.experiment.variant._asdict())


def _effects(_: ExperimentAnalysis, each: OperatorAnalysis) -> pd.DataFrame:
    frames = []
    if each.paper:
        manova = each.paper.manova.reset_index()
        names = ", ".join(outcome.name for outcome in PAPER_OUTCOMES)
        printed = [MANOVA.get(term, (np.nan, np.nan)) for term in manova["term"]]
        manova[["paper_lambda", "paper_f"]] = [row[:2] for row in printed]
        frames.append(manova.assign(analysis="manova", outcome=names, trials=each.paper.trials))
        for outcome, anova in each.paper.anovas.items():
            frame = anova.reset_index().assign(analysis="anova", trials=each.paper.trials)
            frames.append(_with_papers_f(frame, outcome))
    for primary in each.primaries:
        names_of = {"epsilon": "gg_epsilon", "p_gg": "gg_p"}
        frame = primary.effects.rename(columns=names_of).assign(analysis=_kind(primary))
        frames.append(_with_papers_f(frame, primary.outcome, primary.only_haptic))
    frame = _stacked(frames or [pd.DataFrame(columns=["term"])])
    return frame.assign(effect=[effect_name(term) for term in frame["term"]])


def _kind(primary: Primary) -> str:
    name = "repeated measures"
    return f"{name}, {primary.only_haptic}" if primary.only_haptic else name


def _with_papers_f(
    frame: pd.DataFrame, outcome: Outcome, only_haptic: str | None = None
) -> pd.DataFrame:
    """The paper's contact angles are those of UaH."""
    is_of_paper = outcome is not ANGLE or only_haptic
    papers = [F.get((outcome, term)) if is_of_paper else None for term in frame["term"]]
    return frame.assign(
        outcome=outcome.name,
        paper_f=[paper[0] if paper else np.nan for paper in papers],
        paper_p=[paper[1] or None if paper else None for paper in papers],
    )


def _comparisons(_: ExperimentAnalysis, each: OperatorAnalysis) -> pd.DataFrame:
    frames = []
    for outcome, plsd in each.paper.plsd.items() if each.paper else ():
        if each.paper and len(plsd):
            frame = plsd.rename(columns={"least_significant": "least_significant_difference"})
            pairs = frame["first"] + " - " + frame["second"]
            frame = frame.assign(pair=pairs, family=frame["factor"], df=float(each.paper.error_df))
            frames.append(_with_outcome(frame.assign(analysis="plsd"), outcome))
    for primary in each.primaries:
        kind = "paired t, UaH" if primary.only_haptic else "paired t"
        frame = primary.pairs.rename(
            columns={
                "half_width": "half_width_95",
                "pairs": "participants",
                "d_z_low": "d_z_low_95",
                "d_z_high": "d_z_high_95",
            }
        )
        frames.append(_with_outcome(frame.assign(analysis=kind), primary.outcome))
    return _stacked(frames)


def _with_outcome(frame: pd.DataFrame, outcome: Outcome) -> pd.DataFrame:
    return frame.assign(outcome=outcome.name, unit=outcome.unit)


def levels_of_means(experiment: Experiment) -> list[dict[str, str]]:
    """The levels of tables of means, by factor: of all trials, each level of each factor, and each
    combination of Haptic and Rotation. Factors with one level are left out."""
    levels: list[dict[str, str]] = [{}]
    for factors in MEAN_LEVELS:
        lists = [experiment.levels[factor] for factor in factors]
        if all(len(names) > 1 for names in lists):
            levels += [dict(zip(factors, names)) for names in product(*lists)]
    return levels


def trial_means(experiment: Experiment, outcome: Outcome) -> pd.DataFrame:
    """Mean and standard deviation (n - 1) of the trials that have an outcome, at each of
    levels_of_means(). Columns: Haptic, Rotation, Object ("all": over all levels), n, mean, sd."""
    grid = experiment.grid(outcome)
    rows = []
    for levels in levels_of_means(experiment):
        at: list[Any] = [
            experiment.levels[factor].index(levels[factor]) if factor in levels else slice(None)
            for factor in CONDITION
        ]
        values = grid[(slice(None), *at)]
        rows.append([levels.get(factor, "all") for factor in CONDITION] + _summary(values))
    return pd.DataFrame(rows, columns=[*CONDITION, "n", "mean", "sd"])


def _summary(grid: Array) -> list[float]:
    values = grid[~np.isnan(grid)]
    n = len(values)
    is_constant = n > 0 and values.min() == values.max()  # no rounding noise
    sd = np.nan if n < 2 else 0.0 if is_constant else values.std(ddof=1)
    mean = np.nan if n == 0 else values[0] if is_constant else values.mean()
    return [n, float(mean), float(sd)]


def paper_mean(
    experiment: Experiment, outcome: Outcome, haptic: str, rotation: str, object_: str = "all"
) -> tuple[float, float] | None:
    """The paper's mean and standard deviation of an outcome at these levels, if it has them. Its
    contact angles are those of UaH. None of it is of a force that was seen."""
    if object_ != "all" or experiment.is_seen:
        return None
    if outcome is ANGLE:
        only = experiment.levels["Haptic"]
        is_uah = (only[0] if haptic == "all" and len(only) == 1 else haptic) == "UaH"
        return MEANS.get((outcome, rotation)) if is_uah else None
    if (haptic == "all") == (rotation == "all"):
        return None
    return MEANS.get((outcome, rotation if haptic == "all" else haptic))


def _means(_: ExperimentAnalysis, each: OperatorAnalysis) -> pd.DataFrame:
    experiment = each.experiment
    frames = [
        _with_outcome(trial_means(experiment, outcome), outcome).assign(of="trials", key=outcome)
        for outcome in experiment.reported_outcomes()
    ]
    for primary in each.primaries:
        columns = {"participants": "n", "half_width": "half_width_95"}
        frame = primary.means.rename(columns=columns).assign(
            Object="all", of="participants", key=primary.outcome
        )
        if primary.only_haptic:  # it can have more participants
            of = f"participants, {primary.only_haptic}"
            frame = frame.assign(of=of, Haptic=primary.only_haptic)
        frames.append(_with_outcome(frame, primary.outcome))
    if not frames:
        return pd.DataFrame()
    frame = _stacked(frames)
    levels = frame[["key", "Haptic", "Rotation", "Object"]].itertuples(index=False)
    papers = [paper_mean(experiment, *row) or (np.nan, np.nan) for row in levels]
    frame[["paper_mean", "paper_sd"]] = papers
    return frame.rename(columns=str.lower)


def _missing(_: ExperimentAnalysis, each: OperatorAnalysis) -> pd.DataFrame:
    return each.experiment.counts.reset_index().rename(columns=str.lower).rename(columns=SHARES)


def _findings(analysis: ExperimentAnalysis, each: OperatorAnalysis) -> pd.DataFrame:
    differing = analysis.differing()
    return pd.DataFrame(
        {
            "finding": result.finding.name,
            "paper_statement": result.finding.statement,
            "paper_figures": result.finding.printed,
            "verdict": result.verdict,
            "because": result.because,
            "verdict_by_the_papers_test": result.by_the_papers_test,
            "differs_between_followings": int(i in differing),
        }
        for i, result in enumerate(each.findings)
    )


def _verdicts(_: ExperimentAnalysis, each: OperatorAnalysis) -> pd.DataFrame:
    rows = []
    for result in each.findings:
        for comparison in result.comparisons:
            ours, paper = comparison.ours, comparison.paper
            rows.append(
                {
                    "finding": result.finding.name,
                    "comparison": comparison.name,
                    "unit": result.finding.outcome.unit if result.finding.outcome else "",
                    "difference": ours.difference,
                    "low_95": ours.low,
                    "high_95": ours.high,
                    "margin": comparison.margin,
                    "p": comparison.p,
                    "p_holm": comparison.p_holm,
                    "participants": comparison.participants,
                    "paper_difference": paper.difference if paper else None,
                    "paper_low_95": paper.low if paper else None,
                    "paper_high_95": paper.high if paper else None,
                    "verdict": comparison.verdict,
                }
            )
    return pd.DataFrame(rows)


def _variances(_: ExperimentAnalysis, each: OperatorAnalysis) -> pd.DataFrame:
    return pd.DataFrame(
        {
            "outcome": outcome.name,
            "unit": outcome.unit,
            "sd_participants": parts.participants,
            "sd_participant_condition": parts.participant_condition,
            "sd_trials": parts.trials,
            "share_of_participants": parts.share_of_participants,
            "trials": parts.n_trials,
            "participants": parts.n_participants,
        }
        for outcome, parts in each.variances.items()
    )


def _loss_rates(_: ExperimentAnalysis, each: OperatorAnalysis) -> pd.DataFrame:
    rates = each.loss_rates
    if rates is None:
        return pd.DataFrame()
    frame = rates.ratios.rename(columns={"low": "low_95", "high": "high_95"})
    return frame.assign(df=rates.df, dispersion=rates.dispersion, trials=rates.trials)


def _differences(analysis: ExperimentAnalysis) -> pd.DataFrame:
    rows = []
    for difference in analysis.differences:
        first, second = difference.first, difference.second
        rows.append(
            {
                "following": second.who,
                **second.variant._asdict(),
                "other_following": first.who,
                **{f"other_{name}": each for name, each in first.variant._asdict().items()},
                "outcome": difference.outcome.name,
                "unit": difference.outcome.unit,
                "haptic": difference.haptic,
                "rotation": difference.rotation,
                "difference": difference.test.difference,
                "half_width_95": difference.test.half_width,
                "t": difference.test.t,
                "df": difference.test.df,
                "p": difference.test.p,
                "participants": difference.test.pairs,
            }
        )
    return pd.DataFrame(rows)


def document(
    analysis: ExperimentAnalysis, tables: dict[str, pd.DataFrame], file: str, limit_s: float
) -> dict[str, Any]:
    """The JSON document: the file, the time limit and the operators, then the tables. file: as the
    user named it."""
    operators = [_operator(each) for each in analysis.operators]
    head = {
        "palpate_analysis": 1,
        "file": file,
        "limit_s": limit_s,
        "pilot_rows": analysis.pilot_rows,
        "operators": operators,
    }
    return {**head, **{name: rows_of(table) for name, table in tables.items()}}


def _operator(each: OperatorAnalysis) -> dict[str, Any]:
    experiment, paper = each.experiment, each.paper
    result = {
        "following": experiment.who,
        **experiment.variant._asdict(),
        "simulated": experiment.is_simulated,
        "participants": experiment.participants,
        "levels": experiment.levels,
        "trials_done": experiment.total["done"],
        "trials_missing": experiment.missing,
        "repeated": experiment.repeated,
        "error_df_of_the_papers_analysis": paper.error_df if paper else None,
        "problem_of_the_papers_analysis": each.paper_problem,
    }
    if paper:
        errors = {o.name: error for o, error in paper.mean_square_errors.items()}
        result["mean_square_error"] = errors
    return {**result, "notes": each.notes}
