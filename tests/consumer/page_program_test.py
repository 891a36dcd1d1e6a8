#!/usr/bin/env python3
"""Runs the program of a page, and compares what the page says that it prints.

usage: page_program_test.py PROGRAM PAGE.md PROJECT

The program runs in the project's folder and must succeed. Each line of a block of `text` below the line
<!-- printed by the program --> must be a line that it prints.
"""

import pathlib
import re
import subprocess
import sys

QUOTED = re.compile(r"^<!-- printed by the program -->\n+```text\n(.*?)^```", re.M | re.S)


def main():
    program, page, project = sys.argv[1:]
    done = subprocess.run([program], cwd=project, capture_output=True, text=True, timeout=60)
    print(done.stdout + done.stderr)
    faults = [] if done.returncode == 0 else [f"{page}: its program ends with exit code {done.returncode}"]
    printed = done.stdout.splitlines()
    if not printed:
        faults.append(f"{page}: its program prints nothing")
    for block in QUOTED.findall((pathlib.Path(project) / page).read_text(encoding="utf-8")):
        faults += [f"{page}: its program does not print: {line}"
                   for line in block.splitlines() if line not in printed]
    for fault in faults:
        print(fault)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
