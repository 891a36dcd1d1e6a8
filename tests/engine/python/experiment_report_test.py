"""The report of an experiment: its numbers against the analysis and against counts of the rows, what
it states, and what it does not write."""

from __future__ import annotations

import csv
import io
import json
import re
from collections import Counter, defaultdict

import numpy as np
import pytest

from experiment_samples import (
    ALL_FOLLOWINGS, analysed, analysed_all, end_as, where, written)  # fmt: skip
from page_text import tables_of, visible_text
from palpate.analysis.errors import InputError
from palpate.analysis.experiment import text as texts
from palpate.analysis.experiment.verdicts import AGREES, DISAGREES, NOT_TESTABLE, VERDICTS
from palpate.analysis.experiment.outcomes import PAPER_OUTCOMES
from palpate.analysis.experiment.paper import FINDINGS
from palpate.analysis.experiment.primary import residuals
from palpate.analysis.experiment.tables import TABLES
from palpate.analysis.numbers import df_text, number_or_dash, with_decimals
from palpate.analysis.statistics import effect_name
from sample_trials import SampleTrials, SeededRandom, sample_trials

FILES = {"report.html", "analysis.json", "effects.csv", "comparisons.csv", "means.csv",
         "missing_trials.csv", "findings.csv", "verdicts.csv", "variances.csv", "loss_rates.csv",
         "differences.csv", "ratings.csv", "rating_tests.csv"}  # fmt: skip
SIMULATED = SampleTrials(followings=ALL_FOLLOWINGS, has_timeouts=True)
DIGITS = 1e-9  # of numbers in files


def minimal_rows():
    """With the measures that an analysis needs, and no other."""
    rows = sample_trials()
    for row in rows:
        for column in ("losses_100ms", "losses_per_s", "mean_penetration_dm",
                       "mean_contact_angle_deg"):  # fmt: skip
            row.pop(column, None)
    return rows


@pytest.fixture(scope="module")
def people(tmp_path_factory):
    return written(sample_trials(), tmp_path_factory.mktemp("people"))


@pytest.fixture(scope="module")
def people_analysis():
    return analysed(sample_trials())


@pytest.fixture(scope="module")
def simulated(tmp_path_factory):
    return written(sample_trials(SIMULATED), tmp_path_factory.mktemp("simulated"))


@pytest.fixture(scope="module")
def simulated_analysis():
    return analysed_all(sample_trials(SIMULATED))


def rows_of(report, name):
    return list(csv.DictReader(io.StringIO(report.files[f"{name}.csv"])))


def page_of(report):
    return report.files["report.html"]


def the_row(rows, **values):
    """The only row with these values."""
    [found] = where(rows, **values)
    return found


def number(cell):
    return float(cell) if cell else np.nan


def equal(expected):
    return pytest.approx(expected, rel=DIGITS, nan_ok=True)


def test_report_has_all_files(people):
    assert set(people.files) == FILES
    assert people.warnings == []


def test_report_has_the_parts_of_the_variance(tmp_path):
    rows = sample_trials(SampleTrials(participants=4))
    report = written(rows, tmp_path)
    [time, losses, depth] = rows_of(report, "variances")
    assert (time["outcome"], time["unit"]) == ("total time", "s")
    assert (time["trials"], time["participants"]) == ("288", "4")
    table = table_below(page_of(report), "<h3>Parts of the variance of trials</h3>")
    assert table[1][:2] == ["Total time (s)", number_or_dash(number(time["sd_participants"]))]
    assert table[1][4:] == [f"{100.0 * number(time['share_of_participants']):.0f} %", "288", "4"]


def test_report_has_ratios_of_losses_per_time(people):
    rows = rows_of(people, "loss_rates")
    assert [row["pair"] for row in rows] == ["UaH / NoH", "H / NoH", "H / UaH", "R / NoR"]
    table = table_below(page_of(people), "<h3>Losses of contact per time</h3>")
    for shown, row in zip(table[1:], rows):
        low, high = (with_decimals(number(row[end]), 3) for end in ("low_95", "high_95"))
        ratio = with_decimals(number(row["ratio"]), 3)
        assert shown[:3] == [row["pair"], ratio, f"{low} to {high}"]


