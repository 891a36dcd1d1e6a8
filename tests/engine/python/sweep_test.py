"""Rankings, flips and shares of sweeps, compared with counts by hand."""

from __future__ import annotations

import functools
import itertools
import math
import random
import re

import numpy as np
import pandas as pd
import pytest

from palpate.analysis import figures
from palpate.analysis.draws import key_hash, mt19937_64
from palpate.analysis.errors import InputError
from palpate.analysis.measured import Run, read_run
from palpate.analysis.statistics import wilson
from palpate.analysis.sweep import chance, command, findings, points, rankings, texts
from palpate.analysis.sweep.figures import axis_figure
from palpate.analysis.sweep.points import HAPTICS, MEASURES, ROTATIONS
from palpate.analysis.sweep.rankings import RANKINGS

BY_NAME = {ranking.name: ranking for ranking in RANKINGS}
TIME, LOSSES, PENETRATION, ANGLE = (measure.column for measure in MEASURES)
ROTATION_OF_ANGLE = "mean contact angle, Rotation"
NONE = math.nan
RUN = Run(plan="plan <b>", seed=1, operator="person", operator_version=1, version="0")


def any_mean(participant, haptic, rotation, measure):
    return 1.0


def rows_of(*all_points):
    """Rows of sweep.csv of points: each is (block, parameter that varies or "", values of
    parameters, participants, mean of (participant, haptic, rotation, measure))."""
    rows = []
    for number, (block, varied, values, participants, mean) in enumerate(all_points, 1):
        for person, haptic, rotation in itertools.product(range(1, participants + 1), HAPTICS,
                                                          ROTATIONS):
            rows.append({
                "point": number, "block": block, "parameter": varied,
                **{p.name: values.get(p.name, "" if p.words else NONE)
                   for p in points.all_parameters().values()},
                "participant": person, "haptic": haptic, "rotation": rotation, "trials": 1,
                "done": 1, "timeouts": 0, "faults": 0, "limit_s": 120.0,
                **{m.column: mean(person, haptic, rotation, m.column) for m in MEASURES}})
    return pd.DataFrame(rows)


def level(parameter, value, participants, mean):
    return ("one_at_a_time", parameter, {parameter: value}, participants, mean)


def drawn(values, mean, participants=1):
    return ("hypercube", "", values, participants, mean)


def angle_smaller(is_smaller, otherwise=2.0):
    """The angle with R is smaller, or nothing differs."""
    return lambda person, haptic, rotation, measure: (
        1.0 if measure == ANGLE and rotation == "R" and is_smaller else otherwise)


def set_counts(rows, where, done, timeouts, faults):
    """A row of trials that were not done has no means."""
    rows.loc[where, ["trials", "done", "timeouts", "faults"]] = [
        done + timeouts + faults, done, timeouts, faults]
    if done == 0:
        rows.loc[where, [m.column for m in MEASURES]] = NONE


def ranked(name, rows):
    """The ranking at the first point."""
    return rankings.at_points(BY_NAME[name], points.sweep_of(rows)).iloc[0]


def ranked_by(name, participants, mean):
    return ranked(name, rows_of(("base", "", {}, participants, mean)))


def found_in(*all_points):
    return findings.findings_of(points.sweep_of(rows_of(*all_points)))


def ranking_row(found, name):
    return next(row for row in found.rankings if row["ranking"] == name)


def halves(found, name):
    return [row for row in found.halves if row["ranking"] == name]


def test_rankings_are_those_of_the_paper_and_that_a4_helps():
    assert [f"{r.name}: {r.order}{'' if r.is_of_paper else ' *'}" for r in RANKINGS] == [
        "total time, Haptic: H < UaH < NoH", "total time, Rotation: NoR < R",
        "losses of contact, Haptic: H < UaH < NoH", "losses of contact, Rotation: NoR < R",
        "mean penetration, Haptic: H < UaH < NoH", "mean contact angle, Rotation: R < NoR",
        "total time, A4 in UaH: R < NoR *", "losses of contact, A4 in UaH: R < NoR *",
        "mean penetration, A4 in UaH: R < NoR *"]


