"""The statistics on public data sets, against results of R and pingouin, and against the
definitions on random data."""

from math import atan, ceil, floor, nan, pi, sqrt
from os import environ
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from palpate.analysis import statistics as st

DATA = Path(__file__).parent / "data"
RELATIVE = 1e-9


def equal(expected, half_unit=0.0):
    """Within 1e-9, and half a unit of the last printed digit."""
    return pytest.approx(expected, rel=0.0, abs=RELATIVE * abs(expected) + half_unit)


def data_set(name):
    frame = pd.read_csv(DATA / name)
    for column in frame.columns[frame.dtypes == object]:
        frame[column] = pd.Categorical(frame[column], categories=frame[column].unique())
    return frame


def random(seed):
    seed = int(environ.get("PALPATE_SEED", seed))
    print(f"PALPATE_SEED={seed}")
    return np.random.default_rng(seed)


def fit(frame, factors, responses, terms=None):
    return st.Design(frame, factors, terms).fit(frame[responses])


def test_wilks_of_iris_equals_r():
    data = data_set("iris.csv")
    widths = ["sepal_length", "sepal_width", "petal_length", "petal_width"]
    test = fit(data, ["species"], widths).wilks(("species",))
    assert test.wilks_lambda == equal(0.0234386306508782)
    assert test.f == equal(199.145343540085)
    assert (test.df1, test.df2) == pytest.approx((8.0, 288.0), rel=1e-15)


def test_wilks_of_pottery_equals_r():
    data = data_set("pottery.csv")
    test = fit(data, ["site"], ["Al", "Fe", "Mg", "Ca", "Na"]).wilks(("site",))
    assert test.wilks_lambda == equal(0.0123009058474734)
    assert test.f == equal(13.0885429044, 0.5e-10)
    assert test.df1 == 15.0
    assert test.df2 == equal(50.0914730996, 0.5e-10)


# R prints five digits. The second results are of the same data with another twelfth opacity, to
# more digits.
@pytest.mark.parametrize(
    ("opacity", "lambdas", "fs", "half_unit"),
    [
        (4.1, [0.38186, 0.52303, 0.77711], [7.5543, 4.2556, 1.3385], 0.5e-4),
        (
            4.2,
            [0.380969861242919, 0.524093054716922, 0.778885319368864],
            [7.58277125853, 4.23760448264, 1.32480159011],
            0.5e-11,
        ),
    ],
)
def test_wilks_of_plastic_film_equals_r(opacity, lambdas, fs, half_unit):
    data = data_set("plastic.csv")
    assert data.loc[11, "opacity"] == 4.1
    data.loc[11, "opacity"] = opacity
    found = fit(data, ["rate", "additive"], ["tear", "gloss", "opacity"])
    for term, lambda_, f in zip(st.all_terms(["rate", "additive"]), lambdas, fs):
        test = found.wilks(term)
        assert test.wilks_lambda == equal(lambda_, half_unit)
        assert test.f == equal(f, half_unit)
        assert (test.df1, test.df2) == pytest.approx((3.0, 14.0), rel=1e-15)


# The paper prints lambda with three digits: lambda +- 0.0005 must give an interval that holds its
# F.
@pytest.mark.parametrize(
    ("effect", "df", "lambda_", "low", "high", "f", "df2"),
    [
        ("Haptic", 2, 0.236, 227.46, 228.39, 228.207, 1292),
        ("Rotation", 1, 0.925, 17.34, 17.58, 17.486, 646),
        ("Object", 3, 0.110, 257.20, 258.80, 257.433, 1572.3),
        ("Trial", 2, 0.925, 8.50, 8.62, 8.590, 1292),
        ("Rotation x Haptic", 2, 0.911, 10.22, 10.33, 10.271, 1292),
        ("Object x Haptic", 6, 0.868, 5.19, 5.23, 5.227, 1827.6),
        ("Object x Rotation", 3, 0.934, 4.94, 5.01, 4.964, 1572.3),
    ],
)
def test_rao_intervals_hold_the_papers_f(effect, df, lambda_, low, high, f, df2):
    least, most = [st.rao(lambda_ + sign * 0.0005, 3, df, 648) for sign in (1, -1)]
    # The ends are rounded inwards to two decimals.
    assert ceil(100.0 * least.f) == round(100.0 * low)
    assert floor(100.0 * most.f) == round(100.0 * high)
    assert least.f < f < most.f
    assert least.df2 == pytest.approx(df2, abs=0.05)


