#!/usr/bin/env python3
"""Checks that the names of all tests in a build are unique, so that a name selects one test.

usage: suite_test.py CTEST BUILD
"""

import collections
import re
import subprocess
import sys


def main():
    ctest, build = sys.argv[1:]
    listed = subprocess.run([ctest, "--test-dir", build, "-N"], capture_output=True, text=True,
                            check=True).stdout
    names = re.findall(r"^ *Test +#\d+: (.*)$", listed, re.M)
    twice = [name for name, count in collections.Counter(names).items() if count > 1]
    for name in twice:
        print(f"{name}: several tests have this name; rename all but one")
    if not names:
        print(f"{build}: has no tests; build it first")
    return 1 if twice or not names else 0


if __name__ == "__main__":
    sys.exit(main())