def test_a_ranking_compares_means_over_the_other_factor():
    # NoH 20 and 40, UaH 21 and 37, H 10 and 46: means 30, 29 and 28.
    times = {"NoH": (20.0, 40.0), "UaH": (21.0, 37.0), "H": (10.0, 46.0)}
    at = functools.partial(ranked_by, participants=1,
                           mean=lambda _, h, r, __: times[h][ROTATIONS.index(r)])
    haptic = at("total time, Haptic")
    assert haptic["holds"] == 1
    assert list(haptic[["H", "UaH", "NoH"]]) == [28.0, 29.0, 30.0]
    assert haptic["participants"] == 1
    assert not haptic["is_clear"], "one participant has no interval"
    rotation = at("total time, Rotation")
    assert rotation["holds"] == 1
    assert list(rotation[["NoR", "R"]]) == [17.0, 41.0]
    a4 = at("total time, A4 in UaH")  # in UaH alone, and the claim is R < NoR
    assert a4["holds"] == 0
    assert list(a4[["R", "NoR"]]) == [37.0, 21.0]


@pytest.mark.parametrize("name", BY_NAME)
def test_a_tie_does_not_hold(name):
    assert ranked_by(name, 3, any_mean)["holds"] == 0


def test_a_tie_of_rounded_means_does_not_hold():
    """10, 15 and 7 losses, and 8, 12 and 12: both sums are 32."""
    losses = {("NoH", "NoR"): 10, ("UaH", "NoR"): 15, ("H", "NoR"): 7,
              ("NoH", "R"): 8, ("UaH", "R"): 12, ("H", "R"): 12}
    other = {("NoH", "NoR"): 1 / 3, ("UaH", "NoR"): 0.1, ("H", "NoR"): 0.7,
             ("NoH", "R"): 0.7, ("UaH", "R"): 1 / 3, ("H", "R"): 0.1}
    at = ranked_by("losses of contact, Rotation", 3,
                   lambda person, h, r, _: (losses if person == 1 else other)[h, r])
    assert at["holds"] == 0
    assert not at["is_clear"]


def test_a_ranking_is_of_the_mean_over_participants():
    """The mean of the pairs counts, not how many participants agree."""
    at = ranked_by("total time, Rotation", 3, lambda person, _, r, __: (
        10.0 if r == "NoR" else 30.0 if person == 3 else 9.0))
    assert at["holds"] == 1
    assert not at["is_clear"]


def test_a_ranking_leaves_out_participants_without_a_cell():
    def mean(person, haptic, rotation, _):
        if person == 1 and (haptic, rotation) == ("H", "NoR"):
            return NONE
        number = HAPTICS.index(haptic)
        return 100.0 * number if person == 1 else 3.0 - number

    haptic = ranked_by("total time, Haptic", 2, mean)
    assert haptic["participants"] == 1
    assert list(haptic[["H", "UaH", "NoH"]]) == [1.0, 2.0, 3.0]
    # The missing cell is not one of UaH.
    assert ranked_by(ROTATION_OF_ANGLE, 2, mean)["participants"] == 2
    assert math.isnan(ranked_by("total time, Haptic", 2, lambda *_: NONE)["holds"])


@pytest.mark.parametrize(("difference", "holds", "is_clear"), [
    (2.4842, 1, True), (2.4841, 1, False), (-2.4842, 0, True), (-2.4841, 0, False)])
def test_a_ranking_is_clear_if_the_intervals_of_paired_differences_exclude_zero(
        difference, holds, is_clear):
    """Three participants with the differences d - w, d and d + w have a t interval of half width
    4.302653 w / sqrt(3) = 2.484138 w."""
    at = ranked_by(ROTATION_OF_ANGLE, 3, lambda person, _, r, __: (
        50.0 if r == "NoR" else 50.0 - difference + person - 2))
    assert (at["holds"], at["is_clear"]) == (holds, is_clear)


@pytest.mark.parametrize(("counts", "time_s", "has_others"), [
    ((4, 0, 0), 30.0, True), ((3, 1, 0), (3 * 30.0 + 120.0) / 4, False), ((3, 0, 1), NONE, False),
    ((2, 1, 1), NONE, False), ((0, 4, 0), 120.0, False), ((0, 0, 0), NONE, False)])
