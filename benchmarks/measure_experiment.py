#!/usr/bin/env python3
"""Runs the paper's experiment with both files of simulated operators and keeps the results.

measure_experiment.py PROGRAM

Writes OPERATOR.json into benchmarks/results/experiment: the means that the paper prints, too, and
the verdict about each of its findings, for every following. The results depend on the code alone.
The two runs take a few minutes.
"""

import csv
import json
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
RESULTS = ROOT / "benchmarks" / "results" / "experiment"
OPERATORS = ["people2005", "literature"]


def main():
    program = pathlib.Path(sys.argv[1]).resolve()
    RESULTS.mkdir(parents=True, exist_ok=True)
    for name in OPERATORS:
        with tempfile.TemporaryDirectory() as folder:
            result = measure(program, name, pathlib.Path(folder))
        path = RESULTS / f"{name}.json"
        path.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
        print(f"wrote {path}")


def measure(program, operator, folder):
    def palpate(*arguments):
        subprocess.run([program, "experiment", *arguments], check=True, cwd=folder,
                       stdout=subprocess.DEVNULL)

    palpate("plan", "paper", "--out", "plan.json")
    plan = json.loads((folder / "plan.json").read_text())
    plan["operator"] = operator
    (folder / "plan.json").write_text(json.dumps(plan))
    palpate("run", "plan.json", "--out", "trials")
    palpate("analyse", "trials/trials.csv", "--out", "analysis")
    return {"operator": operator, "seed": plan["seed"],
            "trials": trials_of(folder / "analysis" / "missing_trials.csv"),
            "means": means_of(folder / "analysis" / "means.csv"),
            "findings": findings_of(folder / "analysis" / "findings.csv")}


def rows_of(path):
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def trials_of(path):
    """How many trials of each following were done, and how many were not."""
    return [{"following": row["following"], "done": int(row["done"]),
             "timeouts": int(row["timeouts"]), "faults": int(row["faults"])}
            for row in rows_of(path)
            if {row["haptic"], row["rotation"], row["object"]} == {"all"}]


def means_of(path):
    """The means of trials at the levels for which the paper prints a mean."""
    return [{**{key: row[key] for key in ("following", "outcome", "unit", "haptic", "rotation")},
             **{key: float(row[key]) for key in ("mean", "sd", "paper_mean", "paper_sd")}}
            for row in rows_of(path) if row["of"] == "trials" and row["paper_mean"]]


def findings_of(path):
    return [{key: row[key] for key in ("following", "finding", "paper_statement", "verdict")}
            for row in rows_of(path)]


if __name__ == "__main__":
    main()
