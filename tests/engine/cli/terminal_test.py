#!/usr/bin/env python3
"""Progress is one line that fits the terminal; in a log it is a line now and then.

terminal_test.py PALPATE MODELS_DIR

Runs the program on terminals of several widths and kinds, reads their content, and presses Ctrl-C.
"""

import fcntl
import json
import os
import pathlib
import pty
import re
import select
import signal
import struct
import subprocess
import sys
import tempfile
import termios

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "helpers"))
from needs import need_terminals  # noqa: E402

RUN = ["run", "star.glb", "--out", "out"]
DONE = (0, 3)  # exit codes; 3: not comparable, because the runs are short


def check(condition, message):
    if not condition:
        sys.exit(message)


class Terminal:
    """A program whose stdin, stderr and controlling terminal are a terminal of `columns` columns."""

    def __init__(self, palpate, models, folder, columns, kind, arguments):
        self.end, inner = pty.openpty()
        fcntl.ioctl(inner, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
        arguments = [str(models / a) if a.endswith(".glb") else a for a in arguments]
        self.process = subprocess.Popen(
            [str(palpate), *arguments], cwd=folder, stdin=inner, stdout=subprocess.PIPE, stderr=inner,
            env={**os.environ, "TERM": kind}, start_new_session=True,
            preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0))
        os.close(inner)
        self.text = ""

    def read(self, until=None):
        """The terminal's content until the program ends or the pattern `until` appears."""
        while until is None or not re.search(until, self.text):
            ready, _, _ = select.select([self.end], [], [], 60)
            check(ready, f"no output for 60 s: {self.text!r}")
            try:
                part = os.read(self.end, 4096)
            except OSError:  # the program has ended
                break
            if not part:
                break
            self.text += part.decode()
        return self.text

    def finish(self):
        self.read()
        out = self.process.stdout.read().decode()
        os.close(self.end)
        return self.process.wait(), out


def check_progress(text, columns, seconds):
    lines = [line for line in re.split(r"[\r\n]+", text) if "%" in line or "#" in line]
    check(len(lines) >= 2, f"no progress: {text!r}")
    check(all(len(line) < columns for line in lines), f"too long for {columns} columns: {lines}")
    check("\x1b" not in text, f"an escape sequence, which some terminals do not support: {text!r}")
    bar = text[:text.rfind("%") + 1]
    check("\n" not in bar, f"more than a line: {bar!r}")
    if columns >= 60:
        shares = [int(share) for share in re.findall(r"(\d+) %", text)]
        check(max(shares) == 100 and min(shares) == 0, f"shares {shares}")
        check(re.search(rf"\d\.\d of {seconds:.1f} s", text), f"no seconds: {text!r}")


def write_plan(path, models, participants):
    """A plan of an experiment; a participant takes a tenth of a second or more."""
    path.write_text(json.dumps({
        "palpate_plan": 1, "name": "terminal", "seed": 1, "participants": participants, "blocks": 1,
        "practice_blocks": 0,
        "device": {"sensors": 2, "actuators": 1, "rate_Hz": 1000, "stiffness_N_per_m": 1000,
                   "damping_Ns_per_m": 2},
        "display_Hz": 40, "sphere_radius_m": 0.006, "limit_s": 120, "haptic": ["NoH", "H"],
        "rotation": ["NoR", "R"], "objects": {"O1": str(models / "star.glb")},
        "operator": "literature", "followings": ["delayed"]}))


def check_experiments(palpate, models, folder):
    """The line of an experiment states the time left; Ctrl-C ends it between two trials."""
    write_plan(pathlib.Path(folder) / "plan.json", models, participants=6)
    run = ["experiment", "run", "plan.json", "--jobs", "1", "--out"]
    for columns in (80, 24, 8):
        terminal = Terminal(palpate, models, folder, columns, "xterm", [*run, f"out-{columns}"])
        code, out = terminal.finish()
        text = terminal.text
        check(code == 0 and "24 trials of 6 participants: " in out, f"{code}: {text!r} {out!r}")
        check("\x1b" not in text and "\n" not in text, f"not one line: {text!r}")
        lines = [line for line in text.split("\r") if line.strip()]
        check(len(lines) >= 2 and all(len(line) < columns for line in lines), f"lines: {lines}")
        shares = [int(share) for share in re.findall(r"(\d+) %", text)]
        check(shares == sorted(shares) and shares[-1] <= 100, f"shares {shares}")
        if columns == 80:
            check(re.search(r"experiment, \d+ s left \[#+ *\] +\d+ %", text), f"no time: {text!r}")
    quiet = subprocess.run([str(palpate), *run, "quiet"], cwd=folder, capture_output=True, text=True)
    check(quiet.returncode == 0 and quiet.stderr == "", f"without a terminal: {quiet.stderr!r}")
    write_plan(pathlib.Path(folder) / "plan.json", models, participants=1000)
    terminal = Terminal(palpate, models, folder, 80, "xterm", [*run, "cut"])
    terminal.read(until=r"experiment, .* left")
    os.write(terminal.end, b"\x03")
    code, out = terminal.finish()
    check(code == 130 and out == "", f"exit code {code}: {terminal.text!r} {out!r}")
    check(re.search(r"palpate: interrupted; \d+ of 1000 participants are complete in cut/parts(, "
                    r"\d+ trials? of (an )?incomplete participants? (is|are) kept there)?, and the same command goes on from there", terminal.text), f"{terminal.text!r}")
    check(not (pathlib.Path(folder) / "cut" / "trials.csv").exists(), "results of half a plan")


