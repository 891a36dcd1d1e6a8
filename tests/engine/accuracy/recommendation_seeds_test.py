#!/usr/bin/env python3
"""Five seeds recommend the same levels.

recommendation_seeds_test.py PALPATE SCENE

Runs `palpate accuracy SCENE --quick` with five seeds on this machine. Each knob must recommend the same
level with every seed; prints the processor and, for each knob, the levels recommended.
"""

import argparse
import csv
import pathlib
import subprocess
import sys
import tempfile

SEEDS = range(1, 6)
TIMEOUT_S = 300


def processor_name():
    for line in pathlib.Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
        if line.startswith("model name"):
            return line.split(": ", 1)[1]
    return "unknown"


def recommended_levels(palpate, scene, seed):
    """{knob: (method, level, whether it is the default)}"""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([palpate, "accuracy", scene, "--quick", "--seed", str(seed), "--out", folder],
                       check=True, stdout=subprocess.DEVNULL, timeout=TIMEOUT_S)
        with open(pathlib.Path(folder) / "raw.csv", newline="", encoding="utf-8") as table:
            return {row["knob"]: (row["method"], row["level"], row["is_default"] == "1")
                    for row in csv.DictReader(table) if row["recommended"] == "1"}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("palpate")
    parser.add_argument("scene")
    options = parser.parse_args()
    by_seed = [recommended_levels(options.palpate, options.scene, seed) for seed in SEEDS]
    print(f"processor: {processor_name()}")
    differing = 0
    for knob in by_seed[0]:
        levels = [levels.get(knob) for levels in by_seed]
        is_same = len(set(levels)) == 1
        differing += not is_same
        shown = ", ".join(f"{level} ({method}{', default' if is_default else ''})"
                          for method, level, is_default in dict.fromkeys(filter(None, levels)))
        print(f"{'same' if is_same else 'DIFFERS'}  {knob}: {shown}")
    if len(by_seed[0]) < 21:
        sys.exit(f"{len(by_seed[0])} knobs recommend a level, expected 21 or more")
    return 1 if differing else 0


if __name__ == "__main__":
    sys.exit(main())
