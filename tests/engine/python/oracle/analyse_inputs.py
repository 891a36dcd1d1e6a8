"""The made cases of `experiment analyse`: name -> what it is, text of trials.csv, options."""

from __future__ import annotations

import random
import sys
from collections.abc import Callable
from pathlib import Path

from made_trials import (FACTORS, HAPTIC, MEASURES, OBJECTS, Row, dropped, ended, is_at, put,
                         scaled, six,
                         some_end, text_of, tie_depth, trials, without)

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from sample_trials import SampleTrials, sample_trials, trials_csv  # noqa: E402

Made = tuple[str, str | bytes, list[str]]
CANONICAL_COLUMNS = "participant,angle_deg,motion,rotation,along_over_into,share_within_30deg"
FOLLOWINGS = ("delayed", "predict", "replan", "frozen")
_CASES: dict[str, tuple[str, Callable[[random.Random], str | bytes], list[str]]] = {}


def made(about: str, *arguments: str) -> Callable[[Callable[[random.Random], str | bytes]], None]:
    def add(function: Callable[[random.Random], str | bytes]) -> None:
        _CASES[function.__name__] = (about, function, list(arguments))
    return add


def made_cases() -> dict[str, Made]:
    return {f"{name}": (about, function(random.Random(name)), arguments)
            for name, (about, function, arguments) in _CASES.items()}


# --- Levels

@made("six people, two blocks, two objects, no trial missing")
def balanced_people(r: random.Random) -> str:
    return text_of(trials(r))


@made("two people")
def two_people(r: random.Random) -> str:
    return text_of(trials(r, people=2, blocks=3))


@made("two people, one block and one object: no effect of Object and Trial, few degrees of freedom")
def two_people_one_block_one_object(r: random.Random) -> str:
    return text_of(trials(r, people=2, blocks=[1], objects=["O1"]))


@made("one block")
def one_block(r: random.Random) -> str:
    return text_of(trials(r, people=5, blocks=1, objects=OBJECTS))


@made("one object")
def one_object(r: random.Random) -> str:
    return text_of(trials(r, objects=["lock"], blocks=3))


@made("UaH alone")
def uah_alone(r: random.Random) -> str:
    return text_of(trials(r, haptic=["UaH"], blocks=3))


@made("NoH and H alone: no angle in UaH")
def without_uah(r: random.Random) -> str:
    return text_of(trials(r, haptic=["NoH", "H"]))


@made("R alone")
def r_alone(r: random.Random) -> str:
    return text_of(trials(r, rotation=["R"]))


@made("NoR alone, one object, one block: Haptic is the only factor")
def haptic_is_the_only_factor(r: random.Random) -> str:
    return text_of(trials(r, people=8, rotation=["NoR"], blocks=1, objects=["O1"]))


@made("one condition: no factor with two levels but Trial")
def trial_is_the_only_factor(r: random.Random) -> str:
    return text_of(trials(r, people=8, haptic=["UaH"], rotation=["R"], blocks=3, objects=["O1"]))


@made("twelve objects, in the order of the numbers in their names")
def many_objects(r: random.Random) -> str:
    return text_of(trials(r, people=3, blocks=1, objects=[f"Vase {i}" for i in range(1, 13)]))


@made("thirty people, one block, one object")
def many_people(r: random.Random) -> str:
    return text_of(trials(r, people=30, blocks=1, objects=["O1"]))


@made("blocks are numbered 2, 5 and 11")
def blocks_with_gaps(r: random.Random) -> str:
    return text_of(trials(r, people=4, blocks=[2, 5, 11]))


# --- Missing trials

@made("people with one, two, three and four blocks")
def people_with_other_numbers_of_blocks(r: random.Random) -> str:
    rows = trials(r, people=6, blocks=4)
    return text_of([row for row in rows if row["block"] <= 1 + int(row["participant"]) % 4])


@made("one of twenty trials is absent")
def few_absent(r: random.Random) -> str:
    return text_of(dropped(r, trials(r, people=8, blocks=3), 0.05))


@made("a third of the trials is absent: most people lack a cell")
def many_absent(r: random.Random) -> str:
    return text_of(dropped(r, trials(r, people=8, blocks=3), 0.33))


@made("one person lacks one condition")
def one_person_lacks_a_condition(r: random.Random) -> str:
    return text_of([row for row in trials(r, people=5, blocks=3)
                    if not is_at(row, participant=3, haptic="UaH", rotation="R", object="O2")])


