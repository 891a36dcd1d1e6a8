#!/usr/bin/env python3
"""Pages of the site, opened from a folder in headless Chromium.

usage: browser_test.py PROJECT [FOLDER]

Builds the site, or takes the built one in FOLDER. Opens every page in a frame as wide as a phone, and
the pages of PAGES also as wide as a screen, with light and dark colours. The console must stay empty, and nothing may be
requested elsewhere. A page is not wider than its frame, and its text has a contrast of at least
LEAST_CONTRAST. The search finds pages with the word "god-object". Is not run if Chromium or Sphinx is
missing.
"""

import html
import json
import pathlib
import re
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "helpers"))
import browser  # noqa: E402
import site_builder  # noqa: E402

PAGES = ("index", "concepts/a4", "reference/settings", "inside/index")
FRAMES = 16  # in one start of the browser
TIMEOUT_S = 400  # of one start, on a busy machine
THEMES = ("light", "dark")
LEAST_CONTRAST = 4.5
SEARCHED = "god-object"

MEASURE = """
function brightness(colour) {
  const [r, g, b] = colour.match(/[0-9.]+/g).map(Number).map(
      c => c / 255 <= 0.04045 ? c / 255 / 12.92 : ((c / 255 + 0.055) / 1.055) ** 2.4);
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
}
function measure(frame) {
  const page = frame.contentDocument, theme = frame.dataset.theme;
  page.body.dataset.theme = theme;
  const style = frame.contentWindow.getComputedStyle(page.body);
  const text = page.querySelector('article p, article li, article td') || page.body;
  const [a, b] = [brightness(style.backgroundColor), brightness(frame.contentWindow.getComputedStyle(text).color)];
  const wide = [...page.querySelectorAll('article img, article svg')].filter(
      picture => picture.getBoundingClientRect().right > frame.clientWidth + 1).map(picture => picture.src || 'svg');
  return {page: frame.dataset.page, theme: theme, width: frame.clientWidth, content: page.documentElement.scrollWidth,
          body: page.body.scrollWidth, contrast: (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05), dark: a < 0.2,
          wide: wide, requests: frame.contentWindow.performance.getEntriesByType('resource').map(e => e.name)};
}
addEventListener('load', () => setTimeout(() => {
  document.getElementById('measured').textContent =
      JSON.stringify([...document.querySelectorAll('iframe')].map(measure));
}, 500));
"""


def opened(chromium, url, profile):
    """The document behind an address after loading, and the lines on its console."""
    done = subprocess.run(
        [chromium, "--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr", "--v=0",
         "--virtual-time-budget=20000", "--window-size=1300,1000", "--allow-file-access-from-files",
         f"--user-data-dir={profile}", "--dump-dom", url],
        capture_output=True, text=True, encoding="utf-8", timeout=TIMEOUT_S)
    if done.returncode:
        sys.exit(f"{chromium} ended with {done.returncode}\n{done.stderr}")
    return done.stdout, [line for line in done.stderr.splitlines() if "CONSOLE" in line]


def frames_of(site):
    pages = sorted(path.relative_to(site).with_suffix("").as_posix() for path in site.rglob("*.html"))
    if not set(PAGES) < set(pages):
        sys.exit(f"the site has no page {', '.join(set(PAGES) - set(pages))}")
    return [f'<iframe src="{(site / page).with_suffix(".html").as_uri()}" data-page="{page}" data-theme="{theme}" '
            f'style="width:{width}px;height:900px;border:0"></iframe>'
            for page in pages for theme in (THEMES if page in PAGES else THEMES[:1])
            for width in (browser.WIDTHS_PX if page in PAGES else browser.WIDTHS_PX[-1:])]


def measured(chromium, frames, folder):
    path = folder / "measure.html"
    path.write_text('<!DOCTYPE html><meta charset="utf-8"><link rel="icon" href="data:,">'
                    f'<script>{MEASURE}</script>{"".join(frames)}<pre id="measured"></pre>', encoding="utf-8")
    document, console = opened(chromium, path.as_uri(), folder / "profile")
    found = re.search(r'<pre id="measured">([^<]+)</pre>', document)
    if not found:
        sys.exit("the pages were not measured\n" + "\n".join(console))
    return json.loads(html.unescape(found[1])), console


def problems_of(chromium, site, folder):
    frames, console, all_frames = [], [], frames_of(site)
    for first in range(0, len(all_frames), FRAMES):
        some, lines = measured(chromium, all_frames[first:first + FRAMES], folder)
        frames += some
        console += lines
    problems = [f"on the console: {line}" for line in console]
    for frame in frames:
        where = f"{frame['page']}, {frame['theme']}, {frame['width']} px"
        if max(frame["content"], frame["body"]) > frame["width"]:
            problems.append(f"{where}: the page is {max(frame['content'], frame['body'])} px wide")
        if frame["contrast"] < LEAST_CONTRAST or frame["dark"] != (frame["theme"] == "dark"):
            problems.append(f"{where}: the contrast is {frame['contrast']:.1f}, the ground "
                            f"{'dark' if frame['dark'] else 'light'}")
        problems += [f"{where}: beyond the frame: {name}" for name in frame["wide"]]
        problems += [f"{where}: requests {name}" for name in frame["requests"]
                     if not name.startswith((site.as_uri(), "data:"))]
    document, console = opened(chromium, (site / "search.html").as_uri() + f"?q={SEARCHED}", folder / "profile")
    problems += [f"on the console of the search: {line}" for line in console]
    results = re.findall(r'<li[^>]*><a href="([^"]+)"', document.partition('id="search-results"')[2])
    if not results:
        problems.append(f"the search does not find {SEARCHED}")
    print(f"{len(frames)} frames; the search finds {len(results)} places with {SEARCHED}")
    return problems


def main():
    chromium = browser.need_browser()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name).resolve()
        browser.check_console_is_heard(chromium, folder)
        if len(sys.argv) > 2:
            site = pathlib.Path(sys.argv[2]).resolve()
        else:
            site_builder.build(pathlib.Path(sys.argv[1]).resolve() / "docs", folder)
            site = folder / "html"
        problems = problems_of(chromium, site, folder)
    print("\n".join(problems) if problems else "opened without an error")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
