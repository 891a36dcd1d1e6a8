"""Draws a4.svg: one wall of the star while A4 turns it towards the motor.

measure_objects.py takes the instants from a trace of `palpate run` (instants_of) and keeps them in
a4.json, from which the picture is drawn (draw). Lengths in metres, angles in degrees.
"""

import csv
import json
import math

import svg

START_ABOVE_DEG = 45.0
LATER_BELOW_DEG = [45.0, 20.0, 3.0]  # the later instants: the first tick at or below each angle
SAME_NORMAL = 1e-9
ACTUATED_AXIS = (1.0, 0.0)  # A1, the only motor of the device with two sensors

MOTOR = svg.BLUE
WALL = svg.RED
MUTED = svg.INK
TURN = svg.INK

WIDTH = 960
MARGIN = 22
GAP = 12
LEGEND_Y = 148
PANELS_TOP = 168
TEXT = 19
HEADER = 30
ARROW_PX = 80
NORMAL_PX = 70
ANGLE_PX = 34
LEGEND_X = [0, 197, 374, 558, 692]
LEFT_OF_CONTACT_M = 0.092  # so that the arrows do not leave the panel


# Extraction

def walls(rows):
    """Runs of ticks in contact with one wall: lists of rows with one scene-frame normal."""
    run = []
    for row in rows:
        in_contact = row["contact"] == "1"
        if run and not (in_contact and math.dist(normal_of(row), normal_of(run[0])) < SAME_NORMAL):
            yield run
            run = []
        if in_contact:
            run.append(row)
    if run:
        yield run


def normal_of(row):
    return float(row["normal_x"]), float(row["normal_y"])


def instants_of(trace_path, contour_path):
    """Four instants of one contact: among all contacts with one wall that A4 aligns, the contact that
    starts at the largest angle. The instants are its first tick and the first ticks at which the
    angle is at most each of LATER_BELOW_DEG."""
    with open(trace_path, encoding="utf-8", newline="") as file:
        runs = [run for run in walls(csv.DictReader(file))
                if float(run[0]["alpha_deg"]) > START_ABOVE_DEG and
                min(float(row["alpha_deg"]) for row in run) <= LATER_BELOW_DEG[-1]]
    run = max(runs, key=lambda r: float(r[0]["alpha_deg"]))
    chosen = [run[0]] + [next(row for row in run if float(row["alpha_deg"]) <= angle)
                         for angle in LATER_BELOW_DEG]
    with open(contour_path, encoding="utf-8", newline="") as file:
        outline = [[float(row["x"]), float(row["y"])] for row in csv.DictReader(file)]
    return {"source": "palpate run models/star.glb --virtual: trace-on.csv, contour-on.csv",
            "first_tick": int(run[0]["tick"]),
            "actuated_axis_device": list(ACTUATED_AXIS),
            "outline_scene_m": [[round(c, 7) for c in p] for p in corners(outline)],
            "instants": [instant_of(row, run[0]) for row in chosen]}


def instant_of(row, first):
    return {"t_s": round(float(row["t"]) - float(first["t"]), 6),
            "proxy_scene_m": [round(float(row[f"proxy_{axis}"]), 7) for axis in "xy"],
            "normal_scene": [round(c, 9) for c in normal_of(row)],
            "T_device_scene": {"q_wz": [round(float(row[f"q_{axis}"]), 9) for axis in "wz"],
                               "origin_m": [round(float(row[f"o_{axis}"]), 7) for axis in "xy"]},
            "contact_angle_deg": round(float(row["alpha_deg"]), 4)}


def corners(outline):
    """A closed outline without the points that lie on a straight wall."""
    if outline[0] == outline[-1]:
        outline = outline[:-1]

    def is_corner(n):
        (ax, ay), (bx, by), (cx, cy) = (outline[(n + k) % len(outline)] for k in (-1, 0, 1))
        cross = (bx - ax) * (cy - by) - (by - ay) * (cx - bx)
        return abs(cross) > 1e-6 * math.dist((ax, ay), (bx, by)) * math.dist((bx, by), (cx, cy))
    return [p for n, p in enumerate(outline) if is_corner(n)]


# Geometry

