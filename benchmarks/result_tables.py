"""Reads the files of benchmarks/results and makes Markdown tables from them."""

import json

import accuracy_results


class BadInput(Exception):
    """A file with unexpected content; the message is for the user."""


# Benchmark and the name of its row. Peers are in italics.
TICKS = [
    ("tick_free", "free motion"),
    ("tick_tapping", "tapping"),
    ("tick_sliding", "sliding"),
    ("tick_sliding_a4", "sliding, A4 turns the scene"),
    ("tick_sliding_avx2", "sliding, no AVX-512"),
    ("tick_sliding_sse2", "sliding, SSE2 only"),
    ("tick_sliding_fast", "sliding, `--accuracy fast`"),
    ("tick_sliding_exact", "sliding, `--accuracy exact`"),
    ("tick_sliding_float", "sliding, narrow phase in float"),
    ("tick_free_evicted", "free motion, L1 and L2 evicted"),
    ("tick_tapping_evicted", "tapping, L1 and L2 evicted"),
    ("tick_sliding_evicted", "sliding, L1 and L2 evicted"),
    ("tick_sphere_sliding", "sliding, sphere proxy of 1 mm"),
    ("tick_centre", "first 50 ticks of a hand that starts at the sphere's centre"),
    ("tick_centre_pressed", "pressing towards the sphere's centre"),
    ("tick_teleport", "random jumps across the sphere"),
]
QUERIES = [
    ("closest_point", "closest point"),
    ("stock_closest_point", "*closest point, Embree's own triangles (float)*"),
    ("cgal_closest_point", "*closest point, CGAL's AABB_tree with a hint*"),
    ("closest_point_evicted", "closest point, L1 and L2 evicted"),
    ("stock_closest_point_evicted",
     "*closest point, Embree's own triangles (float), L1 and L2 evicted*"),
    ("first_hit", "first hit of a segment"),
    ("stock_first_hit", "*first hit of a segment, Embree's own triangles (float)*"),
    ("cgal_first_hit", "*any hit of a segment, CGAL's AABB_tree*"),
    ("packs_near", "triangles near a point"),
]
STATISTICS = ["p50_ns", "p99_ns", "p999_ns", "max_ns"]

# Benchmark, its counter (a ratio of medians within one run), the name of the row.
RATIOS = [
    ("tick_sliding", "vs_stock_p50", "sliding tick / *Embree's closest point*"),
    ("tick_sliding_evicted", "vs_stock_p50",
     "sliding tick / *Embree's closest point*, L1 and L2 evicted"),
    ("closest_point", "vs_stock_p50", "closest point / *Embree's closest point*"),
    ("closest_point_evicted", "vs_stock_p50",
     "closest point / *Embree's closest point*, L1 and L2 evicted"),
    ("closest_point", "vs_cgal_p50", "closest point / *CGAL's closest point with a hint*"),
    ("first_hit", "vs_stock_p50", "first hit / *Embree's first hit*"),
    ("first_hit", "vs_cgal_p50", "first hit / *CGAL's any hit*"),
]

# Benchmark, its counter, decimals, the name of the row.
LOADING = [
    ("load_glb", "median_ms", 0, "opening a `.glb`, up to the first answer, ms"),
    ("read_file", "median_ms", 1, "*reading the file, ms*"),
    ("openmesh_add_face", "median_ms", 0, "*OpenMesh's own `add_face`, ms*"),
    ("embree_build", "median_ms", 0, "*building Embree's own triangles, ms*"),
    ("load_glb", "vs_parts", 2, "first row / sum of the three rows in italics"),
    ("load_glb", "bytes_per_triangle", 0, "memory counted by the scene, bytes per triangle"),
    ("load_glb", "resident_per_triangle", 0, "growth of the process's memory, bytes per triangle"),
]