def test_wilks_of_one_response_is_its_f():
    found = fit(data_set("warpbreaks.csv"), ["wool", "tension"], ["breaks"])
    for term in found.term_parts:
        assert found.wilks(term).f == equal(found.effect(term).f)


def test_error_matrix_of_a_constant_or_combined_response_is_singular():
    data = data_set("iris.csv")
    y = data[["sepal_length", "sepal_width", "petal_length"]].to_numpy()
    design = st.Design(data, ["species"])

    def singular():
        return design.fit(y).singular_response()

    assert singular() is None
    third = y[:, 2].copy()
    y[:, 2] = 0.3 * y[:, 0] - 1e3 * y[:, 1]
    assert singular() == 2
    y[:, 2] = third * 1e-12  # a small unit is no reason
    assert singular() is None
    y[:, 1] = 0.1
    assert singular() == 1
    y[:, 1] = np.where(np.arange(len(y)) < 50, 1.1, 2.3)
    assert singular() == 1  # constant within the cells


def test_factorial_model_of_npk_equals_r():
    data = data_set("npk.csv")
    data["block"] = data["block"].astype(str)
    terms = [("block",), ("N",), ("P",), ("K",), ("N", "P"), ("N", "K"), ("P", "K")]
    found = fit(data, ["block", "N", "P", "K"], ["yield"], terms)
    fs = [4.44666642680, 12.2587342137, 0.544129816860, 6.16568920232,
          1.37829669341, 2.14597200734, 0.0311949051919]  # fmt: skip
    for term, f in zip(terms, fs):
        assert found.effect(term).f == equal(f, 0.5e-12)
        assert found.effect(term).df1 == (5.0 if term == ("block",) else 1.0)
    assert found.error_df == 12
    assert found.error_sscp[0, 0] == equal(185.286666667, 0.5e-9)


def test_factorial_model_of_unbalanced_warpbreaks_is_type_three():
    data = data_set("warpbreaks.csv").drop([0, 1, 29])
    found = fit(data, ["wool", "tension"], ["breaks"])
    fs = [6.166046801923, 11.065533657595, 6.157905462486]
    for term, f in zip(found.term_parts, fs):
        assert found.effect(term).f == equal(f, 0.5e-12)
    assert found.error_df == 45
    assert found.error_sscp[0, 0] == equal(5031.636904762, 0.5e-9)


def residual_ss(x, y):
    return float(np.square(y - x @ np.linalg.lstsq(x, y, rcond=None)[0]).sum())


# The definition of type III on unbalanced random data: for two factors with two levels each, whose
# codes are 1 and -1, the columns of a term are left out of a regression.
def test_term_is_the_difference_to_the_model_without_it():
    rng = random(18001)
    for _ in range(50):
        rows = 12 + int(rng.integers(30))
        a, b = rng.integers(2, size=(2, rows))
        a[:4], b[:4] = [0, 1, 0, 1], [0, 0, 1, 1]  # the first four rows fill all cells
        y = 5.0 + a + 2.0 * a * b + rng.standard_normal(rows)
        x = np.column_stack([np.ones(rows), 1 - 2 * a, 1 - 2 * b, (1 - 2 * a) * (1 - 2 * b)])
        found = st.Design(pd.DataFrame({"a": a, "b": b}), ["a", "b"]).fit(y[:, None])
        error = residual_ss(x, y)
        assert found.error_sscp[0, 0] == equal(error)
        for column, term in enumerate(found.term_parts, start=1):
            without = residual_ss(np.delete(x, column, axis=1), y)
            assert found.term_sscp(term)[0, 0] == pytest.approx(
                without - error, rel=0.0, abs=1e-10 * error
            )


def test_empty_cell_is_refused():
    data = data_set("warpbreaks.csv").drop(range(9))  # wool A, tension L
    with pytest.raises(st.DesignError, match="determines 5 parameters; expected all 6"):
        st.Design(data, ["wool", "tension"])


def test_design_without_error_is_refused():
    with pytest.raises(st.DesignError):
        st.Design(pd.DataFrame({"a": [0, 1, 2]}), ["a"])


def test_constant_response_has_no_f():
    design = st.Design(pd.DataFrame({"a": [0, 0, 1, 1, 1]}), ["a"])
    assert np.isnan(design.fit(np.full((5, 1), 0.1)).effect(("a",)).f)


