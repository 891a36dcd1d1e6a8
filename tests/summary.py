#!/usr/bin/env python3
"""Prints how many tests passed, failed and were not run, and why not, from a result file of ctest.

usage: summary.py RESULTS.xml

A test that needs what the machine lacks says so in one line that begins with "needs " (helpers/needs.h). With
PALPATE_NEEDS=all, as in .ci/run, each test that was not run makes this script fail, except those that say
"skipped: " and why: the corpus is missing, or the build is another one than the test is for.
"""

import os
import re
import sys
import xml.etree.ElementTree

SHOWN = 3  # names for each reason


def reason_of(case):
    """Why the test was not run: its line with "needs " or "skipped: "."""
    output = case.findtext("system-out") or ""
    found = re.search(r"^(?:needs |skipped: ).*", output, re.M)
    if found:
        return found[0]
    skipped = case.find("skipped")
    return (skipped.get("message") if skipped is not None else "") or "for an unknown reason"


def say(text):
    print(f"palpate: {text}", file=sys.stderr)


def main():
    cases = xml.etree.ElementTree.parse(sys.argv[1]).getroot().findall("testcase")
    passed = sum(case.get("status") == "run" for case in cases)
    failed = sum(case.get("status") == "fail" for case in cases)
    reasons = {}
    for case in cases:
        if case.get("status") not in ("run", "fail"):
            reasons.setdefault(reason_of(case), []).append(case.get("name"))
    counted = [f"{passed} {'test' if passed == 1 else 'tests'} passed"]
    counted += [f"{failed} failed"] if failed else []
    not_run = sum(map(len, reasons.values()))
    say(", ".join(counted + [f"{not_run} not run:" if not_run else "all were run"]))
    lacking = 0
    for reason, names in sorted(reasons.items()):
        more = f" and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
        say(f"  {reason} ({', '.join(names[:SHOWN])}{more})")
        lacking += 0 if reason.startswith("skipped: ") else len(names)
    if lacking and os.environ.get("PALPATE_NEEDS") == "all":
        say(f"{lacking} not run, of {len(cases)} tests; with PALPATE_NEEDS=all, each must run")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
