#!/usr/bin/env python3
"""No command writes over what it reads, however the output is spelt.

output_over_input_test.py PALPATE MODELS_DIR

Each command gets an output that is one of its inputs: by the same path, by another spelling, through
symbolic links and through a hard link. It must end with exit code 2 and name both files, and every file
must keep its bytes. Outputs that are no inputs must work: new files, older results, dangling links, pipes
and /dev/null.
"""

import json
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile

PLAN = {"palpate_plan": 1, "name": "small", "seed": 1, "participants": 1, "blocks": 1,
        "practice_blocks": 0,
        "device": {"sensors": 2, "actuators": 1, "rate_Hz": 1000, "stiffness_N_per_m": 1000,
                   "damping_Ns_per_m": 2},
        "display_Hz": 40, "sphere_radius_m": 0.006, "limit_s": 1, "haptic": ["H"], "rotation": ["R"],
        "objects": {"O1": "own.glb"}, "operator": "own.json", "followings": ["delayed"]}


def check(condition, message):
    if not condition:
        sys.exit(message)


class Case:
    """A folder with every kind of input."""

    def __init__(self, palpate, models, place):
        self.palpate = palpate
        self.folder = pathlib.Path(tempfile.mkdtemp(dir=place))
        glb = (models / "star.glb").read_bytes()
        self.write("own.glb", glb)
        length, = struct.unpack("<I", glb[12:16])
        gltf = json.loads(glb[20:20 + length])
        gltf["buffers"][0]["uri"] = "own%20data.bin"
        gltf["images"] = [{"uri": "colour.png"}, {"uri": f"file://{self.folder}/absolute.png"},
                          {"uri": "x%y.png"}, {"uri": "tex\\cut%20a.png?v=1#2"}]
        gltf["extensions"] = {"EXT_lights_ies": {"lights": [{"uri": "lamp.ies"}]},
                              "KHR_audio_emitter": {"audio": [{"uri": "tone.mp3"}]}}
        for name in ("absolute.png", "x%y.png", "tex/cut a.png", "lamp.ies", "tone.mp3"):
            self.write(name, b"never read either")
        self.write("own.gltf", json.dumps(gltf).encode())
        self.write("own data.bin", glb[28 + length:])
        self.write("colour.png", b"never read")
        self.write("way.txt", b"0 0 0.1\n0 0 0.099\n")
        self.write("plan.json", json.dumps(PLAN).encode())
        shipped = pathlib.Path(__file__).parents[3] / "engine/trials/literature.json"
        self.write("own.json", shipped.read_bytes())

    def write(self, name, content):
        (self.folder / name).parent.mkdir(exist_ok=True)
        (self.folder / name).write_bytes(content)

    def call(self, *arguments, **options):
        return subprocess.run([str(self.palpate), *arguments], cwd=self.folder, text=True,
                              capture_output="stdout" not in options, timeout=300, **options)

    def contents(self):
        return {str(path.relative_to(self.folder)): path.read_bytes()
                for path in self.folder.rglob("*") if path.is_file()}

    def expect_refused(self, arguments, names, **options):
        before = self.contents()
        done = self.call(*arguments, **options)
        what = f"{' '.join(arguments)}: exit code {done.returncode}: {done.stderr}"
        check(done.returncode == 2, what)
        check(done.stderr.count("\n") == 1 and "input" in done.stderr, what)
        check(all(name in done.stderr for name in names), f"{what} (no {names})")
        after = self.contents()
        check(all(after.get(name) == content for name, content in before.items()),
              f"{' '.join(arguments)}: an input has changed")

    def expect_done(self, *arguments, codes=(0, 3)):
        done = self.call(*arguments)
        check(done.returncode in codes, f"{' '.join(arguments)}: {done.returncode}: {done.stderr}")
        return done


def spellings(case, name):
    """Paths that denote the file."""
    os.makedirs(case.folder / "deep/er")
    os.symlink(name, case.folder / "soft")
    os.symlink("../soft", case.folder / "deep/soft")
    os.symlink(case.folder / name, case.folder / "absolute")
    os.link(case.folder / name, case.folder / "hard")
    os.symlink("deep", case.folder / "linked")
    return [name, f"./{name}", f"deep/../{name}", str(case.folder / name), f"linked/../{name}", "soft",
            "deep/soft", "linked/soft", "absolute", "hard", "/proc/self/cwd/" + name]


