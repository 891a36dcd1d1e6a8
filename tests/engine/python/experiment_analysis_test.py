"""The analysis of trials: its tests by their definitions, missing trials, verdicts and refusals."""

from __future__ import annotations

from collections import defaultdict

import numpy as np
import pandas as pd
import pytest

from experiment_samples import LIMIT_S, analysed, analysed_all, end_as, frame_of, where, without
from palpate.analysis.errors import InputError
from palpate.analysis.experiment.analysis import analyse_trials, check_rows
from palpate.analysis.experiment import paper
from palpate.analysis.experiment.verdicts import (
    AGREES, DISAGREES, NOT_TESTABLE, UNDECIDED, comparisons_of, verdict_of)  # fmt: skip
from palpate.analysis.experiment.outcomes import (
    ANGLE, LOSS_RATE, LOSSES, PENETRATION, TIME, TIME_TO_LIMIT)  # fmt: skip
from palpate.analysis.experiment.paper import FINDINGS, MANOVA
from palpate.analysis.statistics import effect_name
from sample_trials import SampleTrials, SeededRandom, sample_trials

HAPTIC, ROTATION = ("Haptic",), ("Rotation",)


@pytest.fixture(scope="module")
def sample():
    return analysed(sample_trials())


def close(expected):
    return pytest.approx(expected, rel=1e-9)


def between_ss(rows, measure, group):
    """The sum of squares between groups of rows, about the mean of all."""
    groups = defaultdict(list)
    for row in rows:
        if row["block"] > 0:
            groups[group(row)].append(row[measure])
    values = np.concatenate(list(groups.values()))
    return sum(len(g) * (np.mean(g) - values.mean()) ** 2 for g in groups.values())


def cell(row):
    return row["haptic"], row["rotation"], row["object"], row["block"]


def cell_of_participant(row):
    return *cell(row), row["participant"]


def haptic(row):
    return row["haptic"]


def participant(row):
    return row["participant"]


def test_papers_analysis_has_the_degrees_of_freedom_of_the_paper(sample):
    assert sample.paper.trials == 720
    assert sample.paper.error_df == 648
    assert len(sample.paper.manova) == 15
    for term, (_, _, df2) in MANOVA.items():
        found = sample.paper.manova.loc[[term]].iloc[0]
        assert found["df2"] == pytest.approx(df2, abs=0.05), effect_name(term)


# On full data the sums of squares are those between groups of rows.
def test_f_of_the_papers_analysis_is_that_of_the_definition(sample):
    rows = sample_trials()
    effect = between_ss(rows, "total_time_s", haptic)
    error = between_ss(rows, "total_time_s", cell_of_participant)
    error -= between_ss(rows, "total_time_s", cell)
    test = sample.paper.anovas[TIME].loc[[HAPTIC]].iloc[0]
    assert test["f"] == close(effect / 2.0 / (error / 648.0))
    assert sample.paper.mean_square_errors[TIME] == close(error / 648.0)
    assert test["partial_eta2"] == pytest.approx(effect / (effect + error), abs=1e-12)


def test_pairs_are_compared_only_after_a_significant_f(sample):
    without_effects = analysed(sample_trials(SampleTrials(effects=0.0, seed=5)))
    has_haptic = {}
    for name, analysis in [("with", sample), ("without", without_effects)]:
        for outcome, anova in analysis.paper.anovas.items():
            plsd = analysis.paper.plsd[outcome]
            has = len(plsd) > 0 and "Haptic" in set(plsd["factor"])
            assert has == (anova["p"].iloc[0] < 0.05)
            has_haptic[name, outcome] = has
    assert has_haptic["with", PENETRATION]
    assert not has_haptic["without", PENETRATION]


# One factor, F = SS_c / (k - 1) over SS_e / ((k - 1)(n - 1)), SS_e = SS_t - SS_c - SS_s of the
# participants' means.
def test_f_of_the_primary_analysis_is_that_of_the_definition(sample):
    rows = sample_trials()
    effect = between_ss(rows, "total_time_s", haptic)
    error = between_ss(rows, "total_time_s", lambda row: (haptic(row), participant(row)))
    error -= effect + between_ss(rows, "total_time_s", participant)
    found = sample.primary[TIME].effect(HAPTIC)
    assert found["participants"] == 10
    assert found["f"] == close(effect / 2.0 / (error / 18.0))
    assert found["df2"] == 18.0


