"""The pages of Palpate: `python3 -P -m palpate.analysis COMMAND ...`.

The program starts this for its commands; a person may, too. A command writes all of its files into
the folder `--out`, which must exist, and only when nothing can fail any more; it prints what a
terminal shows on stdout. Exit codes: 0; 2 for bad input, with one line on stderr.
"""

from __future__ import annotations

import argparse
import importlib
import pathlib
import sys
from collections.abc import Sequence

from palpate.analysis.errors import InputError

# Each is a module with add_arguments(parser) and run(arguments) -> Report.
COMMANDS = {
    "experiment": "palpate.analysis.experiment.command",
    "power": "palpate.analysis.power.command",
    "sweep": "palpate.analysis.sweep.command",
    "canonical": "palpate.analysis.canonical.command",
    "strategies": "palpate.analysis.strategies.command",
    "accuracy": "palpate.analysis.accuracy.command",
    "results": "palpate.analysis.results.command",
}


def _write(path: pathlib.Path, text: str) -> None:
    try:
        path.write_text(text, encoding="utf-8", newline="\n")
    except OSError as error:
        raise InputError(path.name, "", f"cannot be written: {error.strerror}") from error


def main(words: Sequence[str]) -> int:
    parser = argparse.ArgumentParser(prog="palpate.analysis", description=__doc__)
    parser.add_argument("command", choices=COMMANDS)
    parser.add_argument("--out", type=pathlib.Path, required=True, help="folder of the results")
    name = next((word for word in words if word in COMMANDS), None)
    command = importlib.import_module(COMMANDS[name]) if name else None
    if command:
        command.add_arguments(parser)
    arguments = parser.parse_args(words)
    assert command is not None
    try:
        report = command.run(arguments)
        for file, text in report.files.items():
            _write(arguments.out / file, text)
    except InputError as error:
        print(f"palpate: {error}", file=sys.stderr)
        return 2
    sys.stdout.write(report.text)
    for warning in report.warnings:
        print(f"palpate: warning: {warning}", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
