"""Sphinx builds the site from the Markdown files of this folder: docs/build.sh.

Debian 12 has Sphinx 5.3 with MyST 0.18, Debian 13 has Sphinx 8.1 with MyST 4.0; both must build it.
"""

import pathlib
import re
import shutil
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import site_links  # noqa: E402  (beside this file)

PROJECT = pathlib.Path(__file__).resolve().parent.parent

project = "Palpate"
author = "the authors of Palpate"
release = version = re.search(r"project\(\s*palpate\s+VERSION\s+([\d.]+)",
                              (PROJECT / "CMakeLists.txt").read_text(encoding="utf-8"), re.I)[1]
extensions = ["myst_parser"]
smartquotes = False  # `--option` has two hyphens
highlight_language = "sh"  # a block without a language has command lines

html_theme = "furo"
html_theme_options = {"footer_icons": []}
html_title = f"Palpate {version}"
html_show_copyright = False
html_show_sphinx = False
html_copy_source = False
html_use_index = False
# A page that is opened from a folder may not fetch others: results of a search show titles only.
html_show_search_summary = False
myst_heading_anchors = 4  # a heading of this level or above is the target of a link, named as GitHub does


DEBIAN_SCRIPTS = pathlib.Path("/usr/share/javascript")  # what the path /javascript of a web server stands for


def localise_styles(app, error):
    """Debian's furo imports a style sheet from the root of a web server; a page in a folder has no server."""
    for style in (pathlib.Path(app.outdir) / "_static").rglob("*.css") if not error else ():
        text = style.read_text(encoding="utf-8")
        for name in set(re.findall(r"(?<=[\"'(])/javascript/([^\"')]+)", text)):
            copy = style.parent / pathlib.PurePosixPath(name).name
            shutil.copyfile(DEBIAN_SCRIPTS / name, copy)
            text = text.replace(f"/javascript/{name}", copy.name)
            style.write_text(text, encoding="utf-8")


def setup(app):
    pages = site_links.Pages(PROJECT)

    def read(app, page, source):
        """Puts included texts into a page, and makes its links lead to pages."""
        source[0], included = pages.text_of_page(f"docs/{page}.md", source[0])
        for path in included:
            app.env.note_dependency(str(PROJECT / path))

    app.connect("source-read", read)
    app.connect("build-finished", localise_styles)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