# Benchmark, its counter, the name of the row, the text of a value.
INSTANCES = [
    ("load_instances", "median_ms", "opening the file and compiling the scene, ms",
     lambda v: f"{v:.1f}"),
    ("load_instances", "memory_bytes", "memory, MB", lambda v: f"{v / 1e6:.1f}"),
    ("instances_sliding", "p50_ns", "proxy update while sliding, us", lambda v: microseconds(v)),
    ("instances_sliding_searched", "p50_ns",
     "proxy update while sliding, without candidates kept between ticks, us", lambda v: microseconds(v)),
]
INSTANCE_COUNTS = ["1x", "10000x"]

# Effect of tick_sliding_with_<effect>, its counter, the text of a value, the name of the row.
EFFECTS = [(effect, "marginal_ns", "{:+.0f}", effect + ", ns") for effect in (
    "stiffness", "damping", "friction", "texture", "shading", "vibration", "restitution", "magnet",
    "viscosity", "gravity")] + [
    ("all", "vs_bare", "{:.2f}", "tick with all effects / tick without effects"),
    ("elsewhere", "vs_bare", "{:.2f}",
     "tick with all effects on untouched surfaces / tick without effects")]

SCANS = [(f"scan_{proxy}{suffix}", title + caches)
         for proxy, title in (("point", "point proxy"), ("sphere_0.1mm", "sphere proxy of 0.1 mm"),
                              ("sphere_1mm", "sphere proxy of 1 mm"),
                              ("sphere_5mm", "sphere proxy of 5 mm"))
         for suffix, caches in (("", ""), ("_evicted", ", L1 and L2 evicted"))]
SCAN_SIZES = ["100k", "500k", "1.6M", "6M"]

# Inputs of worst_<input> and the names of their rows.
WORST = [
    ("through_one_point", "all triangles share one point"),
    ("through_one_point_sphere", "all triangles share one point, sphere proxy of 1 mm"),
    ("through_one_point_large_sphere", "all triangles share one point, sphere proxy of 30 mm"),
    ("instances_at_one_point", "instances that share one point"),
    ("instances_at_one_point_sphere", "instances that share one point, sphere proxy of 1 mm"),
    ("stretched_instances_at_one_point", "stretched instances that share one point"),
    ("stack_in_one_mesh", "coincident sheets in one mesh"),
    ("stack_of_bodies", "coincident nodes"),
    ("dense_soup", "dense soup of intersecting triangles"),
    ("dense_soup_sphere", "dense soup of intersecting triangles, sphere proxy of 1 mm"),
    ("needles_in_doubt", "needle triangles in the plane of motion"),
    ("needles_in_doubt_sphere", "needle triangles in the plane of motion, sphere proxy of 1 mm"),
    ("sphere_as_large_as_the_scene", "sphere proxy as large as the scene"),
    ("moving_bodies", "moving nodes that close in on the proxy"),
    ("start_in_a_cluster", "start inside a dense cluster"),
    ("start_in_a_cluster_sphere", "start inside a dense cluster, sphere proxy of 1 mm"),
    ("jumps_across", "jumps across a sphere"),
    ("jumps_across_sphere", "jumps across a sphere, sphere proxy of 1 mm"),
]
COUNTED_IN_NODES = {"stack_of_bodies", "moving_bodies", "instances_at_one_point",
                    "instances_at_one_point_sphere", "stretched_instances_at_one_point"}
WORST_KINDS = [("", "warm caches, us"), ("_evicted", "L1 and L2 evicted, us")]

SIDE_TESTS = [("side_test_float128", "113-bit floating point in software"),
              ("side_test_adaptive", "expansions of doubles (used)"),
              ("side_test_cgal", "*CGAL's exact predicates*")]
SIDE_CLASSES = [("easy", "double decides"), ("near", "double cannot decide"),
                ("exact", "exactly zero"), ("hidden", "113 bits cannot decide")]


