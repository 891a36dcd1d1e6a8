"""The tables and the figure of the budgets of a4-passive."""

import json

import result_tables as tables
from result_tables import BadInput

NAME = "a4_passive.json"
PREFIX = "a4-passive:"
# Name of the column, measure, factor and format.
GROUPS = [
    [("penetration", "penetration", 1e3, "%.2f mm"),
     ("contact angle", "contact angle", 1, "%.1f deg"),
     ("missing force", "missing force", 1, "%.2f N")],
    [("energy of turning", "energy of turning", 1e3, "%.0f mJ"),
     ("port work", "port work", 1e3, "%.0f mJ"),
     ("work along the wall", "work along the wall", 1e3, "%.0f mJ"),
     ("work of one contact", "work of one contact", 1e3, "%.0f mJ")],
]


def read(folder):
    """The result, as measure_passive_budgets.py wrote it."""
    path = folder / NAME
    try:
        result = json.loads(path.read_text(encoding="utf-8"))
        block(result)
        presses_block(result)
        figure_table(result)
    except (OSError, ValueError, KeyError, TypeError, ZeroDivisionError) as error:
        raise BadInput(f"{path}: expected a result of measure_passive_budgets.py ({error!r})") from error
    return result


def means_of(result, measure):
    """{strategy: mean}."""
    return {row["strategy"]: row["mean"] for row in result["means"] if row["measure"] == measure}


def strategies_of(result):
    """mask, the budgets in their order, and a4, which has no limit."""
    budgets = [name for name in means_of(result, "penetration") if name.startswith(PREFIX)]
    return ["mask", *budgets, "a4"]


def shares(depths):
    """{strategy: part of a4's gain in penetration over mask}."""
    whole = depths["mask"] - depths["a4"]
    return {name: (depths["mask"] - depth) / whole for name, depth in depths.items()}


def gains(result):
    """On ways round the objects."""
    return shares(means_of(result, "penetration"))


def pauses_of(result):
    """Before each press, s, the longest first."""
    return sorted({row["pause_s"] for row in result["presses"]}, reverse=True)


def presses_of(result, pause_s, key):
    return {row["strategy"]: row[key] for row in result["presses"] if row["pause_s"] == pause_s}


def rounded(pattern, value):
    """Without the sign of a value that rounds to zero."""
    text = pattern % value
    return text.lstrip("+-") if float(text.split()[0]) == 0.0 else text


def paired_cell(row):
    if row["half_width_m"] == 0.0:
        return "0"
    return f"{rounded('%+.2f', 1e3 * row['minus_0_m'])} ± {1e3 * row['half_width_m']:.2f} mm"


def block(result):
    share = gains(result)
    paired = {row["strategy"]: row for row in result["paired"]}
    parts = []
    for group in GROUPS:
        with_gain = group is GROUPS[0]
        rows = []
        for name in strategies_of(result):
            cells = [rounded(pattern, factor * means_of(result, measure)[name])
                     for _, measure, factor, pattern in group]
            if with_gain:
                cells[1:1] = ["%.0f %%" % (100 * share[name]), paired_cell(paired[name])]
            rows.append((f"`{name}`", cells))
        titles = [title for title, *_ in group]
        if with_gain:
            titles[1:1] = ["gain", f"penetration less that of `{PREFIX}0`"]
        parts.append(tables.markdown([f"mean of {result['hands']} hands", *titles], rows))
    return "\n\n".join(parts)


def presses_block(result):
    """Presses of walls: a row for each strategy, three columns for each pause."""
    pauses = pauses_of(result)
    rows = []
    for name in strategies_of(result):
        cells = []
        for pause_s in pauses:
            depths = presses_of(result, pause_s, "depth_m")
            energies = presses_of(result, pause_s, "turning_energy_J")
            cells += [f"{1e3 * depths[name]:.2f} mm", f"{100 * shares(depths)[name]:.0f} %",
                      f"{1e3 * energies[name]:.1f} mJ"]
        rows.append((f"`{name}`", cells))
    titles = [title for pause_s in pauses
              for title in (f"{pause_s:g} s apart: depth", "gain", "energy of turning")]
    return tables.markdown(["mean of 17 presses", *titles], rows)


def curves_of(result):
    """Title, {strategy: share of that of a4}."""
    energies = means_of(result, "energy of turning")
    longest, shortest = pauses_of(result)
    return ((f"gain, presses {longest:g} s apart", shares(presses_of(result, longest, "depth_m"))),
            (f"gain, presses {shortest:g} s apart", shares(presses_of(result, shortest, "depth_m"))),
            ("gain, ways", gains(result)),
            ("energy of turning, ways",
             {name: energy / energies["a4"] for name, energy in energies.items()}))


def figure_table(result):
    """What palpate.analysis.results.budgets draws: the gains and the energy of turning as shares of
    those of a4, over the budget."""
    return [{"curve": title, "budget_mJ": float(name.removeprefix(PREFIX)), "share": share[name]}
            for title, share in curves_of(result)
            for name in strategies_of(result) if name.startswith(PREFIX)]