def test_a_cell_counts_the_limit_for_a_timeout_of_the_time_and_needs_all_trials_otherwise(
        counts, time_s, has_others):
    means = {TIME: 30.0, LOSSES: 5.0, PENETRATION: 0.04, ANGLE: 20.0}
    rows = rows_of(("base", "", {}, 1, lambda _, __, ___, measure: means[measure]))
    set_counts(rows, rows.index, *counts)
    assert points.cell_means(rows, TIME)[0] == pytest.approx(time_s, rel=1e-15, nan_ok=True)
    for other in (LOSSES, PENETRATION, ANGLE):
        value = points.cell_means(rows, other)[0]
        assert value == means[other] if has_others else math.isnan(value)


def test_a_timeout_does_not_favour_the_condition_that_times_out():
    """In one cell, the trials of a hard object end by the limit. The means of the others would be
    smaller than those of the complete cells."""
    rows = rows_of(("base", "", {}, 2, lambda _, __, r, ___: 10.0 if r == "R" else 20.0))
    set_counts(rows, rows.index, 4, 0, 0)
    hard = (rows["participant"] == 1) & (rows["haptic"] == "UaH") & (rows["rotation"] == "R")
    set_counts(rows, hard, 3, 1, 0)
    for name in ("losses of contact, A4 in UaH", "mean penetration, Haptic", ROTATION_OF_ANGLE):
        assert ranked(name, rows)["participants"] == 1
    time = ranked("total time, A4 in UaH", rows)
    assert time["participants"] == 2
    assert list(time[["R", "NoR"]]) == [((3 * 10.0 + 120.0) / 4 + 10.0) / 2, 20.0]
    assert time["holds"] == 0


@pytest.mark.parametrize("name", BY_NAME)
def test_a_ranking_is_not_testable_where_nobody_completed_a_trial(name):
    rows = rows_of(("base", "", {}, 2, any_mean))
    set_counts(rows, rows.index, 0, 4, 0)
    assert math.isnan(ranked(name, rows)["holds"])


# Random numbers of the program.


def test_random_numbers_are_those_of_the_standard():
    """ISO C++ [rand.predef]: the 10000th number of mt19937_64 with its default seed."""
    assert mt19937_64(5489, 10000)[-1] == 9981545732273789042
    assert list(mt19937_64(1, 700)) == list(mt19937_64(1, 1000)[:700])


def test_hashes_are_those_of_the_program():
    """The values of operator_file_test.cpp."""
    assert key_hash() == 0xEFD01F60BA992926
    assert key_hash("") == 0x6898FE3D08C5A427
    assert key_hash("ab", "c") == 0x2C2B3DD6A23D5ADE
    assert key_hash("a", "bc") == 0xBA25B63973318BDA


def slow_chance(splits, holds, key):
    """largest_difference_p, one deal after the other."""
    def largest(deal):
        sizes = [0.0]
        for part_of in splits:
            shares = [deal[part_of == part].mean() for part in set(part_of[part_of >= 0])]
            sizes.append(max(shares, default=0.0) - min(shares, default=0.0))
        return max(sizes)

    draws = iter(mt19937_64(key_hash("largest difference", key), 2000 * (len(holds) - 1)))
    found, count, deal = largest(holds), 1, holds.copy()
    for _ in range(2000):
        for left in range(len(deal), 1, -1):
            other = int(next(draws)) % left
            deal[left - 1], deal[other] = deal[other], deal[left - 1]
        count += largest(deal) >= found - 1e-12
    return count / 2001


def test_chance_deals_as_the_program_does():
    seed = 3
    print("seed", seed)
    numbers = np.random.default_rng(seed)
    splits = [numbers.integers(-1, 3, 11) for _ in range(4)]
    holds = numbers.integers(0, 2, 11) > 0
    assert chance.largest_difference_p(splits, holds, "key") == slow_chance(splits, holds, "key")


def test_chance_is_the_share_of_deals_with_a_larger_difference():
    """Two points of which one holds are in different parts: each of the two deals has the same
    difference. Of 8 and 8 points, the parts that hold and fail are one of 12,870 deals; two of
    these deals have the difference 1."""
    p_of = chance.largest_difference_p
    assert p_of([np.array([0, 1])], np.array([True, False]), "two") == 1.0
    parted = np.repeat([0, 1], 8)
    assert p_of([parted], parted == 0, "parted") < 0.005
    four, holds = np.array([0, 0, 1, 1]), np.array([True, True, False, False])
    p = p_of([four], holds, "four")  # two of six deals part them
    assert p == pytest.approx(1 / 3, abs=5.0 * math.sqrt(2 / 9 / 2000) + 1 / 2001)
    assert p_of([four], holds, "four") == p
    # Three splits, one for each way to pair four points: every deal parts one of them.
    every = [four, np.array([0, 1, 0, 1]), np.array([0, 1, 1, 0])]
    assert p_of(every, holds, "all") == 1.0