# Files

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
            row = accuracy_results.read_row(run)
            if row:
                knobs[row] = run
                continue
            if subject.isdigit():
                subject = int(subject)
                is_loading = any(workload == name for name, _, _, _ in LOADING)
                for key in ["median_ms"] if is_loading else STATISTICS + ["clock_ns"]:
                    run[key]
            runs[workload, subject] = run
        if not sizes_of(runs):
            raise BadInput(f"{path}: expected a benchmark on a sphere, found none")
        return context, runs, knobs
    except (OSError, ValueError, KeyError) as error:
        raise BadInput(f"{path}: not a result of benchmarks/run.sh ({error!r})") from error


def read_objects(path):
    """The paper's objects: {name: (figures without A4, figures with A4)}."""
    try:
        objects = json.loads(path.read_text(encoding="utf-8"))
        for off, on in objects.values():
            for key in ("mean_contact_angle_deg", "share_within_30deg", "mean_penetration_m",
                        "contact_share", "way_share", "losses_of_contact", "port_work_J"):
                off[key] + on[key]
        return objects
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise BadInput(f"{path}: not a result of measure_objects.py ({error!r})") from error


# Cells

def microseconds(time_ns):
    """Three digits and at most two decimals: the clock counts in steps of 10 ns."""
    time_us = time_ns / 1000
    return f"{time_us:.{0 if time_us >= 100 else 1 if time_us >= 10 else 2}f}"


def sizes_of(runs):
    """Triangles of the spheres."""
    return sorted({subject for workload, subject in runs
                   if isinstance(subject, int) and not workload.startswith("worst_")})


def size_name(triangles):
    return f"{triangles / 1e6:.1f}M" if triangles >= 1e6 else f"{triangles / 1e3:.0f}k"


def markdown(header, rows, words=1):
    """header: the cells of the first line; rows: (title, cells). Rows of "-" are left out. The first
    columns, as many as words, are aligned to the left."""
    rows = [(title, cells) for title, cells in rows if any(cell != "-" for cell in cells)]
    if not rows:
        return ""
    lines = ["| " + " | ".join(header) + " |",
             "|" + "---|" * words + "---:|" * (len(header) - words)]
    return "\n".join(lines + [f"| {title} | " + " | ".join(cells) + " |" for title, cells in rows])


# Tables. An empty string: not measured.

def times_table(runs, rows, sizes, title, name=size_name):
    def cell(workload, size):
        run = runs.get((workload, size))
        return " / ".join(microseconds(run[key]) for key in STATISTICS) if run else "-"
    return markdown([title] + [name(size) for size in sizes],
                    [(row, [cell(workload, size) for size in sizes]) for workload, row in rows])


def tick_table(runs):
    return times_table(runs, TICKS, sizes_of(runs), "tick on a sphere, us; triangles:")


def query_table(runs):
    return times_table(runs, QUERIES, sizes_of(runs), "query on a sphere, us; triangles:")


def scan_table(runs):
    sizes = [size for size in SCAN_SIZES if any((name, size) in runs for name, _ in SCANS)]
    return times_table(runs, SCANS, sizes, "tick on a scanned housing, us; triangles:", str)


def growth_cells(runs, workload):
    """The median at each size over the median at the next smaller size."""
    medians = [runs.get((workload, size), {}).get("p50_ns") for size in sizes_of(runs)]
    return ["-"] + [f"{larger / smaller:.2f}" if smaller and larger else "-"
                    for smaller, larger in zip(medians, medians[1:])]


def ratio_table(runs):
    sizes = sizes_of(runs)
    rows = []
    for workload, counter, title in RATIOS:
        ratios = [runs.get((workload, size), {}).get(counter) for size in sizes]
        rows.append((title, ["-" if ratio is None else f"{ratio:.2f}" for ratio in ratios]))
    rows.append(("sliding tick / sliding tick at the next smaller size",
                 growth_cells(runs, "tick_sliding")))
    return markdown(["ratio of medians; triangles:"] + [size_name(size) for size in sizes], rows)


