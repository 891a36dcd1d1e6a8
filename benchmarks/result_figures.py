"""The figures of the results: palpate.analysis.results draws each from a table.

A file says from which table and code it was drawn, and what its own content is, so that a check needs
no library, and holds with any version of matplotlib.
"""

import functools
import hashlib
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

from result_tables import BadInput

ROOT = pathlib.Path(__file__).resolve().parent.parent
PACKAGES = "numpy, pandas, matplotlib, jinja2"
DRAWN = re.compile(r"<!-- drawn from (\w+), content (\w+) -->\n")


def hash_of(text):
    return hashlib.sha256(text.encode()).hexdigest()[:16]


@functools.cache
def code_of(kind):
    """The text of the module that draws this kind of figure."""
    return (ROOT / f"engine/python/palpate/analysis/results/{kind}.py").read_text(encoding="utf-8")


def mark(source, text):
    """The line at the end of a file with this content."""
    return f"<!-- drawn from {source}, content {hash_of(text)} -->\n"


def source_of(kind, table):
    return hash_of(code_of(kind) + json.dumps(table, sort_keys=True))


def is_drawn(path, kind, table):
    """Whether the file was drawn from this table, and nobody has changed it."""
    try:
        text = path.read_text(encoding="utf-8")
    except OSError:
        return False
    found = DRAWN.search(text)
    return bool(found) and found.groups() == (source_of(kind, table), hash_of(DRAWN.sub("", text)))


def interpreter():
    """A Python that has the packages; BadInput if there is none."""
    chosen = os.environ.get("PALPATE_PYTHON")
    for python in [chosen] if chosen else [sys.executable, shutil.which("python3"), "/usr/bin/python3"]:
        if python and subprocess.run([python, "-P", "-c", f"import {PACKAGES}"], capture_output=True,
                                     check=False).returncode == 0:
            return python
    raise BadInput("the figures need Python 3.11 or later with " + PACKAGES +
                   "; install python3-numpy, python3-pandas, python3-scipy, python3-matplotlib and "
                   "python3-jinja2, or set PALPATE_PYTHON")


def draw(wanted):
    """Writes figures. wanted: {path: (kind, table)}."""
    names = {f"figure-{n}.svg": path for n, path in enumerate(wanted)}
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "engine/python"), "OPENBLAS_NUM_THREADS": "1",
                   "PYTHONDONTWRITEBYTECODE": "1", "PYTHONUTF8": "1"}
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / "tables.json").write_text(json.dumps({file: wanted[path] for file, path in names.items()}))
        done = subprocess.run([interpreter(), "-P", "-m", "palpate.analysis", "results",
                               str(folder / "tables.json"), "--out", name], env=environment,
                              capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise BadInput(f"the figures were not drawn: {done.stderr.strip()[-400:]}")
        for file, path in names.items():
            text = (folder / file).read_text(encoding="utf-8")
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text + mark(source_of(*wanted[path]), text), encoding="utf-8")
            print(f"drew {path}")
