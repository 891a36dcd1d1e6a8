#!/usr/bin/env python3
"""unbalanced_trials.py: prints trials for the comparison with R.

Six people differ, and each differs in every condition; every seventh trial is missing.
"""

import csv
import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from sample_trials import SampleTrials, sample_trials


def rows():
    found = [row for row in sample_trials(SampleTrials(participants=6, seed=7)) if row["block"] > 0]
    conditions = sorted({(row["haptic"], row["rotation"]) for row in found})
    for row in found:
        c = conditions.index((row["haptic"], row["rotation"]))
        own = math.sin(7.0 * int(row["participant"]) + 3.0 * c)  # of the person in the condition
        row["total_time_s"] += 4.0 * own
        row["mean_penetration_dm"] += 0.01 * own
        row["losses_of_contact"] += round(3.0 * (1.0 + own))
    return [row for i, row in enumerate(found) if i % 7]


def main():
    columns = ["participant", "block", "haptic", "rotation", "object", "total_time_s",
               "losses_of_contact", "mean_penetration_dm"]
    writer = csv.writer(sys.stdout, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows([row[column] for column in columns] for row in rows())


if __name__ == "__main__":
    main()
