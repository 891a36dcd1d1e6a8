"""The helpers of the oracle: a changed digit is found, and its place is named."""

from __future__ import annotations

import copy
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent))
from numbers_agree import (  # noqa: E402
    Zero, assert_agree, assert_tables_agree, differences, is_p_value, numbers_in, table_differences)
from oracle_cases import ORACLE, Case, cases, table_of  # noqa: E402
from page_text import svg_texts, tables_of, visible_text, without_drawings  # noqa: E402
from sample_trials import SeededRandom, sample_trials, trials_csv  # noqa: E402

TREE = {"effects": [{"effect": "Haptic", "f": 12.25, "p": 3e-4},
                    {"effect": "Trial", "f": None, "p": 4e-20}],
        "n": 10, "simulated": True}


def changed(*path: str | int, to: object) -> object:
    tree = copy.deepcopy(TREE)
    place = tree
    for key in path[:-1]:
        place = place[key]  # type: ignore[index]
    place[path[-1]] = to  # type: ignore[index]
    return tree


@pytest.mark.parametrize("path, to, told", [
    (("effects", 0, "f"), 12.25 * (1 + 2e-9), "$.effects[0].f: is 12.250000024"),
    (("effects", 0, "p"), 3e-4 * (1 + 2e-9), "$.effects[0].p: "),
    (("effects", 1, "p"), 4e-20 * (1 + 2e-6), "$.effects[1].p: "),
    (("effects", 1, "f"), 0.0, "$.effects[1].f: is 0.0; expected None"),
    (("effects", 0, "effect"), "Haptic ", "$.effects[0].effect: is 'Haptic '; expected 'Haptic'"),
    (("effects", 0, "f"), float("nan"), "$.effects[0].f: is nan"),
    (("simulated",), 1, "$.simulated: is 1; expected True"),
    (("n",), "10", "$.n: is '10'; expected 10"),
    (("more",), 1, "$.more: is not expected"),
    (("effects",), TREE["effects"][:1], "$.effects: has 1 elements; expected 2"),
    # type: ignore[index]
])
def test_a_difference_is_found_with_its_place(path: tuple[str | int, ...], to: object,
                                              told: str) -> None:
    found = list(differences(changed(*path, to=to), TREE))
    assert len(found) == 1 and found[0].startswith(told), found
    with pytest.raises(AssertionError, match="1 differences"):
        assert_agree(changed(*path, to=to), TREE)


@pytest.mark.parametrize("path, to", [
    (("effects", 0, "f"), 12.25 * (1 + 0.5e-9)), (("effects", 1, "p"), 4e-20 * (1 + 0.5e-6)),
    (("n",), 10.0)])
def test_what_agrees_within_the_tolerance_is_no_difference(path: tuple[str | int, ...],
                                                           to: object) -> None:
    assert_agree(changed(*path, to=to), TREE)


def test_rounding_is_0_only_where_a_rule_says_so() -> None:
    found, expected = {"f": 3e-17, "g": 3e-17}, {"f": 0, "g": 0}
    rule = Zero("$.f", 1e-15, "the response is constant")
    assert [line.split(":")[0] for line in differences(found, expected, [rule])] == ["$.g"]
    assert len(list(differences({"f": 2e-15, "g": 0}, expected, [rule]))) == 1


TABLE = [["effect", "f", "p_holm"], ["Haptic", "12.25", "1e-20"], ["Trial", "", "0.5"]]


@pytest.mark.parametrize("line, column, to, told", [
    (1, 1, "12.2500001", "line 2, column f: is 12.2500001; expected 12.25"),
    (1, 2, "1.00001e-20", "line 2, column p_holm: "),
    (2, 1, "0", "line 3, column f: is '0'; expected ''"),
    (2, 0, "trial", "line 3, column effect: "),
    (0, 0, "Effect", "line 1: is [["),
])
def test_a_difference_of_tables_is_found_with_its_place(line: int, column: int, to: str,
                                                        told: str) -> None:
    table = copy.deepcopy(TABLE)
    table[line][column] = to
    found = list(table_differences(table, TABLE))
    assert len(found) == 1 and found[0].startswith(told), found
    with pytest.raises(AssertionError, match="1 differences"):
        assert_tables_agree(table, TABLE)
    assert list(table_differences(TABLE[:2], TABLE)) == ["has 2 lines; expected 3"]


def test_p_values_are_known_by_their_names() -> None:
    assert all(map(is_p_value, ("p", "gg_p", "p_holm", "paper_p")))
    assert not any(map(is_p_value, ("participants", "power", "gg_epsilon", "haptic")))


def test_numbers_of_a_text_keep_their_order() -> None:
    assert numbers_in("F(2, 18) = 0.433, p < .05; \u22120.30 s, 1e-7, P2") == [2, 18, 0.433, 0.05,
                                                                               -0.3, 1e-7]


PAGE = """<style>p {}</style><h1>A  page</h1><p>One <b>bold</b>&nbsp;word<br>and more</p>
<table><tr><th>n</th><th>p<br>(Holm)</th></tr><tr><td>3</td><td>&lt; 0.05</td></tr></table>
<svg aria-label="figure" width="3"><g><title>Time</title><text x="1">27 <tspan>s</tspan></text></g>
</svg>"""


def test_the_texts_of_a_page() -> None:
    assert visible_text(PAGE) == ["A page", "One bold word", "and more", "n | p / (Holm)",
                                  "3 | < 0.05"]
    assert tables_of(PAGE) == [[["n", "p / (Holm)"], ["3", "< 0.05"]]]
    assert svg_texts(PAGE) == ["Time", "27 s"]
    reduced = without_drawings(PAGE)
    assert "<svg aria-label=\"figure\">\n<text>Time</text>\n<text>27 s</text>\n</svg>" in reduced
    assert "p {}" not in reduced and visible_text(reduced) == visible_text(PAGE)


def test_random_numbers_are_those_of_the_standard_engine() -> None:
    random = SeededRandom(5489)
    last = [random.bits() for _ in range(10000)][-1]
    assert last == 9981545732273789042  # [rand.predef] of the C++ standard


@pytest.mark.parametrize("kind", sorted(path.parent.name for path in ORACLE.glob("*/index.json")))
def test_each_case_has_what_its_index_says(kind: str, tmp_path: Path) -> None:
    found = cases(kind)
    assert found
    for case in found:
        assert case.about and bool(case.results) == (case.exit_code != 2), str(case)
        assert case.exit_code != 2 or case.stderr.startswith("palpate: "), str(case)
        assert case.exit_code != 2 or case.stderr.count("\n") == 1, str(case)
        for name in case.results:
            if name.endswith(".csv"):
                assert len(case.csv(name)) >= 1
            elif name.endswith(".json"):
                case.json(name)
        for content in case.expected.values():
            assert b"/tmp/" not in content and b"/home/" not in content
    found[0].put_inputs(tmp_path)
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted({n.split("/")[0]
                                                                 for n in found[0].inputs})


def test_the_sample_of_the_oracle_is_that_of_the_function() -> None:
    committed = Case("analyse", "sample_people").inputs["trials.csv"].decode()
    assert_tables_agree(table_of(trials_csv(sample_trials())), table_of(committed))
