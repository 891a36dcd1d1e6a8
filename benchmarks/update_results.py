#!/usr/bin/env python3
"""Writes the README's measured tables from benchmarks/results, between two marker lines, and draws
the figures that they show.

update_readme.py [--check] [--readme FILE] [--results DIR]

--check changes nothing, draws nothing, and exits with 1 if a table or a figure is not what the results
say.
"""

import argparse
import json
import os
import pathlib
import sys

sys.dont_write_bytecode = True  # no folder beside the sources
import accuracy_results  # noqa: E402

BEGIN = "<!-- measured:begin -->"
END = "<!-- measured:end -->"
ROOT = pathlib.Path(__file__).resolve().parent.parent

# In the order of the table: benchmark, what it says in the README. Peers in italics.
ROWS = [
    ("tick_free", "tick, free motion"),
    ("tick_tapping", "tick, tapping"),
    ("tick_sliding", "tick, sliding"),
    ("tick_sliding_a4", "tick, sliding, A4 turning the scene"),
    ("tick_sliding_avx2", "tick, sliding, no AVX-512"),
    ("tick_sliding_sse2", "tick, sliding, SSE2 only"),
    ("tick_sliding_fast", "tick, sliding, `--accuracy fast`"),
    ("tick_sliding_exact", "tick, sliding, `--accuracy exact`"),
    ("tick_sliding_float", "tick, sliding, narrow phase in float"),
    ("tick_free_evicted", "tick, free motion, L1 and L2 evicted"),
    ("tick_tapping_evicted", "tick, tapping, L1 and L2 evicted"),
    ("tick_sliding_evicted", "tick, sliding, L1 and L2 evicted"),
    ("tick_sphere_sliding", "tick, sliding, sphere proxy of 1 mm"),
    ("tick_centre", "first 50 ticks at the sphere's centre"),
    ("tick_centre_pressed", "tick, pressed to the sphere's centre"),
    ("tick_teleport", "tick, random jumps across the sphere"),
    ("closest_point", "closest point"),
    ("stock_closest_point", "*Embree's own triangles (float)*"),
    ("cgal_closest_point", "*CGAL's AABB_tree with a hint*"),
    ("closest_point_evicted", "closest point, L1 and L2 evicted"),
    ("stock_closest_point_evicted", "*Embree's own triangles (float)*"),
    ("first_hit", "first hit of a segment"),
    ("stock_first_hit", "*Embree's own triangles (float)*"),
    ("cgal_first_hit", "*CGAL's AABB_tree, any hit*"),
    ("packs_near", "triangles near a point"),
]
STATISTICS = ["p50_ns", "p99_ns", "p999_ns", "max_ns"]

# Benchmark, its counter (a ratio of medians within one run), what it says in the README.
RATIOS = [
    ("tick_sliding", "vs_stock_p50", "sliding tick / Embree's closest point"),
    ("tick_sliding_evicted", "vs_stock_p50", "the same, L1 and L2 evicted"),
    ("closest_point", "vs_stock_p50", "closest point / Embree's"),
    ("closest_point_evicted", "vs_stock_p50", "the same, L1 and L2 evicted"),
    ("closest_point", "vs_cgal_p50", "closest point / CGAL's with a hint"),
    ("first_hit", "vs_stock_p50", "first hit / Embree's"),
    ("first_hit", "vs_cgal_p50", "first hit / CGAL's any hit"),
]

# Benchmark, its counter, decimals, what it says in the README.
LOADING = [
    ("load_glb", "median_ms", 0, "`.glb`, from open to first query, ms"),
    ("read_file", "median_ms", 1, "*reading the file, ms*"),
    ("openmesh_add_face", "median_ms", 0, "*OpenMesh's own `add_face`, ms*"),
    ("embree_build", "median_ms", 0, "*Embree's own triangles, ms*"),
    ("load_glb", "vs_parts", 2, "open to first query / the sum of those three"),
    ("load_glb", "bytes_per_triangle", 0, "memory, bytes a triangle"),
    ("load_glb", "resident_per_triangle", 0, "growth of the process, bytes a triangle"),
]

# Benchmark, its counter, what it says in the README, how.
INSTANCES = [
    ("load_instances", "median_ms", "from open to a compiled scene, ms", lambda v: f"{v:.1f}"),
    ("load_instances", "memory_bytes", "memory, MB", lambda v: f"{v / 1e6:.1f}"),
    ("instances_sliding", "p50_ns", "step of the sliding proxy, us", lambda v: microseconds(v)),
    ("instances_sliding_searched", "p50_ns", "the same, each searched for from scratch, us",
     lambda v: microseconds(v)),
]
INSTANCE_COUNTS = ["1x", "10000x"]

