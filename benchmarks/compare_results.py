"""The tables and the figure of the techniques for missing motors."""

import json

import result_tables as tables
from result_tables import BadInput

OPERATOR = "people2005"
# The tables: name of the column, measure, factor and format.
GROUPS = [
    [("contact angle", "contact angle", 1, "%.1f deg"),
     ("penetration", "penetration", 1e3, "%.1f mm"),
     ("losses of contact", "losses of contact", 1, "%.1f"),
     ("losses of 0.1 s", "losses of 0.1 s", 1, "%.1f")],
    [("missing force", "missing force", 1, "%.2f N"),
     ("ghost force", "ghost force", 1, "%.2f N"),
     ("total time", "total time", 1, "%.1f s"),
     ("timeouts", "timeouts", 100, "%.0f %%")],
    [("port work", "port work", 1e3, "%.0f mJ"),
     ("work lost", "work lost", 1e3, "%.0f mJ"),
     ("work along the wall", "work along the wall", 1e3, "%.0f mJ"),
     ("work of one contact", "work of one contact", 1e3, "%.0f mJ")],
    [("empty turns", "empty turns", 1, "%.1f"),
     ("mean drift", "mean drift", 1e3, "%.0f mm"),
     ("worst drift", "worst drift", 1e3, "%.0f mm"),
     ("governed ticks", "governed ticks", 100, "%.2f %%")],
    [("energy of turning", "energy of turning", 1e3, "%.0f mJ"),
     ("device travel", "device travel", 1e3, "%.0f mm")],
]
SHOWN = ("reference", "technique")
DRAWN = ("contact angle", "penetration", "losses of contact", "port work")


def read(folder):
    """The result, as measure_compare.py wrote it."""
    path = folder / f"{OPERATOR}.json"
    try:
        result = json.loads(path.read_text(encoding="utf-8"))
        block(result)
        losses_block(result)
        figure_table(result)
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise BadInput(f"{path}: expected a result of measure_compare.py ({error!r})") from error
    return result


def means_of(result, measure):
    """The rows of a measure, by strategy."""
    return {row["strategy"]: row for row in result["means"]
            if row["measure"] == measure and row["role"] in SHOWN}


def cell(row, factor, pattern):
    """Bold: the best technique or tied with it. A drift of a scene that turned has no meaning: "-"."""
    if row["mean"] is None:
        return "-"
    text = pattern % (factor * row["mean"])
    return f"**{text}**" if row["standing"] in ("best", "tied") else text


def head(result, strategy):
    """A star marks a strategy that completed too few trials."""
    row = next((row for row in result["strategies"] if row["strategy"] == strategy), None)
    return f"`{strategy}`" + (" (*)" if row and 10 * row["done"] < 9 * row["trials"] else "")


def figure_table(result):
    """What palpate.analysis.results.strategies draws."""
    keys = ("measure", "strategy", "role", "mean", "half_width", "minus_mask", "mask_half_width",
            "minus_a4", "a4_half_width")
    return [{key: row[key] for key in keys} for row in result["means"] if row["measure"] in DRAWN]


def measured(result, measure):
    """Name of the column, factor and format of a measure."""
    return next((name, *how) for group in GROUPS for name, key, *how in group if key == measure)


def table(result, group):
    """A row for each strategy, a column for each measure."""
    strategies = list(means_of(result, group[0][1]))
    rows = [(head(result, strategy), [cell(means_of(result, measure)[strategy], factor, pattern)
                                      for _, measure, factor, pattern in group])
            for strategy in strategies]
    return tables.markdown([f"mean of {result['hands']} hands", *(name for name, *_ in group)], rows)


def block(result):
    return "\n\n".join(table(result, group) for group in GROUPS) + beyond_lines(result)


def beyond_lines(result):
    """A paragraph on the strategies that left the workspace."""
    beyond = [row for row in result["strategies"] if row["beyond_workspace"] > 0]
    if not beyond:
        return f"\n\nNo strategy left the workspace of {result['workspace_m']:g} m."
    trials = "; ".join(f"`{row['strategy']}` in {row['beyond_workspace']} of {row['trials']} trials, by up to "
                       f"{1e3 * (row['largest_travel_m'] - result['workspace_m']):.0f} mm" for row in beyond)
    return f"\n\nBeyond the workspace of {result['workspace_m']:g} m: {trials}."


def losses_block(result):
    """Where a4 loses to another technique; references are left out."""
    losses = {}
    for row in result["a4_losses"]:
        if row["role"] == "technique":
            losses.setdefault(row["measure"], []).append(row["strategy"])
    if not losses:
        return "A4 loses to no other technique by any measure."
    rows = []
    for measure, names in losses.items():
        title, factor, pattern = measured(result, measure)
        means = means_of(result, measure)
        texts = {name: pattern % (factor * means[name]["mean"]) for name in ["a4", *names]}
        rows.append((title, [texts["a4"], ", ".join(f"`{name}` {texts[name]}" for name in names)]))
    return tables.markdown([f"mean of {result['hands']} hands", "`a4`", "techniques that are better"],
                           rows, words=3)
