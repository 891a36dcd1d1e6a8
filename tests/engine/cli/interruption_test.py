#!/usr/bin/env python3
"""Ctrl-C at any instant leaves complete results or none.

interruption_test.py PALPATE MODELS_DIR

Sends SIGINT, SIGTERM or SIGHUP to the whole process group, as a terminal does, at random instants of
`run` in real and virtual time, of `replay` and of `accuracy`. The output folder contains files of an
older run. Checks the exit code, that every CSV line is complete, that files of two runs are not mixed,
that other files in the folder are unchanged, and that JSON and traces agree. PALPATE_SEED, which a
failed check prints, determines the instants.
"""

import itertools
import json
import os
import pathlib
import random
import signal
import subprocess
import sys
import tempfile
import time

SEED = int(os.environ.get("PALPATE_SEED", "20"))

# Interruptions of each kind of run by a signal before its end; more with PALPATE_SOAK.
INTERRUPTIONS = 40 if os.environ.get("PALPATE_SOAK") else 10

DONE = (0, 3)  # exit codes; 3: not comparable

OLD = "of an older run\n"
RUN_FILES = ["trace-on.csv", "trace-off.csv", "contour-on.csv", "contour-off.csv", "places-on.csv",
             "places-off.csv", "paths.svg"]
BYSTANDERS = ["notes.txt", "trace-on.csv.bak", ".palpate-notes", "scene.csv"]


class Failure(Exception):
    pass


def check(condition, message):
    if not condition:
        raise Failure(message)


SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def signals_of(process, kind):
    """The mask of the signals that the program catches (SigCgt) or ignores (SigIgn)."""
    status = pathlib.Path(f"/proc/{process.pid}/status").read_text()
    line = next(line for line in status.splitlines() if line.startswith(kind))
    return int(line.split()[1], 16)


def takes_signals(process):
    """Whether the program handles signals already; before, the system ends it."""
    caught = signals_of(process, "SigCgt:")
    return all(caught >> (number - 1) & 1 for number in SIGNALS)


def interrupted(command, folder, delays_s, number):
    """Exit code, stdout and stderr, and whether the process was alive at the last signal."""
    process = subprocess.Popen([str(part) for part in command], cwd=folder, text=True,
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                               start_new_session=True)
    while process.poll() is None and not takes_signals(process):
        time.sleep(0.0005)
    lived = True
    for delay_s in delays_s:
        time.sleep(delay_s)
        lived = process.poll() is None
        if lived:
            os.killpg(process.pid, number)
    out, err = process.communicate(timeout=120)
    return process.returncode, out, err, lived


def check_table(path, is_old_allowed):
    text = path.read_text()
    if text == OLD:
        check(is_old_allowed, f"{path.name} is of an older run")
        return 0
    check(text.endswith("\n"), f"the last line of {path.name} is incomplete: {text[-80:]!r}")
    header, *rows = text.splitlines()
    fields = header.count(",")
    for number, row in enumerate(rows):
        check(row.count(",") == fields, f"{path.name}, row {number}: {row!r}")
        if path.name.startswith("trace-"):
            check(row.split(",")[0] == str(number), f"{path.name}, row {number}: {row!r}")
    return len(rows)


def check_picture(path, is_old_allowed):
    text = path.read_text()
    if text == OLD:
        check(is_old_allowed, f"{path.name} is of an older run")
        return
    check("<svg" in text and text.rstrip().endswith("</svg>"), f"{path.name} is incomplete")


def check_results(out, stdout, is_old_allowed):
    """Checks the files in the folder and their agreement with the JSON on stdout."""
    for name in BYSTANDERS:
        check((out / name).read_text() == OLD, f"{name} has changed")
    left = {path.name for path in out.iterdir()} - set(BYSTANDERS)
    hidden = {name for name in left if name.startswith(".palpate-unfinished-")}
    check(left - hidden <= set(RUN_FILES), f"unknown files: {left}")
    rows = {}
    for name in left - hidden:
        if name.endswith(".svg"):
            check_picture(out / name, is_old_allowed)
        else:
            rows[name] = check_table(out / name, is_old_allowed)
    if not stdout:
        return hidden
    result = json.loads(stdout)
    for run in result["runs"]:
        name = "trace-on.csv" if run["a4"] else "trace-off.csv"
        check(rows.pop(name) == run["ticks"], f"the number of ticks in {name} differs from the JSON")
    check(not any(name.startswith("trace-") for name in rows), f"unexpected traces: {rows}")
    check(not hidden, f"left behind: {hidden}")
    check("paths.svg" in left, "no picture")
    return hidden


