"""A participant of `palpate experiment live` without a browser."""

import subprocess
import time

from page_client import PageClient
from wall_follower import Record, WallFollower

CHECK = {"input": "mouse", "motion": "unaccelerated", "css_px_per_mm": 3.78, "device_pixel_ratio": 1,
         "width_px": 1920, "height_px": 1080, "refresh_Hz": 60.0, "unadjusted": True, "stroke_ratio": None}
TLX = ("mental", "physical", "temporal", "performance", "effort", "frustration")
RATING = {**{f"tlx_{name}": 5 * i for i, name in enumerate(TLX)}, "real": 6}
TRIAL_STEPS = ("learning", "practice", "block")
READERS = ("information", "instructions", "break", "debriefing")  # steps that `next` ends
REPORT_S = 0.2  # from one report of pictures to the next
OPENED_S = time.monotonic()


def page_ms(now_s):
    """performance.now() of a page that was opened when this file was loaded."""
    return 1000 * (now_s - OPENED_S)


class Program:
    """`palpate experiment live`, as it runs."""

    def __init__(self, program, plan, participant, folder, *options):
        self.process = subprocess.Popen(
            [program, "experiment", "live", plan, "--participant", str(participant), "--out", folder,
             *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        lines = [self.process.stdout.readline().split() for _ in range(2)]
        if not all(lines):
            raise RuntimeError(self.process.stderr.read())
        self.participant, self.experimenter = (line[-1] for line in lines)

    def kill(self):
        self.process.kill()
        self.process.communicate()

    def end(self, by=None):
        """Waits for the end. Returns the exit code, and what was printed."""
        if by is not None:
            self.process.send_signal(by)
        out, err = self.process.communicate(timeout=60)
        return self.process.returncode, out + err


class Participant:
    """Goes through the course. on_trial(number, participant): called when a trial has begun; a true
    answer ends the trial from the page."""

    def __init__(self, address, on_trial=lambda number, participant: None):
        self.page = PageClient(address)
        self.on_trial = on_trial
        self.trials = []  # the messages of the trials that began

    def aim(self, _record, target):
        self.page.point(target)

    def follow(self, until=("done",)):
        """Up to one of these steps. Raises Closed when the server ends."""
        shown = self.page.hello["step"]
        if shown["step"] in TRIAL_STEPS:
            self.page.ask("next", step=shown["step"])  # the trial was announced before this page came
        while shown["step"] not in until:
            self.take(shown)
            message = self.next_of("step", "trial")
            while message["type"] == "trial":
                self.touch(message)
                message = self.next_of("step", "trial")
            shown = message
        return shown["step"]

    def next_of(self, *kinds):
        while True:
            while self.page.texts:
                message = self.page.texts.pop(0)
                if message["type"] in kinds:
                    return message
            self.page.read_frame()

    def take(self, shown):
        step = shown["step"]
        if step == "consent":
            self.page.ask("consent", value=True)
        elif step == "check":
            self.page.ask("checked", **CHECK)
        elif step == "about":
            self.page.ask("about", answers={"age": "30"})
        elif step == "questionnaire":
            self.page.ask("rated", answers=RATING)
        elif step in READERS and shown["may_go_on"]:  # a break that is not over is told again
            self.page.ask("next", step=step)

    def touch(self, message):
        if self.page.ask("ready", trial=message["number"]) is not None:
            return  # it runs, or has run: this page has asked for it twice
        if message["step"] == "learning":
            self.page.newest_state()
            self.page.ask("next", step="learning")
            return
        self.trials.append(message)
        if self.on_trial(len(self.trials), self):
            return
        hand = WallFollower(message["green_m"])
        reported = 0.0
        while True:
            self.page.states.clear()
            while not self.page.states:
                if any(text["type"] == "trial_end" for text in self.page.texts):
                    self.page.expect("trial_end")
                    self.page.send({"type": "frames", "times_ms": [page_ms(time.monotonic())]})
                    return
                self.page.read_frame()
            record = Record(self.page.states[-1][STATE_BYTES:])
            self.aim(record, hand.target(record))
            now = time.monotonic()
            if now - reported > REPORT_S:
                self.page.send({"type": "frames", "times_ms": [page_ms(now)]})
                reported = now


STATE_BYTES = 136  # in front of the record (engine/viewer/messages.h)

