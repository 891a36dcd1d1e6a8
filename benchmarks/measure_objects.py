#!/usr/bin/env python3
"""Explores the paper's four objects without and with A4 and keeps the results.

measure_objects.py PROGRAM

Writes into benchmarks/results/paper_objects: objects.json, the figures of each run; star.svg, the
paths that the program draws; a4.json, four instants of the run on the star (a4_instants.py). The runs
are in simulated time: the results depend on the code alone, and times of this machine are left out.
"""

import json
import pathlib
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True  # no folder beside the sources

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "engine/python"))
import a4_instants  # noqa: E402
from palpate.analysis.results.grounds import on_any_ground  # noqa: E402

RESULTS = ROOT / "benchmarks" / "results" / "paper_objects"
LETTERS = 1.3  # star.svg is shown smaller than a run's picture
OBJECTS = ["star", "labyrinth", "inverted_labyrinth", "lock"]
KEPT = ["a4", "mean_contact_angle_deg", "share_within_30deg", "mean_penetration_m",
        "contact_share", "way_share", "losses_of_contact", "port_work_J"]


def main():
    program = sys.argv[1]
    objects = {}
    RESULTS.mkdir(parents=True, exist_ok=True)
    for name in OBJECTS:
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder)
            result = subprocess.run(
                [program, "run", ROOT / "models" / f"{name}.glb", "--virtual", "--json",
                 "--out", out], check=True, capture_output=True, text=True)
            if name == "star":
                picture = (out / "paths.svg").read_text(encoding="utf-8")
                (RESULTS / "star.svg").write_text(on_any_ground(picture, LETTERS), encoding="utf-8")
                instants = a4_instants.instants_of(out / "trace-on.csv", out / "contour-on.csv")
                write_json(RESULTS / "a4.json", instants)
        runs = json.loads(result.stdout)["runs"]
        objects[name] = [{key: run[key] for key in KEPT} for run in runs]
    write_json(RESULTS / "objects.json", objects)


def write_json(path, content):
    path.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
