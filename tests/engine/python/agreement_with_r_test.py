"""The statistics agree with R 4.2 (r/constants.R wrote r/constants.json): to 1e-8; effects of mixed
models to 1e-4 and their variances to 1e-3, because the optimisers differ."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import statsmodels.api as sm
import statsmodels.formula.api as smf
from scipy import stats

from palpate.analysis import statistics as st

HERE = Path(__file__).resolve().parent
R: dict[str, Any] = json.loads((HERE / "r" / "constants.json").read_text())
FACTORS = ("haptic", "rotation", "object", "block")
RELATIVE = 1e-8


def equal(expected: float, relative: float = RELATIVE, unit: float = 0.0) -> Any:
    return pytest.approx(expected, rel=relative, abs=unit)


def in_order(frame: pd.DataFrame, columns: Sequence[str]) -> pd.DataFrame:
    """Levels in the order of their first rows, as in constants.R."""
    for column in columns:
        frame[column] = pd.Categorical(frame[column], categories=frame[column].unique())
    return frame


def trials(name: str) -> pd.DataFrame:
    return in_order(pd.read_csv(HERE / "r" / f"trials_{name}.csv"), ("person", *FACTORS))


def public(name: str) -> pd.DataFrame:
    return pd.read_csv(HERE / "data" / f"{name}.csv")


@pytest.fixture(scope="module")
def balanced() -> pd.DataFrame:
    return trials("balanced")


@pytest.fixture(scope="module")
def unbalanced() -> pd.DataFrame:
    return trials("unbalanced")


# --- Repeated measures

def repeated(name: str) -> pd.DataFrame:
    if name == "rm_anova2":
        frame = in_order(public(name), ("Time", "Metric"))
        return st.repeated_measures(frame, ["Time", "Metric"], "Performance", "Subject")
    response = {"balanced_time": "time_s", "balanced_depth": "depth_dm"}[name]
    return st.repeated_measures(trials("balanced"), ["haptic", "rotation"], response, "person")


@pytest.mark.parametrize("name", R["repeated"])
def test_repeated_measures_agree(name: str) -> None:
    found = repeated(name).set_index("term")
    for effect, expected in R["repeated"][name].items():
        row = found.loc[[tuple(effect.split(":"))]].iloc[0]
        for key, value in expected.items():
            size = row["ss"] / (row["ss"] + row["error_ss"]) if key == "partial_eta2" else row[key]
            assert size == equal(value), f"{effect}, {key}"


# --- Type III, MANOVA and counts

TYPE_THREE = {"warpbreaks": ("breaks", ("wool", "tension")), "unbalanced_time": ("time_s", FACTORS),
              "unbalanced_depth": ("depth_dm", FACTORS)}


@pytest.mark.parametrize("name", R["type_three"])
def test_type_three_agrees(name: str) -> None:
    response, factors = TYPE_THREE[name]
    frame = trials("unbalanced") if name != "warpbreaks" else in_order(
        public(name).drop([0, 1, 29]).reset_index(drop=True), factors)
    fit = st.Design(frame, factors).fit(frame[[response]])
    expected = R["type_three"][name]
    assert fit.error_df == expected["error_df"]
    assert fit.mean_square_error() == equal(expected["mean_square_error"])
    assert len(fit.term_parts) == len(expected["effects"])
    for effect, numbers in expected["effects"].items():
        term = tuple(effect.split(":"))
        found = fit.effect(term)
        assert found.df1 == numbers["df"]
        assert fit.term_sscp(term)[0, 0] == equal(numbers["ss"])
        assert (found.f, found.p) == (equal(numbers["f"]), equal(numbers["p"]))


def test_manova_agrees(balanced: pd.DataFrame) -> None:
    fit = st.Design(balanced, FACTORS).fit(balanced[["time_s", "losses", "depth_dm"]])
    assert len(R["wilks"]["balanced"]) == len(fit.term_parts) == 15
    for effect, expected in R["wilks"]["balanced"].items():
        found = fit.wilks(tuple(effect.split(":")))
        assert found.wilks_lambda == equal(expected["lambda"])
        for key in ("f", "df1", "df2", "p"):
            assert getattr(found, key) == equal(expected[key]), f"{effect}, {key}"


def sums(*factors: str) -> str:
    return " * ".join(f"C({factor}, Sum)" for factor in factors)


def has_values(found: Sequence[float], expected: Mapping[str, float], relative: float = RELATIVE,
               unit: float = 1e-10) -> None:
    """In the order of R. unit: of effects that are 0, such as those of a balanced design."""
    assert len(found) == len(expected)
    for value, (name, number) in zip(found, expected.items()):
        assert value == equal(number, relative, unit), name


@pytest.mark.parametrize("name", R["counts"])
def test_counts_with_time_as_exposure_agree(name: str) -> None:
    frame, expected = trials(name.split("_")[0]), R["counts"][name]
    people = "C(person, Sum) + " if name.endswith("people") else ""

    def fitted(terms: str) -> Any:
        model = smf.glm("losses ~ " + people + terms, frame, family=sm.families.Poisson(),
                        offset=np.log(frame["time_s"]))
        return model.fit(tol=1e-13, maxiter=100)

    fit, without = fitted(sums("haptic", "rotation")), fitted("C(haptic, Sum) + C(rotation, Sum)")
    has_values(fit.params, expected["coefficients"])
    has_values(fit.bse, expected["standard_errors"])
    assert fit.deviance == equal(expected["deviance"])
    assert fit.df_resid == expected["df"]
    assert fit.pearson_chi2 == equal(expected["pearson_chi2"])
    ratio = without.deviance - fit.deviance
    assert ratio == equal(expected["lrt"])
    assert stats.chi2.sf(ratio, without.df_resid - fit.df_resid) == equal(expected["lrt_p"])


# --- Mixed models

@pytest.mark.parametrize("name", R["mixed"])
def test_mixed_models_agree(name: str) -> None:
    frame, expected = trials(name.split("_")[0]), R["mixed"][name]
    frame["condition"] = frame["haptic"].astype(str) + frame["rotation"].astype(str)
    model = smf.mixedlm(f"time_s ~ {sums('haptic', 'rotation')} + C(object, Sum) + C(block, Sum)",
                        frame,
                        groups="person", re_formula="1",
                        vc_formula={"condition": "0 + C(condition)"})
    fit = model.fit(reml=True, method=["lbfgs"])
    has_values(fit.fe_params, expected["fixed"], 1e-4, 1e-6)
    has_values(fit.bse_fe, expected["standard_errors"],
               5e-3)  # of the joint Hessian, not given the variances
    assert fit.cov_re.iloc[0, 0] == equal(expected["variance_person"], 1e-3)
    assert fit.vcomp[0] == equal(expected["variance_condition"], 1e-3)
    assert fit.scale == equal(expected["variance_residual"], 1e-3)
    assert fit.llf == equal(expected["log_likelihood"], 1e-6)


# --- Pairs

@pytest.mark.parametrize("expected", R["pairs"],
                         ids=lambda pair: f"{pair['first']}-{pair['second']}")
def test_pairs_agree(balanced: pd.DataFrame, expected: dict[str, Any]) -> None:
    means = balanced.pivot_table("time_s", "person", "haptic", observed=True)
    first, second, margin = (expected[key] for key in ("first", "second", "margin"))
    found = st.paired_t(means[first], means[second])
    for key in ("difference", "t", "df", "p", "half_width"):
        assert getattr(found, key) == equal(expected[key]), key
    # Two one-sided tests, and the effect size with the interval of its noncentrality.
    n, error = found.pairs, found.difference / found.t
    above, below = ((found.difference + side * margin) / error for side in (1, -1))
    assert stats.t.sf(above, n - 1) == equal(expected["p_above"])
    assert stats.t.cdf(below, n - 1) == equal(expected["p_below"])
    half = st.t_for_coverage(n - 1, 0.9) * error
    assert found.difference - half == equal(expected["low_90"])
    assert found.difference + half == equal(expected["high_90"])
    assert found.t / np.sqrt(n) == equal(expected["d_z"])
    for key, tail in (("d_z_low", 0.975), ("d_z_high", 0.025)):
        assert stats.nct.cdf(found.t, n - 1, expected[key] * np.sqrt(n)) == equal(tail), key


def test_holm_agrees() -> None:
    assert st.holm([pair["p"] for pair in R["pairs"]]) == equal(R["holm"])


# --- Power, effect sizes and shares

NONCENTRAL = 1e-9  # by which R's own distributions with a noncentrality are wrong (pnbeta.c)


@pytest.mark.parametrize("given", R["power_of_t"], ids=lambda given: f"n={given['n']}")
def test_power_of_the_paired_t_agrees(given: dict[str, Any]) -> None:
    n, shift = given["n"], given["delta"] / given["sd"] * np.sqrt(given["n"])
    t = st.t_for_coverage(n - 1)
    with np.errstate(divide="ignore"):  # SciPy takes the logarithm of 0 for a power near 1
        found = stats.nct.sf(t, n - 1, shift) + stats.nct.cdf(-t, n - 1, shift)
    assert found == equal(given["power"], unit=NONCENTRAL)


@pytest.mark.parametrize("given", R["power_of_f"],
                         ids=lambda given: f"{given['df1']}, {given['df2']}")
def test_power_of_f_agrees(given: dict[str, Any]) -> None:
    df1, df2 = given["df1"], given["df2"]
    f, ncp = st.f_for_tail(0.05, df1, df2), given["ncp"]
    # SciPy 1.10 has a probability of -0.95 without a noncentrality.
    found = stats.ncf.sf(f, df1, df2, ncp) if ncp > 0 else st.f_tail(f, df1, df2)
    assert found == equal(given["power"], unit=NONCENTRAL)


@pytest.mark.parametrize("given", R["eta2_intervals"], ids=lambda given: f"F = {given['f']:.3g}")
def test_intervals_of_partial_eta2_agree(given: dict[str, Any]) -> None:
    f, df1, df2 = given["f"], given["df1"], given["df2"]
    for key, tail in (("low", 0.95), ("high", 0.05)):
        ncp = given[key] / (1 - given[key]) * (df1 + df2 + 1)
        if ncp > 0:
            assert stats.ncf.cdf(f, df1, df2, ncp) == equal(tail, unit=NONCENTRAL), key
        else:
            assert 1.0 - st.f_tail(f, df1, df2) < tail, key


@pytest.mark.parametrize("given", R["shares"],
                         ids=lambda given: f"{given['count']} of {given['all']}")
def test_intervals_of_shares_agree(given: dict[str, Any]) -> None:
    count, all_ = given["count"], given["all"]
    low, high = st.wilson(count, all_)
    assert (low, high) == (equal(given["wilson_low"], unit=1e-12), equal(given["wilson_high"]))
    low, high = st.clopper_pearson(count, all_)
    assert (low, high) == (equal(given["exact_low"]), equal(given["exact_high"]))