def test_primary_analysis_has_effects_comparisons_and_means(sample):
    depth = sample.primary[PENETRATION]
    assert len(depth.effects) == 15
    assert list(depth.pairs.groupby("family").size()) == [3, 3]
    assert len(depth.means) == 3 + 2 + 6
    assert depth.pairs["pair"][0] == "UaH - NoH"
    assert depth.pairs["difference"][0] < 0.0
    assert len(sample.angle_of_uah.effects) == 7  # Rotation, Object, Trial
    assert len(sample.angle_of_uah.means) == 2
    rotation = sample.angle_of_uah.effect(ROTATION)
    assert (rotation["df1"], rotation["df2"]) == (1.0, 9.0)


# The practice block has values a hundred times as large.
def test_practice_is_left_out(sample):
    with_practice = sample.primary[TIME].means["mean"][0]
    rows = without(sample_trials(), block=0)
    assert with_practice == analysed(rows).primary[TIME].means["mean"][0]
    assert with_practice < 50.0


def test_order_of_rows_does_not_matter():
    rows = sample_trials(SampleTrials(followings=("delayed", "frozen"), has_timeouts=True))
    first = analysed_all(rows)
    random = SeededRandom(18201)
    for i in range(len(rows) - 1, 0, -1):
        j = random.index(i + 1)
        rows[i], rows[j] = rows[j], rows[i]
    second = analysed_all(rows)
    assert len(first.operators) == 2
    for a, b in zip(first.operators, second.operators):
        assert a.experiment.name == b.experiment.name
        assert a.paper.manova.equals(b.paper.manova)
        for outcome, primary in a.primary.items():
            assert primary.effects.equals(b.primary[outcome].effects)
        assert [f.because for f in a.findings] == [f.because for f in b.findings]


def test_missing_trial_of_three_blocks_leaves_only_the_effects_with_trial():
    rows = sample_trials()
    at = {"haptic": "UaH", "rotation": "R", "object": "O2"}
    end_as("timeout", where(rows, participant="3", block=2, **at))
    analysis = analysed(rows)
    assert (analysis.paper.trials, analysis.paper.error_df) == (719, 647)
    time = analysis.primary[TIME]
    for effect in time.effects.itertuples():
        assert effect.participants == (9 if "Trial" in effect.term else 10)
    assert pairs_of(time)["R - NoR in UaH"] == 10
    assert (analysis.experiment.total["done"], analysis.experiment.total["timeouts"]) == (719, 1)
    # Once more, with the timeout as the limit.
    limited = analysis.primary[TIME_TO_LIMIT]
    assert (limited.effects["participants"] == 10).all()
    assert limited.mean(rotation="R")["mean"] > time.mean(rotation="R")["mean"]
    assert analysis.experiment.grid(TIME_TO_LIMIT)[2, 1, 1, 1, 1] == LIMIT_S


def pairs_of(primary):
    return dict(zip(primary.pairs["pair"], primary.pairs["pairs"]))


# A cell is the mean of the blocks that are there, and cells count equally.
def test_cells_count_equally_whatever_their_blocks():
    rows = sample_trials(SampleTrials(participants=2, objects=("O1", "O2")))
    for row in rows:
        row["total_time_s"] = 10.0 if row["object"] == "O1" else 30.0
    rows[12]["total_time_s"] = 11.0  # of NoH: the measure is not constant
    for block in (2, 3):
        rows = without(rows, participant="1", object="O2", block=block, haptic="UaH")
    mean = analysed(rows).primary[TIME].mean("UaH")
    assert mean["mean"] == pytest.approx(20.0, abs=1e-12)


