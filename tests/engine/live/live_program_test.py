#!/usr/bin/env python3
"""`palpate experiment live` with participants without a browser.

usage: live_program_test.py PROGRAM MODELS KILLS

A participant goes through consent, learning, practice and the blocks; the rows are computed again
from the recordings. The program is killed KILLS times at random moments: only the trial that ran is
cut, and no finished one comes again. Pages with a wrong token, of another role or beside the first
one are refused; so is bad input, in one line.
"""

import csv
import json
import os
import pathlib
import random
import resource
import signal
import subprocess
import sys
import tempfile
import threading
import time

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "cli"), str(HERE.parents[1] / "helpers")]

from needs import need  # noqa: E402
from page_client import Closed, PageClient  # noqa: E402
from participant import RATING, Participant, Program  # noqa: E402
from trial_measures_test import Ticks, measures  # noqa: E402
from wall_follower import Record  # noqa: E402

TEXTS = {"information": "Read this.", "consent": "I agree.", "instructions": "Touch <b>it</b>.",
         "debriefing": "Thank you."}
DEVICE = {"sensors": 2, "actuators": 1, "rate_Hz": 1000, "stiffness_N_per_m": 1000,
          "damping_Ns_per_m": 2}


def plan_with(models, **changes):
    plan = {"palpate_plan": 1, "name": "short", "seed": 7, "participants": 3, "blocks": 3,
            "practice_blocks": 1, "device": DEVICE, "display_Hz": 40, "sphere_radius_m": 0.006,
            "limit_s": 60, "haptic": ["NoH"], "rotation": ["NoR", "R"],
            "objects": {"O1": str(models / "star.glb")}, "operator": "people2005",
            "followings": ["delayed"],
            "live": {"input": "mouse", "texts": TEXTS, "break_s": 0, "about": ["age"],
                     "longest_picture_s": 10, "longest_lateness_s": 10}}
    plan.update(changes)
    return plan


def seen_plan(models, **grip):
    """A plan with a force that is seen, and a grip so stiff that the hand is quick."""
    plan = plan_with(models, participants=2, blocks=1, practice_blocks=0, rotation=["R"],
                     haptic=["NoH", "seen-UaH", "seen-H"])
    plan["live"].update({"force": "seen", "grip": {"stiffness_N_per_m": 3000, "damping_Ns_per_m": 20,
                                                   "mass_kg": 0.1, **grip}})
    return plan


def rows_of(folder):
    with open(folder / "trials.csv", newline="") as file:
        return list(csv.DictReader(file))


def journal_of(folder, participant=1):
    lines = (folder / f"participants/{participant:02}/journal.txt").read_text().splitlines()
    return [json.loads(line[17:]) for line in lines]


def kill_later(process, folder, moment, changes):
    """Kills at a random moment or, in two of three cases, as soon as a file of the participant or the
    rows have changed so often: the program is then writing."""
    if moment < 1 / 3:
        time.sleep(4.5 * moment)
    else:
        end = time.monotonic() + 3.0
        seen = None
        while changes > 0 and time.monotonic() < end and process.poll() is None:
            now = sizes_in(folder)
            changes -= now != seen
            seen = now
    process.kill()


def which(status):
    """The trial that a status of the experimenter's page names."""
    return {key: status[key] for key in ("block", "place", "attempt")}


def sizes_in(folder):
    try:
        return [(entry, entry.stat().st_size) for entry in sorted(folder.rglob("*"))]
    except FileNotFoundError:  # renamed meanwhile
        return None


def page_trial(participant):
    """The number of the trial that a participant takes."""
    return participant.trials[-1]["number"]


class ClutchUser(Participant):
    """Sets the hand back at the beginning of the first trial, and presses in contact, which does nothing;
    lifts a pen in contact in the second."""

    BACK = (0.05, -0.02, 0.0)  # device frame, m

    def __init__(self, address):
        super().__init__(address, self.set_back)
        self.offset = (0.0, 0.0, 0.0)
        self.contacts = 0  # states in contact in this trial
        self.aimed = None

    def set_back(self, number, _):
        self.offset = self.BACK if number == 1 else (0.0, 0.0, 0.0)
        self.contacts = 0
        if number == 1:
            start = Record(self.page.newest_state()[1]).device
            target = [a + b for a, b in zip(start, self.BACK)]
            for place, buttons in ((start, 2), (start, 1), (start, 3), (target, 3), (target, 1)):
                self.page.point(place, buttons)
                while self.page.newest_state()[0] < self.page.sequence:
                    pass
            device = Record(self.page.newest_state()[1]).device
            assert max(abs(a - b) for a, b in zip(device, start)) < 1e-15, (device, start)

    def aim(self, record, target):
        self.contacts += record.contact
        is_second = len(self.trials) == 2
        if self.contacts == 10 and record.contact and not is_second:
            for buttons in (3, 1):
                self.page.point(self.aimed, buttons)
        self.aimed = [a + b for a, b in zip(target, self.offset)]
        self.page.point(self.aimed, 2 if is_second and self.contacts > 10 else 1)


