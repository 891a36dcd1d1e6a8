"""A participant without a browser who waits in each trial until somebody ends it.

usage: waiting_participant.py ADDRESS STEP: up to this step of the course
"""

import pathlib
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "live"))

from page_client import Closed  # noqa: E402
from participant import REPORT_S, Participant  # noqa: E402


def wait(_number, participant):
    page = participant.page
    begin, pictures = time.monotonic(), 0
    while not any(text["type"] == "trial_end" for text in page.texts):
        page.read_frame()
        page.states.clear()
        if time.monotonic() > begin + REPORT_S:  # 40 Hz
            page.send({"type": "frames", "times_ms": [25.0 * i for i in range(pictures, pictures + 8)]})
            begin, pictures = time.monotonic(), pictures + 8
    page.expect("trial_end")
    return True


try:
    Participant(sys.argv[1], wait).follow(until=(sys.argv[2],))
except (Closed, OSError):
    pass  # the test has ended
