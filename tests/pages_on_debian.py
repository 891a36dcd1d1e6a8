#!/usr/bin/env python3
"""Pages on a freshly installed system: with what ./run.sh installs, without the packages, without Python.

pages_on_debian.py PROJECT

tests/on_debian.sh runs this in its root directory, where PROJECT has been built. Each command runs by ./run.sh,
and its page must be whole. Then the program runs where the modules that Debian packages install are hidden, and
where the interpreter is hidden, each in a mount namespace of its own: commands that measure must write their
files and answer in the terminal, others must name the packages in one line. Refuses to run on a whole system,
whose Python could be hidden from other programs.
"""

import html.parser
import os
import pathlib
import sys
import tempfile
from xml.etree import ElementTree

PROJECT = pathlib.Path(sys.argv[1]).resolve()
sys.path.insert(0, str(PROJECT / "tests" / "engine" / "cli"))
import python_pages_test as pages
from python_pages_test import check

PACKAGES = "/usr/lib/python3/dist-packages"  # of Debian
INTERPRETER = os.path.realpath("/usr/bin/python3")
NO_END_TAG = {"br", "col", "hr", "img", "input", "link", "meta"}


class Page(html.parser.HTMLParser):
    """Checks that each element is closed, and collects the figures."""

    def __init__(self, text):
        super().__init__()
        self.open, self.headings = [], 0
        self.feed(text)
        self.close()
        check(not self.open, f"elements are not closed: {self.open}")
        check(text.rstrip().endswith("</html>"), "the page does not end with </html>")
        check(self.headings == 1, f"{self.headings} elements h1; expected one")
        self.figures = [text[at:text.index("</svg>", at) + 6] for at in range(len(text))
                        if text.startswith("<svg", at)]

    def handle_starttag(self, tag, attrs):
        self.headings += tag == "h1"
        if tag not in NO_END_TAG:
            self.open.append(tag)

    def handle_endtag(self, tag):
        check(self.open and self.open.pop() == tag, f"</{tag}> ends another element")


def check_page_is_whole(path):
    page = Page(path.read_text("utf-8"))
    check(page.figures, "the page has no figure")
    for figure in page.figures:
        ElementTree.fromstring(figure)


def is_in_a_root_directory():
    """Whether / is no mount, as after chroot."""
    mounts = pathlib.Path("/proc/self/mountinfo").read_text().splitlines()
    return not any(line.split()[4] == "/" for line in mounts)


def program_without(folder, name, mount):
    """A program that runs Palpate where a part of Python is hidden by a mount."""
    script = folder / name
    script.write_text(f"#!/bin/sh\nexec unshare --mount --propagation unchanged sh -c '{mount} && exec \"$0\" \"$@\"' "
                      f"{PROJECT}/build/release/palpate \"$@\"\n")
    script.chmod(0o700)
    return script


def test_pages_are_whole(commands):
    jobs = {name: (words, page) for name, (words, _, page) in commands.measuring.items()}
    jobs |= {name: (words, "report.html") for name, words in commands.page_only.items()}
    for name, (words, page) in jobs.items():
        out = commands.folder / f"page-{name}"
        done = commands.run(*words, "--out", out)
        check("the page is missing" not in done.stderr, f"{name}: {done.stderr}")
        check((out / page).exists(), f"{name}: no {page}: {done.stderr}")
        try:
            check_page_is_whole(out / page)
        except (pages.Failure, ElementTree.ParseError, ValueError) as fault:
            raise pages.Failure(f"{name}, {page}: {fault}") from fault


def check_without(commands, name, mount, reason):
    whole, commands.program = commands.program, program_without(commands.folder, name, mount)
    try:
        pages.check_page_alone_is_refused(commands, reason)
        pages.check_measured_files_are_there(commands, reason)
    finally:
        commands.program = whole


def test_commands_answer_without_the_packages(commands):
    check_without(commands, "no-packages", f"mount -t tmpfs none {PACKAGES}", "python3 has no package numpy")


def test_commands_answer_without_python(commands):
    check_without(commands, "no-python", f"mount --bind /dev/null {INTERPRETER}", "python3 could not be started")


def main():
    if not is_in_a_root_directory():
        sys.exit("pages_on_debian.py: runs only in the root directory that tests/on_debian.sh makes")
    with tempfile.TemporaryDirectory() as folder:
        commands = pages.Commands(PROJECT / "run.sh", PROJECT / "models", pathlib.Path(folder))
        for test in (test_pages_are_whole, test_commands_answer_without_the_packages,
                     test_commands_answer_without_python):
            try:
                test(commands)
            except pages.Failure as failure:
                print(f"{test.__name__}: {failure}")
                return 1
            print(f"{test.__name__}: passed", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