class Tests:
    def __init__(self, program, models, kills):
        self.program, self.models, self.kills = program, models, kills
        self.folder = None

    def write(self, plan, name="plan.json"):
        path = self.folder / name
        path.write_text(json.dumps(plan))
        return path

    # The rows are what the recordings say.
    def test_course(self):
        plan = plan_with(self.models)
        plan["live"] = {**plan["live"], "break_s": 1}
        run = Program(self.program, self.write(plan), 1, self.folder / "out")

        def leave_second(number, participant):
            if number == 2:
                participant.page.newest_state()
                participant.page.send({"type": "left", "why": "focus"})
                participant.page.expect("trial_end")
                return True
            return False

        person = Participant(run.participant, leave_second)
        assert person.follow() == "done"
        code, text = run.end()
        assert code == 0, text
        rows = rows_of(self.folder / "out")
        done = [row for row in rows if row["status"] == "done"]
        aborted = [row for row in rows if row["status"] == "aborted"]
        assert len(done) == 8 and len(aborted) == 1, [row["status"] for row in rows]
        assert aborted[0]["reason"] == "focus" and aborted[0]["block"] == "0", aborted
        repeated = [row for row in done if row["attempt"] == "2"]
        assert [r["rotation"] for r in repeated] == [aborted[0]["rotation"]], repeated
        assert all(row["following"] == "" and row["input"] == "mouse" for row in rows)
        self.judge_recordings(plan, done)
        about = json.loads((self.folder / "out/participants/01/about.json").read_text())
        assert about == {"age": "30"}, about
        analysed = subprocess.run(
            [self.program, "experiment", "analyse", self.folder / "out/trials.csv", "--out",
             self.folder / "analysis"], capture_output=True, text=True)
        assert analysed.returncode in (0, 2), analysed.stderr

    def judge_recordings(self, plan, rows):
        recordings = self.folder / "out/participants/01/recordings"
        for row in rows:
            name = (f"block-{row['block']}-trial-{row['trial']}-{row['haptic']}-{row['rotation']}-"
                    f"{row['object']}-attempt-{row['attempt']}")
            trace = self.folder / f"{name}.csv"
            subprocess.run([self.program, "recording", "export", recordings / f"{name}.palpate",
                            "--csv", trace], check=True, capture_output=True)
            ticks = Ticks(trace)
            exact, near, status = measures(ticks, plan, self.models / "star.glb")
            # The haptic thread runs on for some ticks until the trial is stopped.
            assert row["status"] == "done" and status.startswith("done"), (name, status)
            del exact["missed_deadlines"]  # no part of a trace
            for column, value in exact.items():
                assert row[column] == str(value), (name, column, row[column], value)
            for column, (value, _) in near.items():
                assert abs(float(row[column]) - value) <= 1e-9 * max(abs(value), 1e-12), \
                    (name, column, row[column], value)

    # A force that is seen: the frame yields, the rows are what the recordings say, and these can be
    # computed again.
    def test_seen(self):
        plan = seen_plan(self.models)
        out = self.folder / "out"
        path = self.write(plan)
        for options in (["run", path, "--out", out],
                        ["live", path, "--participant", 1, "--script", "people2005", "--out", out]):
            done = self.run(*options)
            assert done.returncode == 2 and len(done.stderr.splitlines()) == 1, done
            assert "/live/force: is seen, which only people see" in done.stderr, done.stderr
        run = Program(self.program, path, 1, out)
        assert Participant(run.participant).follow() == "done"
        code, text = run.end()
        assert code == 0, text
        rows = rows_of(out)
        assert sorted(row["haptic"] for row in rows) == ["NoH", "seen-H", "seen-UaH"], rows
        assert all(row["status"] == "done" and row["input"] == "mouse" for row in rows), rows
        self.judge_recordings(plan, rows)
        depth = {row["haptic"]: float(row["mean_penetration_m"]) for row in rows}
        assert depth["seen-H"] < depth["NoH"], depth
        work = {row["haptic"]: float(row["port_work_J"]) for row in rows}
        assert work["NoH"] == 0 and work["seen-H"] != 0 and work["seen-UaH"] != 0, work
        for recording in sorted((out / "participants/01/recordings").iterdir()):
            proved = subprocess.run([self.program, "replay", recording], capture_output=True, text=True)
            assert proved.returncode == 0 and "each with the same bits" in proved.stdout, proved
        levels = (out / "columns.csv").read_text()
        assert "seen-H as H on a simulated hand (seen but not felt)" in levels, levels

    # Only the running trial is cut, and none that has ended comes again.
    def test_kills(self):
        seed = random.randrange(1 << 32)
        print(f"kills: seed {seed}")
        chance = random.Random(seed)
        plan = self.write(plan_with(self.models, blocks=3 + self.kills // 4))
        out = self.folder / "out"
        ended = []
        for _ in range(self.kills):
            run = Program(self.program, plan, 1, out)
            killer = threading.Thread(target=kill_later, args=(run.process, out, chance.random(),
                                                               chance.randrange(1, 12)))
            killer.start()
            try:
                Participant(run.participant).follow()
                raise AssertionError("the course ended before the last kill")
            except (Closed, OSError):
                pass
            killer.join()
            run.kill()
            ended = self.judge_journal(out, ended)
        run = Program(self.program, plan, 1, out)
        assert Participant(run.participant).follow() == "done"
        assert run.end()[0] == 0
        self.judge_journal(out, ended)
        done = [(r["block"], r["trial"]) for r in rows_of(out) if r["status"] != "aborted"]
        assert len(done) == len(set(done)) == 2 * (4 + self.kills // 4), len(done)

    def judge_journal(self, out, before):
        """The entries of ended trials begin with those of earlier runs; each attempt is there once."""
        text = (out / "participants/01/journal.txt").read_text()
        whole = text[:text.rfind("\n") + 1].splitlines()
        entries = [json.loads(line[17:]) for line in whole]
        ended = [e for e in entries if e["kind"] == "end"]
        assert ended[:len(before)] == before
        attempts = [(e["trial"], e["attempt"]) for e in ended]
        assert len(attempts) == len(set(attempts)), attempts
        finished = [e["trial"] for e in ended if e["status"] != "aborted"]
        assert len(finished) == len(set(finished)), finished
        assert all(e["reason"] in ("server", "hidden") for e in ended if e["status"] == "aborted")
        return ended

    # The rows of a simulated person are those of `experiment run`.
    def test_script(self):
        plan = self.write(plan_with(self.models, followings=["delayed", "frozen"], blocks=1,
                                    rotation=["R"], start_orientation_deg=[30]))
        for number in (2, 1):
            done = self.run("live", plan, "--participant", number, "--script", "people2005", "--out",
                            self.folder / "live")
            assert done.returncode == 0, done.stderr
        third = self.run("live", plan, "--participant", 3, "--script", "people2005", "--out",
                         self.folder / "live", "--pilot")
        assert third.returncode == 0, third.stderr
        assert self.run("run", plan, "--out", self.folder / "run").returncode == 0
        ours, theirs = ((self.folder / name / "trials.csv").read_text().splitlines()
                        for name in ("live", "run"))
        common = len(theirs[0].split(","))
        assert ours[0].split(",")[:common] == theirs[0].split(",")
        assert [line.split(",")[:common] for line in ours] == [line.split(",") for line in theirs]
        pilots = [row["pilot"] for row in rows_of(self.folder / "live")]
        assert pilots == ["0"] * 8 + ["1"] * 4, pilots

    # No motion is lost, however fast the messages come.
    def test_pointer(self):
        run = Program(self.program, self.write(plan_with(self.models)), 1, self.folder / "out")
        latencies = []

        def move(number, participant):
            page = participant.page
            _, data = page.newest_state()
            x, y, z = Record(data).device
            begin = time.monotonic()
            for i in range(2000):
                page.point((x - 1e-5 * (i + 1), y, z))
                while time.monotonic() < begin + 1e-3 * i:
                    pass
                if i % 20:
                    continue
                asked = time.monotonic()
                while page.newest_state()[0] < page.sequence:
                    pass
                latencies.append(time.monotonic() - asked)
            last = (x - 1e-5 * 2000, y, z)
            while page.newest_state()[0] < page.sequence:
                pass
            assert Record(page.newest_state()[1]).device == last
            page.send({"type": "frames", "times_ms": [1.0]})
            page.ask("pause")
            return True

        person = Participant(run.participant, move)
        person.follow(until=("paused",))
        run.kill()
        latencies.sort()
        print(f"pointer message to the state of the tick that used it: median "
              f"{1e3 * latencies[len(latencies) // 2]:.1f} ms, 99 % "
              f"{1e3 * latencies[int(0.99 * len(latencies))]:.1f} ms")

    # The hand is set back out of contact only; each use is in the row; a lift in contact ends the trial.
    def test_clutch(self):
        plan = plan_with(self.models, blocks=2, practice_blocks=0, rotation=["NoR"])
        plan["live"] = {**plan["live"], "clutch": True}
        run = Program(self.program, self.write(plan), 1, self.folder / "out")
        person = ClutchUser(run.participant)
        assert person.page.hello["clutch"] is True
        assert person.follow() == "done"
        assert run.end()[0] == 0
        rows = rows_of(self.folder / "out")
        seen = [(row["status"], row["reason"], row["clutches"]) for row in rows]
        assert seen == [("done", "", "2"), ("aborted", "lift", "0"), ("done", "", "0")], seen
        self.judge_recordings(plan, [rows[0], rows[2]])
        board = {**plan, "live": {**plan["live"], "input": "board"}}
        self.refused(self.write(board), "/live/clutch: is true with a board")

    # A trial for which the disk has no space does not begin, and what has ended stays.
    def test_full_disk(self):
        plan = self.write(plan_with(self.models))
        out = self.folder / "out"
        run = Program(self.program, plan, 1, out)

        def fill(number, participant):
            if number == 3:
                resource.prlimit(run.process.pid, resource.RLIMIT_FSIZE, (200_000, 200_000))
            return False

        try:
            Participant(run.participant, fill).follow()
        except Closed:
            pass
        code, text = run.end()
        assert code == 2 and "File too large" in text.splitlines()[-1], text
        before = [row for row in rows_of(out) if row["status"] == "done"]
        assert len(before) >= 2, before
        run = Program(self.program, plan, 1, out)
        assert Participant(run.participant).follow() == "done"
        assert run.end()[0] == 0
        done = [row for row in rows_of(out) if row["status"] == "done"]
        assert done[:len(before)] == before and len(done) == 8, len(done)

    # Who may do what.
    def test_pages(self):
        run = Program(self.program, self.write(plan_with(self.models)), 1, self.folder / "out")
        with PageClient(run.participant) as page:
            for kind in ("abort", "repeat", "skip", "rearm"):
                assert "another role" in page.ask(kind), kind
            assert "another role" in page.ask("note", text="hello")
            assert page.ask("next", step="consent") is not None
            assert page.ask("next", step="information") is None
            assert page.ask("next", step="information") is not None, "a second click does nothing"
            with PageClient(run.participant) as second:
                assert second.hello["control"] is False
                assert second.hello["step"]["step"] == "consent"
                assert "control" in second.ask("consent", value=False)
            with PageClient(run.experimenter) as experimenter:
                assert experimenter.hello["role"] == "experimenter"
                assert "another role" in experimenter.ask("consent", value=True)
                assert experimenter.ask("note", text="a <b>note</b>") is None
                assert experimenter.ask("take_control") is not None
                status = experimenter.expect("status")
                assert status["step"] == "consent", status
            assert page.ask("consent", value=False) is None
        wrong = run.participant[:-1] + ("0" if run.participant[-1] != "0" else "1")
        try:
            PageClient(wrong)
            raise AssertionError("a wrong token was accepted")
        except (Closed, OSError):
            pass
        assert run.end()[0] == 0
        assert list((self.folder / "out/participants").iterdir()) == [], "refusing leaves no data"

    def test_stop_before_consent(self):
        """Nothing is kept of somebody who has not consented."""
        for steps, keep in ((0, True), (1, True), (1, False)):
            run = Program(self.program, self.write(plan_with(self.models)), 1, self.folder / "out")
            with PageClient(run.participant) as page:
                if steps:
                    assert page.ask("next", step="information") is None
                assert page.ask("stop", keep=keep) is None
            assert run.end()[0] == 0
            assert not (self.folder / "out/participants/01").exists(), (steps, keep)

    # What the experimenter sees and may do, and what the journal keeps of it.
    def test_experimenter(self):
        out = self.folder / "out"
        run = Program(self.program, self.write(plan_with(self.models)), 1, out)
        watcher = PageClient(run.experimenter)
        assert watcher.hello["status"]["participant"] == 1 and watcher.hello["trial"] is None
        assert watcher.ask("rearm") == "rearm: the force was not cut"
        assert watcher.ask("repeat") is not None
        for kind in ("skip", "abort"):
            assert watcher.ask(kind, block=0, place=1, attempt=1) is not None, kind
        seen = []

        def act(number, participant):
            page = participant.page
            told = watcher.expect("trial", number=page_trial(participant))
            assert told == participant.trials[-1], "both roles see the same trial"
            status = watcher.expect("status", runs=True)
            place = (status["block"], status["place"], status["attempt"])
            assert status["step"] == ("block" if status["block"] else "practice"), status
            assert status["condition"] in ("NoH-NoR", "NoH-R") and status["object"] == "O1", status
            if number == 1:
                page.send({"type": "frames", "times_ms": [25.0 * i for i in range(1, 21)]})
                assert watcher.expect("status", pictures_Hz=40.0)["worst_late_us"] >= 0
                watcher.newest_state()
                assert watcher.ask("note", text="a <b>lorry</b> passed") is None
                assert watcher.ask("repeat") is None
                other = {**which(status), "attempt": status["attempt"] + 1}
                assert watcher.ask("abort", **other) is not None, "of another attempt"
                assert watcher.ask("abort", **which(status)) is None
                while not any(text["type"] == "trial_end" for text in page.texts):
                    page.read_frame()
                assert "step" not in [text["type"] for text in page.texts], "the trial stays shown"
            elif number == 2:
                assert watcher.ask("skip", **which(status)) is None
            elif number == 3:
                assert watcher.ask("pause") is None
                page.expect("trial_end")
                page.expect("step", step="paused")
                assert watcher.expect("status", paused=True)["step"] == "paused"
                assert watcher.ask("skip", **which(status)) is not None, "this attempt has ended"
                next_one = watcher.expect("status", paused=True)
                assert watcher.ask("skip", **which(next_one)) is None, "while the course is paused"
                assert watcher.ask("go_on") is None
                return True
            else:
                return False
            page.expect("trial_end")
            seen.append(place)
            return True

        person = Participant(run.participant, act)
        assert person.follow(until=("break",)) == "break"
        status = watcher.expect("status", step="break")
        counts = {kind: count for kind, count in status["attempts"].items() if count}
        run.kill()
        rows = [(r["block"], r["rotation"], r["attempt"], r["status"], r["reason"])
                for r in rows_of(out)]
        assert counts == {kind: [r[3] for r in rows].count(kind) for kind in {r[3] for r in rows}}
        entries = journal_of(out)
        notes = [e["text"] for e in entries if e["kind"] == "note"]
        assert notes == ["a <b>lorry</b> passed"], notes
        assert [e["by"] for e in entries if e["kind"] in ("pause", "go_on")] == ["experimenter"] * 2
        assert [e["kind"] for e in entries].count("repeat") == 1
        assert {r[4] for r in rows if r[3] in ("aborted", "skipped")} == {"experimenter"}, rows
        assert seen[:2] == [(0, 1, 1), (0, 2, 1)], seen
        assert [r[3] for r in rows][:2] == ["aborted", "skipped"], rows

    # With `blind`, the experimenter's page gets nothing that tells the condition.
    def test_blind(self):
        plan = plan_with(self.models)
        plan["live"] = {**plan["live"], "blind": True}
        run = Program(self.program, self.write(plan), 1, self.folder / "out")
        watcher = PageClient(run.experimenter)
        assert watcher.hello["blind"] is True

        def act(number, participant):
            participant.page.newest_state()
            for _ in range(3):
                status = watcher.expect("status")
            assert status["runs"] is True and not {"condition", "object", "rules"} & set(status)
            with PageClient(run.experimenter) as late:
                assert late.hello["trial"] is None and "condition" not in str(late.hello), late.hello
                late.expect("status")
                assert late.states == []
            participant.page.send({"type": "left", "why": "focus"})
            participant.page.expect("trial_end")
            assert watcher.ask("pause") is None
            return True

        Participant(run.participant, act).follow(until=("paused",))
        assert watcher.states == [], "neither states nor ticks"
        assert {text["type"] for text in watcher.texts} <= {"status", "answer"}, watcher.texts
        run.kill()

    # After each condition of a block the participant rates it; the answers are analysed and forgotten.
    def test_questionnaire(self):
        plan = plan_with(self.models, blocks=2, practice_blocks=0, order="williams")
        plan["live"] = {**plan["live"], "questionnaire": True}
        out = self.folder / "out"
        path = self.write(plan)
        for number in (1, 2):
            run = Program(self.program, path, number, out, *(["--pilot"] if number == 2 else []))
            person = Participant(run.participant)
            person.follow(until=("questionnaire",))
            page = person.page
            for change, words in (({"real": 8}, "real"), ({"tlx_effort": 7}, "tlx_effort"),
                                  ({"tlx_mental": 1 << 40}, "tlx_mental"), ({"other": 1}, "other")):
                problem = page.ask("rated", answers={**RATING, **change})
                assert words in problem, problem
            problem = page.ask("rated", answers={k: v for k, v in RATING.items() if k != "real"})
            assert "lacks real" in problem, problem
            if number == 2:  # a pilot's answers are in the journal only
                assert page.ask("rated", answers=RATING) is None
                run.kill()
                break
            run.kill()
            run = Program(self.program, path, number, out)  # it goes on at the questionnaire
            page.close()
            person = Participant(run.participant)
            assert person.page.hello["step"]["step"] == "questionnaire", person.page.hello
            assert person.follow() == "done"
            assert run.end()[0] == 0
        rated = [e for e in journal_of(out) if e["kind"] == "rated"]
        assert [e["block"] for e in rated] == [1, 1, 2, 2], rated
        assert all(e["answers"] == RATING for e in rated)
        with open(out / "questionnaires.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        expected = {("1", block, "NoH", r, item, str(v)) for block in ("1", "2") for r in ("NoR", "R")
                    for item, v in RATING.items()}
        assert {tuple(row.values()) for row in rows} == expected and len(rows) == 28, rows
        order = [row["rotation"] for row in rows_of(out) if row["participant"] == "1"]
        assert [e["rotation"] for e in rated] == order, "in the order of the conditions"
        done = self.run("forget", out, "1")
        assert done.returncode == 0 and not (out / "questionnaires.csv").exists(), done
        self.refused(self.write({**plan, "order": "random"}, "random.json"),
                     "/live/questionnaire: is true in a plan with the order random")

    def test_unfinished_end(self):
        """A participant who wanted no data to be kept has none left after the next start."""
        plan = self.write(plan_with(self.models))
        out = self.folder / "out"
        run = Program(self.program, plan, 1, out)
        person = Participant(run.participant)
        person.follow(until=("learning",))
        run.process.send_signal(signal.SIGSTOP)
        person.page.send({"type": "stop", "id": 99, "keep": False})
        run.process.send_signal(signal.SIGCONT)
        journal = out / "participants/01/journal.txt"
        while b'"stop"' not in journal.read_bytes():
            pass
        run.kill()
        if journal.exists():  # killed before it was removed
            self.refused(plan, "deleted now")
        assert not (out / "participants/01").exists()

    def test_messages_after_a_stop(self):
        """What comes behind a stop is not noted, and does not undo it."""
        out = self.folder / "out"
        run = Program(self.program, self.write(plan_with(self.models)), 1, out)
        watcher = PageClient(run.experimenter)

        def stop(number, participant):
            page = participant.page
            page.newest_state()
            page.send({"type": "frames", "times_ms": [1.0]})  # the program waits for the last ones
            page.send({"type": "stop", "id": 98, "keep": True})
            page.send({"type": "stop", "id": 99, "keep": False})
            page.expect("trial_end")
            assert watcher.ask("note", text="gone") == "the course has ended"
            raise Closed("stopped")

        try:
            Participant(run.participant, stop).follow()
        except Closed:
            pass
        code, text = run.end()
        assert code == 0 and "stopped; rows in" in text, (code, text)
        assert [e["kind"] for e in journal_of(out)][-2:] == ["end", "stop"], journal_of(out)[-2:]

    def test_reports_without_pictures(self):
        """A page that reports no pictures draws none, and times that no page has are refused."""
        plan = plan_with(self.models)
        plan["live"] = {**plan["live"], "longest_picture_s": 0.25}
        run = Program(self.program, self.write(plan), 1, self.folder / "out")

        def report(number, participant):
            page = participant.page
            page.newest_state()
            for wrong in ([-1.0], [2.0, 1.0], [1e308]):
                assert page.ask("frames", times_ms=wrong) is not None, wrong
            while not any(text["type"] == "trial_end" for text in page.texts):
                page.send({"type": "frames", "times_ms": []})
                page.read_frame()
            page.expect("trial_end")
            return True

        assert Participant(run.participant, report).follow(until=("paused",)) == "paused"
        assert "3 attempts in a row were aborted (late_frames)" in run.end(signal.SIGTERM)[1]
        rows = [(r["status"], r["reason"]) for r in rows_of(self.folder / "out")]
        assert rows == [("aborted", "late_frames")] * 3, rows

    def test_shared_folder(self):
        """Two programs in one folder, and a journal of a third participant that is damaged."""
        plan = self.write(plan_with(self.models, blocks=1, practice_blocks=0))
        out = self.folder / "out"
        run = Program(self.program, plan, 3, out)
        assert Participant(run.participant).follow() == "done"
        assert run.end()[0] == 0
        third = [row for row in rows_of(out) if row["participant"] == "3"]
        journal = out / "participants/03/journal.txt"
        journal.write_bytes(journal.read_bytes().replace(b'"about"', b'"abuot"'))
        runs = [Program(self.program, plan, number, out) for number in (1, 2)]
        people = [threading.Thread(target=Participant(r.participant).follow) for r in runs]
        for person in people:
            person.start()
        for person in people:
            person.join()
        assert [r.end()[0] for r in runs] == [0, 0]
        rows = rows_of(out)
        assert [row for row in rows if row["participant"] == "3"] == third
        assert [row["participant"] for row in rows] == ["1", "1", "2", "2", "3", "3"], rows
        assert self.run("forget", out, 2).returncode == 0
        assert [row["participant"] for row in rows_of(out)] == ["1", "1", "3", "3"]
        refused = self.run("run", plan, "--out", out)
        assert refused.returncode == 2 and "has trials of people" in refused.stderr, refused
        assert self.run("run", plan, "--out", self.folder / "simulated").returncode == 0
        simulated = self.run("live", plan, "--participant", 1, "--out", self.folder / "simulated")
        assert simulated.returncode == 2 and "simulated persons" in simulated.stderr, simulated
        assert self.run("run", plan, "--out", self.folder / "simulated").returncode == 0, \
            "the refused command leaves nothing in the folder"

    def test_second_program(self):
        plan = self.write(plan_with(self.models))
        run = Program(self.program, plan, 1, self.folder / "out")
        self.refused(plan, "is in use")
        run.kill()

    def test_reload(self):
        """A page that is loaded again goes on at the same step; a trial that ran is aborted."""
        run = Program(self.program, self.write(plan_with(self.models)), 1, self.folder / "out")

        def leave(number, participant):
            if number == 1:
                participant.page.newest_state()
                participant.page.close()
                raise Closed("reloaded")
            return False

        try:
            Participant(run.participant, leave).follow()
        except Closed:
            pass
        person = Participant(run.participant)
        assert person.page.hello["checked"]["css_px_per_mm"] == 3.78
        assert person.follow() == "done"
        assert run.end()[0] == 0
        aborted = [r for r in rows_of(self.folder / "out") if r["status"] == "aborted"]
        assert [r["reason"] for r in aborted] == ["hidden"], aborted

    def test_forget(self):
        plan = self.write(plan_with(self.models, blocks=1, practice_blocks=0))
        out = self.folder / "out"
        for number in (1, 2):
            run = Program(self.program, plan, number, out)
            assert Participant(run.participant).follow() == "done"
            assert run.end()[0] == 0
        others = [row for row in rows_of(out) if row["participant"] == "1"]
        run = Program(self.program, plan, 3, out)
        person = Participant(run.participant)
        person.follow(until=("learning",))
        busy = self.run("forget", out, "3")
        assert busy.returncode == 2 and "is in use" in busy.stderr, busy.stderr
        assert person.page.ask("stop", keep=False) is None
        assert run.end()[0] == 0
        done = self.run("forget", out, "2")
        assert done.returncode == 0 and "backups" in done.stdout, done
        assert self.run("forget", out, "2").returncode == 0, "a second time does no harm"
        assert rows_of(out) == others
        left = sorted(str(path.relative_to(out)) for path in out.rglob("*") if path.is_file()
                      and not str(path.relative_to(out)).startswith("participants/01/"))
        assert left == ["columns.csv", "forgotten.csv", "plan.json", "texts.json", "trials.csv"], left
        lines = (out / "forgotten.csv").read_text().splitlines()
        assert [line.split(",")[0] for line in lines] == ["participant", "3", "2"], lines
        nothing = self.run("forget", self.folder, "2")
        assert nothing.returncode == 2 and len(nothing.stderr.splitlines()) == 1, nothing

    def run(self, *words):
        return subprocess.run([self.program, "experiment", *map(str, words)], capture_output=True,
                              text=True, timeout=60)

    def refused(self, plan, words, *options, participant=1):
        done = subprocess.run([self.program, "experiment", "live", plan, "--participant",
                               str(participant), "--out", self.folder / "out", *options],
                              capture_output=True, text=True, timeout=60)
        lines = done.stderr.splitlines()
        assert done.returncode == 2 and len(lines) == 1 and words in lines[0], \
            (words, done.returncode, done.stderr)

    def test_bad_input(self):
        good = plan_with(self.models)
        live = good["live"]
        self.refused(self.write(good), "expected 1 to 3", participant=0)
        self.refused(self.write(good), "expected 1 to 3", participant=4)
        self.refused(self.write({**good, "haptic": ["NoH", "H"]}), "/haptic/1: is H")
        without = {**live, "texts": {k: v for k, v in TEXTS.items() if k != "consent"}}
        self.refused(self.write({**good, "live": without}), "/live/texts/consent")
        (self.folder / "long.txt").write_text("a" * (1 << 20) + "b")
        long = {**live, "texts": {**TEXTS, "information": {"file": "long.txt"}}}
        self.refused(self.write({**good, "live": long}), "long.txt")
        blank = {**live, "texts": {**TEXTS, "debriefing": " \n"}}
        self.refused(self.write({**good, "live": blank}), "/live/texts/debriefing")
        self.refused(self.write({k: v for k, v in good.items() if k != "live"}), "/live: is missing")
        wrong = {**live, "words": {"go_onn": "Weiter"}}
        self.refused(self.write({**good, "live": wrong}), "/live/words/go_onn: is no word")
        unnamed = {**live, "words": {"go_on": " "}}
        self.refused(self.write({**good, "live": unnamed}), "/live/words/go_on: is \" \"")
        self.refused(self.write({**good, "scale": [1, 2]}), "/live: is in a plan with several")
        self.refused(self.write(good), "--device: is given", "--device", "hapi:port=/dev/null")
        seen = seen_plan(self.models)
        self.refused(self.write({**good, "haptic": ["NoH", "seen-H"]}), "/haptic/1: is seen-H, which")
        self.refused(self.write({**seen, "haptic": ["seen-H", "UaH"]}), "/haptic/1: is UaH, which")
        on_board = {**seen["live"], "input": "board"}
        self.refused(self.write({**seen, "live": on_board}), "/live/force: is seen, but")
        loose = seen_plan(self.models, damping_Ns_per_m=0)
        loose["device"] = {**DEVICE, "stiffness_N_per_m": 6000}
        self.refused(self.write(loose), "/live/grip/damping_Ns_per_m: is 0, with which the hand")
        board = {**live, "input": "board"}
        both = {**good, "haptic": ["UaH", "H"], "device": {**DEVICE, "actuators": 2}, "live": board}
        self.refused(self.write(both), "/haptic/0: is UaH", "--device", "hapi:port=/dev/null")
        self.refused(self.write({**good, "live": board}), "--device: is missing")
        assert not (self.folder / "out").exists(), "nothing is written"

    def test_other_plan_and_changed_journal(self):
        plan = self.write(plan_with(self.models))
        run = Program(self.program, plan, 1, self.folder / "out")
        with PageClient(run.participant) as page:
            page.ask("next", step="information")
        run.kill()
        self.refused(self.write(plan_with(self.models, seed=8), "other.json"), "is another one")
        self.refused(plan, "line 1: is", "--pilot")
        journal = self.folder / "out/participants/01/journal.txt"
        text = journal.read_bytes()
        journal.write_bytes(text.replace(b'"information"', b'"infornation"'))
        self.refused(plan, "its checksum does not fit")


def run_all(tests):
    """Runs the methods test_... of an object with a program, each with a folder of its own."""
    page = subprocess.run([tests.program, "view", "--licences"], capture_output=True, text=True)
    need(page.returncode != 2, "a program with the page; run ./run.sh view once")
    only = os.environ.get("PALPATE_ONLY", "")  # runs the tests whose names have it
    for name in sorted(name for name in dir(tests) if name.startswith("test_") and only in name):
        begin = time.monotonic()
        with tempfile.TemporaryDirectory() as folder:
            tests.folder = pathlib.Path(folder)
            getattr(tests, name)()
        print(f"{name}: {time.monotonic() - begin:.1f} s", flush=True)


if __name__ == "__main__":
    os.environ.setdefault("PYTHONDONTWRITEBYTECODE", "1")
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)  # the program inherits it: a write then fails
    run_all(Tests(str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2]).resolve(),
                  int(sys.argv[3])))
