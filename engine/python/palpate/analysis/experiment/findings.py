"""Whether trials agree with the findings of the paper.

The effects of the primary analysis are compared with those of the paper (verdicts.py). Where the
paper prints no effect but only a significant test, trials agree if theirs is significant, and are
undecided if not. For the MANOVA that is the test of the paper's analysis.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pandas as pd

from palpate.analysis.numbers import f_text, p_text
from palpate.analysis.statistics import SIGNIFICANCE

from .as_paper import AsPaper
from .experiments import HAPTIC, SEEN_CLAIM, Experiment
from .outcomes import ANGLE, Outcome
from .paper import FINDINGS, Claim, Finding
from .primary import Primary
from .verdicts import (
    AGREES,
    DISAGREES,
    NOT_TESTABLE,
    UNDECIDED,
    Comparison,
    comparisons_of,
    verdict_of,
)

NO_EVIDENCE = (
    "the trials do not have all levels of the effect, too few participants are complete, or the "
    "effect is equal in all participants"
)


@dataclass(frozen=True)
class Evidence:
    """The test of an effect, and the means at the levels of a claimed order; none if the trials do
    not have all of the levels."""

    f: float
    df1: float
    df2: float
    p: float
    means: dict[str, float]


@dataclass(frozen=True)
class FindingResult:
    """comparisons: of effects, which the verdict needs. by_the_papers_test: the verdict of the test
    that the paper used, with all trials as independent: significant or not, and the order of the
    means; None for the contact angle."""

    finding: Finding
    verdict: str
    because: str
    by_the_papers_test: str | None
    comparisons: list[Comparison]


def judge(
    experiment: Experiment,
    paper: AsPaper | None,
    primary: Mapping[Outcome, Primary],
    angle: Primary | None,
) -> list[FindingResult]:
    """In the order of FINDINGS. paper: None if that analysis is not possible. angle: the analysis
    of the contact angle of UaH alone."""
    results = []
    for finding in FINDINGS:
        has_levels = "Haptic" not in finding.term or len(experiment.levels["Haptic"]) == len(HAPTIC)
        testable = has_levels and not experiment.is_seen
        as_paper = _paper_evidence(experiment, paper, finding) if testable else None
        why_not = SEEN_CLAIM if experiment.is_seen else NO_EVIDENCE
        verdict, because, comparisons = NOT_TESTABLE, why_not, list[Comparison]()
        if testable and finding.outcome is not None:
            analysis = angle if finding.outcome is ANGLE else primary.get(finding.outcome)
            if analysis:
                verdict, because, comparisons = _by_effects(experiment, analysis, finding)
        elif as_paper:
            verdict, because = _by_significance(as_paper)
        papers = None if finding.outcome is ANGLE else _papers_verdict(finding, as_paper)
        results.append(FindingResult(finding, verdict, because, papers, comparisons))
    return results


def _by_effects(
    experiment: Experiment, analysis: Primary, finding: Finding
) -> tuple[str, str, list[Comparison]]:
    assert finding.outcome is not None
    if finding.claim is Claim.EFFECT:
        effect = analysis.effect(finding.term)
        if effect is None or np.isnan(effect["f"]):
            return NOT_TESTABLE, NO_EVIDENCE, []
        test = Evidence(effect["f"], effect["df1"], effect["df2"], effect["p_gg"], {})
        return *_by_significance(test), []
    comparisons = comparisons_of(experiment, analysis, finding)
    verdict = verdict_of(comparisons)
    if verdict == NOT_TESTABLE:
        return NOT_TESTABLE, NO_EVIDENCE, comparisons
    texts = [comparison.text(finding.outcome.unit) for comparison in comparisons]
    return verdict, "; ".join(texts), comparisons


def _by_significance(test: Evidence) -> tuple[str, str]:
    """Where the paper prints no effect."""
    if np.isnan(test.p):
        return NOT_TESTABLE, NO_EVIDENCE
    words = f"{f_text(test.f, test.df1, test.df2)}, {p_text(test.p)}"
    return AGREES if test.p < SIGNIFICANCE else UNDECIDED, words


def _has_levels(experiment: Experiment, finding: Finding) -> bool:
    return set(finding.ascending) <= set(experiment.levels[finding.term[0]])


def _paper_evidence(
    experiment: Experiment, paper: AsPaper | None, finding: Finding
) -> Evidence | None:
    if paper is None:
        return None
    tests = paper.manova if finding.outcome is None else paper.anovas.get(finding.outcome)
    if tests is None or finding.term not in tests.index:
        return None
    test: pd.Series[float] = tests.loc[[finding.term]].iloc[0]
    means: dict[str, float] = {}
    if finding.outcome is not None and _has_levels(experiment, finding) and finding.ascending:
        values = experiment.trials.groupby(finding.term[0], observed=False)[finding.outcome.key]
        means = {level: float(values.mean()[level]) for level in finding.ascending}
    return Evidence(test["f"], test["df1"], test["df2"], test["p"], means)


def _papers_verdict(finding: Finding, evidence: Evidence | None) -> str:
    if evidence is None or np.isnan(evidence.p):
        return NOT_TESTABLE
    agrees = evidence.p < SIGNIFICANCE
    if finding.claim is Claim.NO_EFFECT:
        agrees = not agrees
    if finding.claim is Claim.ORDER:
        if not evidence.means:
            return NOT_TESTABLE
        agrees = agrees and all(a < b for a, b in pairwise(evidence.means.values()))
    return AGREES if agrees else DISAGREES
