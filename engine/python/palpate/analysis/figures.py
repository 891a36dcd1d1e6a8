"""One style of figures, and their SVG.

A figure is a function of a table: it gets a DataFrame and returns a matplotlib `Figure` that
`new_figure()` made. The ink (axes, texts) is `currentColor`, so that a figure is legible on light
and dark ground; data have colours that are told apart by most people with colour-blindness (Okabe and
Ito 2008) and that have contrast on both grounds.
"""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib
from markupsafe import Markup, escape
from matplotlib import rcsetup
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from palpate.analysis.errors import printable

# Okabe and Ito's blue, vermillion, bluish green, orange, purple and sky blue, in the order of use.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#E69F00", "#CC79A7", "#56B4E9")
MARKERS = ("o", "s", "^", "D", "v", "P")  # so that a series is not told by its colour alone
INK = "#0a0b0c"  # becomes currentColor
GRID, GRID_ALPHA = "#808080", 0.3  # a grey that is faint on both grounds

_STYLE = {
    "axes.edgecolor": INK,
    "axes.facecolor": "none",
    "axes.grid": True,
    "axes.labelcolor": INK,
    "axes.labelsize": 10,
    "axes.linewidth": 0.8,
    "axes.prop_cycle": rcsetup.cycler(color=COLOURS),
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlecolor": INK,
    "axes.titlesize": 11,
    "errorbar.capsize": 2.5,
    "figure.constrained_layout.use": True,
    "figure.dpi": 72,
    "figure.facecolor": "none",
    "font.family": ["DejaVu Sans"],
    "font.size": 10,
    "grid.alpha": GRID_ALPHA,
    "grid.color": GRID,
    "grid.linewidth": 0.6,
    "legend.fontsize": 9,
    "legend.frameon": False,
    "lines.linewidth": 1.5,
    "lines.markersize": 5,
    "patch.edgecolor": INK,
    "savefig.facecolor": "none",
    "svg.fonttype": "none",  # text stays text
    "svg.hashsalt": "palpate",  # the same ids in every run
    "text.color": INK,
    "text.parse_math": False,  # a name with $ is a name
    "xtick.color": INK,
    "xtick.labelsize": 9,
    "ytick.color": INK,
    "ytick.labelsize": 9,
}
matplotlib.rcdefaults()  # a matplotlibrc of the user or of the working folder changes nothing
matplotlib.rcParams.update(_STYLE)

PX = 1 / 72  # inches: a pixel of the page


def new_figure(width_px: float = 560, height_px: float = 360, **subplots: Any) -> tuple[Figure, Any]:
    """Return an empty figure and its axes; `subplots` as of Figure.subplots (nrows, sharex...)."""
    figure = Figure(figsize=(width_px * PX, height_px * PX))
    FigureCanvasSVG(figure)
    return figure, figure.subplots(**subplots)


def _raw_svg(figure: Figure) -> str:
    out = io.StringIO()
    figure.savefig(out, format="svg", metadata={"Date": None, "Creator": None})
    text = out.getvalue()
    return text[text.index("<svg"):].replace(INK, "currentColor")


def svg(figure: Figure, name: str, title: str) -> Markup:
    """Return the figure as an element of a page.

    name: letters, digits and hyphens; different for each figure of a page, because ids begin with
    it. title: the accessible name.
    """
    text = _raw_svg(figure)
    text = re.sub(r"<metadata>.*?</metadata>\s*", "", text, flags=re.DOTALL)
    text = text.replace(">*{", ">svg *{")  # its style is for pictures, not for the page
    text = re.sub(r'(\sid="|href="#|url\(#)', rf"\g<1>{name}-", text)
    label = escape(printable(title))
    head, _, rest = text.partition(">")
    size = re.search(r'width="([\d.]+)pt" ', head)
    head = re.sub(r'\s(width|height|version)="[^"]*"', "", head)
    width = f' style="width:{float(size[1]):.0f}px"' if size else ""
    return Markup(f'{head} role="img" aria-label="{label}"{width}>\n<title>{label}</title>\n'
                  f"{rest.strip()}")


_GROUNDS = ("<style>.picture{color-scheme:light dark;color:#1d2329}.ground{fill:#fff}"
            "@media (prefers-color-scheme:dark){.picture{color:#e4e8ec}.ground{fill:#14181d}}</style>")


def size(element: str) -> tuple[float, float]:
    """Width and height of an element that svg() returned, px."""
    box = re.search(r'viewBox="0 0 ([\d.]+) ([\d.]+)"', element)
    assert box is not None
    return float(box[1]), float(box[2])


def placed(element: str, x: float, y: float) -> str:
    """An element that svg() returned, with this upper left corner in a document()."""
    width, height = size(element)
    where = f'<svg x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}"'
    return re.sub(r'^<svg((?: [^>]*?)?) style="[^"]*"', rf"{where}\1", str(element), count=1)


def document(width: float, height: float, title: str, parts: Sequence[str]) -> str:
    """A picture of its own (px), with a light or dark ground as the reader prefers."""
    return (f'<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" '
            f'class="picture" width="{width:g}" height="{height:g}" '
            f'viewBox="0 0 {width:g} {height:g}">\n<title>{escape(printable(title))}</title>\n'
            f'{_GROUNDS}\n<rect class="ground" width="100%" height="100%" fill="#fff"/>\n'
            + "\n".join(parts) + "\n</svg>\n")


def svg_file(figure: Figure, title: str) -> str:
    """Return the figure as a document of its own."""
    element = svg(figure, "figure", title)
    return document(*size(element), title, [placed(element, 0.0, 0.0)])


@dataclass(frozen=True)
class Picture:
    """A figure that a notebook shows. title: the accessible name."""

    figure: Figure
    title: str

    def _repr_svg_(self) -> str:
        return svg_file(self.figure, self.title)