def test_report_has_a_picture_of_residuals_of_each_outcome(people, people_analysis):
    assert page_of(people).count("normal quantile (standard deviations)</text>") == 3
    found = residuals(people_analysis.experiment, PAPER_OUTCOMES[0]).to_numpy().reshape(10, 24)
    assert found.sum(axis=0) == pytest.approx(0.0, abs=1e-9)
    assert found.sum(axis=1) == pytest.approx(0.0, abs=1e-9)
    # The interaction with participants is the error of repeated measures.
    grid = people_analysis.experiment.grid(PAPER_OUTCOMES[0]).mean(axis=4).reshape(10, 24)
    deviations = grid - grid.mean(axis=1, keepdims=True)
    between = 10.0 * np.square(deviations.mean(axis=0)).sum()
    assert np.square(found).sum() == equal(np.square(deviations).sum() - between)


# The columns that name a row differ between any two rows of a table.
def test_each_row_of_a_table_is_named_once(people, tmp_path):
    names = {
        "effects": ["following", "analysis", "outcome", "effect"],
        "comparisons": ["following", "analysis", "outcome", "family", "pair"],
        "means": ["following", "of", "outcome", "haptic", "rotation", "object"],
        "missing_trials": ["following", "haptic", "rotation", "object"],
        "findings": ["following", "finding"],
        "verdicts": ["following", "finding", "comparison"],
        "variances": ["following", "outcome"],
        "loss_rates": ["following", "pair"],
    }
    two = written(sample_trials(SampleTrials(followings=("delayed", "frozen"))), tmp_path)
    for report in (people, two):
        for table, columns in names.items():
            found = Counter(tuple(row[c] for c in columns) for row in rows_of(report, table))
            assert set(found.values()) == {1}, table


# A following whose effects cannot be tested agrees or disagrees with nobody.
def test_missing_test_is_no_flip():
    rows = sample_trials(SampleTrials(followings=("delayed",)))
    incomplete = sample_trials(SampleTrials(followings=("frozen",)))
    end_as("timeout", where(incomplete, haptic="UaH", object="O2"))
    assert analysed_all(rows + incomplete).differing() == []


# 15 effects of four factors: in the MANOVA, in three ANOVAs and in the repeated measures of six
# outcomes; 7 effects of UaH alone.
def test_report_has_every_f(people, people_analysis):
    rows = rows_of(people, "effects")
    assert len(rows) == 15 * (1 + 3 + 6) + 7
    for outcome, primary in people_analysis.primary.items():
        for effect in primary.effects.to_dict("records"):
            row = the_row(rows, analysis="repeated measures", outcome=outcome.name,
                          effect=effect_name(effect["term"]))  # fmt: skip
            assert number(row["f"]) == equal(effect["f"])
            assert number(row["p"]) == equal(effect["p"])
            assert number(row["gg_p"]) == equal(effect["p_gg"])
            assert number(row["gg_epsilon"]) == equal(effect["epsilon"])
            assert number(row["generalized_eta2"]) == equal(effect["generalized_eta2"])
            assert row["participants"] == "10"
    anova = the_row(rows, analysis="anova", outcome="mean penetration", effect="Rotation x Haptic")
    found = people_analysis.paper.anovas[PAPER_OUTCOMES[2]].loc[[("Haptic", "Rotation")]].iloc[0]
    assert number(anova["f"]) == equal(found["f"])
    assert number(anova["df2"]) == 648
    assert anova["trials"] == "720"
    assert number(anova["paper_f"]) == 22.859


def table_below(page, heading):
    """The rows of the first table below a heading, without the rows of heads."""
    assert heading in page
    return [row for row in tables_of(page[page.index(heading):])[0] if row and row[0] != "effect"]


def test_page_has_each_f_beside_the_papers(people, people_analysis):
    printed = [["12.141", "29.674", "0.433 (n.s.)"], ["19.139", "22.389", "2.608 (p < .07)"],
               ["836.377", "0.845 (n.s.)", "22.859"]]  # fmt: skip
    for outcome, papers in zip(PAPER_OUTCOMES, printed):
        rows = table_below(page_of(people), f"<h4>{outcome.heading}</h4>")[-15:]
        primary = people_analysis.primary[outcome]
        anova = people_analysis.paper.anovas[outcome]
        for row, effect in zip(rows, primary.effects.to_dict("records")):
            fixed = anova.loc[[effect["term"]]].iloc[0]
            assert len(row) == 14
            assert row[0] == effect_name(effect["term"])
            assert row[2] == number_or_dash(fixed["f"])
            assert row[5] == with_decimals(fixed["partial_eta2"], 3)
            assert row[6] == "720"
            assert row[7] == number_or_dash(effect["f"])
            assert row[8] == f"{df_text(effect['df1'])}, {df_text(effect['df2'])}"
            assert row[10] == with_decimals(effect["epsilon"], 3)
            assert row[12] == with_decimals(effect["generalized_eta2"], 3)
            assert row[13] == "10"
        assert rows[0][1] == papers[0]
        assert rows[1][1] == papers[1]
        assert rows[3][0] == "Rotation x Haptic"
        assert rows[3][1] == papers[2]


