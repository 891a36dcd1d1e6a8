"""The answers of `experiment power`: against the oracle, and against their own counts.

The oracle simulated 200 data sets (1,000 in the cases one_*) with other random numbers. What is not
simulated agrees to 1e-9; powers agree within the error of two simulations.
"""

import argparse
import csv
import io
import json
from functools import cache

import numpy as np
import pytest
from numbers_agree import assert_agree, assert_tables_agree
from oracle_cases import cases
from page_text import svg_texts, tables_of, visible_text

from palpate.analysis import __main__
from palpate.analysis.numbers import csv_text, json_text
from palpate.analysis.power import command, figures
from palpate.analysis.power.answers import Answers
from palpate.analysis.power.notes import notes
from palpate.analysis.power.page import page_of
from palpate.analysis.power.question import prepare
from palpate.analysis.power.simulation import simulate
from palpate.analysis.power.texts import (
    answer_number,
    answer_rest,
    facts,
    lines,
    pilot_pairs,
    terminal_text,
)

MADE = cases("power", refused=False)
CHECKED_BY_THE_PROGRAM = "(see palpate experiment power --help)"
REFUSED = [case for case in cases("power", refused=True)
           if CHECKED_BY_THE_PROGRAM not in case.stderr]


def answers_of(*options):
    parser = argparse.ArgumentParser()
    command.add_arguments(parser)
    study = prepare(parser.parse_args(options))
    request = study.request
    counts = simulate(study.contrasts, study.means, study.assumptions["noise"].to_numpy(),
                      request.participants, request.sets, request.seed)
    return Answers(study, counts)


@pytest.fixture(scope="module")
def answers(tmp_path_factory):
    """A function: the answers to a case."""

    @cache
    def of(case):
        folder = tmp_path_factory.mktemp(case.name)
        case.put_inputs(folder)
        with pytest.MonkeyPatch.context() as patch:
            patch.chdir(folder)
            return answers_of(*case.arguments[2:])

    return of


def without_counts(json_of_case):
    """Numbers of simulated data sets are replaced by their number; the oracle has no `answer`."""
    json_of_case.pop("answer", None)
    for assumption in json_of_case["assumptions"]:
        for test in assumption["tests"]:
            for key in ("people", "people_bounds", "significant"):
                test[key] = len(test[key])
    return json_of_case


def with_own_effects(lines, found):
    """Of given effects, the oracle says that they are published."""
    own = ("The numbers of people are for effects as large as those of --effect; smaller ones need "
           "more people.")
    old = ("Effects of a study that was published because they were significant are too large on "
           "average: numbers of people from them are a lower bound.")
    return [line.replace(old, own) for line in lines] if found.study.request.effect else lines


@pytest.mark.parametrize("case", MADE, ids=str)
def test_what_is_not_simulated_agrees_with_the_oracle(answers, case):
    found = answers(case)
    text = json_text(found.as_json(notes(found.study)))
    expected = case.json("power.json")
    expected["notes"] = with_own_effects(expected["notes"], found)
    keys = [list(expected[part] or {}) for part in ("settings", "pilot")]
    assert [list(json.loads(text)[part] or {}) for part in ("settings", "pilot")] == keys
    assert_agree(without_counts(json.loads(text)), without_counts(expected))


@pytest.mark.parametrize("case", MADE, ids=str)
def test_powers_agree_with_the_oracle(answers, case):
    found = answers(case)
    expected = np.array([[test["significant"] for test in assumption["tests"]]
                         for assumption in case.json("power.json")["assumptions"]])
    share = (found.counts + expected) / (2.0 * found.sets)
    errors = np.sqrt(2.0 * found.sets * np.maximum(share * (1.0 - share), 1.0 / found.sets))
    off = np.abs(found.counts - expected) / errors
    print(f"largest {off.max():.2f} standard errors, beyond three: {np.mean(off > 3.0):.2%}")
    assert np.mean(off > 3.0) <= 0.01
    assert off.max() < 4.5


