#!/usr/bin/env python3
"""The figures a4.svg, groove.svg and a4_helps.svg show what their data say, and all committed figures are
legible on white and on dark ground.

figures_test.py BENCHMARKS_DIR
"""

import copy
import csv
import json
import math
import pathlib
import re
import sys
import tempfile

sys.dont_write_bytecode = True
BENCHMARKS = pathlib.Path(sys.argv[1])
sys.path.insert(0, str(BENCHMARKS))
import a4_figure  # noqa: E402
import groove_figure  # noqa: E402
import svg  # noqa: E402
import sweep_figure  # noqa: E402


def expect(condition, statement):
    if not condition:
        sys.exit(f"false: {statement}")


def angle_deg(instant):
    """From the rotation matrix of the quaternion, between the device's normal and the x axis."""
    w, z = instant["T_device_scene"]["q_wz"]
    x, y = instant["normal_scene"]
    return math.degrees(math.acos(min(1.0, abs((w * w - z * z) * x - 2.0 * w * z * y))))


def check_a4():
    folder = BENCHMARKS / "results/paper_objects"
    data, objects = (json.loads((folder / name).read_text()) for name in ("a4.json", "objects.json"))
    picture = a4_figure.draw(data, objects)
    angles = [angle_deg(instant) for instant in data["instants"]]
    for angle, instant in zip(angles, data["instants"]):
        expect(abs(angle - instant["contact_angle_deg"]) < 0.01,
               f"pose and normal at {instant['t_s']} s give the angle of the trace")
        expect(f">{instant['t_s']:.2f} s<" in picture, f"the picture shows {instant['t_s']:.2f} s")
    expect(len(angles) == 4 and angles == sorted(angles, reverse=True), "four angles decrease")
    shown = [int(text) for text in re.findall(r">(\d+)\u00b0</text>", picture)]
    expect(shown == [round(angle) for angle in angles], "the picture shows these angles")
    shares = [int(text) for text in re.findall(r">force rendered: (\d+) %<", picture)]
    expect(shares == [round(100 * math.cos(math.radians(a))) for a in angles],
           "the rendered part of the force is the cosine of the angle")
    walls = {a4_figure.touched_wall(data, i)[0][0] for i in data["instants"]}
    expect(len(walls) == 1, "every panel shows the same wall")
    for instant in data["instants"]:
        # The proxy keeps a stand-off, far less than a pixel of the picture, from the wall.
        (ax, ay), (bx, by) = a4_figure.touched_wall(data, instant)
        px, py = instant["proxy_scene_m"]
        height = ((bx - ax) * (py - ay) - (by - ay) * (px - ax)) / math.hypot(bx - ax, by - ay)
        expect(abs(height) < 1e-4, "the proxy touches the wall that is drawn")

    changed = copy.deepcopy(data)
    changed["instants"][1]["T_device_scene"]["q_wz"] = [1.0, 0.0]
    expect(a4_figure.draw(changed, objects) != picture, "another pose gives another picture")
    changed = copy.deepcopy(objects)
    changed["star"][1]["losses_of_contact"] += 1
    expect(a4_figure.draw(data, changed) != picture, "another result gives another caption")


def trace_row(tick, normal, alpha_deg, contact=1):
    return {"tick": tick, "t": 0.001 * tick, "proxy_x": 0.0, "proxy_y": 0.0, "normal_x": normal[0],
            "normal_y": normal[1], "contact": contact, "alpha_deg": alpha_deg, "q_w": 1.0, "q_z": 0.0,
            "o_x": 0.0, "o_y": 0.0}


