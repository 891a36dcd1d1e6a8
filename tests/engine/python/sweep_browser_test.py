#!/usr/bin/env python3
"""The report of a sweep, in a browser.

sweep_browser_test.py MODELS_DIR --make PALPATE
sweep_browser_test.py MODELS_DIR REPORT.html

Runs a small sweep with every parameter, or takes a report of one. Opens the page in headless Chromium;
its console must stay empty. Then measures the page in frames as wide as a screen and as a phone: the
page is no wider than the frame and requests nothing; a table wider than the frame scrolls within its own
box; the answer comes first, with each ranking of the paper and the sentence about ranges; there is a
figure for each parameter with the six conditions and all levels, and none of its texts is cut, covers
another or is tiny. Exits with 77 if no Chromium is installed.
"""

import functools
import json
import pathlib
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "helpers"))
from browser import open_and_measure, parse_options, run_test, width_and_request_problems

LEAST_TEXT_PX = 9.0  # the height of a line of text
LEVELS = {"sight_delay_s": [0.1, 0.2], "intention_noise_m": [0.001, 0.002],
          "force_noise": [0, 0.05], "press_depth_m": [0.004, 0.008],
          "hand_stiffness_N_per_m": [200, 400], "speed_m_per_s": [0.03, 0.06],
          "stiffness_N_per_m": [500, 1000], "comfortable_depth_m": [0.005, 0.01],
          "following": ["delayed", "predict", "replan", "frozen"], "align": ["nearest", "forward"],
          "start_orientation_deg": [0, 45], "scale": [0.3, 0.4]}
CONDITIONS = [f"{haptic}, {rotation}" for haptic in ("NoH", "UaH", "H") for rotation in ("NoR", "R")]
MEASURES = ["total time (s)", "losses of contact", "mean penetration (dm)",
            "mean contact angle (deg)"]
SENTENCE = "Shares are of our ranges, not of people"

MEASURE = """
function measure_frame(frame) {
  const page = frame.contentDocument;
  page.querySelectorAll('details').forEach(part => part.open = true);
  const figures = [...page.querySelectorAll('.axes figure')].map(figure => {
    const svg = figure.querySelector('svg');
    if (!svg) return {id: figure.id, texts: [], covering: [], cut: [], least: 0, right: 0};
    return {...measure_texts(svg), id: figure.id};
  });
  const boxes = [...page.querySelectorAll('.wide')].map(box => ({
      right: box.getBoundingClientRect().right, scrolls: getComputedStyle(box).overflowX,
      rows: box.querySelectorAll('tbody tr').length}));
  const answer = page.querySelector('#answer');
  return {width: frame.clientWidth, content: page.documentElement.scrollWidth, requests: requests_of(frame),
          figures: figures, boxes: boxes, first: page.querySelector('main > section').id,
          rankings: answer.querySelectorAll('tbody tr').length, answer: answer.textContent};
}
"""


def figure_problems(figure, levels, width):
    texts = [line for text in figure["texts"] for line in text.split("\n")]
    problems = [f"has no text \"{text}\"" for text in CONDITIONS + MEASURES
                if text not in texts]
    problems += [f"has no level {level}" for level in levels
                 if not any(text.startswith(str(level)) for text in texts)]
    problems += [f"cuts {text}" for text in figure["cut"]]
    problems += [f"has texts that cover each other: {pair}" for pair in figure["covering"]]
    if figure["least"] < 0.5 * LEAST_TEXT_PX:
        problems.append(f"has a text of {figure['least']} px")
    if figure["right"] > width:
        problems.append(f"ends at {figure['right']} px")
    return [f"figure {figure['id']} {problem}" for problem in problems]


def frame_problems(frame):
    problems = width_and_request_problems(frame)
    if frame["first"] != "answer":
        problems.append(f"begins with {frame['first']}")
    if frame["rankings"] != 9:
        problems.append(f"the answer has {frame['rankings']} rankings")
    for text in ("What must be true of the hand", SENTENCE, "H < UaH < NoH", "R < NoR"):
        if text not in frame["answer"]:
            problems.append(f"the answer does not say: {text}")
    for number, box in enumerate(frame["boxes"]):
        if box["right"] > frame["width"] or box["scrolls"] != "auto" or box["rows"] == 0:
            problems.append(f"table {number}: {box}")
    if [figure["id"] for figure in frame["figures"]] != list(LEVELS):
        problems.append(f"figures: {[figure['id'] for figure in frame['figures']]}")
    for figure in frame["figures"]:
        problems += figure_problems(figure, LEVELS.get(figure["id"], []), frame["width"])
    return problems


def small_sweep(models):
    plan = {"palpate_plan": 1, "name": "small", "seed": 7, "participants": 2, "blocks": 1,
            "practice_blocks": 0,
            "device": {"sensors": 2, "actuators": 1, "rate_Hz": 1000, "stiffness_N_per_m": 1000,
                       "damping_Ns_per_m": 2},
            "display_Hz": 40, "sphere_radius_m": 0.006, "limit_s": 30,
            "haptic": ["NoH", "UaH", "H"], "rotation": ["NoR", "R"],
            "objects": {"O1": {"file": str(models / "star.glb")}}, "scale": [0.3],
            "operator": "literature", "followings": ["delayed"]}
    return {"palpate_sweep": 1, "name": "small", "plan": plan, "parameters": LEVELS,
            "hypercube": {"points": 8, "seed": 23, "participants": 1}}


def main():
    options = parse_options(__doc__, ("models", {"type": pathlib.Path}), make={"metavar": "PALPATE"})
    problems_of = functools.partial(open_and_measure, MEASURE, frame_problems)
    if options.report:
        return run_test(options.report, None, problems_of)
    with tempfile.TemporaryDirectory() as name:
        sweep = pathlib.Path(name) / "sweep.json"
        sweep.write_text(json.dumps(small_sweep(options.models.resolve())))
        return run_test(None, [options.make, "experiment", "sweep", str(sweep), "--out"], problems_of)


if __name__ == "__main__":
    sys.exit(main())
