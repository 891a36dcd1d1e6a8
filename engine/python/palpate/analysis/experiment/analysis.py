"""The analysis of the trials of an experiment, by people or by simulated operators, in two ways: as
the paper did, and by repeated measures, which is the primary analysis. The trials of each following
and of each variant are analysed separately."""

from __future__ import annotations

from dataclasses import dataclass, field

import pandas as pd

from palpate.analysis.errors import InputError, printable
from palpate.analysis.numbers import number_or_dash

from .as_paper import AsPaper, analyse_as_paper, experiment_notes
from .differences import Difference, differences_of
from .experiments import (
    Experiment,
    check_haptic,
    counts_text,
    experiments_of,
    without_pilots,
)
from .findings import FindingResult, judge
from .loss_rates import LossRates, loss_rates
from .outcomes import ANGLE, OUTCOMES, PAPER_OUTCOMES, TIME_TO_LIMIT, Outcome
from .primary import Primary, analyse_repeated_measures
from .questionnaires import Questionnaires
from .variances import Variances, parts_of_variance
from .verdicts import AGREES, DISAGREES


@dataclass
class OperatorAnalysis:
    """The analysis of an experiment. paper: None if it is not possible; paper_problem states why.
    angle_of_uah: Figure 7. variances: of the paper's outcomes. loss_rates: None if the trials do
    not determine them. notes: what was left out, and why: sentences."""

    experiment: Experiment
    paper: AsPaper | None = None
    paper_problem: str = ""
    primary: dict[Outcome, Primary] = field(default_factory=dict)
    angle_of_uah: Primary | None = None
    variances: dict[Outcome, Variances] = field(default_factory=dict)
    loss_rates: LossRates | None = None
    findings: list[FindingResult] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    @property
    def whose_trials(self) -> str:
        """For titles: "simulated operators, delayed"; "people"."""
        name = self.experiment.name
        return f"simulated operators, {name}" if self.experiment.is_simulated else name

    @property
    def primaries(self) -> list[Primary]:
        """All of them."""
        return [*self.primary.values(), *([self.angle_of_uah] if self.angle_of_uah else [])]


@dataclass
class ExperimentAnalysis:
    """operators: at least one, in the order of experiments_of(). differences: none with one
    variant. pilot_rows: how many rows were left out because they are of a pilot run.
    questionnaires: None if there are none beside the trials."""

    operators: list[OperatorAnalysis]
    differences: list[Difference]
    pilot_rows: int = 0
    questionnaires: Questionnaires | None = None

    @property
    def experiments(self) -> list[Experiment]:
        return [each.experiment for each in self.operators]

    @property
    def variants(self) -> int:
        return len({experiment.variant for experiment in self.experiments})

    @property
    def has_simulated(self) -> bool:
        return any(experiment.is_simulated for experiment in self.experiments)

    @property
    def has_people(self) -> bool:
        return not all(experiment.is_simulated for experiment in self.experiments)

    def differing(self) -> list[int]:
        """The places in FINDINGS with which one operator agrees and another one disagrees."""
        verdicts = zip(*([result.verdict for result in each.findings] for each in self.operators))
        return [i for i, found in enumerate(verdicts) if {AGREES, DISAGREES} <= set(found)]


def analyse_trials(frame: pd.DataFrame, limit_s: float) -> ExperimentAnalysis:
    """frame: the rows of trials.csv (read_trials), in any order. limit_s: of a trial.

    Raises InputError as check_haptic(), experiments_of() and analyse_as_paper() do, and for a contact
    angle that is the same in all trials. A condition without a completed trial is an error only if every
    following has such a condition. If the file has several variants, a reason why the paper's
    analysis is not possible is no error: they are still compared.
    """
    check_haptic(frame)
    counted = without_pilots(frame)
    if counted.empty and len(frame):
        raise InputError("", "column pilot", "is 1 in every row; expected trials that are not of a "
                         "pilot run", "`palpate experiment power` can use them")
    experiments = experiments_of(counted, limit_s)
    several = len({experiment.variant for experiment in experiments}) > 1
    operators = [_analyse(experiment, several) for experiment in experiments]
    if not several and not any(each.paper for each in operators):
        with _in_following(experiments[0]):
            analyse_as_paper(experiments[0])
    pilot_rows = len(frame) - len(counted)
    return ExperimentAnalysis(operators, differences_of(experiments), pilot_rows)


class _in_following:
    """Names the experiment in an InputError."""

    def __init__(self, experiment: Experiment) -> None:
        self.experiment = experiment

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: object, error: BaseException | None, traceback: object) -> None:
        if isinstance(error, InputError):
            error.element = self.experiment.whose + error.element


