"""The texts of the site's pages: what they include, and where their links lead.

On GitHub a link leads to a file of the project. In the site it must lead to a page. A page is a file
docs/**/*.md, and it may include a text of another folder:

    ```{include} ../../engine/accuracy/README.md
    ```

A link to an included text leads to the page that includes it, from every page. A link to another file of
the project becomes its text, with the path behind it. Links in an included text are relative to its own
folder. Where a page has a title before the include, the included text loses its own title.
"""

import pathlib
import posixpath
import re

FENCE = re.compile(r"^(?P<fence>`{3,}|~{3,})(?P<language>[^\n]*)\n(?P<body>.*?)^(?P=fence)[ \t]*$", re.M | re.S)
INCLUDE = re.compile(r"\{include\}\s+(\S+)")
# What is no link, and a link or picture. A link's text may hold code and one level of brackets.
PIECES = re.compile(
    FENCE.pattern +
    r"|(?P<picture>!?)\[(?P<text>(?:`[^`]*`|[^\[\]`]|\[[^\[\]]*\])*)\]\((?P<target>[^()\s]*)\)"
    r"|(?P<ticks>`+)(?!`).+?(?<!`)(?P=ticks)(?!`)", re.M | re.S)
TITLE = re.compile(r"\A(?:\s|<!--.*?-->)*# [^\n]*\n", re.S)
HOME = "docs/index.md"
WITH_HOME = {"README.md", "docs", "."}  # the site's first page stands for these
EXTERNAL = re.compile(r"[a-z][a-z0-9+.-]*:", re.I)


def includes_of(page, text):
    """The texts that a page includes, as paths from the project's root."""
    found = []
    for block in FENCE.finditer(text):
        match = INCLUDE.match(block["language"].strip())
        if match:
            found.append(posixpath.normpath(posixpath.join(posixpath.dirname(page), match[1])))
    return found


class Pages:
    def __init__(self, project):
        self.project = pathlib.Path(project)
        self.pages = {path.relative_to(self.project).as_posix()
                      for path in sorted((self.project / "docs").rglob("*.md"))}
        self.page_of = {}  # to each included text
        for page in sorted(self.pages):
            for path in includes_of(page, (self.project / page).read_text(encoding="utf-8")):
                if self.page_of.setdefault(path, page) != page:
                    raise ValueError(f"{page} includes {path}, as {self.page_of[path]} does; link it")

    def page_for(self, path):
        """The page that shows a file or folder of the project, or None."""
        if path in self.pages:
            return path
        if path in WITH_HOME:
            return HOME
        for name in (path, posixpath.join(path, "README.md"), posixpath.join(path, "index.md")):
            if name in self.page_of or name in self.pages:
                return self.page_of.get(name, name)
        return None

    def text_of_page(self, page, text):
        """A page with what it includes, with links as the site has them, and the included paths."""
        return self._converted(page, page, text), includes_of(page, text)

    def _converted(self, page, file, text):
        """The text of a file as it stands in a page."""
        has_title = TITLE.match(text)

        def convert(match):
            if match["fence"]:
                include = INCLUDE.match(match["language"].strip())
                return self._included(page, file, include[1], match, has_title) if include else match[0]
            return match[0] if match["ticks"] else self._link(page, file, match)

        return PIECES.sub(convert, text)

    def _included(self, page, file, name, match, has_title):
        if match["body"].strip():
            raise ValueError(f"{file}: an include of this site has no options: {match['body'].strip()}")
        path = posixpath.normpath(posixpath.join(posixpath.dirname(file), name))
        text = (self.project / path).read_text(encoding="utf-8")
        if has_title:
            text = TITLE.sub("", text, count=1)
        return self._converted(page, path, text).strip("\n")

    def _link(self, page, file, match):
        target, _, anchor = match["target"].partition("#")
        if EXTERNAL.match(match["target"]):
            return match[0]
        here = posixpath.dirname(page)
        text = PIECES.sub(lambda inner: inner[0] if not inner["picture"] else
                          self._link(page, file, inner), match["text"])
        path = posixpath.normpath(posixpath.join(posixpath.dirname(file), target)) if target else file
        if match["picture"]:
            shown = " ".join(text.split())  # MyST drops the line breaks of an alternative text
            return f"![{shown}]({posixpath.relpath(path, here or '.')})"
        shown = self.page_for(path) if target else page
        if shown is None:
            if not (self.project / path).exists():
                return match[0]  # Sphinx reports it
            return text if path in text or path.split("/")[-1] in text else f"{text} (`{path}`)"
        place = "" if shown == page else posixpath.relpath(shown, here or ".")
        return f"[{text}]({place}{'#' + anchor if anchor else ''})" if place or anchor else text
