"""A figure as a file: an SVG on a transparent ground."""

from __future__ import annotations

import re

from matplotlib.figure import Figure

from palpate.analysis import figures
from palpate.analysis.results.grounds import on_any_ground

WIDTH_PX = 520  # letters of 9 px have 12 px at the width of 700 px of a page


def picture(figure: Figure, title: str) -> str:
    """The document. title: what is shown, for those who do not see it."""
    text = str(figures.svg(figure, "figure", title))
    text = re.sub(r' style="width:\d+px"', "", text, count=1)
    # Letters of a font that every browser has, should DejaVu Sans be missing.
    text = text.replace("'DejaVu Sans'", "'DejaVu Sans', sans-serif")
    return on_any_ground(_smaller(text)) + "\n"


def _smaller(text: str) -> str:
    """The same picture in half of the bytes."""
    text = re.sub(r"<!--.*?-->|(?<=<g) id=\"[^\"]*\"", "", text, flags=re.DOTALL)
    text = re.sub(r"\s*\n\s*", "\n", text)
    text = re.sub(r"<[^>]*>", lambda tag: _LONG.sub(_rounded, str(tag[0])), text)  # texts stay
    return _MARKS.sub(_with_one_style, text)


_LONG = re.compile(r"-?\d+\.\d{3,}")
_MARKS = re.compile(r'<g([^>]*)>\n((?:<use [^>]* style="[^"]*"/>\n)+)</g>')


def _rounded(number: re.Match[str]) -> str:
    """To a hundredth of a pixel."""
    return f"{float(number[0]):.2f}"


def _with_one_style(group: re.Match[str]) -> str:
    """The marks of a series, with the style that all have at their group."""
    styles = set(re.findall(r' style="[^"]*"', group[2]))
    if len(styles) != 1:
        return group[0]
    style = styles.pop()
    return f"<g{group[1]}{style}>\n{group[2].replace(style, '')}</g>"
