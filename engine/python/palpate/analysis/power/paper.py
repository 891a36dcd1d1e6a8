"""What the paper (Lécuyer et al., 2005) states about the scatter and the effects of a measure."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from palpate.analysis.experiment.experiments import HAPTIC, ROTATION
from palpate.analysis.experiment.outcomes import ANGLE, Outcome
from palpate.analysis.experiment.paper import MEANS, F
from palpate.analysis.numbers import as_printed
from palpate.analysis.statistics.types import Array

PARTICIPANTS = 10
TRIALS_OF_CONDITION = 12  # 4 objects in 3 blocks
_TRIALS = PARTICIPANTS * TRIALS_OF_CONDITION * len(HAPTIC) * len(ROTATION)


@dataclass(frozen=True)
class Scatter:
    """A standard deviation that follows from the paper's means and one of its F."""

    source: str  # the effect whose F it is: "Haptic"
    sd: float
    # What the printed means allow: each may be off by half of its last printed digit. The rounding
    # of F is not in it: it is at most 0.1 %.
    low: float
    high: float

    def allows(self, other: float) -> bool:
        return self.low <= other <= self.high


def rounding(mean: float) -> float:
    """Half of the last digit with which the paper prints a mean: 0.5 for 29, 0.05 for 27.5."""
    return float(0.5 * 10.0 ** -len(as_printed(mean).partition(".")[2]))


def level_means(outcome: Outcome, levels: tuple[str, ...]) -> Array:
    return np.array([MEANS[outcome, level][0] for level in levels])


def trial_scatter(outcome: Outcome) -> list[Scatter]:
    """The standard deviation of one trial in the paper's own model, which treats all trials as
    independent: the root of its mean square of the error, from the F of Haptic and from that of
    Rotation, ascending. It holds u, w and e. Of the time, the losses and the penetration."""
    levels = {"Haptic": HAPTIC, "Rotation": ROTATION}
    found = [_trial_scatter(outcome, factor, names) for factor, names in levels.items()]
    return sorted(found, key=lambda scatter: scatter.sd)


def _trial_scatter(outcome: Outcome, factor: str, levels: tuple[str, ...]) -> Scatter:
    means = level_means(outcome, levels)
    # F is the mean square of the effect divided by that of the error.
    scale = _TRIALS / len(means) / (len(means) - 1.0) / F[outcome, (factor,)][0]
    low, high = _squares_range(means)
    return Scatter(factor, *np.sqrt(scale * np.array([_squares(means), low, high])).tolist())


def _squares(means: Array) -> float:
    return float(np.square(means - means.mean()).sum())


def _squares_range(means: Array) -> tuple[float, float]:
    """The least and the largest sum of squares about their mean of values within `means` +- half a
    digit. It is convex, so that the largest is at a corner. The least is where all values are as
    near to one centre as they can be; the squared distances from a centre are convex, too, and
    quadratic between two ends."""
    halves = np.array([rounding(mean) for mean in means])
    low, high = means - halves, means + halves
    most = max(_squares(np.array(corner)) for corner in product(*zip(low, high)))
    ends = np.sort(np.concatenate([low, high]))
    least = most
    for begin, end in zip(ends, ends[1:]):
        middle = 0.5 * (begin + end)
        nearest = np.concatenate([high[high < middle], low[low > middle]])
        if not nearest.size:
            return 0.0, most
        centre = np.clip(nearest.mean(), begin, end)
        least = min(least, float(np.square(nearest - centre).sum()))
    return least, most


def angle_scatter() -> Scatter:
    """The standard deviation over people of their difference R - NoR in the contact angle of UaH;
    each value is the mean of TRIALS_OF_CONDITION trials. F(1, n - 1) is the square of the paired t.
    """
    means = level_means(ANGLE, ROTATION)
    scale = np.sqrt(PARTICIPANTS / F[ANGLE, ("Rotation",)][0])
    off = sum(rounding(mean) for mean in means)
    differences = abs(means[1] - means[0]) + np.array([0.0, -off, off])
    return Scatter("Rotation", *(scale * differences).tolist())


def condition_means(outcome: Outcome) -> Array:
    """Of the conditions in which the measure is tested. Of the time, the losses and the
    penetration, the paper states the means at the levels of Haptic and of Rotation only; this sum
    of both, less their mean, assumes that there is no interaction."""
    rotation = level_means(outcome, ROTATION)
    if outcome is ANGLE:
        return rotation
    haptic = level_means(outcome, HAPTIC)[:, None]
    return np.asarray((haptic + rotation - rotation.mean()).ravel())
