"""What a test needs of the machine. Where the machine lacks it, the test is not run and says so in one line that
begins with "needs ". test.sh lists these lines at its end; .ci/run fails on any. needs.h is the same for C++."""

import os
import pty
import sys

NOT_RUN = 77  # the exit code that ctest counts as skipped


def need(holds, what):
    """Ends the test as not run unless it holds. what: what is needed, and how to get it."""
    if not holds:
        print(f"needs {what}", flush=True)
        sys.exit(NOT_RUN)


def need_terminals():
    try:
        ends = pty.openpty()
    except OSError as error:
        need(False, f"a pseudo-terminal: {error.strerror or error}; mount devpts on /dev/pts, and make /dev/ptmx")
    for end in ends:
        os.close(end)
