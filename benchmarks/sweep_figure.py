"""Draws a4_helps.svg: which assumption decides whether A4 helps.

For each measure in the condition UaH whose share is not 0 or 1, and for each assumption that the sweep
varies, the share of the hypercube's testable points at which the measure is smaller with A4: in the low and
in the high half of the assumption, or at each of its words. measure_sweep.py writes the data. The texts are
readable at a width of 400 px.
"""

import json
import math

import result_tables as tables
import svg
from result_tables import BadInput

# The measure, and the name of its ranking.
MEASURES = [("contact angle", "mean contact angle, Rotation"),
            ("time", "total time, A4 in UaH"),
            ("losses", "losses of contact, A4 in UaH"),
            ("penetration", "mean penetration, A4 in UaH")]
# Words of each assumption, in the order of the tables.
ASSUMPTIONS = {
    "sight_delay_s": "delay of sight",
    "intention_noise_m": "noise of the aim",
    "force_noise": "noise of the force",
    "press_depth_m": "depth of pressing",
    "hand_stiffness_N_per_m": "stiffness of hand",
    "speed_m_per_s": "speed",
    "stiffness_N_per_m": "stiffness of device",
    "comfortable_depth_m": "slowing depth",
    "following": "following the turn",
    "align": "end of motor line",
    "start_orientation_deg": "start orientation",
    "scale": "size of objects",
}
HALVES = ("low half", "high half")

LOW = "none"
HIGH = svg.BLUE
DECIDES = svg.RED
MUTED = svg.INK
GRID = "#78787859"
RADIUS = 5

WIDTH = 520
MARGIN = 14
TOP = 46
ROW = 24
NAMES = 142  # width of the names
GAP = 24
LINE = 19  # between lines of text
TEXT = 15
LETTER = 0.52 * TEXT  # the mean width of a letter


def read(folder):
    path = folder / "sweep.json"
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise BadInput(f"{path}: expected a result of measure_sweep.py ({error!r})") from error


def percent(share):
    """Shares that are not 1 or 0 are not rounded to them."""
    text = f"{math.floor(100 * share + 0.5)} %"
    if text == "100 %" and share < 1.0:
        return "> 99 %"
    return "< 1 %" if text == "0 %" and share > 0.0 else text


def ranking(data, name):
    return next(row for row in data["rankings"] if row["ranking"] == name)


def parts(data, name, parameter):
    return [row for row in data["halves"] if row["ranking"] == name and row["parameter"] == parameter]


def decisive(row):
    return (row["decisive_parameters"] or "").split()


def drawn(data):
    """The measures with a panel: whose share is neither 0 nor 1."""
    return [(words, name) for words, name in MEASURES
            if 0 < ranking(data, name)["holds"] < ranking(data, name)["points"]]


def answer(data):
    """Lines: where A4 helps."""
    lines = ["With the force of one motor (UaH), A4 makes smaller the"]
    for words, name in MEASURES:
        row = ranking(data, name)
        line = f"- {words} at {row['holds']} of {row['points']} testable points"
        if row["untestable"]:
            line += f" ({row['untestable']} are not)"
        lines.append(line)
    return lines


def draw(data):
    rows, measures = list(ASSUMPTIONS), drawn(data)
    said = answer(data)
    top = TOP + LINE * len(said) + 42
    bottom = top + ROW * len(rows)
    notes = notes_of(data)
    picture = svg.Drawing(WIDTH, bottom + 74 + LINE * len(notes),
                          "Which assumption decides whether A4 helps")
    picture.text((MARGIN, 26), "Which assumption decides whether A4 helps", 19, bold=True)
    for n, line in enumerate(said):
        picture.text((MARGIN, TOP + 4 + LINE * n), line, TEXT)
    for n, parameter in enumerate(rows):
        picture.text((MARGIN, top + ROW * (n + 0.5) + 5), ASSUMPTIONS[parameter], TEXT)
    panel = panel_width(measures)
    for n, measure in enumerate(measures):
        left = MARGIN + NAMES + n * (panel + GAP)
        draw_panel(picture, data, measure, (left, panel, top, bottom), rows)
    draw_legend(picture, bottom + 48)
    for n, note in enumerate(notes):
        picture.text((MARGIN, bottom + 70 + LINE * n), note, TEXT, MUTED)
    return picture.svg()


def panel_width(measures):
    return (WIDTH - 2 * MARGIN - NAMES - (len(measures) - 1) * GAP) / max(1, len(measures))


