#!/usr/bin/env python3
"""Writes the measured blocks of README.md and of the pages in docs from benchmarks/results, and draws
the figures.

update_results.py [--check] [--root DIR]

A block stands between the lines <!-- measured:NAME:begin --> and <!-- measured:NAME:end -->; the
rest of these files is written by hand. Each block has a page that must hold it (blocks_of); README.md
and any other page of docs may show it too. --check changes nothing and exits with 1 if a block or a
figure differs from the results. --root: a folder with the same layout as the project.
"""

import argparse
import json
import os
import pathlib
import re
import sys

sys.dont_write_bytecode = True  # no folder beside the sources
import accuracy_results  # noqa: E402
import calm_chart_results  # noqa: E402
import compare_results  # noqa: E402
import contour_results  # noqa: E402
import experiment_results  # noqa: E402
import passive_results  # noqa: E402
import result_figures  # noqa: E402
import result_tables as tables  # noqa: E402
import session_results  # noqa: E402
import soak_results  # noqa: E402
import sweep_results  # noqa: E402
import work_results  # noqa: E402
from result_tables import BadInput  # noqa: E402

README = pathlib.PurePath("README.md")
STUDY = pathlib.PurePath("docs/study")
HEADLINE_TRIANGLES = 1310720
TICK_NS = 1e6  # the period of the haptic thread
NUMBERS = {1: "one", 2: "two", 3: "three", 4: "four"}


class Machine:
    """One file of results."""

    def __init__(self, path):
        self.path = path
        self.context, self.runs, self.knobs = tables.read_result(path)

    @property
    def figure(self):
        return self.path.parent / self.path.stem / "accuracy.svg"

    def counter(self, workload, name, size=HEADLINE_TRIANGLES):
        return self.runs.get((workload, size), {}).get(name)

    def description(self):
        context = self.context
        return (f"{context['cpu']}, {context['num_cpus']} cores at "
                f"{context['mhz_per_cpu'] / 1000:.1f} GHz; {context['compiler']}")


# Blocks of the README

def means(objects, key):
    """The means over objects without and with A4."""
    return [sum(runs[run][key] for runs in objects.values()) / len(objects) for run in (0, 1)]


def a4_block(objects):
    (off_deg, on_deg), (off_J, on_J) = (means(objects, key)
                                        for key in ("mean_contact_angle_deg", "port_work_J"))
    off, on = objects["star"]
    return (f"Round each of the paper's {NUMBERS[len(objects)]} objects, the mean contact angle of a simulated hand "
            f"falls from {off_deg:.1f} to {on_deg:.1f} deg with A4. In exchange, the device returns {1000 * on_J:.0f} mJ in place "
            f"of {1000 * off_J:.0f} mJ; on the star, the hand loses contact {on['losses_of_contact']:.0f} times in place "
            f"of {off['losses_of_contact']:.0f}.")


def headline_block(machine, work):
    tick = [machine.counter("tick_sliding", key) for key in ("p50_ns", "p99_ns")]
    slowest = f"the slowest known input took {longest_ns(work) / 1e6:.2f} ms ([measured](docs/study/results-ticks.md))."
    if None in tick:
        return f"- Speed at 1 kHz: {slowest}"
    median, most = map(tables.microseconds, tick)
    return (f"- A tick takes {median} us (median) and {most} us (99 %) on {HEADLINE_TRIANGLES / 1e6:.1f} million "
            f"triangles; {slowest}")


# Blocks of the pages

def longest_ns(work):
    return 1e3 * max(work_results.longest_us(rows) for rows in work.values())


def speed_block(machine, work):
    tick = [machine.counter("tick_sliding", key) for key in ("p50_ns", "p99_ns")]
    ratios = [machine.counter("closest_point", key) for key in ("vs_stock_p50", "vs_cgal_p50")]
    lines = []
    if None not in tick:
        median, most = map(tables.microseconds, tick)
        lines.append("- A tick of a point proxy that slides over "
                     f"{HEADLINE_TRIANGLES / 1e6:.1f} million triangles takes {median} us (median) and "
                     f"{most} us (99 %).")
    if None not in ratios:
        lines.append("- Palpate's closest-point query gives its result in double precision. It takes "
                     f"{ratios[0]:.2f} times as long as the same query with Embree's built-in triangles, "
                     f"which are in float.\n- The query takes {ratios[1]:.2f} times as long as the same "
                     "query with CGAL's tree.")
    slowest_ns = longest_ns(work)
    lines.append(f"- The longest update of the proxy and of magnets and media, on inputs built to be "
                 f"slow, took {slowest_ns / 1e6:.2f} ms. That is {100 * slowest_ns / TICK_NS:.0f} % of a "
                 f"tick at 1 kHz ({', '.join(work)}).")
    return "\n".join(lines) + "\n\n" + machine_line(machine)


