#!/usr/bin/env python3
"""Compares the instructions that a tick takes in two builds of the program, scene by scene.

usage: compare_instructions.py BEFORE AFTER MODELS

Counted by Callgrind in HapticLoop::tick, on the trajectories and scenes of the test of effects. Not a
test of the suite: it needs a program built from an older commit.
"""

import pathlib
import sys
import tempfile

import effects_build_test as effects


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    before, after, models = map(pathlib.Path, sys.argv[1:])
    with tempfile.TemporaryDirectory() as name:
        scratch = pathlib.Path(name)
        for scene in effects.BARE + effects.WITHOUT_FRICTION:
            trajectory = scratch / "trajectory.txt"
            effects.write_trajectory(trajectory, effects.extent_m(before, models / scene))
            counts = [effects.instructions(program, models / scene, trajectory, scratch / "out")
                      for program in (before, after)]
            print(f"{scene}: {counts[0] / effects.TICKS:.1f} became "
                  f"{counts[1] / effects.TICKS:.1f} instructions a tick, "
                  f"{100 * (counts[1] / counts[0] - 1):+.3f} %")


main()
