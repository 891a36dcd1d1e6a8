"""The statistics on made data sets and at extreme arguments, against what the C++ computed
(oracle/README.md)."""

from __future__ import annotations

import json
from math import nan
from typing import Any

import numpy as np
import pandas as pd
import pytest

from numbers_agree import Zero, assert_agree
from oracle_cases import ORACLE
from palpate.analysis import statistics as st


def tree(name: str) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((ORACLE / "statistics" / f"{name}.json").read_text())
    return found


INPUT, EXPECTED = tree("input"), tree("expected")


def plain(value: Any) -> Any:
    """A number as JSON has it: null for NaN."""
    value = value.item() if isinstance(value, (np.generic, np.ndarray)) else value
    return None if isinstance(value, float) and value != value else value


def members(found: Any, names: str) -> dict[str, Any]:
    return {name: plain(getattr(found, name)) for name in names.split()}


REPEATED_ZEROS = [Zero("$.effects[[]*].error_ss", 1e-25, "the differences are equal"),
                  Zero("$.participants_ss", 1e-25, "all values are equal"),
                  Zero("$.effects[[]*].ss", 1e-25, "all values are equal")]
P_ZEROS = [Zero("*.p", 1e-300, "C++ has 0 for probabilities below the normal numbers")]


@pytest.mark.parametrize("name", INPUT["repeated"])
def test_repeated_measures_are_those_of_the_oracle(name: str) -> None:
    given, expected = INPUT["repeated"][name], EXPECTED["repeated"][name]
    levels = {f"f{i}": k for i, k in enumerate(given["levels"])}
    found = st.repeated_measures_of(given["table"], levels)
    effects = [{"term": [int(f[1:]) for f in e.term],
                **members(e, "ss error_ss f df1 df2 p epsilon p_gg generalized_eta2")}
               for e in found.effects]
    widths = [plain(width) for width in st.cousineau_morey(given["table"])]
    assert_agree({"participants_ss": plain(found.participants_ss), "effects": effects,
                  "cousineau_morey": widths}, expected, REPEATED_ZEROS, name)


@pytest.mark.parametrize("name", INPUT["factorial"])
def test_factorial_models_are_those_of_the_oracle(name: str) -> None:
    given, expected = INPUT["factorial"][name], EXPECTED["factorial"][name]
    factors = [f"f{i}" for i in range(len(given["levels"]))]
    frame = pd.DataFrame(given["rows"], columns=factors)
    terms = [tuple(factors[i] for i in term) for term in given["terms"]] or None
    y = np.array(given["responses"])
    design = st.Design(frame, factors, terms)
    fit = design.fit(y)
    singular = fit.singular_response()
    found = []
    for term in design.terms:
        responses = []
        for k in range(y.shape[1]):
            ss = float(fit.term_sscp(term)[k, k])
            responses.append({**members(fit.effect(term, k), "f df1 df2 p partial_eta2"), "ss": ss})
        wilks = None
        if singular is None:
            test = fit.wilks(term)
            wilks = {"lambda": plain(test.wilks_lambda), **members(test, "f df1 df2 p")}
        found.append({"term": [factors.index(f) for f in term],
                      "df": fit.term_parts[term].shape[-2],
                      "responses": responses, "wilks": wilks})
    errors = [plain(fit.mean_square_error(k)) for k in range(y.shape[1])]
    assert_agree({"error_df": fit.error_df, "mean_square_error": errors,
                  "singular_response": singular,
                  "terms": found}, expected, what=name)


@pytest.mark.parametrize("name", INPUT["pairs"])
def test_paired_t_and_intervals_are_those_of_the_oracle(name: str) -> None:
    a, b = INPUT["pairs"][name]["a"], INPUT["pairs"][name]["b"]
    interval = st.mean_interval(a)
    found = {"paired_t": members(st.paired_t(a, b), "pairs difference t df p half_width"),
             "mean_interval_of_a": {**members(interval, "mean half_width count"),
                                    "excludes_zero": bool(interval.excludes_zero())}}
    assert_agree(found, EXPECTED["pairs"][name], what=name)


# Quantiles of SciPy lose digits far outside what the pages use: tails of 0.05, coverages of 0.95.
QUANTILES = ("f_for_tail", "t_for_coverage", "z_for_coverage")


def is_used(share: float) -> bool:
    return 1e-6 <= share <= 1 - 1e-6


FUNCTIONS = {
    "f_upper_tail": st.f_tail, "f_for_tail": st.f_for_tail, "t_two_sided": st.t_two_sided,
    "t_for_coverage": lambda coverage, df: st.t_for_coverage(df, coverage),
    "z_for_coverage": st.z_for_coverage}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_distributions_are_those_of_the_oracle(name: str) -> None:
    kind = "p" if name in ("f_upper_tail", "t_two_sided") else "x"
    used = [(given, value) for given, value in zip(INPUT[name], EXPECTED[name])
            if name not in QUANTILES or is_used(given[0])]
    found = [{kind: plain(FUNCTIONS[name](*given))} for given, _ in used]
    assert_agree(found, [{kind: value} for _, value in used], P_ZEROS, name)


def test_wilsons_intervals_are_those_of_the_oracle() -> None:
    found = [[plain(end) for end in st.wilson(*arguments)] for arguments in INPUT["wilson"]]
    assert_agree(found, EXPECTED["wilson"])


def test_adjusted_p_values_are_those_of_the_oracle() -> None:
    found = [[plain(p) for p in st.holm([nan if p is None else p for p in ps]).tolist()]
             for ps in INPUT["holm"]]
    assert_agree(found, EXPECTED["holm"])


def test_least_significant_differences_are_those_of_the_oracle() -> None:
    found = []
    for given in INPUT["plsd"]:
        pairs = st.fisher_plsd(pd.Series(given["means"]), pd.Series(given["counts"]), given["mse"],
                               given["df"])
        found.append(pairs.to_dict("records"))
    assert_agree(found, EXPECTED["plsd"])


def test_raos_f_is_that_of_the_oracle() -> None:
    found = [{name: plain(value) for name,
              value in vars(st.rao(*arguments)).items() if name != "wilks_lambda"}
             for arguments in INPUT["rao"]]
    expected = [dict(zip(("f", "df1", "df2", "p"), values)) for values in EXPECTED["rao"]]
    assert_agree(found, expected, P_ZEROS)
