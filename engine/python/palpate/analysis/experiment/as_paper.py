"""The analysis as the paper did it: fixed effects of Haptic, Rotation, Object and Trial with all
their interactions, without participants in the model, so that all trials count as independent."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import pandas as pd

from palpate.analysis.errors import InputError, printable
from palpate.analysis.statistics import (
    SIGNIFICANCE,
    Design,
    DesignError,
    Fit,
    Term,
    all_terms,
    fisher_plsd,
)

from .experiments import CONDITION, FACTORS, Experiment
from .outcomes import PAPER_OUTCOMES, Outcome


@dataclass(frozen=True)
class AsPaper:
    """trials: completed, with all three measures: the n of every F.

    manova: indexed by term: wilks_lambda, f, df1, df2, p.
    anovas: by outcome, indexed by term: f, df1, df2, p, partial_eta2.
    plsd: by outcome: factor, first, second, difference, t, p, least_significant, of the factors
    whose F is significant.
    left_out: factors that the model does not have, and why: sentences.
    """

    trials: int
    error_df: int
    manova: pd.DataFrame
    anovas: dict[Outcome, pd.DataFrame]
    mean_square_errors: dict[Outcome, float]
    plsd: dict[Outcome, pd.DataFrame]
    left_out: list[str]


def analyse_as_paper(experiment: Experiment) -> AsPaper:
    """Raises InputError if a measure is missing, if the error matrix is singular, or if the trials
    do not determine the model."""
    trials = _model_trials(experiment)
    empty = experiment.empty_condition()
    if empty:
        raise InputError(
            "",
            f"condition {printable(empty)}",
            "has no completed trial; expected one or more",
            "the effects of its factors cannot be separated",
        )
    factors, left_out = _factors(experiment, trials)
    if not factors:
        raise InputError(
            "", "rows", "have one level of every factor; expected a factor with two"
        )
    try:
        design = Design(trials, factors)
    except DesignError as error:
        hint = "leave out a factor, or add trials to the empty cells"
        raise InputError("", "design", str(error), hint) from None
    fit = design.fit(trials[[outcome.key for outcome in PAPER_OUTCOMES]])
    _check_error_matrix(fit)
    terms = all_terms(factors)
    anovas = {
        outcome: _by_term({term: fit.effect(term, i) for term in terms})
        for i, outcome in enumerate(PAPER_OUTCOMES)
    }
    errors = {o: float(fit.mean_square_error(i)) for i, o in enumerate(PAPER_OUTCOMES)}
    return AsPaper(
        len(trials),
        fit.error_df,
        _by_term({term: fit.wilks(term) for term in terms}),
        anovas,
        errors,
        {o: _plsd(trials, o, anovas[o], errors[o], fit.error_df) for o in PAPER_OUTCOMES},
        left_out,
    )


def _by_term(tests: dict[Term, Any]) -> pd.DataFrame:
    index = pd.Index(list(tests), tupleize_cols=False, name="term")
    return pd.DataFrame([asdict(test) for test in tests.values()], index=index)


def _model_trials(experiment: Experiment) -> pd.DataFrame:
    for outcome in PAPER_OUTCOMES:
        if not experiment.has(outcome):
            raise InputError(
                "",
                outcome.column,
                "is in no completed trial; expected it in every completed trial",
                "the multivariate analysis needs total time, losses of contact and penetration",
            )
    trials = experiment.trials[experiment.trials["status"] == "done"]
    lacks = trials[[outcome.key for outcome in PAPER_OUTCOMES]].isna()
    if lacks.any(axis=None):
        row = trials[lacks.any(axis=1)].iloc[0]
        outcome = next(o for o in PAPER_OUTCOMES if pd.isna(row[o.key]))
        at = f"participant {row['participant']}, block {row['Trial']}, {', '.join(row[CONDITION])}"
        raise InputError(
            "",
            f"{printable(at)}, {outcome.column}",
            "is empty; expected a number, because the status is done",
        )
    return trials


def _factors(experiment: Experiment, trials: pd.DataFrame) -> tuple[list[str], list[str]]:
    """The factors of the model, and a sentence for each other one."""
    done = trials.groupby([*CONDITION, "Trial"], observed=False).size()
    empty = done.index[done == 0]
    factors, left_out = [], experiment_notes(experiment)
    for factor in FACTORS:
        if len(experiment.levels[factor]) == 1:
            continue
        if factor == "Trial" and len(empty):
            *condition, block = empty[0]
            left_out.append(
                f"Trial is left out, because no trial of {', '.join(condition)} in block {block} "
                "was completed."
            )
        else:
            factors.append(factor)
    return factors, left_out


def experiment_notes(experiment: Experiment) -> list[str]:
    """A sentence for each factor that no analysis has."""
    return [
        f"{factor} is left out, because the file has one level of it: {levels[0]}."
        for factor, levels in experiment.levels.items()
        if len(levels) == 1
    ]


def _check_error_matrix(fit: Fit) -> None:
    if fit.error_df < len(PAPER_OUTCOMES):
        raise InputError(
            "",
            "rows",
            f"leave {fit.error_df} degrees of freedom for the error; expected at least 3",
            "add participants or blocks",
        )
    singular = fit.singular_response() if np.isfinite(fit.error_sscp).all() else None
    if not np.isfinite(fit.error_sscp).all():
        raise InputError(
            "",
            "rows",
            "have a measure whose squares are beyond the largest number; expected smaller values",
            "check the columns and their units",
        )
    if singular is not None:
        raise InputError(
            "",
            PAPER_OUTCOMES[singular].column,
            "is constant within the conditions, or follows from the measures before it, so that "
            "the error matrix is singular; expected a measure that varies",
            "check the column",
        )


def _plsd(
    trials: pd.DataFrame, outcome: Outcome, anova: pd.DataFrame, error: float, error_df: int
) -> pd.DataFrame:
    families = []
    for term, p in anova["p"].items():
        if len(term) > 1 or not p < SIGNIFICANCE:
            continue
        (factor,) = term
        values = trials.groupby(factor, observed=False)[outcome.key]
        pairs = fisher_plsd(values.mean(), values.count(), error, error_df)
        families.append(pairs.assign(factor=factor))
    return pd.concat(families, ignore_index=True) if families else pd.DataFrame()