@made("each person lacks another condition: no effect is testable as repeated measures")
def each_person_lacks_a_condition(r: random.Random) -> str:
    rows = trials(r, people=6, blocks=2)
    gone = [(h, t) for h in HAPTIC for t in ("NoR", "R")]
    return text_of([row for row in rows
                    if (row["haptic"], row["rotation"]) != gone[int(row["participant"]) - 1]])


@made("one block has no trial of a condition: Trial is left out")
def block_without_a_condition(r: random.Random) -> str:
    return text_of([row for row in trials(r, blocks=3)
                    if not is_at(row, block=2, haptic="H", rotation="R", object="O2")])


@made("one of ten trials is a timeout")
def timeouts(r: random.Random) -> str:
    return text_of(some_end(r, trials(r, people=8, blocks=3), 0.1, "timeout"))


@made("half of the trials with R are timeouts; the limit is 60 s", "--limit", "60")
def timeouts_with_rotation(r: random.Random) -> str:
    return text_of(some_end(r, trials(r, people=8, blocks=3), 0.5, "timeout", rotation="R"))


@made("faults")
def faults(r: random.Random) -> str:
    return text_of(some_end(r, trials(r, people=6, blocks=3), 0.08, "fault"))


@made("timeouts, faults and absent trials of simulated operators with four followings")
def all_kinds_of_missing_trials(r: random.Random) -> str:
    rows = []
    for share, following in zip((0.02, 0.05, 0.1, 0.25), FOLLOWINGS):
        its = some_end(r, trials(r, people=5, blocks=2, following=following), share, "timeout")
        rows += dropped(r, some_end(r, its, share / 2, "fault"), share / 2)
    return text_of(rows)


@made("timeouts with nan, inf and numbers in their measures")
def timeouts_with_measures(r: random.Random) -> str:
    rows = trials(r, people=5, blocks=2)
    for row in rows:
        if r.random() < 0.15:
            row["status"] = "timeout"
            row["total_time_s"], row["losses_per_s"] = r.choice([120.0, "nan", "inf", "NA"]), "nan"
    return text_of(rows)


@made("a following has no completed trial of a condition, another one has")
def following_without_a_condition(r: random.Random) -> str:
    rows = trials(r, people=4, following="delayed")
    frozen = trials(r, people=4, following="frozen")
    return text_of(rows + some_end(r, frozen, 1.0, "timeout", haptic="NoH", rotation="R",
                                   object="O1"))


@made("one following has completed no trial at all")
def following_without_any_trial(r: random.Random) -> str:
    rows = trials(r, people=3, following="delayed")
    return text_of(rows + some_end(r, trials(r, people=3, following="replan"), 1.0, "timeout"))


@made("trials were repeated: the last attempt counts")
def several_attempts(r: random.Random) -> str:
    rows = trials(r, people=4, blocks=2)
    again = []
    for row in rows:
        if r.random() < 0.1:
            again.append({**row, "attempt": 2, "total_time_s": six(row["total_time_s"] + 5)})
            ended(row, r.choice(["fault", "timeout"]))
    return text_of(again + rows)


# --- Several experiments in a file

@made("all seven followings")
def seven_followings(r: random.Random) -> str:
    rows = []
    for i, name in enumerate(FOLLOWINGS + ("adapts-0", "adapts-0.5", "adapts-1")):
        rows += trials(r, people=3, following=name, effects=1 - 0.3 * i,
                       view="turning" if i < 4 else "still")
    return text_of(rows)


@made("four start orientations, one negative")
def start_orientations(r: random.Random) -> str:
    return text_of([row for start in (45, 0, -144.5, 90)
                    for row in trials(r, people=3, following="delayed",
                                      start_orientation_deg=start)])


@made("three scales, with timeouts")
def scales(r: random.Random) -> str:
    rows = [row for scale in (1, 0.5, 2.25)
            for row in trials(r, people=4, following="delayed", scale=scale)]
    return text_of(some_end(r, rows, 0.1, "timeout"))


@made("people with both views and both alignments")
def views_and_alignments(r: random.Random) -> str:
    return text_of([row for view in ("turning", "still") for align in ("nearest", "forward")
                    for row in trials(r, people=3, view=view, align=align)])


@made("two followings, two alignments, two start orientations and two scales")
def variants_of_two_followings(r: random.Random) -> str:
    return text_of([row for following in ("delayed", "replan") for align in ("nearest", "forward")
                    for start in (0, 30) for scale in (1, 0.75)
                    for row in trials(r, people=2, blocks=[1], following=following, align=align,
                                      start_orientation_deg=start, scale=scale)])


