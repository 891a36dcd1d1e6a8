"""Whether trials agree with the findings of the paper.

If the paper found an effect, trials agree if the effect is significant at 5 % and the means have
the paper's order. If the paper found no effect, trials agree if the effect is not significant. The
primary analysis decides. It has no MANOVA; for the MANOVA, the paper's analysis decides.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pandas as pd

from palpate.analysis.numbers import f_text, number_or_dash, p_text
from palpate.analysis.statistics import SIGNIFICANCE

from .as_paper import AsPaper
from .experiments import HAPTIC, Experiment
from .outcomes import ANGLE, Outcome
from .paper import FINDINGS, Claim, Finding
from .primary import Primary

AGREES, DISAGREES, NOT_TESTABLE = VERDICTS = ("agrees", "disagrees", "not testable")
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
    finding: Finding
    verdict: str
    because: str  # "F(2, 18) = 14.2, p = 0.001; H 27.1 < UaH 27.3 < NoH 29.1 s"
    as_paper: str | None  # the verdict of the analysis as the paper did it; None for the angle


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
        testable = "Haptic" not in finding.term or len(experiment.levels["Haptic"]) == len(HAPTIC)
        as_paper = _paper_evidence(experiment, paper, finding) if testable else None
        decisive = as_paper
        if finding.outcome is not None:
            analysis = angle if finding.outcome is ANGLE else primary.get(finding.outcome)
            decisive = _primary_evidence(experiment, analysis, finding) if testable else None
        results.append(
            FindingResult(
                finding,
                _verdict(finding, decisive),
                _reason(finding, decisive),
                None if finding.outcome is ANGLE else _verdict(finding, as_paper),
            )
        )
    return results


def _has_levels(experiment: Experiment, finding: Finding) -> bool:
    return set(finding.ascending) <= set(experiment.levels[finding.term[0]])


def _primary_evidence(
    experiment: Experiment, analysis: Primary | None, finding: Finding
) -> Evidence | None:
    effect = analysis.effect(finding.term) if analysis else None
    if analysis is None or effect is None or np.isnan(effect["f"]):
        return None
    means = {}
    for level in finding.ascending if _has_levels(experiment, finding) else ():
        at = {finding.term[0].lower(): level}
        mean = analysis.mean(**at)
        means[level] = np.nan if mean is None else float(mean["mean"])
    return Evidence(effect["f"], effect["df1"], effect["df2"], effect["p_gg"], means)


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


def _verdict(finding: Finding, evidence: Evidence | None) -> str:
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


def _reason(finding: Finding, evidence: Evidence | None) -> str:
    if evidence is None:
        return NO_EVIDENCE
    text = f"{f_text(evidence.f, evidence.df1, evidence.df2)}, {p_text(evidence.p)}"
    if finding.outcome is None or not evidence.means:
        return text
    order = sorted(evidence.means.items(), key=lambda level: level[1])
    found = " < ".join(f"{level} {number_or_dash(mean)}" for level, mean in order)
    return f"{text}; {found} {finding.outcome.unit}".rstrip()