@pytest.mark.parametrize("case", MADE, ids=str)
def test_the_answer_is_the_largest_number_of_its_effects(answers, case):
    found = answers(case)
    answer = json.loads(json_text(found.as_json([])))["answer"]
    effects = found.needed_people()
    effects = effects[(effects["correction"] != "Holm") & (effects["has_effect"] == 1)]
    corrected = effects.groupby(["error_from", "share_u", "share_w", "test"], sort=False).tail(1)
    if corrected.empty:
        assert answer["people"] is None and answer["tests"] == []
        assert answer_number(found) == "no number of people"
        return
    people = corrected["people_for_0.8"].astype(float).fillna(found.most + 1)
    of_models = corrected.assign(people=people.astype(int)).groupby(
        ["error_from", "share_u", "share_w"], sort=False)["people"].max()
    shown = [None if n > found.most else n for n in (of_models.min(), of_models.max())]
    assert answer["over_all_assumptions"] == shown
    assumption = answer["assumption"]
    at = tuple(assumption[key] if key == "error_from" else f"{assumption[key]:.6g}"
               for key in ("error_from", "share_u", "share_w"))
    people = of_models[at]
    assert answer["people"] == (None if people > found.most else people)
    assert answer_number(found) == (f"{people} people" if people <= found.most
                                    else f"more than {found.most} people")
    assert [test.split(", ")[0] for test in answer["tests"]] == list(dict.fromkeys(effects["test"]))


# A grid has one case that is named; what is given is used.
@pytest.mark.parametrize("options, source, shares, is_choice", [
    ([], "paper, F of Rotation", (0.3, 0.1), True),
    (["--measure=losses"], "paper, F of Haptic", (0.3, 0.1), True),
    (["--share-w=0.8"], "paper, F of Rotation", (0.1, 0.8), True),
    (["--share-u=0.8"], "paper, F of Rotation", (0.8, 0.1), True),
    (["--share-u=0.2", "--share-w=0.4"], "paper, F of Rotation", (0.2, 0.4), False),
    (["--error=9"], "--error", (0.3, 0.1), True),
])
def test_the_answer_names_its_assumption(options, source, shares, is_choice):
    found = answers_of(*options, "--sets=100", "--participants=4")
    row = found.study.assumptions.iloc[found.answer.model]
    assert (row["error_from"], (row["share_u"], row["share_w"])) == (source, shares)
    text = answer_rest(found)
    assert f"with the shares u {shares[0]} and w {shares[1]}" in text
    assert ("which are a choice" in text) == is_choice


def test_the_answer_is_that_of_the_larger_error():
    for measure in ("time", "losses", "penetration"):
        found = answers_of(f"--measure={measure}", "--share-u=0.3", "--share-w=0.1", "--sets=400")
        assert found.answer.model == found.by_noise[-1]
        assert found.answer.people == found.answer.most >= found.answer.least


def is_simulated(line):
    """Whether a line of the terminal has numbers of the simulation."""
    return line.startswith("  ") and ", " in line


@pytest.mark.parametrize("case", MADE, ids=str)
def test_the_text_for_the_terminal_is_the_oracles(answers, case):
    found = answers(case)
    answer, blank, *text = terminal_text(found, notes(found.study)).splitlines()
    assert answer == f"{answer_number(found)} {answer_rest(found)}" and not blank
    expected = case.stdout.splitlines()
    expected = with_own_effects(expected, found)
    assert expected.pop() == "report.html, power.json and 2 tables are in power/"  # by the program
    assert len(text) == len(expected)
    for line, other in zip(text, expected):
        if is_simulated(line):
            assert line.split("   ")[0].split(", ")[0] == other.split("   ")[0].split(", ")[0]
            assert line.count("no effect") == other.count("no effect")
        else:
            assert line.split() == other.split()  # the columns' widths follow the numbers


