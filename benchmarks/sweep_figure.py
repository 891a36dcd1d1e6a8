"""Draws a4_helps.svg: which assumption decides whether A4 helps.

For each measure in the condition UaH, and for each assumption that the sweep varies, the share of the
hypercube's points at which the measure is smaller with A4, in the low and in the high half of the
assumption. measure_sweep.py writes the data.
"""

import json
import math

import result_tables as tables
import svg
from result_tables import BadInput

# The measure, and the name of its ranking.
MEASURES = [("contact angle", "mean contact angle, Rotation"),
            ("time", "total time, A4 in UaH"),
            ("losses of contact", "losses of contact, A4 in UaH"),
            ("penetration", "mean penetration, A4 in UaH")]
# Words, factor and unit of each assumption, in the order of the tables.
ASSUMPTIONS = {
    "sight_delay_s": ("delay of sight", 1e3, "ms"),
    "intention_noise_m": ("noise of the aim", 1e3, "mm"),
    "force_noise": ("noise of the force", 1e2, "%"),
    "press_depth_m": ("depth of pressing", 1e3, "mm"),
    "hand_stiffness_N_per_m": ("stiffness of the hand", 1, "N/m"),
    "speed_m_per_s": ("speed", 1e3, "mm/s"),
    "stiffness_N_per_m": ("stiffness of the device", 1, "N/m"),
    "comfortable_depth_m": ("depth that slows the hand", 1e3, "mm"),
    "following": ("how the turn is followed", None, ""),
    "align": ("end of the motor's line", None, ""),
    "start_orientation_deg": ("start orientation", 1, "deg"),
    "scale": ("size of the objects", 1, ""),
}
WORD_HALVES = {"following": "delayed, predict / replan, frozen", "align": "nearest / forward"}

LOW = "#ffffff"
HIGH = "#1f5fbf"
DECIDES = "#c62828"
MUTED = "#555555"
GRID = "#e1e4e8"

WIDTH = 960
MARGIN = 26
TOP = 150
ROW = 30
NAMES = 226  # width of the names
GAP = 44


def read(folder):
    path = folder / "sweep.json"
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise BadInput(f"{path}: expected a result of measure_sweep.py ({error!r})") from error


def percent(share):
    return f"{100 * share:.0f} %"


def ranking(data, name):
    return next(row for row in data["rankings"] if row["ranking"] == name)


def halves(data, name, parameter):
    return next(row for row in data["halves"]
                if row["ranking"] == name and row["parameter"] == parameter)


def range_text(data, parameter):
    _, factor, unit = ASSUMPTIONS[parameter]
    if factor is None:
        return WORD_HALVES[parameter]
    row = next(row for row in data["ranges"] if row["parameter"] == parameter)
    low, high = (f"{factor * row[end]:.6g}" for end in ("low", "high"))
    return f"{low} to {high} {unit}".strip()


def answer(data):
    """Sentences: where A4 helps, and what decides it."""
    parts = []
    for words, name in MEASURES:
        row = ranking(data, name)
        part = f"the {words} at {percent(row['share'])}"
        if row["decisive_parameters"]:
            names = [ASSUMPTIONS[name][0] for name in row["decisive_parameters"].split()]
            part += f" (most decisive: {' and '.join(names)})"
        parts.append(part)
    return (f"Each of {data['points']['hypercube']} points has other properties of hand, device and scene. "
            "With the force of one motor (UaH), A4 makes these measures smaller: "
            + "; ".join(parts) + ".")


