"""The parts of the variance of trials of an outcome, by the mixed model of statistics/nested.py.

A condition is a Haptic and a Rotation, as in the primary analysis and in `experiment power`; an
item is an Object and a Trial. How a person differs in one object, in all conditions alike, is in the
part of trials. Only the parts are taken from the model: its tests of conditions are z tests, which
ten participants are too few for.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.analysis.statistics import parts_of_variance as parts_of_trials

from .experiments import Experiment
from .outcomes import Outcome

# The optimiser finds the parts to 1e-10; this leaves room for another version of SciPy.
DIGITS = 8


@dataclass(frozen=True)
class Variances:
    """Standard deviations in the unit of the outcome: between participants; of how a participant
    differs in one condition; of trials. NaN: the trials do not determine them."""

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
    grid = experiment.grid(outcome)
    people, haptics, rotations = grid.shape[:3]
    parts = parts_of_trials(grid.reshape(people, haptics * rotations, -1))
    variances = [parts.participants, parts.participant_condition, parts.trials]
    between, within, rest = (float(f"{sd:.{DIGITS}g}") for sd in np.sqrt(variances))
    there = ~np.isnan(grid).reshape(people, -1)
    return Variances(between, within, rest, int(there.sum()), int(there.any(axis=1).sum()))