def check_choice_of_instants():
    """Three contacts: one is not aligned, one starts at a smaller angle, one is chosen."""
    rows = [trace_row(n, (1.0, 0.0), 80.0 - n) for n in range(10)]
    rows += [trace_row(10 + n, (0.0, 1.0), 60.0 - n) for n in range(61)]
    rows += [trace_row(71, (0.0, 0.0), 0.0, contact=0)]
    rows += [trace_row(72 + n, (0.0, 1.0), 70.0 - n) for n in range(71)]
    with tempfile.TemporaryDirectory() as name:
        trace, contour = pathlib.Path(name) / "trace.csv", pathlib.Path(name) / "contour.csv"
        for path, table in ((trace, rows), (contour, [
                {"x": x, "y": y} for x, y in ((0.5, 0), (1, 0), (1, 1), (0, 1), (0, 0), (0.5, 0))])):
            with open(path, "w", newline="", encoding="utf-8") as file:
                writer = csv.DictWriter(file, table[0].keys())
                writer.writeheader()
                writer.writerows(table)
        data = a4_figure.instants_of(trace, contour)
    expect(data["first_tick"] == 72, "the chosen contact starts at 70 deg")
    expect([i["contact_angle_deg"] for i in data["instants"]] == [70.0, 45.0, 20.0, 3.0],
           "the instants are the start and the first ticks at 45, 20 and 3 deg")
    expect([i["t_s"] for i in data["instants"]] == [0.0, 0.025, 0.05, 0.067],
           "times are counted from the start of the contact")
    expect(len(data["outline_scene_m"]) == 4, "a start on a straight wall is no corner")


def check_groove():
    old, stopped, nearest, rest = groove_figure.steps()
    goal = groove_figure.GOAL_MM
    first, second = groove_figure.normals()
    heights = [groove_figure.height(rest, normal) for normal in (first, second)]
    expect(max(abs(h) for h in heights) < 1e-12, "the proxy rests on both planes")
    expect(abs(groove_figure.height(stopped, first)) < 1e-12, "the first step ends on plane 1")
    expect(min(groove_figure.height(p, second) for p in (old, stopped)) > 0.0,
           "plane 2 is met last")
    least = math.dist(rest, goal)
    for n in range(3600):
        angle = math.radians(n / 10)
        step = (rest[0] + 0.01 * math.cos(angle), rest[1] + 0.01 * math.sin(angle))
        if min(groove_figure.height(step, normal) for normal in (first, second)) >= 0.0:
            expect(math.dist(step, goal) > least, "no free direction leads nearer to the goal")
    expect(math.dist(nearest, goal) < least, "plane 1 alone would let the proxy go nearer")
    committed = BENCHMARKS.parent / "haptics/proxy/groove.svg"
    expect(committed.read_text(encoding="utf-8") == groove_figure.draw(), "groove.svg is up to date")


def check_sweep():
    """The halves and words of each assumption and measure lie at their shares of the panel."""
    folder = BENCHMARKS / "results/sweep"
    data = json.loads((folder / "sweep.json").read_text(encoding="utf-8"))
    picture = sweep_figure.draw(data)
    expect((folder / "a4_helps.svg").read_text(encoding="utf-8") == picture, "a4_helps.svg is up to date")
    circles = [(float(x), float(y)) for x, y in
               re.findall(r'<circle cx="([\d.]+)" cy="([\d.]+)" r="5"', picture)]
    marks = [float(x) + 3 for x in
             re.findall(r'<rect x="([\d.]+)" y="[\d.]+" width="6.0" height="10.0"', picture)]
    measures = sweep_figure.drawn(data)
    columns = len(measures)
    panel = sweep_figure.panel_width(measures)
    expected, words = [], []
    for n, (_, ranking) in enumerate(measures):
        left = sweep_figure.MARGIN + sweep_figure.NAMES + n * (panel + sweep_figure.GAP)
        for row in data["halves"]:
            if row["ranking"] == ranking:
                of = expected if row["part"] in sweep_figure.HALVES else words
                of.append(left + row["holds"] / row["points"] * panel)
    # Ten numbers with two halves; four words of following and two of align. Before the marks of the
    # words, and after the circles, come those of the legend.
    expect(len(expected) == 20 * columns and len(words) == 6 * columns, "all assumptions are drawn")
    expect(len(circles) == len(expected) + 3 and len(marks) == len(words) + 1, "nothing else is drawn")
    for found, shares in (([x for x, _ in circles], expected), (marks, words)):
        expect(all(abs(x - share) < 0.06 for x, share in zip(found, shares)),
               "each point is at its share, to the digit that is written")
    for ranking in {name for _, name in sweep_figure.MEASURES}:
        of = [row for row in data["halves"] if row["ranking"] == ranking]
        shares = {row["parameter"]: [other["share"] for other in of
                                     if other["parameter"] == row["parameter"]] for row in of}
        differences = {name: max(values) - min(values) for name, values in shares.items()}
        decides = next(row for row in data["rankings"] if row["ranking"] == ranking)
        most = max(differences.values())
        expect((decides["p"] is None) == (most == 0.0), f"{ranking} has p if shares differ")
        is_clear = most > 0.0 and decides["p"] < 0.05
        expect((decides["decisive_parameters"] or "").split() ==
               [name for name, difference in differences.items() if difference == most and is_clear],
               f"what decides {ranking} differs most")
    changed = copy.deepcopy(data)
    changed["halves"][-1]["share"] = 0.123
    expect(sweep_figure.draw(changed) != picture, "another share gives another picture")


