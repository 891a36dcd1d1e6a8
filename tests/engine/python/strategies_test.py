"""Means, paired differences and ranks of strategies, against tables computed by hand."""

import argparse
import json
import math

import numpy as np
import pandas as pd
import pytest

from page_text import visible_text
from palpate.analysis.errors import InputError
from palpate.analysis.strategies import command, text
from palpate.analysis.strategies.comparison import (
    compare,
    intervals,
    is_comparable,
    is_tie_of_all,
    leaders,
)
from palpate.analysis.strategies.differences_figure import (
    BETTER,
    UNDECIDED,
    WORSE,
    differences_figure,
)
from palpate.analysis.strategies.measures import MEASURES
from palpate.analysis.strategies.names import meaning

# Student's t with P(|T| > t) = 0.05, in closed form: with one degree of freedom T is Cauchy, so
# t = tan(0.475 pi); with two, t = p sqrt(2 / (1 - p^2)) with p = 0.95.
T1 = math.tan(0.475 * math.pi)
T2 = 0.95 * math.sqrt(2.0 / (1.0 - 0.95**2))


def near(expected):
    """Rounding of a handful of operations on numbers of this size, and of SciPy's quantile."""
    return pytest.approx(expected, rel=1e-12, abs=0.0)


def of_hands(*values):
    """Mean, half width and count of one value of each hand."""
    cells = np.array(values, dtype=float).reshape(1, len(values), 1, 1)
    return [each.item() for each in intervals(cells)]


def test_an_interval_is_students():
    mean, half_width, hands = of_hands(1.0, 3.0)
    assert (mean, hands) == (2.0, 2)
    assert half_width == near(T1)  # sd sqrt(2), over sqrt(2)
    mean, half_width, _ = of_hands(2.0, 4.0, 9.0)
    assert mean == 5.0
    assert half_width == near(T2 * math.sqrt(13.0 / 3.0))  # sd^2 = (9 + 1 + 16) / 2


def test_an_interval_holds_zero_unless_the_mean_is_farther_from_it_than_half_of_it():
    def excludes_zero(*values):
        mean, half_width, _ = of_hands(*values)
        return abs(mean) > half_width

    assert not excludes_zero(-1.0, 2.0, 1.0)
    assert excludes_zero(-1.0, -1.0, -1.5)
    assert not excludes_zero(0.0, 0.0)
    assert not excludes_zero(1.0, 1.0), "equal values have no interval"
    assert not excludes_zero(1.0), "one value has no interval"
    assert not excludes_zero(math.nan)
    assert of_hands(math.nan)[2] == 0


def test_equal_values_have_no_interval():
    """Also where the mean rounds, and for two hands as for seven."""
    for hands in (2, 7):
        mean, half_width, count = of_hands(*(0.1 + 0.2 for _ in range(hands)))
        assert mean == near(0.3) and math.isnan(half_width) and count == hands
    assert of_hands(*6 * (0.3,), 0.3 + 1e-9)[1] > 0.0, "a spread, however small"


def trial(strategy, hand, scene, angle_deg, **more):
    """A completed trial with this contact angle; other measures have no value."""
    return {"following": "delayed", "participant": str(hand), "block": 1, "trial": 1,
            "object": scene, "attempt": 1, "status": "done", "strategy": strategy,
            "mean_contact_angle_deg": float(angle_deg), "device_travel_m": math.nan, **more}


# Angles of three hands on the scenes A and B: none 9 everywhere.
ANGLES = {"none": ((9, 9, 9), (9, 9, 9)), "mask": ((40, 42, 44), (50, 52, 54)),
          "a4": ((10, 14, 15), (20, 22, 27)), "cd": ((12, 16, 11), (22, 20, 21))}


WORKSPACE_M = 0.5


def small_trials():
    return [trial(strategy, hand + 1, scene, angles[hand])
            for strategy, of_scenes in ANGLES.items() for hand in range(3)
            for scene, angles in zip("AB", of_scenes)]


def compared(rows, strategies=tuple(ANGLES), scenes=("A", "B")):
    return compare(pd.DataFrame(rows), list(strategies), list(scenes), "delayed", WORKSPACE_M)


def entries(comparison, column="mean_contact_angle_deg", scene=""):
    """The rows of a measure, by strategy."""
    means = comparison.means
    rows = means[(means["column"] == column) & (means["scene"] == scene)]
    assert len(rows) > 0
    return rows.set_index("strategy", drop=False)