def turned(instant, vector):
    w, z = instant["T_device_scene"]["q_wz"]
    angle = 2.0 * math.atan2(z, w)
    return (math.cos(angle) * vector[0] - math.sin(angle) * vector[1],
            math.sin(angle) * vector[0] + math.cos(angle) * vector[1])


def angle_deg(instant, axis):
    """Between the contact normal, turned into the device frame, and the line of the motor."""
    normal = turned(instant, instant["normal_scene"])
    cosine = abs(normal[0] * axis[0] + normal[1] * axis[1]) / math.hypot(*normal)
    return math.degrees(math.acos(min(1.0, cosine)))


def from_contact(instant, point):
    """A point of the scene, relative to the contact, along the axes of the device."""
    proxy = instant["proxy_scene_m"]
    return turned(instant, (point[0] - proxy[0], point[1] - proxy[1]))


def touched_wall(data, instant):
    """The side of the outline that is nearest to the proxy among those that have its normal."""
    outline = data["outline_scene_m"]
    sides = [(a, b) for a, b in zip(outline, outline[1:] + outline[:1])]

    def distance(side):
        (ax, ay), (bx, by) = side
        length = math.dist(*side)
        along = ((bx - ax) / length, (by - ay) / length)
        px, py = (p - q for p, q in zip(instant["proxy_scene_m"], (ax, ay)))
        s = min(max(px * along[0] + py * along[1], 0.0), length)
        slant = abs(along[0] * instant["normal_scene"][0] + along[1] * instant["normal_scene"][1])
        return (slant > 1e-3, math.dist((px, py), (s * along[0], s * along[1])))
    return min(sides, key=distance)


# Picture

def draw(data, objects):
    """data: the result of instants_of; objects: the content of objects.json."""
    instants = data["instants"]
    star = [[from_contact(i, p) for p in data["outline_scene_m"]] for i in instants]
    low = [min(p[k] for points in star for p in points) for k in (0, 1)]
    low[0] = min(low[0], -LEFT_OF_CONTACT_M)
    high = [max(p[k] for points in star for p in points) for k in (0, 1)]
    panel = (WIDTH - 2 * MARGIN - (len(instants) - 1) * GAP) / len(instants)
    scale = (panel - 16) / (high[0] - low[0])
    height = scale * (high[1] - low[1]) + 16
    text_top = PANELS_TOP + HEADER + height + 56
    picture = svg.Drawing(WIDTH, 0, "A4 turns the star until the touched wall faces the only motor")
    picture.text((MARGIN, 36), "A4 turns the scene until the touched wall faces the motor", 24,
                 bold=True)
    picture.paragraph((MARGIN, 62),
                      "The device senses two axes and has one motor, which can push only along the "
                      "blue axis. The hand presses on one wall of the star (red) and slides along it. "
                      "Every panel shows the contact at the same place: the star turns, the motor "
                      "does not.",
                      WIDTH - 2 * MARGIN, TEXT)
    draw_legend(picture)
    for n, instant in enumerate(instants):
        left = MARGIN + n * (panel + GAP)

        def place(point, left=left):
            return (left + 8 + scale * (point[0] - low[0]),
                    PANELS_TOP + HEADER + 8 + scale * (high[1] - point[1]))
        draw_panel(picture, data, instant, (left, panel, height), place, star[n], n)
    picture.height = math.ceil(draw_text(picture, text_top, objects))
    return picture.svg()


def draw_legend(picture):
    def mark(n):
        return MARGIN + LEGEND_X[n], LEGEND_Y - 5, MARGIN + LEGEND_X[n] + 34

    x, y, end = mark(0)
    picture.arrow((x, y), (end, y), MOTOR, 3, both_ends=True)
    x, y, end = mark(1)
    picture.line([(x, y), (end, y)], WALL, 5)
    x, y, end = mark(2)
    picture.arrow((x, y), (end, y), WALL, 2.5)
    x, y, end = mark(3)
    picture.circle((end - 8, y), 5.5, svg.INK)
    x, y, end = mark(4)
    picture.line(svg.arc((x + 12, y + 7), 17, 0.0, 1.6), svg.INK, 1.5)
    for n, (text, colour) in enumerate([("the only motor", MOTOR), ("touched wall", WALL),
                                        ("contact normal", WALL), ("contact", svg.INK),
                                        ("angle to the motor", svg.INK)]):
        picture.text((mark(n)[2] + 8, LEGEND_Y), text, TEXT, colour)