def luminance(colour):
    parts = [int(colour[at:at + 2], 16) / 255 for at in (1, 3, 5)]
    red, green, blue = (part / 12.92 if part <= 0.03928 else ((part + 0.055) / 1.055) ** 2.4
                        for part in parts)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def contrast(colour, ground):
    low, high = sorted((luminance(colour), luminance(ground)))
    return (high + 0.05) / (low + 0.05)


def check_grounds():
    """No figure has a ground of its own. Its colours, but for the digits in badges and for areas, grids and
    frames, which have an opacity, keep a contrast of 4 on both grounds."""
    root = BENCHMARKS.parent
    figures = [root / "haptics/proxy/groove.svg", *sorted(BENCHMARKS.glob("results/**/*.svg")),
               *sorted(root.glob("docs/pictures/*.svg"))]
    expect(len(figures) >= 5, "the committed figures are found")
    for path in figures:
        text = path.read_text(encoding="utf-8")
        body = text.split("</defs>")[-1]
        expect(not re.search(r"""<rect[^>]*fill=.#ffffff""", body, re.IGNORECASE),
               f"{path.name} has no ground")
        badges = re.sub(r'<text [^>]*fill="#ffffff"[^>]*>\d</text>', "", body)
        used = set(re.findall(r"""(?:fill|stroke)=["']([^"']+)["'](?! (?:fill|stroke)-opacity)""", badges))
        colours = {value for value in used if value not in ("none", "currentColor")}
        expect(colours and all(re.fullmatch("#[0-9a-f]{6}", value) for value in colours),
               f"{path.name} has colours of a known form: {sorted(colours)}")
        for colour in colours:
            least = min(contrast(colour, ground) for ground in ("#ffffff", "#131416"))
            expect(least >= 4.0, f"{colour} in {path.name} has a contrast of 4, not {least:.2f}")
        letters = [float(size) for size in re.findall(r'font-size="([\d.]+)"', text)]
        width = float(re.search(r'viewBox="0 0 (\d+)', text)[1])
        expect(min(letters) * 700 / width >= 12.0, f"{path.name} has letters of 12 px at a width of 700 px")
    drawn = svg.on_any_ground('<rect x="0" y="0" width="9" height="9" fill="#ffffff"/>\n'
                              '<path stroke="rgb(213,  94,   0)" fill = "black"/>')
    expect(drawn == f'<path stroke="{svg.ORANGE}" fill="{svg.INK}"/>', "a picture of gnuplot is recoloured")


def main():
    check_a4()
    check_grounds()
    check_sweep()
    check_choice_of_instants()
    check_groove()
    print("the figures show their data")
    return 0


if __name__ == "__main__":
    sys.exit(main())
