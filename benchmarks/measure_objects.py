#!/usr/bin/env python3
"""Follows the paper's four objects without and with A4 and keeps what came out.

measure_objects.py PROGRAM

Writes benchmarks/results/paper_objects/objects.json and the picture of the star. In simulated time,
so the numbers depend on the code alone; times of this machine are left out.
"""

import json
import pathlib
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
RESULTS = ROOT / "benchmarks" / "results" / "paper_objects"
OBJECTS = ["star", "labyrinth", "inverted_labyrinth", "lock"]
KEPT = ["a4", "mean_contact_angle_deg", "share_within_30deg", "mean_penetration_m",
        "contact_share", "way_share", "losses_of_contact", "port_work_J"]


def main():
    program = sys.argv[1]
    objects = {}
    RESULTS.mkdir(parents=True, exist_ok=True)
    for name in OBJECTS:
        with tempfile.TemporaryDirectory() as out:
            result = subprocess.run(
                [program, "run", ROOT / "models" / f"{name}.glb", "--virtual", "--json",
                 "--out", out], check=True, capture_output=True, text=True)
            if name == "star":
                shutil.copy(pathlib.Path(out) / "paths.svg", RESULTS / "star.svg")
        runs = json.loads(result.stdout)["runs"]
        objects[name] = [{key: run[key] for key in KEPT} for run in runs]
    (RESULTS / "objects.json").write_text(json.dumps(objects, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
