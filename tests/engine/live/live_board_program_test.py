#!/usr/bin/env python3
"""`palpate experiment live` with a board in the hand, killed, pulled out and tripped.

usage: live_board_program_test.py PROGRAM MODELS BOARD

The program has its real guard. BOARD (simulated_board.cpp) is the judge of the force. Times are
printed and not asserted: the machine may be busy.
"""

import json
import math
import pathlib
import signal
import sys
import time

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1] / "helpers")]

from board_client import Board  # noqa: E402
from live_program_test import plan_with, rows_of, run_all  # noqa: E402
from needs import need_terminals  # noqa: E402
from page_client import Closed, PageClient  # noqa: E402
from participant import (  # noqa: E402
    CHECK,
    REPORT_S,
    STATE_BYTES,
    Participant,
    Program,
    page_ms,
)
from wall_follower import Record, WallFollower  # noqa: E402

MS_PER_NS = 1e-6
SHORT = {"limit_s": 4}  # trials that may end by their limit
PRESS_M = 3e-3  # beyond the green sphere
MOST_STARTS = 10
TEAR_M = 0.4  # the hand pulls the board away with as many times its stiffness


class Grasp(WallFollower):
    """A hand that is soft, as people's are: it pulls the device to where it wants it."""

    speed_m = 0.5e-3
    depth_m = 0.5e-3
    turn = math.radians(60)

    def target(self, record):
        if self.inward is None and not record.contact:  # through the green sphere into the wall
            x, y = record.proxy[:2]
            dx, dy = self.green[0] - x, self.green[1] - y
            beyond = 1.0 + PRESS_M / max(math.hypot(dx, dy), 1e-9)
            return record.to_device(x + beyond * dx, y + beyond * dy)
        return super().target(record)


class Holder(Participant):
    """A participant whose hand holds a board. on_force(number, holder): called once in each trial,
    when the hand feels a force; a true answer ends the trial from here."""

    def __init__(self, address, board, on_force=lambda number, holder: None):
        super().__init__(address)
        self.board, self.on_force = board, on_force
        self.hand = self.record = self.ring = None

    def take(self, shown):
        if shown["step"] == "check":
            self.page.ask("checked", **{**CHECK, "input": "board", "motion": "unknown", "unadjusted": None})
        else:
            super().take(shown)

    def touch(self, message):
        if self.page.ask("ready", trial=message["number"]) is not None:
            return
        learns = message["step"] == "learning"
        if not learns:
            self.trials.append(message)
        self.hand, led_to = Grasp(message["green_m"]), None
        told = learns
        begun = self.board.read()["last_force_ns"]
        reported = asked = time.monotonic()
        while True:
            self.record = self.next_record()
            if self.record is None:
                return
            if self.ring != led_to:
                led_to = self.ring
                if led_to or not self.hand.inward:
                    self.hand = Grasp(led_to or message["green_m"])
            report = self.board.pull(*self.hand.target(self.record)[:2])
            now = time.monotonic()
            if not told and self.hand.inward and report["last_force_ns"] != begun:
                told = True
                if self.on_force(len(self.trials), self):
                    return
            if learns and not self.ring and now - asked > REPORT_S:
                self.page.ask("next", step="learning")
                asked = now
            if now - reported > REPORT_S:
                self.page.send({"type": "frames", "times_ms": [page_ms(now)]})
                reported = now

    def next_record(self):
        """The record of the newest state; none: the trial has ended."""
        self.page.states.clear()
        while not self.page.states:
            for text in [t for t in self.page.texts if t["type"] in ("ring", "trial_end")]:
                self.page.texts.remove(text)
                if text["type"] == "ring":
                    self.ring = text["p_scene_m"]
                else:
                    return None
            if any(text["type"] == "trial" for text in self.page.texts):
                return None  # it is announced again
            self.page.read_frame()
        return Record(self.page.states[-1][STATE_BYTES:])


def zero_ns(board):
    """When the board let go for good: no force comes for half a second."""
    while True:
        report = board.read()
        if report["zero_ns"] is not None and report["now_ns"] - report["zero_ns"] > 500_000_000:
            return report["zero_ns"]
        time.sleep(0.01)


