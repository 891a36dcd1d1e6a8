"""Sentences about a sweep, for the page and for a terminal."""

from __future__ import annotations

import math
from dataclasses import dataclass

import pandas as pd

from palpate.analysis.sweep.findings import Findings, Row, Rows, axis_of
from palpate.analysis.sweep.points import Parameter, Sweep
from palpate.analysis.sweep.rankings import RANKINGS

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


@dataclass(frozen=True)
class Spread:
    """Of the mean penetration over conditions, between the persons of the base plan."""

    persons: int
    mean_mm: float
    sd_mm: float  # NaN below two persons


def spread_of_persons(sweep: Sweep) -> Spread:
    is_base = sweep.points["block"] == "base"
    if not is_base.any():
        return Spread(0, math.nan, math.nan)
    cells = sweep.cells["mean_penetration_dm"].loc[is_base.idxmax()]
    of_person_mm = 100.0 * cells.mean(axis=1, skipna=False).dropna()
    return Spread(len(of_person_mm), float(of_person_mm.mean()), float(of_person_mm.std()))


def construction(findings: Findings, sweep: Sweep) -> list[str]:
    """What the model of a person fixes, so that no count of this sweep is evidence of it."""
    facts = ["They do not learn, and they use what they see, not the force that they feel: only the "
             "passive hand (its mass, stiffness and damping) meets that force."]
    for ranking, row in zip(RANKINGS, findings.rankings):
        if ranking.by_construction:
            where = (f"holds at {row['holds']} of {row['points']} testable points" if row["points"]
                     else "not testable")
            facts.append(f"{ranking.name} ({ranking.order}; {where}): {ranking.by_construction}.")
    spread = spread_of_persons(sweep)
    if not math.isnan(spread.sd_mm):
        facts.append("They differ as much as their ranges state: the mean penetration of "
                     f"{spread.persons} persons at the base plan has a standard deviation of "
                     f"{spread.sd_mm:.2g} mm between them, with a mean of {spread.mean_mm:.2g} mm.")
    return facts


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
