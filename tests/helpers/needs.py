"""What a test needs of the machine. Where the machine lacks it, the test is not run and says so in one line that
begins with "needs ". test.sh lists these lines at its end; .ci/run fails on any. needs.h is the same for C++."""

import os
import pty
import subprocess
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


PAGES = ("numpy", "scipy", "pandas", "statsmodels", "matplotlib", "jinja2")  # of engine/cli/python_page.cpp
MISSING = """
import sys
from importlib.util import find_spec
print(*[name for name in sys.argv[1:] if getattr(find_spec(name), "loader", None) is None])
"""


def python_with(*modules):
    """The interpreter of pages: PALPATE_PYTHON, or the first of `python3` in PATH and /usr/bin/python3 that has the
    packages of pages and these modules. Without one, the test ends as not run."""
    lacks = []
    chosen = os.environ.get("PALPATE_PYTHON")
    for python in [chosen] if chosen else ["python3", "/usr/bin/python3"]:
        command = [python, "-P", "-c", MISSING, *PAGES, *modules]
        try:
            found = subprocess.run(command, capture_output=True, text=True, check=False)
        except OSError as error:
            lacks.append(f"{python} ({error.strerror})")
            continue
        if found.returncode == 0 and not found.stdout.strip():
            return python
        lacks.append(f"{python} ({'lacks ' + found.stdout.strip() if found.returncode == 0 else 'is too old'})")
    return need(False, f"a Python with the packages of pages, pytest and mypy: {', '.join(lacks)}; "
                       "apt-get install the packages python3-... of setup.sh")
