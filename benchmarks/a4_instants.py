"""The instants of a4.json: one wall of the star while A4 turns it towards the motor.

measure_objects.py takes them from a trace of `palpate run`. Lengths in metres, angles in degrees.
"""

import csv
import math

START_ABOVE_DEG = 45.0
LATER_BELOW_DEG = [45.0, 20.0, 3.0]  # the later instants: the first tick at or below each angle
SAME_NORMAL = 1e-9
ACTUATED_AXIS = (1.0, 0.0)  # A1, the only motor of the device with two sensors


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
