"""The notebook with the paper's Figures 6 and 7 runs on the trials of the paper's plan (oracle),
and the manual has its pictures."""

from __future__ import annotations

import ast
import json
import re
from pathlib import Path

import pytest

from oracle_cases import cases

ROOT = Path(__file__).resolve().parents[3]
NOTEBOOK = ROOT / "engine/python/examples/figures_6_and_7.ipynb"
PICTURES = ROOT / "docs/pictures"
CASE = next(case for case in cases("analyse") if case.name == "paper_people2005")


def run_cells(path):
    """The names after all cells, and the value of the last line of each."""
    names, values = {}, []
    for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
        if cell["cell_type"] != "code":
            continue
        assert cell["outputs"] == [], "the committed notebook has no outputs"
        body = ast.parse("".join(cell["source"])).body
        last = body.pop() if isinstance(body[-1], ast.Expr) else None
        exec(compile(ast.Module(body, []), str(path), "exec"), names)
        values.append(eval(compile(ast.Expression(last.value), str(path), "eval"), names)
                      if last else None)
    return names, values


@pytest.fixture(scope="module")
def notebook(tmp_path_factory):
    folder = tmp_path_factory.mktemp("notebook")
    (folder / "experiment").mkdir()
    file = next(word for word in CASE.arguments if word.endswith(".csv"))
    (folder / "experiment/trials.csv").write_bytes(CASE.inputs[file])
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        names, values = run_cells(NOTEBOOK)
    return folder, names, values


def texts_in(svg):
    return sorted(re.sub("<[^>]*>", "", text) for text in re.findall("<text.*?</text>", svg, re.S))


def test_a_notebook_shows_the_pictures(notebook):
    _, __, values = notebook
    shown = [value._repr_svg_() for value in values if hasattr(value, "_repr_svg_")]
    assert len(shown) == 2
    for text in ("total time (s)", "losses of contact", "mean penetration (dm)",
                 "R: the scene turns", "the paper&#39;s people, mean of NoR and R", "n = 10"):
        assert any(text.replace("&#39;", "'") in found.replace("&#39;", "'")
                   for found in texts_in(shown[0])), text
    assert "mean contact angle (deg)" in texts_in(shown[1])


def test_the_means_are_those_of_the_oracle(notebook):
    _, names, __ = notebook
    rows = [row for row in CASE.json("analysis.json")["means"]
            if row["following"] == "delayed" and row["of"] == "trials" and row["object"] == "all"]
    compared = 0
    for outcome, primary in names["leading"].primary.items():
        for row in rows:
            mean = primary.mean(row["haptic"], row["rotation"])
            if row["outcome"] == outcome.name and mean is not None:
                assert mean["mean"] == pytest.approx(row["mean"], rel=1e-9)
                compared += 1
    assert compared >= 9


@pytest.mark.parametrize("name", ["figure_6.svg", "figure_7.svg"])
def test_the_manual_has_the_same_pictures(notebook, name):
    """Their texts are equal; versions of matplotlib place curves a little differently."""
    made = (notebook[0] / name).read_text(encoding="utf-8")
    committed = (PICTURES / name).read_text(encoding="utf-8")
    assert texts_in(made) == texts_in(committed)
