#!/usr/bin/env python3
"""`experiment analyse`: the files that it writes, and its refusals.

analyse_command_test.py PALPATE
"""

import contextlib
import json
import os
import pathlib
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "python"))
from sample_trials import SampleTrials, sample_trials, trials_csv

FILES = ["analysis.json", "comparisons.csv", "differences.csv", "effects.csv", "findings.csv",
         "loss_rates.csv", "means.csv", "missing_trials.csv", "rating_tests.csv", "ratings.csv",
         "report.html", "variances.csv", "verdicts.csv"]


def check(condition, message):
    if not condition:
        sys.exit(message)


def contents(folder):
    """The bytes of the files below a folder, by path."""
    return {str(path.relative_to(folder)): path.read_bytes()
            for path in sorted(folder.rglob("*")) if path.is_file()}


class Folder:
    def __init__(self, palpate, path):
        self.palpate, self.path = palpate, pathlib.Path(path)

    def write(self, name, rows):
        (self.path / name).write_text(rows if isinstance(rows, str) else trials_csv(rows))

    def analyse(self, *arguments):
        return subprocess.run([self.palpate, "experiment", "analyse", *arguments], cwd=self.path,
                              capture_output=True, text=True, encoding="utf-8", timeout=300)

    def expect_refused(self, arguments, message):
        before = contents(self.path)
        done = self.analyse(*arguments)
        check(done.returncode == 2, f"{arguments}: exit code {done.returncode}: {done.stderr}")
        check(done.stdout == "", f"{arguments}: prints {done.stdout}")
        check(done.stderr.startswith(f"palpate: {message}"), f"{arguments}: {done.stderr}")
        check(done.stderr.count("\n") == 1, f"{arguments}: more than a line: {done.stderr}")
        check(contents(self.path) == before, f"{arguments}: a file has changed")
        check(not (self.path / "analysis").exists(), f"{arguments}: the folder analysis is there")


def check_report(folder):
    """The same rows give the same files, also under another name in another folder."""
    rows = sample_trials(SampleTrials(participants=3, blocks=2))
    folder.write("trials.csv", rows)
    done = folder.analyse("trials.csv")
    check(done.returncode == 0, f"exit code {done.returncode}: {done.stderr}")
    check(done.stderr == "", f"warns: {done.stderr}")
    found = contents(folder.path / "analysis")
    check(sorted(found) == FILES, f"files: {sorted(found)}")
    check(done.stdout.startswith("144 trials of 3 people; missing: none\n"), done.stdout)
    check(done.stdout.endswith("\nreport.html, analysis.json and 11 tables are in analysis/\n"),
          done.stdout)
    document = json.loads(found["analysis.json"])
    check(document["file"] == "trials.csv" and document["limit_s"] == 120, f"{document['file']}")
    again = folder.analyse("trials.csv", "--out", "again")
    check(contents(folder.path / "again") == found, "a second report is another one")
    check(again.stdout == done.stdout.replace("analysis/", "again/"), again.stdout)
    folder.write("-t.csv", rows)
    done = folder.analyse("--limit", "90", "--out", "dash", "--", "-t.csv")
    check(done.returncode == 0, f"a name with a dash: {done.stderr}")
    document = json.loads((folder.path / "dash/analysis.json").read_text())
    check(document["file"] == "-t.csv" and document["limit_s"] == 90, f"{document['file']}")
    done = folder.analyse("trials.csv", "--out=-x")
    check(done.returncode == 0, f"a folder with a dash: {done.stderr}")
    (folder.path / os.fsdecode(b"n\xff.csv")).write_text(trials_csv(rows))
    done = folder.analyse(b"n\xff.csv", "--out", "bytes")
    check(done.returncode == 0, f"a name that is not UTF-8: {done.stderr}")
    document = json.loads((folder.path / "bytes/analysis.json").read_text())
    check(document["file"] == "n?.csv", f"{document['file']}")


def check_refusals(folder):
    rows = sample_trials(SampleTrials(participants=2, blocks=1))
    good = trials_csv(rows)
    folder.write("good.csv", good)
    rows[30]["status"] = "timeout"
    folder.write("timeout.csv", rows)
    folder.write("doubled.csv", good + good.splitlines()[-1] + "\n")
    folder.write("empty.csv", "")
    folder.write("taken", "a file")
    for arguments, message in (
            (["absent.csv"], "absent.csv: "),
            (["empty.csv"], "empty.csv: is empty"),
            (["doubled.csv"], "doubled.csv: line 98: has the trial of line 97 again"),
            (["."], ".: is a folder; expected a file (name the file of trials in it, such as "
                    "./trials.csv)"),
            (["timeout.csv", "--limit", "20"], "timeout.csv: participant 1, block 1, "),
            (["good.csv", "--limit", "0"], '--limit: is "0"'),
            (["good.csv", "--out", "taken"], "taken: ")):
        folder.expect_refused(arguments, message)


def check_many_and_huge(folder):
    """An analysis of many people ends, and has the parts of the variance. Squares that overflow are named."""
    folder.write("many.csv", sample_trials(SampleTrials(participants=41, blocks=2, objects=("O1",))))
    done = folder.analyse("many.csv")
    check(done.returncode == 0, f"exit code {done.returncode}: {done.stderr}")
    parts = (folder.path / "analysis/variances.csv").read_text().splitlines()
    check(len(parts) == 4 and ",41," in parts[1] and ",,," not in parts[1], f"variances.csv: {parts}")
    rows = sample_trials(SampleTrials(participants=3, blocks=1))
    for number, row in enumerate(rows):
        row["total_time_s"] = 1e290 * (1 + number % 7)
    folder.write("huge.csv", rows)
    done = folder.analyse("huge.csv", "--out", "huge", "--limit", "1e300")
    check(done.returncode == 2 and "squares are beyond the largest number" in done.stderr,
          f"huge: {done.returncode}: {done.stderr}")
    check(not (folder.path / "huge").exists(), "huge: the folder is there")


def check_refused_rows_change_no_file(folder):
    folder.write("good.csv", sample_trials(SampleTrials(participants=2, blocks=1)))
    check(folder.analyse("good.csv", "--out", "out").returncode == 0, "not analysed")
    check(len(contents(folder.path / "out")) == len(FILES), "not all files")
    folder.write("one.csv", [row for row in sample_trials() if row["participant"] == "4"])
    no_losses = sample_trials()
    for row in no_losses:
        del row["losses_of_contact"]
    folder.write("no_losses.csv", no_losses)
    late = sample_trials()
    late[40]["status"] = "timeout"
    late[41]["total_time_s"] = 130.0
    folder.write("late.csv", late)
    for name, message in (
            ("one.csv", "participant: has 1 level beside practice"),
            ("no_losses.csv", "losses_of_contact: is in no completed trial"),
            ("late.csv", "participant 1, block 1, H, NoR, O2, total_time_s: is 130 in a completed "
                         "trial; expected at most the time limit, 120 s, because the file has "
                         "timeouts (give the time limit of the trials with --limit)")):
        for out in ("out", "new"):
            folder.expect_refused([name, "--out", out], f"{name}: {message}")
            check(not (folder.path / "new").exists(), f"{name}: the folder new is there")


def main():
    palpate = str(pathlib.Path(sys.argv[1]).resolve())
    for part in (check_report, check_refusals, check_many_and_huge,
                 check_refused_rows_change_no_file):
        with contextlib.ExitStack() as stack:
            path = stack.enter_context(tempfile.TemporaryDirectory())
            part(Folder(palpate, path))
    print("experiment analyse writes its files together, or refuses in a line and writes none")


if __name__ == "__main__":
    main()
