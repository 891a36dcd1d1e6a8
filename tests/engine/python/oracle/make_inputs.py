#!/usr/bin/env python3
"""Makes the inputs of the oracle. What is expected comes from make_oracle.py afterwards.

make_inputs.py [--with PALPATE] [KIND ...]

The made files are the same bytes every time. Trials of the paper's plan are kept as they are
committed; --with PALPATE runs the plan again (ten minutes on two cores).
"""

from __future__ import annotations

import argparse
import csv
import io
import json
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

import analyse_inputs
import hostile_inputs
import run_inputs
from analyse_inputs import FOLLOWINGS
from made_trials import FACTORS, MEASURES, VARIANT, text_of
from packing import pack, write_index
from run_inputs import Given

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from oracle_cases import archived, index_of  # noqa: E402

HERE = Path(__file__).resolve().parent


class Kind:
    """Collects the cases of a kind, and writes them."""

    def __init__(self, kind: str, program: Path | None) -> None:
        self.program = program
        self.folder = HERE / kind
        self.index: dict[str, dict[str, object]] = {}
        self.files: dict[str, bytes] = {}

    def add(self, name: str, about: str, arguments: list[str], out: str,
            inputs: dict[str, bytes]) -> None:
        self.index[name] = {"about": about, "arguments": arguments, "out": out}
        self.files |= {f"{name}/{file}": content for file, content in inputs.items()}

    def write(self) -> None:
        """What is known about a case with the same input stays in the index."""
        if (self.folder / "index.json").exists():
            before = archived(self.folder / "input.tar.xz") if self.files else {}
            for name, known in index_of(self.folder.name).items():
                is_same = all(self.files.get(f"{name}/{file}") == content
                              for file, content in before.get(name, {}).items())
                new = self.index.get(name, {})
                if is_same and new.get("arguments") == known["arguments"] and len(before.get(name,
                    {})) == sum(
                        file.startswith(f"{name}/") for file in self.files):
                    self.index[name] = {**known, **new}
        write_index(self.folder / "index.json", self.index)
        pack(self.folder / "input.tar.xz", self.files)


# Of the committed results (benchmarks/measure_experiment.py). One has the columns that the analysis
# reads, for all followings; the other one has all columns, for two.
PAPER_COLUMNS = FACTORS + MEASURES + VARIANT
PAPER = {"people2005": (PAPER_COLUMNS, FOLLOWINGS), "literature": (None, ("delayed", "predict"))}


def paper_trials(program: Path, operator: str) -> bytes:
    """trials.csv of the paper's plan with a file of simulated operators."""
    with tempfile.TemporaryDirectory() as folder:
        def palpate(*arguments: str) -> None:
            subprocess.run([program, "experiment", *arguments], check=True, cwd=folder,
                           stdout=subprocess.DEVNULL)
        palpate("plan", "paper", "--out", "plan.json")
        plan_path = Path(folder) / "plan.json"
        plan = json.loads(plan_path.read_text())
        plan_path.write_text(json.dumps(plan | {"operator": operator}))
        palpate("run", "plan.json", "--out", "trials")
        return (Path(folder) / "trials" / "trials.csv").read_bytes()


def share_of(trials: bytes, columns: Sequence[str] | None, followings: Sequence[str]) -> bytes:
    reader = csv.DictReader(io.StringIO(trials.decode(), newline=""))
    rows = [row for row in reader if row["following"] in followings]
    return text_of(rows, columns or list(rows[0])).encode()


def committed(name: str) -> bytes:
    return archived(HERE / "analyse" / "input.tar.xz")[name]["trials.csv"]


def analyse(kind: Kind) -> None:
    for operator, (columns, followings) in PAPER.items():
        name = f"paper_{operator}"
        trials = (share_of(paper_trials(kind.program, operator), columns, followings)
                  if kind.program else committed(name))
        kind.add(name, f"the paper's plan, seed 2005, {operator}: {', '.join(followings)}",
                 ["experiment", "analyse", "trials.csv"], "analysis", {"trials.csv": trials})
    for name, (about, text, more) in analyse_inputs.made_cases().items():
        content = text if isinstance(text, bytes) else text.encode()
        kind.add(name, about, ["experiment", "analyse", "trials.csv", *more], "analysis",
                 {"trials.csv": content})


def trials(kind: Kind) -> None:
    for name, content in hostile_inputs.texts().items():
        kind.add(name, name.replace("_", " "), ["experiment", "analyse", "trials.csv"], "analysis",
                 {"trials.csv": content})


def runs(cases: dict[str, Given], out: str) -> Callable[[Kind], None]:
    def write(kind: Kind) -> None:
        for name, (about, arguments, inputs) in cases.items():
            kind.add(name, about, arguments, out, inputs)
    return write


KINDS = {"analyse": analyse,
         "trials": trials,
         "compare": runs(run_inputs.compare_cases(), "compare"),
         "power": runs(run_inputs.power_cases(), "power"),
         "sweep": runs(run_inputs.sweep_cases(), "sweep"),
         "canonical": runs(run_inputs.canonical_cases(), "experiment"),
         "accuracy": runs(run_inputs.accuracy_cases(), "accuracy")}


def main() -> None:
    options = argparse.ArgumentParser()
    options.add_argument("--with", dest="program", type=Path)
    options.add_argument("kinds", nargs="*")
    given = options.parse_args()
    for name in given.kinds or KINDS:
        kind = Kind(name, given.program and given.program.resolve())
        KINDS[name](kind)
        kind.write()


if __name__ == "__main__":
    main()