def test_fisher_plsd_of_plant_growth_equals_r():
    data = data_set("plant_growth.csv")
    found = fit(data, ["group"], ["weight"])
    assert found.effect(("group",)).f == equal(4.84608786238, 0.5e-11)
    means = data.groupby("group", sort=False, observed=True)["weight"].agg(["mean", "size"])
    pairs = st.fisher_plsd(
        means["mean"], means["size"], found.mean_square_error(), found.error_df
    )
    assert len(pairs) == 3
    ps = [0.194387880054, 0.0876816750627, 0.00445923593821]
    adjusted = [0.194387880054, 0.175363350125, 0.0133777078146]
    for pair, p_holm, p, expected in zip(pairs.itertuples(), st.holm(pairs["p"]), ps, adjusted):
        assert pair.p == equal(p, 0.5e-12)
        assert p_holm == equal(expected, 0.5e-12)
        assert pair.least_significant == equal(0.57201261156, 0.5e-11)


FIVE_BY_THREE = np.array([[1, 3, 4], [2, 2, 3], [2, 5, 6], [3, 4, 4], [3, 5, 6]], dtype=float)


def test_repeated_measures_of_the_small_example_are_known():
    [effect] = st.repeated_measures_of(FIVE_BY_THREE, {"a": 3}).effects
    assert effect.f == equal(13.5757575758, 0.5e-10)
    assert (effect.df1, effect.df2) == (2.0, 8.0)
    assert effect.epsilon == equal(0.575277337559, 0.5e-12)
    assert effect.p_gg == equal(0.0153706071352, 0.5e-13)


def test_paired_t_of_the_small_example_by_holm_are_equal():
    raw = [
        st.paired_t(FIVE_BY_THREE[:, i], FIVE_BY_THREE[:, j]).p for i, j in [(0, 1), (0, 2), (1, 2)]
    ]
    for p in st.holm(raw):
        assert p == equal(0.0483902697003, 0.5e-13)


def test_cousineau_morey_of_the_small_example_is_known():
    half = st.cousineau_morey(FIVE_BY_THREE)
    for found, expected in zip(half, [1.241663998204, 0.555289021040, 0.832933531559]):
        assert found == equal(expected, 0.5e-12)


def test_repeated_measures_of_one_factor_equal_pingouin():
    data = data_set("rm_anova_wide.csv").reset_index()
    long = data.melt("index", ["Before", "1 week", "2 week", "3 week"], "week", "value")
    effect = st.repeated_measures(long, ["week"], "value", "index").loc["week"]
    assert effect.participants == 9  # those who are complete
    assert effect.f == equal(5.20065155118, 0.5e-11)
    assert (effect.df1, effect.df2) == (3.0, 24.0)
    assert effect.epsilon == equal(0.694329331302, 0.5e-12)


def test_repeated_measures_of_two_factors_equal_pingouin():
    data = data_set("rm_anova2.csv")
    effects = st.repeated_measures(data, ["Time", "Metric"], "Performance", "Subject")
    assert list(effects.index) == ["Time", "Metric", "Metric x Time"]
    assert (effects.participants == 10).all()
    time, metric, both = effects.itertuples()
    assert time.f == equal(33.8522804629, 0.5e-10)
    assert time.df2 == 9.0
    assert time.epsilon == pytest.approx(1.0, rel=1e-15)
    assert metric.f == equal(26.9591896438, 0.5e-10)
    assert (metric.df1, metric.df2) == (2.0, 18.0)
    assert metric.epsilon == equal(0.9691029585, 0.5e-10)
    assert both.f == equal(12.6322701689, 0.5e-10)
    assert both.epsilon == equal(0.7271664202, 0.5e-10)
    assert time.generalized_eta2 == equal(0.254010981995, 0.5e-12)
    assert metric.generalized_eta2 == equal(0.359334971048, 0.5e-12)
    assert both.generalized_eta2 == equal(0.0844199809419, 0.5e-13)


def test_repeated_measures_of_fewer_than_two_complete_people_are_nan():
    data = pd.DataFrame({"who": [1, 1, 2], "a": ["x", "y", "x"], "v": [1.0, 2.0, 3.0]})
    [effect] = st.repeated_measures(data, ["a"], "v", "who").itertuples()
    assert effect.participants == 1
    assert np.isnan(effect.f)


