#!/usr/bin/env python3
"""Commands whose pages Python makes: without Python, from a hostile folder, and killed meanwhile.

python_pages_test.py PALPATE MODELS_DIR

Without an interpreter, the measured files are there and the answer is in the terminal; only a command of
which the page was all that was asked for fails. A module of the working folder is never run. A command
that is interrupted or killed while the process makes a page leaves the former results and no process.
"""

import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

OLD = "of an older run\n"
BAD_INPUT = 2
PATIENCE_S = 120


class Failure(Exception):
    pass


def check(condition, message):
    if not condition:
        raise Failure(message)


class Commands:
    """The commands, each with small inputs, the files that it measures, and its page."""

    def __init__(self, program, models, folder):
        self.program, self.folder = program, folder
        self.star = models / "star.glb"
        self.write_plans()
        self.run("experiment", "run", "plan.json", "--out", "trials")
        trials = folder / "trials/trials.csv"
        self.page_only = {
            "analyse": ["experiment", "analyse", trials],
            "power": ["experiment", "power", "--sets", "100", "--participants", "4"],
        }
        self.measuring = {  # the command, the measured files, the page
            "accuracy": (["accuracy", "--quick", "--knob", "a4_step"], ["raw.csv"], "report.html"),
            "compare": (["compare", self.star, "--hands", "2", "--strategies", "mask,a4"],
                        ["plan.json", "means.csv"], "report.html"),
            "canonical": (["experiment", "run", "wall.json"], ["canonical.csv", "run.json"],
                          "canonical.html"),
            "sweep": (["experiment", "sweep", "sweep.json"], ["sweep.csv", "run.json"],
                      "report.html"),
        }

    def write_plans(self):
        for name, change in (("plan", self.cut_plan), ("wall", self.cut_wall),
                             ("sweep", self.cut_sweep)):
            kind = {"plan": "paper", "wall": "canonical"}.get(name, name)
            self.run("experiment", "plan", kind, "--out", f"{name}-whole.json")
            plan = json.loads((self.folder / f"{name}-whole.json").read_text())
            change(plan)
            (self.folder / f"{name}.json").write_text(json.dumps(plan))

    def cut_plan(self, plan):
        plan.update(participants=3, blocks=1, practice_blocks=0, followings=["delayed"],
                    objects={"O1": str(self.star)})

    def cut_wall(self, plan):
        plan.update(participants=2, angles_deg=[0, 45, 90])

    def cut_sweep(self, sweep):
        self.cut_plan(sweep["plan"])
        sweep["plan"]["participants"] = 2
        sweep["parameters"] = {"press_depth_m": [0.004, 0.007]}
        sweep["hypercube"].update(points=2)

    def new_folder(self):
        return pathlib.Path(tempfile.mkdtemp(dir=self.folder))

    def run(self, *words, python=None, cwd=None, expected=(0, 3)):
        environment = dict(os.environ)
        if python is not None:
            environment["PALPATE_PYTHON"] = str(python)
        done = subprocess.run([self.program, *map(str, words)], cwd=cwd or self.folder,
                              env=environment, capture_output=True, text=True,
                              stdin=subprocess.DEVNULL, timeout=600, check=False)
        check(done.returncode in expected,
              f"{words} ended with {done.returncode}: {done.stdout[-300:]}{done.stderr[-600:]}")
        return done


def old_results(folder, names):
    folder.mkdir()
    for name in names:
        (folder / name).write_text(OLD)


def check_old(folder, names, what):
    there = sorted(path.name for path in folder.iterdir())
    check(there == sorted(names), f"{what}: the folder has {there}; expected {sorted(names)}")
    for name in names:
        check((folder / name).read_text() == OLD, f"{what}: {name} has changed")


def check_page_alone_is_refused(commands, reason, python=None):
    """reason: what the one line says about the interpreter."""
    for name, words in commands.page_only.items():
        out = commands.new_folder() / name
        old_results(out, ["report.html", "notes.txt"])
        done = commands.run(*words, "--out", out, python=python, expected=(BAD_INPUT,))
        lines = done.stderr.splitlines()
        check(len(lines) == 1 and reason in lines[0] and "(install python3-numpy" in lines[0],
              f"{name}: {done.stderr}")
        check_old(out, ["report.html", "notes.txt"], name)


def check_measured_files_are_there(commands, reason, python=None):
    for name, (words, measured, page) in commands.measuring.items():
        out = commands.new_folder() / name
        done = commands.run(*words, "--out", out, python=python)
        for file in measured:
            check((out / file).stat().st_size > 0, f"{name}: {file} is missing")
        check(not (out / page).exists(), f"{name}: {page} is there without Python")
        lines = [line for line in done.stderr.splitlines() if "the page is missing" in line]
        check(len(lines) == 1 and lines[0].startswith("palpate: warning: ")
              and reason in lines[0], f"{name}: {done.stderr}")
        check(len(done.stdout.splitlines()) > 1, f"{name}: no answer: {done.stdout}")


def test_page_alone_is_refused_without_python(commands):
    check_page_alone_is_refused(commands, "/nowhere/python3 could not be started", "/nowhere/python3")


