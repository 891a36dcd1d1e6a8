"""The cases of `compare`, `experiment power`, `experiment sweep`, `experiment run canonical` and
`accuracy`: name -> what it is, arguments, files of the inputs."""

from __future__ import annotations

import json
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

from made_trials import HAPTIC, ROTATION, Row, dropped, ended, is_at, put, some_end, text_of, trials

ROOT = Path(__file__).resolve().parents[4]
Given = tuple[str, list[str], dict[str, bytes]]
OBJECTS = ("star", "labyrinth", "inverted_labyrinth", "lock")


def models(*names: str) -> dict[str, bytes]:
    return {f"models/{name}.glb": (ROOT / "models" / f"{name}.glb").read_bytes() for name in names}


def shipped(name: str) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((ROOT / "engine" / "trials" / f"{name}.json").read_text())
    return found


def as_json(tree: Any) -> bytes:
    return (json.dumps(tree, indent=1) + "\n").encode()


# --- compare

def slow_operator(factor: float) -> bytes:
    """people2005, whose trials last longer by a factor: some of them reach the limit of 120 s."""
    operator = shipped("people2005")
    speed = operator["parameters"]["speed_m_per_s"]
    speed.update(low=speed["low"] * factor, high=speed["high"] * factor)
    return as_json(operator | {"name": "slow", "note": "people2005, slower"})


def compare_cases() -> dict[str, Given]:
    two, three = models("star", "lock"), models("star", "labyrinth", "lock")
    stars = models("star")
    slow = {"slow.json": slow_operator(0.21)}
    cases: dict[str, Given] = {}

    def add(name: str, about: str, scenes: dict[str, bytes], options: str, *,
            more: dict[str, bytes] | None = None) -> None:
        arguments = ["compare", *scenes, *options.split()]
        cases[name] = (about, arguments, scenes | (more or {}))

    add("paper_objects",
        "the committed results (benchmarks/results/compare/people2005.json), as JSON",
        models(*OBJECTS), "--json")
    add("all_strategies", "one scene, four hands, every strategy", stars, "--hands 4")
    add("two_hands", "the fewest hands", stars, "--hands 2 --strategies mask,a4,cd")
    add("three_scenes", "means over three scenes and for each", three,
        "--hands 3 --strategies none,mask,full,a4,a4-anticipate")
    add("one_strategy", "one strategy: nothing to compare with", stars,
        "--hands 3 --strategies mask")
    add("without_a4", "no a4: no differences to it", two, "--hands 3 --strategies mask,cd,full")
    add("without_mask", "no mask: no differences to it", two, "--hands 3 --strategies a4,cd,none")
    add("references_alone", "none and full, which are references", two,
        "--hands 3 --strategies none,full")
    add("followings", "hands of all followings", stars,
        "--hands 3 --strategies mask,a4 --followings")
    add("followings_of_two_scenes", "hands of all followings, two scenes, tuned", two,
        "--hands 2 --strategies mask,a4,anisotropic --followings")
    add("anisotropic", "the values of E that are tried", stars,
        "--hands 4 --strategies mask,anisotropic,a4")
    add("anisotropic_given", "two values of E are given", stars,
        "--hands 4 --strategies mask,anisotropic:0.25,anisotropic:4,a4")
    add("passive_budgets", "a4-passive with three budgets", stars,
        "--hands 4 --strategies mask,a4-passive:0,a4-passive:5,a4-passive:200,a4")
    add("slow_hands", "timeouts: a strategy completes fewer than 90 % of its trials", stars,
        "--hands 5 --strategies none,mask,a4,full --operator slow.json",
        more={"slow.json": slow_operator(0.135)})
    add("very_slow_hands", "no trial of any strategy ends", stars,
        "--hands 2 --strategies mask,a4 --operator slow.json",
        more={"slow.json": slow_operator(0.05)})
    add("slow_hands_of_two_scenes",
        "a scene without a completed trial", models("star", "inverted_labyrinth"),
        "--hands 3 --strategies mask,a4,anisotropic --operator slow.json", more=slow)
    add("literature", "other ranges of the hands, another seed", two,
        "--hands 3 --operator literature --seed 7 --strategies none,mask,a4")
    add("refused_three_sensors", "three sensors", stars,
        "--hands 3 --sensors 3 --actuators 2 --strategies mask,a4,full")
    add("refused_anisotropic", "a value of E and the tuned one", stars,
        "--strategies anisotropic:0.25,anisotropic")
    add("forward", "the normal turns to the forward end", stars,
        "--hands 3 --align forward --strategies mask,a4")
    add("small_scene", "a scaled scene", stars, "--hands 3 --scale 0.5 --strategies mask,a4")
    add("printed_table", "Table 1 and the step as printed: a4 does not help", stars,
        "--hands 3 --table1 printed --a4-step paper --strategies mask,a4,none")
    add("small_force", "a largest force of 0.5 N, adaptive velocity", stars,
        "--hands 3 --max-force 0.5 --damping 5 --velocity-estimator adaptive "
        "--velocity-window 8 --encoder-quantum 1e-5 --strategies mask,a4,full")
    add("refused_one_hand", "one hand", stars, "--hands 1")
    add("refused_strategy", "a strategy that is unknown", stars, "--strategies mask,magic")
    add("refused_strategy_twice", "a strategy is there twice", stars, "--strategies mask,a4,mask")
    return cases


