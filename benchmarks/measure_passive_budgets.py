#!/usr/bin/env python3
"""Compares budgets of a4-passive with mask and a4 on the paper's objects and keeps the results.

measure_passive_budgets.py PROGRAM

Writes benchmarks/results/compare/a4_passive.json: the means over all trials that ended at the red
sphere. The results depend on the code alone. The run takes a minute or two.
"""

import csv
import math
import pathlib
import subprocess
import sys
import tempfile

from measure_compare import COMPARABLE, OPERATOR, RESULTS, ROOT, SCENES, text_of

BUDGETS_MJ = (0, 1, 2, 5, 10, 15, 20)
STRATEGIES = ("mask", *(f"a4-passive:{budget}" for budget in BUDGETS_MJ), "a4")
# Name of the measure, column of trials.csv.
MEASURES = (("contact angle", "mean_contact_angle_deg"), ("penetration", "mean_penetration_m"),
            ("missing force", "mean_missing_force_N"), ("energy of turning", "turning_energy_J"),
            ("port work", "port_work_J"), ("work along the wall", "wall_work_J"),
            ("work of one contact", "largest_contact_work_J"),
            ("losses of contact", "losses_of_contact"))


def main():
    program = pathlib.Path(sys.argv[1]).resolve()
    path = RESULTS / "a4_passive.json"
    path.write_text(text_of(measure(program)), encoding="utf-8")
    print(f"wrote {path}")


def measure(program):
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run([program, "compare", *SCENES, "--operator", OPERATOR, "--strategies",
                               ",".join(STRATEGIES), "--out", folder], cwd=ROOT,
                              stdout=subprocess.DEVNULL, check=False)
        if done.returncode not in COMPARABLE:
            sys.exit(f"palpate compare: exit code {done.returncode}")
        return means_of(pathlib.Path(folder) / "trials" / "trials.csv")


def means_of(trials):
    with open(trials, encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    done = {name: [row for row in rows if row["strategy"] == name and row["status"] == "done"]
            for name in STRATEGIES}
    means = [{"measure": measure, "strategy": name,
              "mean": math.fsum(float(row[column]) for row in of) / len(of)}
             for measure, column in MEASURES for name, of in done.items()]
    return {"operator": OPERATOR, "hands": len({row["participant"] for row in rows}),
            "scenes": SCENES, "trials": len(rows), "done": sum(map(len, done.values())),
            "means": means}


if __name__ == "__main__":
    main()