def test_chance_rarely_finds_a_parameter_in_noise():
    """Noise decides in about one of twenty sets of noise, however many parameters there are."""
    seed, sets = 17, 200
    print("seed", seed)
    numbers = np.random.default_rng(seed)
    found = sum(chance.largest_difference_p(list(numbers.integers(0, 2, (12, 40))),
                                            numbers.integers(0, 2, 40) > 0, str(number)) < 0.05
                for number in range(sets))
    assert found <= sets * 0.05 + 5.0 * math.sqrt(sets * 0.05 * 0.95)


# Tables.


def test_means_have_the_standard_deviation_over_participants():
    found = found_in(level("scale", 1.0, 3, lambda person, *_: NONE if person == 3 else
                           10.0 * person), drawn({"scale": 1.0}, any_mean))
    of = next(row for row in found.one_at_a_time
              if (row["measure"], row["haptic"], row["rotation"]) == (TIME, "UaH", "R"))
    assert (of["participants"], of["mean"]) == (2, 15.0)
    assert of["sd"] == pytest.approx(math.sqrt(50.0), rel=1e-15)


def test_flips_are_between_neighbouring_levels_with_the_base_in_its_place():
    """The angle with R is smaller at the levels 500 and 2000, not at 1000 (the base) and 4000."""
    def mean(is_smaller):
        return lambda person, _, r, measure: (
            1.0 if measure == ANGLE and r == "R" and is_smaller else 2.0 + 0.01 * person)

    name = "stiffness_N_per_m"
    all_points = [("base", "", {name: 1000.0}, 2, mean(False))]
    all_points += [level(name, value, 2, mean(value != 4000.0))
                   for value in (500.0, 2000.0, 4000.0)]
    sweep = points.sweep_of(rows_of(*all_points, drawn({name: 1000.0}, any_mean)))
    assert [p.name for p in sweep.varied] == [name]
    assert findings.axis_of(sweep, sweep.varied[0]) == [2, 1, 3, 4]
    flips = findings.findings_of(sweep).flips
    keys = ("from", "to", "holds_at_from", "holds_at_to")
    assert [tuple(row[key] for key in keys) for row in flips] == [
        (500, 1000, 1, 0), (1000, 2000, 0, 1), (2000, 4000, 1, 0)]
    assert {row["ranking"] for row in flips} == {ROTATION_OF_ANGLE}
    # Where the ranking fails, all differences are 0.
    assert not any(row["is_clear"] for row in flips)


def test_flips_compare_with_the_last_testable_level():
    def mean(value):
        def at(_, __, rotation, measure):
            if value == 1.0:
                return NONE
            return 2.0 if measure == ANGLE and (rotation == "R") != (value == 0.5) else 1.0
        return at

    found = found_in(*(level("scale", value, 3, mean(value)) for value in (0.5, 1.0, 2.0)),
                     drawn({"scale": 1.0}, any_mean))
    assert [(row["from"], row["to"], row["holds_at_to"]) for row in found.flips] == [(0.5, 2.0, 0)]


