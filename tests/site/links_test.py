#!/usr/bin/env python3
"""Every link of the built site leads somewhere, and a page asks for nothing elsewhere.

usage: links_test.py PROJECT [FOLDER]

Builds the site, or takes the built one in FOLDER. Each link inside the site must lead to a file of it, and to
an element with the name behind `#`. What a page loads (scripts, style sheets, pictures, fonts, what style
sheets import) must be a file of the site. Links to other sites are allowed in a text, and are printed.
"""

import html.parser
import pathlib
import re
import sys
import tempfile
import urllib.parse

sys.dont_write_bytecode = True
import site_builder  # noqa: E402

LOADS = {"img": ("src", "srcset"), "script": ("src",), "iframe": ("src",), "source": ("src", "srcset"),
         "video": ("src", "poster"), "audio": ("src",), "embed": ("src",), "object": ("data",),
         "use": ("href", "xlink:href"), "image": ("href", "xlink:href")}
LOADED_LINKS = {"stylesheet", "icon", "preload", "prefetch", "modulepreload", "shortcut icon", "manifest"}


class Page(html.parser.HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.ids, self.links, self.loads, self.styles = set(), [], [], []
        self._in_style = False
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        given = dict(attributes)
        self.ids.update(given[name] for name in ("id", "name") if given.get(name) and
                        (name == "id" or tag == "a"))
        if tag == "a" and given.get("href") is not None:
            self.links.append(given["href"])
        if tag == "link" and given.get("href"):
            (self.loads if given.get("rel", "") in LOADED_LINKS else self.links).append(given["href"])
        for name in LOADS.get(tag, ()):
            if given.get(name):
                self.loads += [part.split()[0] for part in given[name].split(",")] if name == "srcset" \
                    else [given[name]]
        if given.get("style"):
            self.styles.append(given["style"])
        self._in_style = tag == "style"

    def handle_data(self, data):
        if self._in_style:
            self.styles.append(data)
            self._in_style = False


def urls_of_style(text):
    found = re.findall(r"url\(\s*['\"]?([^'\")]+)", text) + re.findall(r"@import\s+['\"]([^'\"]+)", text)
    return [url for url in found if not url.startswith(("data:", "#"))]


def check(site):
    """The faults of a built site, and its links to other sites."""
    faults, elsewhere = [], {}
    pages = {path: Page(path.read_text(encoding="utf-8")) for path in sorted(site.rglob("*.html"))}

    def check_file(path, url, kind):
        parts = urllib.parse.urlsplit(url)
        name = path.relative_to(site)
        if parts.scheme == "data":
            return
        if parts.scheme or parts.netloc:
            if kind == "links" and parts.scheme in ("http", "https", "mailto"):
                elsewhere.setdefault(url, name)
            else:
                faults.append(f"{name}: {kind} {url}, which is elsewhere")
            return
        target = path
        if parts.path:
            target = (path.parent / urllib.parse.unquote(parts.path)).resolve()
        if not target.is_file() or not target.is_relative_to(site):
            faults.append(f"{name}: {kind} {url}, which is no file of the site")
        elif parts.fragment and target in pages and \
                urllib.parse.unquote(parts.fragment) not in pages[target].ids:
            faults.append(f"{name}: {kind} {url}, which is no element there")

    for path, page in pages.items():
        for url in page.links:
            if url != "#":
                check_file(path, url, "links")
        for url in page.loads + [url for style in page.styles for url in urls_of_style(style)]:
            check_file(path, url, "loads")
    for path in sorted(site.rglob("*.css")):
        for url in urls_of_style(path.read_text(encoding="utf-8")):
            check_file(path, url, "loads")
    for path in sorted(site.rglob("*.svg")):
        text = path.read_text(encoding="utf-8")
        for url in re.findall(r"(?:xlink:)?href=\"([^\"]+)\"", text) + urls_of_style(text):
            if not url.startswith("#"):
                check_file(path, url, "loads")
    return faults, elsewhere, sum(len(page.links) for page in pages.values()), len(pages)


def check_that_faults_are_found(folder):
    """Ends the test if it would not notice a fault."""
    site = folder / "faulty"
    site.mkdir()
    (site / "a.html").write_text(
        '<link rel="stylesheet" href="https://x.example/a.css"><a href="b.html">b</a><a href="#none">n</a>'
        '<a href="https://x.example/">x</a><img src="http://x.example/a.png"><style>p{background:url(//x/y)}</style>')
    (site / "a.css").write_text('@import "https://x.example/b.css";')
    found = check(site.resolve())[0]
    if len(found) != 6:
        sys.exit("made six faults; found\n" + "\n".join(found))


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name).resolve()
        check_that_faults_are_found(folder)
        if len(sys.argv) > 2:
            site = pathlib.Path(sys.argv[2]).resolve()
        else:
            site_builder.build(pathlib.Path(sys.argv[1]).resolve() / "docs", folder)
            site = folder / "html"
        faults, elsewhere, links, pages = check(site)
    for fault in faults:
        print(fault)
    for url, page in sorted(elsewhere.items()):
        print(f"elsewhere: {url} ({page})")
    print(f"{links} links of {pages} pages, {len(elsewhere)} of them elsewhere, {len(faults)} faults")
    return 1 if faults or pages < 10 else 0


if __name__ == "__main__":
    sys.exit(main())
