#!/usr/bin/env python3
"""Runs the sweep that ships and keeps its results.

measure_sweep.py PROGRAM [FOLDER]

Writes sweep.json into benchmarks/results/sweep: how the trials ended, the ranges of the parameters in the
hypercube, and at which share of its points each ranking holds, over all testable points and in the
parts by each parameter. The results depend on the code alone. The run takes less than ten minutes on two cores. FOLDER:
where the parts of the run are kept, so that an interrupted run goes on; by default a temporary folder.
"""

import csv
import json
import pathlib
import subprocess
import sys
import tempfile

from measure_compare import text_of

ROOT = pathlib.Path(__file__).resolve().parent.parent
RESULTS = ROOT / "benchmarks" / "results" / "sweep"
COUNTS = ("trials", "done", "timeouts", "faults")


def main():
    program = pathlib.Path(sys.argv[1]).resolve()
    RESULTS.mkdir(parents=True, exist_ok=True)
    path = RESULTS / "sweep.json"
    if len(sys.argv) > 2:
        result = measure(program, pathlib.Path(sys.argv[2]).resolve())
    else:
        with tempfile.TemporaryDirectory() as folder:
            result = measure(program, pathlib.Path(folder))
    path.write_text(text_of(result), encoding="utf-8")
    print(f"wrote {path}")


def rows_of(path):
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def value(text):
    """A number, a word, or None for an empty field."""
    if not text:
        return None
    try:
        return float(text) if "." in text or "e" in text else int(text)
    except ValueError:
        return text


def measure(program, folder):
    subprocess.run([program, "experiment", "sweep", "sweep", "--out", folder], check=True, cwd=ROOT,
                   stdout=subprocess.DEVNULL)
    return results_in(folder)


def results_in(folder):
    rows = rows_of(folder / "sweep.csv")
    halves = [{key: value(text) for key, text in row.items()}
              for row in rows_of(folder / "halves.csv")]
    return {"points": {block: len({row["point"] for row in rows if row["block"] == block})
                       for block in ("base", "one_at_a_time", "hypercube")},
            "counts": {count: sum(int(row[count]) for row in rows) for count in COUNTS},
            "ranges": [range_of(name) for name in dict.fromkeys(h["parameter"] for h in halves)],
            "rankings": [{key: value(text) for key, text in row.items()}
                         for row in rows_of(folder / "rankings.csv")],
            "halves": halves}


def range_of(name):
    """From which the hypercube draws."""
    literature, sweep = (json.loads((ROOT / "engine" / "trials" / file).read_text())
                         for file in ("literature.json", "sweep.json"))
    levels = sweep["parameters"][name]
    if isinstance(levels[0], str):
        return {"parameter": name, "words": levels}
    drawn = literature["parameters"].get(name, {"low": min(levels), "high": max(levels)})
    return {"parameter": name, "low": drawn["low"], "high": drawn["high"]}


if __name__ == "__main__":
    main()