def check_replays(palpate, models, folder):
    """Replays, and commands that read a whole recording, show their progress, which ends at most at 100 %."""
    (pathlib.Path(folder) / "way.txt").write_text("".join(f"{i * 1e-7} 0 0.1\n" for i in range(30_000)))
    record = ["run", str(models / "star.glb"), "--virtual", "--seconds", "30", "--a4", "on", "--record",
              "long.palpate", "--out", "recorded"]
    done = subprocess.run([str(palpate), *record], cwd=folder, capture_output=True, text=True)
    check(done.returncode in DONE, done.stderr)
    for labels, arguments in (
            (["replay", "writing the trace"], ["replay", "star.glb", "--trajectory", "way.txt", "--repeat", "2",
                                               "--out", "trace.csv"]),
            (["replay"], ["replay", "long.palpate"]),
            (["replay"], ["replay", "long.palpate", "--damping", "5"]),
            (["recording check"], ["recording", "check", "long.palpate"]),
            (["recording repair"], ["recording", "repair", "long.palpate", "--out", "copy.palpate"]),
            (["recording export"], ["recording", "export", "long.palpate", "--csv", "export.csv"])):
        terminal = Terminal(palpate, models, folder, 80, "xterm", arguments)
        code, out = terminal.finish()
        text = terminal.text
        check(code == 0 and out, f"{arguments}: {code}: {text!r}")
        check("\x1b" not in text and "\n" not in text, f"{arguments}: not one line: {text!r}")
        for label in labels:
            shares = [int(share) for share in
                      re.findall(rf"\r{label}(?:, [^\[\r]* left)? \[#* *\] +(\d+) %", text)]
            check(len(shares) > 3 and shares == sorted(shares) and shares[-1] <= 100,
                  f"{arguments}: {label}: {shares}: {text!r}")
        quiet = subprocess.run([str(palpate), *[str(models / a) if a == "star.glb" else a for a in arguments]],
                               cwd=folder, capture_output=True, text=True)
        check("%" not in quiet.stderr, f"without a terminal: {quiet.stderr!r}")


def main():
    palpate, models = (pathlib.Path(path).resolve() for path in sys.argv[1:3])
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_DFL)
    need_terminals()
    with tempfile.TemporaryDirectory() as folder:
        for columns, kind in ((80, "xterm"), (200, "dumb"), (60, "vt100"), (33, "xterm"),
                              (12, "xterm"), (2, "dumb"), (1, "xterm"), (0, "unknown")):
            for seconds, more in ((4, ["--virtual"]), (2, [])):
                if more == [] and columns != 80:
                    continue
                terminal = Terminal(palpate, models, folder, columns, kind,
                                    RUN + ["--seconds", str(seconds)] + more)
                code, out = terminal.finish()
                check(code in DONE and "mean contact angle" in out, f"{code}: {terminal.text}")
                if columns not in (1, 2):  # too narrow for a share
                    check_progress(terminal.text, columns or 80, seconds)
        # Ctrl-C in the middle of a run in real time.
        terminal = Terminal(palpate, models, folder, 80, "xterm", RUN + ["--seconds", "60"])
        terminal.read(until=r" [1-9]\d*\.\d of 60\.0 s")
        os.write(terminal.end, b"\x03")
        code, out = terminal.finish()
        check(code == 130, f"exit code {code}: {terminal.text!r}")
        check(re.search(r"interrupted +after [1-9]\d*\.\d\d s", out), out)
        check("palpate: interrupted;" in terminal.text, f"{terminal.text!r}")
        check_experiments(palpate, models, folder)
        check_replays(palpate, models, folder)
        # Without a terminal on stderr.
        quiet = subprocess.run([str(palpate), "run", str(models / "star.glb"), "--virtual",
                                "--seconds", "4"], cwd=folder, capture_output=True, text=True)
        check(quiet.returncode in DONE, f"exit code {quiet.returncode}: {quiet.stderr}")
        check("\r" not in quiet.stderr and "of 4.0 s" not in quiet.stderr, quiet.stderr)
        # A long command in a log; JSON on stdout stays JSON.
        log = subprocess.run([str(palpate), "soak", str(models / "star.glb"), "--minutes", "0.2",
                              "--json", "--out", "log"], cwd=folder, capture_output=True, text=True)
        check(log.returncode == 0 and json.loads(log.stdout), f"{log.returncode}: {log.stderr}")
        check("\r" not in log.stderr, log.stderr)
        check(re.search(r"^palpate: soak, \d+ s left, \d+ % done$", log.stderr, re.M), log.stderr)


main()
