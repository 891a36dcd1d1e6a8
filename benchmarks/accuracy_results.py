"""What accuracy costs: the table and the figure, from the rows accuracy_<knob>/<method>/<level> of a
result.

Counters of a row: error, error_low, error_high, time, time_low, time_high (median and quartiles),
level; optionally is_default and failures. Rows of a method are ordered from coarse to fine.
"""

import hashlib
import math
import re
import subprocess
from typing import NamedTuple

import svg

PREFIX = "accuracy_"
COUNTERS = ("error", "error_low", "error_high", "time", "time_low", "time_high", "level")


class Knob(NamedTuple):
    title: str
    error: str
    error_unit: str
    time: str
    time_unit: str
    level_unit: str = ""


TICK = ("tick", "ns")
SECOND = ("computing time per second of contact", "us")

# In the order of the table. The units are those of engine/accuracy: a counter of a result has none.
KNOBS = {
    "mesh_depth": Knob("mesh resolution: mean edge", "penetration depth", "m", *TICK, "m"),
    "mesh_angle": Knob("mesh resolution: mean edge", "contact normal", "deg", *TICK, "m"),
    "proxy_radius": Knob("point and sphere proxy: mean edge", "contact normal", "deg", *TICK, "m"),
    "solver_iterations": Knob("solver: limit of steps", "distance to the converged proxy", "m",
                              *TICK),
    "solver_tolerance": Knob("solver: tolerance in stand-offs", "distance to the converged proxy",
                             "m", *TICK),
    "candidate_reuse": Knob("candidates kept: speed of the hand",
                            "distance to the converged proxy", "m", *TICK, "m/s"),
    "narrow_phase": Knob("arithmetic: distance from the origin",
                         "distance to the proxy at the origin", "m", *TICK, "m"),
    "certification": Knob("certificate: angle of a groove", "distance to the exact proxy", "m",
                          *TICK, "deg"),
    "work_budget": Knob("work budget of a tick: units", "distance to the proxy without a budget",
                        "m", *TICK),
    "servo_rate": Knob("servo period", "energy gained in a bounce", "", *SECOND, "s"),
    "servo_pressed": Knob("servo period, pressing hand", "deviation of the path", "", *SECOND, "s"),
    "jitter": Knob("servo period, uneven ticks", "energy gained in a bounce", "", *SECOND, "s"),
    "substeps": Knob("substep under friction", "error of the radius", "m", *SECOND, "s"),
    "integrator": Knob("step of the simulated device", "deviation of the path", "", *SECOND, "s"),
    "velocity_noise": Knob("velocity window, encoder noise", "velocity error", "m/s", *TICK, "ticks"),
    "velocity_lag": Knob("velocity window, lag", "velocity error", "m/s", *TICK, "ticks"),
    "velocity_total": Knob("velocity window, total", "velocity error", "m/s", *TICK, "ticks"),
    "a4_step": Knob("period of A4's rotation", "error of the time to align", "s", *SECOND, "s"),
    "texture_sampling": Knob("relief: texel size", "error of the normal force / (K H)", "", *TICK, "m"),
    "effect_costs": Knob("each effect alone: triangles", "change of force (not an error)", "N",
                         "added time", "ns"),
    "effects": Knob("effects left out: triangles", "missing force", "N",
                    "time added by the others", "ns"),
}

# The knobs of the figure; unmeasured ones are left out.
MAIN_KNOBS = ["mesh_depth", "solver_iterations", "servo_rate", "velocity_total", "integrator",
              "a4_step"]


def read_row(run):
    """(knob, method, level), or None for a row of another benchmark; KeyError or ValueError for an
    invalid row."""
    parts = run["name"].split("/")
    if not parts[0].startswith(PREFIX):
        return None
    if len(parts) < 3:
        raise ValueError(f"{run['name']}: expected {PREFIX}<knob>/<method>/<level>")
    knob = parts[0][len(PREFIX):]
    if knob not in KNOBS:
        raise ValueError(f"{run['name']}: accuracy_results.py has no units for this knob")
    for counter in COUNTERS:
        if not math.isfinite(run[counter]):
            raise ValueError(f"{run['name']}: {counter} is {run[counter]}")
    return knob, parts[1], parts[2]


# Numbers

PREFIXES = [(1.0, ""), (1e-3, "m"), (1e-6, "u"), (1e-9, "n")]
UNITS = {prefix + base: (factor, base) for base in ("m", "s", "N") for factor, prefix in PREFIXES}
UNITS |= {"m/s": (1.0, "m/s")}


def display_unit(size, unit):
    """The factor that converts a value, and the unit of the result: lengths in nm, um or mm."""
    if unit not in UNITS:
        return 1.0, unit
    in_base, base = UNITS[unit]
    if not 1e-12 <= abs(size) * in_base:
        return in_base, base
    for factor, prefix in PREFIXES:
        if abs(size) * in_base >= 0.9995 * factor:
            break
    return in_base / factor, prefix + base


