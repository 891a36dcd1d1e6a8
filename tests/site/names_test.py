#!/usr/bin/env python3
"""The page of faults has one row for each fault, each rule of the governor and each reason of a trip.

usage: names_test.py PROJECT

The rows are those of the tables in docs/reference/faults.md that have a column called fault, rule or reason.
The names are those of the constants in the headers.
"""

import pathlib
import re
import sys

PAGE = "docs/reference/faults.md"
NAMES = {"fault": ("haptics/include/palpate/record.h", "kFaultNames"),
         "rule": ("haptics/include/palpate/record.h", "kGovernorRuleNames"),
         "reason": ("haptics/safety_governor.h", "kTripReasonNames")}
NO_ROW = {"none"}  # the reason of no trip


def names_of(header, constant):
    return [name for name in re.findall(r'"(\w+)"', re.search(rf"\b{constant} = \{{(.*?)\}};", header, re.S)[1])
            if name not in NO_ROW]


def rows_of(page, heading):
    """The names in the columns with this heading, of all tables."""
    names, column = [], None
    for line in page.splitlines():
        cells = [cell.strip() for cell in line.split("|")[1:]]
        if not cells:
            column = None
        elif heading in cells:
            column = cells.index(heading)
        elif column is not None and (name := re.fullmatch(r"`(\w+)`", cells[column])):
            names.append(name[1])
    return names


def check(page, headers):
    """The faults of the page. headers: the text of each header by its path."""
    for heading, (path, constant) in NAMES.items():
        names, rows = names_of(headers[path], constant), rows_of(page, heading)
        for name in names:
            if rows.count(name) != 1:
                yield f"{PAGE}: {rows.count(name)} rows of a {heading} `{name}`; expected one"
        for name in sorted(set(rows) - set(names)):
            yield f"{PAGE}: a row of a {heading} `{name}`, which {constant} does not have"


def main():
    project = pathlib.Path(sys.argv[1])
    headers = {path: (project / path).read_text(encoding="utf-8") for path, _ in NAMES.values()}
    page = (project / PAGE).read_text(encoding="utf-8")
    faults = list(check(page, headers))
    print("\n".join(faults))
    broken = list(check(re.sub(r"^\| `clamp`.*\n", "", page, flags=re.M).replace("| `jump` |", "| `jumps` |"), headers))
    if not faults and len(broken) != 3:
        print("three made faults, found:", *broken, sep="\n")
        return 1
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
