#!/usr/bin/env python3
"""Makes questionnaires.csv: what 12 made people answered after six conditions in two blocks; two left
some of it out, and one came to one block only. The same bytes every time."""

from __future__ import annotations

import csv
import random
from itertools import product
from pathlib import Path

HERE = Path(__file__).resolve().parent
ITEMS = ("tlx_mental", "tlx_physical", "tlx_temporal", "tlx_performance", "tlx_effort",
         "tlx_frustration", "real")
HAPTIC, ROTATION = ("NoH", "UaH", "H"), ("NoR", "R")
# Participant and haptic, of which one item or all items are not there.
WITHOUT = {("7", "H", "tlx_effort"), *(("9", "UaH", item) for item in ITEMS)}


ONE_BLOCK = "4"


def answer(r: random.Random, item: str, person: float, force: int, turned: bool) -> int:
    if item == "real":
        return min(7, max(1, round(2 + 1.6 * force + 0.3 * turned + person + r.gauss(0, 0.9))))
    value = 45 - 7 * force + 9 * turned * (item == "tlx_mental") + 15 * person + r.gauss(0, 12)
    return min(100, max(0, 5 * round(value / 5)))


def main() -> None:
    r = random.Random("questionnaires")
    with open(HERE / "questionnaires.csv", "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("participant", "block", "haptic", "rotation", "item", "value"))
        for number in range(1, 13):
            person = r.gauss(0, 0.6)
            blocks = (1,) if str(number) == ONE_BLOCK else (1, 2)
            for block, haptic, rotation, item in product(blocks, HAPTIC, ROTATION, ITEMS):
                value = answer(r, item, person, HAPTIC.index(haptic), rotation == "R")
                if (str(number), haptic, item) not in WITHOUT:
                    writer.writerow((number, block, haptic, rotation, item, value))


if __name__ == "__main__":
    main()
