"""Draws calm_chart.svg: at which stiffness, delay and rate a contact of a device with motors is calm.

The areas are the zones of a device that states nothing but its delay (a bare tip); the points are the
contacts that `palpate soak --device` has simulated. measure_calm_chart.py writes both tables.
"""

import csv
import math

import svg
from result_tables import BadInput

CASES = "calm_chart.csv"
ZONES = "stiffness_zones.csv"
STABLE = svg.GREEN
CONTROLLED = svg.BLUE
TRIPPED = svg.ORANGE
BROKEN = svg.RED
AREA = "2e"  # opacity of the areas
OUTCOMES = {"stable": ("at rest by itself", STABLE), "calm by the controller": ("at rest by the controller", CONTROLLED),
            "tripped": ("tripped, with the reason", TRIPPED), "refused": ("refused", svg.INK),
            "swings": ("promise broken", BROKEN), "returns energy": ("promise broken", BROKEN)}

LEAST_N_PER_M, MOST_N_PER_M = 100.0, 20000.0
LONGEST_MS = 5.0
WIDTH = 760
MARGIN = 16
LEFT = 74
GAP = 30
TOP = 64
PANEL_HEIGHT = 250
BETWEEN = 62
TEXT = 15
RADIUS = 3.2


def rows_of(path):
    try:
        with path.open(encoding="utf-8", newline="") as file:
            return list(csv.DictReader(file))
    except OSError as error:
        raise BadInput(f"{path}: expected a table of measure_calm_chart.py ({error!r})") from error


def rates(zones):
    return sorted({float(row["rate_Hz"]) for row in zones})


class Panel:
    def __init__(self, column, row):
        self.width = (WIDTH - LEFT - MARGIN - GAP) / 2
        self.left = LEFT + column * (self.width + GAP)
        self.top = TOP + row * (PANEL_HEIGHT + BETWEEN)
        self.bottom = self.top + PANEL_HEIGHT

    def x(self, delay_ms):
        return self.left + self.width * delay_ms / LONGEST_MS

    def y(self, stiffness):
        share = math.log(min(max(stiffness, LEAST_N_PER_M), MOST_N_PER_M) / LEAST_N_PER_M) / \
            math.log(MOST_N_PER_M / LEAST_N_PER_M)
        return self.bottom - PANEL_HEIGHT * share


def draw_zones(picture, panel, zones):
    """Below the stable limit, between it and that of the controller."""
    places = [(panel.x(1e3 * float(row["delay_s"])), panel.y(float(row["stable_N_per_m"])),
               panel.y(float(row["calm_N_per_m"]))) for row in zones]
    stable = [(x, low) for x, low, _ in places]
    calm = [(x, high) for x, _, high in places]
    picture.polygon(stable + [(panel.x(LONGEST_MS), panel.bottom), (panel.left, panel.bottom)], STABLE + AREA)
    picture.polygon(calm + stable[::-1], CONTROLLED + AREA)
    picture.line(stable, STABLE, 2)
    picture.line(calm, CONTROLLED, 2)


def draw_axes(picture, panel, rate_Hz, has_numbers):
    for delay_ms in range(int(LONGEST_MS) + 1):
        x = panel.x(delay_ms)
        picture.line([(x, panel.bottom), (x, panel.bottom + 4)], svg.INK)
        picture.text((x, panel.bottom + 19), str(delay_ms), TEXT, anchor="middle")
    for stiffness in (100, 300, 1000, 3000, 10000):
        y = panel.y(stiffness)
        picture.line([(panel.left - 4, y), (panel.left, y)], svg.INK)
        if has_numbers:
            picture.text((panel.left - 8, y + 5), f"{stiffness:,}", TEXT, anchor="end")
    picture.rectangle((panel.left, panel.top), (panel.width, PANEL_HEIGHT), "none", svg.INK)
    picture.text((panel.left, panel.top - 8), f"{rate_Hz:,.0f} Hz", TEXT + 1, bold=True)


def draw_point(picture, at, outcome):
    colour = OUTCOMES[outcome][1]
    x, y = at
    if outcome == "refused":
        picture.circle(at, 0.7 * RADIUS, "none", colour, 1)
    elif colour == BROKEN:
        picture.line([(x - RADIUS, y - RADIUS), (x + RADIUS, y + RADIUS)], colour, 2.5)
        picture.line([(x - RADIUS, y + RADIUS), (x + RADIUS, y - RADIUS)], colour, 2.5)
    elif outcome == "tripped":
        picture.polygon([(x, y - 1.3 * RADIUS), (x + 1.2 * RADIUS, y + RADIUS), (x - 1.2 * RADIUS, y + RADIUS)],
                        colour)
    else:
        picture.circle(at, RADIUS, colour)


def draw_legend(picture, y, outcomes):
    x = LEFT
    said = set()
    for outcome, (words, _) in OUTCOMES.items():
        if words in said or outcome not in outcomes:
            continue
        said.add(words)
        width = 30 + svg.LETTER_WIDTH * TEXT * len(words)
        if x + width > WIDTH - MARGIN:
            x, y = LEFT, y + 22
        draw_point(picture, (x + 5, y - 5), outcome)
        picture.text((x + 16, y), words, TEXT)
        x += width
    return y


def draw(cases, zones):
    picture = svg.Drawing(WIDTH, 0, "Stiffness, delay and rate at which a contact is calm")
    picture.text((MARGIN, 26), "Where a contact is calm: stiffness (N/m) over delay (ms)", 19, bold=True)
    for n, rate_Hz in enumerate(rates(zones)):
        panel = Panel(n % 2, n // 2)
        draw_zones(picture, panel, [row for row in zones if float(row["rate_Hz"]) == rate_Hz])
        draw_axes(picture, panel, rate_Hz, n % 2 == 0)
        for row in cases:
            if float(row["rate_Hz"]) == rate_Hz and row["states_delay"] == "1":
                draw_point(picture, (panel.x(1e3 * float(row["delay_s"])),
                                     panel.y(float(row["stiffness_N_per_m"]))), row["outcome"])
    y = draw_legend(picture, panel.bottom + 50, {row["outcome"] for row in cases})
    y += 24
    for colour, words in ((STABLE, "Below the green line, the loop comes to rest by itself;"),
                          (CONTROLLED, "up to the blue line, only by the controller; above it, a run is refused.")):
        picture.text((LEFT, y), words, TEXT, colour)
        y += 21
    picture.height = math.ceil(y)
    return picture.svg()


def svg_of(folder):
    try:
        return draw(rows_of(folder / CASES), rows_of(folder / ZONES))
    except (KeyError, ValueError) as error:
        raise BadInput(f"{folder}: expected the tables of measure_calm_chart.py ({error!r})") from error