def test_measured_files_are_there_without_python(commands):
    check_measured_files_are_there(commands, "/nowhere/python3 could not be started", "/nowhere/python3")


def test_folder_that_a_removed_package_left_is_no_package(commands):
    left = commands.folder / "left"
    (left / "numpy").mkdir(parents=True)
    script = commands.folder / "bare"
    script.write_text(f"#!/bin/sh\nPYTHONPATH='{left}' exec '{sys.executable}' -S \"$@\"\n")
    script.chmod(0o700)
    check_page_alone_is_refused(commands, "bare has no package numpy scipy pandas", script)


def test_modules_of_the_working_folder_are_not_run(commands):
    hostile = commands.folder / "hostile"
    hostile.mkdir()
    for name in ("numpy", "json", "palpate", "matplotlib", "sitecustomize"):
        (hostile / f"{name}.py").write_text(f"open({str(hostile / 'seen')!r}, 'w')\nraise SystemExit(0)\n")
    (hostile / "matplotlibrc").write_text("savefig.dpi: 12\nfont.size: 40\naxes.grid: False\n")
    pages = {}
    for folder in (commands.folder, hostile):
        out = commands.folder / f"from-{folder.name}"
        done = commands.run(*commands.page_only["analyse"], "--out", out, cwd=folder)
        check(not (hostile / "seen").exists(), "a module of the working folder was run")
        check(done.stderr == "", f"warnings: {done.stderr}")
        pages[folder] = (out / "report.html").read_bytes()
    check(pages[commands.folder] == pages[hostile], "the page depends on the working folder")


def test_folders_and_scenes_may_begin_with_a_dash(commands):
    (commands.folder / "-star.glb").write_bytes(commands.star.read_bytes())
    jobs = {name: (words, page) for name, (words, _, page) in commands.measuring.items()}
    jobs |= {name: (words, "report.html") for name, words in commands.page_only.items()}
    jobs["compare"] = (["compare", "--hands", "2", "--strategies", "mask,a4"], "report.html")
    for name, (words, page) in jobs.items():
        end = ["--", "-star.glb"] if name == "compare" else []
        done = commands.run(*words, f"--out=-{name}", *end)
        check((commands.folder / f"-{name}" / page).exists(), f"{name}: no {page}: {done.stderr}")


def slow_interpreter(commands):
    """An interpreter that says where it is, and never ends."""
    script = commands.folder / "slow"
    script.write_text(f"#!/bin/sh\necho $$ > {commands.folder}/pid.part\n"
                      f"mv {commands.folder}/pid.part {commands.folder}/pid\nexec sleep 1000\n")
    script.chmod(0o700)
    return script


def is_alive(process):
    try:
        return pathlib.Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):  # it ended before or while the file was read
        return False


def wait_for(condition, what):
    end = time.monotonic() + PATIENCE_S
    while not condition():
        check(time.monotonic() < end, f"waited too long for {what}")
        time.sleep(0.01)


def test_ended_while_the_page_is_made(commands):
    slow = slow_interpreter(commands)
    jobs = {name: (words, ["report.html", "notes.txt"]) for name, words in
            commands.page_only.items()}
    jobs["canonical"] = (commands.measuring["canonical"][0], ["canonical.html", "canonical.csv"])
    jobs["compare"] = (commands.measuring["compare"][0], ["report.html", "comparison.json", "means.csv"])
    for name, (words, old) in jobs.items():
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL):
            what = f"{name}, {number.name}"
            out = commands.folder / f"ended-{name}-{number.name}"
            old_results(out, old)
            pid = commands.folder / "pid"
            pid.unlink(missing_ok=True)
            process = subprocess.Popen(
                [commands.program, *map(str, words), "--out", str(out)], cwd=commands.folder,
                env={**os.environ, "PALPATE_PYTHON": str(slow)}, start_new_session=True,
                stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            wait_for(lambda: pid.exists() or process.poll() is not None, f"{what}: the page")
            if not pid.exists():
                raise Failure(f"{what}: ended before: {process.communicate()}")
            page = int(pid.read_text())
            os.killpg(process.pid, number) if number != signal.SIGKILL else process.kill()
            _, err = process.communicate(timeout=PATIENCE_S)
            killed = number == signal.SIGKILL
            check(process.returncode == (-number if killed else 128 + number),
                  f"{what}: exit code {process.returncode}: {err}")
            check(killed or "interrupted" in err, f"{what}: {err}")
            wait_for(lambda: not is_alive(page), f"{what}: the end of the process")
            for file in old:
                check((out / file).read_text() == OLD, f"{what}: {file} has changed")


def main():
    program, models = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
    tests = [value for name, value in globals().items() if name.startswith("test_")]
    with tempfile.TemporaryDirectory() as folder:
        commands = Commands(program, models, pathlib.Path(folder))
        for test in tests:
            try:
                test(commands)
            except Failure as failure:
                print(f"{test.__name__}: {failure}")
                return 1
            print(f"{test.__name__}: passed")
    return 0


if __name__ == "__main__":
    sys.exit(main())