def test_participant_with_an_empty_cell_leaves_what_needs_it():
    rows = sample_trials()
    empty = {"participant": "3", "haptic": "UaH", "rotation": "R", "object": "O2"}
    end_as("fault", [row for row in where(rows, **empty) if row["block"] > 0])
    rows = without(rows, participant="7", haptic="H", rotation="NoR", object="O4", block=3)
    analysis = analysed(rows)
    time = analysis.primary[TIME]
    assert time.effect(HAPTIC)["participants"] == 9
    assert time.effect(("Haptic", "Trial"))["participants"] == 8
    pairs = pairs_of(time)
    assert pairs["UaH - NoH"] == 9
    assert pairs["H - NoH"] == 10
    assert pairs["R - NoR in NoH"] == 10
    assert pairs["R - NoR in UaH"] == 9
    assert analysis.angle_of_uah.effect(ROTATION)["participants"] == 9
    assert (analysis.experiment.total["faults"], analysis.experiment.total["absent"]) == (3, 1)
    assert analysis.experiment.missing == 4


def test_effect_of_fewer_than_two_participants_is_not_testable():
    rows = sample_trials(SampleTrials(participants=2))
    empty = {"participant": "2", "haptic": "UaH", "rotation": "R", "object": "O2"}
    end_as("timeout", [row for row in where(rows, **empty) if row["block"] > 0])
    analysis = analysed(rows)
    effect = analysis.primary[TIME].effect(HAPTIC)
    assert effect["participants"] == 1
    assert np.isnan(effect["f"])
    assert analysis.findings[0].verdict == NOT_TESTABLE
    assert analysis.findings[0].by_the_papers_test in (AGREES, DISAGREES)


def test_block_without_a_trial_of_a_condition_leaves_out_trial():
    rows = without(sample_trials(), haptic="H", rotation="R", object="O3", block=2)
    analysis = analysed(rows)
    assert len(analysis.paper.manova) == 7
    assert analysis.notes == [
        "Trial is left out, because no trial of H, R, O3 in block 2 was completed."
    ]


def test_following_without_a_completed_trial_of_a_condition_is_reported():
    rows = sample_trials(SampleTrials(followings=("delayed", "frozen")))
    at = {"haptic": "NoH", "rotation": "R", "object": "O1"}
    end_as("timeout", where(rows, following="frozen", **at))
    delayed, frozen = analysed_all(rows).operators
    assert delayed.paper
    assert frozen.paper is None
    problem = "No trial of NoH, R, O1 was completed: its effects cannot be separated."
    assert frozen.paper_problem == problem
    # Alone it is refused.
    alone = where(rows, following="frozen")
    expected = "^following frozen, condition NoH, R, O1: has no completed trial"
    with pytest.raises(InputError) as refused:
        analysed(alone)
    assert str(refused.value).startswith(expected[1:])


def test_files_of_people_are_analysed():
    design = SampleTrials(participants=4, blocks=1, rotation=("NoR",),
                          objects=("cup", "Vase 10", "Vase 2"))  # fmt: skip
    rows = sample_trials(design)
    for row in rows:
        row["participant"] = "P" + row["participant"]
        for column in ("mean_penetration_dm", "losses_per_s", "losses_100ms",
                       "mean_contact_angle_deg"):  # fmt: skip
            del row[column]  # the penetration is in metres alone
    all_ = analysed_all(rows)
    assert not all_.has_simulated
    analysis = all_.operators[0]
    assert analysis.experiment.name == "people"
    assert analysis.experiment.levels["Object"] == ["Vase 2", "Vase 10", "cup"]
    assert len(analysis.paper.manova) == 3  # Haptic and Object
    assert list(analysis.paper.anovas) == [TIME, LOSSES, PENETRATION]
    assert analysis.primary[PENETRATION].mean("H")["mean"] == pytest.approx(0.031, abs=0.02)
    assert LOSS_RATE in analysis.primary
    assert analysis.angle_of_uah is None
    assert {
        "Rotation is left out, because the file has one level of it: NoR.",
        "Trial is left out, because the file has one level of it: 1.",
        "The file does not have the column mean_contact_angle_deg, so that there is no analysis of "
        "mean contact angle.",
    } <= set(analysis.notes)
    assert analysis.findings[1].verdict == NOT_TESTABLE  # Rotation


def test_last_attempt_counts():
    rows = sample_trials()
    [row] = where(rows, participant="3", block=2, haptic="UaH", rotation="R", object="O2")
    rows.append({**row, "attempt": 2})
    end_as("fault", [row])
    analysis = analysed(rows)
    assert analysis.paper.trials == 720
    assert analysis.notes[0] == (
        "Of several attempts at a trial the last completed one counts, or the last one if none was "
        "completed; other attempts: 1 (fault 1)."
    )


