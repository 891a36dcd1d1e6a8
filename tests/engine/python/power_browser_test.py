#!/usr/bin/env python3
"""The report of `experiment power`, in a browser.

power_browser_test.py PANELS REPORT.html
power_browser_test.py PANELS --make PROGRAM ARGUMENT...
                                         PROGRAM ARGUMENT... FOLDER writes FOLDER/report.html

Opens the page in headless Chromium; its console must stay empty. Then measures the page in frames as
wide as a screen and as a phone, with all parts unfolded: the page is no wider than the frame and
requests nothing; a table wider than the frame scrolls within its own box; the answer comes first, and
the numbers of people in its table are within the frame; there are PANELS panels, each names its axes,
and no text in them is cut, covers another or is tiny. Exits with 77 if no Chromium is installed.
"""

import functools
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "helpers"))
from browser import open_and_measure, parse_options, run_test, width_and_request_problems

LEAST_TEXT_PX = 10.0  # the height of a line of text; that of a letter is about two thirds

MEASURE = """
function measure_frame(frame) {
  const page = frame.contentDocument;
  page.querySelectorAll('details').forEach(part => part.open = true);
  const panels = [...page.querySelectorAll('.panels svg')].map(measure_texts);
  const people = [...page.querySelectorAll('#answer tbody tr')].map(row => row.children[2]);
  return {width: frame.clientWidth, content: page.documentElement.scrollWidth, requests: requests_of(frame),
          first: page.querySelector('main > section').id, people: people.length, panels: panels,
          beyond: people.filter(cell => cell.getBoundingClientRect().right > frame.clientWidth)
              .map(cell => cell.textContent),
          boxes: [...page.querySelectorAll('.wide')].map(box => ({
              right: box.getBoundingClientRect().right, scrolls: getComputedStyle(box).overflowX}))};
}
"""


def panel_problems(panel):
    problems = [f"cut: {text}" for text in panel["cut"]]
    problems += [f"covers: {text}" for text in panel["covering"]]
    problems += [f"lacks {text}" for text in ("number of people", "power") if text not in panel["texts"]]
    if panel["least"] < LEAST_TEXT_PX:
        problems.append(f"a text is {panel['least']} px large")
    return [f"panel {panel['name']}: {problem}" for problem in problems]


def frame_problems(frame, panels):
    problems = width_and_request_problems(frame)
    problems += [f"beyond the frame: {text}" for text in frame["beyond"]]
    if frame["first"] != "answer" or frame["people"] == 0:
        problems.append(f"begins with {frame['first']} and {frame['people']} tests")
    if len(frame["panels"]) != panels:
        problems.append(f"has {len(frame['panels'])} panels; expected {panels}")
    for panel in frame["panels"]:
        problems += panel_problems(panel)
    for number, box in enumerate(frame["boxes"]):
        if box["right"] > frame["width"] or box["scrolls"] != "auto":
            problems.append(f"table {number}: {box}")
    return problems


def main():
    options = parse_options(__doc__, ("panels", {"type": int}))
    problems_in = functools.partial(frame_problems, panels=options.panels)
    return run_test(options.report, options.make,
                    functools.partial(open_and_measure, MEASURE, problems_in))


if __name__ == "__main__":
    sys.exit(main())