def number(value):
    """Three digits."""
    if value == 0:
        return "0"
    if 1e-3 <= abs(value) < 1e6:
        digits = max(0, 2 - math.floor(math.log10(abs(value))))
        text = f"{value:.{digits}f}"
        return text.rstrip("0").rstrip(".") if "." in text else text
    return re.sub(r"e([+-])0*", lambda m: "e" + m[1].strip("+"), f"{value:.3g}")


def human(value, unit):
    if value == 0:
        return "0"
    if unit == "ticks" and value == 1:
        return "1 tick"
    factor, shown = display_unit(value, unit)
    return f"{number(value * factor)} {shown}".strip()


# Table

def levels_of(rows, knob):
    """{method: [(level, row), ...]} without failed levels, in their order."""
    methods = {}
    for (name, method, level), row in rows.items():
        if name == knob and not row.get("failures"):
            methods.setdefault(method, []).append((level, row))
    return methods


def cell(knob, row):
    name = human(row["level"], knob.level_unit)
    bound = "<= " if row.get("at_floor") else ""
    return (f"{name}: {bound}{human(row['error'], knob.error_unit)}, "
            f"{human(row['time'], knob.time_unit)}")


def table(rows):
    lines = []
    for name, knob in KNOBS.items():
        methods = levels_of(rows, name)
        if not methods:
            continue
        usual = [(method, level, row) for method, levels in methods.items()
                 for level, row in levels if row.get("is_default")]
        levels = methods[usual[0][0]] if usual else next(iter(methods.values()))
        default = cell(knob, usual[0][-1]) if usual else "-"
        lines.append(f"| {knob.title} | {knob.error}, {knob.time} | {cell(knob, levels[0][1])} | "
                     f"{default} | {cell(knob, levels[-1][1])} |")
    if not lines:
        return ""
    return "\n".join(["| parameter | error, time | first level | default | last level |",
                      "|---|---|---:|---:|---:|"] + lines)


# Figure

# Okabe and Ito's colours, and gnuplot's filled points.
COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9"]
POINTS = [7, 5, 9, 11, 13, 15]
COLUMNS = 2
PANEL_WIDTH, PLOT_HEIGHT, FONT_PX = 400, 250, 14
LEFT, RIGHT, TOP, LEGEND_GAP, LEGEND_ROW, BOTTOM = 78, 14, 42, 62, 22, 14
LEAST_DECADES = 0.2
WHISKER_BEYOND = 1.5  # decades
MARGIN = 0.08  # of the span
ZERO_BELOW = 0.15


class Axis:
    """Positions are log10 of a value; 0 is below all others."""

    def __init__(self, rows, counter, unit):
        values = [row[counter] for row in rows]
        logs = [math.log10(v) for v in values if v > 0] or [0.0]
        factor, self.unit = display_unit(10 ** max(logs), unit)
        self.shift = math.log10(factor)
        whiskers = [math.log10(row[counter + end]) for row in rows for end in ("_low", "_high")
                    if row[counter + end] > 0]
        first = max(min(logs) - WHISKER_BEYOND, min(logs + whiskers))
        last = min(max(logs) + WHISKER_BEYOND, max(logs + whiskers))
        lacking = max(0.0, LEAST_DECADES - (last - first)) / 2
        first, last = first - lacking, last + lacking
        margin = MARGIN * (last - first)
        self.first, self.last = first - margin, last + margin
        self.marks = self.ticks() if any(v > 0 for v in values) else []
        self.zero = None
        if any(v <= 0 for v in values):
            self.zero = self.first - ZERO_BELOW * (self.last - self.first)
            self.first = self.zero - margin
            self.marks.append((self.zero, "0"))

    def at(self, value):
        if value <= 0:
            return self.first if self.zero is None else self.zero
        return min(max(math.log10(value), self.first), self.last)

    def ticks(self):
        first, last = self.first + self.shift, self.last + self.shift
        powers = range(math.floor(first), math.floor(last) + 1)
        if last - first > 2.5:
            stride = math.ceil((last - first) / 6)
            values = [10.0 ** p for p in powers if p % stride == 0]
        elif last - first > 0.8:
            values = [d * 10.0 ** p for p in powers for d in (1, 2, 5)]
        else:
            rough = (10 ** last - 10 ** first) / 4
            power = 10.0 ** math.floor(math.log10(rough))
            step = next(d * power for d in (1, 2, 5, 10) if d * power >= rough)
            values = [n * step for n in range(1, math.floor(10 ** last / step) + 1)]
        return [(math.log10(v) - self.shift, number(v)) for v in values
                if first <= math.log10(v) <= last]

    def set(self, letter):
        marks = ", ".join(f"{quoted(text)} {at:.6g}" for at, text in self.marks)
        return f"set {letter}range [{self.first:.6g}:{self.last:.6g}]\nset {letter}tics ({marks})\n"


