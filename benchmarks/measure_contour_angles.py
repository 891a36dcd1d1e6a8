#!/usr/bin/env python3
"""Measures the contact angles of a hand without delay on the paper's four objects.

measure_contour_angles.py PROGRAM

PROGRAM: build/release/write_contour_angles. Writes benchmarks/results/contour_angles.csv in about a
second. The time is simulated: the results depend on the code alone.
"""

import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
RESULT = ROOT / "benchmarks" / "results" / "contour_angles.csv"


def main():
    subprocess.run([sys.argv[1], ROOT / "models", RESULT], check=True)
    print(f"wrote {RESULT}")


if __name__ == "__main__":
    main()
