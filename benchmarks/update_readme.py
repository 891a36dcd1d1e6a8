#!/usr/bin/env python3
"""Writes the README's measured tables from benchmarks/results, between two marker lines.

update_readme.py [--check] [--readme FILE] [--results DIR]

--check changes nothing and exits with 1 if the table is not what the results say.
"""

import argparse
import json
import pathlib
import sys

BEGIN = "<!-- measured:begin -->"
END = "<!-- measured:end -->"
ROOT = pathlib.Path(__file__).resolve().parent.parent

# In the order of the table: benchmark, what it says in the README.
ROWS = [
    ("tick_free", "haptic tick, free motion"),
    ("tick_tapping", "haptic tick, tapping"),
    ("tick_sliding", "haptic tick, sliding"),
    ("tick_sliding_a4", "haptic tick, sliding, A4 turning the scene"),
    ("closest_point", "closest point"),
    ("first_hit", "first hit of a segment"),
    ("packs_near", "triangles near a point"),
    ("stock_closest_point", "*closest point, Embree's own triangles (float)*"),
    ("stock_first_hit", "*first hit, Embree's own triangles (float)*"),
]
STATISTICS = [("p50_ns", "p50"), ("p99_ns", "p99"), ("max_ns", "max")]


class BadInput(Exception):
    """A file that is not what it should be; the message is for the user."""


def read_result(path):
    """The context and {(workload, triangles): counters} of one file of Google Benchmark."""
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
        context = document["context"]
        for key in ("cpu", "compiler", "flags", "commit", "num_cpus", "mhz_per_cpu", "date"):
            context[key]
        runs = {}
        for run in document["benchmarks"]:
            workload, triangles = run["name"].split("/")[:2]
            if run.get("error_occurred"):
                raise BadInput(f"{path}: {workload} failed: {run.get('error_message')}")
            runs[workload, int(triangles)] = run
        return context, runs
    except (OSError, ValueError, KeyError) as error:
        raise BadInput(f"{path}: not a result of benchmarks/run.sh ({error!r})") from error


def microseconds(time_ns):
    """The clock counts in steps of 10 ns, so two decimals say all there is."""
    return f"{time_ns / 1000:.2f}"


def size_name(triangles):
    return f"{triangles / 1e6:.1f}M" if triangles >= 1e6 else f"{triangles / 1e3:.0f}k"


def machine_line(context, runs):
    clock_ns = max(run["clock_ns"] for run in runs.values())
    return (
        f"{context['cpu']}, {context['num_cpus']} cores at {context['mhz_per_cpu'] / 1000:.1f} GHz; "
        f"{context['compiler']}, `{context['flags']}`; commit {context['commit']}, "
        f"{context['date'][:10]}. Microseconds, the clock's own {clock_ns:.0f} ns included."
    )


def table(runs):
    sizes = sorted({triangles for _, triangles in runs})
    heads = [f"{size_name(size)}: {title}" if title == "p50" else title
             for size in sizes for _, title in STATISTICS]
    lines = ["| triangles | " + " | ".join(heads) + " |",
             "|---|" + "---:|" * len(heads)]
    for workload, title in ROWS:
        cells = [microseconds(runs[workload, size][key]) if (workload, size) in runs else "-"
                 for size in sizes for key, _ in STATISTICS]
        lines.append(f"| {title} | " + " | ".join(cells) + " |")
    return lines


def ratio_line(runs):
    """How much of the peer's time a closest point takes, at the median."""
    parts = []
    for size in sorted({triangles for _, triangles in runs}):
        ours, peer = (runs.get((name, size)) for name in ("closest_point", "stock_closest_point"))
        if ours and peer:
            parts.append(f"{ours['p50_ns'] / peer['p50_ns']:.2f} at {size_name(size)}")
    return ("Time of a closest point, in double, relative to Embree's point query on its own float "
            "triangles (p50): " + ", ".join(parts) + ".") if parts else ""


def objects_table(path):
    """The paper's objects, without and with A4: what measure_objects.py kept."""
    try:
        objects = json.loads(path.read_text(encoding="utf-8"))
        lines = ["| one turn round | mean contact angle | contact within 30 deg | mean penetration |",
                 "|---|---:|---:|---:|"]
        for name, (off, on) in objects.items():
            def pair(pattern, key, scale):
                return " -> ".join(pattern % (scale * run[key]) for run in (off, on))
            lines.append(f"| {name.replace('_', ' ')} | "
                         f"{pair('%.1f', 'mean_contact_angle_deg', 1)} deg | "
                         f"{pair('%.0f', 'share_within_30deg', 100)} % | "
                         f"{pair('%.2f', 'mean_penetration_m', 1000)} mm |")
    except (OSError, ValueError, KeyError) as error:
        raise BadInput(f"{path}: not a result of measure_objects.py ({error!r})") from error
    return ("Without -> with A4: a simulated hand on a device with two sensors and one motor, once "
            "round each of the paper's objects in 27 s (with ten people, the paper measured 49.4 -> "
            "32.1 deg).\n\n" + "\n".join(lines))


def generate(results_directory):
    paths = sorted(results_directory.glob("*.json"))
    if not paths:
        raise BadInput(f"{results_directory}: no results; benchmarks/run.sh makes them")
    sections = [objects_table(results_directory / "paper_objects" / "objects.json")]
    for path in paths:
        context, runs = read_result(path)
        parts = [machine_line(context, runs), "\n".join(table(runs)), ratio_line(runs)]
        sections.append("\n\n".join(part for part in parts if part))
    return "\n\n".join(sections)


def replace_between_markers(text, content, path):
    if text.count(BEGIN) != 1 or text.count(END) != 1 or text.index(BEGIN) > text.index(END):
        raise BadInput(f"{path}: expected one line {BEGIN} and after it one line {END}, "
                       "to put the table between")
    before, rest = text.split(BEGIN)
    return f"{before}{BEGIN}\n{content}\n{END}{rest.split(END)[1]}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="change nothing, only compare")
    parser.add_argument("--readme", type=pathlib.Path, default=ROOT / "README.md")
    parser.add_argument("--results", type=pathlib.Path, default=ROOT / "benchmarks" / "results")
    options = parser.parse_args()
    try:
        try:
            text = options.readme.read_text(encoding="utf-8")
        except OSError as error:
            raise BadInput(f"{options.readme}: {error.strerror}") from error
        fresh = replace_between_markers(text, generate(options.results), options.readme)
        if fresh == text:
            return 0
        if options.check:
            raise BadInput(f"{options.readme}: the table between {BEGIN} and {END} is not what the "
                           "results say; run benchmarks/update_readme.py")
        options.readme.write_text(fresh, encoding="utf-8")
        print(f"wrote the table of {options.readme}")
        return 0
    except BadInput as error:
        print(error, file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
