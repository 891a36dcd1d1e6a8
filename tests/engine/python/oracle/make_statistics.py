#!/usr/bin/env python3
"""Makes the data sets of statistics/input.json: the same bytes every time.

statistics/expected.json holds what the C++ functions of statistics at commit 53aa82cd computed
for them (README.md).
"""

from __future__ import annotations

import json
import math
import random
from collections.abc import Callable
from itertools import product
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
Draw = Callable[[random.Random], float]


def normal(scale: float = 1.0, mean: float = 0.0) -> Draw:
    return lambda r: float(f"{mean + scale * r.gauss(0, 1):.9g}")


def heavy(r: random.Random) -> float:
    return float(f"{r.lognormvariate(0, 1.5):.9g}")


def whole(r: random.Random) -> float:
    return float(r.randrange(6))


def repeated(name: str, levels: list[int], people: int, draw: Draw, *, between: float = 1.0,
             slope: float = 0.0) -> dict[str, Any]:
    """A table of people by cells; the last factor varies fastest. slope: by which the scatter grows
    from cell to cell."""
    r = random.Random(name)
    table = []
    for _ in range(people):
        person = between * r.gauss(0, 1)
        cells = range(math.prod(levels))
        table.append([float(f"{person + (1 + slope * c) * draw(r) + 0.1 * c:.9g}") for c in cells])
    return {"levels": levels, "table": table}


def repeated_sets() -> dict[str, dict[str, Any]]:
    sets = {
        "two_levels": ([2], 9, normal(), {}), "three_levels": ([3], 5, normal(), {}),
        "two_people": ([3, 2], 2, normal(), {}), "fewer_people_than_cells": ([3, 2, 4], 10,
                                                                             normal(), {}),
        "the_papers_design": ([3, 2, 4, 3], 10, normal(5.0, 27.0), {"between": 3.0}),
        "unequal_scatter": ([4, 2], 8, normal(), {"slope": 1.5}),
        "far_from_spherical": ([6], 12, normal(), {"slope": 4.0}),
        "heavy_tails": ([3, 2], 12, heavy, {}),
        "whole_numbers": ([3, 3], 6, whole, {"between": 0.0}),
        "large_mean": ([3, 2], 7, normal(1.0, 1e6), {}), "tiny": ([2, 2], 6, normal(1e-9),
                                                                  {"between": 1e-9}),
        "many_people": ([2, 3], 60, normal(), {"between": 5.0})}
    found = {name: repeated(name, levels, n, draw, **more) for name,
             (levels, n, draw, more) in sets.items()}
    equal = repeated("equal_differences", [2], 5, normal())
    for row in equal["table"]:
        row[:] = [row[0], row[0] + 0.25]
    found["equal_differences"] = equal
    found["constant"] = {"levels": [3, 2], "table": [[0.1] * 6 for _ in range(4)]}
    for name in ("tiny",):
        for row in found[name]["table"]:
            row[:] = [float(f"{value - 0.1 * c:.9g}") for c, value in enumerate(row)]
    return found


def factorial(name: str, levels: list[int], most: int, responses: list[Draw], *, keep: int = 1,
              terms: list[list[int]] | None = None) -> dict[str, Any]:
    """Rows of a design with keep to `most` rows in each cell."""
    r = random.Random(name)
    rows, values = [], []
    for cell in product(*map(range, levels)):
        for _ in range(r.randint(keep, most)):
            rows.append(list(cell))
            shift = 0.3 * sum(cell)
            values.append([float(f"{shift + draw(r):.9g}") for draw in responses])
    return {"levels": levels, "rows": rows, "responses": values, "terms": terms or []}


