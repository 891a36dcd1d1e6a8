#!/usr/bin/env python3
"""The report of an experiment, in a browser.

experiment_browser_test.py people|simulated --make PROGRAM ARGUMENT...
                                         PROGRAM ARGUMENT... FOLDER writes FOLDER/report.html
experiment_browser_test.py people|simulated REPORT.html

Opens the page in headless Chromium; its console must stay empty. Then measures the page in frames as
wide as a screen and as a phone, with all parts unfolded: the page is no wider than the frame and
requests nothing; Figures 6 and 7 have all their texts, none of which is cut, covers another or is
tiny; the verdicts of the leading following are within the frame; the answer comes first. Simulated
operators are named in the title and in each figure, and the report of people does not name them.
Exits with 77 if no Chromium is installed.
"""

import functools
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "helpers"))
from browser import (measured_in_frames, open_and_measure, parse_options, run_test,
                     width_and_request_problems)

LEAST_TEXT_PX = 10.0  # the height of a line of text; that of a letter is about two thirds
FIGURE_6 = ["NoR: the scene stands still", "R: the scene turns",
            "the paper's people, mean of NoR and R", "NoH", "UaH", "H", "commanded force (Haptic)"]
# The texts of each panel.
PANELS = [FIGURE_6 + ["total time (s)"], FIGURE_6 + ["mean penetration (dm)"],
          ["NoR", "R", "the paper's people, standard deviation", "mean contact angle (deg)",
           "rotation of the scene"]]
WHO = {"people": ["people"], "simulated": ["delayed", "predict", "replan", "frozen"]}

MEASURE = """
function measure_frame(frame) {
  const page = frame.contentDocument;
  page.querySelectorAll('details').forEach(part => part.open = true);
  const diagrams = [...page.querySelectorAll('.figure6 svg, .figure7 svg')].map(measure_texts);
  const leading = [...page.querySelectorAll('.findings tr')].map(row => row.children[1]);
  return {width: frame.clientWidth, content: page.documentElement.scrollWidth, diagrams: diagrams,
          beyond: leading.filter(cell => cell.className == 'found' &&
              cell.getBoundingClientRect().right > frame.clientWidth).map(cell => cell.textContent),
          verdicts: leading.filter(cell => cell.className == 'found').length,
          requests: requests_of(frame), title: page.title,
          first: page.querySelector('main > section').id, text: page.body.textContent,
          figures: [...page.querySelectorAll('figcaption')].map(text => text.textContent)};
}
"""


def diagram_problems(diagram, i, who, frame_width):
    texts = " | ".join(diagram["texts"])
    problems = [f"has no text \"{text}\": {texts}" for text in PANELS[i % len(PANELS)]
                if not any(text == found or text in found.split("\n") for found in diagram["texts"])]
    if not any(who in text for text in diagram["texts"]):
        problems.append(f"does not say {who}: {texts}")
    if diagram["width"] < 0.25 * frame_width or diagram["height"] < 0.5 * diagram["width"]:
        problems.append(f"is {diagram['width']} x {diagram['height']}")
    if diagram["least"] < LEAST_TEXT_PX:
        problems.append(f"has a text {diagram['least']} px high")
    problems += [f"cut: {text}" for text in diagram["cut"]]
    problems += [f"texts cover each other: {text}" for text in diagram["covering"]]
    return [f"{diagram['name']}: {problem}" for problem in problems]


def frame_problems(frame, kind):
    problems = width_and_request_problems(frame)
    names = WHO[kind]
    problems += [f"beyond the frame: {text}" for text in frame["beyond"]]
    if frame["verdicts"] < 17:
        problems.append(f"{frame['verdicts']} verdicts of the leading following")
    if frame["first"] != "answer":
        problems.append(f"begins with {frame['first']}")
    if len(frame["diagrams"]) != len(PANELS) * len(names):
        problems.append(f"{len(frame['diagrams'])} diagrams")
    for i, diagram in enumerate(frame["diagrams"]):
        who = names[i // len(PANELS)] if i // len(PANELS) < len(names) else "nobody"
        if kind == "simulated":
            who = "simulated operators, " + who
        problems += diagram_problems(diagram, i, who, frame["width"])
    simulated = ["simulated operators" in text for text in [frame["title"]] + frame["figures"]]
    if kind == "simulated" and not all(simulated):
        problems.append("a title or caption does not say simulated operators")
    if kind == "people" and "imulated" in frame["title"] + frame["text"]:
        problems.append("people are called simulated")
    return problems


def check_requests_are_noticed(browser, folder):
    """Ends the test if it would not notice a request."""
    frames = measured_in_frames(browser, '<!DOCTYPE html><main><section id="answer"></section></main>'
                                '<img src="http://127.0.0.1:9/picture.png">',
                                folder, MEASURE)
    if not all(frame["requests"] for frame in frames):
        sys.exit("a request was not noticed")


def problems_of(kind, browser, page, folder):
    check_requests_are_noticed(browser, folder)
    problems_in = functools.partial(frame_problems, kind=kind)
    return open_and_measure(MEASURE, problems_in, browser, page, folder)


def main():
    options = parse_options(__doc__, ("kind", {"choices": sorted(WHO)}))
    return run_test(options.report, options.make,
                    functools.partial(problems_of, options.kind))


if __name__ == "__main__":
    sys.exit(main())