def leaders_in_order(rows):
    return [name for standing in ("best", "tied") for name in
            rows.loc[rows["standing"] == standing, "strategy"]]


def test_means_and_paired_differences_are_those_computed_by_hand():
    comparison = compared(small_trials())
    assert comparison.hands == 3
    assert comparison.scenes == ["", "A", "B"]
    angle = entries(comparison)
    assert list(angle.index) == list(ANGLES)
    # Means of hands: mask 45, 47, 49; a4 15, 18, 21; cd 17, 18, 16.
    assert angle.at["mask", "mean"] == 47.0
    assert angle.at["mask", "half_width"] == near(T2 * 2.0 / math.sqrt(3.0))
    assert angle.at["a4", "mean"] == 18.0
    assert angle.at["a4", "half_width"] == near(T2 * 3.0 / math.sqrt(3.0))
    assert angle.at["cd", "mean"] == 17.0
    # a4 - mask: -30, -29, -28. cd - a4: 2, 0, -5. a4 - a4 does not exist.
    assert angle.at["a4", "minus_mask"] == -29.0
    assert angle.at["a4", "mask_half_width"] == near(T2 / math.sqrt(3.0))
    assert angle.at["cd", "minus_a4"] == -1.0
    assert angle.at["cd", "a4_half_width"] == near(T2 * math.sqrt(13.0 / 3.0))
    assert pd.isna(angle.at["a4", "minus_a4"]) and pd.isna(angle.at["mask", "minus_mask"])
    assert pd.isna(angle.at["a4", "a4_hands"])
    # Scene B alone: a4 - mask is -30, -30, -27.
    assert entries(comparison, scene="B").at["a4", "minus_mask"] == -29.0
    assert entries(comparison, scene="B").at["a4", "mask_half_width"] == near(T2)


def test_techniques_are_ranked_and_references_are_not():
    comparison = compared(small_trials())
    angle = entries(comparison)
    assert angle.at["none", "standing"] == "", "none has 9 deg"
    assert leaders_in_order(angle) == ["cd", "a4"]
    assert angle.at["mask", "standing"] == ""
    assert not is_tie_of_all(angle)
    assert leaders(angle) == "cd (tied: a4)"
    # Nobody has a time: no leader. Nobody has a timeout: a tie.
    assert leaders(entries(comparison, "total_time_s")) == "-"
    assert leaders(entries(comparison, "status")) == "tie of all"


def test_a4_loses_only_where_the_interval_is_on_the_better_side():
    rows = small_trials()
    # Port work of hands: mask 1, 1, 2; a4 5, 5, 7; cd 4, 4, 9: a4 - cd is 1, 1, -2.
    port = {"mask": (1, 1, 2), "a4": (5, 5, 7), "cd": (4, 4, 9)}
    for row in rows:
        if row["strategy"] in port:
            row["port_work_J"] = 1e-3 * port[row["strategy"]][int(row["participant"]) - 1]
    losses = text.losses_by_strategy(compared(rows), "+-")
    # 9 - 18 with sd 3: the half width is 4.3027 sqrt(3) = 7.45.
    # -4, -4, -5: mean -4.333, sd 1 / sqrt(3), half width 4.3027 / 3 = 1.43.
    assert losses == [("none", " (a reference)", ["contact angle -9.00 +- 7.45 deg"]),
                      ("mask", "", ["port work -4.33 +- 1.43 mJ"])]


def values(**of_hands):
    """Trials on one scene with these drifts of each hand, m; None: no value."""
    return [trial(strategy, hand, "A", 1.0, **({} if drift_m is None else {"mean_drift_m": drift_m}))
            for strategy, drifts in of_hands.items() for hand, drift_m in enumerate(drifts, start=1)]


def standings(rows, names):
    comparison = compared(rows, names, ["A"])
    drift = entries(comparison, "mean_drift_m")
    return list(drift["standing"]), leaders(drift), comparison


