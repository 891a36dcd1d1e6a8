#!/usr/bin/env python3
"""Makes what is expected from the inputs, with a program.

make_oracle.py PALPATE DIR [KIND | KIND/NAME ...]

For each case of this folder, runs the command with its inputs, and writes what it printed and wrote
into DIR/KIND. DIR may be this folder. The committed results are of commit 53aa82cd (README.md).
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from packing import pack, write_index

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from oracle_cases import Case, Files, as_table, cases, table_of  # noqa: E402
from numbers_agree import table_differences  # noqa: E402
from page_text import without_drawings  # noqa: E402

# Results that tell about the run and not about its numbers, and folders of parts.
NOT_KEPT = {"run.log", "parts", "traces"}


# Numbers keep 12 significant digits: 1e-9 is compared, and JSON and CSV then have the same texts.
LONG_NUMBER = re.compile(rb"(?<![\w.])-?\d+\.\d{8,}(?:e[+-]?\d+)?(?![\w.])")


PROGRESS = re.compile(rb"^palpate: .* left, \d+ % done\r?\n?", re.M)


def shortened(text: bytes) -> bytes:
    return LONG_NUMBER.sub(lambda number: b"%.12g" % float(number[0]), text)


def reduced(path: Path) -> bytes:
    """The content of a result; of a page or a drawing, its texts."""
    if path.suffix in (".csv", ".json"):
        return shortened(path.read_bytes())
    if path.suffix in (".html", ".svg"):
        return without_drawings(path.read_text(encoding="utf-8")).encode()
    return path.read_bytes()


def results_in(folder: Path) -> Files:
    if not folder.is_dir():
        return {}
    paths = [path for path in folder.rglob("*") if path.is_file() and not path.is_symlink()]
    kept = [path for path in paths if not NOT_KEPT & set(path.relative_to(folder).parts)]
    return {str(path.relative_to(folder)): reduced(path) for path in kept}


def is_table(tree: Any) -> bool:
    """Whether a JSON tree is a list of objects that are not nested, with one row or more."""
    rows = tree if isinstance(tree, list) else []
    return bool(rows) and all(isinstance(row, dict) and not any(
        isinstance(value, (dict, list)) for value in row.values()) for row in rows)


def tables_in_json(found: Files) -> dict[str, str]:
    """The CSV files whose rows are in a JSON file, too, and the name of that file."""
    in_json = {}
    for name in found:
        if not name.endswith(".json"):
            continue
        trees = json.loads(found[name])
        for table in (key for key, rows in trees.items() if f"{key}.csv" in found
                      and is_table(rows)):
            rows = table_of(found[f"{table}.csv"].decode())
            if not list(table_differences(as_table(trees[table]), rows)):
                in_json[f"{table}.csv"] = name
    return in_json


def run(program: Path, each: Case) -> tuple[int, Files]:
    """The exit code of a case's command, and what it printed and wrote."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        each.put_inputs(folder)
        done = subprocess.run([program, *each.arguments], cwd=folder, capture_output=True,
                              check=False)
        found = {"stdout": done.stdout, "stderr": PROGRESS.sub(b"",
            done.stderr)} | results_in(folder / each.out)
    for content in found.values():
        assert name.encode() not in content, f"{each}: a result names the folder of the run"
    return done.returncode, found


def remake(program: Path, kind: str, only: str, to: Path) -> None:
    """only: the name of one case; empty: all cases."""
    index, expected = {}, {}
    for each in cases(kind):
        if only and each.name != only:
            index[each.name] = each.index
            known = each.expected if "exit" in each.index else {}
            expected |= {f"{each.name}/{name}": content for name, content in known.items()}
            continue
        code, found = run(program, each)
        in_json = tables_in_json(found)
        found = {name: content for name, content in found.items() if name not in in_json}
        index[each.name] = {**each.index, "exit": code, "as_in_json": in_json}
        expected |= {f"{each.name}/{name}": content for name, content in found.items()}
        print(f"{each}: exit code {code}")
    if to != HERE / kind:
        to.mkdir(parents=True, exist_ok=True)
        (to / "input.tar.xz").write_bytes((HERE / kind / "input.tar.xz").read_bytes())
    pack(to / "expected.tar.xz", expected)
    write_index(to / "index.json", index)


def main() -> None:
    program, to = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
    for name in sys.argv[3:] or sorted(path.parent.name for path in HERE.glob("*/index.json")):
        kind, _, only = name.partition("/")
        remake(program, kind, only, to / kind)


if __name__ == "__main__":
    main()
