"""Variances of the model of simulation.py, from the trials of a pilot.

The trials are those of one following, or of people.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pandas as pd
from scipy.sparse.csgraph import connected_components

from palpate.analysis.errors import InputError, printable
from palpate.analysis.experiment.experiments import (
    SEEN,
    SEEN_CLAIM,
    Experiment,
    Variant,
    experiments_of,
    without_pilots,
)
from palpate.analysis.experiment.outcomes import Outcome
from palpate.analysis.numbers import number_or_dash
from palpate.analysis.statistics import SIGNIFICANCE, f_tail
from palpate.analysis.statistics.types import EPSILON, Array
from palpate.analysis.trials import read_trials

from .contrasts import Contrast, Design

# The largest mean, standard deviation and value of a pilot, in the unit of the measure: far beyond
# any measure, and small enough that no square overflows.
MOST_VALUE = 1e9
PEOPLE = "people"
_ANY_LIMIT_S = 120.0  # of an outcome that power does not have
_WITHOUT = "use --error, --share-u and --share-w"


def listed(names: list[str]) -> str:
    """ "a, b or c"."""
    return " or ".join(filter(None, [", ".join(names[:-1]), names[-1]]))


@dataclass
class Pilot:
    """Estimates: e = MS_e, w = (MS_pc - MS_e) / m, u = (MS_p - MS_pc) / (k m), k conditions.

    MS_p is the mean square between people, MS_pc that of people x conditions. MS_e is that of the
    trials within a person and a condition, less what is common to all people in a condition, an
    object and a block: the objects and blocks of an experiment are fixed, and cancel in its
    comparisons, as in the paper's own error.

    Missing trials: within a condition, the means of people are adjusted for the objects and blocks
    that they lack (least squares), and m is the number of trials that would give the adjusted means
    their mean variance. With it the estimates are unbiased, if trials are missing at random.
    Without missing trials m is exactly their number, and this is the usual analysis of variance.

    `experiment analyse` has the same u, w and e by restricted maximum likelihood
    (statistics/nested.py), which is the same without missing trials, unless an estimate is
    negative. It then pools mean squares, for example a low MS_p with MS_pc. Power does not: u cancels in the
    tests, and MS_pc / m = w + e / m is the scatter that they see.

    The model has no term for how a person differs in one object, in all conditions alike. Such
    scatter stays in MS_e and cancels in MS_pc, so that w is estimated too low, and often below 0.
    """

    participants: int = 0  # who have all conditions
    left_out: list[str] = field(default_factory=list)  # people who lack a condition
    trials: int = 0  # that count
    missing: int = 0  # of these people: timeouts, faults, absent
    m: float = 0.0  # trials of a person in a condition
    mean_squares: dict[str, float] = field(default_factory=dict)  # p, pc, e
    df: dict[str, int] = field(default_factory=dict)  # p, pc, e
    raw: dict[str, float] = field(default_factory=dict)  # u, w, e; may be negative
    means: Array = field(default_factory=lambda: np.zeros(0))  # of the conditions, over people
    cells: Array = field(default_factory=lambda: np.zeros((0, 0)))  # people x conditions, adjusted

    @property
    def variances(self) -> dict[str, float]:
        """Negative estimates are 0."""
        return {name: max(0.0, value) for name, value in self.raw.items()}

    def noise(self) -> float:
        """The variance of a person's mean in a condition, with the pilot's m."""
        return self.variances["w"] + self.variances["e"] / self.m

    @property
    def f(self) -> float:
        """MS_pc / MS_e; by the model at least 1 on average. NaN: both are 0."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return float(np.divide(self.mean_squares["pc"], self.mean_squares["e"]))

    @property
    def p_below(self) -> float:
        """P(F(df_pc, df_e) <= f): small if f is too low for the model."""
        inverse = np.inf if self.f == 0.0 else 1.0 / self.f  # F(df_e, df_pc)
        return float(f_tail(inverse, self.df["e"], self.df["pc"]))

    @property
    def is_too_low(self) -> bool:
        return self.p_below < SIGNIFICANCE

    def pairs(self, contrasts: list[Contrast]) -> pd.DataFrame:
        """The standard deviation over people of the difference of their means in each pair: in the
        pilot, which has MS_pc's parts of this pair alone, and by the model."""
        pairs = [contrast for contrast in contrasts if contrast.family]
        weights = np.hstack([pair.weights for pair in pairs])
        observed = (self.cells @ weights).std(axis=0, ddof=1)
        model = np.sqrt(self.noise() * np.square(weights).sum(axis=0))
        return pd.DataFrame({"pilot": observed, "model": model}, index=[p.name for p in pairs])


def read_pilot(path: str, following: str, outcome: Outcome, design: Design) -> Pilot:
    """The estimates from the trials of one following in a file. following: as in the file, `people`
    for rows without a following, or empty if the file has one kind only.

    Raises InputError as read_trials(), experiment_of() and estimate() do.
    """
    frame = read_trials(path)
    try:
        return estimate(experiment_of(frame, following, design), outcome, design)
    except InputError as error:
        if error.element == "--following":
            error.hint = f"these are in {printable(path)}"
        else:
            error.path = path
        raise