# --- experiment power

CONDITIONS = [f"{h}-{t}" for h in HAPTIC for t in ROTATION]
FIVE = "NoH-NoR=29,NoH-R=31,UaH-NoR=27,UaH-R=29,H-NoR=25"
FEW = ["--sets", "200", "--participants", "12"]


def effects(*means: float) -> str:
    return ",".join(f"{name}={mean:g}" for name, mean in zip(CONDITIONS, means))


def pilots() -> dict[str, tuple[str, list[Row]]]:
    """Files of pilots that are used: what each is, and its rows."""
    r = random.Random("pilots")
    both = trials(r, people=4, following="delayed") + trials(r, people=5)
    uah = put(trials(r, people=4, haptic=["UaH"]),
              lambda row: {"view": "still" if row["block"] == 0 else "turning"})
    two_views = trials(r, people=3, view="turning") + trials(r, people=3, view="still")
    return {
        "people": ("balanced, 4 people", trials(r, people=4, blocks=2)),
        "two_people": ("2 people, 1 block, 2 objects", trials(r, people=2, blocks=1)),
        "missing": ("timeouts, faults and absent trials", dropped(r, some_end(
            r, some_end(r, trials(r, people=8, blocks=3), 0.08, "timeout"), 0.05, "fault"), 0.08)),
        "without_a_person": ("one person lacks a condition, and is left out", [
            row for row in trials(r, people=5) if not is_at(row, participant=2, haptic="H",
                                                            rotation="R")]),
        "several_followings": ("people and simulated operators", both),
        "several_views": ("two views", two_views),
        "angle": ("UaH alone; practice with another view", uah),
        "no_scatter_between": ("people who do not differ: the variance of u is 0", put(
            trials(r, people=6, noise=1.0), lambda row: {"total_time_s": round(
                30 + 2 * HAPTIC.index(row["haptic"]) + r.gauss(0, 6), 4)})),
        "large_effects": ("effects far above the error", trials(r, people=5, effects=6, noise=0.3)),
    }


