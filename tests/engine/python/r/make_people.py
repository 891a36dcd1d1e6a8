#!/usr/bin/env python3
"""Makes people.csv: trials of 12 made people as `experiment live` writes them, with fewer columns.
Some trials are aborted, repeated, skipped, timed out or absent. The same bytes every time."""

from __future__ import annotations

import csv
import math
import random
from collections.abc import Sequence
from itertools import product
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
SEED = "12 people"
COLUMNS = ("participant", "block", "trial", "haptic", "rotation", "object", "attempt", "status",
           "total_time_s", "losses_of_contact", "mean_penetration_dm", "mean_contact_angle_deg",
           "pilot", "input", "motion", "reason")
MEASURES = COLUMNS[COLUMNS.index("total_time_s"): COLUMNS.index("pilot")]
HAPTIC, ROTATION, OBJECTS, BLOCKS = ("NoH", "UaH", "H"), ("NoR", "R"), ("O1", "O2"), (1, 2)
REASONS = ("focus", "full_screen", "pointer_lock", "hidden", "late_ticks", "late_frames", "trip",
           "server")
# participant, block, haptic, rotation, object: how a trial ended that nobody completed.
NEVER_DONE = {("2", 1, "NoH", "R", "O2"): ("timeout", ""),
              ("3", 1, "UaH", "R", "O1"): ("skipped", "experimenter"),
              ("3", 2, "UaH", "R", "O1"): ("aborted", "server"),
              ("5", 2, "H", "NoR", "O1"): ("skipped", "participant"),
              ("5", 2, "H", "R", "O2"): ("absent", ""),
              ("5", 2, "NoH", "R", "O1"): ("absent", ""),
              ("7", 1, "UaH", "NoR", "O2"): ("fault", ""),
              ("8", 2, "NoH", "R", "O1"): ("timeout", ""),
              ("8", 2, "UaH", "R", "O2"): ("timeout", ""),
              ("11", 1, "NoH", "NoR", "O1"): ("timeout", "")}
# Trials that were done, and again: the later one counts, or the first if the later one was cut.
TWICE = {("4", 1, "H", "R", "O1"), ("6", 2, "NoH", "NoR", "O2"), ("12", 1, "UaH", "R", "O2")}
CUT_AFTER = {("10", 2, "H", "NoR", "O2"): "experimenter"}
WITHOUT_ANGLE = {("9", 1, "UaH", "NoR", "O1")}


class Person:
    """u: of the person; w: of the person in a condition, in units of each measure."""

    def __init__(self, r: random.Random, number: int) -> None:
        self.r, self.number = r, str(number)
        self.u = [r.gauss(0, 1) for _ in range(4)]
        self.w = {c: [r.gauss(0, 1) for _ in range(4)] for c in product(HAPTIC, ROTATION)}

    def measures(self, block: int, haptic: str, rotation: str, thing: str) -> list[str]:
        r, force, turned = self.r, HAPTIC.index(haptic), rotation == "R"
        u, w = self.u, self.w[haptic, rotation]
        e = [r.gauss(0, 1) for _ in range(4)]
        time_s = (27 - 1.5 * force + 3 * turned + 3 * (thing == "O2") - 1.5 * block
                  + 3 * u[0] + 2.5 * w[0] + 4 * e[0])
        rate = 0.8 * math.exp(0.2 * u[1] + 0.12 * w[1] + 0.2 * e[1] - 0.08 * force + 0.06 * turned)
        depth_dm = (0.1 - 0.033 * force + 0.006 * turned * (force == 0)
                    + 0.009 * u[2] + 0.016 * w[2] + 0.008 * e[2])
        angle_deg = 49 - 15 * turned - 2 * force + 2.5 * u[3] + 2 * w[3] + 3 * e[3]
        time_s = max(time_s, 5.0)
        return [f"{time_s:.3f}", str(round(rate * time_s)), f"{max(depth_dm, 0.002):.5f}",
                f"{max(angle_deg, 1.0):.2f}"]


def row(person: Person, at: Sequence[Any], place: int, attempt: int, status: str = "done",
        reason: str = "", pilot: int = 0) -> dict[str, Any]:
    block, haptic, rotation, thing = at
    found = dict(zip(COLUMNS, (person.number, block, place, haptic, rotation, thing, attempt, status)))
    measures = person.measures(block, haptic, rotation, thing)
    if status != "done":  # what was measured up to the end
        measures = [measures[0], measures[1], "", ""] if status == "aborted" else [""] * 4
    found.update(zip(MEASURES, measures))
    if (person.number, *at) in WITHOUT_ANGLE:
        found["mean_contact_angle_deg"] = ""
    return found | {"pilot": pilot, "input": "mouse", "motion": "unaccelerated", "reason": reason}


def attempts(person: Person, at: Sequence[Any], place: int) -> list[dict[str, Any]]:
    """The first attempt, and those at the end of the block."""
    r, key = person.r, (person.number, *at)
    if key in NEVER_DONE:
        status, reason = NEVER_DONE[key]
        return [] if status == "absent" else [row(person, at, place, 1, status, reason)]
    found = []
    while r.random() < 0.1:
        found.append(row(person, at, place, len(found) + 1, "aborted", r.choice(REASONS)))
    found.append(row(person, at, place, len(found) + 1))
    if key in TWICE:
        found.append(row(person, at, place, len(found) + 1))
    if key in CUT_AFTER:
        found.append(row(person, at, place, len(found) + 1, "aborted", CUT_AFTER[key]))
    return found


def rows() -> list[dict[str, Any]]:
    r = random.Random(SEED)
    people = [Person(r, number) for number in range(1, 13)]
    conditions = list(product(HAPTIC, ROTATION, OBJECTS))
    found = [row(people[0], (1, *c), place, 1, pilot=1) for place, c in enumerate(conditions, 1)]
    for person in people:
        found.append(row(person, (0, *r.choice(conditions)), 1, 1))  # practice
        for block in BLOCKS:
            r.shuffle(conditions)
            tried = [attempts(person, (block, *c), p) for p, c in enumerate(conditions, 1)]
            found += [each for trial in tried for each in trial[:1]]
            found += [each for trial in tried for each in trial[1:]]
    return found


def main() -> None:
    with open(HERE / "people.csv", "w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows())


if __name__ == "__main__":
    main()
