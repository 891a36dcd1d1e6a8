#!/usr/bin/env python3
"""The report of what accuracy costs, in a browser.

report_browser_test.py REPORT.html
report_browser_test.py --make PROGRAM ARGUMENT...
                                         PROGRAM ARGUMENT... FOLDER writes FOLDER/report.html

Opens the page in headless Chromium; its console must stay empty. Then measures the page in frames as
wide as a screen and as a phone: every diagram has a size and no text is cut, the page and the columns
with verdicts are no wider than the frame, the advice comes first and the build facts come last. Exits
with 77 if no Chromium is installed.
"""

import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "helpers"))
from browser import measured_in_frames, open_page, parse_options, run_test

CUT_PX = 1.0  # how far the box of a text may reach out of its diagram

# For every frame: [width, width of the content, diagrams as [width, height, texts that are cut], verdicts
# that reach beyond the frame, whether the advice is first and the facts are last, whether all chapters were
# folded].
MEASURE = """
function measure_frame(frame) {
  const page = frame.contentDocument;
  const isFolded = [...page.querySelectorAll('details')].every(part => !part.open);
  page.querySelectorAll('details').forEach(part => { part.open = true; });
  const diagrams = [...page.querySelectorAll('.work-precision svg')].map(svg => {
    const box = svg.getBoundingClientRect();
    const cut = [...svg.querySelectorAll('text')].filter(text => {
      const b = text.getBoundingClientRect();
      return b.left < box.left - CUT || b.right > box.right + CUT ||
             b.top < box.top - CUT || b.bottom > box.bottom + CUT;
    });
    return [box.width, box.height, cut.map(text => text.textContent)];
  });
  const beyond = [...page.querySelectorAll('.verdict')].filter(
      cell => cell.getBoundingClientRect().right > frame.clientWidth).map(cell => cell.textContent);
  const sections = [...page.querySelectorAll('main > section')];
  const inOrder = sections[0].id === 'advice' && sections.at(-1).id === 'facts';
  return [frame.clientWidth, page.documentElement.scrollWidth, diagrams, beyond, inOrder, isFolded];
}
"""


def problems_of(browser, page, folder):
    path = folder / "page.html"
    path.write_text(page, encoding="utf-8")
    document, console = open_page(browser, path, folder / "profile")
    problems = [f"on the console: {line}" for line in console]
    expected = len(re.findall(r'<figure class="work-precision"', document))
    if expected == 0:
        problems.append("no diagram on the page")
    for width, content_width, diagrams, beyond, in_order, is_folded in measured_in_frames(
            browser, page, folder, MEASURE.replace("CUT", str(CUT_PX))):
        if len(diagrams) != 2 * expected:
            problems.append(f"{width} px: {len(diagrams)} diagrams, {expected} pairs expected")
        if content_width > width:
            problems.append(f"{width} px: the page is {content_width} px wide")
        problems += [f"{width} px: beyond the frame: {text}" for text in beyond]
        if not is_folded:
            problems.append(f"{width} px: a chapter is open before a reader opens it")
        if not in_order:
            problems.append(f"{width} px: the advice is not first, or the facts are not last")
        for i, (diagram_width, height, cut) in enumerate(diagrams):
            if diagram_width < 0.25 * width or height < 0.25 * diagram_width:
                problems.append(f"{width} px: diagram {i} is {diagram_width} x {height}")
            problems += [f"{width} px: diagram {i}: cut: {text}" for text in cut]
    return problems


def main():
    options = parse_options(__doc__)
    return run_test(options.report, options.make, problems_of)


if __name__ == "__main__":
    sys.exit(main())