def refused_pilots() -> dict[str, tuple[str, str | list[Row], list[str]]]:
    r = random.Random("refused pilots")
    good = trials(r, people=3)
    by = {"one_person": lambda row: row["participant"] == "1",
          "practice": lambda row: row["block"] == 0,
          "without_uah": lambda row: row["haptic"] != "UaH",
          "nor_alone": lambda row: row["rotation"] == "NoR",
          "one_trial": lambda row: row["block"] == 1 and row["object"] == "O1",
          "one_complete_person": lambda row: row["participant"] == "1"
          or not is_at(row, haptic="H", rotation="R"),
          "no_common_object": lambda row: row["haptic"] != "NoH" or (row["participant"] == "1") == (
              row["object"] == "O1"),
          "few_in_common": lambda row: row["block"] == 1 and row["participant"] != "3" and (
              row["participant"] == "1" or row["object"] == "O1")}
    found: dict[str, tuple[str, str | list[Row], list[str]]] = {
        name: (f"a pilot with these rows: {name}", [row for row in good if keeps(row)], [])
        for name, keeps in by.items()}
    too_large = [dict(row) for row in good]
    too_large[-1]["total_time_s"] = 1e155
    found |= {
        "empty": ("an empty file", "", []),
        "columns_alone": ("no trial", text_of(good).split("\n")[0] + "\n", []),
        "semicolons": ("semicolons", text_of(good).replace(",", ";"), []),
        "nan": ("nan in a completed trial", [*good[:-1], good[-1] | {"total_time_s": "nan"}], []),
        "twice": ("a trial is there twice", [*good, good[3]], []),
        "no_losses": ("no value of the measure", [{k: v for k,
                                                   v in row.items() if k != "losses_of_contact"}
                                                  for row in good], ["--measure", "losses"]),
        "constant": ("the measure does not vary but between people", [
            row | {"total_time_s": 20 + 3 * int(row["participant"])} for row in good], []),
        "timeouts": ("no completed trial", [ended(dict(row), "timeout") for row in good], []),
        "two_kinds": ("people and simulated operators, --following is missing", good + [
            row | {"following": "delayed"} for row in good], []),
        "other_following": ("the following is not in the file", good, ["--following", "delayed"]),
        "too_large": ("a time of 1e155 s", too_large, []),
        "with_error": ("--error with a pilot", good, ["--error", "0.5"]),
        "strategies": ("trials of strategies", [row | {"haptic": "", "rotation": "",
                                                       "strategy": "a4"}
                                                for row in trials(r, haptic=["H"], rotation=["R"])],
                       []),
    }
    return found


REFUSED_OPTIONS = {
    "measure": ["--measure", "speed"], "five_effects": ["--effect", FIVE],
    "effect_without_number": ["--effect", FIVE + ",H-R="], "effect_part": ["--effect",
                                                                           FIVE + ",H-R"],
    "effect_empty_part": ["--effect", FIVE + ","], "effect_nan": ["--effect", FIVE + ",H-R=nan"],
    "effect_large": ["--effect", FIVE + ",H-R=1e10"], "effect_unit": ["--effect",
                                                                      FIVE + ",H-R=28 s"],
    "effect_twice": ["--effect", FIVE + ",H-R=28,H-NoR=4"], "effect_unknown": ["--effect",
                                                                               FIVE + ",R-H=28"],
    "effect_of_angle": ["--measure", "angle", "--effect", FIVE + ",H-R=28"],
    "error_0": ["--error", "0"],
    "share_u": ["--share-u", "30%"], "shares_above_1": ["--share-u", "0.7", "--share-w", "0.4"],
    "share_u_1": ["--share-u", "1", "--share-w", "0"], "share_u_alone": ["--share-u", "0.85"],
    "share_w_alone": ["--share-w", "0.9"], "following": ["--following", "delayed"],
    "nothing_left": ["--share-u", "0.9999999999999999", "--share-w", "0"],
    "effect_too_large": ["--effect", FIVE + ",H-R=1e9"],
    "error_too_small": ["--error", "1e-8", "--effect", FIVE + ",H-R=28"],
    "missing": ["--pilot", "missing.csv"]}


