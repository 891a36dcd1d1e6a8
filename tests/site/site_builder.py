"""Builds the site for tests."""

import pathlib
import shutil
import subprocess
import sys

SKIPPED = 77  # exit code if Sphinx, MyST or furo is missing
MODULES = ("sphinx", "myst_parser", "furo")


def require_sphinx():
    """Ends a test that cannot run here, in one line."""
    command = shutil.which("sphinx-build")
    if command:  # it may belong to another Python than this one
        python = pathlib.Path(command).read_text(encoding="utf-8").splitlines()[0].removeprefix("#!").split()
        done = subprocess.run([*python, "-c", "import " + ", ".join(MODULES)], capture_output=True)
    if not command or done.returncode:
        print("not run: the packages python3-sphinx, python3-myst-parser and furo are missing")
        sys.exit(SKIPPED)
    return command


def build(docs, folder):
    """Builds the pages of docs into a folder as docs/build.sh does. Returns what Sphinx says if it warns."""
    done = subprocess.run(
        [require_sphinx(), "-E", "-W", "--keep-going", "-n", "-q", "-b", "html", "-d", str(folder / "cache"),
         str(docs), str(folder / "html")], text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    return done.stdout if done.returncode else ""


def copy_for_pages(project, folder):
    """A copy of docs in a folder whose other entries are links to those of the project. Returns the copy."""
    for entry in pathlib.Path(project).iterdir():
        if entry.name not in ("docs", ".git"):
            (folder / entry.name).symlink_to(entry)
    shutil.copytree(project / "docs", folder / "docs", ignore=shutil.ignore_patterns("__pycache__"))
    return folder / "docs"
