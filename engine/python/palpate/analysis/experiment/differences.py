"""Paired differences between the experiments of a file, which have the same people and random
numbers."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations, product

import pandas as pd

from palpate.analysis.statistics import PairedT, paired_t

from .experiments import FACTORS, VARIANT, Experiment, Variant
from .outcomes import ANGLE, LOSSES, PENETRATION, TIME, TIME_TO_LIMIT, Outcome

# A setting with more levels than this is compared with its first level only.
MOST_LEVELS_IN_PAIRS = 6


@dataclass(frozen=True)
class Difference:
    """second - first at a level of Haptic and of Rotation. The value of a participant is the mean
    of the differences between trials with the same object and block, of which both have the
    outcome."""

    first: Experiment
    second: Experiment
    outcome: Outcome
    haptic: str
    rotation: str
    test: PairedT


def differences_of(experiments: list[Experiment]) -> list[Difference]:
    """Two experiments are compared if their variants differ in one setting, and if both are of
    people or both of simulated persons. Simulated persons have the same following; with two views,
    each following of the still view is compared with the first following of the turning view:
    without rotation they have the same rows, and with it the followings of the still view state
    what the person adapts to."""
    variants = sorted({e.variant for e in experiments}, key=Variant.order)
    few = {s: list(dict.fromkeys(getattr(variant, s) for variant in variants)) for s in VARIANT}
    return [
        difference
        for a, b in combinations(experiments, 2)
        if _are_compared(a, b, experiments, few)
        for difference in _differences(a, b)
    ]


def _are_compared(
    a: Experiment, b: Experiment, experiments: list[Experiment], levels: dict[str, list[object]]
) -> bool:
    differ = [s for s in VARIANT if getattr(a.variant, s) != getattr(b.variant, s)]
    if a.is_simulated != b.is_simulated or len(differ) != 1:
        return False
    found = levels[differ[0]]
    if len(found) > MOST_LEVELS_IN_PAIRS and found[0] not in (
        getattr(a.variant, differ[0]),
        getattr(b.variant, differ[0]),
    ):
        return False
    if differ[0] != "view" or not a.is_simulated:
        return a.following == b.following
    turning = a if a.variant.view == "turning" else b
    alike = [e for e in experiments if e.variant == turning.variant and e.is_simulated]
    return turning is alike[0]


def _by_trial(experiment: Experiment) -> pd.DataFrame:
    """The outcomes, indexed by names: two experiments may have different levels."""
    keys = ["participant", *FACTORS]
    return experiment.trials.astype({key: str for key in keys}).set_index(keys)


def _differences(a: Experiment, b: Experiment) -> list[Difference]:
    first, second = _by_trial(a).align(_by_trial(b), join="inner", axis=0)
    common = {
        factor: [level for level in a.levels[factor] if level in b.levels[factor]]
        for factor in ("Haptic", "Rotation")
    }
    found = []
    for outcome in (TIME, TIME_TO_LIMIT, LOSSES, PENETRATION, ANGLE):
        if not (a.has(outcome) and b.has(outcome)):
            continue
        if outcome is TIME_TO_LIMIT and not (a.has_timeouts or b.has_timeouts):
            continue
        both = pd.DataFrame({"first": first[outcome.key], "second": second[outcome.key]}).dropna()
        means = both.groupby(["Haptic", "Rotation", "participant"]).mean()
        conditions = dict(iter(means.groupby(["Haptic", "Rotation"])))
        for haptic, rotation in product(common["Haptic"], common["Rotation"]):
            pair = conditions.get((haptic, rotation), means.iloc[:0])
            test = paired_t(pair["second"], pair["first"])
            found.append(Difference(a, b, outcome, haptic, rotation, test))
    return found