def test_sums_of_squares_add_up_to_the_total():
    table = 1e3 + random(18002).standard_normal((20, 7, 24))
    result = st.repeated_measures_of(table, {"a": 4, "b": 2, "c": 3})
    total = np.square(table - table.mean(axis=(1, 2), keepdims=True)).sum(axis=(1, 2))
    found = result.participants_ss + sum(e.ss + e.error_ss for e in result.effects)
    np.testing.assert_allclose(found, total, rtol=1e-9)


def test_paired_t_of_equal_means_is_0_without_rounding_noise():
    a = [0.1 + 0.2, 1.0, 2.0]
    assert st.paired_t(a, [0.3, 1.0, 2.0]).difference == 0.0
    assert st.paired_t([1.3, 0.7, 1.1], [0.7, 1.1, 1.3]).t == 0.0


# The ends of the interval are the noncentralities with which t has a tail of 2.5 %.
def test_standardized_difference_has_the_interval_of_the_noncentral_t():
    from scipy.stats import nct

    test = st.paired_t(FIVE_BY_THREE[:, 1], FIVE_BY_THREE[:, 0])
    d, low, high = st.standardized(test)
    assert d == pytest.approx(test.t / sqrt(5), rel=1e-4)
    assert nct.sf(test.t, 4, low * sqrt(5)) == pytest.approx(0.025, rel=1e-3)
    assert nct.cdf(test.t, 4, high * sqrt(5)) == pytest.approx(0.025, rel=1e-3)
    assert np.isnan(st.standardized(st.paired_t([1.0], [2.0]))).all()


# One factor of two levels: F is the square of the paired t.
def test_repeated_measures_of_two_levels_are_the_paired_t():
    table = random(18003).standard_normal((9, 2))
    [effect] = st.repeated_measures_of(table, {"a": 2}).effects
    test = st.paired_t(table[:, 0], table[:, 1])
    assert effect.f == equal(test.t**2)
    assert effect.p == equal(test.p)


def test_equal_differences_have_no_f():
    table = [[0.1, 0.4], [1.1, 1.4], [7.1, 7.4]]
    [effect] = st.repeated_measures_of(table, {"a": 2}).effects
    assert np.isnan([effect.f, effect.p, effect.epsilon, effect.p_gg]).all()
    test = st.paired_t(*np.transpose(table))
    assert (test.pairs, test.difference) == (3, pytest.approx(-0.3))
    assert np.isnan([test.t, test.p, test.half_width]).all()


def test_effect_of_0_has_f_0_without_rounding_noise():
    table = np.array([[0.1, 0.3, 0.1, 0.3], [0.7, 0.2, 0.2, 0.7]]) + 1e3
    a, b, _ = st.repeated_measures_of(table, {"a": 2, "b": 2}).effects
    assert a.ss == 0.0
    frame = pd.DataFrame({"a": [0, 0, 1, 1, 2, 2]})
    found = st.Design(frame, ["a"]).fit(np.array([[0.1, 0.7] * 3]).T)
    assert (found.effect(("a",)).f, found.effect(("a",)).p) == (0.0, 1.0)


def test_holm_leaves_out_what_is_not_tested():
    adjusted = st.holm([0.01, nan, 0.04])
    assert adjusted[0] == pytest.approx(0.02, rel=1e-15)
    assert np.isnan(adjusted[1])
    assert adjusted[2] == pytest.approx(0.04, rel=1e-15)
    assert st.holm([0.9, 0.8])[0] == 1.0


# The ends solve (share - p)^2 = z^2 p (1 - p) / n.
def test_ends_of_wilson_solve_their_equation():
    z = st.z_for_coverage(0.95)
    assert z == equal(1.959963984540054)
    for count, n in [(1, 10), (3, 30), (29, 30)]:
        low, high = st.wilson(count, n)
        share = count / n
        for p in (low, high):
            assert (share - p) ** 2 == pytest.approx(z * z * p * (1.0 - p) / n, abs=1e-14)
        assert low < share < high
    assert st.wilson(0, 30)[0] == 0.0
    assert st.wilson(30, 30)[1] == 1.0
    assert st.wilson(0, 30)[1] == equal(z * z / (30.0 + z * z))
    assert st.wilson(0, 0) == (0.0, 1.0)


def binomial_tail(k, n, p):
    """P(at least k of n)."""
    from math import comb

    return sum(comb(n, i) * p**i * (1.0 - p) ** (n - i) for i in range(k, n + 1))