@made("variants whose differences are 0, but for rounding")
def variants_without_differences(r: random.Random) -> str:
    rows = trials(r, people=3, following="delayed", scale=1)
    again = [{**row, "scale": 0.5} for row in rows]
    for row in again[::3]:
        row["total_time_s"] = f"{row['total_time_s'] * (1 + 2.2e-16):.17g}"
    return text_of(rows + again)


@made("people and simulated operators in one file")
def people_and_simulated(r: random.Random) -> str:
    return text_of(trials(r, people=5, following="delayed") + trials(r, people=4, effects=-1)
                   + trials(r, people=3, following="frozen", effects=0))


@made("people and simulated operators, each with both views")
def people_and_simulated_with_both_views(r: random.Random) -> str:
    return text_of(trials(r, people=3, view="turning") + trials(r, people=3, view="still")
                   + trials(r, people=3, following="predict", view="turning")
                   + trials(r, people=3, following="adapts-0.5", view="still"))


# --- Columns and fields

@made("NA and empty fields in the measures that may be undefined")
def missing_values(r: random.Random) -> str:
    rows = trials(r, people=6, blocks=2)
    for row in rows:
        for name in ("mean_contact_angle_deg", "losses_per_s", "losses_100ms"):
            if r.random() < 0.1:
                row[name] = r.choice(["NA", ""])
    return text_of(rows)


@made("only what a file of people needs; penetration in metres")
def fewest_columns(r: random.Random) -> str:
    return text_of(without(trials(r, people=4), "following", "trial", "attempt", "losses_100ms",
                           "losses_per_s",
                           "mean_penetration_dm", "mean_contact_angle_deg"))


@made("penetration in metres where the decimetres are empty")
def penetration_in_two_units(r: random.Random) -> str:
    rows = trials(r, people=4)
    for row in rows:
        if r.random() < 0.5:
            row["mean_penetration_dm"] = ""
    return text_of(rows)


@made("other columns, another order of columns, names of columns in quotation marks, CRLF, a byte "
      "order mark")
def other_layout(r: random.Random) -> bytes:
    rows = put(trials(r, people=3), lambda row: {"comment": 'said "aha", twice', "age": 30})
    columns = sorted(("comment", "age") + FACTORS + MEASURES, key=lambda name: name[::-1])
    text = text_of(rows, columns, end="\r\n")
    head, rest = text.split("\r\n", 1)
    head = ",".join(f'"{name}"' for name in head.split(","))
    return ("\ufeff" + head + "\r\n\r\n" + rest + "\r\n").encode()


@made("names with markup, commas, quotation marks, mathtext and letters of other scripts")
def names_with_markup(r: random.Random) -> str:
    people = ["<b>Ann</b>", 'Bob "the hand", Jr.', "Zoë & Co.", "渡辺", "$x^2$", "{{ 7*7 }}"]
    objects = ["<script>alert(1)</script>", "cup, blue", "x_1 $\\alpha$", "%s\\n'"]
    return text_of(trials(r, people=people, objects=objects))


@made("names with markup in a refusal")
def refused_name_with_markup(r: random.Random) -> str:
    rows = trials(r, people=["<b>Ann</b>", "Bob"], objects=["<i>cup</i>", "jar"])
    rows[13]["losses_of_contact"] = ""
    return text_of(rows)


@made("a name with a control character of the direction of writing")
def refused_name_with_a_control_character(r: random.Random) -> str:
    return text_of(trials(r, people=["Ann", "B\u202eob"]))


@made("people in the order of the numbers in their names; 01 and 1 are two people")
def natural_order_of_people(r: random.Random) -> str:
    return text_of(trials(r, people=["P10", "P9", "P2", "01", "1", "P1b", "P1a"], blocks=[1]))


# --- Values

@made("times of days, penetrations of kilometres")
def large_values(r: random.Random) -> str:
    return text_of(scaled(trials(r, people=5), total_time_s=1e5, mean_penetration_dm=1e6,
                          mean_penetration_m=1e6))


@made("times of microseconds, penetrations of picometres")
def small_values(r: random.Random) -> str:
    return text_of(scaled(trials(r, people=5), total_time_s=1e-7, mean_penetration_dm=1e-10,
                          mean_penetration_m=1e-10, losses_per_s=1e7))


@made("values of a person are a power of ten times those of the one before")
def many_magnitudes(r: random.Random) -> str:
    rows = trials(r, people=7)
    for row in rows:
        scaled([row], **{name: 10.0 ** (int(row["participant"]) - 4)
                         for name in ("total_time_s", "mean_penetration_dm", "mean_penetration_m")})
    return text_of(rows)


