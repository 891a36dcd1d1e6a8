"""Builds the site for tests."""

import pathlib
import shutil
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "helpers"))
from needs import need  # noqa: E402

MODULES = ("sphinx", "myst_parser", "furo")


def require_sphinx():
    """Ends a test that cannot run here, in one line."""
    command = shutil.which("sphinx-build")
    if command:  # it may belong to another Python than this one
        python = pathlib.Path(command).read_text(encoding="utf-8").splitlines()[0].removeprefix("#!").split()
        done = subprocess.run([*python, "-c", "import " + ", ".join(MODULES)], capture_output=True)
    need(command and done.returncode == 0,
         "Sphinx with MyST and furo: apt-get install python3-sphinx python3-myst-parser furo")
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
