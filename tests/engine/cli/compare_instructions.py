#!/usr/bin/env python3
"""Compares the instructions per tick of two builds of the program, scene by scene.

usage: compare_instructions.py BEFORE AFTER MODELS

Callgrind counts them in HapticLoop::tick, on the trajectories and scenes of effects_build_test.py.
Not a test of the suite: the script needs a program built from an older commit.
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
        for scene in effects.NO_EFFECTS + effects.WITHOUT_FRICTION:
            trajectory = scratch / "trajectory.txt"
            effects.write_trajectory(trajectory, effects.extent_m(before, models / scene))
            counts = [effects.instructions(program, models / scene, trajectory, scratch / "out")
                      for program in (before, after)]
            print(f"{scene}: {counts[0] / effects.TICKS:.1f} became "
                  f"{counts[1] / effects.TICKS:.1f} instructions per tick, "
                  f"{100 * (counts[1] / counts[0] - 1):+.3f} %")


main()
