"""The table of the soaks."""

import json

import result_tables as tables
from result_tables import BadInput

NAMES = {"sphere_1kHz": "sphere, 1.3M triangles, 1 kHz",
         "sphere_10kHz": "sphere, 1.3M triangles, 10 kHz",
         "scan_1kHz": "scan, 1.25M triangles, 1 kHz",
         "scan_10kHz": "scan, 1.25M triangles, 10 kHz"}
COLUMNS = ["three runs each", "minutes", "late ticks", "woken late, preempted, page fault",
           "late, charged to device or loop",
           "over a quarter of the period in all runs", "worst CPU time of a tick",
           "period, 99.9 %", "delay, 99.9 %", "allocations, locks", "heap, resident",
           "not finite"]


def read(folder):
    """{name: result}, as measure_soak.py wrote them."""
    results = {}
    for name in NAMES:
        path = folder / f"{name}.json"
        try:
            results[name] = json.loads(path.read_text(encoding="utf-8"))
            row(results[name])
        except (OSError, ValueError, KeyError, TypeError, IndexError) as error:
            raise BadInput(f"{path}: expected a result of measure_soak.py ({error!r})") from error
    return results


def each(result, number, pattern="%g"):
    """The number of each run."""
    return ", ".join(pattern % number(run) for run in result["runs"])


def total(result, number):
    return sum(number(run) for run in result["runs"])


def growth(run, key):
    return run["memory_at_end"][key] - run["memory_after_1_s"][key]


def row(result):
    def causes(*names):
        return lambda run: sum(run["tick_times"]["late_ticks"][name] for name in names)

    rate_Hz = result["runs"][0]["rate_Hz"]
    worst_ns = result["worst_repeated_cpu_ns"]
    return [f"{result['minutes']:g}",
            each(result, causes("woken_late", "preempted", "page_fault", "ours", "device"))
            + f" of {result['runs'][0]['ticks']}",
            ", ".join(str(total(result, causes(name)))
                      for name in ("woken_late", "preempted", "page_fault")),
            str(total(result, causes("ours", "device"))), str(result["ours_in_all"]),
            f"{worst_ns / 1000:.1f} us, {1e-7 * worst_ns * rate_Hz:.1f} % of the period",
            each(result, lambda run: run["reached_timing"]["period_ns"] / 1e6, "%.3f") + " ms",
            each(result, lambda run: run["reached_timing"]["delay_ns"] / 1e3, "%.1f") + " us",
            f"{total(result, lambda run: run['allocations'])}, "
            f"{total(result, lambda run: run['locks'])}",
            "; ".join(f"{growth(run, 'heap_bytes'):+d}, {growth(run, 'resident_bytes'):+d} bytes"
                      for run in result["runs"]),
            str(total(result, lambda run: run["ticks_not_finite"]))]


def block(results):
    columns = [[COLUMNS[0]] + [NAMES[name] for name in results]]
    rows = list(zip(COLUMNS[1:], *(row(result) for result in results.values())))
    return tables.markdown(columns[0], [(name, list(cells)) for name, *cells in rows])