@pytest.mark.parametrize("case", MADE, ids=str)
def test_tables_have_the_oracles_rows(answers, case):
    found = answers(case)
    for name, table, simulated in (("needed_people", found.needed_people(), 7),
                                   ("power", found.curves(), 8)):
        text = csv_text(list(table), table.to_numpy().tolist())
        rows = list(csv.reader(io.StringIO(text)))
        expected = case.csv(f"{name}.csv")
        assert rows[0] == expected[0]
        assert_tables_agree(*([row[:simulated] for row in table] for table in (rows, expected)))


@pytest.mark.parametrize("case", REFUSED, ids=str)
def test_bad_options_and_pilots_are_refused_in_the_oracles_line(case, tmp_path, monkeypatch, capsys):
    case.put_inputs(tmp_path)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "out").mkdir()
    assert __main__.main(["power", *case.arguments[2:], "--out", "out"]) == 2
    assert capsys.readouterr() == ("", case.stderr)
    assert list((tmp_path / "out").iterdir()) == []


PAGES = [case for case in MADE if case.name in ("paper_time", "one_angle", "pilot_missing")]


@pytest.fixture(scope="module", params=PAGES, ids=str)
def page(request, answers):
    """A case, its answers, and its page."""
    found = answers(request.param)
    return request.param, found, page_of(found, notes(found.study))


def test_the_page_has_the_oracles_texts(page):
    case, found, html = page
    drawings = set(svg_texts(html))

    def plain_lines(document):
        return [line for line in visible_text(document) if " | " not in line]

    lines_here = plain_lines(html)
    assert lines_here[2] == "How many people"
    assert lines_here.pop(3) == f"{answer_number(found)} {answer_rest(found)}"
    lines_here = [line for line in lines_here if "restricted maximum likelihood" not in line]  # new
    sets = f"share of n = {found.sets} simulated data sets"
    lines_here = [line.replace(sets, "simulated share") for line in lines_here]
    assert lines_here == plain_lines(case.text("report.html").replace("`", ""))
    expected = tables_of(case.text("report.html"))
    for table, other in zip(tables_of(html), expected, strict=True):
        assert table[0] == other[0]
        assert [row[0] for row in table] == [row[0] for row in other]
        assert [["no effect" in cell for cell in row] for row in table] == [
            ["no effect" in cell for cell in row] for row in other]
    # Each panel has the title, the axes and the curves of its predecessor.
    ticks = {"0", "0.2", "0.4", "0.6", "0.8", "1", "5", "10", "15", "20", "30", "40", "50", "60"}
    ticks |= {str(n) for n in range(21)}
    assert set(svg_texts(case.text("report.html"))) - drawings <= ticks


def test_the_page_shows_what_the_terminal_shows(page):
    _, found, html = page
    answer, *_ = tables_of(html)
    assert [[cell.replace(" (", "(") for cell in row] for row in answer[1:]] == [
        [cell.replace(" (", "(") for cell in line] for line in lines(found)]
    text = visible_text(html)
    for name, value in facts(found):
        assert text[text.index(name) + 1] == value
    pairs = tables_of(html)[-1][1:] if found.study.pilot else []
    assert pairs == pilot_pairs(found.study)


# A curve is the power of its test; a band its interval.
def test_panels_have_the_simulated_powers(page):
    _, found, _ = page
    titles = [test.title for test in found.study.contrasts]
    for panel in figures.panels(found):
        assert set(panel.table["participants"]) == set(range(2, found.most + 1))
        assert ((panel.table["low"] <= panel.table["power"])
                & (panel.table["power"] <= panel.table["high"])).all()
    drawn = figures.drawn_assumptions(found)
    first = figures.panels(found)[0].table
    test = max(t for t, title in enumerate(titles) if title.startswith(figures.panels(found)[0].title
                                                                       + ","))
    solid = first[~first["is_dashed"] & (first["colour"] == 0)]
    assert solid["power"].tolist() == found.share[drawn[0], test].tolist()
    axes = figures.draw(figures.panels(found)[0]).axes[0]
    assert axes.get_xlabel() == "number of people" and axes.get_ylabel() == "power"
    assert any(np.array_equal(line.get_ydata(), solid["power"]) for line in axes.lines)


