#!/usr/bin/env python3
"""Writes the report of made trials, for viewing and for the test in a browser.

make_experiment_report.py PALPATE simulated|people FOLDER
"""

import pathlib
import subprocess
import sys
import tempfile

from sample_trials import SampleTrials, sample_trials, trials_csv

SIMULATED = SampleTrials(followings=("delayed", "predict", "replan", "frozen"), has_timeouts=True)


def trials(kind):
    """Of simulated operators, who have all followings and timeouts; of people, with the measures that
    an analysis needs and the contact angle."""
    if kind == "simulated":
        return sample_trials(SIMULATED)
    rows = sample_trials()
    for row in rows:
        for column in ("losses_per_s", "losses_100ms", "mean_penetration_m"):
            row.pop(column, None)
    return rows


def main():
    palpate, kind, folder = sys.argv[1:]
    with tempfile.TemporaryDirectory() as place:
        file = pathlib.Path(place, "trials.csv")
        file.write_text(trials_csv(trials(kind)))
        done = subprocess.run([palpate, "experiment", "analyse", str(file), "--out", folder],
                              stderr=subprocess.PIPE, text=True, check=False)
    sys.stderr.write(done.stderr)
    return done.returncode or bool(done.stderr)


if __name__ == "__main__":
    sys.exit(main())