def _analyse(experiment: Experiment, is_one_of_several: bool) -> OperatorAnalysis:
    analysis = OperatorAnalysis(experiment, notes=experiment_notes(experiment))
    if experiment.is_seen:
        analysis.notes.append(
            "In seen-UaH and seen-H the force acted on a simulated hand that the pointer led: "
            "people saw it and felt nothing. What these levels show is a claim about seeing, so "
            "that no finding of the paper, whose people felt the force, is tested."
        )
    if experiment.repeated:
        analysis.notes.append(
            "Of several attempts at a trial the last completed one counts, or the last one if none "
            f"was completed; other attempts: {sum(experiment.repeated.values())} "
            f"({counts_text(experiment.repeated)})."
        )
    with _in_following(experiment):
        _analyse_fixed_effects(analysis, is_one_of_several)
        _analyse_outcomes(analysis, is_one_of_several)
    analysis.variances = {
        outcome: parts_of_variance(experiment, outcome)
        for outcome in PAPER_OUTCOMES
        if outcome in analysis.primary
    }
    analysis.loss_rates = loss_rates(experiment)
    analysis.findings = judge(
        experiment, analysis.paper, analysis.primary, analysis.angle_of_uah
    )
    return analysis


def _analyse_fixed_effects(analysis: OperatorAnalysis, is_one_of_several: bool) -> None:
    empty = analysis.experiment.empty_condition()
    try:
        analysis.paper = analyse_as_paper(analysis.experiment)
    except InputError as error:
        if empty:
            analysis.paper_problem = (
                f"No trial of {empty} was completed: its effects cannot be separated."
            )
        elif is_one_of_several:
            analysis.paper_problem = f"The trials {error.problem}."
        else:
            raise
    else:
        analysis.notes += [s for s in analysis.paper.left_out if s not in analysis.notes]


def _analyse_outcomes(analysis: OperatorAnalysis, is_one_of_several: bool) -> None:
    experiment = analysis.experiment
    for outcome in OUTCOMES:
        if outcome is TIME_TO_LIMIT and not experiment.has_timeouts:
            continue
        values = experiment.trials[outcome.key].dropna().unique()
        if len(values) == 0:
            is_any_done = experiment.total["done"] > 0
            why = f"The file does not have the column {outcome.column}"
            analysis.notes.append(
                f"{why if is_any_done else 'No trial was completed'}, so that there is no analysis "
                f"of {outcome.name}."
            )
        elif len(values) > 1:
            analysis.primary[outcome] = analyse_repeated_measures(experiment, outcome)
        elif outcome is ANGLE and not is_one_of_several:
            raise InputError(
                "",
                outcome.column,
                f"is {number_or_dash(values[0])} in every trial; expected a measure that varies",
                "check the column",
            )
        else:
            analysis.notes.append(
                f"The number of {outcome.name} is {number_or_dash(values[0])} in every trial; its "
                "analysis is left out."
            )
    if "UaH" in experiment.levels["Haptic"] and experiment.has(ANGLE):
        analysis.angle_of_uah = analyse_repeated_measures(experiment, ANGLE, "UaH")


def check_rows(frame: pd.DataFrame, limit_s: float) -> None:
    """Raises InputError for rows with a strategy, and for a completed trial that is longer than the
    time limit if the file has timeouts."""
    strategies = frame["strategy"] if "strategy" in frame else pd.Series(dtype=object)
    named = frame[strategies.fillna("").astype(str).reindex(frame.index, fill_value="") != ""]
    if len(named):
        row = named.iloc[0]
        raise InputError(
            "",
            "column strategy",
            f"is {row['strategy']} in a trial of participant {printable(row['participant'])}; "
            "expected trials with haptic and rotation",
            "`palpate compare` compares strategies",
        )
    counted = without_pilots(frame)
    counted = counted[counted["block"] > 0]
    if "total_time_s" not in frame or not (counted["status"] == "timeout").any():
        return
    beyond = counted[(counted["status"] == "done") & (counted["total_time_s"] > limit_s)]
    if len(beyond):
        row = beyond.iloc[0]
        raise InputError(
            "",
            f"participant {printable(row['participant'])}, block {row['block']}, {row['haptic']}, "
            f"{row['rotation']}, {printable(row['object'])}, total_time_s",
            f"is {number_or_dash(row['total_time_s'])} in a completed trial; expected at most the "
            f"time limit, {number_or_dash(limit_s)} s, because the file has timeouts",
            "give the time limit of the trials with --limit",
        )