# A number and its bounds, from the counts: the interval of a share contains 0.8 just where
# (count / sets - 0.8)^2 <= z^2 0.8 0.2 / sets.
def test_the_smallest_number_has_the_bounds_of_its_interval():
    found = answers_of("--measure=angle", "--effect=UaH-NoR=36, UaH-R=32", "--sets=200",
                       "--participants=12")
    text = terminal_text(found, notes(found.study))
    assert "36 combinations with the error, all with the same noise" in text
    assumptions = json.loads(json_text(found.as_json([])))["assumptions"]
    test = assumptions[7]["tests"][0]
    assert test == assumptions[30]["tests"][0]
    bound = 1.959963984540054 * np.sqrt(0.8 * 0.2 / 200.0)
    low = high = number = 0
    for n in range(12, 1, -1):
        above = test["significant"][n - 2] / 200.0 - 0.8
        low = n if above >= -bound and low == (0 if n == 12 else n + 1) else low
        number = n if above >= 0.0 and number == (0 if n == 12 else n + 1) else number
        high = n if above >= bound and high == (0 if n == 12 else n + 1) else high
    assert 2 < low < number
    assert test["people"]["0.8"] == number
    assert test["people_bounds"]["0.8"] == [low, high or None]
    assert f"{number} ({low} to {high or '>12'})" in text


# A set is a count, so that a power of 200 sets has three decimals.
def test_curves_have_exact_powers_and_few_digits():
    found = answers_of("--measure=angle", "--sets=200", "--participants=12")
    table = found.curves()
    rows = list(csv.reader(io.StringIO(csv_text(list(table), table.to_numpy().tolist()))))[1:]
    assert len(rows) == 36 * 2 * 11
    for row in rows:
        assert float(row[9]) == int(row[8]) / 200.0
        assert len(row[9]) <= 5
        for column in (1, 2, 3, 10, 11):
            digits = row[column].split("e")[0]
            assert sum(digit in "123456789" for digit in digits) <= 6


def test_the_angle_has_the_two_conditions_of_uah():
    found = answers_of("--measure=angle", "--effect=UaH-R=32,UaH-NoR=49", "--sets=200")
    text = terminal_text(found, notes(found.study))
    assert "UaH-NoR 49, UaH-R 32 deg\n" in text
    assert "Haptic, " not in text


def test_names_of_a_file_are_shown_as_text(tmp_path):
    case = next(case for case in MADE if case.name == "pilot_without_a_person")
    case.put_inputs(tmp_path)
    path = tmp_path / "<img src=x>$a_b$.csv"
    (tmp_path / "pilot.csv").rename(path)
    rows = list(csv.reader(path.read_text().splitlines()))
    place = rows[0].index("participant")
    left_out = answers_of(f"--pilot={path}", "--sets=100").study.pilot.left_out[0]
    for row in rows:
        row[place] = "<b>&amp;</b>" if row[place] == left_out else row[place]
    path.write_text("".join(",".join(row) + "\n" for row in rows))
    found = answers_of(f"--pilot={path}", "--sets=100", "--participants=3")
    html = page_of(found, notes(found.study))
    assert "<img" not in html and "<b>&amp;" not in html
    assert any("<img src=x>$a_b$.csv: " in line for line in visible_text(html))
    assert any("completed trial of theirs: <b>&amp;</b>." in line for line in visible_text(html))


def test_the_same_request_gives_the_same_bytes():
    texts = []
    for jobs in ("1", "2", "3"):
        found = answers_of("--measure=angle", "--share-u=0.3", "--share-w=0.1", "--trials=4",
                           "--sets=600", "--participants=8", f"--jobs={jobs}")
        sentences = notes(found.study)
        texts.append((page_of(found, sentences), json_text(found.as_json(sentences)),
                      terminal_text(found, sentences)))
    assert texts[0] == texts[1] == texts[2]
