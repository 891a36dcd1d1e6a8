#!/usr/bin/env python3
"""Compares the strategies for missing motors on the paper's objects and keeps the results.

measure_compare.py PROGRAM

Writes OPERATOR.json into benchmarks/results/compare: how the trials ended and how many of them left the
workspace, the means over all objects together, and where A4 loses. An interval is null where all hands
have the same value. The results depend on the code alone. The run takes a minute or two, and
the program needs Python with the packages of palpate.analysis.
"""

import json
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
RESULTS = ROOT / "benchmarks" / "results" / "compare"
OPERATOR = "people2005"
SCENES = [f"models/{name}.glb" for name in ("star", "labyrinth", "inverted_labyrinth", "lock")]
MEAN_KEYS = ("measure", "unit", "strategy", "role", "hands", "mean", "half_width",
             "minus_mask", "mask_half_width", "minus_a4", "a4_half_width", "standing")
COMPARABLE = (0, 3)  # 3: a strategy completed too few trials; the results say which


def main():
    program = pathlib.Path(sys.argv[1]).resolve()
    RESULTS.mkdir(parents=True, exist_ok=True)
    path = RESULTS / f"{OPERATOR}.json"
    path.write_text(text_of(measure(program)), encoding="utf-8")
    print(f"wrote {path}")


def text_of(result):
    """JSON with a line for each entry, and for each row of a table."""
    def value_text(value):
        if isinstance(value, list) and value and isinstance(value[0], dict):
            return "[\n  " + ",\n  ".join(json.dumps(row) for row in value) + "]"
        return json.dumps(value)
    lines = [f" {json.dumps(key)}: {value_text(value)}" for key, value in result.items()]
    return "{\n" + ",\n".join(lines) + "\n}\n"


def measure(program):
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run([program, "compare", *SCENES, "--operator", OPERATOR, "--out", folder,
                               "--json"], cwd=ROOT, stdout=subprocess.PIPE, check=False)
    if done.returncode not in COMPARABLE:
        sys.exit(f"palpate compare: exit code {done.returncode}")
    result = json.loads(done.stdout)
    return {**{key: result[key] for key in ("operator", "hands", "seed", "scenes", "comparable",
                                            "strategies", "a4_losses")},
            "workspace_m": result["device"]["workspace_m"],
            "means": [{key: row[key] for key in MEAN_KEYS} for row in result["means"]
                      if row["scene"] == ""]}


if __name__ == "__main__":
    main()
