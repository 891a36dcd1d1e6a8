"""The README's table of the techniques for missing motors."""

import json

import result_tables as tables
from result_tables import BadInput

OPERATOR = "people2005"
# Name of the row, measure, factor and format.
ROWS = [("contact angle", "contact angle", 1, "%.1f deg"),
        ("penetration", "penetration", 1e3, "%.1f mm"),
        ("losses of contact", "losses of contact", 1, "%.1f"),
        ("missing force", "missing force", 1, "%.2f N"),
        ("port work", "port work", 1e3, "%.0f mJ")]
SHOWN = ("reference", "technique")


def read(folder):
    """The result, as measure_compare.py wrote it."""
    path = folder / f"{OPERATOR}.json"
    try:
        result = json.loads(path.read_text(encoding="utf-8"))
        block(result)
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise BadInput(f"{path}: expected a result of measure_compare.py ({error!r})") from error
    return result


def means_of(result, measure):
    """The rows of a measure, by strategy."""
    return {row["strategy"]: row for row in result["means"]
            if row["measure"] == measure and row["role"] in SHOWN}


def cell(row, factor, pattern):
    """Bold: the best technique or tied with it."""
    text = pattern % (factor * row["mean"])
    return f"**{text}**" if row["standing"] in ("best", "tied") else text


def head(result, strategy):
    """A star marks a strategy that completed too few trials."""
    row = next((row for row in result["strategies"] if row["strategy"] == strategy), None)
    return f"`{strategy}`" + (" (*)" if row and 10 * row["done"] < 9 * row["trials"] else "")


def listed(words):
    return words[0] if len(words) == 1 else ", ".join(words[:-1]) + " and " + words[-1]


def losses_sentence(result):
    """Where a4 loses to another technique; references are left out."""
    losses = {}
    for row in result["a4_losses"]:
        if row["role"] == "technique":
            losses.setdefault(row["measure"], []).append(f"`{row['strategy']}`")
    if not losses:
        return "A4 loses to no other technique by any measure."
    parts = [f"{measure} (to {listed(names)})" for measure, names in losses.items()]
    return f"A4 loses by {'; '.join(parts)}."


def block(result):
    strategies = list(means_of(result, ROWS[0][1]))
    rows = [(name, [cell(means_of(result, measure)[strategy], factor, pattern)
                    for strategy in strategies])
            for name, measure, factor, pattern in ROWS]
    table = tables.markdown([f"mean of {result['hands']} hands",
                             *(head(result, strategy) for strategy in strategies)], rows)
    return table + "\n\n" + losses_sentence(result)