def prepare(out):
    out.mkdir(exist_ok=True)
    for name in RUN_FILES + BYSTANDERS:
        (out / name).write_text(OLD)


def seconds_of(command, folder):
    begin = time.monotonic()
    done = subprocess.run([str(part) for part in command], cwd=folder, capture_output=True)
    check(done.returncode in DONE, f"{done.returncode}: {done.stderr!r}")
    return time.monotonic() - begin


def check_runs(palpate, models, folder, generator, options):
    """Interrupts runs by one signal each: while loading, running or writing, or after the end."""
    command = [palpate, "run", models / "star.glb", "--json", "--out", "out", *options]
    out = folder / "out"
    prepare(out)
    whole_s = seconds_of(command, folder)
    seen = {"nothing written": 0, "cut": 0, "whole": 0, "too late": 0}
    signals = itertools.cycle(SIGNALS)
    while sum(seen.values()) - seen["too late"] < INTERRUPTIONS or seen["cut"] == 0:
        check(sum(seen.values()) < 10 * INTERRUPTIONS, f"too few runs were cut: {seen}")
        prepare(out)
        number = next(signals)
        code, stdout, stderr, lived = interrupted(command, folder,
                                                  [generator.uniform(0.0, whole_s)], number)
        if code in DONE:  # the process was about to exit or had exited
            seen["too late"] += 1
            whole_s *= 0.95  # the machine is less busy than before
            check_results(out, stdout, is_old_allowed=False)
            continue
        check(lived, f"exit code {code} without a signal: {stderr}")
        check(code == 128 + number, f"exit code {code} after signal {number}: {stderr}")
        check("interrupted" in stderr or json.loads(stdout)["interrupted"] is False, stderr)
        hidden = check_results(out, stdout, is_old_allowed=not stdout)
        check(not hidden, f"left behind: {hidden}")
        if not stdout:
            seen["nothing written"] += 1
            check(all((out / name).read_text() == OLD for name in RUN_FILES), "old files changed")
            continue
        was_cut = any(run["interrupted"] for run in json.loads(stdout)["runs"])
        seen["cut" if was_cut else "whole"] += 1
    print(" ".join(options), seen)


def check_second_signals(palpate, models, folder, generator):
    """A second signal ends the program at once; the next run removes its leftovers."""
    command = [palpate, "run", models / "star.glb", "--json", "--out", "out", "--virtual",
               "--seconds", "30"]
    out = folder / "out"
    prepare(out)
    whole_s = seconds_of(command, folder)
    for _ in range(INTERRUPTIONS):
        prepare(out)
        delays_s = [generator.uniform(0.0, whole_s), generator.uniform(0.0, 0.02)]
        code, stdout, stderr, _ = interrupted(command, folder, delays_s, signal.SIGINT)
        check(code in (*DONE, 130), f"exit code {code}: {stderr}")
        is_cut = bool(stdout) and not stdout.endswith("}\n")
        check_results(out, "" if is_cut else stdout, is_old_allowed=not stdout)
        fates = {(out / name).read_text() == OLD for name in RUN_FILES if (out / name).exists()}
        check(len(fates) == 1, "files of two runs beside each other")
    seconds_of(command, folder)
    check(not list(out.glob(".palpate-unfinished-*")), "a hidden folder outlives the next run")


def check_killed(palpate, models, folder, generator):
    """SIGKILL leaves the older or the new files; the next run removes its leftovers."""
    command = [palpate, "run", models / "star.glb", "--virtual", "--out", "deep/out", "--seconds",
               "30"]
    whole_s = seconds_of(command, folder)
    out = folder / "deep" / "out"
    for _ in range(10):
        prepare(out)
        interrupted(command, folder, [generator.uniform(0.0, whole_s)], signal.SIGKILL)
        left = [out / name for name in RUN_FILES if (out / name).exists()]
        check(len({path.read_text() == OLD for path in left}) <= 1, "files of two runs")
        for path in left:
            if path.suffix == ".csv":
                check_table(path, is_old_allowed=True)
    seconds_of(command, folder)
    check(not list(out.glob(".palpate-unfinished-*")), "a hidden folder outlives the next run")


def check_search(palpate, models, folder):
    """A run that has ended is judged even if a signal ends the search for better options."""
    command = [palpate, "run", models / "gallery.glb", "--virtual", "--seconds", "3", "--out", "cut"]
    picture = folder / "cut" / "paths.svg"
    for _ in range(INTERRUPTIONS):
        picture.unlink(missing_ok=True)
        process = subprocess.Popen([str(part) for part in command], cwd=folder, text=True,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                   start_new_session=True)
        while process.poll() is None and not picture.exists():
            time.sleep(0.0005)
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGINT)
        out, err = process.communicate(timeout=120)
        if process.returncode == 128 + signal.SIGINT and "results are complete" in err:
            break
    check("the search for better options was interrupted\n" in out, f"{out} {err}")
    check(out.startswith("not comparable\n  without A4: the proxy "), out)
    check("\ninterrupted after the runs had ended; the results are complete\n" in out, out)