def check_files(palpate, models, place):
    """Outputs that are one file."""
    for scene, name in (("own.glb", "own.glb"), ("own.glb", "way.txt"), ("own.gltf", "own.gltf"),
                        ("own.gltf", "own data.bin"), ("own.gltf", "colour.png")):
        case = Case(palpate, models, place)
        for spelling in spellings(case, name):
            case.expect_refused(["replay", scene, "--trajectory", "way.txt", "--out", spelling],
                                [spelling, name])
    case = Case(palpate, models, place)
    for name in ("absolute.png", "x%y.png", "tex/cut a.png", "lamp.ies", "tone.mp3"):
        case.expect_refused(["replay", "own.gltf", "--trajectory", "way.txt", "--out", name], [name])
    case = Case(palpate, models, place)
    case.expect_done("run", "own.glb", "--virtual", "--seconds", "2", "--a4", "on", "--record",
                     "own.palpate", "--out", "ran")
    for spelling in spellings(case, "own.palpate"):
        case.expect_refused(["recording", "export", "own.palpate", "--csv", spelling],
                            [spelling, "own.palpate"])


def check_folders(palpate, models, place):
    """Files in a folder of results that are inputs: through links, or because the input has that name."""
    trials = "out/trials.csv"
    source = Case(palpate, models, place)
    larger = {**PLAN, "participants": 3, "blocks": 2, "limit_s": 120, "haptic": ["NoH", "UaH", "H"],
              "rotation": ["NoR", "R"], "objects": {"O1": {"file": "own.glb", "scale": 0.5}}}
    source.write("plan.json", json.dumps(larger).encode())
    source.expect_done("experiment", "run", "plan.json", "--out", "out")
    trials = (source.folder / trials).read_bytes()
    for link in (os.symlink, os.link):
        for input_name, result, arguments in (
                ("own.glb", "trace-on.csv", ["run", "own.glb", "--virtual", "--seconds", "2"]),
                ("own data.bin", "paths.svg", ["run", "own.gltf", "--virtual", "--seconds", "2"]),
                ("colour.png", "soak.txt", ["soak", "own.gltf", "--minutes", "0.04"]),
                ("own.glb", "raw.csv", ["accuracy", "own.glb", "--quick", "--knob", "a4_step"]),
                ("own.glb", "a4_step.svg", ["accuracy", "own.glb", "--quick", "--knob", "a4_step"]),
                ("own.glb", "report.html", ["compare", "own.glb", "--hands", "2"]),
                ("own.glb", "plan.json", ["compare", "own.glb", "--hands", "2"]),
                ("own.json", "comparison.json", ["compare", "own.glb", "--operator", "own.json"]),
                ("own.glb", "trials/trials.csv", ["compare", "own.glb", "--hands", "2"]),
                ("plan.json", "run.json", ["experiment", "run", "plan.json"]),
                ("own.json", "trials.csv", ["experiment", "run", "plan.json"]),
                ("own.glb", "run.log", ["experiment", "run", "plan.json"]),
                ("own.glb", "parts/participant-1.csv", ["experiment", "run", "plan.json"]),
                ("own.glb", "parts/participant-1.trials", ["experiment", "run", "plan.json"]),
                ("trials.csv", "means.csv", ["experiment", "analyse", "trials.csv"]),
                ("trials.csv", "power.csv", ["experiment", "power", "--pilot", "trials.csv"])):
            case = Case(palpate, models, place)
            case.write("trials.csv", trials)
            target = case.folder / "out" / result
            target.parent.mkdir(parents=True)
            link(case.folder / input_name, target)
            case.expect_refused([*arguments, "--out", "out"], [f"out/{result}", input_name])
    for name, result, arguments in (("plan.json", "run.json", ["experiment", "run"]),
                                    ("own.glb", "scene.csv", ["accuracy"]),
                                    ("own.glb", "paths.svg", ["run"])):
        case = Case(palpate, models, place)
        os.rename(case.folder / name, case.folder / result)
        case.expect_refused([*arguments, result, "--out", "."], [f"./{result}", result])


def check_streams(palpate, models, place):
    """Standard output and standard error that are appended to the input."""
    case = Case(palpate, models, place)
    for name in ("own.gltf", "colour.png"):
        before = case.contents()
        with open(case.folder / name, "ab") as stream:
            done = case.call("info", "own.gltf", stdout=stream, stderr=subprocess.PIPE)
        check(done.returncode == 2 and "standard output" in done.stderr, done.stderr)
        check(case.contents() == before, f"{name} has changed")
        for stdout in (subprocess.PIPE, subprocess.STDOUT):
            with open(case.folder / name, "ab") as stream:
                target = stream if stdout == subprocess.STDOUT else stdout
                done = case.call("info", "own.gltf", stdout=target, stderr=stream)
            check(done.returncode == 2, f"exit code {done.returncode}")
            check(case.contents() == before, f"{name} has changed by the refusal")