def test_a_technique_without_a_value_makes_no_other_the_best():
    nothing = (None, None, None)
    found, lead, comparison = standings(values(mask=(1.0, 2.0, 4.0), a4=nothing), ["mask", "a4"])
    assert found == ["", ""] and lead == "- (only mask; no value: a4)"
    lines = text.comparison_text(comparison).splitlines()
    assert next(line for line in lines if line.startswith("mean drift")).split()[-2:] == ["2333", "-"]
    assert "not compared, because a4 has no value: mean drift" in lines
    assert "- no value: not ranked" in lines
    # Two that have a value are compared, and the third is named.
    rows = values(mask=(1.0, 2.0, 4.0), a4=nothing, cd=(8.0, 9.0, 12.0))
    found, lead, _ = standings(rows, ["mask", "a4", "cd"])
    assert found == ["best", "", ""] and lead == "mask (no value: a4)"
    rows = values(mask=(1.0, 2.0, 4.0), a4=nothing, cd=(1.0, 2.5, 3.5))
    found, lead, _ = standings(rows, ["mask", "a4", "cd"])
    assert sorted(found) == ["", "best", "tied"] and lead == "tie of all (no value: a4)"
    # A reference has nobody to beat, and neither has a technique alone.
    found, lead, _ = standings(values(none=(0.0, 0.0, 0.0), mask=(1.0, 2.0, 4.0)), ["none", "mask"])
    assert found == ["", ""] and lead == "- (only mask)"


def test_a_technique_that_was_not_completed_makes_no_other_the_best():
    rows = values(mask=(1.0, 2.0, 4.0), a4=(0.0, 0.5, 0.0))
    for row in rows:
        row["status"] = "timeout" if row["strategy"] == "a4" and row["participant"] == "1" else "done"
    found, _, comparison = standings(rows, ["mask", "a4"])
    assert comparison.incomplete == ["a4"] and found == ["", ""]
    lines = text.comparison_text(comparison).splitlines()
    assert text.NOT_JUDGED in lines and "a4 loses by no measure" not in lines


def test_equal_differences_decide_nothing_and_are_named():
    rows = values(mask=(1.0, 2.0), a4=(4.0, 5.0), cd=(1.0, 7.0))
    found, lead, comparison = standings(rows, ["mask", "a4", "cd"])
    assert found == ["best", "tied", "tied"] and lead == "tie of all"
    assert math.isnan(entries(comparison, "mean_drift_m").at["mask", "a4_half_width"])
    assert text.losses_by_strategy(comparison, "+-") == []
    assert text.undecided_by_strategy(comparison) == [
        ("mask", "", ["mean drift -3000 mm (equal in 2 hands)"])]
    lines = text.comparison_text(comparison).splitlines()
    place = lines.index("undecided, because no spread is measured (paired difference to a4):")
    assert lines[place + 1] == "  to mask: mean drift -3000 mm (equal in 2 hands)"
    # One hand more with another difference is a spread.
    _, _, decided = standings(values(mask=(1.0, 2.0, 1.0), a4=(4.0, 5.0, 4.25)), ["mask", "a4"])
    assert text.undecided_by_strategy(decided) == []
    assert text.losses_by_strategy(decided, "+-")[0][0] == "mask"


def test_a_strategy_that_leaves_the_workspace_is_flagged():
    """The workspace is 0.5 m, and a travel as long as it fits it. a4: hand 1 goes 0.75 m, on B without
    arriving."""
    rows = small_trials()
    for row in rows:
        if row["strategy"] == "mask":
            row["device_travel_m"] = 0.5
        if row["strategy"] == "a4":
            row["device_travel_m"] = 0.75 if row["participant"] == "1" else 0.25
            row["status"] = "timeout" if row["object"] == "B" else "done"
    comparison = compared(rows)
    counts = comparison.strategies.set_index("strategy")
    assert list(counts["beyond_workspace"]) == [0, 0, 2, 0]
    assert counts.at["a4", "largest_travel_m"] == 0.75 and counts.at["mask", "largest_travel_m"] == 0.5
    assert math.isnan(counts.at["cd", "largest_travel_m"])
    travel = entries(comparison, "device_travel_m")
    assert travel.at["a4", "mean"] == near((0.75 + 0.25 + 0.25) / 3.0)
    lines = text.comparison_text(comparison).splitlines()
    assert "! beyond the workspace of 500 mm: a4 in 2 of 6 trials, by up to 250 mm" in lines
    row = next(line for line in lines if line.startswith("device travel, mm"))
    assert row.split() == ["device", "travel,", "mm", "-", "500", "417", "!", "-"]
    assert not any("mask in" in line for line in lines)


def test_trials_without_the_travel_are_refused(folder):
    path = folder / "trials/trials.csv"
    pd.read_csv(path).drop(columns="device_travel_m").to_csv(path, index=False)
    with pytest.raises(InputError, match="trials.csv: line 1, column device_travel_m: is missing"):
        report_of(folder)


