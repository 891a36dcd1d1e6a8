#!/usr/bin/env python3
"""Runs `palpate run` on foreign glTF files and verifies its figures by traces and contours.

usage: run_corpus_test.py PROGRAM DEFAULT_FOLDER [COUNT [SKIP]]

PALPATE_CORPUS or the default names the folder; without it the test is skipped (exit code 77). Its
INDEX.tsv names the kind of each file. The files of kind "real" that `palpate info` accepts are
ordered by the MD5 of their paths; the test skips the first SKIP and uses the next COUNT. Each file is
run with --virtual --fit auto. If the run is refused or not comparable, the test follows the command
line or the option that the program prints, at most twice.

For every run the test computes the share of ticks in contact, the share of the path that the proxy
came near, and the longest stretch without contact, from the trace and the contour or the places. It
compares them with the JSON, with "comparable" and with the exit code.
"""

import csv
import hashlib
import json
import math
import operator
import os
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile

SKIPPED = 77
ROUNDS = 2
LEAST_WAY = 0.9
LONGEST_GAP = 0.1
LEAST_CONTACT_OF_MEANS = 0.05
LEAST_CLOSED_SHARE = 0.8  # of closed models over CLOSED_TRIANGLES that must end comparable
CLOSED_TRIANGLES = 1000
STEPS_PER_NEAR = 8  # along the contour, at least
LEAST_STEPS = 2000  # along the whole contour: one step is far below the tolerance of a share


def take_models(program, folder, count, skip):
    rows = [line.split("\t") for line in (folder / "INDEX.tsv").read_text().splitlines()]
    real = [row[0] for row in rows if len(row) > 1 and row[1] == "real"]
    models = []
    for path in sorted(real, key=lambda p: hashlib.md5(p.encode()).hexdigest()):
        answer = subprocess.run([program, "info", "--json", folder / path], capture_output=True)
        if answer.returncode == 0:
            models.append((folder / path, json.loads(answer.stdout)))
        if len(models) == skip + count:
            break
    return models[skip:]


class Near:
    """Finds whether any of the points is within a distance of a place."""

    def __init__(self, points, distance):
        self.distance = distance
        self.cells = {}
        seen = set()
        fine = distance / 64
        for p in points:
            key = tuple(math.floor(x / fine) for x in p)
            if key in seen:
                continue
            seen.add(key)
            self.cells.setdefault(tuple(math.floor(x / distance) for x in p), []).append(p)

    def __call__(self, place):
        c = [math.floor(x / self.distance) for x in place]
        for i in (-1, 0, 1):
            for j in (-1, 0, 1):
                for k in (-1, 0, 1):
                    for p in self.cells.get((c[0] + i, c[1] + j, c[2] + k), ()):
                        if math.dist(p, place) <= self.distance:
                            return True
        return False


def read_columns(path, *names):
    """The rows of a table, with these columns only. csv.DictReader would take most of the test's time."""
    with open(path, newline="") as file:
        rows = csv.reader(file)
        header = next(rows)
        columns = operator.itemgetter(*map(header.index, names))
        return [columns(row) for row in rows]


def read_points(path):
    return [tuple(map(float, row)) for row in read_columns(path, "x", "y", "z")]


def way_share(points, near, is_contour, near_m):
    if not is_contour:
        return sum(near(p) for p in points) / len(points) if points else 0.0
    length = covered = 0.0
    whole = sum(math.dist(a, b) for a, b in zip(points, points[1:]))
    longest_step = min(near_m / STEPS_PER_NEAR, whole / LEAST_STEPS)
    if longest_step == 0.0:
        return 0.0
    for a, b in zip(points, points[1:]):
        leg = math.dist(a, b)
        steps = max(1, math.ceil(leg / longest_step))
        for s in range(steps):
            t = (s + 0.5) / steps
            place = tuple(x + t * (y - x) for x, y in zip(a, b))
            length += leg / steps
            covered += leg / steps * near(place)
    return covered / length if length > 0 else 0.0


def judge(folder, run, near_m):
    """Contact share, way share and longest gap of a run, from its files."""
    name = "on" if run["a4"] else "off"
    rows = read_columns(folder / f"trace-{name}.csv", "contact", "proxy_x", "proxy_y", "proxy_z")
    contact = [row[0] == "1" for row in rows]
    proxies = [tuple(map(float, row[1:])) for row in rows]
    contour = folder / f"contour-{name}.csv"
    is_contour = contour.exists()
    points = read_points(contour if is_contour else folder / f"places-{name}.csv")
    gap = longest = 0
    touched = False
    for c in contact:
        touched = touched or c
        gap = 0 if c else gap + 1
        longest = max(longest, gap if touched else 0)
    share = way_share(points, Near(proxies, near_m), is_contour, near_m)
    return sum(contact) / len(contact), share, longest, len(contact)


