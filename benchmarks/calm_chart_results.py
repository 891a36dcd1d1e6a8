"""The table and the figure of what is safe with which device, from the tables of measure_calm_chart.py.

The areas of the figure are the zones of a device that states nothing but its delay (a bare tip); the
points are the contacts that `palpate soak --device` has simulated.
"""

import csv

import result_tables as tables
from result_tables import BadInput

CASES = "calm_chart.csv"
ZONES = "stiffness_zones.csv"
RATE_HZ = 1000.0  # of the row of the stiffness
# The longest delay of a column, s: a hAPI board on a fast line, on a slow one, and the end of the chart.
DELAYS_S = (1e-3, 3.1e-3, 5e-3)
SAME_S = 1e-9  # far below the step of the delays
AT_REST = ("stable", "calm by the controller")
BROKEN = ("swings", "returns energy")
NO_BREAK = "\N{NO-BREAK SPACE}"


def rows_of(path):
    try:
        with path.open(encoding="utf-8", newline="") as file:
            return list(csv.DictReader(file))
    except OSError as error:
        raise BadInput(f"{path}: expected a table of measure_calm_chart.py ({error!r})") from error


def read(folder):
    """(cases, zones)"""
    cases, zones = rows_of(folder / CASES), rows_of(folder / ZONES)
    try:
        block((cases, zones))
        figure_table((cases, zones))
    except (OSError, ValueError, KeyError, ArithmeticError, StopIteration) as error:
        raise BadInput(f"{folder}: expected the tables of measure_calm_chart.py ({error!r})") from error
    return cases, zones


def figure_table(measured):
    """What palpate.analysis.results.calm_chart draws."""
    cases, zones = measured

    def numbers(row, *names):
        return {"rate_Hz": float(row["rate_Hz"]), "delay_ms": 1e3 * float(row["delay_s"]),
                **{name: float(row[name]) for name in names}}

    return {"cases": [{**numbers(row, "stiffness_N_per_m"), "outcome": row["outcome"]} for row in cases
                      if row["states_delay"] == "1"],
            "zones": [numbers(row, "stable_N_per_m", "calm_N_per_m") for row in zones]}


def stiffness_cell(zones, delay_s):
    row = next(row for row in zones if float(row["rate_Hz"]) == RATE_HZ
               and abs(float(row["delay_s"]) - delay_s) < SAME_S)
    stable, calm = (int(float(row[key])) for key in ("stable_N_per_m", "calm_N_per_m"))
    return f"{stable:,}/{calm:,} N/m".replace(" ", NO_BREAK)


def column_of(case):
    return next(n for n, longest_s in enumerate(DELAYS_S) if float(case["delay_s"]) <= longest_s + SAME_S)


def outcome_cell(outcomes):
    """How many came to rest; how many tripped or broke a promise, if any did. The rest was refused."""
    def count(names):
        return sum(outcome in names for outcome in outcomes)
    text = f"{count(AT_REST)} of {len(outcomes)}"
    for names, words in ((("tripped",), "let go"), (BROKEN, "**broken**")):
        text += f"; {count(names)} {words}" if count(names) else ""
    return text.replace(" ", NO_BREAK)


def block(measured):
    cases, zones = measured
    kinds = sorted({(int(case["motors"]), float(case["peak_force_N"])) for case in cases})
    cells = {(*kind, column): [] for kind in kinds for column in range(len(DELAYS_S))}
    for case in cases:
        cells[int(case["motors"]), float(case["peak_force_N"]), column_of(case)].append(case["outcome"])
    rows = [(f"{motors} motors, {force_N:g} N",
             [outcome_cell(cells[motors, force_N, column]) for column in range(len(DELAYS_S))])
            for motors, force_N in kinds]
    stiffness = [stiffness_cell(zones, delay_s) for delay_s in DELAYS_S]
    header = ["delay of the force"] + [f"to {1e3 * delay_s:g} ms" for delay_s in DELAYS_S]
    return tables.markdown(header, [("stable/calm below", stiffness), *rows])
