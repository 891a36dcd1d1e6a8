"""The README's table of the experiment: people, and two files of simulated operators."""

import json

import result_tables as tables
from result_tables import BadInput

OPERATORS = ("people2005", "literature")
LEADING = "delayed"  # the following that the tables show


def read(folder):
    """{operator: result}, as measure_experiment.py wrote them."""
    results = {}
    for name in OPERATORS:
        path = folder / f"{name}.json"
        try:
            results[name] = json.loads(path.read_text(encoding="utf-8"))
            table_rows({name: results[name]})
            not_shared({name: results[name]})
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


def cell(result, key, outcome, pattern, factor, levels, separator, unit):
    numbers = [pattern % (factor * value(result, outcome, key, **level)) for level in levels]
    return separator.join(numbers) + unit


FORCES = [{"haptic": level} for level in ("NoH", "UaH", "H")]
ROTATIONS = [{"rotation": level} for level in ("NoR", "R")]
ANGLES = [{"haptic": "UaH", **level} for level in ROTATIONS]

# The name of a row, then the arguments of cell() after `key`, for each part of the cell.
ROWS = [
    ("time: NoH, UaH, H; NoR -> R", [("total time", "%.1f", 1, FORCES, ", ", " s"),
                                     ("total time", "%.1f", 1, ROTATIONS, " -> ", " s")]),
    ("losses of contact", [("losses of contact", "%.1f", 1, FORCES, ", ", ""),
                           ("losses of contact", "%.1f", 1, ROTATIONS, " -> ", "")]),
    ("penetration", [("mean penetration", "%.1f", 100, FORCES, ", ", " mm"),
                     ("mean penetration", "%.1f", 100, ROTATIONS, " -> ", " mm")]),
    ("contact angle in UaH: NoR -> R", [("mean contact angle", "%.1f", 1, ANGLES, " -> ",
                                         " deg")]),
]


def table_rows(results):
    first = next(iter(results.values()))
    def parts(result, key, hows):
        return "; ".join(cell(result, key, *how) for how in hows)
    return [(name, [parts(first, "paper_mean", hows)] +
             [parts(result, "mean", hows) for result in results.values()])
            for name, hows in ROWS]


def findings_of(result):
    """{name: (statement, verdict)} of the leading following."""
    return {row["finding"]: (row["paper_statement"], row["verdict"])
            for row in result["findings"] if row["following"] == LEADING}


def not_shared(results):
    """[(finding, the operators whose trials disagree with it)], and the number of all findings."""
    by_operator = {name: findings_of(result) for name, result in results.items()}
    first = next(iter(by_operator.values()))
    disagreeing = [(f"{finding} (paper: {statement})",
                    [name for name, findings in by_operator.items()
                     if findings[finding][1] == "disagrees"])
                   for finding, (statement, _) in first.items()]
    return [item for item in disagreeing if item[1]], len(first)


def sentence(results):
    rows, count = not_shared(results)
    if not rows:
        return f"The simulation disagrees with none of the paper's {count} findings."
    statements = "; ".join(finding + ("" if names == list(results) else f", only `{names[0]}`")
                           for finding, names in rows)
    return (f"The simulation disagrees with {len(rows)} of the paper's {count} findings: "
            f"{statements}.")


def block(results):
    table = tables.markdown(["mean of all trials", "ten people", *(f"`{n}`" for n in results)],
                            table_rows(results))
    return table + "\n\n" + sentence(results)