def test_ends_of_clopper_pearson_have_tails_of_a_fortieth():
    for count, n in [(0, 7), (1, 10), (3, 30), (30, 30)]:
        low, high = st.clopper_pearson(count, n)
        assert low == 0.0 if count == 0 else binomial_tail(count, n, low) == equal(0.025)
        assert high == 1.0 if count == n else 1 - binomial_tail(count + 1, n, high) == equal(0.025)


def test_mean_interval_needs_two_values():
    interval = st.mean_interval([1.0, nan, 3.0])
    assert (interval.mean, interval.count) == (2.0, 2)
    assert interval.half_width == equal(st.t_for_coverage(1.0))
    assert not interval.excludes_zero()
    assert st.mean_interval([5.0, 5.1, 5.2]).excludes_zero()
    assert not st.mean_interval([5.0]).excludes_zero()
    assert st.mean_interval([]).count == 0


# Table values, and closed forms: F(2, v) has the tail (1 + 2 f / v)^(-v/2), and T with one degree
# of freedom is Cauchy's.
def test_distributions_agree_with_tables_and_closed_forms():
    assert st.f_tail(3.3158, 2, 30) == pytest.approx(0.05, abs=1e-5)
    assert st.f_tail(4.1709, 1, 30) == pytest.approx(0.05, abs=1e-5)
    assert st.f_tail(2.8663, 3, 36) == pytest.approx(0.05, abs=1e-5)
    for f in [0.1, 1.0, 12.0, 300.0]:
        assert st.f_tail(f, 2.0, 7.5) == equal((1.0 + 2.0 * f / 7.5) ** -3.75)
        assert st.t_two_sided(-f, 1.0) == equal(1.0 - 2.0 * atan(f) / pi, 1e-15)
    for df in [1.0, 5.37, 13.0, 100.0]:  # the quantiles of scipy.stats.t have errors of 2e-9
        assert st.t_two_sided(st.t_for_coverage(df), df) == equal(0.05)
    assert st.f_tail(st.f_for_tail(0.05, 2.6, 23.4), 2.6, 23.4) == equal(0.05)
    assert np.isnan(st.f_tail(nan, 1, 2))
    assert np.isnan(st.f_tail(1.0, 1, 0))
    assert np.isnan(st.t_two_sided(1.0, -1))
    assert np.isnan(st.t_for_coverage(3, 1.0))
    assert st.f_tail(0.0, 2, 5) == 1.0
    assert st.f_tail(np.inf, 2, 5) == 0.0
    assert st.t_two_sided(np.inf, 2) == 0.0


# How often the tests reject on 10,000 data sets without any effect, at the 5 % level. The
# tolerances are three standard deviations of the binomial distribution or more.
SETS, SETS_AT_ONCE = 10_000, 250
LEVELS = {"haptic": 3, "rotation": 2, "object": 4}
PEOPLE, BLOCKS = 10, 3


@pytest.fixture(scope="module")
def papers_design():
    levels = {"participant": PEOPLE, **LEVELS, "block": BLOCKS}
    rows = pd.MultiIndex.from_product([range(k) for k in levels.values()], names=list(levels))
    return st.Design(rows.to_frame(index=False), [*LEVELS, "block"])


