"""Power by simulation: against the noncentral distributions, and against the primary analysis of the
same tables and of whole trials."""

from os import environ
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import special, stats

from palpate.analysis import statistics as st
from palpate.analysis.experiment.outcomes import TIME
from palpate.analysis.experiment.primary import analyse_repeated_measures
from palpate.analysis.power.answers import first_from
from palpate.analysis.power.contrasts import Design, contrasts_of
from palpate.analysis.power.simulation import (
    BLOCK,
    EpsilonLimits,
    Simulation,
    draw,
    first_of_equal_noise,
    simulate,
)
from palpate.analysis.statistics import SIGNIFICANCE

SETS = 10_000
PEOPLE = 60
SEED = 2005
SIX = Design(("NoH", "UaH", "H"), ("NoR", "R"))
THREE = Design(("NoH", "UaH", "H"), ("NoR",))
TWO = Design(("UaH",), ("NoR", "R"))


def random(seed):
    seed = int(environ.get("PALPATE_SEED", seed))
    print(f"PALPATE_SEED={seed}")
    return np.random.default_rng(seed)


def place_of(contrasts, title):
    return [contrast.title for contrast in contrasts].index(title)


def shares(design, means, noise, people=PEOPLE, sets=SETS):
    """By the title of the test: the power with 2, 3, ... people."""
    contrasts = contrasts_of(design)
    counts = simulate(contrasts, np.array(means), np.array([noise]), people, sets, SEED)
    return {test.title: counts[0, t] / sets for t, test in enumerate(contrasts)}


def three_errors(share, sets=SETS):
    """Three standard errors of a share."""
    return 3.0 * np.sqrt(share * (1.0 - share) / sets)


def noncentral_f_power(noncentrality, df1, df2):
    # A mixture of beta distributions; that of SciPy 1.10 has errors of 1e-6.
    limit = stats.f.isf(SIGNIFICANCE, df1, df2)
    j = np.arange(1000)
    below = special.betainc(df1 / 2.0 + j, df2 / 2.0, df1 * limit / (df1 * limit + df2))
    return 1.0 - stats.poisson.pmf(j, noncentrality / 2.0) @ below


def noncentral_t_power(delta, df):
    limit = stats.t.isf(SIGNIFICANCE / 2.0, df)
    return stats.nct.sf(limit, df, delta) + stats.nct.cdf(-limit, df, delta)


# Differences of the sd 1 in a pair of conditions: var(R - NoR) = 2 (w + e / m).
@pytest.mark.parametrize("n, d_z, power",
                         [(10, 0.5, 0.2931756), (34, 0.5, 0.8077775), (10, 1.0, 0.8030969)])
def test_power_of_paired_values_is_that_of_noncentral_t(n, d_z, power):
    assert noncentral_t_power(d_z * np.sqrt(n), n - 1.0) == pytest.approx(power, abs=1e-7)
    found = shares(TWO, [3.0, 3.0 + d_z], 0.25 + 1.0 / 4, people=n)
    for title in ("Rotation, uncorrected", "R - NoR in UaH, Holm"):
        assert found[title][-1] == pytest.approx(power, abs=three_errors(power)), title


# k levels with one value a cell, of the variance 1 and the correlation rho; f is the standard
# deviation of the k means.
@pytest.mark.parametrize("n, f, rho, power, about_gg",
                         [(28, 0.25, 0.5, 0.8124546, 0.80), (10, 0.5, 0.5, 0.8991220, 0.87)])
def test_power_of_repeated_measures_is_that_of_noncentral_f_and_lower_by_greenhouse_and_geisser(
        n, f, rho, power, about_gg):
    k = 3.0
    noncentrality = f * f * n * k / (1.0 - rho)
    expected = noncentral_f_power(noncentrality, k - 1.0, (k - 1.0) * (n - 1.0))
    assert expected == pytest.approx(power, abs=1e-7)
    step = f * np.sqrt(1.5)  # of the means -step, 0 and step
    found = shares(THREE, [-step, 0.0, step], 1.0 - rho, people=n)
    plain, gg = found["Haptic, uncorrected"][-1], found["Haptic, Greenhouse-Geisser"][-1]
    assert plain == pytest.approx(power, abs=three_errors(power))
    assert gg < plain
    assert gg == pytest.approx(about_gg, abs=0.5e-2 + three_errors(about_gg))


