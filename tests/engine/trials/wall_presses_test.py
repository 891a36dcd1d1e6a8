#!/usr/bin/env python3
"""Presses of walls are those of the committed results, and have the gain that a4-passive states.

usage: wall_presses_test.py WRITE_WALL_PRESSES PROJECT_DIR
"""

import json
import math
import pathlib
import sys

PROGRAM, PROJECT = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
sys.dont_write_bytecode = True
sys.path.insert(0, str(PROJECT / "benchmarks"))
import measure_passive_budgets  # noqa: E402
import passive_results  # noqa: E402

ROUNDING = 1e-6  # of the nine digits of the file, and of what platforms differ in sine and cosine
OWN_BUDGET_S = 2.0  # before a press: more than TurnBudget::kRest_s


def expect(condition, statement):
    if not condition:
        sys.exit(f"false: {statement}")


def main():
    committed = json.loads((PROJECT / "benchmarks/results/compare/a4_passive.json").read_text())
    rows = measure_passive_budgets.pressed(PROGRAM)
    expect(len(rows) == len(committed["presses"]), "the results have each strategy and pause")
    for ours, theirs in zip(rows, committed["presses"]):
        for key, value in theirs.items():
            same = (ours[key] == value if isinstance(value, str)
                    else math.isclose(ours[key], value, rel_tol=ROUNDING, abs_tol=1e-12))
            expect(same, f"{theirs['strategy']}, {theirs['pause_s']} s: {key} is {value}, as committed (now "
                   f"{ours[key]}; run benchmarks/measure_passive_budgets.py)")
    result = {"presses": rows}
    depths = passive_results.presses_of(result, OWN_BUDGET_S, "depth_m")
    gains = passive_results.shares(depths)
    expect(gains["a4-passive:10"] > 0.8, "10 mJ give more than four fifths of A4's gain")
    expect(gains["a4-passive:0"] > 0.25, "0 mJ give more than a quarter")
    energies = passive_results.presses_of(result, OWN_BUDGET_S, "turning_energy_J")
    for name, energy_J in energies.items():
        if name.startswith(passive_results.PREFIX):
            most_J = 1e-3 * float(name.removeprefix(passive_results.PREFIX))
            expect(energy_J <= most_J + 1e-12, f"the turns of a press add no more than {name}")
    print("the presses are those of the results")


if __name__ == "__main__":
    main()
