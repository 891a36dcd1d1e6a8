"""Writes SVG pictures as plain text: the same input gives the same bytes."""

import math
from xml.sax.saxutils import escape

FONT = "Helvetica, Arial, sans-serif"
INK = "#222222"
LETTER_WIDTH = 0.52  # mean width of a letter over the font size, for wrapping


class Drawing:
    """Pixels, y down, on a white background, so that it reads on dark pages as well."""

    def __init__(self, width, height, description):
        self.width = width
        self.height = height
        self.parts = [f"<title>{escape(description)}</title>",
                      f'<rect width="{width}" height="{height}" fill="#ffffff"/>']

    def polygon(self, points, fill, stroke="none", width=1.0):
        self.parts.append(f'<polygon points="{joined(points)}" fill="{fill}" stroke="{stroke}" '
                          f'stroke-width="{width:g}" stroke-linejoin="round"/>')

    def line(self, points, colour=INK, width=1.0, dashes=""):
        dashed = f' stroke-dasharray="{dashes}"' if dashes else ""
        self.parts.append(f'<polyline points="{joined(points)}" fill="none" stroke="{colour}" '
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
                          f'r="{radius:g}" fill="{fill}" stroke="{stroke}" '
                          f'stroke-width="{width:g}"/>')

    def rectangle(self, corner, size, fill, stroke="none", radius=0):
        self.parts.append(f'<rect x="{fixed(corner[0])}" y="{fixed(corner[1])}" '
                          f'width="{fixed(size[0])}" height="{fixed(size[1])}" rx="{radius:g}" '
                          f'fill="{fill}" stroke="{stroke}"/>')

    def text(self, at, text, size=14, colour=INK, anchor="start", bold=False):
        weight = ' font-weight="bold"' if bold else ""
        self.parts.append(f'<text x="{fixed(at[0])}" y="{fixed(at[1])}" font-size="{size:g}" '
                          f'fill="{colour}" text-anchor="{anchor}"{weight}>{escape(text)}</text>')

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