def test_page_has_means_beside_the_papers(people):
    means = rows_of(people, "means")
    heading = "<h3>Means and standard deviations of trials</h3>"
    rows = table_below(page_of(people), heading)[1:]
    assert len(rows) == 1 + 3 + 2 + 4 + 6

    def mean_at(outcome, haptic, decimals):
        row = the_row(means, of="trials", outcome=outcome, haptic=haptic, rotation="all",
                      object="all")  # fmt: skip
        mean, sd = (with_decimals(number(row[name]), decimals) for name in ("mean", "sd"))
        return f"{mean} ({sd})"

    printed = {"NoH": ["29 (15)", "24 (11)", "0.101 (0.031)"],
               "UaH": ["27.5 (15)", "22 (11)", "0.068 (0.023)"],
               "H": ["25 (13)", "21 (10)", "0.031 (0.008)"]}  # fmt: skip
    for row, (level, papers) in zip(rows[1:], printed.items()):
        assert row[:2] == [level, "240"]
        assert row[2] == mean_at("total time", level, 2)
        assert row[4] == mean_at("losses of contact", level, 2)
        assert row[6] == mean_at("mean penetration", level, 4)
        assert row[3:8:2] == papers
    assert rows[4][3] == "25.14 (12.041)"  # NoR
    assert rows[5][3] == "29.15 (15.972)"  # R


def test_page_has_the_manova_beside_the_papers(people, people_analysis):
    rows = table_below(page_of(people), "<h3>MANOVA")[-15:]
    manova = people_analysis.paper.manova
    for row, term, test in zip(rows, manova.index, manova.to_dict("records")):
        assert row[0] == effect_name(term)
        assert row[4] == with_decimals(test["wilks_lambda"], 3)
        assert row[5] == number_or_dash(test["f"])
    assert {row[0]: row[1] for row in rows if row[1]} == {
        "Haptic": "0.236", "Rotation": "0.925", "Object": "0.110", "Trial": "0.925",
        "Rotation x Haptic": "0.911", "Object x Haptic": "0.868",
        "Object x Rotation": "0.934"}  # fmt: skip


# The paper's contact angles are those of UaH: no other angle stands beside them.
def test_papers_angles_stand_beside_uah_alone(people):
    beside = {
        " ".join(row[c] for c in ("of", "haptic", "rotation", "paper_mean"))
        for row in rows_of(people, "means")
        if row["outcome"] == "mean contact angle" and row["paper_mean"]
    }
    assert len(beside) == 6  # of trials, of participants, and of participants in UaH alone
    assert "trials UaH R 32.1" in beside
    assert "participants, UaH UaH R 32.1" in beside
    assert "participants UaH NoR 49.4" in beside


def test_means_are_those_of_the_rows(simulated):
    rows = sample_trials(SIMULATED)
    for following in ALL_FOLLOWINGS:
        done = where(rows, following=following, haptic="UaH", status="done")
        times = [row["total_time_s"] for row in done if row["block"] > 0]
        found = the_row(rows_of(simulated, "means"), following=following, of="trials",
                        outcome="total time", haptic="UaH", rotation="all", object="all")  # fmt: skip
        assert found["n"] == str(len(times))
        assert number(found["mean"]) == equal(np.mean(times))
        assert number(found["sd"]) == equal(np.std(times, ddof=1))
        assert number(found["paper_mean"]) == 27.5


def test_timeouts_are_counted_by_condition(simulated):
    timeouts = Counter()
    for row in where(sample_trials(SIMULATED), status="timeout"):
        if row["block"] > 0:
            timeouts[row["following"], row["haptic"], row["rotation"], row["object"]] += 1
            timeouts[row["following"], "all", "all", "all"] += 1
    missing = rows_of(simulated, "missing_trials")
    assert len(missing) == 4 * 25
    for row in missing:
        at = tuple(row[c] for c in ("following", "haptic", "rotation", "object"))
        assert row["timeouts"] == str(timeouts[at])
        low, share, high = (
            number(row[f"timeout_share{end}"]) for end in ("_low", "", "_high")
        )
        assert low <= share <= high
    n = timeouts["frozen", "all", "all", "all"]
    assert n > 10
    assert f"missing: {n} ({n} timeouts, 0 faults, 0 absent)" in simulated.text
    sentence = f"{720 - n} of 720 trials were completed by 10 participants; timeouts: {n}"
    assert sentence in page_of(simulated)
    # The time with timeouts as the limit is that of `frozen` alone.
    to_limit = where(rows_of(simulated, "effects"), outcome="total time, timeouts as the limit")
    assert {row["following"] for row in to_limit} == {"frozen"}