def rates(design, draw):
    """In percent: how often each test of Haptic, and one of Object x Haptic, rejects. draw(sets):
    responses of this many data sets, in the order participant, haptic, rotation, object, block."""
    rejected = []
    for _ in range(SETS // SETS_AT_ONCE):
        y = draw(SETS_AT_ONCE)
        fit = design.fit(y)
        cells = y[..., 0].reshape(SETS_AT_ONCE, PEOPLE, -1, BLOCKS).mean(axis=-1)
        repeated = st.repeated_measures_of(cells, LEVELS)
        haptic, object_haptic = repeated[("haptic",)], repeated[("haptic", "object")]
        assert object_haptic.df1 == 6.0
        ps = {"fixed": fit.effect(("haptic",)).p, "uncorrected": haptic.p, "gg": haptic.p_gg}
        ps["gg of object x haptic"] = object_haptic.p_gg
        if y.shape[-1] == 3:
            ps["manova"] = fit.wilks(("haptic",)).p
        rejected.append(pd.DataFrame(ps) < st.SIGNIFICANCE)
    percent = 100.0 * pd.concat(rejected).mean()
    print(percent.to_string())
    return percent


def test_independent_rows_are_rejected_at_the_nominal_rate(papers_design):
    rng = random(18101)
    rows = PEOPLE * 24 * BLOCKS
    percent = rates(papers_design, lambda sets: rng.standard_normal((sets, rows, 3)))
    for test in ["manova", "fixed", "uncorrected"]:
        assert percent[test] == pytest.approx(5.0, abs=0.65)
    assert percent["gg"] == pytest.approx(4.0, abs=0.65)
    assert percent["gg of object x haptic"] == pytest.approx(2.0, abs=0.5)


# Rows of one participant are not independent: intercepts of one residual standard deviation, and
# scatter of the effect of haptic between participants.
@pytest.mark.parametrize(
    ("scatter", "fixed_percent", "tolerance"),
    [(0.0, 0.4, 0.2), (0.4, 27.5, 1.5)],
    ids=["intercepts: the paper's analysis rejects too rarely", "scatter: too often"],
)
def test_dependent_rows_mislead_the_papers_analysis(
    papers_design, scatter, fixed_percent, tolerance
):
    rng = random(18102)

    def draw(sets):
        intercept = rng.standard_normal((sets, PEOPLE, 1, 1))
        shift = intercept + scatter * rng.standard_normal((sets, PEOPLE, 3, 1))
        y = shift + rng.standard_normal((sets, PEOPLE, 3, 8 * BLOCKS))
        return y.reshape(sets, -1, 1)

    percent = rates(papers_design, draw)
    assert percent["fixed"] == pytest.approx(fixed_percent, abs=tolerance)
    assert percent["uncorrected"] == pytest.approx(5.0, abs=0.65)
    assert percent["gg"] == pytest.approx(4.0, abs=0.65)


TAILS = (1e-300, 1e-100, 1e-30, 1e-12, 0.05, 0.5, 0.999, 1 - 1e-9, 1 - 2**-50)


# F with 2 numerator degrees of freedom: P(F > f) = (1 + 2 f / df2)^(-df2 / 2); 1 / F has the others.
@pytest.mark.parametrize("tail", TAILS)
@pytest.mark.parametrize("df", [1.0, 2.0, 18.0, 648.0, 1572.3, 2500.0, 1e5])
def test_quantiles_of_f_with_2_degrees_of_freedom_at_any_tail(tail, df):
    with np.errstate(over="ignore"):
        expected = 0.5 * df * np.expm1(-2.0 / df * np.log(tail))
    if np.isfinite(expected):
        assert st.f_for_tail(tail, 2.0, df) == pytest.approx(expected, rel=1e-11)
    with np.errstate(over="ignore"):
        expected = 1.0 / (0.5 * df * np.expm1(-2.0 / df * np.log1p(-tail)))
    if np.isfinite(expected):
        assert st.f_for_tail(tail, df, 2.0) == pytest.approx(expected, rel=1e-11)


# The t of one degree of freedom is that of Cauchy; of two, P(|T| > t) = 1 - t / sqrt(2 + t^2).
@pytest.mark.parametrize("coverage", [1e-300, 1e-15, 1e-9, 0.01, 0.5, 0.95, 1 - 1e-9, 1 - 2**-50])
def test_quantiles_of_t_with_1_and_2_degrees_of_freedom_at_any_coverage(coverage):
    tail = 1.0 - coverage
    one = np.tan(0.5 * np.pi * coverage) if tail > 0.5 else 1.0 / np.tan(0.5 * np.pi * tail)
    assert st.t_for_coverage(1.0, coverage) == pytest.approx(one, rel=1e-11)
    two = coverage * np.sqrt(2.0 / (tail * (1.0 + coverage)))
    assert st.t_for_coverage(2.0, coverage) == pytest.approx(two, rel=1e-11)


# qf and qt of R 4.2.2 with lower.tail = FALSE.
@pytest.mark.parametrize("tail, df1, df2, f", [
    (1e-100, 1.0, 9.0, 1.1116582511819331e23), (1e-30, 6.0, 54.0, 135.53523112334986),
    (1e-12, 1.2, 10.8, 1217.3415464158334), (0.5, 0.2, 5.0, 0.0071694047329318167)])
def test_quantiles_of_f_agree_with_r(tail, df1, df2, f):
    assert st.f_for_tail(tail, df1, df2) == pytest.approx(f, rel=1e-12)
    root = st.f_for_tail(tail, 1.0, df2)
    assert st.t_two_sided(np.sqrt(root), df2) == pytest.approx(tail, rel=1e-11)
