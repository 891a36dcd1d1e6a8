#!/usr/bin/env python3
"""Runs `palpate soak --device` at four rates and writes its tables into a folder.

    benchmarks/measure_calm_chart.py build/release/palpate benchmarks/results/calm_chart

The simulation has no clock: the same program writes the same bytes.
"""

import pathlib
import subprocess
import sys
import tempfile

import calm_chart_results as results

RATES_HZ = (250, 1000, 4000, 10000)
CASES = 150
SEED = 49


def main():
    if len(sys.argv) != 3:
        sys.exit("usage: measure_calm_chart.py PROGRAM FOLDER")
    program, folder = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
    lines = []
    with tempfile.TemporaryDirectory() as out:
        for rate in RATES_HZ:
            done = subprocess.run([program, "soak", "--device", "--cases", str(CASES), "--seed", str(SEED + rate),
                                   "--rate", str(rate), "--out", out], check=False)
            if done.returncode not in (0, 1):
                sys.exit(f"soak --device ended with exit code {done.returncode}")
            header, *rows = (pathlib.Path(out) / results.CASES).read_text(encoding="utf-8").splitlines()
            lines += ([] if lines else [header]) + rows
        zones = (pathlib.Path(out) / results.ZONES).read_text(encoding="utf-8")
    folder.mkdir(parents=True, exist_ok=True)
    (folder / results.CASES).write_text("\n".join(lines) + "\n", encoding="utf-8")
    (folder / results.ZONES).write_text(zones, encoding="utf-8")


if __name__ == "__main__":
    main()
