"""The tables about the price of a unit of work, and the files that state the price."""

import csv
import math
import re

import result_tables as tables
from result_tables import BadInput

EFFECTS = ["none", "magnets", "media"]
# The longest tick of all inputs, with effects.
LONGEST_US = 500.0
# The sources that state the price, and the text before and after the number.
SOURCES = [("haptics/proxy/work.h", r"One unit takes at most (\d+) ns"),
           ("engine/session/run_setting.cpp", r"units of at most (\d+) ns")]
PAGE_PATTERN = r"(?:[Uu]nit takes|units of) at most (\d+) ns"  # of pages in docs


def read(folder):
    """{name of the processor: {(input, effects): row}}, as work_prices wrote them."""
    machines = {}
    for path in sorted(folder.glob("*.csv")):
        try:
            with open(path, encoding="utf-8", newline="") as file:
                cpu = file.readline()[2:].strip()
                rows = {(row["input"], row["effects"]): {
                    key: float(row[key]) for key in
                    ("size", "capped", "longest_us", "unit_ns", "dearest_unit_ns")}
                    for row in csv.DictReader(file)}
            machines[cpu] = rows
            block({cpu: rows})
        except (OSError, ValueError, KeyError, TypeError, IndexError) as error:
            raise BadInput(f"{path}: expected a result of work_prices ({error!r})") from error
    if not machines:
        raise BadInput(f"{folder}: no results of work_prices")
    return machines


def price_ns(rows):
    """The price of a unit: what it takes in the dearest capped tick, in whole nanoseconds, up."""
    return math.ceil(max(row["dearest_unit_ns"] for row in rows.values()))


def longest_us(rows):
    return max(row["longest_us"] for row in rows.values())


def inputs_of(rows):
    """(title, the rows of all effects) of each measured input."""
    return [(name, title, [rows[name, effects] for effects in EFFECTS])
            for name, title in tables.WORST if (name, "none") in rows]


def block(machines):
    parts = []
    for cpu, rows in machines.items():
        longest, units = [], []
        for name, title, found in inputs_of(rows):
            counted = "nodes" if name in tables.COUNTED_IN_NODES else "triangles"
            longest.append((title, [f"{found[0]['size']:,.0f} {counted}"] +
                            [f"{row['longest_us']:.0f}" for row in found]))
            units.append((title, [f"{row['unit_ns']:.1f}" if row["unit_ns"] else "-" for row in found]))
        parts += [tables.markdown(["longest tick, us", "size", "no effects", "magnets", "media"], longest),
                  tables.markdown(["time of a unit, ns", "no effects", "magnets", "media"], units),
                  f"On {cpu}, in the dearest capped tick, a unit takes at most {price_ns(rows)} ns. The "
                  f"longest tick takes {longest_us(rows):.0f} us."]
    return "\n\n".join(parts)


def statements(root):
    """(file, the prices that it states) of the sources and of each page that states one."""
    for name, pattern in SOURCES:
        yield root / name, re.findall(pattern, joined_lines(root / name))
    for path in sorted((root / "docs").rglob("*.md")):
        if found := re.findall(PAGE_PATTERN, joined_lines(path)):
            yield path, found


def joined_lines(path):
    try:
        return " ".join(path.read_text(encoding="utf-8").split())
    except OSError as error:
        raise BadInput(f"{path}: {error.strerror}") from error


def check(root, machines):
    """Raises BadInput if a file states another price, or if the results do not keep the bounds."""
    price = max(price_ns(rows) for rows in machines.values())
    for cpu, rows in machines.items():
        for (name, effects), row in rows.items():
            if row["longest_us"] > LONGEST_US:
                raise BadInput(f"{cpu}: the longest tick of {name}, {effects}, takes "
                               f"{row['longest_us']:.0f} us; expected at most {LONGEST_US:.0f}")
    for path, found in statements(root):
        if not found or set(found) != {str(price)}:
            raise BadInput(f"{path}: states the price of a unit as {found}; expected {price} ns, "
                           "from benchmarks/results/work")
