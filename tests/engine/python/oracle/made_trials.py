"""Made files of trials for `experiment analyse`: each is one shape of data that may go wrong.

Numbers come from random.Random with a seed of the case's name, and have six digits.
"""

from __future__ import annotations

import csv
import io
import random
from collections.abc import Callable, Iterable, Sequence
from typing import Any

Row = dict[str, Any]
Change = Callable[[random.Random, list[Row]], Iterable[Row] | None]

FACTORS = ("following", "participant", "block", "trial", "haptic", "rotation", "object", "attempt",
           "status")
MEASURES = ("total_time_s", "losses_of_contact", "losses_100ms", "losses_per_s",
            "mean_penetration_m",
            "mean_penetration_dm", "mean_contact_angle_deg")
VARIANT = ("view", "align", "start_orientation_deg", "scale")
HAPTIC, ROTATION = ("NoH", "UaH", "H"), ("NoR", "R")
OBJECTS = ("O1", "O2", "O3", "O4")


def six(value: float) -> float:
    return float(f"{value:.6g}")


def trials(r: random.Random, *, people: Sequence[str] | int = 6, blocks: Sequence[int] | int = 2,
           haptic: Sequence[str] = HAPTIC, rotation: Sequence[str] = ROTATION,
           objects: Sequence[str] = ("O1", "O2"), following: str = "", effects: float = 1.0,
           noise: float = 1.0, **variant: Any) -> list[Row]:
    """Trials of one kind of operator, all done. Effects are about those of the paper."""
    names = [str(p + 1) for p in range(people)] if isinstance(people, int) else people
    numbers = range(blocks + 1) if isinstance(blocks, int) else blocks
    rows = []
    for name in names:
        person = r.gauss(0, 1)
        in_condition = {(h, t): r.gauss(0, 0.5) for h in haptic for t in rotation}
        for block in numbers:
            order = [(h, t, o) for h in haptic for t in rotation for o in objects]
            r.shuffle(order)
            for place, (h, t, o) in enumerate(order, start=1):
                i, turned, w = HAPTIC.index(h), 0.5 if t == "R" else -0.5, in_condition[h, t]
                time = (27 + effects * ((2, 0.3, -2)[i] + 4 * turned) + 3 * person + 2 * w
                        + 2.5 * objects.index(o) - 0.8 * block + noise * r.gauss(0, 4))
                losses = (22 + effects * ((2, 0, -1.5)[i] + 2 * turned) + 2 * person + w
                          + 0.3 * (time - 27) + noise * r.gauss(0, 2))
                depth = (0.067 + effects * (0.034, 0.001, -0.036)[i] + 0.004 * person + 0.003 * w
                         + noise * r.gauss(0, 0.008))
                angle = 41 - 17 * effects * turned + 2 * person + w + noise * r.gauss(0, 3)
                rows.append(_row(following, name, block, place, h, t, o, time, losses, depth, angle,
                                 variant))
    return rows


def _row(following: str, name: str, block: int, place: int, haptic: str, rotation: str, thing: str,
         time: float, losses: float, depth: float, angle: float, variant: Row) -> Row:
    time_s, count, depth_dm = six(max(2.0, time)), max(0, round(losses)), six(max(0.001, depth))
    return {"following": following, "participant": name, "block": block, "trial": place,
            "haptic": haptic,
            "rotation": rotation, "object": thing, "attempt": 1, "status": "done",
            "total_time_s": time_s,
            "losses_of_contact": count, "losses_100ms": count // 2,
            "losses_per_s": six(count / time_s),
            "mean_penetration_m": six(depth_dm / 10), "mean_penetration_dm": depth_dm,
            "mean_contact_angle_deg": six(max(1.0, angle)), **variant}


def text_of(rows: Sequence[Row], columns: Sequence[str] | None = None, end: str = "\n") -> str:
    """trials.csv: the columns that any row has, in the order of the program."""
    if columns is None:
        known = FACTORS + MEASURES + VARIANT
        columns = [name for name in known if any(name in row for row in rows)]
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator=end)
    writer.writerow(columns)
    for row in rows:
        writer.writerow([row.get(name, "") for name in columns])
    return text.getvalue()


def ended(row: Row, status: str) -> Row:
    """A trial without measures."""
    for name in MEASURES:
        row.pop(name, None)
    row["status"] = status
    return row


def is_at(row: Row, **levels: Any) -> bool:
    return all(str(row[name]) == str(level) for name, level in levels.items())


def without(rows: Sequence[Row], *names: str) -> list[Row]:
    return [{key: value for key, value in row.items() if key not in names} for row in rows]


def dropped(r: random.Random, rows: Sequence[Row], share: float) -> list[Row]:
    return [row for row in rows if r.random() >= share]


def some_end(r: random.Random, rows: list[Row], share: float, status: str,
             **levels: Any) -> list[Row]:
    for row in rows:
        if is_at(row, **levels) and r.random() < share:
            ended(row, status)
    return rows


def scaled(rows: list[Row], **factors: float) -> list[Row]:
    for row in rows:
        for name, factor in factors.items():
            if name in row:
                row[name] = six(row[name] * factor)
    return rows


def put(rows: list[Row], value: Callable[[Row], Row]) -> list[Row]:
    for row in rows:
        row.update(value(row))
    return rows


def tie_depth(rows: list[Row]) -> list[Row]:
    return put(rows, lambda row: {"mean_penetration_m": row["mean_penetration_dm"] / 10})