def factorial_sets() -> dict[str, dict[str, Any]]:
    n = normal()
    found = {
        "balanced": factorial("balanced", [3, 2], 4, [n, n, n], keep=4),
        "unbalanced": factorial("unbalanced", [3, 2], 6, [n, n, n]),
        "three_factors": factorial("three_factors", [3, 2, 4], 4, [n, n]),
        "the_papers_design": factorial("the_papers_design", [3, 2, 4, 3], 10, [n, n, n], keep=9),
        "one_factor": factorial("one_factor", [5], 8, [n, n, n, n], keep=2),
        "main_effects_alone": factorial("main_effects_alone", [3, 2, 2], 3, [n, n],
                                        terms=[[0], [1], [2]]),
        "one_row_in_most_cells": factorial("one_row_in_most_cells", [4, 3], 2, [n]),
        "units_of_many_sizes": factorial("units_of_many_sizes", [2, 3], 5,
                                         [normal(1e-6), normal(1.0, 1e5), heavy]),
        "heavy_tails": factorial("heavy_tails", [3, 3], 5, [heavy, heavy]),
        "whole_numbers": factorial("whole_numbers", [2, 2], 6, [whole, whole], keep=3)}
    for row in found["units_of_many_sizes"]["responses"]:
        row[0] = float(f"{row[0] * 1e-6:.9g}")
    return found


def pairs_sets() -> dict[str, dict[str, Any]]:
    r = random.Random("pairs")
    found = {}
    for name, n, draw in (("ten", 10, normal()), ("two", 2, normal()), ("heavy", 30, heavy),
                          ("one", 1, normal()),
                          ("whole", 12, whole), ("large", 6, normal(1e-3, 1e6))):
        found[name] = {"a": [draw(r) for _ in range(n)], "b": [draw(r) for _ in range(n)]}
    return found


def arguments() -> dict[str, Any]:
    """Arguments of the distributions, of Wilson's interval, Holm's adjustment, PLSD and Rao's F."""
    r = random.Random("arguments")
    fs = [0.0, 1e-300, 1e-9, 0.01, 0.5, 1.0, 2.5, 10.0, 300.0, 1e4, 1e9]
    dfs = [(1, 1), (1, 9), (2, 18), (2, 648), (6, 54), (0.7, 3.2), (12.5, 0.4), (3, 1e6), (648, 2),
           (33, 297)]
    return {
        "f_upper_tail": [[f, *df] for f in fs for df in dfs],
        "f_for_tail": [[tail, *df] for tail in (1e-12, 1e-6, 0.001, 0.05, 0.5, 0.95, 1 - 1e-9)
                       for df in dfs],
        "t_two_sided": [[t, df] for t in (0.0, 1e-12, -0.5, 1.0, -2.1, 12.7, 40.0, -1e4, 1e8)
                        for df in (1, 2, 4.5, 9, 18, 648, 1e7)],
        "t_for_coverage": [[c, df] for c in (1e-9, 0.5, 0.9, 0.95, 0.99, 1 - 1e-9)
                           for df in (1, 2, 3, 9, 18, 647, 1e6)],
        "z_for_coverage": [[c] for c in (1e-9, 0.5, 0.9, 0.95, 0.99, 1 - 1e-9)],
        "wilson": [[c, n] for n in (0, 1, 2, 10, 30, 1000, 100000)
                   for c in sorted({0, n // 3, n // 2, n - 1, n})
                   if 0 <= c <= n],
        "holm": [[0.01, None, 0.04], [0.9, 0.8], [0.05, 0.05, 0.05], [], [None],
                 [1e-20, 0.3, 1e-5, 0.3, 1.0],
                 [float(f"{r.random():.9g}") for _ in range(15)]],
        "plsd": [{"means": [float(f"{r.gauss(0, 1):.9g}") for _ in range(k)],
                  "counts": [r.randint(2, 60)
                 for _ in range(k)], "mse": mse, "df": df}
                 for k, mse, df in ((2, 1.0, 5), (3, 0.3, 648), (4, 25.0, 12), (3, 1e-9, 40))],
        "rao": [[lam, p, q, v] for lam in (1.0, 0.999, 0.9, 0.5, 0.1, 1e-6)
                for p, q, v in ((1, 1, 10), (1, 5, 40), (3, 1, 648), (3, 2, 648), (3, 6, 648),
                                (2, 3, 9), (4, 4, 12),
                                (3, 12, 60))]}


def main() -> None:
    tree = {"repeated": repeated_sets(), "factorial": factorial_sets(), "pairs": pairs_sets(),
            **arguments()}
    (HERE / "statistics").mkdir(exist_ok=True)
    text = json.dumps(tree, separators=(",", ":"))
    (HERE / "statistics" / "input.json").write_text(text.replace('},"', '},\n"') + "\n")


if __name__ == "__main__":
    main()
