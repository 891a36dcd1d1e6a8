#!/usr/bin/env python3
"""The report of a comparison of strategies, in a browser.

compare_browser_test.py REPORT.html
compare_browser_test.py --make PROGRAM ARGUMENT...
                                         PROGRAM ARGUMENT... FOLDER writes FOLDER/report.html

Opens the page in headless Chromium; its console must stay empty. Then measures the page in frames as
wide as a screen and as a phone, with all parts unfolded: the page is no wider than the frame and
requests nothing; a table wider than the frame scrolls within its own box; the answer comes first, its
table of the best techniques is within the frame, and it says that the hands are simulated. Exits with
77 if no Chromium is installed.
"""

import functools
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "helpers"))
from browser import open_and_measure, parse_options, run_test, width_and_request_problems

MEASURES = 18

MEASURE = """
function measure_frame(frame) {
  const page = frame.contentDocument;
  page.querySelectorAll('details').forEach(part => part.open = true);
  const answer = page.querySelector('#answer');
  const best = [...answer.querySelectorAll('tbody tr')];
  const boxes = [...page.querySelectorAll('.wide')].map(box => ({
      right: box.getBoundingClientRect().right, scrolls: getComputedStyle(box).overflowX,
      rows: box.querySelectorAll('tbody tr').length}));
  return {width: frame.clientWidth, content: page.documentElement.scrollWidth, requests: requests_of(frame),
          first: page.querySelector('main > section').id, boxes: boxes, best: best.length,
          beyond: best.filter(row => row.getBoundingClientRect().right > frame.clientWidth)
              .map(row => row.textContent),
          answer: answer.textContent, title: page.title};
}
"""


def frame_problems(frame):
    problems = width_and_request_problems(frame)
    problems += [f"beyond the frame: {text}" for text in frame["beyond"]]
    if frame["first"] != "answer":
        problems.append(f"begins with {frame['first']}")
    if frame["best"] != MEASURES:
        problems.append(f"names the best technique by {frame['best']} measures")
    for number, box in enumerate(frame["boxes"]):
        if box["right"] > frame["width"] or box["scrolls"] != "auto" or box["rows"] == 0:
            problems.append(f"table {number}: {box}")
    for text in ("The hands are simulated", "Where A4 loses"):
        if text not in frame["answer"]:
            problems.append(f"the answer does not say: {text}")
    if "simulated hands" not in frame["title"]:
        problems.append(f"the title is {frame['title']}")
    return problems


def main():
    options = parse_options(__doc__)
    return run_test(options.report, options.make,
                    functools.partial(open_and_measure, MEASURE, frame_problems))


if __name__ == "__main__":
    sys.exit(main())
