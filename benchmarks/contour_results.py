"""The tables of a hand without delay."""

import csv

import result_tables as tables
from result_tables import BadInput

OBJECTS = ("star", "labyrinth", "inverted_labyrinth", "lock")
RULES = ("nearest", "forward")
DURATIONS = ("27", "20")
STARTS = ("0", "45")
LEADING = "27"  # the duration of the table of the rules


def read(path):
    """{(object, rule, duration, start): mean in deg}, as write_contour_angles wrote them."""
    try:
        with open(path, encoding="utf-8", newline="") as file:
            means = {(row["object"], row["align"], row["duration_s"], row["start_orientation_deg"]):
                     float(row["mean_contact_angle_deg"]) for row in csv.DictReader(file)}
        block(means)
        return means
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise BadInput(f"{path}: expected a result of measure_contour_angles.py "
                       f"({error!r})") from error


def block(means):
    """A row for each object, a column for each rule and duration, and the two starts in a cell."""
    columns = [(rule, duration) for duration in DURATIONS for rule in RULES]
    rows = [(name.replace("_", " "),
             [" / ".join(f"{means[name, rule, duration, start]:.1f}" for start in STARTS)
              for rule, duration in columns])
            for name in OBJECTS]
    return tables.markdown(
        ["mean contact angle, deg; start at " + " / ".join(STARTS) + " deg"] +
        [f"`{rule}`, {duration} s" for rule, duration in columns], rows)


def reached(means, rule):
    """The range over objects and starts."""
    angles = [means[name, rule, LEADING, start] for name in OBJECTS for start in STARTS]
    return f"{min(angles):.1f} to {max(angles):.1f} deg"


def rules_block(means):
    """What the two rules of alignment alone give."""
    return tables.markdown(
        [f"a hand without delay, {LEADING} s", "mean contact angle of each object, least to greatest"],
        [("turns to the nearer end of the motor's axis (`--align nearest`, the default)",
          [reached(means, "nearest")]),
         ("turns to the positive end (`--align forward`), as Table 1's acos reads",
          [reached(means, "forward")])])