def power_cases() -> dict[str, Given]:
    power = ["experiment", "power"]
    one = ["--share-u", "0.3", "--share-w", "0.1"]
    cases: dict[str, Given] = {}
    for measure in ("time", "losses", "penetration", "angle"):
        cases[f"paper_{measure}"] = (f"{measure}: the paper's means and errors, a grid of shares",
                                     [*power, "--measure", measure, *FEW], {})
        cases[f"one_{measure}"] = (f"{measure}: the paper's means and errors, shares given",
                                   [*power, "--measure", measure, "--sets", "1000",
                                    "--participants", "20", *one], {})
    given = {
        "effects_given": ["--effect", effects(30, 34, 29, 29, 27, 28), "--error", "9", *one],
        "no_effect": ["--effect", effects(30, 30, 30, 30, 30, 30), "--error", "9", *one],
        "interaction_alone": ["--effect", effects(30, 34, 34, 30, 32, 32), "--error", "6", *one],
        "large_effect": ["--effect", effects(10, 40, 20, 50, 30, 60), "--error", "5", *one],
        "effects_with_the_papers_error": ["--effect", effects(30, 34, 29, 29, 27, 28), *one],
        "error_given": ["--error", "12", "--share-u", "0.2", "--share-w", "0.3"],
        "share_w_0": ["--error", "9", "--share-u", "0.5", "--share-w", "0"],
        "share_u_0": ["--error", "9", "--share-u", "0", "--share-w", "0.2"],
        "share_u_given": ["--error", "9", "--share-u", "0.4"],
        "share_w_given": ["--error", "9", "--share-w", "0.2"],
        "four_trials": ["--measure", "losses", "--trials", "4", *one],
        "another_seed": ["--error", "9", "--seed", "7", *one],
        "two_people": ["--error", "9", "--participants", "2", *one],
        "angle_given": ["--measure", "angle", "--effect", "UaH-R=32,UaH-NoR=49", "--error", "40",
                        *one],
        "tiny_units": ["--measure", "penetration", "--effect",
                       effects(*(x * 1e-4 for x in (9, 8, 7, 6, 3, 3))),
                       "--error", "4e-4", *one]}
    for name, arguments in given.items():
        few = FEW if "--participants" not in arguments else FEW[:2]
        cases[name] = (name.replace("_", " "), [*power, *few, *arguments], {})
    for name, (about, rows) in pilots().items():
        following = ["--following", "people"] if name == "several_followings" else []
        measure = ["--measure", "angle"] if name == "angle" else []
        refused = "refused_" if name == "several_views" else ""
        cases[f"{refused}pilot_{name}"] = (
            f"a pilot: {about}", [*power, *FEW, "--pilot", "pilot.csv", *following, *measure],
            {"pilot.csv": text_of(rows).encode()})
    rows = pilots()["people"][1]
    for name, more in {"trials": ["--trials", "12"], "losses": ["--measure", "losses"],
                       "penetration": ["--measure", "penetration"],
                       "effects": ["--effect", effects(30, 34, 29, 29, 27, 28)]}.items():
        cases[f"pilot_with_{name}"] = (f"a pilot with {name} given",
                                       [*power, *FEW, "--pilot", "pilot.csv", *more],
                                       {"pilot.csv": text_of(rows).encode()})
    for name, (about, content, more) in refused_pilots().items():
        columns = list(content[0]) if name == "strategies" else None
        text = content if isinstance(content, str) else text_of(content, columns)
        cases[f"refused_pilot_{name}"] = (about, [*power, *FEW, "--pilot", "pilot.csv", *more],
                                          {"pilot.csv": text.encode()})
    for name, arguments in REFUSED_OPTIONS.items():
        cases[f"refused_{name}"] = ("options: " + " ".join(arguments), [*power, *FEW, *arguments],
                                    {})
    return cases


# --- experiment sweep

SMALL_SWEEP: dict[str, Any] = {
    "palpate_sweep": 1, "name": "small",
    "plan": {"palpate_plan": 1, "name": "base", "seed": 7, "participants": 2, "blocks": 1,
             "practice_blocks": 0,
             "device": {"sensors": 2, "actuators": 1, "rate_Hz": 1000, "stiffness_N_per_m": 1000,
                        "damping_Ns_per_m": 2},
             "display_Hz": 40, "sphere_radius_m": 0.006, "limit_s": 120,
             "haptic": list(HAPTIC), "rotation": list(ROTATION),
             "objects": {"O1": "models/star.glb"},
             "operator": "people2005", "followings": ["delayed"]},
    "parameters": {"sight_delay_s": [0.2, 0.1], "intention_noise_m": [0.001, 0.002],
                   "force_noise": [0, 0.05],
                   "press_depth_m": [0.004, 0.008], "hand_stiffness_N_per_m": [200, 400],
                   "speed_m_per_s": [0.03, 0.06], "stiffness_N_per_m": [500, 1000],
                   "comfortable_depth_m": [0.005, 0.01], "following": ["delayed", "frozen"],
                   "align": ["nearest", "forward"], "start_orientation_deg": [0, 45],
                   "scale": [0.5, 1]},
    "hypercube": {"points": 6, "seed": 3, "participants": 1}}


