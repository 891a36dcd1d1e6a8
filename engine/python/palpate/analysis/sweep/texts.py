"""Sentences about a sweep, for the page and for a terminal."""

from __future__ import annotations

import math
import pandas as pd

from palpate.analysis.sweep.findings import Findings, Row, Rows, axis_of
from palpate.analysis.sweep.points import Parameter, Sweep

SHARES = ("Shares are of our ranges, not of people: they say at how many drawn hands and devices a "
          "ranking holds, and nobody knows how people are spread over these ranges.")
CHANCE = ("By chance alone, as if coins decided, an order of two conditions holds at 1/2 of the "
          "points, and an order of three at 1/6.")


def percent(share: float) -> str:
    """A share: "71 %"; "> 99 %" and "< 1 %" for one that is not 1 or 0 but would be rounded so."""
    rounded = math.floor(100.0 * share + 0.5)
    if rounded == 100 and share < 1.0:
        return "> 99 %"
    return "< 1 %" if rounded == 0 and share > 0.0 else f"{rounded} %"


def part(row: Row) -> str:
    """A share in a part: "low half 71 % of 50"."""
    share = f"{percent(row['share'])} of {row['points']}" if row["points"] else "not testable"
    return f"{row['part']} {share}"


def parts(rows: Rows) -> str:
    return ", ".join(map(part, rows)) or "-"


def share(row: Row) -> str:
    """At how many points a ranking holds, with Wilson's interval."""
    untestable = (f"{row['untestable']} of {row['points'] + row['untestable']} not testable, "
                  "because nobody completed the trials")
    if not row["points"]:
        return untestable
    text = (f"{percent(row['share'])} ({math.floor(100.0 * row['low'] + 0.5)} to "
            f"{percent(row['high'])}): holds at {row['holds']} of {row['points']} testable points")
    return f"{text}; {untestable}" if row["untestable"] else text


def parts_by(findings: Findings, ranking: str, parameter: str) -> str:
    """The shares of a ranking in the parts by a parameter."""
    return parts([row for row in findings.halves
                  if (row["ranking"], row["parameter"]) == (ranking, parameter)])


def decisive(findings: Findings, row: Row, parameters: dict[str, Parameter]) -> str:
    """What decides most, with its shares; several parameters if their parts differ equally."""
    if math.isnan(row["p"]):
        return "none"
    names = row["decisive_parameters"].split()
    text = "; ".join(f"{parameters[name].label}: {parts_by(findings, row['ranking'], name)}"
                     for name in names)
    return f"{text or 'none beyond chance'} (p = {row['p']:.2g})"


def persons(sweep: Sweep) -> str:
    """What decides a point, and what Wilson's interval leaves out."""
    of_hypercube = sweep.rows[sweep.rows["block"] == "hypercube"]
    count = of_hypercube["participant"].nunique()
    who = "1 person, who is" if count == 1 else f"{count} persons, who are"
    return (f"A point is decided by the means of {who} the same at all points. Wilson's interval "
            "covers the draw of the points, and not that of the persons.")


def flips(rows: Rows) -> str:
    """How many: "3 flips, 1 of them beyond noise"."""
    clear = sum(row["is_clear"] for row in rows)
    return f"{len(rows)} flip{'s' * (len(rows) != 1)}, {clear} of them beyond noise"


def flip(row: Row, parameter: Parameter) -> str:
    """Where a ranking holds and where not."""
    low, high = (v if isinstance(v, str) else parameter.text(v) for v in (row["from"], row["to"]))
    where, not_where = (high, low) if row["holds_at_to"] else (low, high)
    text = f"{row['ranking']} ({row['order']}): holds at {where}, not at {not_where}"
    return text if row["is_clear"] else f"{text} (within noise)"


def missing(sweep: Sweep, parameter: Parameter) -> str:
    """At which levels trials are missing; empty if at none."""
    of = sweep.points.loc[axis_of(sweep, parameter)]
    texts = [f"{row['done']} of {row['trials']} done at {parameter.text(row[parameter.name])}"
             for _, row in of[of["done"] < of["trials"]].iterrows()]
    return f"Trials are missing: {', '.join(texts)}." if texts else ""


def participants(levels: pd.DataFrame) -> str:
    """Of how many participants means are: "5 participants", "3 to 5 participants"."""
    least, most = levels["participants"].min(), levels["participants"].max()
    return f"{least} to {most} participants" if least < most else f"{most} participants"


def drawn(sweep: Sweep, parameter: Parameter) -> str:
    """The range of the hypercube: "0.117 to 0.2 s"."""
    of_hypercube = sweep.points[sweep.points["block"] == "hypercube"]
    values = of_hypercube[parameter.name]
    unit = f" {parameter.unit}" if parameter.unit not in ("", "1") else ""
    return f"{parameter.text(values.min())} to {parameter.text(values.max())}{unit}"


def terminal(sweep: Sweep, findings: Findings) -> str:
    lines = [f"  {row['ranking']} ({row['order']}): {share(row)}; decides most: "
             f"{decisive(findings, row, sweep.parameters)}" for row in findings.rankings]
    return "\n".join([*lines, f"{CHANCE} {persons(sweep)}", SHARES, ""])
