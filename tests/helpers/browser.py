"""Opens pages of reports in headless Chromium, for tests."""

import argparse
import html
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

from needs import need

BROWSERS = ["chromium", "chromium-browser", "google-chrome"]
TIMEOUT_S = 120
WIDTHS_PX = [1200, 400]

# measure_texts(svg): the texts of a diagram, those that reach out of it by more than CUT_PX, the pairs
# that cover each other, and the height of the smallest line, px; a text may stand upright.
TEXTS = """
const CUT_PX = 1.0;
function measure_texts(svg) {
  const box = svg.getBoundingClientRect();
  const texts = [...svg.querySelectorAll('text')].filter(text => text.textContent.trim());
  const boxes = texts.map(text => text.getBoundingClientRect());
  const cut = texts.filter((text, i) => {
    const b = boxes[i];
    return b.left < box.left - CUT_PX || b.right > box.right + CUT_PX ||
           b.top < box.top - CUT_PX || b.bottom > box.bottom + CUT_PX;
  });
  const covering = [];
  for (let i = 0; i < boxes.length; ++i) {
    for (let j = 0; j < i; ++j) {
      const across = Math.min(boxes[i].right, boxes[j].right) - Math.max(boxes[i].left, boxes[j].left);
      const down = Math.min(boxes[i].bottom, boxes[j].bottom) - Math.max(boxes[i].top, boxes[j].top);
      if (across > CUT_PX && down > 0.3 * Math.min(boxes[i].height, boxes[j].height)) {
        covering.push(texts[i].textContent.trim() + ' / ' + texts[j].textContent.trim());
      }
    }
  }
  return {width: box.width, height: box.height, right: box.right, name: svg.getAttribute('aria-label'),
          texts: texts.map(text => text.textContent.trim()), cut: cut.map(text => text.textContent),
          covering: covering,
          least: Math.min(...boxes.map((b, i) => texts[i].textContent.trim().length > 2 ?
              Math.min(b.width, b.height) : b.height))};
}
// What the page in a frame has requested.
function requests_of(frame) {
  return frame.contentWindow.performance.getEntriesByType('resource')
      .map(entry => entry.name).filter(name => !name.startsWith('data:'));
}
"""

# measure_frame(frame) is a function of the test.
FRAMES = """
addEventListener('load', () => {
  const measured = [...document.querySelectorAll('iframe')].map(measure_frame);
  document.getElementById('measured').textContent = JSON.stringify(measured);
});
"""


def find_browser():
    return next(filter(None, map(shutil.which, BROWSERS)), None)


def need_browser():
    browser = find_browser()
    need(browser, "Chromium: apt-get install chromium fonts-dejavu-core")
    return browser


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


def check_console_is_heard(browser, folder):
    """Ends the test if it would not notice an error on the console."""
    noisy = folder / "noisy.html"
    noisy.write_text("<!DOCTYPE html><script>console.error('heard')</script>")
    if not open_page(browser, noisy, folder / "profile")[1]:
        sys.exit("an error on the console was not noticed")


def measured_in_frames(browser, page, folder, script):
    """What measure_frame() of the script returns for the page in a frame of each of WIDTHS_PX."""
    frames = "".join(f'<iframe style="width:{width}px;height:900px;border:0" '
                     f'srcdoc="{html.escape(page)}"></iframe>' for width in WIDTHS_PX)
    path = folder / "measure.html"
    path.write_text('<!DOCTYPE html><meta charset="utf-8"><link rel="icon" href="data:,">'
                    f'<script>{TEXTS}{script}{FRAMES}</script>{frames}<pre id="measured"></pre>',
                    encoding="utf-8")
    document, console = open_page(browser, path, folder / "profile")
    found = re.search(r'<pre id="measured">([^<]+)</pre>', document)
    if not found:
        sys.exit("the page was not measured\n" + "\n".join(console))
    return json.loads(html.unescape(found.group(1)))


def width_and_request_problems(frame):
    """frame: with the members width, content (the width of the page) and requests."""
    wide = [f"the page is {frame['content']} px wide"] if frame["content"] > frame["width"] else []
    return wide + [f"requests {name}" for name in frame["requests"]]


def open_and_measure(script, frame_problems, browser, page, folder):
    """What is wrong with the page: the lines on its console, and frame_problems() of each frame."""
    path = folder / "page.html"
    path.write_text(page, encoding="utf-8")
    _, console = open_page(browser, path, folder / "profile")
    problems = [f"on the console: {line}" for line in console]
    for frame in measured_in_frames(browser, page, folder, script):
        problems += [f"{frame['width']} px: {problem}" for problem in frame_problems(frame)]
    return problems


def parse_options(text, *arguments, make={"nargs": argparse.REMAINDER, "metavar": "PROGRAM"}):
    """The options of a test: the arguments, and either a report or a program that makes one. text: the
    documentation of the test; arguments: (name, options of add_argument())."""
    parser = argparse.ArgumentParser(description=text.splitlines()[0])
    for name, how in arguments:
        parser.add_argument(name, **how)
    parser.add_argument("report", nargs="?", type=pathlib.Path)
    parser.add_argument("--make", **make)
    options = parser.parse_args()
    if (options.report is None) == (options.make is None):
        parser.error("either a report or a program that makes one")
    return options


def run_test(report, make, problems_of, name="report.html"):
    """The exit code of a test. report: a page, or None; make: a command, to which a folder is added, that
    writes the page of this name there. problems_of(browser, page, folder): lines."""
    browser = need_browser()
    with tempfile.TemporaryDirectory() as folder_name:
        folder = pathlib.Path(folder_name)
        if make:
            subprocess.run(make + [folder_name], check=True, timeout=TIMEOUT_S)
        page = (report or folder / name).read_text(encoding="utf-8")
        check_console_is_heard(browser, folder)
        problems = problems_of(browser, page, folder)
    print("\n".join(problems) if problems else "opened without an error")
    return 1 if problems else 0