# Every effect of the six conditions, at several n of one simulation. The noise is w + e / m.
def test_power_of_each_effect_and_number_of_people_is_that_of_noncentral_f():
    means, noise = np.array([0.3, 0.9, 0.1, 0.2, -0.4, 0.8]), 0.2 + 0.9 / 3.0
    found = shares(SIX, means, noise)
    for test in contrasts_of(SIX):
        if test.correction != "uncorrected":
            continue
        df1 = test.weights.shape[1]
        of_means = np.square(means @ test.weights).sum()
        for n in (2, 3, 6, 12, 30, 60):
            power = noncentral_f_power(n * of_means / noise, df1, df1 * (n - 1.0))
            assert found[test.title][n - 2] == pytest.approx(power, abs=three_errors(power)), \
                (test.name, n)


def analysed(tables):
    """(tests, sets): whether the primary analysis of each table, (sets, people, 6), finds the tests
    of SIX significant."""
    found = []
    for effect in st.repeated_measures_of(tables, {"Haptic": 3, "Rotation": 2}).effects:
        found.append(effect.p < SIGNIFICANCE)
        if effect.df1 > 1.0:
            found.append(effect.p_gg < SIGNIFICANCE)
    of_haptic = tables.reshape(*tables.shape[:2], 3, 2).mean(axis=3)
    families = (
        [(of_haptic[..., j], of_haptic[..., i]) for i, j in ((0, 1), (0, 2), (1, 2))],
        [(tables[..., 2 * h + 1], tables[..., 2 * h]) for h in range(3)],
    )
    for family in families:
        p = [[st.paired_t(a, b).p for a, b in zip(*pair)] for pair in family]
        found += list(np.transpose([st.holm(each) for each in np.transpose(p)]) < SIGNIFICANCE)
    return np.array(found)


# The first n rows of simulated tables, with another scatter between people, which cancels.
def test_decisions_are_those_of_the_primary_analysis_of_the_same_table():
    sets, sd = 40, np.sqrt(4.0 + 60.0 / 12.0)
    means = np.array([29.0, 29.5, 27.0, 28.0, 25.0, 27.5])
    contrasts = contrasts_of(SIX)
    noise = draw(SEED, 0, PEOPLE, 6)[..., :sets]
    found = Simulation(contrasts, means, np.array([sd**2]), PEOPLE, SEED).decisions(noise, sd)
    between = 4.0 * random(23000).standard_normal((sets, PEOPLE, 1))
    tables = means + between + sd * noise.transpose(2, 0, 1)
    for n in range(2, PEOPLE + 1):
        expected = analysed(tables[:, :n])
        assert (found[:, n - 2] == expected).all(), n
    assert 1000 < np.count_nonzero(found) < found.size - 1000


# The decision by the series of limits is the one by the p value, at F on both sides of the limit.
def test_greenhouse_geisser_decides_by_the_p_value():
    rng = random(23001)
    people = np.arange(2.0, PEOPLE + 1.0)
    limits = EpsilonLimits(people)
    epsilon = rng.uniform(0.5, 1.0, (people.size, 400))
    epsilon[0] = 0.5  # of two people
    df1, df2 = 2.0 * epsilon, 2.0 * epsilon * (people[:, None] - 1.0)
    limit = limits(epsilon)
    assert limit == pytest.approx(st.f_for_tail(SIGNIFICANCE, df1, df2), rel=1e-11)
    side = rng.choice([-1.0, 1.0], epsilon.shape)
    f = limit * np.exp(side * 10.0 ** -rng.uniform(0.0, 10.0, epsilon.shape))
    assert ((f > limit) == (st.f_tail(f, df1, df2) < SIGNIFICANCE)).all()
    ends = np.array([[0.5 - 1e-16, 1.0 + 1e-16]] * people.size)  # roundings
    assert limits(ends) == pytest.approx(limits(np.array([[0.5, 1.0]] * people.size)), rel=1e-12)


