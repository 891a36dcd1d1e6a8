"""The texts of a page: lines, tables, and a page without its drawings."""

from __future__ import annotations

import re
from html.parser import HTMLParser

_HIDDEN = {"style", "script", "svg"}
_INLINE = {"a", "abbr", "b", "code", "em", "i", "small", "span", "strong", "sub", "sup", "var"}
_VOID = {"br", "col", "hr", "img", "input", "link", "meta"}


class _Texts(HTMLParser):
    """Collects the visible text, and the cells of every table."""

    def __init__(self) -> None:
        super().__init__(convert_charrefs=True)
        self.lines: list[str] = [""]
        self.tables: list[list[list[str]]] = []
        self._hidden = 0
        self._cell = False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag in _HIDDEN or self._hidden:
            self._hidden += tag not in _VOID
        elif tag == "br":
            self._add(" / ") if self._cell else self._end_line()
        elif tag in ("td", "th"):
            self._cell = True
            if not self.lines[-1]:
                self.tables[-1].append([])
            else:
                self.lines[-1] += " | "
            self.tables[-1][-1].append("")
        elif tag not in _INLINE:
            if tag == "table":
                self.tables.append([])
            if not self._cell:
                self._end_line()

    def handle_endtag(self, tag: str) -> None:
        if self._hidden:
            self._hidden -= tag not in _VOID
        elif tag in ("td", "th"):
            self._cell = False
        elif tag not in _INLINE and not self._cell:
            self._end_line()

    def handle_data(self, data: str) -> None:
        if not self._hidden:
            self._add(data)

    def _add(self, text: str) -> None:
        self.lines[-1] += text
        if self._cell:
            self.tables[-1][-1][-1] += text

    def _end_line(self) -> None:
        if self.lines[-1].strip():
            self.lines.append("")
        else:
            self.lines[-1] = ""


def _tidy(text: str) -> str:
    return re.sub(r"\s+", " ", text).strip()


def _parsed(html: str) -> _Texts:
    texts = _Texts()
    texts.feed(html)
    texts.close()
    return texts


def visible_text(html: str) -> list[str]:
    """The lines that a reader sees, without drawings. Cells of a row are separated by " | "."""
    return [line for line in map(_tidy, _parsed(html).lines) if line]


def tables_of(html: str) -> list[list[list[str]]]:
    """The rows of each table, in the order of the page. A line break in a cell is " / "."""
    return [[[_tidy(cell) for cell in row] for row in table] for table in _parsed(html).tables]


def svg_texts(svg: str) -> list[str]:
    """The title and the texts of a drawing."""
    found = re.findall(r"<(title|desc|text)\b[^>]*>(.*?)</\1>", svg, re.S)
    plain = (_tidy(re.sub(r"<[^>]+>", "", text)) for _, text in found)
    return [text for text in plain if text]


def without_drawings(html: str) -> str:
    """A page, or a drawing, whose drawings have their texts only, and which has no style."""

    def texts(drawing: re.Match[str]) -> str:
        label = re.search(r'aria-label="[^"]*"', drawing[1])
        lines = "".join(f"\n<text>{text}</text>" for text in svg_texts(drawing[0]))
        return f"<svg{' ' + label[0] if label else ''}>{lines}\n</svg>"

    html = re.sub(r"<style\b.*?</style>", "<style></style>", html, flags=re.S)
    return re.sub(r"<svg\b([^>]*)>.*?</svg>", texts, html, flags=re.S)