def sweep_cases() -> dict[str, Given]:
    star = models("star")
    cases: dict[str, Given] = {}

    def add(name: str, about: str, sweep: dict[str, Any], files: dict[str, bytes]) -> None:
        cases[name] = (about, ["experiment", "sweep", "sweep.json"],
                       files | {"sweep.json": as_json(sweep)})

    def with_plan(sweep: dict[str, Any], **plan: Any) -> dict[str, Any]:
        return sweep | {"plan": sweep["plan"] | plan}

    full = shipped("sweep")
    objects = {name: f"models/{path}" for name, path in full["plan"]["objects"].items()}
    add("assumptions", "the sweep that ships (benchmarks/results/sweep/sweep.json)",
        with_plan(full, objects=objects),
        models(*OBJECTS))
    add("small", "every parameter with two levels", SMALL_SWEEP, star)
    quick = {name: SMALL_SWEEP["parameters"][name] for name in ("sight_delay_s", "following",
                                                                "scale")}
    add("quick", "three parameters", SMALL_SWEEP | {"parameters": quick}, star)
    one = {"press_depth_m": [0.002, 0.004, 0.008, 0.012, 0.02]}
    add("one_parameter", "one parameter with five levels, no hypercube beyond two points",
        SMALL_SWEEP | {
        "parameters": one, "hypercube": {"points": 2, "seed": 3, "participants": 1}}, star)
    slow = {"speed_m_per_s": [0.004, 0.006, 0.03], "following": ["delayed", "frozen"]}
    add("timeouts", "slow hands: points whose trials do not end", SMALL_SWEEP | {
        "parameters": slow, "hypercube": {"points": 8, "seed": 5, "participants": 1}}, star)
    add("many_points", "forty points of the hypercube, two parameters",
        with_plan(SMALL_SWEEP, participants=2) | {
        "parameters": {"sight_delay_s": [0.05, 0.2, 0.35], "hand_stiffness_N_per_m": [135, 300,
                                                                                      600]},
        "hypercube": {"points": 40, "seed": 11, "participants": 2}}, star)
    return cases


# --- experiment run canonical

def canonical_cases() -> dict[str, Given]:
    cases: dict[str, Given] = {}

    def add(name: str, about: str, **changes: Any) -> None:
        plan = shipped("canonical") | changes
        cases[name] = (about, ["experiment", "run", "plan.json"], {"plan.json": as_json(plan)})

    device = shipped("canonical")["device"]
    cases["shipped"] = ("the plan that ships", ["experiment", "run", "canonical"], {})
    add("two_people", "two people, three angles", participants=2, angles_deg=[0, 45, 90])
    add("one_person", "one person: no interval", participants=1, angles_deg=[0, 30, 60, 90])
    add("one_angle", "one angle", participants=4, angles_deg=[45])
    add("literature", "other ranges, seed and angles", operator="literature", seed=7,
        participants=5,
        angles_deg=[0, 10, 20, 35, 50, 70, 85, 90])
    add("soft", "a soft wall at 500 Hz", participants=4,
        device=device | {"stiffness_N_per_m": 50, "rate_Hz": 500})
    add("stiff", "a stiff wall at 200 Hz", participants=4,
        device=device | {"stiffness_N_per_m": 20000, "rate_Hz": 200, "damping_Ns_per_m": 0})
    return cases | made_walls()


