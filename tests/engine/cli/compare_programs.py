#!/usr/bin/env python3
"""Compares the output and the files of two builds of the program, on twenty command lines.

usage: compare_programs.py BEFORE AFTER MODELS

BEFORE and AFTER are paths of the program, MODELS is the folder of the project's models. Printed text,
exit codes and the names of files must be equal. The columns of BEFORE's CSV files must come first
in AFTER's and be equal to the byte; AFTER may append columns, and add keys to JSON objects. Measured
times are left out. Not a test of the suite: the script needs a program built from an older commit.
"""

import csv
import json
import pathlib
import re
import subprocess
import sys
import tempfile

# Measured times, which differ between any two runs.
TIME_COLUMNS = re.compile(r"_(ns|us|ms)$")
TIME_KEYS = {"step_ns", "load_ms", "load_parts_ms", "time_share", "loading_ms"}
TIME_LINES = re.compile(r"^.*(loaded in|tick p50|of the time of a tick).*$", re.M)


def command_lines(models, scratch):
    """The arguments of each command; it writes into its working folder."""
    star, labyrinth, lock = (models / f"{n}.glb" for n in ("star", "labyrinth", "lock"))
    path = scratch / "path.txt"
    path.write_text("".join(f"{0.11 - 1e-4 * n:.17g} {2e-5 * n:.17g} {1e-5 * n:.17g}\n"
                            for n in range(2000)))
    replay = ["replay", star, "--trajectory", path, "--out", "trace.csv"]
    run = ["run", star, "--virtual", "--seconds", "6"]
    friction = ["replay", models / "effect_friction.glb", "--trajectory", path, "--out", "t.csv"]
    return [
        ["--help"], ["--version"], ["run", "--help"], ["replay", "--help"], ["accuracy", "--help"],
        ["info", "--help"],
        ["info", labyrinth],
        ["info", models / "gallery.glb", "--list"],
        ["info", models / "gallery.glb", "--json"],
        run,
        [*run, "--json", "--a4", "on", "--radius", "0.003"],
        ["run", lock, "--virtual", "--seconds", "8", "--sensors", "3", "--json"],
        ["run", models / "torus.glb", "--virtual", "--fit", "auto", "--seconds", "5", "--a4", "off"],
        ["run", models / "effect_viscosity.glb", "--virtual"],
        replay,
        [*replay, "--sensors", "3", "--actuators", "2", "--a4", "on", "--table1", "printed",
         "--a4-step", "paper"],
        [*replay, "--json", "--accuracy", "exact", "--radius", "0.004", "--damping", "1"],
        [*friction, "--sensors", "3", "--force", "full", "--effect-times"],
        ["replay", models / "effect_texture.glb", "--trajectory", path, "--move",
         "texture_sine=0.01 0 0 0 0 1", "--out", "t.csv"],
        ["replay", star, "--trajectory", path, "--stiffness", "-1"],
        ["run", scratch / "absent.glb"],
    ]


class Outcome:
    """Output and files of one command."""

    def __init__(self, program, arguments, folder):
        folder.mkdir()
        done = subprocess.run([program, *map(str, arguments)], cwd=folder, capture_output=True,
                              text=True, env={"PATH": "/usr/bin:/bin"})
        self.code = done.returncode
        self.texts = {"stdout": self._text(done.stdout, program),
                      "stderr": self._text(done.stderr, program)}
        self.files = {p.relative_to(folder).as_posix(): p for p in sorted(folder.rglob("*"))
                      if p.is_file()}

    @staticmethod
    def _text(text, program):
        if text.startswith("{"):
            return json.dumps(without_times(json.loads(text)), indent=1)
        return TIME_LINES.sub("(times)", text.replace(str(program), "palpate"))


def without_times(value):
    if isinstance(value, dict):
        return {k: without_times(v) for k, v in value.items() if k not in TIME_KEYS}
    return [without_times(v) for v in value] if isinstance(value, list) else value


def table_differences(before, after):
    """Differences between two CSV files."""
    with before.open() as b, after.open() as a:
        old, new = csv.reader(b), csv.reader(a)
        header, header_after = next(old), next(new)
        if header_after[:len(header)] != header:
            return [f"columns {header} became {header_after}"]
        kept = [i for i, name in enumerate(header) if not TIME_COLUMNS.search(name)]
        for row, row_after in zip(old, new, strict=True):
            for i in kept:
                if row[i] != row_after[i]:
                    return [f"{header[i]}: {row[i]} became {row_after[i]}"]
    return []


def json_differences(before, after, place=""):
    """Differences between two values; new keys are printed and are not differences."""
    if isinstance(before, dict) and isinstance(after, dict):
        added = [key for key in after if key not in before]
        if added:
            print(f"        adds {place or 'JSON'}: {', '.join(added)}")
        gone = [f"{place}.{key} is gone" for key in before if key not in after]
        return gone + [text for key in before if key in after
                       for text in json_differences(before[key], after[key], f"{place}.{key}")]
    if isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
        return [text for i, (b, a) in enumerate(zip(before, after))
                for text in json_differences(b, a, f"{place}[{i}]")]
    return [] if before == after else [f"{place}: {before} became {after}"]


def differences(before, after):
    found = []
    if before.code != after.code:
        found.append(f"exit code {before.code} became {after.code}")
    for name, text in before.texts.items():
        if text.startswith("{") and after.texts[name].startswith("{"):
            found += json_differences(json.loads(text), json.loads(after.texts[name]))
        elif text != after.texts[name]:
            lines = set(text.splitlines()) ^ set(after.texts[name].splitlines())
            found.append(f"{name} differs: {sorted(lines)[:4]}")
    if before.files.keys() != after.files.keys():
        return found + [f"files {sorted(before.files)} became {sorted(after.files)}"]
    for name, path in before.files.items():
        if name.endswith(".csv"):
            found += [f"{name}: {text}" for text in table_differences(path, after.files[name])]
        elif path.read_bytes() != after.files[name].read_bytes():
            found.append(f"{name} differs")
    return found


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    before, after, models = (pathlib.Path(argument).resolve() for argument in sys.argv[1:])
    failures = 0
    with tempfile.TemporaryDirectory() as name:
        scratch = pathlib.Path(name)
        for number, arguments in enumerate(command_lines(models, scratch)):
            outcome = Outcome(before, arguments, scratch / f"{number}-before")
            found = differences(outcome, Outcome(after, arguments, scratch / f"{number}-after"))
            shown = " ".join(str(a).replace(str(models), "models").replace(name, "")
                             for a in arguments)
            print(f"{'DIFFERS' if found else 'same   '} exit {outcome.code} palpate {shown}")
            for text in found:
                print(f"        {text}")
            failures += bool(found)
    sys.exit(f"{failures} command lines differ" if failures else 0)


main()
