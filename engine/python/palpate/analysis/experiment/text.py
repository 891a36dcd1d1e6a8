"""The verdicts in words, and a few lines for a terminal."""

from __future__ import annotations

from collections.abc import Mapping

from .analysis import ExperimentAnalysis, OperatorAnalysis
from .paper import FINDINGS, Finding, reason_by_construction
from .verdicts import AGREES, DISAGREES, NOT_TESTABLE, UNDECIDED, VERDICTS

MOST_NAMES = 8


def counted(n: int, one: str, many: str) -> str:
    return f"{n} {one if n == 1 else many}"


def verdict_counts(each: OperatorAnalysis) -> dict[str, int]:
    verdicts = [result.verdict for result in each.findings]
    return {verdict: verdicts.count(verdict) for verdict in VERDICTS}


def verdict_counts_text(each: OperatorAnalysis) -> str:
    """ "11 agree, 3 disagree, 2 undecided, 1 not testable"."""
    counts = verdict_counts(each)
    return ", ".join(
        [
            counted(counts[AGREES], "agrees", "agree"),
            counted(counts[DISAGREES], "disagrees", "disagree"),
            *(f"{counts[verdict]} {verdict}" for verdict in (UNDECIDED, NOT_TESTABLE)),
        ]
    )


def findings_with(each: OperatorAnalysis, verdict: str) -> list[tuple[str, str]]:
    """Name and statement of the findings with this verdict. Those of the MANOVA are combined into
    one: "effects of Haptic, Rotation"."""
    found = [result.finding for result in each.findings if result.verdict == verdict]
    texts = [(finding.name, finding.statement) for finding in found if finding.outcome]
    effects = [finding.effect for finding in found if finding.outcome is None]
    return texts + ([("MANOVA", f"effects of {', '.join(effects)}")] if effects else [])


def built_so(analysis: ExperimentAnalysis) -> dict[Finding, str]:
    """The findings about which simulated persons are no evidence, and why; none for people."""
    reasons = {finding: reason_by_construction(finding) for finding in FINDINGS}
    if not analysis.has_simulated:
        return {}
    return {finding: reason for finding, reason in reasons.items() if reason}


def columns_text(analysis: ExperimentAnalysis) -> str:
    """A name for the columns of the table of verdicts."""
    if analysis.has_people and analysis.has_simulated:
        return "people and simulated operators"
    if analysis.variants == 1:
        return "followings"
    return "followings and settings" if analysis.has_simulated else "settings"


def who(analysis: ExperimentAnalysis) -> str:
    if not analysis.has_simulated:
        return "people"
    return "people and simulated operators" if analysis.has_people else "simulated operators"


def names_of(analysis: ExperimentAnalysis) -> str:
    """ "delayed, predict"; "delayed; delayed, start 45 deg"."""
    names = [experiment.name for experiment in analysis.experiments]
    text = ("; " if analysis.variants > 1 else ", ").join(names[:MOST_NAMES])
    beyond = len(names) - MOST_NAMES
    return text + (f" and {beyond} more" if beyond > 0 else "")


def all_counts(analysis: ExperimentAnalysis) -> Mapping[str, int]:
    """done, timeouts, faults and absent, of all experiments together."""
    names = ["done", "timeouts", "faults", "absent"]
    return {name: sum(e.total[name] for e in analysis.experiments) for name in names}


def all_trials(analysis: ExperimentAnalysis) -> int:
    counts = all_counts(analysis)
    return counts["done"] + counts["timeouts"] + counts["faults"]


def missing_text(analysis: ExperimentAnalysis) -> str:
    """ "57 (40 timeouts, 0 faults, 17 absent)"; "none"."""
    counts = all_counts(analysis)
    missing = counts["timeouts"] + counts["faults"] + counts["absent"]
    if missing == 0:
        return "none"
    timeouts = counted(counts["timeouts"], "timeout", "timeouts")
    faults = counted(counts["faults"], "fault", "faults")
    return f"{missing} ({timeouts}, {faults}, {counts['absent']} absent)"


def most_participants(analysis: ExperimentAnalysis) -> int:
    return max(len(experiment.participants) for experiment in analysis.experiments)


def terminal_text(analysis: ExperimentAnalysis) -> str:
    """What was analysed, and the verdicts of the first operator."""
    leading = analysis.operators[0]
    whose = f"{all_trials(analysis)} trials of {most_participants(analysis)} {who(analysis)}"
    whose += f" ({names_of(analysis)})" if analysis.has_simulated else ""
    lines = [
        f"{whose}; missing: {missing_text(analysis)}",
        f"the paper's {len(FINDINGS)} findings, {leading.experiment.name}: "
        f"{verdict_counts_text(leading)}",
    ]
    if built := built_so(analysis):
        names = "; ".join(finding.name for finding in built)
        lines.append(f"no evidence, because simulated persons are built so: {names}")
    for verdict in VERDICTS:
        for name, statement in findings_with(leading, verdict):
            lines.append(f"  {verdict:<14}{name}: {statement}")
    flips = len(analysis.differing())
    if flips:
        verdicts = counted(flips, "verdict flips", "verdicts flip")
        lines.append(f"{verdicts} between {columns_text(analysis)}")
    return "\n".join(lines) + "\n"
