"""Compares the effects of a file with those of the paper.

A finding that states an order needs every difference between two levels; one that states no effect
needs every contrast of the effect. Each difference is a paired one of participants' means. A
finding agrees only if all of its comparisons do, with Holm's p; one comparison that disagrees
decides, so that their intervals are 95 % intervals of all of them together (Bonferroni).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from palpate.analysis.numbers import number_or_dash, p_text
from palpate.analysis.statistics import (
    SIGNIFICANCE,
    PairedT,
    holm,
    paired_t,
    t_for_coverage,
    t_tail,
)
from palpate.analysis.statistics.types import Array

from .experiments import Experiment
from .outcomes import Outcome
from .paper import RH, Claim, Effect, Finding, difference, equivalence_margin
from .primary import Primary

VERDICTS = AGREES, DISAGREES, UNDECIDED, NOT_TESTABLE = (
    "agrees", "disagrees", "undecided", "not testable")  # fmt: skip


@dataclass(frozen=True)
class Comparison:
    """A difference that a verdict needs; positive in the direction of the paper.

    ours: with an interval for all comparisons of the finding. p: two-sided; with a margin, of two
    one-sided tests that the difference is within it. p_holm: adjusted over all comparisons of the
    finding.
    """

    name: str
    participants: int
    ours: Effect
    paper: Effect | None
    margin: float | None
    p: float
    p_holm: float

    @property
    def verdict(self) -> str:
        if np.isnan(self.p_holm):
            return NOT_TESTABLE
        low, high = self.ours.low, self.ours.high
        is_significant = self.p_holm < SIGNIFICANCE
        if self.margin is not None:
            is_beyond = low > self.margin or high < -self.margin
            return AGREES if is_significant else DISAGREES if is_beyond else UNDECIDED
        assert self.paper is not None
        if high < 0.0 or high < self.paper.low or low > self.paper.high:
            return DISAGREES
        return AGREES if is_significant and self.ours.difference > 0.0 else UNDECIDED

    @property
    def _how(self) -> str:
        """In which way it disagrees with the paper."""
        if self.verdict != DISAGREES or self.paper is None:
            return ""
        if self.ours.high < 0.0:
            return ": the other way here"
        return ": smaller here" if self.ours.high < self.paper.low else ": larger here"

    def text(self, unit: str) -> str:
        """ "NoH - UaH 1.5 s (0.8 to 2.2), p = 0.002; the paper 1.5 s (-0.66 to 3.66)"."""
        words = f"{self.name} {_effect_text(self.ours, unit)}, "
        if self.margin is not None:
            margin = f"{number_or_dash(self.margin)} {unit}".rstrip()
            return f"{words}within \u00b1{margin}: {p_text(self.p_holm)}"
        words += p_text(self.p_holm)
        assert self.paper is not None
        return f"{words}; the paper {_effect_text(self.paper, unit)}{self._how}"


def _effect_text(effect: Effect, unit: str) -> str:
    ends = f"({number_or_dash(effect.low)} to {number_or_dash(effect.high)})"
    return " ".join(filter(None, [number_or_dash(effect.difference), unit, ends]))


def comparisons_of(
    experiment: Experiment, primary: Primary, finding: Finding
) -> list[Comparison]:
    """The comparisons of an order, or of no effect; none if the file lacks a level."""
    assert finding.outcome is not None
    haptic, rotation = experiment.levels["Haptic"], experiment.levels["Rotation"]
    cells = primary.cells
    if finding.term == RH:
        if len(rotation) < 2:
            return []
        of_rotation = np.moveaxis(cells[:, :, 1] - cells[:, :, 0], 1, 0)
        by_level: dict[str, Array] = dict(zip(haptic, of_rotation))
        pairs = [(b, a) for a, b in combinations(haptic, 2)]
        name = "R - NoR in {}, less in {}"
    elif finding.term == ("Haptic",):
        by_level = dict(zip(haptic, np.moveaxis(cells.mean(axis=2), 1, 0)))
        pairs = [(b, a) for a, b in combinations(finding.ascending, 2)]
        name = "{} - {}"
    else:
        by_level = dict(zip(rotation, np.moveaxis(cells.mean(axis=1), 1, 0)))
        pairs = [(b, a) for a, b in combinations(finding.ascending or ("NoR", "R"), 2)]
        name = "{} - {}"
    if not all(level in by_level for pair in pairs for level in pair):
        return []
    return _compared(finding, finding.outcome, pairs, by_level, name)


def _compared(
    finding: Finding,
    outcome: Outcome,
    pairs: list[tuple[str, str]],
    by_level: dict[str, Array],
    name: str,
) -> list[Comparison]:
    tests = [paired_t(by_level[a], by_level[b]) for a, b in pairs]
    margin = equivalence_margin(outcome) if finding.claim is Claim.NO_EFFECT else None
    ps = [test.p if margin is None else _equivalence(test, margin) for test in tests]
    return [
        Comparison(
            name.format(a, b),
            test.pairs,
            _effect(test, len(pairs)),
            difference(outcome, a, b) if finding.claim is Claim.ORDER else None,
            margin,
            p,
            p_holm,
        )
        for (a, b), test, p, p_holm in zip(pairs, tests, ps, holm(ps))
    ]


def _effect(test: PairedT, comparisons: int) -> Effect:
    coverage = 1.0 - SIGNIFICANCE / comparisons
    half = t_for_coverage(test.df, coverage) * test.standard_error
    return Effect(test.difference, test.difference - half, test.difference + half)


def _equivalence(test: PairedT, margin: float) -> float:
    """The p of two one-sided tests (Schuirmann, 1987) that a difference is within +-margin."""
    inside = (margin - abs(test.difference)) / test.standard_error
    return float(t_tail(inside, test.df))  # the larger one


def verdict_of(comparisons: list[Comparison]) -> str:
    """All must agree; one that disagrees decides."""
    verdicts = {comparison.verdict for comparison in comparisons}
    for verdict in (DISAGREES, NOT_TESTABLE, UNDECIDED):
        if verdict in verdicts or not verdicts:
            return verdict if verdicts else NOT_TESTABLE
    return AGREES
