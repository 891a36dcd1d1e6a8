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

import argparse
import html
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

SKIPPED = 77
BROWSERS = ["chromium", "chromium-browser", "google-chrome"]
TIMEOUT_S = 120
WIDTHS_PX = [1200, 400]
CUT_PX = 1.0  # how far the box of a text may reach out of its diagram

# For every frame: [width, width of the content, diagrams as [width, height, texts that are cut], verdicts
# that reach beyond the frame, whether the advice is first and the facts are last].
MEASURE = """
addEventListener('load', () => {
  const measured = [...document.querySelectorAll('iframe')].map(frame => {
    const page = frame.contentDocument;
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
    return [frame.clientWidth, page.documentElement.scrollWidth, diagrams, beyond, inOrder];
  });
  document.getElementById('measured').textContent = JSON.stringify(measured);
});
"""


def open_page(browser, path, profile):
    """The document after loading, and the lines on its console."""
    command = [browser, "--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr",
               "--v=0", "--virtual-time-budget=10000", "--window-size=1300,1000",
               f"--user-data-dir={profile}", "--dump-dom", path.resolve().as_uri()]
    done = subprocess.run(command, capture_output=True, text=True, encoding="utf-8",
                          timeout=TIMEOUT_S)
    if done.returncode != 0:
        sys.exit(f"{browser} ended with {done.returncode}\n{done.stderr}")
    return done.stdout, [line for line in done.stderr.splitlines() if "CONSOLE" in line]


def measured(browser, page, folder):
    frames = "".join(f'<iframe style="width:{width}px;height:900px;border:0" '
                     f'srcdoc="{html.escape(page)}"></iframe>' for width in WIDTHS_PX)
    path = folder / "measure.html"
    path.write_text('<!DOCTYPE html><meta charset="utf-8"><link rel="icon" href="data:,">'
                    f'<script>{MEASURE.replace("CUT", str(CUT_PX))}</script>{frames}'
                    '<pre id="measured"></pre>', encoding="utf-8")
    document, console = open_page(browser, path, folder / "profile")
    found = re.search(r'<pre id="measured">([^<]+)</pre>', document)
    if not found:
        sys.exit("the page was not measured\n" + "\n".join(console))
    return json.loads(html.unescape(found.group(1)))


def problems_of(browser, page, folder):
    path = folder / "page.html"
    path.write_text(page, encoding="utf-8")
    document, console = open_page(browser, path, folder / "profile")
    problems = [f"on the console: {line}" for line in console]
    expected = len(re.findall(r'<figure class="work-precision"', document))
    if expected == 0:
        problems.append("no diagram on the page")
    for width, content_width, diagrams, beyond, in_order in measured(browser, page, folder):
        if len(diagrams) != 2 * expected:
            problems.append(f"{width} px: {len(diagrams)} diagrams, {expected} pairs expected")
        if content_width > width:
            problems.append(f"{width} px: the page is {content_width} px wide")
        problems += [f"{width} px: beyond the frame: {text}" for text in beyond]
        if not in_order:
            problems.append(f"{width} px: the advice is not first, or the facts are not last")
        for i, (diagram_width, height, cut) in enumerate(diagrams):
            if diagram_width < 0.25 * width or height < 0.25 * diagram_width:
                problems.append(f"{width} px: diagram {i} is {diagram_width} x {height}")
            problems += [f"{width} px: diagram {i}: cut: {text}" for text in cut]
    return problems


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("report", nargs="?", type=pathlib.Path)
    parser.add_argument("--make", nargs=argparse.REMAINDER, metavar="PROGRAM")
    options = parser.parse_args()
    if (options.report is None) == (options.make is None):
        parser.error("either a report or a program that makes one")
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        print("skipped: no Chromium is installed")
        return SKIPPED
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        if options.make:
            subprocess.run(options.make + [name], check=True, timeout=TIMEOUT_S)
        page = (options.report or folder / "report.html").read_text(encoding="utf-8")
        # The test notices an error on the console.
        noisy = folder / "noisy.html"
        noisy.write_text("<!DOCTYPE html><script>console.error('heard')</script>")
        if not open_page(browser, noisy, folder / "profile")[1]:
            sys.exit("an error on the console was not noticed")
        problems = problems_of(browser, page, folder)
    print("\n".join(problems) if problems else "opened without an error")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