# Whole trials of data sets, as `experiment analyse` sees them. Objects and blocks, which move all
# people and conditions alike, change nothing.
def test_power_is_the_share_of_significant_analyses_of_whole_trials():
    rng = random(23002)
    analyses, people, u, w, e = 1500, 6, 9.0, 1.0, 6.0
    means = 0.5 * np.arange(6.0)
    trials = (means[:, None, None]
              + np.sqrt(u) * rng.standard_normal((analyses, people, 1, 1, 1))
              + np.sqrt(w) * rng.standard_normal((analyses, people, 6, 1, 1))
              + np.sqrt(e) * rng.standard_normal((analyses, people, 6, 2, 2))
              + np.array([5.0, -5.0])[:, None] + np.array([4.0, 8.0]))
    effects = st.repeated_measures_of(trials.mean(axis=(3, 4)), {"Haptic": 3, "Rotation": 2})
    found = {
        "Haptic, uncorrected": effects["Haptic",].p < SIGNIFICANCE,
        "Haptic, Greenhouse-Geisser": effects["Haptic",].p_gg < SIGNIFICANCE,
        "Rotation, uncorrected": effects["Rotation",].p < SIGNIFICANCE,
        "H - NoH, Holm": analysed(trials.mean(axis=(3, 4)))[6],
    }
    # One set through the primary analysis of trials gives the p that are counted.
    grid = trials[0].reshape(people, 3, 2, 2, 2)
    levels = {"Haptic": list(SIX.haptic), "Rotation": list(SIX.rotation), "Object": ["O1", "O2"],
              "Trial": ["1", "2"]}
    primary = analyse_repeated_measures(
        SimpleNamespace(grid=lambda _: grid, levels=levels), TIME)
    haptic = primary.effect(("Haptic",))
    assert haptic["p"] == pytest.approx(effects["Haptic",].p[0], rel=1e-9)
    assert haptic["p_gg"] == pytest.approx(effects["Haptic",].p_gg[0], rel=1e-9)
    pairs = primary.pairs.set_index("pair")
    assert (pairs.loc["H - NoH", "p_holm"] < SIGNIFICANCE) == found["H - NoH, Holm"][0]

    powers = shares(SIX, means, w + e / 4.0, people=people)
    for title, significant in found.items():
        power, share = powers[title][-1], np.mean(significant)
        print(f"{title}: {share} of whole trials, {power} by power")
        assert 0.1 < power < 0.9
        # Both are shares of random data sets.
        variance = power * (1.0 - power) * (1.0 / analyses + 1.0 / SETS)
        assert share == pytest.approx(power, abs=3.0 * np.sqrt(variance)), title


def test_power_does_not_depend_on_jobs_or_the_largest_number_of_people():
    contrasts = contrasts_of(SIX)
    means, noises = np.array([0.0, 1.0, 0.0, 1.0, 2.0, 1.0]), np.array([1.5, 4.0])
    sets = BLOCK + 247  # no whole number of blocks

    def counts(people=20, seed=SEED, jobs=1):
        return simulate(contrasts, means, noises, people, sets, seed, jobs)

    one = counts()
    assert (counts(jobs=2) == one).all()
    assert (counts(people=31)[..., :19] == one).all()
    assert np.count_nonzero(counts(seed=7) != one) > 100


def test_the_first_data_sets_are_the_same_for_any_number_of_them():
    contrasts = contrasts_of(TWO)
    few, more = (simulate(contrasts, np.array([0.0, 1.0]), np.array([1.0]), 8, sets, SEED)
                 for sets in (BLOCK, BLOCK + 1))
    assert ((more - few >= 0) & (more - few <= 1)).all()


# w and e in other parts, and another u.
def test_equal_noise_gives_equal_numbers():
    w, e = np.array([0.1, 2.0, 0.7]), np.array([3.6, 2.0, 1.2])
    noises = w + e / 4
    assert first_of_equal_noise(noises).tolist() == [0, 1, 0]
    contrasts, means = contrasts_of(SIX), np.array([0.0, 1.0, 0.0, 1.0, 2.0, 1.0])
    counts = simulate(contrasts, means, noises, PEOPLE, 500, SEED)
    alone = simulate(contrasts, means, noises[2:], PEOPLE, 500, SEED)
    assert (counts[0] == counts[2]).all()
    assert (alone[0] == counts[2]).all()
    assert np.count_nonzero(counts[0] != counts[1]) > 100


@pytest.mark.parametrize("counts, percent, expected", [
    ([10, 80, 79, 80, 95], 80, 5),
    ([10, 80, 79, 80, 95], 90, 6),
    ([10, 80, 79, 80, 95], 10, 2),
    ([10, 80, 79, 80, 95], 96, None),
    ([10, 80, 85, 90, 79], 80, None),
])
def test_the_smallest_number_is_the_first_from_which_the_power_stays(counts, percent, expected):
    found = first_from(np.array(counts) / 100 >= percent / 100)  # n = 2 to 6
    assert found == (expected or 7)


# A power is compared with 0.8 as a number: a share of exactly 0.8 or 0.9 is enough.
def test_a_share_of_exactly_the_power_is_enough():
    for sets in (100, 200, 1000, 10_000, 123_450, 1_000_000):
        for power in (0.8, 0.9):
            enough = round(power * sets)
            assert np.int64(enough) / sets >= power
            assert not np.int64(enough - 1) / sets >= power
