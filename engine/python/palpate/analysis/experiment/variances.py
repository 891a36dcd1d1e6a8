"""The parts of the variance of trials, by a mixed model.

y = condition + Trial + u(participant) + w(participant, condition) + e(trial), fitted by restricted
maximum likelihood (statsmodels). A condition is a Haptic, a Rotation and an Object; that of `power`
is a Haptic and a Rotation, so that its w and e are others. Only the parts are taken from it: its tests of conditions are z
tests, which ten participants are too few for.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from .experiments import CONDITION, Experiment
from .outcomes import Outcome

# The optimiser finds the parts to 1e-6; of another version of statsmodels, to 1e-5.
DIGITS = 4
# The optimiser takes about 0.1 s a participant and outcome; more than this are left out.
MOST_PARTICIPANTS = 40
NEGLIGIBLE = 1e-3  # of the standard deviation of trials: a part that the optimiser took to 0


@dataclass(frozen=True)
class Variances:
    """Standard deviations in the unit of the outcome: between participants; of how a participant
    differs in one condition; of trials. NaN: the model has no estimate."""

    participants: float
    participant_condition: float
    trials: float
    n_trials: int
    n_participants: int

    @property
    def share_of_participants(self) -> float:
        """Of the variance of trials about the means of conditions."""
        squares = np.square([self.participants, self.participant_condition, self.trials])
        return float(squares[:2].sum() / squares.sum())


def parts_of_variance(experiment: Experiment, outcome: Outcome) -> Variances:
    """The trials that have the outcome."""
    trials = experiment.trials.dropna(subset=[outcome.key])
    condition = trials[CONDITION].astype(str).agg(" ".join, axis=1)
    counts = len(trials), trials["participant"].nunique()
    unknown = Variances(np.nan, np.nan, np.nan, *counts)
    scale = float(trials[outcome.key].std())
    frame = pd.DataFrame(
        {
            "y": trials[outcome.key] / scale,
            "condition": condition,
            "block": trials["Trial"].astype(str),
            "participant": trials["participant"].astype(str),
        }
    )
    has_repeats = len(trials) > frame.groupby(["participant", "condition"]).ngroups
    rest = len(trials) - frame["condition"].nunique() - frame["block"].nunique()
    if counts[1] > MOST_PARTICIPANTS:
        return unknown
    if not (scale > 0.0 and counts[1] > 1 and has_repeats and rest > counts[1]):
        return unknown
    try:
        fit = _fit(frame)
    except (np.linalg.LinAlgError, ValueError):
        return unknown
    between, within = float(np.asarray(fit.cov_re)[0, 0]), float(fit.vcomp[0])
    if not fit.converged or not fit.scale > 0.0:
        return unknown
    sds = np.sqrt(np.maximum([between, within, fit.scale], 0.0))
    sds = scale * np.where(sds > NEGLIGIBLE * sds[2], sds, 0.0)
    between, within, rest_sd = (float(f"{sd:.{DIGITS}g}") for sd in sds)
    return Variances(between, within, rest_sd, *counts)


def _fit(frame: pd.DataFrame) -> Any:
    from statsmodels.regression.mixed_linear_model import MixedLM  # slow to import

    formula = "y ~ 0 + C(condition)"
    formula += " + C(block)" if frame["block"].nunique() > 1 else ""
    model = MixedLM.from_formula(
        formula,
        frame,
        groups="participant",
        re_formula="1",
        vc_formula={"condition": "0 + C(condition)"},
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a part of 0 is at the edge of the parameters
        # Other methods of statsmodels stop too early.
        return model.fit(reml=True, method=["powell"], maxiter=30, xtol=1e-5, ftol=1e-9)