def quoted(text):
    """A string of gnuplot's language; characters with a meaning in it are written as octal."""
    escaped = re.sub("[\\\\\"'`@]", lambda m: f"\\{ord(m[0]):03o}", text)
    return f'"{escaped}"'


def block(name, lines):
    return f"${name} << EOD\n" + "".join(
        " ".join(f"{x:.6g}" for x in line) + "\n" for line in lines) + "EOD\n"


def title_with_unit(name, unit):
    return quoted(f"{name} ({unit})" if unit else name)


def panel(index, name, methods, frame):
    knob = KNOBS[name]
    all_rows = [row for levels in methods.values() for _, row in levels]
    x = Axis(all_rows, "time", knob.time_unit)
    y = Axis(all_rows, "error", knob.error_unit)
    text = (frame + x.set("x") + y.set("y") + f"set title {quoted(knob.title)} offset 0,-0.4\n"
            f"set xlabel {title_with_unit(knob.time, x.unit)} offset 0,0.4\n"
            f"set ylabel {title_with_unit(knob.error, y.unit)} offset 1,0\n")
    plots = ["NaN notitle"]
    for m, (method, levels) in enumerate(methods.items()):
        style = f"pt {POINTS[m % 6]} ps 0.8 lc rgb '{COLOURS[m % 6]}'"
        text += block(f"d{index}_{m}", [
            (x.at(row["time"]), y.at(row["error"]), x.at(row["time_low"]), x.at(row["time_high"]),
             y.at(row["error_low"]), y.at(row["error_high"])) for _, row in levels])
        plots += [f"$d{index}_{m} with xyerrorbars pt 0 ps 0 lc rgb '{COLOURS[m % 6]}' notitle",
                  f"$d{index}_{m} with linespoints lw 2 {style} title "
                  f"{quoted(method.replace('-', ' '))}"]
    usual = [(x.at(row["time"]), y.at(row["error"])) for row in all_rows if row.get("is_default")]
    if usual:
        text += block(f"u{index}", usual)
        plots.append(f"$u{index} with points pt 6 ps 2 lc rgb '#000000' title 'default'")
    return text + "plot " + ", \\\n  ".join(plots) + "\n"


def script(rows):
    """The gnuplot script with all its data; empty if no main knob was measured."""
    panels = [(name, levels_of(rows, name)) for name in MAIN_KNOBS]
    panels = [(name, methods) for name, methods in panels if methods]
    if not panels:
        return ""
    columns = min(COLUMNS, len(panels))
    legend_rows = 1 + max(len(methods) for _, methods in panels)
    height = TOP + PLOT_HEIGHT + LEGEND_GAP + LEGEND_ROW * legend_rows + BOTTOM
    size = columns * PANEL_WIDTH, math.ceil(len(panels) / columns) * height
    text = (f"set encoding utf8\nset terminal svg noenhanced size {size[0]},{size[1]} "
            f"font 'sans-serif,{FONT_PX}' background 'white'\nset multiplot\n"
            "set grid lc rgb '#E4E4E4'\nset border lc rgb '#404040'\nset tics nomirror scale 0.7\n")
    for i, (name, methods) in enumerate(panels):
        left, top = i % columns * PANEL_WIDTH, i // columns * height
        bottom = top + TOP + PLOT_HEIGHT
        frame = (f"set lmargin at screen {(left + LEFT) / size[0]:.6g}\n"
                 f"set rmargin at screen {(left + PANEL_WIDTH - RIGHT) / size[0]:.6g}\n"
                 f"set tmargin at screen {1 - (top + TOP) / size[1]:.6g}\n"
                 f"set bmargin at screen {1 - bottom / size[1]:.6g}\n"
                 f"set key at screen {(left + LEFT) / size[0]:.6g}, screen "
                 f"{1 - (bottom + LEGEND_GAP) / size[1]:.6g} left top Left reverse samplen 2\n")
        text += panel(i, name, methods, frame)
    return text + "unset multiplot\n"


def hash_of(text):
    return hashlib.sha256(text.encode()).hexdigest()


def is_figure_of(text, path):
    """Whether the file was drawn by this script. The SVG itself differs between gnuplot versions."""
    try:
        return f"<!-- drawn by the script {hash_of(text)} -->" in path.read_text(encoding="utf-8")
    except OSError:
        return False


def draw(text, path):
    """Draws the figure, or raises OSError."""
    done = subprocess.run(["gnuplot", "-d"], input=text, capture_output=True, text=True,
                          encoding="utf-8")
    if done.returncode != 0 or "</svg>" not in done.stdout:
        raise OSError(f"gnuplot did not draw it: {done.stderr.strip()[-200:]}")
    picture = svg.on_any_ground(done.stdout).replace(
        "</svg>", f"<!-- drawn by the script {hash_of(text)} -->\n</svg>")
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(picture, encoding="utf-8")