def test_json_has_the_numbers_of_the_tables(simulated):
    document = json.loads(simulated.files["analysis.json"])
    assert len(document["operators"]) == 4
    assert document["operators"][3]["following"] == "frozen"
    assert document["limit_s"] == 120.0
    for name in TABLES:
        rows = rows_of(simulated, name)
        assert len(document[name]) == len(rows)
        for values, row in zip(document[name], rows):
            assert list(values) == list(row)
            for column, value in values.items():
                if value is None:
                    assert row[column] == ""
                elif isinstance(value, str):
                    assert row[column] == value
                else:
                    assert float(row[column]) == value


def test_page_states_each_verdict(simulated, simulated_analysis):
    page = page_of(simulated)
    counts = Counter(f.verdict for each in simulated_analysis.operators for f in each.findings)
    for verdict in VERDICTS:
        assert page.count(f">{verdict}</span>") == counts[verdict]
    leading = texts.verdict_counts(simulated_analysis.operators[0])
    assert sum(leading.values()) == len(FINDINGS)
    sentence = (f"Of the paper\u2019s 17 findings, {leading[AGREES]} agree, "
                f"{leading[DISAGREES]} disagree")  # fmt: skip
    assert sentence in page
    rows = rows_of(simulated, "findings")
    results = [f for each in simulated_analysis.operators for f in each.findings]
    assert len(rows) == 4 * 17
    for row, result in zip(rows, results):
        assert (row["verdict"], row["because"]) == (result.verdict, result.because)


# `predict` has the opposite effects.
def test_verdicts_that_flip_are_marked(tmp_path):
    rows = sample_trials(SampleTrials(followings=("delayed",)))
    rows += sample_trials(SampleTrials(followings=("predict",), effects=-1.0))
    analysis, report = analysed_all(rows), written(rows, tmp_path)
    a, b = ([f.verdict for f in each.findings] for each in analysis.operators)
    flips = sum(x != y for x, y in zip(a, b))
    assert flips > 3
    assert page_of(report).count(">flips between followings<") == flips
    assert len(analysis.differing()) == flips
    assert f"{flips} verdicts flip between followings\n" in report.text
    marked = where(rows_of(report, "findings"), following="predict", differs_between_followings="1")
    assert len(marked) == flips


def test_simulated_operators_are_named_and_people_are_not(simulated, people, tmp_path):
    page = page_of(simulated)
    assert "<title>The paper\u2019s experiment with simulated operators</title>" in page
    for following in ALL_FOLLOWINGS:
        # In each of the three pictures of the paper's figures.
        figures = re.search(f'id="{following}".*?<h3>Residuals', page, re.S)[0]
        assert len(re.findall(f": simulated operators, {following}</text>", figures)) == 3
    assert "not of people" in page
    assert "The rule of alignment may be one reason." in page
    assert "imulated" not in page_of(people)
    assert "27 %" in page_of(people)
    assert "720 trials of 10 people; missing: none\n" in people.text
    assert "imulated" not in people.text
    both = sample_trials(SampleTrials(followings=("delayed",))) + sample_trials()
    mixed = written(both, tmp_path)
    assert mixed.text.startswith(
        "720 trials of 10 people; missing: none\n"
        "720 trials of 10 simulated operators (delayed); missing: none\n"
        "the paper's 17 findings, people: "
    )
    assert "between followings" not in page_of(mixed)