def key_hash(text: bytes) -> str:
    """engine/trials/key_hash.h: the hash of one text."""
    h = 14695981039346656037
    for byte in b"t" + len(text).to_bytes(8, "little") + text:
        h = (h ^ byte) * 1099511628211 % 2**64
    for factor in (0xFF51AFD7ED558CCD, 0xC4CEB9FE1A85EC53, 1):
        h = (h ^ h >> 33) * factor % 2**64
    return f"{h:016x}"


WALL_COLUMNS = "participant,angle_deg,motion,rotation,along_over_into,share_within_30deg\n"
# What a run of the plan that ships with three people and the angles 0, 45 and 90 deg writes beside
# its parts.
WALL_RUN: dict[str, Any] = {
    "run": "b8906003e8e73dae", "version": "0.1.0", "plan": {"name": "canonical",
                                                            "hash": "1fa60bbd17d18a9e"},
    "seed": 2003, "participants": 3, "scenes": {}, "kind": "canonical",
    "operator": {"name": "people2005", "version": 1, "hash": "e38488ce893d8ede"}}


def made_wall(name: str, measures: Callable[[int, int, str, str, random.Random], str]) -> dict[str,
    bytes]:
    """The parts of a run whose trials are made. measures: the two last fields of a row."""
    r = random.Random(name)
    files = {"made/parts/run.json": as_json(WALL_RUN)}
    for person in (1, 2, 3):
        rows = "".join(f"{person},{angle},{motion},{turned},"
                       f"{measures(person, angle, motion, turned, r)}\n"
                       for angle in (0, 45, 90) for motion in ("pressed", "stroked")
                       for turned in ROTATION).encode()
        run = WALL_RUN["run"]
        head = f"palpate part 1, run {run}, participant {person}, rows {key_hash(rows)}\n"
        files[f"made/parts/participant-{person}.csv"] = head.encode() + WALL_COLUMNS.encode() + rows
    return files


def made_walls() -> dict[str, Given]:
    """Runs with results that the simulation does not give: without a result, ties, large values."""
    def drawn(r: random.Random) -> str:
        return f"{r.expovariate(2):.6g},{r.random():.6g}"

    makers: dict[str, tuple[str, Callable[[int, int, str, str, random.Random], str]]] = {
        "some_without_a_result": ("a third of the trials has no result",
                                  lambda p, a, m, t, r: "," if r.random() < 0.33 else drawn(r)),
        "one_person_without_a_result": (
            "one person has no result, one angle has results of one person",
            lambda p, a, m, t, r: "," if p == 2 or (a == 45 and p == 3) else drawn(r)),
        "none_with_a_result": ("no trial has a result", lambda p, a, m, t, r: ","),
        "equal": ("every trial has the same result", lambda p, a, m, t, r: "0.5,0.25"),
        "large": ("ratios over many magnitudes", lambda p, a, m, t,
                  r: f"{10.0 ** r.randrange(-12, 13):g},1")}
    arguments = ["experiment", "merge", "made", "--out", "experiment"]
    return {f"made_{name}": (about, arguments, made_wall(name, maker))
            for name, (about, maker) in makers.items()}


# --- accuracy

def accuracy_cases() -> dict[str, Given]:
    star = models("star")
    scene = next(iter(star))
    return {
        "without_a_scene": ("no scene", ["accuracy", "--quick"], {}),
        "with_a_scene": ("a scene", ["accuracy", scene, "--quick"], star),
        "with_a_delay": ("a device whose answer is late by 2 ms", [
            "accuracy", scene, "--quick", "--device-delay", "0.002", "--rate", "2000"], star),
        "one_knob": ("one knob, another device and seed", [
            "accuracy", "--quick", "--knob", "a4_step", "--knob", "servo_rate", "--seed", "3",
            "--device-mass", "0.3",
            "--device-damping", "0", "--device-friction", "0", "--encoder-quantum", "0"], {}),
        "refused_knob": ("a knob that is unknown", ["accuracy", "--quick", "--knob", "magic"], {}),
    }
