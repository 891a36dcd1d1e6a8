"""The tables of what a viewer and a recording cost a session."""

import csv
import json

import result_tables as tables
from result_tables import BadInput

VIEW_LINES = [
    ("tick without a viewer, median", ("tick without a viewer: median",), "%.0f"),
    ("more with a viewer", ("tick with a viewer: more",), "%.0f"),
    ("pointer to state, median, 99 %", ("pointer to state: median", "pointer to state: 99 %"),
     "%.2f"),
    ("bare round trip, median, 99 %", ("bare round trip: median", "bare round trip: 99 %"), "%.2f"),
]
CAUSES = ("woken_late", "preempted", "page_fault", "device", "ours")
THREAD_LINES = ["CPU of the network thread", "growth of memory", "ticks"] + [
    f"late ticks: {cause}" for cause in CAUSES]
RATES = {"1kHz": "1 kHz", "20kHz": "20 kHz"}


def read_view(path):
    """{quantity: (value, unit)}, as view_times wrote them."""
    try:
        with open(path, encoding="utf-8", newline="") as file:
            lines = {row["quantity"]: (float(row["value"]), row["unit"])
                     for row in csv.DictReader(file)}
        view_block(lines)
        return lines
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise BadInput(f"{path}: expected a result of view_times ({error!r})") from error


def view_block(lines):
    def cell(names, pattern):
        unit = lines[names[0]][1]
        return ", ".join(pattern % lines[name][0] for name in names) + ("" if unit == "1" else " " + unit)

    costs = [(name, [cell(names, pattern)]) for name, names, pattern in VIEW_LINES]
    threads = [(name, [cell((f"{side}: {name}",), "%.2f" if lines[f"{side}: {name}"][1] != "1" else "%.0f")
                       for side in ("without clients", "with clients")])
               for name in THREAD_LINES]
    return (tables.markdown(["cost", "value"], costs) + "\n\n" +
            tables.markdown(["haptic thread with a viewer", "no client", "four clients"], threads))


def read_frames(path):
    """The result of measure_frames.mjs."""
    try:
        result = json.loads(path.read_text(encoding="utf-8"))
        frames_block(result)
        return result
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise BadInput(f"{path}: expected a result of measure_frames.mjs ({error!r})") from error


def frames_block(result):
    rows = [(name, [f"{part['frames_per_s']:.1f}", f"{part['script_ms_per_frame']:.2f} ms"])
            for name, part in (("without drawing", result["not_drawn"]),
                               ("drawn in software, free motion", result["drawn"]),
                               ("drawn in software, A4 turns the scene", result["drawn_in_contact"]))]
    return tables.markdown([f"{result['triangles']} triangles", "frames a second", "script a frame"],
                           rows)


def read_recording(folder):
    """{name: result}, as recorder_times printed them."""
    results = {}
    for name in RATES:
        path = folder / f"{name}.json"
        try:
            results[name] = json.loads(path.read_text(encoding="utf-8"))
            recording_row(results[name])
        except (OSError, ValueError, KeyError, TypeError, IndexError) as error:
            raise BadInput(f"{path}: expected a result of recorder_times ({error!r})") from error
    return results


def recording_row(result):
    without, recorded = result["sessions"]

    def late(run, names):
        return str(sum(run["late_ticks"][name] for name in names))

    others = [cause for cause in CAUSES if cause != "ours"]
    return [f"{result['tick_ns_without']:.0f} ns, {result['recording_ns_per_tick']:+.0f} ns",
            f"{recorded['ticks']}",
            f"{late(without, ['ours'])}, {late(recorded, ['ours'])}",
            f"{late(without, others)}, {late(recorded, others)}",
            f"{100 * result['recorder_cpu_share']:.2f} %",
            f"{recorded['bytes_per_tick']:.1f}", str(recorded["dropped"])]


RECORDING_LINES = ["tick without, more with recording", "ticks", "late, ours: without, with",
                   "late, other causes: without, with", "CPU of the recorder", "bytes per tick",
                   "dropped ticks"]


def recording_block(results):
    columns = [recording_row(result) for result in results.values()]
    return tables.markdown(["cost"] + [RATES[name] for name in results],
                           [(title, list(cells)) for title, *cells in zip(RECORDING_LINES, *columns)])