# What of tick_sliding_with_<effect>, how, and what it says in the README.
EFFECTS = [(effect, "marginal_ns", "{:+.0f}", effect + ", ns") for effect in (
    "stiffness", "damping", "friction", "texture", "shading", "vibration", "restitution", "magnet",
    "viscosity", "gravity")] + [
    ("all", "vs_bare", "{:.2f}", "all of them / none"),
    ("elsewhere", "vs_bare", "{:.2f}", "all of them on what is not touched / none")]

SCANS = [(f"scan_{proxy}{suffix}", title + caches)
         for proxy, title in (("point", "point"), ("sphere_0.1mm", "sphere of 0.1 mm"),
                              ("sphere_1mm", "sphere of 1 mm"), ("sphere_5mm", "sphere of 5 mm"))
         for suffix, caches in (("", ""), ("_evicted", ", L1 and L2 evicted"))]
SCAN_SIZES = ["100k", "500k", "1.6M", "6M"]

# Inputs of worst_<input>, and what the README calls them.
WORST = [
    ("through_one_point", "all triangles through one point"),
    ("through_one_point_sphere", "the same, sphere of 1 mm"),
    ("stack_in_one_mesh", "sheets on one another, in one mesh"),
    ("stack_of_bodies", "nodes on one another"),
    ("dense_soup", "dense soup"),
    ("dense_soup_sphere", "the same, sphere of 1 mm"),
    ("needles_in_doubt", "needles whose signs are in doubt"),
    ("needles_in_doubt_sphere", "the same, sphere of 1 mm"),
    ("sphere_as_large_as_the_scene", "a sphere as large as the scene"),
    ("moving_bodies", "nodes that close in on the hand"),
    ("start_in_a_cluster", "a start inside a cluster"),
    ("start_in_a_cluster_sphere", "the same, sphere of 1 mm"),
    ("jumps_across", "jumps across a sphere"),
    ("jumps_across_sphere", "the same, sphere of 1 mm"),
]
WORST_KINDS = [("", "warm"), ("_evicted", "L1 and L2 evicted"), ("_magnets", "*magnets*"),
               ("_media", "*media*")]

SIDE_TESTS = [("side_test_float128", "113 bits in software"), ("side_test_adaptive", "expansions"),
              ("side_test_cgal", "CGAL's kernel")]
SIDE_CLASSES = [("easy", "easy"), ("near", "double fails"), ("exact", "exactly zero"),
                ("hidden", "113 bits fail")]


class BadInput(Exception):
    """A file that is not what it should be; the message is for the user."""


def read_result(path):
    """The context, {(workload, triangles or class of inputs): counters} and {(knob, method, level):
    counters} of one file of Google Benchmark."""
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
        context = document["context"]
        for key in ("cpu", "compiler", "flags", "commit", "num_cpus", "mhz_per_cpu", "date"):
            context[key]
        runs, knobs = {}, {}
        for run in document["benchmarks"]:
            workload, subject = run["name"].split("/")[:2]
            if run.get("error_occurred"):
                raise BadInput(f"{path}: {workload} failed: {run.get('error_message')}")
            place = accuracy_results.read_row(run)
            if place:
                knobs[place] = run
                continue
            if subject.isdigit():
                subject = int(subject)
                is_loading = any(workload == name for name, _, _, _ in LOADING)
                for key in ["median_ms"] if is_loading else STATISTICS + ["clock_ns"]:
                    run[key]
            runs[workload, subject] = run
        if not sizes_of(runs):
            raise BadInput(f"{path}: no workload on a sphere in it")
        return context, runs, knobs
    except (OSError, ValueError, KeyError) as error:
        raise BadInput(f"{path}: not a result of benchmarks/run.sh ({error!r})") from error


def microseconds(time_ns):
    """Three digits, and no more than two decimals: the clock counts in steps of 10 ns."""
    time_us = time_ns / 1000
    return f"{time_us:.{0 if time_us >= 100 else 1 if time_us >= 10 else 2}f}"


def sizes_of(runs):
    """Triangles of the spheres."""
    return sorted({subject for workload, subject in runs
                   if isinstance(subject, int) and not workload.startswith("worst_")})


def size_name(triangles):
    return f"{triangles / 1e6:.1f}M" if triangles >= 1e6 else f"{triangles / 1e3:.0f}k"


def machine_line(context, runs):
    clock_ns = max(run["clock_ns"] for run in runs.values() if "clock_ns" in run)
    return (
        f"{context['cpu']}, {context['num_cpus']} cores at {context['mhz_per_cpu'] / 1000:.1f} GHz; "
        f"{context['compiler']}, `{context['flags']}`; commit {context['commit']}, "
        f"{context['date'][:10]}. Microseconds: median / 99 % / 99.9 % / worst over the samples of "
        f"a path, each sample the shortest of six passes, less the {clock_ns:.0f} ns of the clock "
        "itself."
    )


