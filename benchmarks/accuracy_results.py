"""What accuracy costs: the table and the figure, from the rows accuracy_<knob>/<method>/<level> of a
result.

Counters of a row: error, error_low, error_high, time, time_low, time_high (median and quartiles),
level; optionally is_default and failures. Rows of a method are ordered from coarse to fine.
"""

import math
import re
from typing import NamedTuple

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

def figure_table(rows):
    """What palpate.analysis.results.accuracy draws: the levels of the main knobs that were measured."""
    return [{"knob": name, "title": knob.title, "method": method, "is_default": bool(row.get("is_default")),
             "error_name": knob.error, "error_unit": knob.error_unit, "time_name": knob.time,
             "time_unit": knob.time_unit,
             **{key: row[key] for key in COUNTERS if key != "level"}}
            for name in MAIN_KNOBS for knob in [KNOBS[name]]
            for method, levels in levels_of(rows, name).items() for _, row in levels]
