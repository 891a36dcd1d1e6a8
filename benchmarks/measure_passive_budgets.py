#!/usr/bin/env python3
"""Compares budgets of a4-passive with mask and a4 and keeps the results.

measure_passive_budgets.py PROGRAM PRESSES

PROGRAM: build/release/palpate; PRESSES: build/release/write_wall_presses. Writes
benchmarks/results/compare/a4_passive.json: on ways round the paper's objects, the means over all
trials that ended at the red sphere, and the paired differences in penetration to a budget of 0; of
single presses of walls, the depths. The results depend on the code alone. The run takes a minute or
two.
"""

import csv
import math
import pathlib
import statistics
import subprocess
import sys
import tempfile

from measure_compare import COMPARABLE, OPERATOR, RESULTS, ROOT, SCENES, text_of

# Student's t of 95 % for the mean of 20 hands, the number of `palpate compare`.
HANDS, STUDENT_T = 20, 2.093
BUDGETS_MJ = (0, 1, 2, 5, 10, 20, 50, 100, 200)
WITHOUT_BUDGET = "a4-passive:0"
STRATEGIES = ("mask", *(f"a4-passive:{budget}" for budget in BUDGETS_MJ), "a4")
# Name of the measure, column of trials.csv.
MEASURES = (("contact angle", "mean_contact_angle_deg"), ("penetration", "mean_penetration_m"),
            ("missing force", "mean_missing_force_N"), ("energy of turning", "turning_energy_J"),
            ("port work", "port_work_J"), ("work along the wall", "wall_work_J"),
            ("work of one contact", "largest_contact_work_J"),
            ("losses of contact", "losses_of_contact"))


def main():
    program, presses = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
    path = RESULTS / "a4_passive.json"
    result = {**measure(program), "presses": pressed(presses)}
    path.write_text(text_of(result), encoding="utf-8")
    print(f"wrote {path}")


def measure(program):
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run([program, "compare", *SCENES, "--operator", OPERATOR, "--strategies",
                               ",".join(STRATEGIES), "--out", folder], cwd=ROOT,
                              stdout=subprocess.DEVNULL, check=False)
        if done.returncode not in COMPARABLE:
            sys.exit(f"palpate compare: exit code {done.returncode}")
        return means_of(pathlib.Path(folder) / "trials" / "trials.csv")


def pressed(presses):
    """The rows of write_wall_presses."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "presses.csv"
        subprocess.run([presses, path, *STRATEGIES], check=True)
        return [{key: text if key == "strategy" else float(text) for key, text in row.items()}
                for row in rows_of(path)]


def rows_of(path):
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def means_of(trials):
    rows = rows_of(trials)
    done = {name: [row for row in rows if row["strategy"] == name and row["status"] == "done"]
            for name in STRATEGIES}
    means = [{"measure": measure, "strategy": name,
              "mean": math.fsum(float(row[column]) for row in of) / len(of)}
             for measure, column in MEASURES for name, of in done.items()]
    return {"operator": OPERATOR, "hands": len({row["participant"] for row in rows}),
            "scenes": SCENES, "trials": len(rows), "done": sum(map(len, done.values())),
            "means": means, "paired": [paired(name, done) for name in STRATEGIES]}


def paired(name, done):
    """The difference in penetration to a budget of 0, and half of its 95 % interval: the mean over
    hands of their means over the scenes that they completed with both."""
    def depths(strategy):
        return {(row["participant"], row["object"]): float(row["mean_penetration_m"])
                for row in done[strategy]}
    ours, others = depths(name), depths(WITHOUT_BUDGET)
    by_hand = {}
    for key in sorted(ours.keys() & others.keys()):
        by_hand.setdefault(key[0], []).append(ours[key] - others[key])
    means = [statistics.fmean(differences) for differences in by_hand.values()]
    if len(means) != HANDS:
        sys.exit(f"expected {HANDS} hands, found {len(means)}")
    return {"strategy": name, "minus_0_m": statistics.fmean(means),
            "half_width_m": STUDENT_T * statistics.stdev(means) / math.sqrt(HANDS)}


if __name__ == "__main__":
    main()