def table(runs):
    sizes = sizes_of(runs)
    lines = ["| triangles | " + " | ".join(size_name(size) for size in sizes) + " |",
             "|---|" + "---:|" * len(sizes)]
    for workload, title in ROWS:
        cells = [" / ".join(microseconds(runs[workload, size][key]) for key in STATISTICS)
                 if (workload, size) in runs else "-" for size in sizes]
        if any(cell != "-" for cell in cells):
            lines.append(f"| {title} | " + " | ".join(cells) + " |")
    return lines


def growth_cells(runs, workload):
    """The median at each size over that at the size before."""
    medians = [runs.get((workload, size), {}).get("p50_ns") for size in sizes_of(runs)]
    return ["-"] + [f"{larger / smaller:.2f}" if smaller and larger else "-"
                    for smaller, larger in zip(medians, medians[1:])]


def ratio_table(runs):
    sizes = sizes_of(runs)
    rows = []
    for workload, counter, title in RATIOS:
        ratios = [runs.get((workload, size), {}).get(counter) for size in sizes]
        rows.append((title, ["-" if ratio is None else f"{ratio:.2f}" for ratio in ratios]))
    rows.append(("sliding tick / at the size before", growth_cells(runs, "tick_sliding")))
    rows = [row for row in rows if any(cell != "-" for cell in row[1])]
    if not rows:
        return ""
    lines = ["| ratio of medians | " + " | ".join(size_name(size) for size in sizes) + " |",
             "|---|" + "---:|" * len(sizes)]
    return "\n".join(lines + [f"| {title} | " + " | ".join(cells) + " |" for title, cells in rows])


