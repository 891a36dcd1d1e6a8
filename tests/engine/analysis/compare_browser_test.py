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

import argparse
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "helpers"))
from browser import measured_in_frames, open_page, run_test

MEASURES = 16

MEASURE = """
function measure_frame(frame) {
  const page = frame.contentDocument;
  page.querySelectorAll('details').forEach(part => part.open = true);
  const requests = frame.contentWindow.performance.getEntriesByType('resource')
      .map(entry => entry.name).filter(name => !name.startsWith('data:'));
  const answer = page.querySelector('#answer');
  const best = [...answer.querySelectorAll('tbody tr')];
  const boxes = [...page.querySelectorAll('.wide')].map(box => ({
      right: box.getBoundingClientRect().right, scrolls: getComputedStyle(box).overflowX,
      rows: box.querySelectorAll('tbody tr').length}));
  return {width: frame.clientWidth, content: page.documentElement.scrollWidth, requests: requests,
          first: page.querySelector('main > section').id, boxes: boxes, best: best.length,
          beyond: best.filter(row => row.getBoundingClientRect().right > frame.clientWidth)
              .map(row => row.textContent),
          answer: answer.textContent, title: page.title};
}
"""


def frame_problems(frame):
    problems = []
    if frame["content"] > frame["width"]:
        problems.append(f"the page is {frame['content']} px wide")
    problems += [f"requests {name}" for name in frame["requests"]]
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
    return [f"{frame['width']} px: {problem}" for problem in problems]


def problems_of(browser, page, folder):
    path = folder / "page.html"
    path.write_text(page, encoding="utf-8")
    _, console = open_page(browser, path, folder / "profile")
    problems = [f"on the console: {line}" for line in console]
    for frame in measured_in_frames(browser, page, folder, MEASURE):
        problems += frame_problems(frame)
    return problems


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("report", nargs="?", type=pathlib.Path)
    parser.add_argument("--make", nargs=argparse.REMAINDER, metavar="PROGRAM")
    options = parser.parse_args()
    if (options.report is None) == (options.make is None):
        parser.error("either a report or a program that makes one")
    return run_test(options.report, options.make, problems_of)


if __name__ == "__main__":
    sys.exit(main())