def draw_panel(picture, data, instant, frame, place, star, n):
    left, panel, height = frame
    axis = data["actuated_axis_device"]
    angle = angle_deg(instant, axis)
    picture.rectangle((left, PANELS_TOP), (panel, HEADER + height), "none", "#78787866", 6)
    picture.text((left + 10, PANELS_TOP + 22), f"{instant['t_s']:.2f} s", TEXT, MUTED)
    picture.text((left + panel - 10, PANELS_TOP + 23), f"{angle:.0f}\u00b0", 20, svg.INK, "end", True)
    picture.polygon([place(p) for p in star], svg.FAINT, svg.INK, 1.2)
    picture.line([place(from_contact(instant, p)) for p in touched_wall(data, instant)], WALL, 5)
    if n + 1 < len(data["instants"]):
        middle = place([sum(p[k] for p in star) / len(star) for k in (0, 1)])
        curve = svg.arc(middle, 24, -0.6, 1.9)
        picture.line(curve[:-3], TURN, 2.5)
        picture.arrow(curve[-4], curve[-1], TURN, 2.5)

    contact = place((0.0, 0.0))
    tips = [(contact[0] + s * ARROW_PX * axis[0], contact[1] - s * ARROW_PX * axis[1])
            for s in (-1, 1)]
    normal = turned(instant, instant["normal_scene"])
    picture.arrow(tips[0], tips[1], MOTOR, 3.5, both_ends=True)
    tip = contact[0] + NORMAL_PX * normal[0], contact[1] - NORMAL_PX * normal[1]
    picture.arrow(contact, tip, WALL, 2.5)
    along = 1.0 if normal[0] * axis[0] + normal[1] * axis[1] >= 0.0 else -1.0
    first = math.atan2(along * axis[1], along * axis[0])
    turn = math.remainder(math.atan2(normal[1], normal[0]) - first, 2.0 * math.pi)
    picture.line(svg.arc(contact, ANGLE_PX, first, first + turn), svg.INK, 1.5)
    picture.circle(contact, 5.5, svg.INK)

    bottom = PANELS_TOP + HEADER + height
    share = math.cos(math.radians(angle))
    picture.rectangle((left, bottom + 10), (panel, 8), svg.FAINT, radius=4)
    picture.rectangle((left, bottom + 10), (panel * share, 8), MOTOR, radius=4)
    picture.text((left, bottom + 38), f"force rendered: {100 * share:.0f} %", TEXT, MOTOR)


def draw_text(picture, top, objects):
    """Returns the y below the text."""
    off, on = objects["star"]
    column = (WIDTH - 2 * MARGIN - 24) / 2
    columns = [
        ("What gets better",
         "Over one turn round the star, the mean angle between the touched wall's normal and the "
         f"motor falls from {off['mean_contact_angle_deg']:.1f}\u00b0 without A4 to "
         f"{on['mean_contact_angle_deg']:.1f}\u00b0 with it. Without A4 the star stays as in the first "
         "panel."),
        ("What gets worse",
         f"The hand loses contact {off['losses_of_contact']} times without A4 and "
         f"{on['losses_of_contact']} times with it: at a tip the star turns while the hand still "
         f"moves on. The device returns {1000 * off['port_work_J']:.0f} mJ without A4 and "
         f"{1000 * on['port_work_J']:.0f} mJ with it: the hand presses in against part of the force "
         "and is pushed out by all of it."),
    ]
    below = top
    for n, (title, text) in enumerate(columns):
        x = MARGIN + n * (column + 24)
        picture.text((x, top + 16), title, 20, bold=True)
        below = max(below, picture.paragraph((x, top + 42), text, column, TEXT))
    return below


def svg_of(folder):
    """The picture as the files of a folder give it."""
    data, objects = (json.loads((folder / name).read_text(encoding="utf-8"))
                     for name in ("a4.json", "objects.json"))
    return draw(data, objects)
