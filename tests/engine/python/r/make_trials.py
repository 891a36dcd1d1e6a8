#!/usr/bin/env python3
"""Makes trials_balanced.csv and trials_unbalanced.csv: the same bytes every time."""

from __future__ import annotations

import csv
import math
import random
from itertools import product
from pathlib import Path

HERE = Path(__file__).resolve().parent
COLUMNS = ("person", "haptic", "rotation", "object", "block", "time_s", "losses", "depth_dm")
HAPTIC, ROTATION, OBJECTS, BLOCKS = ("NoH", "UaH", "H"), ("NoR", "R"), ("O1", "O2"), (1, 2, 3)


def poisson(r: random.Random, mean: float) -> int:
    """Knuth's algorithm."""
    product_, count = r.random(), 0
    while product_ > math.exp(-mean):
        product_ *= r.random()
        count += 1
    return count


def rows(seed: str, people: int) -> list[tuple[object, ...]]:
    r = random.Random(seed)
    found: list[tuple[object, ...]] = []
    for person in range(1, people + 1):
        u = r.gauss(0, 3)
        w = {condition: r.gauss(0, 2) for condition in product(HAPTIC, ROTATION)}
        for h, t, o, b in product(HAPTIC, ROTATION, OBJECTS, BLOCKS):
            force, turned = HAPTIC.index(h), t == "R"
            time = (27 + u + w[h, t] - 2 * force + 4 * turned + 2.5 * (o == "O2") - 0.8 * b
                    + r.gauss(0, 4))
            rate = 0.75 * math.exp(0.04 * u - 0.1 * force + 0.08 * turned)
            depth = 0.1 - 0.033 * force + 0.002 * u + 0.008 * r.gauss(0, 1)
            time = round(max(time, 3.0), 3)
            found.append((f"P{person:02}", h, t, o, b, time, poisson(r, rate * time),
                          round(max(depth, 0.001), 5)))
    return found


def write(name: str, table: list[tuple[object, ...]]) -> None:
    with open(HERE / name, "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(table)


def main() -> None:
    write("trials_balanced.csv", rows("balanced", 10))
    r = random.Random("missing")
    write("trials_unbalanced.csv", [row for row in rows("unbalanced", 8) if r.random() > 0.15])


if __name__ == "__main__":
    main()
