"""Sphinx builds the site from the Markdown files of this folder: docs/build.sh."""

project = "Palpate"
author = "the authors of Palpate"
extensions = ["myst_parser"]
html_theme = "furo"
html_title = "Palpate"
html_show_copyright = False
html_copy_source = False
# A page that is opened from a folder may not fetch others: results of a search show titles only.
html_show_search_summary = False
myst_heading_anchors = 4  # a heading of this level or above is the target of a link, named as GitHub does
