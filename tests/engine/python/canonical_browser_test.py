#!/usr/bin/env python3
"""The report of the canonical protocol, in a browser.

canonical_browser_test.py REPORT.html
canonical_browser_test.py --make PROGRAM ARGUMENT...
                                         PROGRAM ARGUMENT... FOLDER writes FOLDER/canonical.html

Opens the page in headless Chromium; its console must stay empty. Then measures the page in frames as
wide as a screen and as a phone: the page is no wider than the frame and requests nothing; the four
diagrams have all their texts, none of which is cut, covers another or is tiny, and a curve for the
rotation by A4; the diagrams of the ratio have the curve tan a as well; each table, two for each measure, has all its
columns within the frame. Exits with 77 if no Chromium is installed.
"""

import functools
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "helpers"))
from browser import open_and_measure, parse_options, run_test, width_and_request_problems

LEAST_TEXT_PX = 10.0  # the height of a line of text
BOTH = ["NoR: the wall stands still", "R: A4 turns the wall",
        "angle a of the wall to the motor (deg)", "45", "90"]
RATIO = BOTH + ["force along the wall / into the hand", "tan a: the motor alone, wall at rest"]
SHARE = BOTH + ["share within 30 deg"]
# The texts and the number of curves of each diagram.
DIAGRAMS = [(RATIO + ["Pressed: simulated operators"], 2),
            (RATIO + ["Stroked: simulated operators"], 2),
            (SHARE + ["Pressed: simulated operators"], 1),
            (SHARE + ["Stroked: simulated operators"], 1)]

MEASURE = """
function measure_frame(frame) {
  const page = frame.contentDocument;
  const diagrams = [...page.querySelectorAll('figure svg')].map(svg => {
    const measured = measure_texts(svg);
    // A curve is an unbroken line across at least half of the diagram, beside its line of the legend;
    // the whiskers of a curve are one path of many lines.
    const curves = [...svg.querySelectorAll('path')].filter(path =>
        path.getAttribute('d').split('L').length > 4 && path.getAttribute('d').split('M').length <= 3 &&
        !path.getAttribute('d').trim().endsWith('z') &&
        path.getBoundingClientRect().width > 0.5 * measured.width).length;
    return {...measured, curves: curves};
  });
  const boxes = [...page.querySelectorAll('.wide')].map(box => ({
      right: box.getBoundingClientRect().right, hidden: box.scrollWidth - box.clientWidth,
      rows: box.querySelectorAll('tbody tr').length}));
  return {width: frame.clientWidth, content: page.documentElement.scrollWidth, diagrams: diagrams,
          requests: requests_of(frame), boxes: boxes, title: page.title};
}
"""


def diagram_problems(diagram, expected, frame_width):
    texts, curves = expected
    found = " | ".join(diagram["texts"])
    problems = [f"has no text \"{text}\": {found}" for text in texts if text not in diagram["texts"]]
    if diagram["width"] < 0.25 * frame_width or diagram["height"] < 0.5 * diagram["width"]:
        problems.append(f"is {diagram['width']} x {diagram['height']}")
    if diagram["least"] < LEAST_TEXT_PX:
        problems.append(f"has a text {diagram['least']} px high")
    if diagram["curves"] != curves:
        problems.append(f"has {diagram['curves']} curves; expected {curves}")
    problems += [f"cut: {text}" for text in diagram["cut"]]
    problems += [f"texts cover each other: {text}" for text in diagram["covering"]]
    return [f"{diagram['name']}: {problem}" for problem in problems]


def frame_problems(frame):
    problems = width_and_request_problems(frame)
    if len(frame["diagrams"]) != len(DIAGRAMS):
        problems.append(f"{len(frame['diagrams'])} diagrams")
    for diagram, expected in zip(frame["diagrams"], DIAGRAMS):
        problems += diagram_problems(diagram, expected, frame["width"])
    if len(frame["boxes"]) != 4:
        problems.append(f"{len(frame['boxes'])} tables")
    for number, box in enumerate(frame["boxes"]):
        if box["right"] > frame["width"] or box["hidden"] > 0 or box["rows"] != 7:
            problems.append(f"table {number}: {box}")
    if "simulated operators" not in frame["title"]:
        problems.append(f"the title is {frame['title']}")
    return problems


def main():
    options = parse_options(__doc__)
    return run_test(options.report, options.make,
                    functools.partial(open_and_measure, MEASURE, frame_problems), "canonical.html")


if __name__ == "__main__":
    sys.exit(main())
