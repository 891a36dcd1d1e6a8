"""Writes SVG pictures as plain text: the same input gives the same bytes."""

import math
import re
from xml.sax.saxutils import escape

FONT = "Helvetica, Arial, sans-serif"
# Mid-tones with a contrast of 4 or more on white and on the dark ground of the site.
INK = "#787878"
BLUE = "#3b82c4"
ORANGE = "#b96a15"
GREEN = "#29894f"
RED = "#d6455d"
FAINT = "#78787826"  # for areas; the last two digits are the opacity
LETTER_WIDTH = 0.52  # mean width of a letter over the font size, for wrapping


class Drawing:
    """Pixels, y down, on a transparent ground, so that it reads on white and on dark pages. A colour is
    "none", "#rrggbb" or, with an opacity, "#rrggbbaa"."""

    def __init__(self, width, height, description):
        self.width = width
        self.height = height
        self.parts = [f"<title>{escape(description)}</title>"]

    def polygon(self, points, fill, stroke="none", width=1.0):
        self.parts.append(f'<polygon points="{joined(points)}" {paint("fill", fill)} '
                          f'{paint("stroke", stroke)} stroke-width="{width:g}" stroke-linejoin="round"/>')

    def line(self, points, colour=INK, width=1.0, dashes=""):
        dashed = f' stroke-dasharray="{dashes}"' if dashes else ""
        self.parts.append(f'<polyline points="{joined(points)}" fill="none" {paint("stroke", colour)} '
                          f'stroke-width="{width:g}" stroke-linecap="round" '
                          f'stroke-linejoin="round"{dashed}/>')

    def arrow(self, start, end, colour=INK, width=2.5, both_ends=False):
        """The tip of the head is at the end."""
        head = 4.0 * width
        length = math.dist(start, end)
        along = ((end[0] - start[0]) / length, (end[1] - start[1]) / length)

        def moved(point, distance):
            return point[0] + distance * along[0], point[1] + distance * along[1]

        def draw_head(tip, direction):
            base = moved(tip, -direction * head)
            half = 0.42 * head
            self.polygon([tip, (base[0] - half * along[1], base[1] + half * along[0]),
                          (base[0] + half * along[1], base[1] - half * along[0])], colour)

        first = moved(start, 0.8 * head) if both_ends else start
        self.line([first, moved(end, -0.8 * head)], colour, width)
        draw_head(end, 1.0)
        if both_ends:
            draw_head(start, -1.0)

    def circle(self, centre, radius, fill, stroke="none", width=1.0):
        self.parts.append(f'<circle cx="{fixed(centre[0])}" cy="{fixed(centre[1])}" '
                          f'r="{radius:g}" {paint("fill", fill)} {paint("stroke", stroke)} '
                          f'stroke-width="{width:g}"/>')

    def rectangle(self, corner, size, fill, stroke="none", radius=0):
        self.parts.append(f'<rect x="{fixed(corner[0])}" y="{fixed(corner[1])}" '
                          f'width="{fixed(size[0])}" height="{fixed(size[1])}" rx="{radius:g}" '
                          f'{paint("fill", fill)} {paint("stroke", stroke)}/>')

    def text(self, at, text, size=14, colour=INK, anchor="start", bold=False):
        weight = ' font-weight="bold"' if bold else ""
        self.parts.append(f'<text x="{fixed(at[0])}" y="{fixed(at[1])}" font-size="{size:g}" '
                          f'{paint("fill", colour)} text-anchor="{anchor}"{weight}>{escape(text)}</text>')

    def paragraph(self, at, text, width, size=14, colour=INK, spacing=1.35):
        """Returns the y below its last line."""
        x, y = at
        for line in wrapped(text, width / (LETTER_WIDTH * size)):
            self.text((x, y), line, size, colour)
            y += spacing * size
        return y

    def svg(self):
        return (f'<svg xmlns="http://www.w3.org/2000/svg" width="{self.width}" '
                f'height="{self.height}" viewBox="0 0 {self.width} {self.height}" '
                f'font-family="{FONT}">\n' + "\n".join(self.parts) + "\n</svg>\n")


def paint(attribute, colour):
    """The attributes of a colour: not all programs read the opacity in it."""
    if len(colour) != 9:
        return f'{attribute}="{colour}"'
    return f'{attribute}="{colour[:7]}" {attribute}-opacity="{int(colour[7:], 16) / 255:.2f}"'


# The colours of gnuplot's pictures: Okabe and Ito's, black, grey and the grids.
MID_TONES = {"0,114,178": BLUE, "213,94,0": ORANGE, "0,158,115": GREEN, "204,121,167": "#ad62a0",
             "230,159,0": "#8f741b", "86,180,233": "#41809e", "0,0,0": INK, "64,64,64": INK}
GRIDS = {"221,221,221", "228,228,228"}


def on_any_ground(text, letters=1.0):
    """A picture of gnuplot, with a transparent ground, mid-tones and larger letters."""
    def recoloured(match):
        attribute, colour = match[1], re.sub(r"\s|rgb|[()]", "", match[2])
        if colour in GRIDS:
            return paint(attribute, INK + "59")
        return f'{attribute}="{INK if colour == "black" else MID_TONES.get(colour, match[2])}"'

    text = re.sub(r'<rect x="0" y="0" [^>]*fill="#ffffff"/>\n', "", text, count=1)
    text = re.sub(r'font-size="([\d.]+)"', lambda m: f'font-size="{letters * float(m[1]):.2f}"', text)
    text = re.sub(r"<title>[^<]*</title>\s*|<desc>[^<]*</desc>\s*", "", text)
    return re.sub(r"""\b(fill|stroke|color)\s*=\s*["'](black|rgb\([^)]*\))["']""", recoloured, text)


def fixed(value):
    return f"{value + 0.0:.1f}".replace("-0.0", "0.0") if abs(value) < 0.05 else f"{value:.1f}"


def joined(points):
    return " ".join(f"{fixed(x)},{fixed(y)}" for x, y in points)


def wrapped(text, letters):
    lines, line = [], ""
    for word in text.split():
        if line and len(line) + 1 + len(word) > letters:
            lines.append(line)
            line = ""
        line += (" " if line else "") + word
    return lines + [line]


def arc(centre, radius, first_rad, last_rad):
    """Points of an arc, with angles counter-clockwise as seen on the picture."""
    return [(centre[0] + radius * math.cos(a), centre[1] - radius * math.sin(a))
            for a in (first_rad + (last_rad - first_rad) * n / 24 for n in range(25))]
