#!/usr/bin/env python3
"""Runs the Python lines of FORMAT.md as they stand on a recording.

usage: format_test.py WRITER FORMAT.md

WRITER FOLDER writes FOLDER/a.palpate and FOLDER/rows, the rows that its recorder was handed. Each column
must have the same bits.
"""

import importlib.util
import pathlib
import re
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "helpers"))
from needs import need  # noqa: E402


def main():
    writer, document = sys.argv[1:]
    missing = [name for name in ("sqlite3", "zstandard", "numpy") if not importlib.util.find_spec(name)]
    need(not missing, f"the Python modules {', '.join(missing)}: apt-get install python3-numpy python3-zstandard")
    import numpy
    lines = re.search(r"```python\n(.*?)```", pathlib.Path(document).read_text(), re.S).group(1)
    assert len(lines.splitlines()) == 12, "FORMAT.md promises twelve lines"
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([writer, folder], check=True)
        given = {"path": f"{folder}/a.palpate"}
        exec(lines, given)
        table, columns = given["table"], given["columns"]
        rows = numpy.fromfile(f"{folder}/rows", numpy.dtype([(c["name"], c["type"]) for c in table]))
        assert len(rows) > 2000, len(rows)
        for column in table:
            name = column["name"]
            assert columns[name].dtype == numpy.dtype(column["type"]), name
            assert columns[name].tobytes() == rows[name].tobytes(), name
        assert (columns["tick"] == numpy.arange(len(rows))).all()
        assert columns["contact"].any() and columns["full_force_device_N_x"].any()
    return 0


sys.exit(main())
