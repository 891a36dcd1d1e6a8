#!/usr/bin/env python3
"""The tasks of engine/trials/deal/slurm_array.sh, run one after another without Slurm.

slurm_array_test.py PALPATE PROJECT_DIR

Their results, merged, have the bytes of one run without shards, for an experiment and for a sweep; the
names of files and folders have blanks. A task that runs again changes nothing. A task that cannot run
ends with code 2 and one line. The script passes shellcheck, if that is installed.
"""

import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

TASKS = 3
RESULTS = {"run": ["trials.csv", "columns.csv", "run.json"],
           "sweep": ["sweep.csv", "columns.csv", "report.html", "sweep_results.json",
                     "one_at_a_time.csv", "flips.csv", "rankings.csv", "halves.csv", "run.json"]}


def check(condition, message):
    if not condition:
        sys.exit(message)


def plan_of(models):
    """A trial of this plan takes a fraction of a second."""
    return {"palpate_plan": 1, "name": "small", "seed": 7, "participants": 4, "blocks": 1,
            "practice_blocks": 0,
            "device": {"sensors": 2, "actuators": 1, "rate_Hz": 1000, "stiffness_N_per_m": 1000,
                       "damping_Ns_per_m": 2},
            "display_Hz": 40, "sphere_radius_m": 0.006, "limit_s": 60,
            "haptic": ["NoH", "UaH", "H"], "rotation": ["NoR", "R"],
            "objects": {"O1": {"file": str(models / "star.glb"), "scale": 0.3}},
            "operator": "literature", "followings": ["delayed"]}


def sweep_of(models):
    return {"palpate_sweep": 1, "name": "small", "plan": {**plan_of(models), "participants": 1},
            "parameters": {"sight_delay_s": [0.1, 0.2], "align": ["nearest", "forward"]},
            "hypercube": {"points": 3, "seed": 23, "participants": 1}}


class Script:
    def __init__(self, project, palpate, folder):
        self.path = project / "engine" / "trials" / "deal" / "slurm_array.sh"
        self.palpate, self.folder = palpate, folder

    def run(self, task, count, arguments, **more):
        environment = {key: value for key, value in os.environ.items()
                       if not key.startswith("SLURM_")}
        environment.update({"PALPATE": str(self.palpate), **more})
        for name, value in (("SLURM_ARRAY_TASK_ID", task), ("SLURM_ARRAY_TASK_COUNT", count)):
            if value is not None:
                environment[name] = str(value)
        return subprocess.run([str(self.path), *arguments], cwd=self.folder, env=environment,
                              capture_output=True, text=True, timeout=120)


def palpate_run(palpate, folder, *arguments):
    done = subprocess.run([str(palpate), "experiment", *arguments], cwd=folder, capture_output=True,
                          text=True, timeout=120)
    check(done.returncode == 0, f"{arguments}: code {done.returncode}\n{done.stderr}")


def check_tasks(script, command, file):
    """Tasks, merged, give the bytes of one run."""
    folder, palpate = script.folder, script.palpate
    palpate_run(palpate, folder, command, file, "--out", f"whole {command}")
    tasks = f"tasks of {command}"
    for task in (*range(1, TASKS + 1), 1):
        done = script.run(task, TASKS, [command, file, tasks, "--jobs", "2"])
        check(done.returncode == 0, f"task {task} of {command}: {done.stderr}")
        check(("kept" in done.stdout) == (task == 1 and (folder / tasks / "shard-3").exists()),
              f"task {task}: {done.stdout}")
    shards = sorted(str(path.relative_to(folder)) for path in (folder / tasks).glob("shard-*"))
    check(len(shards) == TASKS, f"folders: {shards}")
    palpate_run(palpate, folder, "merge", *shards, "--out", "merged")
    for name in RESULTS[command]:
        whole = (folder / f"whole {command}" / name).read_bytes()
        check(whole == (folder / "merged" / name).read_bytes(), f"{command}: {name} differs")
    print(f"{command}: {TASKS} tasks give the same bytes as one run")