def draw_panel(picture, data, measure, frame, rows):
    left, panel, top, bottom = frame
    words, name = measure
    of_all = ranking(data, name)

    def x_of(share):
        return left + share * panel

    picture.text((left, top - 10), words, TEXT, bold=True)
    for share in (0.0, 0.5, 1.0):
        picture.line([(x_of(share), top), (x_of(share), bottom)], GRID)
    for share, anchor in ((0.0, "start"), (1.0, "end")):
        picture.text((x_of(share), bottom + 18), f"{100 * share:.0f} %", TEXT, MUTED, anchor)
    picture.rectangle((x_of(of_all["low"]), top),
                      ((of_all["high"] - of_all["low"]) * panel, bottom - top), svg.FAINT)
    picture.line([(x_of(of_all["share"]), top), (x_of(of_all["share"]), bottom)], MUTED, 1, "4 3")
    for n, parameter in enumerate(rows):
        y = top + ROW * (n + 0.5)
        decides = parameter in decisive(of_all)
        colour = DECIDES if decides else HIGH
        of = [row for row in parts(data, name, parameter) if row["share"] is not None]
        shares = [x_of(row["share"]) for row in of]
        if shares:
            first, last = min(shares), max(shares)
            for row, x in zip(of, shares):  # a line ends at the ring of a low half
                if row["part"] == HALVES[0] and last - first > RADIUS:
                    first, last = (first + RADIUS, last) if x == first else (first, last - RADIUS)
            picture.line([(first, y), (last, y)], colour, 3 if decides else 1.5)
        for row, x in zip(of, shares):
            if row["part"] in HALVES:
                picture.circle((x, y), RADIUS, LOW if row["part"] == HALVES[0] else colour, colour, 1.8)
            else:
                picture.rectangle((x - 3, y - 5), (6, 10), colour)


def draw_legend(picture, y):
    x = MARGIN
    for fill, text, colour in ((LOW, "low half", HIGH), (HIGH, "high half", HIGH),
                               ("word", "one word", HIGH), (DECIDES, "decides most (p < 0.05)", DECIDES)):
        if fill == "word":
            picture.rectangle((x + 3, y - 10), (6, 10), colour)
        else:
            picture.circle((x + 6, y - 5), RADIUS, fill, colour, 1.8)
        picture.text((x + 16, y), text, TEXT)
        x += 34 + LETTER * len(text)


def notes_of(data):
    """Lines below the figure."""
    untestable = max(ranking(data, name)["untestable"] for _, name in MEASURES)
    text = ["Dashed: all points, with Wilson's 95 % interval. A coin gives 50 %."]
    if untestable:
        text.append("Not testable: nobody completed the trials there.")
    text.append("Shares are of our ranges of simulated hands, not of people.")
    return text


def decided_by(row):
    if row["p"] is None:
        return "none"
    names = ", ".join(f"`{name}`" for name in decisive(row))
    return (names or "none beyond chance") + f" (p = {row['p']:.2g})"


def share_text(row):
    if row["share"] is None:
        return "-"
    return f"{percent(row['share'])} ({100 * row['low']:.0f} to {percent(row['high'])})"


def parts_lines(data):
    """A list: of each ranking that a parameter decides, the share in each part of this parameter."""
    lines = []
    for row in data["rankings"]:
        for name in decisive(row) if row["p"] is not None else []:
            shares = ", ".join(f"{of['part']} " + ("not testable" if of["share"] is None else
                                                   f"{percent(of['share'])} of {of['points']}")
                               for of in parts(data, row["ranking"], name))
            lines.append(f"- {row['ranking']}, `{name}`: {shares}.")
    return lines


def table(data):
    """Each ranking, where it holds, and what decides most."""
    rows = [(f"{row['ranking']}: {row['order']}",
             [f"{row['holds']} of {row['points']}", share_text(row), str(row["untestable"]),
              decided_by(row)]) for row in data["rankings"]]
    counts = data["counts"]
    lines = parts_lines(data)
    if lines:
        lines = ["Share of the testable points in each part of the parameter that decides most:", "",
                 *lines, ""]
    return tables.markdown(["ranking", "holds at", "share", "not testable", "what decides most"],
                           rows) + "\n\n" + "\n".join(lines) + (
        f"\n{data['points']['hypercube']} points of the hypercube; {counts['trials']} trials in all, "
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
