"""What a reader of a study must know: what is assumed, what is not normal, and what the numbers of
people leave out."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from palpate.analysis.experiment.outcomes import ANGLE, Outcome
from palpate.analysis.experiment.paper import MEANS, F
from palpate.analysis.numbers import number_or_dash, p_text, with_decimals
from palpate.analysis.statistics.types import EPSILON

from . import paper
from .pilot import Pilot
from .question import Study

# Means that differ by more than this factor are probably in different units.
_MOST_UNIT_FACTOR = 5.0


def notes(study: Study) -> list[str]:
    """Sentences. The first ones warn of what may be a mistake."""
    found: list[str] = []
    if study.pilot:
        found += _about_units(study, study.pilot)
    if study.measure.not_normal:
        found.append(f"The model is normal, and the measure is {study.measure.not_normal}. Take "
                     "the numbers of people as approximate.")
    found += _about_effects(study)
    found += _about_pilot(study, study.pilot) if study.pilot else _about_error(study)
    return [*found, *_about_model(study)]


def _about_units(study: Study, pilot: Pilot) -> Iterator[str]:
    means = np.array([pilot.means.mean(), study.means.mean()])
    least, most = np.sort(np.abs(means))
    if most > _MOST_UNIT_FACTOR * least or means.prod() < 0.0:
        of_pilot, of_effects = (number_or_dash(mean) + study.unit for mean in means)
        yield (f"Check the units: the mean of the pilot is {of_pilot}, and that of the effects is "
               f"{of_effects}.")


def _about_effects(study: Study) -> Iterator[str]:
    if study.request.effect:
        yield ("The numbers of people are for effects as large as those of --effect; smaller ones "
               "need more people.")
        return
    yield ("Effects of a study that was published because they were significant are too large on "
           "average: numbers of people from them are a lower bound.")
    outcome = study.measure.outcome
    rounded = "These means are rounded, and so are the effects: "
    if outcome is ANGLE:
        yield ("The effects are the paper's means of UaH; the paper states no contact angle of the "
               f"other levels of Haptic. {rounded}{_rounded(outcome, 'R', 'NoR')}.")
        return
    rounded += f"{_rounded(outcome, 'H', 'NoH')}, and {_rounded(outcome, 'R', 'NoR')}."
    yield ("The effects are the paper's means at the levels of Haptic and of Rotation. It states "
           "no means of their combinations: that the two add up, without an interaction, is an "
           f"assumption. {rounded}")
    if not F[outcome, ("Haptic", "Rotation")][1]:
        yield "The paper found an interaction in this measure, which these effects lack."


def _rounded(outcome: Outcome, level: str, other: str) -> str:
    """ "R - NoR = 1 may be 0 to 2"."""
    a, b = MEANS[outcome, level][0], MEANS[outcome, other][0]
    off = paper.rounding(a) + paper.rounding(b)
    # A difference of decimal numbers, of which four are rounded.
    least = 4.0 * EPSILON * (abs(a) + abs(b))
    text, low, high = (number_or_dash(0.0 if abs(value) <= least else value)
                       for value in (a - b, a - b - off, a - b + off))
    return f"{level} - {other} = {text} may be {low} to {high}"


def _about_error(study: Study) -> Iterator[str]:
    request = study.request
    if request.error is None and study.measure.outcome is ANGLE:
        yield ("The scatter is that of the paper's paired difference, which fixes w and the mean "
               "of 12 e together: with 12 trials in a condition, the shares make no "
               "difference.")
    elif request.error is None:
        yield ("The error of one trial is that of the paper's own model, from its F and its means, "
               "which are rounded. It holds u, w and e; the paper does not say how much of "
               "each.")
        yield from _about_incompatible_errors(study)
    if request.share_u is None or request.share_w is None:
        yield ("The shares that are not given run from 0.1 to 0.8 in steps of 0.1, with at least "
               "0.1 for e. They are assumptions; a pilot measures them.")


def _about_incompatible_errors(study: Study) -> Iterator[str]:
    """Which of the paper's two errors the other one's rounding excludes."""
    for one in study.paper_scatter:
        for other in study.paper_scatter:
            if not other.allows(one.sd):
                yield (
                    f"The error {number_or_dash(one.sd)}{study.unit} from the F of {one.source} is "
                    f"incompatible with the F of {other.source}: the rounding of its means allows "
                    f"{number_or_dash(other.low)} to {number_or_dash(other.high)}{study.unit}. The "
                    f"F of {one.source} allows {number_or_dash(one.low)} to "
                    f"{number_or_dash(one.high)}{study.unit}; both F have the same error."
                )


def _about_pilot(study: Study, pilot: Pilot) -> Iterator[str]:
    m, trials = number_or_dash(pilot.m), study.trials
    if pilot.m != trials and study.request.trials is not None:
        yield (f"The pilot has m = {m} trials of a person in a condition, and --trials is "
               f"{trials}: the variance of e is divided by {trials}.")
    elif pilot.m != trials:
        yield (f"The pilot's m is {m} trials of a person in a condition, an effective number; "
               f"{trials} are used.")
    yield from _about_fit(pilot)
    df = pilot.df["pc"]
    yield ("A mean square of the pilot with d degrees of freedom has a relative standard error of "
           f"sqrt(2 / d): MS_pc has {df}, which gives "
           f"{with_decimals(100.0 * np.sqrt(2.0 / df), 0)} %. "
           "The power inherits this error, which its interval does not show.")
    for name in ("u", "w"):
        if pilot.raw[name] < 0.0:
            yield (f"The pilot's estimate of the variance of {name} is "
                   f"{number_or_dash(pilot.raw[name])}, which is negative; 0 is used.")
    if pilot.left_out:
        yield ("Left out of the pilot, because a condition has no completed trial of theirs: "
               f"{', '.join(pilot.left_out)}.")
    if pilot.missing:
        yield (f"{pilot.missing} of {pilot.missing + pilot.trials} trials of the pilot are missing "
               "(timeouts, faults, absent). The estimates hold if they are missing at random; a "
               "long trial that ran into the time limit is not.")


def _about_fit(pilot: Pilot) -> Iterator[str]:
    """What is common to objects in all conditions of a person is in MS_e alone."""
    if not pilot.raw["w"] < 0.0:
        return
    pc, e = pilot.mean_squares["pc"], pilot.mean_squares["e"]
    yield (f"The noise of the model, MS_e / m = {number_or_dash(e / pilot.m)}, is larger than what "
           f"was observed, MS_pc / m = {number_or_dash(pc / pilot.m)}, by the factor "
           f"{number_or_dash(e / pc if pc else np.inf)}. Numbers of people grow about in "
           "proportion to the noise.")
    if pilot.is_too_low:
        yield (f"The model does not fit this pilot: F = MS_pc / MS_e = {number_or_dash(pilot.f)} "
               f"with {pilot.df['pc']} and {pilot.df['e']} degrees of freedom is significantly "
               f"below 1 ({p_text(pilot.p_below)}). It has no term for how a person differs in one "
               "object, in all conditions alike. Such scatter stays in MS_e and cancels in the "
               "tests, so that the numbers of people are too large.")


def _about_model(study: Study) -> Iterator[str]:
    yield ("u, how people differ in all conditions alike, cancels in every test; what counts is "
           "the variance of w plus that of e divided by the trials in a condition.")
    sphericity = (" Sphericity therefore holds in the model, and what the correction of Greenhouse "
                  "and Geisser really costs, where it does not hold, is not shown.")
    yield ("w and e are independent and scatter equally in all conditions."
           + (sphericity if len(study.means) > 2 else ""))
    pilot = study.pilot
    as_there = ", as in the pilot" if pilot and (pilot.missing or pilot.left_out) else ""
    yield ("A number of people counts people with completed trials in every condition. If trials "
           f"or people will be missing{as_there}, more people are needed.")