@made("a large mean and a small scatter: 1e6 s and 1 ms")
def small_scatter(r: random.Random) -> str:
    rows = trials(r, people=5)
    return text_of(put(rows, lambda row: {
        "total_time_s": f"{1e6 + 1e-3 * row['total_time_s']:.9f}"}))


@made("effects so large that p-values are next to 0")
def large_effects(r: random.Random) -> str:
    return text_of(trials(r, people=10, blocks=3, objects=OBJECTS, effects=1.7, noise=0.02))


@made("no effect of Haptic and Rotation")
def no_effects(r: random.Random) -> str:
    return text_of(trials(r, people=8, effects=0))


@made("the effects of the paper with the opposite sign")
def opposite_effects(r: random.Random) -> str:
    return text_of(trials(r, people=12, blocks=3, effects=-1))


@made("most trials have no loss of contact")
def rare_losses(r: random.Random) -> str:
    def rare(row: Row) -> Row:
        count = int(r.random() < (0.3 if row["haptic"] == "NoH" else 0.1))
        return {"losses_of_contact": count, "losses_100ms": 0,
                "losses_per_s": six(count / row["total_time_s"])}
    return text_of(put(trials(r, people=6, blocks=3), rare))


@made("losses are 0 in H, and the angle is equal for all people in one condition")
def constant_in_a_condition(r: random.Random) -> str:
    def some(row: Row) -> Row:
        lost = {"losses_of_contact": 0, "losses_100ms": 0,
                "losses_per_s": 0} if row["haptic"] == "H" else {}
        return lost | ({"mean_contact_angle_deg": 45} if is_at(row, haptic="UaH",
                                                               rotation="R") else {})
    return text_of(put(trials(r, people=6, blocks=2), some))


@made("people do not differ in losses of 100 ms: differences within them have no scatter")
def equal_people(r: random.Random) -> str:
    return text_of(put(trials(r, people=5, blocks=2), lambda row: {
        "losses_100ms": 3 + HAPTIC.index(row["haptic"]) + (row["rotation"] == "R")}))


@made("losses of 100 ms are 2 in every trial")
def constant_outcome(r: random.Random) -> str:
    return text_of(put(trials(r, people=5, blocks=2), lambda row: {"losses_100ms": 2}))


@made("the difference between R and NoR is the same for each person: F is without bound")
def constant_difference(r: random.Random) -> str:
    level = {(p, h): r.randrange(20, 40) for p in range(1, 7) for h in HAPTIC}
    def value(row: Row) -> Row:
        base = level[int(row["participant"]), row["haptic"]]
        return {"total_time_s": base + (8 if row["rotation"] == "R" else 0) + (row["block"] - 1)}
    return text_of(put(trials(r, people=6, blocks=2, objects=["O1"]), value))


@made("penetration follows from the time and the losses, but for a millionth")
def nearly_collinear(r: random.Random) -> str:
    return text_of(tie_depth(put(trials(r, people=6, blocks=2), lambda row: {
        "mean_penetration_dm": six(0.05 + 0.001 * row["total_time_s"]
                                   + 0.0005 * row["losses_of_contact"])})))


@made("integers only")
def integers(r: random.Random) -> str:
    rows = trials(r, people=5, blocks=2)
    return text_of(tie_depth(put(rows, lambda row: {
        "total_time_s": round(row["total_time_s"]),
        "mean_penetration_dm": round(100 * row["mean_penetration_dm"]),
        "mean_contact_angle_deg": round(row["mean_contact_angle_deg"])})))


@made("times of 0 s: losses per second are undefined")
def times_of_zero(r: random.Random) -> str:
    rows = without(trials(r, people=4, blocks=2), "losses_per_s")
    for row in rows:
        if r.random() < 0.05:
            row["total_time_s"] = 0
    return text_of(rows)


@made("scatter of the trials differs between conditions and people; seventeen digits")
def unequal_scatter(r: random.Random) -> str:
    def wide(row: Row) -> Row:
        scale = (1 + 3 * HAPTIC.index(row["haptic"])) * (1 + int(row["participant"]) % 3)
        time = 30 + scale * r.expovariate(1.0)
        return {"total_time_s": repr(time), "mean_penetration_dm": repr(0.02 * r.lognormvariate(0,
            0.5 * scale / 9))}
    return text_of(put(trials(r, people=7, blocks=2), wide))


# --- Refused

@made("one person")
def refused_one_person(r: random.Random) -> str:
    return text_of(trials(r, people=1))


