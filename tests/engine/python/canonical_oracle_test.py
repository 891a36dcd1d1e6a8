"""The page of `experiment run` of a wall against that of the C++ (oracle/README.md)."""

from __future__ import annotations

import argparse
import re

import pytest
from markupsafe import Markup

from numbers_agree import numbers_in
from oracle_cases import cases
from page_text import visible_text
from palpate.analysis.canonical import command

# What a caption says besides the C++'s: what whiskers are, and of how many operators.
WHISKERS = re.compile(r" Whiskers: 95 % intervals of the mean over simulated operators, at most "
                      r"\d+\.$")

NUMBER = re.compile(r"\d+(?:\.\d+)?")


@pytest.mark.parametrize("case", cases("canonical"), ids=lambda case: case.name)
def test_page_has_the_numbers_and_texts(case, tmp_path, monkeypatch):
    for name in ("canonical.csv", "run.json"):
        (tmp_path / name).write_bytes(case.expected[name])
    monkeypatch.setattr(command.figures, "svg", lambda *_: Markup("<svg></svg>"))
    report = command.run(argparse.Namespace(folder=tmp_path))
    assert list(report.files) == ["canonical.html"]
    assert report.text == ""
    warnings = [f"palpate: warning: {line}" for line in report.warnings]
    assert warnings == case.stderr.splitlines()
    found = [WHISKERS.sub("", line) for line in visible_text(report.files["canonical.html"])]
    found = [line for line in found if not line.startswith("Where do whiskers end?")]
    expected = visible_text(case.text("canonical.html"))
    assert [NUMBER.sub("#", line) for line in found] == [NUMBER.sub("#", line) for line in expected]
    for mine, theirs in zip(found, expected):
        assert numbers_in(mine) == pytest.approx(numbers_in(theirs), rel=1e-9)
