#!/usr/bin/env python3
"""Runs the tests of the Python package `palpate`, or checks its types.

run.py tests FILE...              these files of this folder, by pytest
run.py tests --except FILE...     all others; tests in a browser are scripts of their own
run.py types CACHE                mypy --strict; CACHE is a folder for what it has read

The interpreter is PALPATE_PYTHON, or the first of `python3` in PATH and /usr/bin/python3 that has all packages.
Nothing is written beside the sources. Exits with 77 if no interpreter has the packages.
"""

import os
import pathlib
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
ROOM = HERE.parents[2] / "engine" / "python"
sys.path.insert(0, str(HERE.parents[1] / "helpers"))
from needs import python_with

# One thread of BLAS, as in the program (engine/cli/python_page.cpp).
ENVIRONMENT = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1", "PYTHONUTF8": "1",
               "PYTHONDONTWRITEBYTECODE": "1"}


def run(module, *words):
    """Runs a module with the packages of pages. The working folder is not searched for modules."""
    command = [python_with(module), "-P", "-m", module, *map(str, words)]
    return subprocess.run(command, env=os.environ | ENVIRONMENT, check=False).returncode


def tests(words):
    is_without = words[:1] == ["--except"]
    named = {HERE / word for word in words[is_without:]}
    missing = sorted(str(path) for path in named if not path.is_file())
    if missing or not named:
        sys.exit(f"expected files of {HERE}: {', '.join(missing) or 'at least one'}")
    others = {path for path in HERE.glob("*_test.py") if not path.name.endswith("_browser_test.py")} - named
    files = sorted(others if is_without else named)
    return run("pytest", "-q", "-p", "no:cacheprovider", "-c", ROOM / "pyproject.toml", "--rootdir", HERE, *files)


def types(words):
    return run("mypy", "--config-file", ROOM / "pyproject.toml", "--cache-dir", words[0], ROOM / "palpate")


def main():
    commands = {"tests": tests, "types": types}
    if len(sys.argv) < 3 or sys.argv[1] not in commands:
        sys.exit(__doc__)
    return commands[sys.argv[1]](sys.argv[2:])


if __name__ == "__main__":
    sys.exit(main())