@made("practice alone")
def refused_practice_alone(r: random.Random) -> str:
    return text_of(trials(r, people=3, blocks=[0]))


@made("a condition has no trial")
def refused_absent_condition(r: random.Random) -> str:
    return text_of([row for row in trials(r) if not is_at(row, haptic="UaH", rotation="R",
                                                          object="O2")])


@made("a condition has no completed trial")
def refused_condition_not_completed(r: random.Random) -> str:
    return text_of(some_end(r, trials(r), 1, "timeout", haptic="UaH", rotation="R", object="O2"))


@made("no trial is completed")
def refused_no_completed_trial(r: random.Random) -> str:
    return text_of(some_end(r, trials(r), 1, "fault"))


@made("losses of contact are constant in each condition")
def refused_constant_losses(r: random.Random) -> str:
    return text_of(put(trials(r), lambda row: {
        "losses_of_contact": 10 + HAPTIC.index(row["haptic"])}))


@made("penetration is 0.1 plus a thousandth of the losses")
def refused_collinear(r: random.Random) -> str:
    return text_of(tie_depth(put(trials(r, people=5), lambda row: {
        "mean_penetration_dm": six(0.1 + 0.001 * row["losses_of_contact"])})))


@made("the angle is 45 deg in each trial")
def refused_constant_angle(r: random.Random) -> str:
    return text_of(put(trials(r), lambda row: {"mean_contact_angle_deg": 45}))


@made("losses of contact are empty in a completed trial")
def refused_empty_losses(r: random.Random) -> str:
    rows = trials(r)
    rows[30]["losses_of_contact"] = "NA"
    return text_of(rows)


@made("the column of the time is missing")
def refused_no_time(r: random.Random) -> str:
    return text_of(without(trials(r), "total_time_s"))


@made("the columns of the penetration are missing")
def refused_no_penetration(r: random.Random) -> str:
    return text_of(without(trials(r), "mean_penetration_m", "mean_penetration_dm"))


@made("a number where the object should be: too many cells")
def refused_too_many_cells(r: random.Random) -> str:
    return text_of(trials(r, people=2, blocks=[1, 2], objects=[str(i) for i in range(60)]))


@made("101 start orientations")
def refused_too_many_experiments(r: random.Random) -> str:
    return text_of([row for start in range(101)
                    for row in trials(r, people=2, blocks=[1], objects=["O1"], haptic=["H"],
                                      rotation=["R"],
                                      following="delayed", start_orientation_deg=start)])


@made("a variant has one person")
def refused_variant_of_one_person(r: random.Random) -> str:
    return text_of(trials(r, people=3, following="delayed", scale=1)
                   + trials(r, people=1, following="delayed", scale=0.5))


@made("a trial is there twice")
def refused_repeated_trial(r: random.Random) -> str:
    rows = trials(r)
    return text_of(rows + [rows[30]])


@made("a level is unknown")
def refused_unknown_level(r: random.Random) -> str:
    rows = trials(r)
    rows[30]["haptic"] = "full"
    return text_of(rows)


@made("the view of a simulated operator is not that of its following")
def refused_view_of_following(r: random.Random) -> str:
    return text_of(trials(r, following="delayed", view="still"))


@made("trials of a comparison of strategies")
def refused_strategies(r: random.Random) -> str:
    return text_of(put(trials(r, following="delayed", haptic=["H"], rotation=["R"]),
                       lambda row: {"haptic": "", "rotation": "", "strategy": "a4"}),
                   FACTORS + MEASURES + ("strategy",))


@made("a file of the canonical wall")
def refused_canonical_file(r: random.Random) -> str:
    return CANONICAL_COLUMNS + "\n"


@made("the limit is not a number of seconds", "--limit", "-3")
def refused_limit(r: random.Random) -> str:
    return text_of(trials(r, people=2))


# --- Samples of the former C++ tests

@made("sample_trials(): people")
def sample_people(r: random.Random) -> str:
    return trials_csv(sample_trials())


@made("sample_trials(): the four followings, with timeouts")
def sample_followings(r: random.Random) -> str:
    return trials_csv(sample_trials(SampleTrials(followings=FOLLOWINGS, has_timeouts=True)))


@made("sample_trials(): no effects")
def sample_without_effects(r: random.Random) -> str:
    return trials_csv(sample_trials(SampleTrials(effects=0.0, seed=5)))


@made("sample_trials(): twelve people, the opposite effects")
def sample_opposite(r: random.Random) -> str:
    return trials_csv(sample_trials(SampleTrials(participants=12, effects=-1.0)))