def test_the_last_completed_attempt_counts_whatever_comes_after_it():
    rows = sample_trials()
    [row] = where(rows, participant="3", block=2, haptic="UaH", rotation="R", object="O2")
    later = [{**row, "attempt": n, "total_time_s": 1.0} for n in (3, 2)]
    rows += later
    assert analysed(rows).experiment.repeated == {"done": 2}
    expected = analysed([r for r in rows if r is not row and r is not later[1]])
    ends = {"timeout": "", "fault": "", "aborted": "server", "skipped": "experimenter"}
    for status, reason in ends.items():
        cut(status, reason, later[:1])
        found = analysed(rows).experiment
        assert found.repeated == {"done": 1, reason or status: 1}
        assert found.missing == 0
    assert found.trials["time"].min() == 1.0 == expected.experiment.trials["time"].min()


def cut(status, reason, rows):
    end_as(status, rows)
    for row in rows:
        row["reason"] = reason


def test_a_trial_that_was_cut_is_missing_unless_it_was_completed_later():
    rows = sample_trials()
    again = where(rows, participant="3", block=2, haptic="UaH", rotation="R")
    rows += [{**row, "attempt": 2} for row in again]
    cut("aborted", "focus", again[:3])
    cut("aborted", "hidden", again[3:])
    cut("aborted", "trip", where(rows, participant="5", block=1, haptic="H", object="O1"))
    cut("skipped", "participant", where(rows, participant="9", block=3, object="O4", haptic="H"))
    experiment = analysed(rows).experiment
    assert experiment.repeated == {"focus": 3, "hidden": 1}
    assert experiment.total == {"done": 716, "timeouts": 0, "faults": 0, "aborted": 2, "skipped": 2,
                                "absent": 0}
    assert experiment.missing == 4
    reasons = experiment.counts["reasons"]
    assert reasons["all", "all", "all"] == "aborted: trip 2; skipped: participant 2"
    assert reasons["H", "R", "O1"] == "aborted: trip 1"
    assert reasons["H", "NoR", "O4"] == "skipped: participant 1"
    assert reasons["UaH", "R", "O1"] == ""
    # The other trials are analysed as if there were no such rows.
    kept = [row for row in rows if row["status"] == "done"]
    alone, whole = analysed(kept), analysed(rows)
    assert alone.experiment.total["absent"] == 4
    for outcome, primary in whole.primary.items():
        pd.testing.assert_frame_equal(primary.effects, alone.primary[outcome].effects)
        pd.testing.assert_frame_equal(primary.pairs, alone.primary[outcome].pairs)


def test_rows_of_a_pilot_run_are_left_out():
    rows = sample_trials()
    pilots = [{**row, "pilot": 1, "total_time_s": 500.0} for row in where(rows, participant="1")]
    analysis = analysed_all(rows + pilots)
    assert analysis.pilot_rows == len(pilots)
    alone = analysed_all(rows)
    assert alone.pilot_rows == 0
    for outcome, primary in analysis.operators[0].primary.items():
        expected = alone.operators[0].primary[outcome]
        pd.testing.assert_frame_equal(primary.effects, expected.effects)
    check_rows(frame_of([*end_one_late(rows), *pilots]), LIMIT_S)
    with pytest.raises(InputError) as refused:
        analysed_all(pilots)
    assert str(refused.value).startswith("column pilot: is 1 in every row; expected trials that")


def end_one_late(rows):
    """With a timeout, so that a time beyond the limit would be refused."""
    end_as("timeout", rows[-1:])
    return rows


def test_findings_of_the_papers_means_agree():
    analysis = analysed(sample_trials(SampleTrials(participants=40)))
    assert len(analysis.findings) == len(FINDINGS)
    for result in analysis.findings:
        # The sample plants no interactions of Object and Trial. The scatter of its losses is so
        # large that 40 people do not show that an interaction is smaller than the margin.
        if "Object x" in result.finding.name:
            assert result.by_the_papers_test == DISAGREES
        elif result.finding.name == "losses of contact, Rotation":  # larger than the paper's
            assert result.because.endswith("larger here")
        elif result.finding.claim is paper.Claim.NO_EFFECT:
            assert result.verdict in (AGREES, UNDECIDED)
            assert result.by_the_papers_test == AGREES
        else:
            assert result.verdict == AGREES, f"{result.finding.name}: {result.because}"