def experiment_of(frame: pd.DataFrame, following: str, design: Design) -> Experiment:
    """The trials of one following, beside practice and trials at other levels of Haptic than those
    of the design.

    Raises InputError as experiments_of() does, and for trials with a strategy or a seen force,
    several followings,
    a following that is not there, and several variants.
    """
    with_strategy = frame[frame["strategy"] != ""]
    if len(with_strategy):
        row = with_strategy.iloc[0]
        raise InputError("", "column strategy", f"is {row['strategy']} in a trial of participant "
                         f"{printable(row['participant'])}; expected trials with haptic and "
                         "rotation", "use the trials of `experiment run` or of people")
    if len(seen := frame[frame["haptic"].isin(SEEN)]):
        raise InputError("", "column haptic", f"is {seen.iloc[0]['haptic']} in a trial of participant "
                         f"{printable(seen.iloc[0]['participant'])}; expected NoH, UaH and H: "
                         f"{SEEN_CLAIM}")
    frame = _of_following(frame, following)
    if len(others := without_pilots(frame)):  # a pilot run alone counts
        frame = others
    frame = frame[frame["block"] > 0]
    if frame.empty:
        raise InputError("", "participant", "has 0 levels beside practice; expected two "
                         "participants or more", "the analysis is about differences between "
                         "participants")
    frame = frame[frame["haptic"].isin(design.haptic)]
    if frame.empty:
        raise InputError("", "column haptic", f"has no trial of {listed(list(design.haptic))} "
                         f"beside practice; expected trials of {len(design.conditions)} conditions",
                         "the measure needs them; choose another one with --measure")
    _check_one_variant(frame)
    return experiments_of(frame, _ANY_LIMIT_S)[0]


def _of_following(frame: pd.DataFrame, following: str) -> pd.DataFrame:
    names = frame["following"].replace("", PEOPLE)
    kinds = sorted(set(names))
    if not following and len(kinds) > 1:
        raise InputError("", "column following", f"has trials of {len(kinds)} kinds; expected "
                         "one kind", f"choose one with --following: {listed(kinds)}")
    if following and following not in kinds:
        raise InputError("", "--following", f'is "{printable(following)}"; expected '
                         f"{listed(kinds)}")
    return frame[names == following] if following else frame


def _check_one_variant(frame: pd.DataFrame) -> None:
    """Each variant is an experiment of its own."""
    columns = ["view", "align", "scale", "start_orientation_deg"]  # of Variant, in this order
    assert set(columns) == set(Variant._fields)
    differs = frame[columns] != frame[columns].iloc[0]
    other = differs[differs.any(axis=1)]
    if other.empty:
        return
    column = columns[int(np.argmax(other.iloc[0].to_numpy()))]
    raise InputError("", f"column {column}", "has several levels; expected trials of one "
                     "experiment", "keep the rows of one level in a file of their own")


def estimate(experiment: Experiment, outcome: Outcome, design: Design) -> Pilot:
    """The estimates from an experiment with the levels of Haptic of the design, at most.

    Raises InputError: fewer than two people with all conditions, a condition that is not there, no
    trials from which e can be estimated, objects and blocks that no people have in common, a value
    beyond MOST_VALUE, a measure that does not vary.
    """
    trials = _trials(experiment, outcome, design)
    pilot = Pilot()
    has_all = np.asarray(~np.isnan(trials).all(axis=2))
    for name, has in zip(map(printable, experiment.participants), has_all):
        if not has.all():
            pilot.left_out.append(name)
    complete = np.asarray(has_all.all(axis=1))
    pilot.participants = int(complete.sum())
    if pilot.participants < 2:
        first = design.conditions[int(np.argmin(has_all[int(np.argmin(complete))]))]
        people = "participant" if pilot.participants == 1 else "participants"
        raise InputError("", "column participant", f"has {pilot.participants} {people} with a "
                         f"completed trial in each of {len(design.conditions)} conditions "
                         f"({pilot.left_out[0]} lacks {first}); expected two or more",
                         f"add their trials, or {_WITHOUT} without a pilot")
    names = [n for n, is_in in zip(experiment.participants, complete) if is_in]
    fits = [_fit_condition(_checked(trials[complete, c], name, names, outcome))
            for c, name in enumerate(design.conditions)]
    pilot.missing = int(np.isnan(trials[complete]).sum())
    pilot.trials = trials[complete].size - pilot.missing
    _put_mean_squares(pilot, fits, outcome)
    ms = pilot.mean_squares
    pilot.raw = {"u": (ms["p"] - ms["pc"]) / (len(fits) * pilot.m),
                 "w": (ms["pc"] - ms["e"]) / pilot.m, "e": ms["e"]}
    return pilot