def test_the_page_flags_the_workspace_and_names_equal_and_missing_values(folder):
    path = folder / "trials/trials.csv"
    trials = pd.read_csv(path)
    of_a4 = trials["strategy"] == "a4"
    trials["device_travel_m"] = np.where(of_a4 & (trials["participant"] == 1), 0.75, 0.25)
    trials["losses_100ms"] = np.where(of_a4, 5, 2)
    trials["mean_drift_m"] = np.where(of_a4, np.nan, 0.0)
    trials.to_csv(path, index=False)
    lines = visible_text(report_of(folder).files["report.html"])
    assert "Beyond the workspace of 500 mm: a4 in 2 of 6 trials, by up to 250 mm." in lines
    assert "a4 | 6 | 6 | 0 | 0 | 2 | 750" in lines
    assert any(line.startswith("device travel, mm | 250 (equal) | 417 ") and line.endswith(" !")
               for line in lines)
    assert "losses of 0.1 s | 2.00 (equal) = | 5.00 (equal)" not in lines
    assert "losses of 0.1 s | 2.00 (equal) | 5.00 (equal)" in lines, "a tie of all has no mark"
    assert "to mask: losses of 0.1 s -3.00 (equal in 3 hands)" in lines
    assert "Not compared, because A4 has no value: mean drift." in lines
    assert "mean drift, mm | - (only mask; no value: a4)" in lines
    document = json.loads(report_of(folder).files["comparison.json"])
    assert [row["beyond_workspace"] for row in document["strategies"]] == [0, 2]
    equal = next(row for row in document["means"] if row["measure"] == "losses of 0.1 s")
    assert equal["half_width"] is None and equal["hands"] == 3


def test_magnitudes_are_compared_where_zero_is_the_best():
    rows = [trial(strategy, hand, "A", 1.0, work_lost_J=work * (1.0 + hand / 1024.0))
            for hand in (1, 2) for strategy, work in (("mask", -0.5), ("a4", 0.25))]
    comparison = compared(rows, ["mask", "a4"], ["A"])
    assert comparison.scenes == [""], "one scene is all scenes"
    lost = entries(comparison, "work_lost_J")
    assert lost.at["mask", "mean"] == 0.5 * (1.0 + 1.5 / 1024.0)
    assert leaders_in_order(lost) == ["a4"]


def test_only_trials_that_both_completed_are_paired():
    """Hand 1 did not complete B with a4, and hand 3 completed nothing with it."""
    rows = small_trials()
    for row in rows:
        if row["strategy"] == "a4" and row["participant"] == "1" and row["object"] == "B":
            row["status"] = "timeout"
        if row["strategy"] == "a4" and row["participant"] == "3":
            row["status"] = "fault"
    comparison = compared(rows)
    a4 = entries(comparison).loc["a4"]
    assert a4["hands"] == 2
    assert a4["mean"] == 14.0  # 10 and 18
    assert a4["mask_hands"] == 2
    assert a4["minus_mask"] == -29.5  # 10 - 40; (14 - 42 + 22 - 52) / 2
    assert a4["mask_half_width"] == near(0.5 * T1)
    counts = comparison.strategies.set_index("strategy").loc["a4"]
    assert list(counts[["trials", "done", "timeouts", "faults"]]) == [6, 3, 1, 2]
    assert comparison.incomplete == ["a4"]
    # Timeouts of hands: 1/2, 0, 0.
    assert entries(comparison, "status").at["a4", "mean"] == near(0.5 / 3.0)


def test_ninety_percent_of_the_trials_are_enough():
    counts = pd.DataFrame({"trials": [80, 80], "done": [72, 71]})
    assert list(is_comparable(counts)) == [True, False]


def test_other_followings_practice_and_strategies_are_left_out():
    expected = text.comparison_text(compared(small_trials()))
    rows = small_trials() + [
        trial("a4", 1, "A", 1000.0, following="predict"), trial("a4", 1, "A", 1000.0, block=0),
        trial("full", 1, "A", 1000.0)]
    assert text.comparison_text(compared(rows)) == expected


def test_each_value_of_a_parameter_is_a_strategy_of_its_own():
    names = ["mask", "anisotropic:0.5", "anisotropic:2"]
    rows = [trial(name, hand, "A", 30.0 - (10.0 + 0.1 * hand) * place + hand)
            for place, name in enumerate(names) for hand in (1, 2)]
    comparison = compared(rows, names, ["A"])
    angle = entries(comparison)
    assert list(angle.index) == names and set(angle["role"]) == {"technique"}
    assert leaders_in_order(angle) == ["anisotropic:2"]
    head, settings = text.comparison_text(comparison).splitlines()[:2]
    assert head.split()[-3:] == ["mask", "anisotropic", "anisotropic"]
    assert settings.split() == [":0.5", ":2"] and settings.index(":2") + 2 == len(head)
    assert meaning("anisotropic:0.5").endswith("counts E = 0.5 times")
    assert meaning("a4-passive:10").endswith("at most 10 mJ to the spring of the motors")
    assert meaning("unknown:3") == ""