def test_findings_of_the_opposite_order_disagree():
    analysis = analysed(sample_trials(SampleTrials(participants=40, effects=-1.0)))
    for order in (0, 1, 3, 4, 6, 9):
        assert analysis.findings[order].verdict == DISAGREES, FINDINGS[order].name


def test_findings_state_test_and_means(sample):
    assert FINDINGS[0].printed == "F(2, 648) = 12.141; H 25, UaH 27.5, NoH 29 s"
    assert FINDINGS[9].printed == "F(1, 9) = 162.31; R 32.1, NoR 49.4 deg"
    assert FINDINGS[10].printed == "lambda = 0.236, F = 228.207"
    because = sample.findings[6].because
    assert because.startswith("UaH - H 0.0368 dm (0.0343 to 0.0393), p < 0.001; the paper 0.037 dm (")
    assert "; NoH - UaH 0.0323 dm (" in because
    assert sample.findings[8].because.startswith("F(2, 18) = ")


# The differences of the paper, and their intervals, by hand.


def test_difference_of_two_levels_has_the_standard_error_of_its_f():
    found = paper.difference(TIME, "R", "NoR")
    share = 1.9636316281059747 / 29.674**0.5  # t(0.975; 648) / t
    assert found.difference == close(29.15 - 25.14)
    assert found.low == close((4.01 - 0.01) * (1.0 - share))  # of means with two decimals
    assert found.high == close((4.01 + 0.01) * (1.0 + share))
    angle = paper.difference(ANGLE, "NoR", "R")
    share = 2.262157162798205 / 162.31**0.5  # t(0.975; 9) / t
    assert angle.high == close((17.3 + 0.1) * (1.0 + share))


def test_difference_of_three_levels_has_the_standard_error_of_their_f():
    found = paper.difference(LOSSES, "NoH", "UaH")
    mean_square = 240.0 * ((24 - 67 / 3) ** 2 + (22 - 67 / 3) ** 2 + (21 - 67 / 3) ** 2) / 2.0
    error = (2.0 * mean_square / 19.139 / 240.0) ** 0.5
    assert found.difference == 2.0
    assert found.low == close(2.0 - 1.0 - 1.9636316281059747 * error)  # means without decimals
    assert found.high == close(2.0 + 1.0 + 1.9636316281059747 * error)


def test_margin_is_half_of_the_smallest_significant_difference():
    margins = [paper.equivalence_margin(outcome) for outcome in (TIME, LOSSES, PENETRATION)]
    assert margins == pytest.approx([0.75, 0.5, 0.0165])


def with_effect(change, people=10):
    """The analysis of people without effects but what change() does to rows of R."""
    rows = sample_trials(SampleTrials(participants=people, effects=0.0, objects=("O1", "O2")))
    for row in where(rows, rotation="R"):
        change(row)
    return analysed(rows)


@pytest.mark.parametrize(
    ("seconds", "people", "verdict", "how"),
    [
        (4.0, 10, AGREES, ""),
        (0.5, 3, UNDECIDED, ""),
        (0.5, 10, DISAGREES, ": smaller here"),
        (-4.0, 10, DISAGREES, ": the other way here"),
        (20.0, 10, DISAGREES, ": larger here"),
    ],
)
def test_verdict_of_an_order_compares_effects(seconds, people, verdict, how):
    def change(row):
        row["total_time_s"] += seconds

    result = with_effect(change, people).findings[1]
    assert result.finding.name == "total time, Rotation"
    assert result.verdict == verdict, result.because
    assert result.because.endswith("(2.56 to 5.47)" + how)
    [comparison] = result.comparisons
    assert comparison.margin is None
    assert comparison.p == comparison.p_holm


@pytest.mark.parametrize(
    ("depth_dm", "verdict"), [(0.0, AGREES), (0.0165, UNDECIDED), (-0.03, DISAGREES)]
)
def test_verdict_of_no_effect_is_equivalence(depth_dm, verdict):
    def change(row):
        row["mean_penetration_dm"] += depth_dm

    result = with_effect(change).findings[7]
    assert result.finding.name == "mean penetration, Rotation"
    assert result.verdict == verdict, result.because
    assert "within \u00b10.0165 dm: p " in result.because


