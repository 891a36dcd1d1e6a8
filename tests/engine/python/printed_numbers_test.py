"""Numbers print the same digits whatever the last bits of a sum are."""

from __future__ import annotations

import numpy as np
import pytest

from palpate.analysis.numbers import csv_text, json_line, p_number, short_number, with_decimals

# Decimal fractions half way between two printed numbers.
SHORT = [0.09375, 1.875, 18.75, 187.5, 0.001235, 0.1045]
LONG = [20.364433615, 15.969259325, 0.48129039925]


def beside(value: float) -> list[float]:
    """Numbers that differ from this one by the rounding of a sum."""
    return [value * (1.0 + n * np.finfo(float).eps) for n in (-200, -1, 0, 1, 200)]


@pytest.mark.parametrize("value", SHORT)
@pytest.mark.parametrize("text", [short_number, p_number, lambda v: with_decimals(v, 3)])
def test_rounding_does_not_decide_a_tie_for_readers(value, text):
    assert len({text(each) for each in beside(value)}) == 1


@pytest.mark.parametrize("value", LONG)
def test_rounding_does_not_decide_a_tie_in_results(value):
    assert len({json_line(each) for each in beside(value)}) == 1
    assert len({csv_text(["x"], [[each]]) for each in beside(value)}) == 1


def test_numbers_without_a_value_are_texts():
    assert (short_number(np.inf), short_number(-np.inf), short_number(0.0)) == (
        "unbounded", "none", "0")
    assert (with_decimals(np.nan, 2), json_line(np.nan)) == ("-", "null")