def a4_objects_block(objects, people_deg):
    angles, energies_J = (means(objects, key) for key in ("mean_contact_angle_deg", "port_work_J"))
    return (f"Over the paper's {NUMBERS[len(objects)]} objects, the mean contact angle falls from "
            f"{angles[0]:.1f} to {angles[1]:.1f} deg, and the energy that the device returns rises from "
            f"{1000 * energies_J[0]:.0f} to {1000 * energies_J[1]:.0f} mJ; the paper's ten people had "
            f"{people_deg[0]:.1f} deg without A4 and {people_deg[1]:.1f} deg with it.")


def machine_line(machine):
    return (f"Measured on {machine.description()}; commit {machine.context['commit']}, "
            f"{machine.context['date'][:10]}.")


def conditions_block(machine):
    clock_ns = max(run["clock_ns"] for run in machine.runs.values() if "clock_ns" in run)
    return (f"{machine.description()}, `{machine.context['flags']}`; commit "
            f"{machine.context['commit']}, {machine.context['date'][:10]}; reading the clock "
            f"takes {clock_ns:.0f} ns, which are subtracted from every time.")


def figure_line(machine, root):
    if not accuracy_results.figure_table(machine.knobs):
        return ""
    link = pathlib.Path(os.path.relpath(machine.figure, root / STUDY)).as_posix()
    return f"![Error against time of the main knobs; rings mark defaults]({link})"


def joined(*parts):
    return "\n\n".join(part for part in parts if part)


MACHINE_BLOCKS = {
    "conditions": lambda m, root: conditions_block(m),
    "ticks": lambda m, root: joined(tables.tick_table(m.runs), tables.sphere_line(m.runs)),
    "queries": lambda m, root: tables.query_table(m.runs),
    "ratios": lambda m, root: tables.ratio_table(m.runs),
    "scans": lambda m, root: tables.scan_table(m.runs),
    "worst": lambda m, root: tables.worst_table(m.runs),
    "effects": lambda m, root: tables.effect_table(m.runs),
    "loading": lambda m, root: tables.loading_table(m.runs),
    "instances": lambda m, root: tables.instance_table(m.runs),
    "signs": lambda m, root: tables.side_test_table(m.runs),
    "accuracy": lambda m, root: joined(accuracy_results.table(m.knobs), figure_line(m, root)),
}


def machine_blocks(machines, root):
    """The text of each block; with several machines, one part under the name of each."""
    def text(make):
        parts = [(machine.context["cpu"], make(machine, root)) for machine in machines]
        return joined(*(joined(f"**{cpu}**", part) if part and len(machines) > 1 else part
                        for cpu, part in parts)) or "Not measured."
    return {name: text(make) for name, make in MACHINE_BLOCKS.items()}


# Documents and figures

def blocks_of(root, machines):
    """{document: {block: text}}: the page that must hold each block."""
    objects = tables.read_objects(root / "benchmarks/results/paper_objects/objects.json")
    experiment = experiment_results.read(root / "benchmarks/results/experiment")
    contours = contour_results.read(root / "benchmarks/results/contour_angles.csv")
    comparison = compare_results.read(root / "benchmarks/results/compare")
    budgets = passive_results.read(root / "benchmarks/results/compare")
    calm = calm_chart_results.read(root / "benchmarks/results/calm_chart")
    soaks = soak_results.read(root / "benchmarks/results/soak")
    view = session_results.read_view(root / "benchmarks/results/view/times.csv")
    frames = session_results.read_frames(root / "benchmarks/results/view/frames.json")
    recording = session_results.read_recording(root / "benchmarks/results/recording")
    work = work_results.read(root / "benchmarks/results/work")
    newest = max(machines, key=lambda machine: machine.context["date"])
    measured = machine_blocks(machines, root)

    def of_machines(*names):
        return {name: measured[name] for name in names}

    return {
        README: {"a4": a4_block(objects), "headline": headline_block(newest, work),
                 "safe": calm_chart_results.block(calm)},
        STUDY / "experiment.md": {"experiment": experiment_results.block(experiment),
                                  "findings": experiment_results.findings_block(experiment),
                                  "rules": contour_results.rules_block(contours)},
        STUDY / "comparisons.md": {"compare": compare_results.block(comparison),
                                   "a4_losses": compare_results.losses_block(comparison),
                                   "a4_passive": passive_results.block(budgets),
                                   "presses": passive_results.presses_block(budgets)},
        STUDY / "sweeps.md": {"sweep": sweep_results.block(root / "benchmarks/results/sweep")},
        STUDY / "soak.md": {"soaks": soak_results.block(soaks)},
        STUDY / "accuracy.md": of_machines("accuracy"),
        STUDY / "results.md": {"speed": speed_block(newest, work), **of_machines("conditions")},
        STUDY / "results-objects.md": {
            "a4_objects": a4_objects_block(objects, experiment_results.people_deg(experiment)),
            "objects": tables.objects_table(objects), "contours": contour_results.block(contours)},
        STUDY / "results-ticks.md": {"work": work_results.block(work),
                                     **of_machines("ticks", "queries", "ratios", "scans", "worst",
                                                   "effects")},
        STUDY / "results-loading.md": of_machines("loading", "instances", "signs"),
        STUDY / "results-sessions.md": {"view": session_results.view_block(view),
                                        "frames": session_results.frames_block(frames),
                                        "recording": session_results.recording_block(recording)},
    }