def test_two_one_sided_tests_are_those_of_statsmodels(sample):
    from statsmodels.stats.weightstats import ttost_paired

    cells = sample.primary[TIME].cells
    turns = cells[:, :, 1] - cells[:, :, 0]
    comparisons = sample.findings[2].comparisons
    assert [c.name for c in comparisons][0] == "R - NoR in UaH, less in NoH"
    for comparison, (a, b) in zip(comparisons, [(1, 0), (2, 0), (2, 1)]):
        p, *_ = ttost_paired(turns[:, a], turns[:, b], -0.75, 0.75)
        assert comparison.p == close(p)
    assert sample.findings[2].verdict == UNDECIDED
    assert sample.findings[2].by_the_papers_test == AGREES


# The intervals of three comparisons hold together: each has a coverage of 1 - 0.05 / 3.
def test_intervals_of_a_finding_hold_together(sample):
    from scipy.stats import t as student

    [first, *_] = sample.findings[0].comparisons
    pair = sample.primary[TIME].pairs.iloc[2]
    assert (first.name, pair["pair"]) == ("UaH - H", "H - UaH")
    assert first.ours.difference == close(-pair["difference"])
    half = first.ours.high - first.ours.difference
    t = student.isf(0.05 / 6.0, 9)
    assert half == pytest.approx(t * pair["standard_error"], rel=1e-7)
    of_haptic = sample.primary[TIME].pairs[:3]
    assert [c.p_holm for c in sample.findings[0].comparisons] == pytest.approx(
        list(of_haptic["p_holm"])[::-1], rel=1e-9
    )


def test_one_comparison_decides(sample):
    finding = sample.findings[0].finding
    assert verdict_of([]) == NOT_TESTABLE
    all_ = comparisons_of(sample.experiment, sample.primary[TIME], finding)
    assert verdict_of(all_) == AGREES
    angle = where_verdict(sample, UNDECIDED)
    assert verdict_of([*all_, angle]) == UNDECIDED


def where_verdict(analysis, verdict):
    return next(c for f in analysis.findings for c in f.comparisons if c.verdict == verdict)


# Refusals

EMPTY = {"haptic": "UaH", "rotation": "R", "object": "O2"}


def put(rows, **values):
    for row in rows:
        row.update(values)


def leave_out(rows, *columns):
    for row in rows:
        for column in columns:
            row.pop(column, None)


def with_objects_of_numbers(rows):
    for i, row in enumerate(rows):
        row["object"] = str(i)


def with_depth_from_losses(rows):
    for row in rows:
        row["mean_penetration_dm"] = 0.001 * row["losses_of_contact"] + 0.1


def only(rows, **values):
    rows[:] = where(rows, **values)


def drop(rows, **values):
    rows[:] = without(rows, **values)


