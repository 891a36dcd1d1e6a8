"""Sphinx builds the site from the Markdown files of this folder: docs/build.sh.

Debian 12 has Sphinx 5.3 with MyST 0.18, Debian 13 has Sphinx 8.1 with MyST 4.0; both must build it.
"""

import itertools
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
highlight_language = "text"  # a block without a language has command lines

html_theme = "furo"
html_theme_options = {"footer_icons": []}
html_static_path = ["static"]
html_css_files = ["site.css"]
html_title = f"Palpate {version}"
html_show_copyright = False
html_show_sphinx = False
html_copy_source = False
html_use_index = False
# A page that is opened from a folder may not fetch others: results of a search show titles only.
html_show_search_summary = False
myst_heading_anchors = 4  # a heading of this level or above is the target of a link, named as GitHub does


DEBIAN_SCRIPTS = pathlib.Path("/usr/share/javascript")  # what the path /javascript of a web server stands for


def make_static(app, error):
    """Debian's furo expects a web server: its style sheet imports another one from the root of a server, and
    its script is a module in two files, which no browser loads from a folder. Both become plain files.
    """
    static = pathlib.Path(app.outdir) / "_static"
    if error or not static.is_dir():
        return
    style = static / "styles/furo.css"
    text = style.read_text(encoding="utf-8")
    for name in set(re.findall(r"(?<=[\"'(])/javascript/([^\"')]+)", text)):
        copy = style.parent / pathlib.PurePosixPath(name).name
        shutil.copyfile(DEBIAN_SCRIPTS / name, copy)
        text = text.replace(f"/javascript/{name}", copy.name)
    style.write_text(text, encoding="utf-8")
    script = static / "scripts/furo.js"
    text = script.read_text(encoding="utf-8")
    imported = re.match(r"import [^\n]*\"\./(gumshoe-patched\.js)\";\n", text)
    if imported:
        part = (script.parent / imported[1]).read_text(encoding="utf-8")
        script.write_text(part + "\n" + text[imported.end():], encoding="utf-8")


# A table with at least so many columns, whose longest cells have together more characters, becomes a list on
# a phone (static/site.css).
LIST_COLUMNS, LIST_CHARACTERS = 3, 80


def text_of(cell):
    return " ".join(re.sub(r"<[^>]*>", "", cell).split())


def label_cells(table):
    """A table of HTML whose cells name their column, if it is wide."""
    heads = [text_of(head) for head in re.findall(r"<th\b.*?</th>", table[0], re.S)]
    rows = [re.findall(r"<td\b.*?</td>", row, re.S) for row in table[0].split("<tr")[2:]]
    if len(heads) < LIST_COLUMNS or any(len(row) != len(heads) for row in rows):
        return table[0]
    longest = [max(len(text_of(cell)) for cell in column) for column in zip(*rows)]
    if sum(longest) <= LIST_CHARACTERS:
        return table[0]
    labels = itertools.cycle(heads)
    text = re.sub(r"<td\b", lambda cell: f'{cell[0]} data-label="{next(labels)}"', table[0].replace("<p></p>", ""))
    return text.replace('<table class="', '<table class="wide ', 1)


def mark_commands(block):
    """A block that, if it has command lines, has a class for them, and one for their options."""
    code = re.sub(r"<[^>]*>|#.*\n", "", block[0]).strip()
    if block[1] == "text" and not re.match(r"(\$ )?(\./|palpate |git |cmake )", code):
        return block[0]
    text = re.sub(r"(?<=[>\s\[])--?[a-z][\w-]*", r'<span class="option">\g<0></span>', block[0])
    return text.replace('class="', 'class="commands ', 1)


def finish_body(app, page, template, context, doctree):
    if "body" in context:
        body = re.sub(r'<table class="[^"]*docutils.*?</table>', label_cells, context["body"], flags=re.S)
        body = re.sub(r'<div class="highlight-(sh|text) .*?</pre>', mark_commands, body, flags=re.S)
        context["body"] = re.sub(r'<span class="pre">(?=--?[a-z])', '<span class="pre option">', body)


def setup(app):
    pages = site_links.Pages(PROJECT)

    def read(app, page, source):
        """Puts included texts into a page, and makes its links lead to pages."""
        source[0], included = pages.text_of_page(f"docs/{page}.md", source[0])
        for path in included:
            app.env.note_dependency(str(PROJECT / path))

    app.connect("source-read", read)
    app.connect("html-page-context", finish_body)
    app.connect("build-finished", make_static)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