def names_in(text):
    return re.findall(r"<!-- measured:(\S*?):(?:begin|end) -->", text)


def documents_of(root, blocks):
    """{path: content with the blocks}, of the pages that must hold blocks and of all others that do."""
    texts = {name: text for page in blocks.values() for name, text in page.items()}
    documents = {root / name: with_blocks(read(root / name), page, texts, root / name)
                 for name, page in blocks.items()}
    for path in sorted((root / "docs").rglob("*.md")):
        content = read(path)
        if path not in documents and names_in(content):
            documents[path] = with_blocks(content, {}, texts, path)
    return documents


def figures_of(root, machines):
    """{path: (kind, table)}: what palpate.analysis.results draws. No table: no figure."""
    results = root / "benchmarks/results"
    objects, sweep, compare, calm = (results / name for name in
                                     ("paper_objects", "sweep", "compare", "calm_chart"))
    try:
        a4 = {"data": json.loads(read(objects / "a4.json")),
              "star": json.loads(read(objects / "objects.json"))["star"]}
        return {objects / "a4.svg": ("a4_turns", a4),
                compare / "a4_passive.svg": ("budgets", passive_results.figure_table(
                    passive_results.read(compare))),
                compare / "strategies.svg": ("strategies", compare_results.figure_table(
                    compare_results.read(compare))),
                calm / "calm_chart.svg": ("calm_chart", calm_chart_results.figure_table(
                    calm_chart_results.read(calm))),
                sweep / "a4_helps.svg": ("a4_helps", sweep_results.figure_of(sweep)),
                root / "haptics/proxy/groove.svg": ("groove", {"steps": 5}),
                **{machine.figure: ("accuracy", accuracy_results.figure_table(machine.knobs))
                   for machine in machines}}
    except (ValueError, KeyError) as error:
        raise BadInput(f"{objects}: expected a4.json and objects.json of measure_objects.py "
                       f"({error!r})") from error


def marker(name, end):
    return f"<!-- measured:{name}:{end} -->"


def with_blocks(text, required, blocks, path):
    """The text with the content of its blocks; it must hold those that are required."""
    found = set(names_in(text))
    unknown = sorted(found - set(blocks))
    if unknown:
        raise BadInput(f"{path}: the marker measured:{unknown[0]} names no block; the blocks are "
                       f"{', '.join(blocks)}")
    for name in sorted(found | set(required)):
        content = blocks[name]
        begin, end = marker(name, "begin"), marker(name, "end")
        if text.count(begin) != 1 or text.count(end) != 1 or text.index(begin) > text.index(end):
            raise BadInput(f"{path}: expected one line {begin} and, after it, one line {end}")
        before, rest = text.split(begin)
        after = rest.split(end)[1]
        if "<!-- measured:" in rest.split(end)[0]:
            raise BadInput(f"{path}: another marker stands between {begin} and {end}")
        text = f"{before}{begin}\n{content}\n{end}{after}"
    return text


def read(path):
    try:
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise BadInput(f"{path}: {error.strerror}") from error


def update(path, content, check):
    """Brings a file to this content, or with check raises BadInput if it has another."""
    old = read(path) if check or path.exists() else None
    if old == content:
        return
    if check:
        raise BadInput(f"{path}: differs from the results; run benchmarks/update_results.py")
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(content, encoding="utf-8")
    print(f"wrote {path}")


def update_figures(figures, check):
    """Draws the figures that are missing, or drawn from other tables; removes those without data."""
    stale = {path: (kind, table) for path, (kind, table) in figures.items()
             if table and not result_figures.is_drawn(path, kind, table)}
    extra = [path for path, (_, table) in figures.items() if not table and path.exists()]
    if check and (stale or extra):
        path = [*stale, *extra][0]
        raise BadInput(f"{path}: {'differs from the results' if path.exists() else 'is missing'}; "
                       "run benchmarks/update_results.py")
    if stale:
        result_figures.draw(stale)
    for path in extra:
        path.unlink()
        print(f"removed {path}")


def run(root, check):
    results = root / "benchmarks/results"
    machines = [Machine(path) for path in sorted(results.glob("*.json"))]
    if not machines:
        raise BadInput(f"{results}: no results; run benchmarks/run.sh")
    documents = documents_of(root, blocks_of(root, machines))
    figures = figures_of(root, machines)
    work_results.check(root, work_results.read(results / "work"))
    update_figures(figures, check)
    for path, content in documents.items():
        update(path, content, check)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="change nothing, only compare")
    parser.add_argument("--root", type=pathlib.Path,
                        default=pathlib.Path(__file__).resolve().parent.parent)
    options = parser.parse_args()
    try:
        run(options.root.resolve(), options.check)
        return 0
    except BadInput as error:
        print(error, file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