def check_run(folder, run, extent_m):
    """Errors in the figures of a run, and whether its files make it comparable."""
    wrong = []
    near_m = max(2e-3, 0.01 * extent_m)
    if abs(run["near_m"] - near_m) > 1e-6 * near_m:
        wrong.append(f"near_m is {run['near_m']}, expected {near_m}")
    contact, way, gap, ticks = judge(folder, run, near_m)
    if ticks != run["ticks"]:
        wrong.append(f"ticks {run['ticks']}, the trace has {ticks}")
    if abs(contact - run["contact_share"]) > 1e-9:
        wrong.append(f"contact share {run['contact_share']}, the trace has {contact}")
    if abs(way - run["way_share"]) > 0.01:
        wrong.append(f"way {run['way_share']}, by trace and contour {way}")
    if gap != run["longest_gap_ticks"]:
        wrong.append(f"longest gap {run['longest_gap_ticks']}, the trace has {gap}")
    if (run["mean_contact_angle_deg"] is None) != (contact < LEAST_CONTACT_OF_MEANS):
        wrong.append("a mean is printed without enough contact, or missing with it")
    comparable = contact >= LEAST_CONTACT_OF_MEANS and run["way_share"] >= LEAST_WAY and gap <= LONGEST_GAP * ticks
    if comparable != run["comparable"]:
        wrong.append(f"comparable is {run['comparable']}, expected {comparable}")
    if bool(run["reasons"]) == comparable:
        wrong.append("reasons contradict comparable")
    return wrong, comparable


def largest_extent(program, arguments):
    """The largest extent of the scene that the arguments of `run` load."""
    kept = [arguments[0]]
    for option in ("--node", "--scale"):
        if option in arguments:
            kept += [option, arguments[arguments.index(option) + 1]]
    answer = subprocess.run([program, "info", "--json", *kept], capture_output=True, check=True)
    return max(json.loads(answer.stdout)["extent_m"])


def with_option(arguments, option, value):
    """The arguments with the option set to the value."""
    if option in arguments:
        at = arguments.index(option)
        arguments = arguments[:at] + arguments[at + 2:]
    return [*arguments, option, value]


def one_round(program, arguments, folder):
    """Exit code, errors, and the proposed arguments (None: no proposal)."""
    for old in folder.iterdir():
        old.unlink()
    command = [program, "run", *arguments, "--virtual", "--json", "--out", str(folder)]
    answer = subprocess.run(command, capture_output=True, text=True, errors="replace")
    if answer.returncode == 2:
        lines = [line for line in answer.stderr.splitlines() if line.startswith("palpate: ")]
        wrong = [] if len(lines) == 1 else [f"expected one line of error: {answer.stderr!r}"]
        option = re.search(r"(--[a-z-]+) (\"[^\"]+\"|[^\s,;)]+)", lines[0] if lines else "")
        if not option:
            return 2, wrong, None
        return 2, wrong, with_option(arguments, option[1], option[2].strip('"'))
    if answer.returncode not in (0, 3):
        return answer.returncode, [f"exit code {answer.returncode}: {answer.stderr[-300:]!r}"], None
    result = json.loads(answer.stdout)
    extent = largest_extent(program, arguments) * result["scale"]
    if "--scale" in arguments:
        extent /= result["scale"]
    wrong = []
    comparable = True
    for run in result["runs"]:
        faults, is_comparable = check_run(folder, run, extent)
        wrong += faults
        comparable = comparable and is_comparable
    if comparable != (answer.returncode == 0) or comparable != result["comparable"]:
        wrong.append(f"exit code {answer.returncode}, comparable {result['comparable']}, "
                     f"expected comparable {comparable}")
    if comparable:
        return 0, wrong, None
    if not result["reasons"]:
        wrong.append("not comparable without a reason")
    if not result["try"]:
        return 3, wrong, None
    words = shlex.split(result["try"])[2:]  # behind `palpate run`
    keep = []
    i = 0
    while i < len(words):
        if words[i] == "--out":
            i += 2
            continue
        if words[i] not in ("--virtual", "--json"):
            keep.append(words[i])
        i += 1
    return 3, wrong, keep


def main():
    program, default_folder = sys.argv[1:3]
    count, skip = (int(x) for x in (sys.argv[3:] + ["120", "0"][len(sys.argv) - 3:])[:2])
    corpus = pathlib.Path(os.environ.get("PALPATE_CORPUS", default_folder))
    if not (corpus / "INDEX.tsv").exists():
        print(f"skipped: no models in {corpus}")
        return SKIPPED
    failures = closed = closed_comparable = comparable = 0
    models = take_models(program, corpus, count, skip)
    with tempfile.TemporaryDirectory() as out:
        for path, info in models:
            arguments = [str(path), "--fit", "auto"]
            codes = []
            for _ in range(ROUNDS + 1):
                code, wrong, arguments = one_round(program, arguments, pathlib.Path(out))
                codes.append(code)
                for text in wrong:
                    failures += 1
                    print(f"WRONG {path.relative_to(corpus)}: {text}")
                if arguments is None:
                    break
            print(f"{codes} {info['triangles']} {'open' if info['boundary_edges'] else 'closed'} "
                  f"{path.relative_to(corpus)}", flush=True)
            comparable += codes[-1] == 0
            if info["boundary_edges"] == 0 and info["triangles"] > CLOSED_TRIANGLES:
                closed += 1
                closed_comparable += codes[-1] == 0
    print(f"{comparable} of {len(models)} models end comparable; of those that are closed and have "
          f"more than {CLOSED_TRIANGLES} triangles {closed_comparable} of {closed}; "
          f"{failures} wrong")
    return 1 if failures or closed_comparable < LEAST_CLOSED_SHARE * closed else 0


if __name__ == "__main__":
    sys.exit(main())
