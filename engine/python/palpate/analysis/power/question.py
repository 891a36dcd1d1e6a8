"""A question about the number of people: what is measured, the effects, and the variances."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from palpate.analysis import tables
from palpate.analysis.errors import InputError
from palpate.analysis.experiment.experiments import HAPTIC, ROTATION
from palpate.analysis.experiment.outcomes import ANGLE, LOSSES, PENETRATION, TIME, Outcome
from palpate.analysis.numbers import number_or_dash
from palpate.analysis.statistics.types import EPSILON, Array

from . import paper
from .contrasts import Contrast, Design, contrasts_of
from .pilot import MOST_VALUE, Pilot, listed, read_pilot

MOST_TRIALS = 1000
# The default grid of both shares, in tenths. The sum of the two is at most nine tenths.
_GRID = [tenths / 10.0 for tenths in range(1, 9)]
_MOST_TOGETHER = 0.9
# Of u and w, for the answer in one number if they are not given: a choice, inside of the grid.
SHARES_OF_ANSWER = (0.3, 0.1)


@dataclass(frozen=True)
class Measure:
    outcome: Outcome
    design: Design = Design(HAPTIC, ROTATION)
    not_normal: str = ""  # why; empty: no warning


MEASURES = {
    "time": Measure(
        TIME, not_normal="a time: it has a long tail and no negative values"),
    "losses": Measure(
        LOSSES, not_normal="a count: it has whole values only, and none below 0"),
    "penetration": Measure(PENETRATION),
    "angle": Measure(ANGLE, Design(("UaH",), ROTATION)),
}


@dataclass
class Study:
    """assumptions: one row for each model, with error_from ("paper, F of Haptic"; "paper's paired
    difference"; "--error"; "pilot"), error_sd (of one trial), share_u and share_w (of its
    variance), the variances u, w and e, and noise: the variance of a person's mean in a condition,
    without u.
    """

    request: argparse.Namespace
    measure: Measure
    contrasts: list[Contrast]
    means: Array  # of the conditions
    trials: int = paper.TRIALS_OF_CONDITION  # of a person in a condition
    paper_scatter: list[paper.Scatter] = field(default_factory=list)  # empty: not the paper's
    pilot: Pilot | None = None
    assumptions: pd.DataFrame = field(default_factory=pd.DataFrame)

    @property
    def unit(self) -> str:
        """ " s"; empty for counts."""
        return f" {self.measure.outcome.unit}" if self.measure.outcome.unit else ""

    @property
    def has_given_variances(self) -> bool:
        """Whether no share of the variance is left to a choice."""
        shares = self.request.share_u, self.request.share_w
        return self.pilot is not None or None not in shares

    @property
    def model_of_answer(self) -> int:
        """The assumption whose shares are the nearest to SHARES_OF_ANSWER; of two errors, the
        larger one."""
        assumed = self.assumptions
        u, w = SHARES_OF_ANSWER
        distance = (assumed["share_u"] - u).abs() + (assumed["share_w"] - w).abs()
        nearest = distance <= distance.min() + 4.0 * EPSILON
        return int(assumed["error_sd"].where(nearest).idxmax())

    @property
    def is_null(self) -> list[bool]:
        return [contrast.is_null(self.means) for contrast in self.contrasts]


def prepare(request: argparse.Namespace) -> Study:
    """Raises InputError: an effect that is no number, is not finite or beyond MOST_VALUE, an
    unknown, repeated or missing condition; shares with a sum above 1, or that leave no variance to
    w and e; a pilot together with --error or a share; --following without a pilot; those of
    read_pilot(); means or shares so large that their rounding would hide the
    scatter.
    """
    measure = MEASURES.get(request.measure)
    if measure is None:
        raise InputError("", "--measure", f"is {tables.quoted(request.measure)}; expected "
                         f"{listed(list(MEASURES))}")
    means = paper.condition_means(measure.outcome)
    if request.effect:
        means = _parse_effects(measure.design, request.effect)
    study = Study(request, measure, contrasts_of(measure.design), means)
    if request.trials is not None:
        study.trials = request.trials
    if request.pilot:
        _take_pilot(study)
    elif request.following:
        raise InputError("", "--following", "is given without --pilot; expected a pilot",
                         "it chooses trials of the pilot's file")
    else:
        _assume_variances(study)
    study.assumptions["noise"] = study.assumptions["w"] + study.assumptions["e"] / study.trials
    _check_scatter(study)
    return study


def _parse_effects(design: Design, text: str) -> Array:
    """ "NoH-R=29.5, ...": the means of the conditions, in the order of the design."""

    def bad(problem: str) -> InputError:
        names = design.conditions
        hint = f"write {names[0]}=29.5,... for each of {', '.join(names)}"
        return InputError("", "--effect", problem, hint)

    found: dict[str, float] = {}
    for part in text.split(","):
        part = part.lstrip(" ")
        name, equals, number = part.partition("=")
        if not equals or name not in design.conditions:
            raise bad(f"has the part {tables.quoted(part)}; expected CONDITION=MEAN")
        value = tables.number_in(number)
        if value is None or not abs(value) <= MOST_VALUE:
            raise bad(f"has {tables.quoted(number)} for {name}; expected a number from -1e9 to 1e9")
        if name in found:
            raise bad(f"has {name} twice; expected each condition once")
        found[name] = value
    for name in design.conditions:
        if name not in found:
            raise bad(f"lacks {name}; expected each condition")
    return np.array([found[name] for name in design.conditions])


def _shares(request: argparse.Namespace) -> list[tuple[float, float]]:
    """Of u and w."""
    given_u, given_w = request.share_u, request.share_w
    both = given_u is not None and given_w is not None
    # A share that was given may leave less than a tenth to e.
    most = (1.0 if both else _MOST_TOGETHER) + 4.0 * EPSILON
    shares = [(u, w) for w in (_GRID if given_w is None else [given_w])
              for u in (_GRID if given_u is None else [given_u]) if u + w <= most]
    if both and not shares:
        raise InputError("", "--share-u", "and --share-w have a sum above 1; expected shares of "
                         "one variance")
    if not shares:
        option = "--share-u" if given_u is not None else "--share-w"
        raise InputError("", option, "leaves no room for the other share, from 0.1 on, and 0.1 for "
                         "e", "give both shares")
    if both and given_u >= 1.0:
        raise InputError("", "--share-u", "is 1; expected less, so that w and e scatter",
                         "u cancels in every test")
    return shares


def _error_variances(study: Study, u: float, w: float) -> Iterator[tuple[str, float]]:
    """The variances of one trial that are assumed with these shares, and where each comes from."""
    if study.request.error is not None:
        yield "--error", study.request.error**2
    elif study.measure.outcome is ANGLE:
        # The paired difference has twice the variance of w and of the mean of 12 e.
        of_mean = w + max(0.0, 1.0 - u - w) / paper.TRIALS_OF_CONDITION
        yield "paper's paired difference", 0.5 * study.paper_scatter[0].sd ** 2 / of_mean
    else:
        for scatter in study.paper_scatter:
            yield f"paper, F of {scatter.source}", scatter.sd**2


def _assume_variances(study: Study) -> None:
    shares = _shares(study.request)
    if study.request.error is None:
        outcome = study.measure.outcome
        is_angle = outcome is ANGLE
        study.paper_scatter = [paper.angle_scatter()] if is_angle else paper.trial_scatter(outcome)
    rows = [
        (source, np.sqrt(variance), u, w, *(variance * np.array([u, w, max(0.0, 1.0 - u - w)])))
        for u, w in shares
        for source, variance in _error_variances(study, u, w)
    ]
    columns = ["error_from", "error_sd", "share_u", "share_w", "u", "w", "e"]
    study.assumptions = pd.DataFrame(rows, columns=columns)


def _take_pilot(study: Study) -> None:
    request = study.request
    for option in ("error", "share_u", "share_w"):
        if getattr(request, option) is not None:
            raise InputError("", f"--{option.replace('_', '-')}", "excludes --pilot; expected one "
                             "of them", "the pilot gives all variances")
    design = study.measure.design
    pilot = read_pilot(request.pilot, request.following, study.measure.outcome, design)
    variances = pilot.variances
    total = sum(variances.values())
    row = {"error_from": "pilot", "error_sd": np.sqrt(total), "share_u": variances["u"] / total,
           "share_w": variances["w"] / total, **variances}
    study.assumptions = pd.DataFrame([row])
    if request.trials is None:
        study.trials = int(np.clip(np.floor(pilot.m + 0.5), 1, MOST_TRIALS))
    study.pilot = pilot


def _check_scatter(study: Study) -> None:
    """The scatter is not hidden by the rounding of the means or of the shares."""
    least = np.sqrt(EPSILON)
    largest = float(np.abs(study.means).max())
    for total, noise in study.assumptions[["error_sd", "noise"]].to_numpy():
        sd = float(np.sqrt(noise))
        if not sd > least * total:
            if study.pilot:
                raise _bad_scale(study, sd, total)
            raise InputError("", "--share-u", "leaves w and e a standard deviation of "
                             f"{number_or_dash(sd)} beside {number_or_dash(total)} of one trial; "
                             "expected less", "u cancels in every test")
        if not sd > least * largest:
            raise _bad_scale(study, sd, largest)


def _bad_scale(study: Study, sd: float, largest: float) -> InputError:
    """What makes the scatter so small beside the means."""
    path, element = "", "--error" if study.request.error is not None else "--effect"
    if study.pilot:
        path, element = study.request.pilot, f"column {study.measure.outcome.column}"
    problem = (f"gives a standard deviation of {number_or_dash(sd)} of w and e beside means of up "
               f"to {number_or_dash(largest)}; expected numbers of one scale")
    return InputError(path, element, problem, "check the unit of the effects")