def test_shares_are_counted_over_the_hypercube_and_its_halves():
    """A ranking that holds or fails as a function of two values, among random ones."""
    seed, count, lost = 91, 41, 7  # nobody completes one point
    print("seed", seed)
    numbers = random.Random(seed)
    words = points.all_parameters()["following"].words
    # One level of each parameter, so that both are of the sweep.
    all_points = [level("sight_delay_s", 0.1, 1, any_mean),
                  level("following", words[1], 1, any_mean)]
    delays, followings, holds = [], [], []
    for i in range(count):
        delays.append(numbers.uniform(0.1, 0.2))
        followings.append(numbers.choice(words[:3]))
        holds.append(delays[i] < 0.13 or (followings[i] == words[2] and delays[i] < 0.18))
        mean = angle_smaller(holds[i]) if i != lost else lambda *_: NONE
        all_points.append(drawn({"sight_delay_s": delays[i], "following": followings[i]}, mean))
    found = found_in(*all_points)

    def counted(is_in):
        there = [holds[i] for i in range(count) if i != lost and is_in(i)]
        return len(there), sum(there)

    of_all = ranking_row(found, ROTATION_OF_ANGLE)
    assert of_all["untestable"] == 1
    assert (of_all["points"], of_all["holds"]) == counted(lambda _: True)
    assert of_all["low"] == wilson(of_all["holds"], count - 1)[0]
    rows = halves(found, ROTATION_OF_ANGLE)
    assert [(row["parameter"], row["part"]) for row in rows] == [
        ("sight_delay_s", "low half"), ("sight_delay_s", "high half"),
        *(("following", word) for word in words[:3])]
    # Of 41 different delays, the 20 lowest and the 20 highest; of three words, each.
    in_order = sorted(delays)
    expected = [counted(lambda i: delays[i] <= in_order[19]),
                counted(lambda i: delays[i] >= in_order[21]),
                *(counted(lambda i: followings[i] == word) for word in words[:3])]
    assert [(row["points"], row["holds"]) for row in rows] == expected
    shares = sorted(row["share"] for row in rows[2:])
    assert rows[2]["difference"] == shares[2] - shares[0]
    is_delay = abs(rows[0]["difference"]) >= abs(rows[2]["difference"])
    assert of_all["p"] < 0.05
    assert of_all["decisive_parameters"] == ("sight_delay_s" if is_delay else "following")


def test_equal_differences_decide_together():
    names = ("scale", "align", "speed_m_per_s")
    aligns = points.all_parameters()["align"].words
    values = [{"scale": value, "align": aligns[1 - value], "speed_m_per_s": speed}
              for value in (0, 1) for speed in (0.1, 0.2) for _ in range(8)]
    first = [level(name, values[0][name], 1, any_mean) for name in names]
    found = found_in(*first, *(drawn(v, angle_smaller(v["scale"] == 1)) for v in values))
    of_all = ranking_row(found, ROTATION_OF_ANGLE)
    assert of_all["p"] < 0.05
    assert of_all["decisive_parameters"] == "align scale"
    # Of four points, one of three deals parts them as well.
    found = found_in(*first, *(drawn(v, angle_smaller(v["scale"] == 1)) for v in values[::8]))
    of_all = ranking_row(found, ROTATION_OF_ANGLE)
    assert len(halves(found, ROTATION_OF_ANGLE)) == 6
    assert of_all["p"] > 0.05
    assert of_all["decisive_parameters"] == ""


def test_without_a_difference_nothing_decides():
    def mean(_, haptic, *__):
        return 3.0 - HAPTICS.index(haptic)

    found = found_in(level("scale", 1.0, 1, mean),
                     *(drawn({"scale": scale}, mean) for scale in (0.5, 1.0, 1.0, 0.5)))
    of_all = ranking_row(found, "total time, Haptic")
    assert (of_all["share"], of_all["high"]) == (1.0, 1.0)
    assert halves(found, "total time, Haptic")[0]["difference"] == 0.0
    assert of_all["decisive_parameters"] == ""
    assert math.isnan(of_all["p"])


def test_text_states_untestable_points_and_rounds_no_share_to_all():
    """399 of 400 points hold; nobody completes another one."""
    rows = rows_of(level("scale", 1.0, 1, angle_smaller(True)),
                   *(drawn({"scale": float(i)}, angle_smaller(i != 5)) for i in range(401)))
    set_counts(rows, rows.index[-6:], 0, 4, 0)
    sweep = points.sweep_of(rows)
    text = texts.terminal(sweep, findings.findings_of(sweep))
    for part in (
            "mean contact angle, Rotation (R < NoR): > 99 % (99 to > 99 %): holds at 399 of 400 "
            "testable points; 1 of 401 not testable, because nobody completed the trials; decides "
            "most: none beyond chance (p = 1)",
            "mean penetration, A4 in UaH (R < NoR): 0 % (0 to 1 %): holds at 0 of 400 testable "
            "points",
            "two conditions holds at 1/2 of the points, and an order of three at 1/6",
            "by the means of 1 person, who is the same at all points"):
        assert part in text


def test_shares_that_nobody_can_test_have_no_numbers():
    rows = rows_of(level("scale", 1.0, 1, any_mean),
                   *(drawn({"scale": float(i)}, any_mean) for i in range(6)))
    set_counts(rows, rows.index, 0, 4, 0)
    report = command.report(points.sweep_of(rows), RUN)
    head, *lines = report.files["rankings.csv"].splitlines()
    assert ",points,untestable,holds,share,low,high," in head
    assert len(lines) == len(RANKINGS)
    for line in lines:
        assert ",0,6,0,,,,," in line