READER = "line "
AT_30 = "participant 1, block 1, NoH, R, O3, "
REFUSED = {
    "practice alone": (
        lambda rows: only(rows, block=0),
        "participant: has 0 levels beside practice; expected two participants or more"),
    "one participant": (
        lambda rows: only(rows, participant="4"),
        "participant: has 1 level beside practice; expected two participants or more"),
    "unknown force": (
        lambda rows: put(rows[30:31], haptic="h"),
        'line 32, column haptic: is "h"; expected NoH, UaH, H, seen-UaH or seen-H'),
    "a seen force among felt ones": (
        lambda rows: put(where(rows, haptic="H"), haptic="seen-H"),
        "column haptic: has seen-H and UaH; expected forces that are seen, or forces that are felt"),
    "unknown rotation": (
        lambda rows: put(rows[30:31], rotation=""),
        'line 32, column rotation: is ""; expected NoR or R'),
    "unknown following": (
        lambda rows: put(rows[30:31], following="Delayed"),
        'line 32, column following: is "Delayed"; expected delayed, predict, replan, frozen, '
        "adapts-0, adapts-0.5 or adapts-1"),
    "a column of numbers taken for objects": (
        with_objects_of_numbers, "object and block: have "),
    "doubled row": (
        lambda rows: rows.append(rows[30]),
        "line 962: has the trial of line 32 again: participant 1, block 1, NoH, R, O3"),
    "not a number": (
        lambda rows: put(rows[30:31], mean_contact_angle_deg="nan"),
        'line 32, column mean_contact_angle_deg: is "nan"; expected a finite number'),
    "no value": (
        lambda rows: leave_out(rows[30:31], "losses_of_contact"),
        AT_30 + "losses_of_contact: is empty; expected a number"),
    "no column": (
        lambda rows: leave_out(rows, "total_time_s"),
        "total_time_s: is in no completed trial"),
    "no penetration": (
        lambda rows: leave_out(rows, "mean_penetration_m", "mean_penetration_dm"),
        "mean_penetration_dm: is in no completed trial"),
    "condition without a row": (
        lambda rows: drop(rows, **EMPTY), "condition UaH, R, O2: has no trial"),
    "condition without a completed trial": (
        lambda rows: end_as("timeout", where(rows, **EMPTY)),
        "condition UaH, R, O2: has no completed trial"),
    "constant measure": (
        lambda rows: put(rows, losses_of_contact=7.0),
        "losses_of_contact: is constant within the conditions"),
    "measure that follows from another": (
        with_depth_from_losses,
        "mean_penetration_dm: is constant within the conditions, or follows from the measures "
        "before it"),
    "constant angle": (
        lambda rows: put(rows, mean_contact_angle_deg=45.0),
        "mean_contact_angle_deg: is 45 in every trial; expected a measure that varies"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_refusals_name_what_to_change(name):
    change, message = REFUSED[name]
    rows = sample_trials()
    change(rows)
    with pytest.raises(InputError) as refused:
        analysed(rows)
    error = refused.value
    error.path = ""
    assert str(error).startswith(message)


SEEN = ("NoH", "seen-UaH", "seen-H")


def test_a_seen_force_is_a_claim_about_seeing():
    felt, seen = analysed(sample_trials()), analysed(sample_trials(SampleTrials(haptic=SEEN)))
    assert seen.experiment.levels["Haptic"] == list(SEEN), "in the order of the felt ones"
    for outcome, primary in felt.primary.items():
        assert list(seen.primary[outcome].means["mean"]) == list(primary.means["mean"])
    assert {found.verdict for found in seen.findings} == {NOT_TESTABLE}
    assert {found.by_the_papers_test for found in seen.findings} <= {None, NOT_TESTABLE}
    assert all("claim about seeing" in found.because for found in seen.findings)
    assert any("claim about seeing" in note for note in seen.notes)
    assert not any("claim about seeing" in note for note in felt.notes)


def test_file_without_trials_is_refused():
    empty = frame_of(sample_trials()).iloc[:0]
    with pytest.raises(InputError, match="expected trials of two participants or more"):
        analyse_trials(empty, LIMIT_S)


# Trials with several levels of view, start orientation or scale


def trials_of(following, seed, participants=4, view="turning", start=0.0, scale=1.0):
    rows = sample_trials(SampleTrials((following,), participants, blocks=2, seed=seed))
    put(rows, view=view, start_orientation_deg=start, scale=scale)
    return rows


def test_each_variant_is_analysed_as_if_it_were_alone():
    first, second = trials_of("delayed", 1), trials_of("delayed", 2, start=45.0)
    both = analysed_all(second + first)  # the order of rows has no influence
    assert both.variants == 2
    assert [each.experiment.name for each in both.operators] == ["delayed", "delayed, start 45 deg"]
    alone = analysed_all(first), analysed_all(second)
    assert alone[1].operators[0].experiment.name == "delayed, start 45 deg"
    for together, each in zip(both.operators, alone):
        assert list(together.primary) == list(each.operators[0].primary)
        for outcome, primary in each.operators[0].primary.items():
            assert together.primary[outcome].means.equals(primary.means)
            assert together.primary[outcome].effects.equals(primary.effects)
    assert not alone[0].differences


# Two participants, one condition each way, numbers by hand.
def test_differences_are_means_over_trials_that_both_completed():
    rows = []

    def add(participant, block, object_, start, time_s, status="done"):
        row = {"following": "delayed", "participant": participant, "block": block, "trial": 1,
               "haptic": "UaH", "rotation": "R", "object": object_, "attempt": 1,
               "status": status, "start_orientation_deg": float(start)}  # fmt: skip
        rows.append({**row, **({"total_time_s": time_s} if status == "done" else {})})

    # Participant 1: differences 1, 3 and, after a timeout, none. Mean 2.
    add("1", 1, "O1", 0, 10)
    add("1", 1, "O1", 90, 11)
    add("1", 2, "O1", 0, 20)
    add("1", 2, "O1", 90, 23)
    add("1", 1, "O2", 0, 30)
    add("1", 1, "O2", 90, 0, "timeout")
    # Participant 2: difference 6. Practice does not count.
    add("2", 0, "O1", 0, 1)
    add("2", 0, "O1", 90, 1000)
    add("2", 1, "O1", 0, 10)
    add("2", 1, "O1", 90, 16)
    # Participant 3: no pair.
    add("3", 1, "O1", 0, 10)
    add("3", 2, "O1", 90, 17)
    analysis = analysed_all(rows)
    assert len(analysis.operators) == 2
    time, to_limit = analysis.differences
    assert (time.outcome, time.haptic, time.rotation) == (TIME, "UaH", "R")
    assert time.test.pairs == 2
    assert time.test.difference == pytest.approx(4.0, rel=1e-15)
    assert time.test.t == pytest.approx(2.0, rel=1e-15)  # 4 / (sqrt(8) / sqrt(2))
    # t(0.975; 1) s / sqrt(2)
    assert time.test.half_width == pytest.approx(12.706204736174696 * 2.0, rel=1e-12)
    # With the timeout as the limit, participant 1 has (1 + 3 + 90) / 3.
    assert to_limit.outcome is TIME_TO_LIMIT
    assert to_limit.test.difference == pytest.approx(((1 + 3 + 90) / 3 + 6) / 2, abs=1e-12)


def names_of_pairs(analysis):
    return {f"{each.second.name} - {each.first.name}" for each in analysis.differences}


# Pairs that differ in one setting.
def test_still_view_is_compared_with_the_first_following_of_the_turning_one():
    rows = trials_of("delayed", 1) + trials_of("predict", 2)
    rows += trials_of("delayed", 3, scale=0.5) + trials_of("predict", 4, scale=0.5)
    for following in ("adapts-0", "adapts-0.5", "adapts-1"):
        rows += trials_of(following, 5, view="still")
    analysis = analysed_all(rows)
    assert analysis.variants == 3
    assert names_of_pairs(analysis) == {
        "delayed, scale 0.5 - delayed",
        "predict, scale 0.5 - predict",
        "adapts-0 - delayed",
        "adapts-0.5 - delayed",
        "adapts-1 - delayed",
    }


def test_people_are_not_paired_with_simulated_persons():
    rows = trials_of("", 1) + trials_of("", 2, view="still")
    rows += trials_of("delayed", 3) + trials_of("adapts-0", 4, view="still")
    analysis = analysed_all(rows)
    assert names_of_pairs(analysis) == {"people, view still - people", "adapts-0 - delayed"}


def test_differences_by_rounding_alone_have_no_test():
    rows = trials_of("delayed", 1)
    turned = [{**row, "start_orientation_deg": 45.0} for row in rows]
    for row in turned[::3]:
        row["total_time_s"] = float(np.nextafter(row["total_time_s"], 1e9))
    for difference in analysed_all(rows + turned).differences:
        assert np.isnan(difference.test.p)


# Many levels of one setting are compared with the first one only.
def test_differences_grow_with_the_number_of_levels_and_not_with_its_square():
    one = trials_of("delayed", 1, participants=2)
    levels = 20
    rows = [{**row, "start_orientation_deg": 5.0 * i} for i in range(levels) for row in one]
    assert len(analysed_all(rows).differences) == (levels - 1) * 4 * 6
    for level in range(levels, 101):
        rows += [{**row, "start_orientation_deg": 3.0 * level / 2 + 100.0} for row in one]
    with pytest.raises(InputError) as refused:
        analysed_all(rows)
    assert "101 experiments; expected at most 100" in refused.value.problem


def test_errors_name_the_variant():
    rows = trials_of("delayed", 1) + trials_of("delayed", 2, participants=1, start=45.0)
    with pytest.raises(InputError) as refused:
        analysed_all(rows)
    assert "following delayed, start 45 deg, participant" in refused.value.element
