"""Losses of contact as counts, with the time of the trial as exposure: ratios of rates.

log E(losses) = log(time) + participant + Haptic + Rotation + Object + Trial, with a variance that
is proportional to the mean (quasi-Poisson). A condition that takes longer has more losses for this
reason alone; in a ratio of rates it has not.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
import pandas as pd

from palpate.analysis.statistics import t_for_coverage, t_two_sided
from palpate.analysis.statistics.types import Array

from .experiments import FACTORS, Experiment
from .outcomes import LOSSES, TIME


# The fit needs a column for each participant.
MOST_PARTICIPANTS = 200


@dataclass(frozen=True)
class LossRates:
    """ratios: factor, pair ("H / UaH"), ratio, low, high (95 %, Student's t) and p of a ratio of 1.
    dispersion: variance / mean; 1 is Poisson's."""

    ratios: pd.DataFrame
    dispersion: float
    df: int
    trials: int


def loss_rates(experiment: Experiment) -> LossRates | None:
    """None if the trials do not determine the model, if nobody lost contact at some level, or for
    more than MOST_PARTICIPANTS."""
    if experiment.trials["participant"].nunique() > MOST_PARTICIPANTS:
        return None
    trials = experiment.trials.dropna(subset=[LOSSES.key, TIME.key])
    trials = trials[trials[TIME.key] > 0.0]
    blocks = {f: _dummies(trials[f]) for f in ("participant", *FACTORS)}
    columns = [np.ones((len(trials), 1)), *blocks.values()]
    design = np.hstack(columns)
    losses = trials[LOSSES.key].to_numpy()
    if not _is_determined(trials, design):
        return None
    ends = np.cumsum([block.shape[1] for block in columns])
    starts = dict(zip(blocks, ends))
    coefficients, covariance, dispersion = _fit(losses, design, np.log(trials[TIME.key].to_numpy()))
    df = len(trials) - design.shape[1]
    rows = []
    for factor in ("Haptic", "Rotation"):
        for a, b in combinations(experiment.levels[factor], 2):
            contrast = np.zeros(design.shape[1])
            for level, sign in ((b, 1.0), (a, -1.0)):
                place = experiment.levels[factor].index(level)
                if place > 0:
                    contrast[starts[factor] + place - 1] = sign
            log_ratio = float(contrast @ coefficients)
            error = float(np.sqrt(contrast @ covariance @ contrast))
            rows.append(_ratio(factor, f"{b} / {a}", log_ratio, error, df))
    return LossRates(pd.DataFrame(rows), dispersion, df, len(trials))


def _dummies(levels: pd.Series[str]) -> Array:
    """A column for each level but the first."""
    codes = levels.cat.codes.to_numpy()
    return np.asarray(codes[:, None] == np.arange(1, len(levels.cat.categories)), dtype=float)


def _is_determined(trials: pd.DataFrame, design: Array) -> bool:
    if len(trials) <= design.shape[1] or np.linalg.matrix_rank(design) < design.shape[1]:
        return False
    sums = [trials.groupby(f, observed=False)[LOSSES.key].sum() for f in ("participant", *FACTORS)]
    return all(bool((sum_ > 0.0).all()) for sum_ in sums)


def _fit(losses: Array, design: Array, offset: Array) -> tuple[Array, Array, float]:
    """Coefficients, their covariance, and the dispersion."""
    from statsmodels.genmod.families import Poisson  # slow to import
    from statsmodels.genmod.generalized_linear_model import GLM

    fit = GLM(losses, design, family=Poisson(), offset=offset).fit(scale="X2", tol=1e-12)
    return fit.params, fit.cov_params(), float(fit.scale)


def _ratio(factor: str, pair: str, log_ratio: float, error: float, df: int) -> dict[str, object]:
    half = t_for_coverage(df) * error
    ends = np.exp([log_ratio, log_ratio - half, log_ratio + half])
    p = float(t_two_sided(log_ratio / error, df))
    return {"factor": factor, "pair": pair, **dict(zip(("ratio", "low", "high"), ends)), "p": p}