def sphere_line(runs):
    parts = []
    for size in sizes_of(runs):
        under = runs.get(("tick_sphere_sliding", size), {}).get("triangles_under_proxy")
        if under is not None:
            parts.append(f"{under:.0f} at {size_name(size)}")
    return ("Mean number of triangles within 1 mm of the point that the sphere proxy touches: " +
            ", ".join(parts) + ".") if parts else ""


def worst_table(runs):
    sizes = {name[len("worst_"):]: size for name, size in runs if name.startswith("worst_")}
    rows = []
    for workload, title in WORST:
        found = [sizes.get(workload + kind) for kind, _ in WORST_KINDS]
        size = next((size for size in found if size), None)
        if size is None:
            continue
        unit = "nodes" if workload in COUNTED_IN_NODES else "triangles"
        cells = [microseconds(runs[f"worst_{workload}{kind}", size]["max_ns"]) if present else "-"
                 for (kind, _), present in zip(WORST_KINDS, found)]
        rows.append((title, [f"{size:,} {unit}"] + cells))
    return markdown(["longest tick"] + ["size"] + [title for _, title in WORST_KINDS], rows)


def effect_table(runs):
    sizes = sorted({size for name, size in runs if name.startswith("tick_sliding_with_")})
    rows = []
    for effect, counter, text, title in EFFECTS:
        values = [runs.get(("tick_sliding_with_" + effect, size), {}).get(counter)
                  for size in sizes]
        rows.append((title, ["-" if value is None else text.format(value) for value in values]))
    return markdown(["time added to the mean sliding tick; triangles:"] +
                    [size_name(size) for size in sizes], rows)


def loading_table(runs):
    sizes = [size for size in sizes_of(runs) if ("load_glb", size) in runs]
    rows = []
    for workload, counter, decimals, title in LOADING:
        values = [runs.get((workload, size), {}).get(counter) for size in sizes]
        rows.append((title, ["-" if value is None else f"{value:.{decimals}f}"
                             for value in values]))
    return markdown(["loading a sphere; triangles:"] + [size_name(size) for size in sizes], rows)


def instance_table(runs):
    if ("load_instances", INSTANCE_COUNTS[-1]) not in runs:
        return ""
    rows = []
    for workload, counter, title, text in INSTANCES:
        values = [runs.get((workload, count), {}).get(counter) for count in INSTANCE_COUNTS]
        rows.append((title, ["-" if value is None else text(value) for value in values]))
    return markdown(["instances of a sphere of 1,280 triangles:", "1", "10,000"], rows)


def side_test_table(runs):
    if not all((test, name) in runs for test, _ in SIDE_TESTS for name, _ in SIDE_CLASSES):
        return ""

    def cell(test, name):
        run = runs[test, name]
        undecided = ", undecided" if run["undecided"] else ""
        return f"{run['call_ns']:.0f}{undecided}"
    return markdown(["time of a sign, ns"] + [title for _, title in SIDE_CLASSES],
                    [(title, [cell(test, name) for name, _ in SIDE_CLASSES])
                     for test, title in SIDE_TESTS])


def change(runs, pattern, key, scale=1):
    """Without → with A4, on one line."""
    return "\N{NO-BREAK SPACE}→\N{NO-BREAK SPACE}".join(pattern % (scale * run[key]) for run in runs)


def objects_table(objects):
    """A row for each measure, a column for each object."""
    measures = [("mean contact angle, deg", "%.1f", "mean_contact_angle_deg", 1),
                ("contact at 30 deg or less, % of contact", "%.0f", "share_within_30deg", 100),
                ("mean penetration, mm", "%.2f", "mean_penetration_m", 1000),
                ("in contact, % of time", "%.0f", "contact_share", 100),
                ("contour completed, %", "%.0f", "way_share", 100),
                ("losses of contact", "%.0f", "losses_of_contact", 1),
                ("energy returned by the device, mJ", "%.0f", "port_work_J", 1000)]
    return markdown(["one turn, without → with A4"] + [name.replace("_", " ") for name in objects],
                    [(title, [change(runs, pattern, key, scale) for runs in objects.values()])
                     for title, pattern, key, scale in measures])
