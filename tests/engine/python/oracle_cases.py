"""The cases of the oracle (oracle/README.md): inputs of a command, and what C++ printed and wrote.

    for case in cases("analyse"):
        case.put_inputs(tmp_path)              # trials.csv, ...; paths in case.arguments are in it
        case.json("analysis.json")             # what is expected
        case.csv("effects.csv")
        case.stdout, case.stderr, case.exit_code
"""

from __future__ import annotations

import csv
import io
import json
import tarfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

ORACLE = Path(__file__).resolve().parent / "oracle"
Files = dict[str, bytes]


@cache
def archived(path: Path) -> dict[str, Files]:
    """The files of an archive: by the name of the case, then by their names."""
    found: dict[str, Files] = {}
    with tarfile.open(path, "r:xz") as archive:
        for member in archive:
            case_name, _, name = member.name.partition("/")
            file = archive.extractfile(member)
            if file:
                found.setdefault(case_name, {})[name] = file.read()
    return found


@cache
def index_of(kind: str, oracle: Path = ORACLE) -> dict[str, dict[str, Any]]:
    found: dict[str, dict[str, Any]] = json.loads((oracle / kind / "index.json").read_text("utf-8"))
    return found


def table_of(text: str) -> list[list[str]]:
    """The first line and the rows of a CSV file."""
    return list(csv.reader(io.StringIO(text, newline="")))


def as_table(rows: list[dict[str, Any]]) -> list[list[str]]:
    """The names of the columns and the rows of a list of JSON objects, as in a CSV file."""
    return [list(rows[0])] + [[_cell(value) for value in row.values()] for row in rows]


def _cell(value: Any) -> str:
    if value is None:
        return ""
    return value if isinstance(value, str) else f"{float(value):.12g}"


@dataclass(frozen=True)
class Case:
    """One call of a command. `arguments` is what follows the name of the program."""

    kind: str
    name: str

    @property
    def index(self) -> dict[str, Any]:
        return index_of(self.kind)[self.name]

    @property
    def about(self) -> str:
        return str(self.index["about"])

    @property
    def arguments(self) -> list[str]:
        return list(self.index["arguments"])

    @property
    def out(self) -> str:
        """The folder of the results, beside the inputs."""
        return str(self.index["out"])

    @property
    def exit_code(self) -> int:
        return int(self.index["exit"])

    @property
    def inputs(self) -> Files:
        return archived(ORACLE / self.kind / "input.tar.xz").get(self.name, {})

    def put_inputs(self, folder: Path) -> None:
        for name, content in self.inputs.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)

    @property
    def expected(self) -> Files:
        """stdout, stderr and each result. Pages and figures have only their texts."""
        return archived(ORACLE / self.kind / "expected.tar.xz")[self.name]

    @property
    def results(self) -> list[str]:
        """The names of the files that the command wrote."""
        kept = [name for name in self.expected if name not in ("stdout", "stderr")]
        return sorted(kept + list(self.index.get("as_in_json", {})))

    @property
    def stdout(self) -> str:
        return self.text("stdout")

    @property
    def stderr(self) -> str:
        return self.text("stderr")

    def text(self, name: str) -> str:
        return self.expected[name].decode("utf-8")

    def json(self, name: str) -> Any:
        return json.loads(self.expected[name])

    def csv(self, name: str) -> list[list[str]]:
        """The first line and the rows; from a JSON result, if it has the same rows."""
        in_json = self.index.get("as_in_json", {}).get(name)
        if in_json:
            return as_table(self.json(in_json)[name.removesuffix(".csv")])
        return table_of(self.text(name))

    def __str__(self) -> str:
        return f"{self.kind}/{self.name}"


def cases(kind: str, *, refused: bool | None = None) -> list[Case]:
    """All cases of a kind (a folder of the oracle), by name. refused: only those with an error, or
    only those without."""
    found = [Case(kind, name) for name in sorted(index_of(kind))]
    return [each for each in found if refused is None or refused == (each.exit_code == 2)]
