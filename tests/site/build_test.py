#!/usr/bin/env python3
"""Sphinx builds the site without a warning, and gives headings the names that GitHub gives them.

usage: build_test.py PROJECT

Builds the pages and one more, which links every heading of every page by the name that named_test.py gives
it, as GitHub does. A name that MyST does not know is a warning. Then breaks a link, an include and a place
in a table of contents: each must give a warning.
"""

import pathlib
import posixpath
import sys
import tempfile

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1]),
                str(pathlib.Path(__file__).resolve().parents[2] / "docs")]
sys.dont_write_bytecode = True
import named_test  # noqa: E402
import site_builder  # noqa: E402
import site_links  # noqa: E402

BROKEN = {
    "[lost](start/run.md#no-such-heading)": "no-such-heading",
    "[lost](start/none.md)": "none.md",
    "[lost](../haptics/none.h)": "none.h",
}


def page_of_headings(project):
    """A page with a link to each heading of the site."""
    pages = site_links.Pages(project)
    lines = ["---", "orphan: true", "---", "", "# All headings", ""]
    for page in sorted(pages.pages):
        text, _ = pages.text_of_page(page, (project / page).read_text(encoding="utf-8"))
        for anchor in named_test.anchors(text):
            lines.append(f"- [{anchor}]({posixpath.relpath(page, 'docs')}#{anchor})")
    return "\n".join(lines) + "\n", len(lines) - 6


def main():
    site_builder.require_sphinx()
    project = pathlib.Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        docs = site_builder.copy_for_pages(project, folder)
        text, count = page_of_headings(project)
        (docs / "all_headings.md").write_text(text, encoding="utf-8")
        said = site_builder.build(docs, folder / "built")
        if said:
            print(said)
            return 1
        broken = "---\norphan: true\n---\n\n# Broken\n\n" + "\n\n".join(BROKEN) + "\n"
        (docs / "all_headings.md").write_text(broken, encoding="utf-8")
        (docs / "in_no_table.md").write_text("# Alone\n", encoding="utf-8")
        said = site_builder.build(docs, folder / "built")
        missed = [link for link, part in BROKEN.items() if part not in said]
        if "in_no_table.md" not in said:
            missed.append("a page in no table of contents")
        for link in missed:
            print(f"Sphinx does not warn of {link}\n{said}")
    print(f"{count} headings have the names that GitHub gives them")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