def draw(data):
    rows = list(ASSUMPTIONS)
    bottom = TOP + ROW * len(rows)
    picture = svg.Drawing(WIDTH, math.ceil(bottom + 96), "Which assumption decides whether A4 helps")
    picture.text((MARGIN, 36), "Which assumption decides whether A4 helps", 24, bold=True)
    picture.paragraph((MARGIN, 62), answer(data), WIDTH - 2 * MARGIN)
    panel = (WIDTH - 2 * MARGIN - NAMES - 3 * GAP) / len(MEASURES)
    for n, parameter in enumerate(rows):
        y = TOP + ROW * (n + 0.5)
        picture.text((MARGIN, y - 1), ASSUMPTIONS[parameter][0], 14)
        picture.text((MARGIN, y + 12), range_text(data, parameter), 11, MUTED)
    for n, measure in enumerate(MEASURES):
        left = MARGIN + NAMES + n * (panel + GAP)
        draw_panel(picture, data, measure, (left, panel, bottom), rows)
    draw_legend(picture, bottom + 58)
    return picture.svg()


def draw_panel(picture, data, measure, frame, rows):
    left, panel, bottom = frame
    words, name = measure
    of_all = ranking(data, name)

    def x_of(share):
        return left + share * panel

    picture.text((left, TOP - 14), words, 15, bold=True)
    for share in (0.0, 0.5, 1.0):
        picture.line([(x_of(share), TOP), (x_of(share), bottom)], GRID)
        picture.text((x_of(share), bottom + 18), f"{100 * share:.0f} %", 12, MUTED, "middle")
    picture.rectangle((x_of(of_all["low"]), TOP),
                      ((of_all["high"] - of_all["low"]) * panel, bottom - TOP), "#f0f2f5")
    picture.line([(x_of(of_all["share"]), TOP), (x_of(of_all["share"]), bottom)], MUTED, 1, "4 3")
    for n, parameter in enumerate(rows):
        y = TOP + ROW * (n + 0.5)
        of = halves(data, name, parameter)
        decides = parameter in (of_all["decisive_parameters"] or "").split()
        colour = DECIDES if decides else HIGH
        low, high = x_of(of["low_share"]), x_of(of["high_share"])
        picture.line([(low, y), (high, y)], colour, 3 if decides else 1.5)
        picture.circle((low, y), 5, LOW, colour, 1.8)
        picture.circle((high, y), 5, colour, colour, 1.8)


def draw_legend(picture, y):
    x = MARGIN
    for fill, text, colour in ((LOW, "low half of the range", HIGH),
                               (HIGH, "high half of the range", HIGH),
                               (DECIDES, "the assumption whose halves differ most", DECIDES)):
        picture.circle((x + 6, y - 5), 5, fill, colour, 1.8)
        picture.text((x + 18, y), text, 13)
        x += 34 + 7.1 * len(text)
    picture.line([(MARGIN, y + 17), (MARGIN + 22, y + 17)], MUTED, 1, "4 3")
    picture.text((MARGIN + 30, y + 22), "all points, with Wilson's 95 % interval. Shares are of our "
                 "ranges of simulated hands, not of people.", 13)


def table(data):
    """The table of RESULTS.md: each ranking, where it holds, and what decides most."""
    rows = []
    for row in data["rankings"]:
        decides = "; ".join(
            f"`{name}`: {percent(of['low_share'])} in the low half, {percent(of['high_share'])} in the "
            "high half" for name in (row["decisive_parameters"] or "").split()
            for of in [halves(data, row["ranking"], name)]) or "-"
        rows.append((f"{row['ranking']}: {row['order']}",
                     [f"{percent(row['share'])} ({100 * row['low']:.0f} to {percent(row['high'])})",
                      decides]))
    counts = data["counts"]
    return tables.markdown(["ranking", "holds at", "what decides most"], rows) + (
        f"\n\n{data['points']['hypercube']} points of the hypercube; {counts['trials']} trials in all, "
        f"{counts['trials'] - counts['done']} of which did not end at the red sphere.")


def made(folder, make):
    try:
        return make(read(folder))
    except (KeyError, StopIteration, TypeError) as error:
        raise BadInput(f"{folder}: expected sweep.json of measure_sweep.py ({error!r})") from error


def svg_of(folder):
    return made(folder, draw)


def block(folder):
    return made(folder, table)
