"""The tables of the experiment: people, and two files of simulated operators."""

import json

import result_tables as tables
from result_tables import BadInput

OPERATORS = ("people2005", "literature")
LEADING = "delayed"  # the following that the tables show
DISAGREES = "disagrees"
UNDECIDED = "undecided"


def read(folder):
    """{operator: result}, as measure_experiment.py wrote them."""
    results = {}
    for name in OPERATORS:
        path = folder / f"{name}.json"
        try:
            results[name] = json.loads(path.read_text(encoding="utf-8"))
            block({name: results[name]})
            findings_block({name: results[name]})
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise BadInput(f"{path}: expected a result of measure_experiment.py "
                           f"({error!r})") from error
    return results


def value(result, outcome, key, haptic="all", rotation="all"):
    wanted = {"following": LEADING, "outcome": outcome, "haptic": haptic, "rotation": rotation}
    for row in result["means"]:
        if all(row[name] == wanted[name] for name in wanted):
            return row[key]
    raise KeyError(f"no mean of {outcome} at {haptic}, {rotation}")


FORCES = ["NoH", "UaH", "H"]
ROTATIONS = ["NoR", "R"]

# The measure and its unit, the name in the results, the factor, the condition of force.
TIME = ("total time, s", "total time", 1, "all")
LOSSES = ("losses of contact", "losses of contact", 1, "all")
PENETRATION = ("penetration, mm", "mean penetration", 100, "all")  # the results have dm
ANGLE = ("contact angle in UaH, deg", "mean contact angle", 1, "UaH")


def who(results):
    """The rows of each measure: a name, the result and the column that holds its means."""
    first = next(iter(results.values()))
    return [("ten people (paper)", first, "paper_mean")] + [
        (f"`{name}`", result, "mean") for name, result in results.items()]


def table(results, measures, factor_name, levels):
    """A row for each measure and kind of persons, a column for each level of Haptic or Rotation."""
    rows = []
    for title, outcome, factor, force in measures:
        for name, result, key in who(results):
            conditions = [{"haptic": force, factor_name: level} for level in levels]
            rows.append((title, [name] + [f"{factor * value(result, outcome, key, **at):.1f}"
                                          for at in conditions]))
    return tables.markdown(["mean of all trials", "persons", *levels], rows, words=2)


def people_deg(results):
    """The paper's contact angles of its people in UaH, without and with A4."""
    first = next(iter(results.values()))
    return [value(first, "mean contact angle", "paper_mean", "UaH", level) for level in ROTATIONS]


def block(results):
    return "\n\n".join([
        "By force:", table(results, [TIME, LOSSES, PENETRATION], "haptic", FORCES),
        "By rotation:", table(results, [TIME, LOSSES, PENETRATION, ANGLE], "rotation", ROTATIONS)])


def findings_of(result):
    """{name: (statement, verdict)} of the leading following."""
    return {row["finding"]: (row["paper_statement"], row["verdict"])
            for row in result["findings"] if row["following"] == LEADING}


def findings_block(results):
    """How many findings each simulation disagrees with, and the verdict on each."""
    by_operator = {name: findings_of(result) for name, result in results.items()}
    first = next(iter(by_operator.values()))
    wrong = {finding: [name for name, findings in by_operator.items()
                       if findings[finding][1] == DISAGREES] for finding in first}
    undecided = {name: sum(verdict == UNDECIDED for _, verdict in findings.values())
                 for name, findings in by_operator.items()}
    lines = [f"- `{name}` disagrees with {sum(name in names for names in wrong.values())} of the "
             f"paper's {len(first)} findings; {undecided[name]} are undecided." for name in results]
    lines.append(f"- Both together disagree with {sum(map(bool, wrong.values()))}; "
                 f"{sum(len(names) == len(results) for names in wrong.values())} of them are the same.")
    rows = [(finding, [statement] + [marked(findings[finding][1]) for findings in by_operator.values()])
            for finding, (statement, _) in first.items()]
    return "\n".join(lines) + "\n\n" + tables.markdown(
        ["finding", "paper", *(f"`{name}`" for name in results)], rows, words=2 + len(results))


def marked(verdict):
    return f"**{verdict}**" if verdict == DISAGREES else verdict
