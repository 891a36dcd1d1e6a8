"""The verdicts in words, and a few lines for a terminal."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping

from .analysis import ExperimentAnalysis, OperatorAnalysis
from .experiments import SEEN_CLAIM, STATUS, Experiment, counts_text
from .paper import FINDINGS, Finding, reason_by_construction
from .questionnaire_page import terminal_lines
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


def names_of(experiments: list[Experiment]) -> str:
    """ "delayed, predict"; "delayed; delayed, start 45 deg"."""
    names = [experiment.name for experiment in experiments]
    is_one = len({experiment.variant for experiment in experiments}) == 1
    text = (", " if is_one else "; ").join(names[:MOST_NAMES])
    beyond = len(names) - MOST_NAMES
    return text + (f" and {beyond} more" if beyond > 0 else "")


def kinds(analysis: ExperimentAnalysis) -> list[tuple[str, list[Experiment]]]:
    """The experiments of people, and those of simulated operators: nothing pools the two."""
    people = [e for e in analysis.experiments if not e.is_simulated]
    simulated = [e for e in analysis.experiments if e.is_simulated]
    both = [("people", people), ("simulated operators", simulated)]
    return [(name, experiments) for name, experiments in both if experiments]


def _counts(experiments: list[Experiment]) -> Mapping[str, int]:
    """By the names of STATUS, and absent."""
    names = (*STATUS.values(), "absent")
    return {name: sum(e.total[name] for e in experiments) for name in names}


def trials_text(experiments: list[Experiment]) -> str:
    """How many trials took place."""
    counts = _counts(experiments)
    return str(sum(counts.values()) - counts["absent"] - counts["skipped"])


def missing_text(experiments: list[Experiment]) -> str:
    """ "57 (40 timeouts, 0 faults, 17 absent)"; with what people's trials can be: "3 (1 timeout, 0
    faults, 0 absent, 2 skipped)"; "none"."""
    counts = _counts(experiments)
    missing = sum(counts.values()) - counts["done"]
    if missing == 0:
        return "none"
    timeouts = counted(counts["timeouts"], "timeout", "timeouts")
    faults = counted(counts["faults"], "fault", "faults")
    absent = f"{counts['absent']} absent"
    cut = [f"{counts[name]} {name}" for name in ("aborted", "skipped") if counts[name]]
    return f"{missing} ({', '.join([timeouts, faults, absent, *cut])})"


def repeated_text(experiments: list[Experiment]) -> str:
    """How many attempts do not count, by reason: "5 (focus 3, hidden 2)"; empty without any."""
    counts: Counter[str] = Counter()
    for experiment in experiments:
        counts.update(experiment.repeated)
    return f"{counts.total()} ({counts_text(counts)})" if counts else ""


def most_participants(experiments: list[Experiment]) -> int:
    return max(len(experiment.participants) for experiment in experiments)


def terminal_text(analysis: ExperimentAnalysis) -> str:
    """What was analysed, and the verdicts of the first operator."""
    leading = analysis.operators[0]
    lines = []
    for kind, of_kind in kinds(analysis):
        line = f"{trials_text(of_kind)} trials of {most_participants(of_kind)} {kind}"
        line += f" ({names_of(of_kind)})" if of_kind[0].is_simulated else ""
        line += f"; missing: {missing_text(of_kind)}"
        repeated = repeated_text(of_kind)
        lines.append(line + (f"; repeated: {repeated}" if repeated else ""))
    if analysis.pilot_rows:
        rows = counted(analysis.pilot_rows, "row of a pilot run", "rows of a pilot run")
        lines.append(f"{rows}: left out")
    if any(experiment.is_seen for experiment in analysis.experiments):
        lines.append(f"seen-UaH and seen-H: {SEEN_CLAIM}")
    lines.append(
        f"the paper's {len(FINDINGS)} findings, {leading.experiment.name}: "
        f"{verdict_counts_text(leading)}"
    )
    if built := built_so(analysis):
        names = "; ".join(finding.name for finding in built)
        lines.append(f"no evidence, because simulated persons are built so: {names}")
    for verdict in VERDICTS:
        for name, statement in findings_with(leading, verdict):
            lines.append(f"  {verdict:<14}{name}: {statement}")
    lines += terminal_lines(analysis.questionnaires)
    flips = len(analysis.differing())
    if flips:
        verdicts = counted(flips, "verdict flips", "verdicts flip")
        lines.append(f"{verdicts} between {columns_text(analysis)}")
    return "\n".join(lines) + "\n"