class Tests:
    def __init__(self, program, models, board):
        self.program, self.models, self.board_program = program, models, board
        self.folder = None

    def plan(self, **changes):
        plan = plan_with(self.models, haptic=["UaH", "H"], rotation=["NoR"], scale=[0.15],
                         sphere_radius_m=0.002, blocks=1, practice_blocks=0,
                         device={"sensors": 2, "actuators": 1, "rate_Hz": 1000,
                                 "stiffness_N_per_m": 150, "damping_Ns_per_m": 1}, **changes)
        plan["live"] = {**plan["live"], "input": "board"}
        del plan["live"]["about"]
        path = self.folder / "plan.json"
        path.write_text(json.dumps(plan))
        return path

    def start(self, board, **changes):
        for tried in range(MOST_STARTS):
            try:
                return Program(self.program, self.plan(**changes), 1, self.folder / "out", "--without-realtime",
                               "--device", f"hapi:port={board.port},torque-per-Nm=1,peak-torque=0.1")
            except RuntimeError as error:
                # A busy machine is late at the port, and with that delay the wall would not be calm.
                if "/device/stiffness_N_per_m" not in str(error) or tried + 1 == MOST_STARTS:
                    raise

    def ends(self, run, board, holder, reason):
        """The course goes on to its end. One attempt was aborted, the first one of a trial, for this
        reason."""
        assert holder.follow() == "done"
        assert run.end()[0] == 0
        board.end()
        rows = [(r["haptic"], r["attempt"], r["status"], r["reason"]) for r in rows_of(self.folder / "out")]
        aborted = [row for row in rows if row[2] == "aborted"]
        assert [(row[1], row[3]) for row in aborted] == [("1", reason)], rows
        others = [row for row in rows if row[2] in ("done", "timeout")]
        attempts = {haptic: "2" if haptic == aborted[0][0] else "1" for haptic in ("UaH", "H")}
        assert {row[0]: row[1] for row in others} == attempts and len(rows) == 3, rows

    # Nobody feels a force any more once the program is gone; the trial is repeated.
    def test_kill(self):
        board = Board(self.board_program)
        run = self.start(board, **SHORT)
        moments = []

        def kill(number, holder):
            moments.append(time.monotonic_ns())
            run.process.kill()
            return True

        try:
            Holder(run.participant, board, kill).follow()
        except (Closed, OSError):
            pass
        run.kill()
        print(f"kill -9 in contact: zero force {MS_PER_NS * (zero_ns(board) - moments[0]):.1f} ms later")
        board.end()
        board = Board(self.board_program)
        run = self.start(board, **SHORT)
        self.ends(run, board, Holder(run.participant, board), "server")

    # A hand that tears the board away: the force falls as the governor states, and comes back only
    # when the experimenter has rearmed.
    def test_trip(self):
        board = Board(self.board_program)
        run = self.start(board, **SHORT)
        watcher = PageClient(run.experimenter)
        moments = []

        def tear(number, holder):
            if number > 1:
                return False
            x, y = holder.hand.inward
            device = holder.record.device
            far = holder.record.to_device(holder.record.proxy[0] + TEAR_M * x, holder.record.proxy[1] + TEAR_M * y)
            moments.append(board.pull(far[0], far[1])["now_ns"])
            holder.page.expect("trial_end")
            board.pull(*device[:2])
            holder.page.expect("step", step="paused")
            zero = zero_ns(board)
            print(f"torn away: zero force {MS_PER_NS * (zero - moments[0]):.1f} ms after the hand began to pull")
            assert watcher.expect("status", paused=True)["trip"] == "speed"
            assert "rearm" in holder.page.ask("go_on")
            assert watcher.ask("rearm") is None
            assert board.read()["zero_ns"] == zero
            assert holder.page.ask("go_on") is None
            return True

        self.ends(run, board, Holder(run.participant, board, tear), "trip")

    # The cable is pulled out. The same command goes on with a board that is plugged in again.
    def test_unplugged(self):
        board = Board(self.board_program)
        run = self.start(board, **SHORT)

        def unplug(number, holder):
            board.tell(hang_up=True)
            return False

        assert Holder(run.participant, board, unplug).follow(until=("paused",)) == "paused"
        assert run.end(signal.SIGINT)[0] == 130
        board = Board(self.board_program)
        run = self.start(board, **SHORT)
        holder = Holder(run.participant, board)
        assert holder.page.hello["step"]["step"] == "paused", "a trip stays until somebody has looked"
        with PageClient(run.experimenter) as watcher:
            assert watcher.ask("rearm") is None
        assert holder.page.ask("go_on") is None
        holder.page.hello["step"] = holder.page.expect("step", step="block")
        self.ends(run, board, holder, "trip")


if __name__ == "__main__":
    program, models, board = (pathlib.Path(word).resolve() for word in sys.argv[1:])
    need_terminals()
    run_all(Tests(str(program), models, str(board)))