def figure_of(rows, parameter="scale"):
    sweep = points.sweep_of(rows)
    found = findings.findings_of(sweep)
    levels = pd.DataFrame([r for r in found.one_at_a_time if r["parameter"] == parameter])
    flips = [row for row in found.flips if row["parameter"] == parameter]
    return levels, axis_figure(levels, flips, sweep.parameters[parameter], base=0)


def texts_in(figure):
    svg = str(figures.svg(figure, "scale", "title"))
    return [re.sub("<[^>]*>", "", text) for text in re.findall("<text.*?</text>", svg, re.S)]


def test_figure_counts_the_trials_of_a_level_at_which_some_are_missing():
    """Of the 2 * 6 trials at the second level, one ends by the limit."""
    rows = rows_of(level("scale", 0.5, 2, any_mean), level("scale", 1.0, 2, any_mean),
                   drawn({"scale": 1.0}, any_mean))
    set_counts(rows, rows.index[23:24], 0, 1, 0)
    levels, figure = figure_of(rows)
    found = texts_in(figure)
    assert "11/12" in found
    assert "12/12" not in found
    assert list(levels["trials_of_point"])[:1] == list(levels["done_of_point"])[:1] == [12]
    assert list(levels["done_of_point"])[-1] == 11


def test_figure_is_drawn_without_some_conditions():
    """Nobody completes a trial with force, or any at the second level."""
    def mean(value):
        return lambda person, haptic, *_: float(person) if (haptic, value) == ("NoH", 0.5) else NONE

    rows = rows_of(*(level("scale", value, 2, mean(value)) for value in (0.5, 1.0)),
                   drawn({"scale": 1.0}, any_mean))
    found = texts_in(figure_of(rows)[1])
    for text in ("NoH, NoR", "H, R", "0.5", "mean penetration (dm)"):
        assert text in found
    rows[[m.column for m in MEASURES]] = NONE
    assert "NoH, NoR" in texts_in(figure_of(rows)[1])


def test_figure_marks_flips_and_the_base():
    def mean(is_smaller):
        return angle_smaller(is_smaller)

    rows = rows_of(("base", "", {"scale": 1.0}, 2, mean(False)), level("scale", 0.5, 2, mean(True)),
                   drawn({"scale": 1.0}, any_mean))
    sweep = points.sweep_of(rows)
    found = findings.findings_of(sweep)
    levels = pd.DataFrame(found.one_at_a_time)
    figure = axis_figure(levels, found.flips, sweep.parameters["scale"], base=1)
    assert "(1)" in texts_in(figure)
    assert "(base)" in texts_in(figure)


def test_tables_have_one_row_for_each_thing_they_count():
    def mean(person, haptic, rotation, _):
        return person + 2.0 * HAPTICS.index(haptic) + ROTATIONS.index(rotation)

    found = found_in(level("scale", 0.5, 2, mean), level("scale", 1.0, 2, mean),
                     drawn({"scale": 0.5}, mean, participants=2))
    assert {name: len(rows) for name, rows in found.tables().items()} == {
        "one_at_a_time": 2 * 4 * 6, "flips": 0, "rankings": 9, "halves": 2 * 9}
    for name, rows in found.tables().items():
        assert all(tuple(row) == findings.COLUMNS[name] for row in rows)


# The page and the files that are read.


def test_page_shows_names_with_markup_as_text():
    rows = rows_of(level("scale", 1.0, 1, any_mean), drawn({"scale": 1.0}, any_mean))
    page = command.report(points.sweep_of(rows), RUN).files["report.html"]
    assert "plan &lt;b&gt;" in page
    assert "plan <b>" not in page
    assert page.count("<svg ") == 1


