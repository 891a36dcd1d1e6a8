"""Colours of a picture in a file, which does not know whether its page is white or dark.

Needs no library, so that scripts can use it without the packages of the figures.
"""

from __future__ import annotations

import re

INK = "#787878"
# Okabe and Ito's colours, and tones of them with a contrast of 4 or more on white and on the dark
# ground of the site.
TONES = {"#0072b2": "#3b82c4", "#d55e00": "#b96a15", "#009e73": "#29894f", "#e69f00": "#8f741b",
         "#cc79a7": "#ad62a0", "#56b4e9": "#41809e", "currentcolor": INK}
_COLOUR = re.compile("|".join(map(re.escape, TONES)), re.IGNORECASE)


_SHEER = re.compile(r'(fill|stroke)="(#[0-9a-f]{6})([0-9a-f]{2})"', re.IGNORECASE)


def on_any_ground(svg: str, letters: float = 1.0) -> str:
    """The picture without a ground of its own, in tones that read on white and on dark pages.

    svg: of matplotlib, or of the program. letters: by which the letters of the program become
    larger, for a picture that a page shows smaller.
    """
    svg = re.sub(r"<style>.*?</style>\s*", "", svg, flags=re.DOTALL)
    svg = re.sub(r'<rect class="[^"]*ground"[^>]*/>\s*| color="#1d2329"', "", svg)
    svg = _SHEER.sub(lambda m: f'{m[1]}="{m[2]}" {m[1]}-opacity="{int(m[3], 16) / 255:.2f}"', svg)
    svg = re.sub(r'font-size="([\d.]+)"', lambda m: f'font-size="{letters * float(m[1]):.2f}"', svg)
    return _COLOUR.sub(lambda match: TONES[match[0].lower()], svg)