def _trials(experiment: Experiment, outcome: Outcome, design: Design) -> Array:
    """(people, conditions, objects and blocks); NaN: no trial."""
    for factor, names in (("Haptic", design.haptic), ("Rotation", design.rotation)):
        for name in names:
            if name not in experiment.levels[factor]:
                problem = (f"has no trial of {name} beside practice; expected trials of "
                           f"{len(design.conditions)} conditions")
                hint = f"without such a pilot, {_WITHOUT}"
                raise InputError("", f"column {factor.lower()}", problem, hint)
    if not experiment.has(outcome):
        raise InputError("", f"column {outcome.column}", "has no value in a completed trial; "
                         "expected the measure of --measure", "choose another measure")
    grid = experiment.grid(outcome)
    return grid.reshape(len(grid), len(design.conditions), -1)


def _checked(trials: Array, condition: str, names: list[str], outcome: Outcome) -> Array:
    """The trials of a condition, (people, objects and blocks), without objects and blocks that
    nobody did."""
    used = trials[:, ~np.isnan(trials).all(axis=0)]
    large = np.argwhere(np.abs(used) > MOST_VALUE)
    if len(large):
        person, item = large[0]
        value, name = number_or_dash(used[person, item]), printable(names[person])
        raise InputError("", f"column {outcome.column}",
                         f"is {value} in a trial of participant {name}, which is too large; "
                         "expected -1e9 to 1e9", "check the unit of the column")
    has = (~np.isnan(used)).astype(float)
    if connected_components(has @ has.T, directed=False)[0] > 1:
        raise InputError("", f"condition {condition}", "has participants whose objects and blocks "
                         "no other participant has; expected the same objects and blocks for all",
                         "remove the trials that nobody else did")
    return used


@dataclass(frozen=True)
class _Fit:
    """Least squares of y = person + item in one condition, an item being an object and a block."""

    means: Array  # of the people, over all items
    residual_ss: float
    df: int
    m: float  # trials of a person: complete, their number; otherwise the effective number


def _fit_condition(trials: Array) -> _Fit:
    """Eliminates the people: with A the table of what is there, D the numbers of a person's trials,
    C those of an item's and y-bar the plain means, the items t solve S t = sum over people of
    A (y - y-bar), S = C - A^T D^-1 A, with the sum 0. Then the means are y-bar - D^-1 A t, with the
    covariance V = D^-1 + D^-1 A S^+ A^T D^-1. The variance of their differences is
    trace((I - J / n) V), J a matrix of ones."""
    n, items = trials.shape
    has = ~np.isnan(trials)
    there = np.where(has, trials, 0.0)
    counts = has.sum(axis=1)
    plain = there.sum(axis=1) / counts
    shares = has / counts[:, None]  # D^-1 A
    # Of constants, S is 0; on the sums of 0, adding J / items changes nothing.
    s = np.diag(has.sum(axis=0)) - has.T @ shares + 1.0 / items
    of_items = np.linalg.solve(s, (has * (there - plain[:, None])).sum(axis=0))
    means = plain - shares @ of_items
    residuals = has * (there - means[:, None] - of_items)
    centred = shares - shares.mean(axis=0)
    scatter = (1.0 / counts).sum() * (1.0 - 1.0 / n)
    scatter += (np.linalg.solve(s, centred.T) * centred.T).sum()
    m = items if has.all() else (n - 1.0) / scatter
    df = int(has.sum()) - (n + items - 1)
    return _Fit(means, float(np.square(residuals).sum()), df, float(m))


def _put_mean_squares(pilot: Pilot, fits: list[_Fit], outcome: Outcome) -> None:
    cells = np.column_stack([fit.means for fit in fits])
    n, k = cells.shape
    df_e = sum(fit.df for fit in fits)
    if df_e == 0:
        problem = f"have so few trials in common that the {pilot.trials} trials only fix the " \
                  "means of participants, objects and blocks; expected two objects or blocks " \
                  "that the same two participants did in one condition"
        if pilot.trials == n * k:
            problem = "have one trial of a participant in a condition; expected two or more, " \
                      "because the scatter of trials cannot be told from that of conditions " \
                      "otherwise"
        raise InputError("", "columns object and block", problem, f"{_WITHOUT} without a pilot")
    of_m = np.array([fit.m for fit in fits])
    # The harmonic mean, without rounding if all conditions have the same m.
    pilot.m = float(of_m[0] if (of_m == of_m[0]).all() else k / (1.0 / of_m).sum())
    pilot.df = {"p": n - 1, "pc": (n - 1) * (k - 1), "e": df_e}
    within = cells - cells.mean(axis=0)
    of_people = within.mean(axis=1, keepdims=True)
    squares = {"p": pilot.m * k * np.square(of_people).sum(),
               "pc": pilot.m * np.square(within - of_people).sum(),
               "e": sum(fit.residual_ss for fit in fits)}
    pilot.mean_squares = {part: float(ss) / pilot.df[part] for part, ss in squares.items()}
    pilot.means, pilot.cells = cells.mean(axis=0), cells
    # Each number is a sum of at most `trials` rounded terms.
    rounding = (pilot.trials * EPSILON * np.abs(cells).max()) ** 2
    ms = pilot.mean_squares
    if not (ms["e"] > rounding or ms["pc"] > pilot.m * rounding):
        raise InputError("", f"column {outcome.column}", "does not vary beside what all "
                         "participants have in common; expected a measure with scatter",
                         "check the column")