def test_page_says_first_what_simulated_persons_cannot_show():
    def mean(person, haptic, rotation, measure):
        return 0.05 + 0.001 * person if measure == PENETRATION else 1.0

    rows = rows_of(("base", "", {"scale": 1.0}, 2, mean), level("scale", 0.5, 2, mean),
                   drawn({"scale": 1.0}, any_mean))
    page = command.report(points.sweep_of(rows), RUN).files["report.html"]
    assert page.index("Simulated persons are not people") < page.index("For each ranking")
    assert ("losses of contact, Haptic (H &lt; UaH &lt; NoH; holds at 0 of 1 testable points): a "
            "person does not use the force") in page
    # 5.1 and 5.2 mm
    assert "2 persons at the base plan has a standard deviation of 0.071 mm" in page
    assert "with a mean of 5.2 mm" in page or "with a mean of 5.1 mm" in page
    assert page.count(">by construction<") == 2  # time by Rotation, losses by Haptic


GOOD = ("1,base,,,,,,,,1000,0.005,delayed,nearest,0,0.3,1,NoH,NoR,1,1,0,0,30,7.1,5,0.05,50.8")


def sweep_file(folder, *lines):
    path = folder / "sweep.csv"
    names = ",".join(column.name for column in points.columns())
    path.write_text("\n".join([names, *lines]) + "\n")
    return path


def test_reads_a_sweep(tmp_path):
    sweep = points.read_sweep(sweep_file(tmp_path, GOOD))
    assert list(sweep.rows.columns) == [column.name for column in points.columns()]
    assert sweep.points.loc[1, "stiffness_N_per_m"] == 1000.0
    assert math.isnan(sweep.points.loc[1, "sight_delay_s"])
    assert sweep.parameters["press_depth_m"].title == "depth of the target inside the wall D (m)"
    assert sweep.parameters["scale"].title == "size of the objects"


@pytest.mark.parametrize(("before", "after", "element", "problem"), [
    ("1,base", "one,base", "line 2, column point", 'is "one"; expected a whole number'),
    (",base,", ",bass,", "line 2, column block", "expected base, one_at_a_time or hypercube"),
    (",base,,", ",base,tau,", "line 2, column parameter", 'is "tau"; expected sight_delay_s, '),
    (",delayed,", ",delay,", "line 2, column following", "expected delayed, predict"),
    (",1000,", ",1e,", "line 2, column stiffness_N_per_m", 'is "1e"; expected a finite number'),
    (",1000,", ",inf,", "line 2, column stiffness_N_per_m", "expected a finite number"),
    (",NoH,", ",,", "line 2, column haptic", 'is ""; expected NoH, UaH or H'),
    (",NoH,NoR,1,", ",NoH,NoR,1.5,", "line 2, column trials", "expected a whole number"),
    ("1,base,", "1,base,,", "line 2", "has 28 fields; expected 27"),
    ("1,base,,,", "1,one_at_a_time,scale,,", "", ""),
    ("1,base,,,", "1,hypercube,sight_delay_s,,", "point 1, column sight_delay_s", "is empty"),
])
def test_names_what_is_broken(tmp_path, before, after, element, problem):
    assert before in GOOD
    path = sweep_file(tmp_path, GOOD.replace(before, after, 1))
    if not element:
        points.read_sweep(path)
        return
    with pytest.raises(InputError) as refused:
        points.read_sweep(path)
    assert refused.value.path == str(path)
    assert refused.value.element == element
    assert problem in refused.value.problem


def test_names_rows_that_do_not_belong_together(tmp_path):
    with pytest.raises(InputError, match="line 3: has point, participant, haptic, rotation 1 1 NoH "
                                         "NoR again; expected each once"):
        points.read_sweep(sweep_file(tmp_path, GOOD, GOOD))
    other = GOOD.replace(",NoH,", ",H,").replace(",1000,", ",500,")
    with pytest.raises(InputError, match="point 1, column stiffness_N_per_m: has several values"):
        points.read_sweep(sweep_file(tmp_path, GOOD, other))
    with pytest.raises(InputError, match="line 1: has other columns; expected point,block,"):
        path = sweep_file(tmp_path, GOOD)
        path.write_text(path.read_text().replace("point,", "points,", 1))
        points.read_sweep(path)
    with pytest.raises(InputError, match="has no row; expected"):
        points.read_sweep(sweep_file(tmp_path))


def test_refuses_what_is_no_run(tmp_path):
    path = tmp_path / "run.json"
    for text, problem in (("{", "is not JSON"), ("[]", "/plan/name: is no value"),
                          ('{"plan": {"name": "a"}, "seed": "1"}', "/seed: is no value")):
        path.write_text(text)
        with pytest.raises(InputError, match=problem):
            read_run(path)