def check_accepted(script):
    """A program on PATH is called with what ships, and with the shard of the task."""
    programs = script.folder / "programs"
    programs.mkdir()
    program = programs / "echo_arguments"
    program.write_text('#!/bin/sh\necho "$@"\n')
    program.chmod(0o755)
    for command, file in (("run", "paper"), ("run", "canonical"), ("sweep", "sweep")):
        done = script.run(2, 3, [command, file, "out"], PALPATE="echo_arguments",
                          SLURM_ARRAY_TASK_MIN="1", SLURM_ARRAY_TASK_MAX="3",
                          PATH=f"{programs}:{os.environ['PATH']}")
        expected = f"experiment {command} {file} --shard 2/3 --out out/shard-2\n"
        check(done.stdout == expected, f"{done.stdout}{done.stderr}")


def check_refusals(script):
    folder = script.folder
    good = ["run", "my plan.json", "out"]
    cases = [
        ((1, 2, []), "too few arguments"),
        ((1, 2, ["run", "my plan.json"]), "too few arguments"),
        ((1, 2, ["analyse", "my plan.json", "out"]), 'asked for "analyse"; expected run or sweep'),
        ((1, 2, ["run", "no plan.json", "out"]), 'no file "no plan.json"'),
        ((None, 2, good), 'SLURM_ARRAY_TASK_ID ""'),
        ((1, None, good), 'SLURM_ARRAY_TASK_COUNT ""'),
        ((0, 2, good), 'SLURM_ARRAY_TASK_ID "0"; expected a number from 1'),
        (("1 2", 2, good), 'SLURM_ARRAY_TASK_ID "1 2"'),
        (("one", 2, good), 'SLURM_ARRAY_TASK_ID "one"'),
        ((3, 2, good), "is task 3 of 2"),
    ]
    for (task, count, arguments), text in cases:
        done = script.run(task, count, arguments)
        check(done.returncode == 2 and text in done.stderr and done.stderr.count("\n") == 1,
              f"{task} of {count}, {arguments}: code {done.returncode}\n{done.stderr}")
    more = [
        ((1, 2, ["run", "sweep", "out"]), {}, 'asked to run "sweep", which is a sweep'),
        ((1, 2, ["sweep", "paper", "out"]), {}, 'asked to sweep "paper", which is a plan'),
        ((1, 2, ["sweep", "canonical", "out"]), {}, 'asked to sweep "canonical"'),
        ((1, 2, ["run", "my plan.json", ""]), {}, 'has the folder ""'),
        ((1, 2, ["run", "my plan.json", "-out"]), {}, 'has the folder "-out"'),
        (("9" * 30, 2, good), {}, 'SLURM_ARRAY_TASK_ID "999'),
        ((2, 2, good), {"SLURM_ARRAY_TASK_MIN": "2"}, "is of an array from 2; expected --array=1-2"),
        ((1, 2, good), {"SLURM_ARRAY_TASK_MIN": "1", "SLURM_ARRAY_TASK_MAX": "3"},
         "is of an array of 2 tasks to 3; expected --array=1-2"),
    ]
    for (task, count, arguments), variables, text in more:
        done = script.run(task, count, arguments, **variables)
        check(done.returncode == 2 and text in done.stderr and done.stderr.count("\n") == 1,
              f"{task} of {count}, {arguments}: code {done.returncode}\n{done.stderr}")
    check_accepted(script)
    done = script.run(1, 2, good, PALPATE=str(folder / "no palpate"))
    check(done.returncode == 2 and "finds no program" in done.stderr, done.stderr)
    # An error of the program is that of the task.
    (folder / "broken.json").write_text("{}")
    done = script.run(1, 2, ["run", "broken.json", "out"])
    check(done.returncode == 2 and "broken.json" in done.stderr, done.stderr)
    check(not (folder / "out").exists(), "a refused task has written a folder")
    print(f"{len(cases) + len(more) + 2} tasks are refused")


def main():
    palpate, project = (pathlib.Path(path).resolve() for path in sys.argv[1:3])
    shellcheck = shutil.which("shellcheck")
    if shellcheck:
        script = project / "engine" / "trials" / "deal" / "slurm_array.sh"
        done = subprocess.run([shellcheck, str(script)], capture_output=True, text=True)
        check(done.returncode == 0, done.stdout)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name) / "a folder"
        folder.mkdir()
        script = Script(project, palpate, folder)
        (folder / "my plan.json").write_text(json.dumps(plan_of(project / "models")))
        (folder / "my sweep.json").write_text(json.dumps(sweep_of(project / "models")))
        check_refusals(script)
        check_tasks(script, "run", "my plan.json")
        check_tasks(script, "sweep", "my sweep.json")


main()