def check_streams_of_results(palpate, models, place):
    """Standard output that is appended to what a merge, or a run that goes on, reads of earlier runs."""
    case = Case(palpate, models, place)
    case.expect_done("experiment", "run", "plan.json", "--out", "done")
    before = case.contents()
    for name in ("participant-1.csv", "run.json"):
        for arguments in (["merge", "done", "--out", "merged"], ["run", "plan.json", "--out", "done"]):
            with open(case.folder / "done/parts" / name, "ab") as stream:
                done = case.call("experiment", *arguments, stdout=stream, stderr=subprocess.PIPE)
            check(done.returncode == 2 and "standard output" in done.stderr, f"{arguments}: {done.stderr}")
            check(case.contents() == before, f"{arguments}: {name}: a file has changed")


def check_leftovers(palpate, models, place):
    """Inputs that have the name of what a killed command leaves."""
    case = Case(palpate, models, place)
    name = "trace.csv.1-0.part"
    os.rename(case.folder / "way.txt", case.folder / name)
    case.expect_refused(["replay", "own.glb", "--trajectory", name, "--out", "trace.csv"], [name])
    os.makedirs(case.folder / "out/.palpate-unfinished-abc123/deep")
    name = "out/.palpate-unfinished-abc123/deep/own.glb"
    os.rename(case.folder / "own.glb", case.folder / name)
    for command in (["run", name, "--virtual", "--seconds", "2"], ["accuracy", name, "--quick", "--knob", "a4_step"],
                    ["compare", name, "--hands", "2"], ["soak", name, "--minutes", "0.04"]):
        case.expect_refused([*command, "--out", "out"], [name])


def columns_and_ticks(trace):
    """What two traces of one path have in common; their computing times differ."""
    lines = trace.splitlines()
    return [lines[0]] + [line.split(b",")[0] for line in lines[1:]]


def check_allowed(palpate, models, place):
    """What is no input may be written, as before."""
    case = Case(palpate, models, place)
    replay = ["replay", "own.glb", "--trajectory", "way.txt", "--out"]
    os.symlink("new.csv", case.folder / "dangling")
    os.symlink("dangling", case.folder / "chain")
    shutil.copy(case.folder / "way.txt", case.folder / "copy.txt")
    for name in ("trace.csv", "trace.csv", "chain", "copy.txt", "/dev/null"):
        case.expect_done(*replay, name)
    trace = columns_and_ticks((case.folder / "trace.csv").read_bytes())
    check(columns_and_ticks((case.folder / "new.csv").read_bytes()) == trace, "a dangling link")
    check((case.folder / "chain").is_symlink() and (case.folder / "dangling").is_symlink(), "links")
    check(columns_and_ticks((case.folder / "copy.txt").read_bytes()) == trace, "an older file")
    os.mkfifo(case.folder / "pipe")
    with subprocess.Popen(["cat", "pipe"], cwd=case.folder, stdout=subprocess.PIPE) as reader:
        case.expect_done(*replay, "pipe")
        check(columns_and_ticks(reader.stdout.read()) == trace, "the pipe lacks the trace")
    check(case.call(*replay, "/dev/stdout").stdout.startswith(trace[0].decode()), "/dev/stdout")
    os.symlink("loop", case.folder / "loop")
    done = case.call(*replay, "loop")
    check(done.returncode == 2 and "loop: cannot be written" in done.stderr, done.stderr)
    run = ["experiment", "run", "plan.json", "--out", "."]
    for _ in range(2):  # results beside the plan; the second run goes over its own results
        case.expect_done(*run)
    case.expect_done("experiment", "merge", ".", "--out", ".")


def main():
    palpate, models = (pathlib.Path(path).resolve() for path in sys.argv[1:3])
    with tempfile.TemporaryDirectory() as place:
        check_files(palpate, models, place)
        check_folders(palpate, models, place)
        check_streams(palpate, models, place)
        check_streams_of_results(palpate, models, place)
        check_leftovers(palpate, models, place)
        check_allowed(palpate, models, place)


main()
