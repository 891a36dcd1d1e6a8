#!/usr/bin/env python3
"""Reads from the programs that ship that they are hardened (palpate_harden in CMakeLists.txt).

usage: hardening_test.py BUILD NINJA PROGRAM...

Each program must be position independent, with a stack that cannot be executed, no segment that can be
both written and executed, tables of the linker that are read-only after the start, and calls of the
checks of stacks and of buffers. On x86-64, every object that was compiled for a program must allow the
checks of jumps and returns (IBT, SHSTK), except those of the tick, and the program must be marked for the
check of returns. It cannot be marked for that of jumps, because the tick and Debian's crt1.o have no
instructions for it.
"""

import pathlib
import platform
import re
import subprocess
import sys

# Folders, and the sources of palpate_unchecked().
OF_THE_TICK = re.compile(r"geometry/|haptics/|"
                         r"engine/session/CMakeFiles/palpate_session\.dir/(haptic_session|node_motions|session_recorder)\.|"
                         r"engine/simulation/CMakeFiles/palpate_simulation\.dir/(path_plan|simulated_device)\.")
OTHER_PROGRAM = "make_record_decoder"  # runs while the page is built

failures = []


def expect(holds, message):
    if not holds:
        failures.append(message)


def readelf(*arguments):
    return subprocess.run(["readelf", "-W", *map(str, arguments)], capture_output=True, text=True,
                          check=True).stdout


def check_program(program):
    name = program.name
    header, segments, dynamic = readelf("-h", program), readelf("-l", program), readelf("-d", program)
    symbols = readelf("--dyn-syms", program)
    expect(re.search(r"Type:\s+DYN", header), f"{name}: is not position independent")
    flags = re.search(r"\(FLAGS_1\)(.*)", dynamic)
    expect(flags and re.search(r"\bPIE\b", flags[1]), f"{name}: FLAGS_1 lacks PIE")
    expect(flags and re.search(r"\bNOW\b", flags[1]), f"{name}: FLAGS_1 lacks NOW")
    expect("TEXTREL" not in dynamic, f"{name}: its code is changed at the start")
    expect(re.search(r"^\s*GNU_RELRO\s", segments, re.M), f"{name}: has no GNU_RELRO")
    kinds = re.findall(r"^\s*(\w+)\s+0x\w+ 0x\w+ 0x\w+ 0x\w+ 0x\w+ ([R ])([W ])([E ])", segments, re.M)
    expect(("GNU_STACK", "R", "W", " ") in kinds, f"{name}: its stack can be executed")
    for kind, _, can_write, can_execute in kinds:
        expect((can_write, can_execute) != ("W", "E"), f"{name}: {kind} can be written and executed")
    expect(re.search(r"UND __stack_chk_fail\b", symbols), f"{name}: does not check its stack")
    checked = set(re.findall(r"UND (__\w+_chk)\b", symbols))
    expect(checked, f"{name}: does not check its buffers")
    marked = re.search(r"x86 feature: (.*)", readelf("-n", program))
    if platform.machine() == "x86_64":
        expect(marked and "SHSTK" in marked[1], f"{name}: is not marked for the check of returns")
    print(f"{name}: calls {', '.join(sorted(checked))}; marked for {marked[1] if marked else 'nothing'}")


def allows_checks(file):
    note = re.search(r"x86 feature: (.*)", readelf("-n", file))
    return note and {"IBT", "SHSTK"} <= set(note[1].replace(",", "").split())


def check_objects(build, ninja, program):
    """The objects that were compiled for the program."""
    inputs = subprocess.run([ninja, "-C", build, "--quiet", "-n", "-t", "inputs", program.name],
                            capture_output=True, text=True, check=True).stdout.splitlines()
    compiled = {i for i in inputs if i.endswith(".o") and OTHER_PROGRAM not in i}
    objects = [o for o in sorted(compiled) if not OF_THE_TICK.match(o)]
    expect(objects, f"{program.name}: ninja names no objects")
    without = [o for o in objects if not allows_checks(build / o)]
    print(f"{program.name}: {len(objects) - len(without)} of {len(objects)} objects allow the checks of "
          "jumps and returns")
    expect(not without, f"{program.name}: these objects allow no checks of jumps and returns: {without}")


def main():
    build, ninja, *programs = sys.argv[1:]
    for program in map(pathlib.Path, programs):
        check_program(program)
        if platform.machine() == "x86_64":
            check_objects(pathlib.Path(build), ninja, program)
    sys.exit("\n".join(failures) if failures else 0)


if __name__ == "__main__":
    main()