def loading_table(runs):
    sizes = [size for size in sizes_of(runs) if ("load_glb", size) in runs]
    if not sizes:
        return ""
    lines = ["| Loading | " + " | ".join(size_name(size) for size in sizes) + " |",
             "|---|" + "---:|" * len(sizes)]
    for workload, counter, decimals, title in LOADING:
        values = [runs.get((workload, size), {}).get(counter) for size in sizes]
        cells = ["-" if value is None else f"{value:.{decimals}f}" for value in values]
        lines.append(f"| {title} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def effect_table(runs):
    sizes = sorted({size for name, size in runs if name.startswith("tick_sliding_with_")})
    if not sizes:
        return ""
    lines = ["| what effects add to the mean sliding tick | " +
             " | ".join(size_name(size) for size in sizes) + " |", "|---|" + "---:|" * len(sizes)]
    for effect, counter, text, title in EFFECTS:
        values = [runs.get(("tick_sliding_with_" + effect, size), {}).get(counter)
                  for size in sizes]
        cells = ["-" if value is None else text.format(value) for value in values]
        lines.append(f"| {title} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def instance_table(runs):
    if ("load_instances", INSTANCE_COUNTS[-1]) not in runs:
        return ""
    lines = ["| Instances of a sphere of 1,280 triangles | one | 10,000 |", "|---|---:|---:|"]
    for workload, counter, title, text in INSTANCES:
        values = [runs.get((workload, count), {}).get(counter) for count in INSTANCE_COUNTS]
        cells = ["-" if value is None else text(value) for value in values]
        lines.append(f"| {title} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def sphere_line(runs):
    parts = []
    for size in sizes_of(runs):
        under = runs.get(("tick_sphere_sliding", size), {}).get("triangles_under_proxy")
        if under is not None:
            parts.append(f"{under:.0f} at {size_name(size)}")
    return ("Triangles within 1 mm of the point where the sphere proxy touches: " +
            ", ".join(parts) + ".") if parts else ""


def scan_table(runs):
    sizes = [size for size in SCAN_SIZES if any((name, size) in runs for name, _ in SCANS)]
    if not sizes:
        return ""
    lines = ["| tick on a scanned housing, triangles | " + " | ".join(sizes) + " |",
             "|---|" + "---:|" * len(sizes)]
    for workload, title in SCANS:
        cells = [" / ".join(microseconds(runs[workload, size][key]) for key in STATISTICS)
                 if (workload, size) in runs else "-" for size in sizes]
        lines.append(f"| {title} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def worst_table(runs):
    found = {(workload, kind): (size, runs["worst_" + workload + kind, size])
             for workload, _ in WORST for kind, _ in WORST_KINDS
             for name, size in runs if name == "worst_" + workload + kind}
    if not found:
        return ""
    lines = ["| worst tick, us; effects are not in the budget | size | " +
             " | ".join(title for _, title in WORST_KINDS) + " |",
             "|---|" + "---:|" * (1 + len(WORST_KINDS))]
    for workload, title in WORST:
        rows = [found.get((workload, kind)) for kind, _ in WORST_KINDS]
        if not any(rows):
            continue
        size = next(f"{row[0]:,}" for row in rows if row)
        cells = [microseconds(row[1]["max_ns"]) if row else "-" for row in rows]
        lines.append(f"| {title} | {size} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def side_test_table(runs):
    if not all((way, name) in runs for way, _ in SIDE_TESTS for name, _ in SIDE_CLASSES):
        return ""

    def cell(way, name):
        run = runs[way, name]
        undecided = ", undecided" if run["undecided"] else ""
        return f"{run['call_ns']:.0f}{undecided}"
    lines = ["| on which side of an edge a line passes, ns | " +
             " | ".join(title for _, title in SIDE_CLASSES) + " |",
             "|---|" + "---:|" * len(SIDE_CLASSES)]
    for way, title in SIDE_TESTS:
        lines.append(f"| {title} | " + " | ".join(cell(way, name) for name, _ in SIDE_CLASSES) +
                     " |")
    return "\n".join(lines)


def objects_table(path):
    """The paper's objects, without and with A4: what measure_objects.py kept."""
    try:
        objects = json.loads(path.read_text(encoding="utf-8"))
        lines = ["| one turn round | mean contact angle | contact within 30 deg | mean penetration "
                 "| in contact | contour completed | losses of contact | energy that the device gives |",
                 "|---|---:|---:|---:|---:|---:|---:|---:|"]
        for name, (off, on) in objects.items():
            def pair(pattern, key, scale):
                return " -> ".join(pattern % (scale * run[key]) for run in (off, on))
            lines.append(f"| {name.replace('_', ' ')} | "
                         f"{pair('%.1f', 'mean_contact_angle_deg', 1)} deg | "
                         f"{pair('%.0f', 'share_within_30deg', 100)} % | "
                         f"{pair('%.2f', 'mean_penetration_m', 1000)} mm | "
                         f"{pair('%.0f', 'contact_share', 100)} % | "
                         f"{pair('%.0f', 'way_share', 100)} % | "
                         f"{pair('%.0f', 'losses_of_contact', 1)} | "
                         f"{pair('%.0f', 'port_work_J', 1000)} mJ |")
    except (OSError, ValueError, KeyError) as error:
        raise BadInput(f"{path}: not a result of measure_objects.py ({error!r})") from error
    return ("Without -> with A4: a simulated hand on a device with two sensors and one motor, once "
            "round each of the paper's objects in 27 s (with ten people, the paper measured 49.4 -> "
            "32.1 deg).\n\n" + "\n".join(lines) +
            "\n\nA4 makes one thing worse: the device gives energy. A hand that presses by d at an "
            "angle a to the motor is charged for K d^2 cos^2(a) / 2 only, and gets up to K d^2 / 2 "
            "back when it lets go after the scene has turned. Contact is lost at corners, without "
            "A4 and with it, about as often.")


def figure_of(result_path):
    return result_path.parent / result_path.stem / "accuracy.svg"


def figure_line(knobs, result_path, readme):
    if not accuracy_results.script(knobs):
        return ""
    where = pathlib.Path(os.path.relpath(figure_of(result_path), readme.resolve().parent))
    return f"![Error against time of the main knobs; rings mark defaults.]({where.as_posix()})"


def update_figures(results_directory, check):
    """Draws what is missing or was drawn from something else, and removes what is of nothing."""
    for path in sorted(results_directory.glob("*.json")):
        figure = figure_of(path)
        script = accuracy_results.script(read_result(path)[2])
        if accuracy_results.is_figure_of(script, figure) if script else not figure.exists():
            continue
        if check:
            raise BadInput(f"{figure}: is not what {path.name} says; run benchmarks/update_readme.py")
        try:
            if script:
                accuracy_results.draw(script, figure)
            else:
                figure.unlink()
        except OSError as error:
            raise BadInput(f"{figure}: {error}; is gnuplot-nox installed?") from error
        print(f"{'drew' if script else 'removed'} {figure}")


def generate(results_directory, readme):
    paths = sorted(results_directory.glob("*.json"))
    if not paths:
        raise BadInput(f"{results_directory}: no results; benchmarks/run.sh makes them")
    sections = [objects_table(results_directory / "paper_objects" / "objects.json")]
    for path in paths:
        context, runs, knobs = read_result(path)
        parts = [machine_line(context, runs), "\n".join(table(runs)), sphere_line(runs),
                 ratio_table(runs), scan_table(runs), worst_table(runs), effect_table(runs),
                 loading_table(runs), instance_table(runs), side_test_table(runs), accuracy_results.table(knobs),
                 figure_line(knobs, path, readme)]
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
        fresh = replace_between_markers(text, generate(options.results.resolve(), options.readme),
                                        options.readme)
        update_figures(options.results.resolve(), options.check)
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