# People lead, and nothing pools the two.
def test_people_lead_a_mixed_file(people, tmp_path):
    simulated = sample_trials(SampleTrials(followings=("delayed",), effects=-1.0, participants=4))
    mixed = written(simulated + sample_trials(), tmp_path)
    sections = re.findall(r'<section class="operator" id="(\w+)"', page_of(mixed))
    assert sections == ["people", "delayed"]
    facts = dict(re.findall(r"<dt>([^<]+)</dt><dd>([^<]+)</dd>", page_of(mixed)))
    assert facts["Trials, people"] == "720 (practice is left out)"
    assert facts["Trials, simulated operators"] == "288 (practice is left out)"
    for table in ("effects", "comparisons", "means", "missing_trials", "verdicts"):
        of_people = where(rows_of(mixed, table), following="people")
        assert of_people == rows_of(people, table)
        assert {row["following"] for row in rows_of(mixed, table)} == {"people", "delayed"}


def test_text_for_the_terminal_is_short_and_states_the_verdicts(simulated, simulated_analysis):
    text = simulated.text
    begin = "2880 trials of 10 simulated operators (delayed, predict, replan, frozen); missing: "
    assert text.startswith(begin)
    leading = simulated_analysis.operators[0]
    agree = texts.verdict_counts(leading)[AGREES]
    assert f"the paper's 17 findings, delayed: {agree} agree{'s' * (agree == 1)}" in text
    assert text.count("\n") <= 4 + 10 + 3
    effects = defaultdict(list)
    for result in leading.findings:
        label = f"\n  {result.verdict:<14}"
        if result.finding.outcome:
            assert f"{label}{result.finding.name}: " in text
        else:
            effects[label].append(result.finding.name.partition(", ")[2])
    # The effects of the MANOVA have a line for each verdict, in the paper's order.
    for label, names in effects.items():
        assert f"{label}MANOVA: effects of {', '.join(names)}\n" in text
        item = f"<li><strong>MANOVA</strong>: effects of {', '.join(names)}</li>"
        assert item in page_of(simulated)


# What simulated persons cannot show by construction comes first.
def test_page_and_terminal_first_say_what_is_no_evidence(simulated, people, people_analysis):
    lines = visible_text(page_of(simulated))
    begin = lines.index("What agrees with the paper")
    assert lines[begin + 1].startswith(
        "What simulated persons cannot show. 5 of the 17 findings are no evidence about people"
    )
    # The sample's persons: 0.4 mm times their random numbers.
    assert "standard deviation between the persons (delayed) of their mean penetration is NoH 0." in (
        lines[begin + 1]
    )
    names = [line.partition(": ")[0] for line in lines[begin + 2 : begin + 7]]
    assert names == [
        "total time, Rotation",
        "losses of contact, Haptic",
        "mean penetration, Haptic",
        "mean contact angle, Rotation",
        "MANOVA, Trial",
    ]
    assert simulated.text.splitlines()[2].startswith("no evidence, because simulated persons are")
    assert page_of(simulated).count(">simulated: no evidence</span>") == 5
    assert "no evidence" not in page_of(people)
    assert "no evidence" not in people.text
    assert people_analysis.experiment.is_simulated is False


def test_what_the_file_does_not_have_is_left_out(tmp_path):
    report = written(minimal_rows(), tmp_path)
    page = page_of(report)
    assert "No Figure 7: the file does not have the contact angle of UaH." in page
    assert 'class="figure7"' not in page
    assert page.count('class="figure6"') == 1
    assert "The file does not have the column mean_contact_angle_deg" in page
    for name in ("effects", "means", "comparisons"):
        outcomes = {row["outcome"] for row in rows_of(report, name)}
        assert "mean contact angle" not in outcomes
        assert "losses of contact of 100 ms or more" not in outcomes
    assert "<h4>Losses of contact of 100 ms or more" not in page
    assert rows_of(report, "findings")[9]["verdict"] == NOT_TESTABLE


@pytest.mark.parametrize("level", ["NoR", "R"])
def test_factors_with_one_level_are_left_out(level, tmp_path):
    page = page_of(written(sample_trials(SampleTrials(blocks=1, rotation=(level,))), tmp_path))
    assert f"Rotation is left out, because the file has one level of it: {level}" in page
    text = "R: the scene turns" if level == "R" else "NoR: the scene stands still"
    assert f">{text}<" in page
    assert "\u00b1 nan" not in page
    assert "\u00b1 -" not in page


def test_file_of_uah_alone_has_figure_7(tmp_path):
    page = page_of(written(sample_trials(SampleTrials(haptic=("UaH",))), tmp_path))
    assert 'class="figure7"' in page