def check_nohup(palpate, models, folder):
    """A run started with SIGHUP ignored outlives its terminal and still obeys Ctrl-C."""
    command = [str(palpate), "run", str(models / "star.glb"), "--out", "nohup", "--seconds", "60"]
    process = subprocess.Popen(command, cwd=folder, text=True, stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE, start_new_session=True,
                               preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))
    while not signals_of(process, "SigCgt:") >> (signal.SIGINT - 1) & 1:
        time.sleep(0.0005)
    os.killpg(process.pid, signal.SIGHUP)
    time.sleep(2.0)
    check(process.poll() is None, "SIGHUP ends a run that was started with SIGHUP ignored")
    os.killpg(process.pid, signal.SIGINT)
    out, err = process.communicate(timeout=120)
    check(process.returncode == 128 + signal.SIGINT, f"exit code {process.returncode}: {err}")
    check("interrupted" in out, out)


def check_replays(palpate, models, folder, generator):
    """The folder contains the older or the new trace and no other file."""
    ticks = 60000
    (folder / "path.txt").write_text("".join(
        f"{0.12 - 0.1 * (n % 1000) / 1000:.6f} {1e-6 * n:.6f} 0\n" for n in range(ticks)))
    place = folder / "replayed"
    place.mkdir()
    command = [palpate, "replay", models / "star.glb", "--trajectory", "path.txt", "--json", "--out",
               "replayed/trace.csv"]
    whole_s = seconds_of(command, folder)
    for _ in range(INTERRUPTIONS):
        (place / "trace.csv").write_text(OLD)
        code, _, stderr, _ = interrupted(command, folder, [generator.uniform(0.0, whole_s)],
                                         signal.SIGINT)
        check(code in (0, 130), f"exit code {code}: {stderr}")
        check([path.name for path in place.iterdir()] == ["trace.csv"], "something is left behind")
        check(check_table(place / "trace.csv", is_old_allowed=code != 0) in (0, ticks), "rows")
    for _ in range(5):
        interrupted(command, folder, [generator.uniform(0.0, whole_s)], signal.SIGKILL)
    seconds_of(command, folder)
    check([path.name for path in place.iterdir()] == ["trace.csv"], "a killed replay leaves files")


def check_studies(palpate, folder, generator):
    command = [palpate, "accuracy", "--quick", "--knob", "a4_step", "--out", "study/new"]
    whole_s = seconds_of(command, folder)
    study = folder / "study" / "new"
    check({path.name for path in study.iterdir()} ==
          {"raw.csv", "accuracy.json", "report.html", "stiffness_zones.csv", "stiffness.svg",
           "a4_step.svg"},
          f"{list(study.iterdir())}")
    before = {path.name: path.read_text() for path in study.iterdir()}
    for _ in range(6):
        code, _, stderr, _ = interrupted(command, folder, [generator.uniform(0.0, whole_s)],
                                         signal.SIGINT)
        check(code in (0, 130), f"exit code {code}: {stderr}")
        now = {path.name: path.read_text() for path in study.iterdir()}
        check(now.keys() == before.keys(), f"{now.keys()}")
        check(code == 0 or now == before or all(now[name] != before[name]
                                                for name in ("raw.csv", "report.html")),
              "files of two studies")
        before = now


def main():
    palpate, models = (pathlib.Path(path).resolve() for path in sys.argv[1:3])
    for number in SIGNALS:  # the caller may ignore them
        signal.signal(number, signal.SIG_DFL)
    generator = random.Random(SEED)
    try:
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            check_runs(palpate, models, folder, generator, ["--virtual", "--seconds", "30"])
            check_runs(palpate, models, folder, generator,
                       ["--virtual", "--seconds", "20", "--sensors", "3", "--actuators", "2"])
            check_runs(palpate, models, folder, generator, ["--seconds", "2"])
            check_second_signals(palpate, models, folder, generator)
            check_killed(palpate, models, folder, generator)
            check_search(palpate, models, folder)
            check_nohup(palpate, models, folder)
            check_replays(palpate, models, folder, generator)
            check_studies(palpate, folder, generator)
    except Failure as failure:
        sys.exit(f"PALPATE_SEED={SEED}: {failure}")


main()