def test_a_figure_has_a_mark_for_each_strategy_at_its_difference():
    angle = entries(compared(small_trials()))
    figure = differences_figure(angle, "a4")
    (axes,) = figure.axes
    marks = [line.lines[0] for line in axes.containers]
    found = [mark.get_xdata()[0] for mark in marks]
    assert found == [near(x) for x in (-9.0, 29.0)] + [0.0, near(-1.0)]
    half_widths = [line.lines[2][0].get_segments()[0][1][0] - x
                   for line, x in zip(axes.containers, found)]
    assert half_widths == [near(angle.at["none", "a4_half_width"]),
                           near(angle.at["mask", "a4_half_width"]), 0.0,
                           near(angle.at["cd", "a4_half_width"])]
    assert [mark.get_markerfacecolor() == "none" for mark in marks] == [True] + 3 * [False]
    assert [mark.get_color() for mark in marks] == [BETTER, WORSE, UNDECIDED, UNDECIDED]
    labels = [label.get_text().split() for label in axes.get_yticklabels()]
    assert labels == [["none", "9.0"], ["mask", "47.0"], ["a4", "18.0"], ["cd", "17.0"]]
    assert axes.get_xlabel() == "difference to a4, deg"
    time = entries(compared(small_trials()), "total_time_s")
    (only,) = differences_figure(time, "a4").axes[0].containers
    assert only.lines[0].get_xdata()[0] == 0.0, "nobody has a time"


PLAN = {"strategies": ["mask", "a4"], "objects": {"B": {"file": "b.glb"}, "A": {"file": "a.glb"}},
        "followings": ["delayed"], "operator": "people2005", "participants": 3, "seed": 2005,
        "device": {"sensors": 2, "velocity_estimator": "difference", "workspace_m": 0.5}}


@pytest.fixture(name="folder")
def comparison_folder(tmp_path):
    (tmp_path / "trials").mkdir()
    (tmp_path / "plan.json").write_text(json.dumps(PLAN))
    rows = pd.DataFrame([row for row in small_trials() if row["strategy"] in PLAN["strategies"]])
    rows.assign(haptic="", rotation="").to_csv(tmp_path / "trials/trials.csv", index=False)
    return tmp_path


def report_of(folder, *words):
    parser = argparse.ArgumentParser()
    command.add_arguments(parser)
    return command.run(parser.parse_args([str(folder), *words]))


def test_a_report_has_all_scenes_and_measures_and_says_that_hands_are_simulated(folder):
    report = report_of(folder, "--scene", "one <b>.glb", "--scene", "$x$.glb")
    assert list(report.files) == ["report.html", "comparison.json", "comparison.csv",
                                  "a4_losses.csv"]
    document = json.loads(report.files["comparison.json"])
    assert len(document["means"]) == 3 * 18 * 2 == 3 * len(MEASURES) * 2
    assert document["scenes"] == ["one <b>.glb", "$x$.glb"]
    assert [row["trials"] for row in document["strategies"]] == [6, 6]
    assert document["comparable"] == {"delayed": True}
    lines = report.files["comparison.csv"].splitlines()
    assert len(lines) == 1 + 3 * 18 * 2
    assert lines[0].startswith("following,scene,measure,column,unit,better,strategy,role,hands,mean")
    page = report.files["report.html"]
    assert ("The hands are simulated: the intervals speak of seeds and of the ranges in the operator "
            "file, not of people.") in page
    assert "<script" not in page and "http" not in page.replace("http://www.w3.org", "")
    assert "one &lt;b&gt;.glb, $x$.glb" in page
    assert page.index('id="differences"') < page.index("Best technique by each measure")
    assert report.text.startswith("one <b>.glb, $x$.glb: 12 trials of 3 hands of people2005, seed 2005")
    assert report_of(folder, "--scene", "one <b>.glb", "--scene", "$x$.glb") == report
    assert report_of(folder, "--json").text == report_of(folder).files["comparison.json"]


def test_a_folder_without_a_plan_is_refused_by_name(folder):
    (folder / "plan.json").write_text("{}")
    with pytest.raises(InputError, match="plan.json: is not a plan of palpate compare"):
        report_of(folder)