def test_following_that_the_papers_analysis_cannot_take_is_explained(tmp_path):
    rows = sample_trials(SampleTrials(followings=("delayed", "frozen")))
    end_as("timeout", where(rows, following="frozen", haptic="H", rotation="R"))
    report = written(rows, tmp_path)
    assert len(report.warnings) == 2  # Figure 6 has no mean of all conditions
    page = page_of(report)
    assert ("The paper\u2019s analysis is not possible. No trial of H, R, O1 was completed: its "
            "effects cannot be separated.") in page  # fmt: skip
    assert "no participant has completed trials in all its conditions" in page


def test_report_is_the_same_for_rows_in_any_order(simulated, tmp_path):
    rows = sample_trials(SIMULATED)
    random = SeededRandom(18301)
    for i in range(len(rows) - 1, 0, -1):
        j = random.index(i + 1)
        rows[i], rows[j] = rows[j], rows[i]
    assert written(rows, tmp_path).files == simulated.files


def test_names_of_the_file_are_escaped(tmp_path):
    rows = sample_trials()
    name = '<script>alert(1)</script>, "cup"'
    for row in where(rows, object="O2"):
        row["object"] = name
    report = written(rows, tmp_path, name="<b>.csv")
    page = page_of(report)
    assert "<script" not in page
    assert "<b>" not in page
    assert "&lt;script&gt;alert(1)" in page
    assert any(name in line for line in visible_text(page))
    assert name in {row["object"] for row in rows_of(report, "missing_trials")}
    assert json.loads(report.files["analysis.json"])["file"] == "<b>.csv"


# A page that works offline: no script, and no address of another document.
def test_page_needs_no_other_file(simulated):
    page = page_of(simulated)
    for part in ("<script", '<link rel="stylesheet', " src=", "@import", "url(http",
                 'href="http', "href='http"):  # fmt: skip
        assert part not in page


def test_ids_of_a_page_are_different(simulated):
    ids = re.findall(r'\sid="([^"]+)"', page_of(simulated))
    assert [name for name, n in Counter(ids).items() if n > 1] == []


REFUSED = {
    "one participant": (
        lambda rows: rows.__setitem__(slice(None), where(rows, participant="4")),
        "trials.csv: participant: has 1 level beside practice"),
    "no losses": (
        lambda rows: [row.pop("losses_of_contact") for row in rows],
        "trials.csv: losses_of_contact: is in no completed trial"),
    "trial beyond the limit": (
        lambda rows: (end_as("timeout", rows[40:41]), rows[41].update(total_time_s=130.0)),
        "trials.csv: participant 1, block 1, H, NoR, O2, total_time_s: is 130 in a completed trial; "
        "expected at most the time limit, 120 s, because the file has timeouts (give the time limit "
        "of the trials with --limit)"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_refused_rows_have_no_report(name, tmp_path):
    change, message = REFUSED[name]
    rows = sample_trials()
    change(rows)
    with pytest.raises(InputError) as refused:
        written(rows, tmp_path)
    error = refused.value
    error.path = "trials.csv"
    assert str(error).startswith(message)


def test_trials_of_strategies_are_refused(tmp_path):
    rows = where(sample_trials(), haptic="H", rotation="R")
    for row in rows:
        row.update(haptic="", rotation="", strategy="a4")
    with pytest.raises(InputError) as refused:
        written(rows, tmp_path, columns=tuple(rows[0]))
    line = str(refused.value)
    assert "trials.csv: column strategy: is a4 in a trial of participant 1" in line
    assert "palpate compare" in line


# Without a timeout the limit is not used, and people may take their time.
def test_trials_beyond_the_limit_are_analysed_if_there_is_no_timeout(tmp_path):
    rows = sample_trials()
    rows[41]["total_time_s"] = 130.0
    assert set(written(rows, tmp_path).files) == FILES


def test_report_of_several_variants_has_a_table_of_differences(tmp_path):
    def trials(seed, start):
        rows = sample_trials(SampleTrials(("delayed",), participants=4, blocks=2, seed=seed))
        return [{**row, "start_orientation_deg": start} for row in rows]

    one = written(trials(1, 0.0), tmp_path)
    assert 'id="differences"' not in page_of(one)
    assert rows_of(one, "differences") == []
    two = written(trials(1, 0.0) + trials(2, 45.0), tmp_path)
    assert 'id="differences"' in page_of(two)
    assert "delayed, start 45 deg \u2212 delayed" in page_of(two)
    assert len(rows_of(two, "differences")) == 4 * 6  # outcomes x conditions
    for name in TABLES:
        lines = list(csv.reader(io.StringIO(two.files[f"{name}.csv"])))
        assert {len(line) for line in lines} == {len(lines[0])}
