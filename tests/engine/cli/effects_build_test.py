#!/usr/bin/env python3
"""Effects that a scene does not declare cost nothing, compared with programs built without them.

effects_build_test.py PALPATE PALPATE_NO_FRICTION PALPATE_NO_EFFECTS MODELS_DIR

Plays the same trajectories with the program, with a program built without friction, and with
a program built without any effect (PALPATE_EFFECTS), through scenes that do not declare the missing
effects. The traces must agree to the bit, and the haptic loop must execute the same number of instructions per
tick within 0.1 %, counted by Callgrind.
"""

import csv
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile

# Relative difference of a tick's instructions; the layout of the linker causes a small one.
LARGEST_DIFFERENCE = 1e-3

TICKS = 1000

# Scenes without any effect, and scenes with effects other than friction.
NO_EFFECTS = ["star.glb", "torus.glb", "thin_plate.glb"]
WITHOUT_FRICTION = ["effect_texture.glb", "effect_shading.glb", "effect_magnet.glb"]

# Columns that the clock fills.
TIME_COLUMNS = {"step_ns"}


def run(*command):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}\n{done.stdout}{done.stderr}")
    return done.stdout + done.stderr


def extent_m(palpate, scene):
    return json.loads(run(palpate, "info", scene, "--json"))["extent_m"]


def write_trajectory(path, extent):
    """Taps across the top of the scene, then a path from outside into its middle and around there."""
    half = [0.5 * e for e in extent]
    with path.open("w") as file:
        for i in range(TICKS):
            t = i / TICKS
            depth = max(0.3, 2.5 - 4.0 * t)
            x = half[0] * math.cos(9.0 * t) * (0.9 if t < 0.5 else depth)
            y = half[1] * math.sin(7.0 * t) * (0.9 if t < 0.5 else depth)
            z = half[2] * (1.1 + 0.3 * math.cos(60.0 * t) if t < 0.5 else
                           max(depth, 0.9) * math.cos(5.0 * t))
            file.write(f"{x:.17g} {y:.17g} {z:.17g}\n")


def trace(palpate, scene, trajectory, out):
    """The rows of a replay, without times."""
    run(palpate, "replay", scene, "--trajectory", trajectory, "--out", out, "--sensors", 3,
        "--actuators", 1, "--a4", "on", "--damping", 1)
    with out.open() as file:
        rows = list(csv.reader(file))
    keep = [i for i, name in enumerate(rows[0]) if name not in TIME_COLUMNS]
    assert len(keep) < len(rows[0]), f"the trace has none of the columns {TIME_COLUMNS}"
    return [[row[i] for i in keep] for row in rows]


def instructions(palpate, scene, trajectory, out):
    """Instructions that all ticks of a replay execute in HapticLoop::tick."""
    run("valgrind", "--tool=callgrind", f"--callgrind-out-file={out}",
        "--toggle-collect=palpate::HapticLoop::tick(*", palpate, "replay", scene, "--trajectory",
        trajectory, "--sensors", 3, "--actuators", 1, "--a4", "on", "--damping", 1)
    return int(re.search(r"^(?:summary|totals): (\d+)", out.read_text(), re.M).group(1))


def check(programs, scene, without_effects, scratch):
    """How many comparisons failed."""
    palpate = programs["all effects"]
    names = ["all effects", "no friction"] + (["no effects"] if without_effects else [])
    trajectory = scratch / "trajectory.txt"
    write_trajectory(trajectory, extent_m(palpate, scene))
    rows = {n: trace(programs[n], scene, trajectory, scratch / "trace.csv") for n in names}
    counts = {n: instructions(programs[n], scene, trajectory, scratch / "callgrind.out")
              for n in names}
    failures = 0
    contact = rows["all effects"][0].index("contact")
    contacts = sum(row[contact] == "1" for row in rows["all effects"][1:])
    if contacts < TICKS // 10:
        print(f"{scene.name}: only {contacts} of {TICKS} ticks in contact: too few for a comparison")
        failures += 1
    for name in names[1:]:
        same = rows[name] == rows["all effects"]
        difference = counts[name] / counts["all effects"] - 1.0
        good = same and abs(difference) <= LARGEST_DIFFERENCE
        failures += not good
        print(f"{scene.name}: {name}: traces {'equal' if same else 'DIFFER'}, "
              f"{counts[name] / TICKS:.1f} instructions per tick, {100 * difference:+.4f} % of "
              f"{counts['all effects'] / TICKS:.1f}{'' if good else '  FAILED'}")
    return failures


def main():
    palpate, no_friction, no_effects, models = map(pathlib.Path, sys.argv[1:])
    programs = {"all effects": palpate, "no friction": no_friction, "no effects": no_effects}
    with tempfile.TemporaryDirectory() as scratch:
        failures = sum(check(programs, models / name, name in NO_EFFECTS, pathlib.Path(scratch))
                       for name in NO_EFFECTS + WITHOUT_FRICTION)
    sys.exit(f"{failures} failed" if failures else 0)


if __name__ == "__main__":
    main()
