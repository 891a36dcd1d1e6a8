#!/usr/bin/env python3
"""Runs `palpate soak` for the committed results, and writes benchmarks/results/soak/NAME.json.

usage: measure_soak.py PALPATE WRITE_MESH COUNT_ALLOCATIONS [NAME...] [--short]

Each soak runs three times with the same seed, so that the ticks of all runs have the same inputs and
the same work. The runs overlap, but begin a few seconds apart, so that nothing disturbs the same tick
in all of them. A tick that is slow in only some of the runs was slowed down by the machine (interrupts,
or a host that took the CPU away), because the system charges such times to the thread that it finds
running. "worst_repeated_cpu_ns" is the largest CPU time, of all ticks, that all runs needed: for each
tick the smallest one counts. "ours_in_all" counts the ticks that computed for more than a quarter of
the period in all runs; no other tick can be late in all of them because of its own computing.
--short: a few seconds each; writes nothing.
"""

import array
import concurrent.futures
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

SPHERE = ["sphere", "8"]  # 1.3 million triangles
SCAN = ["scan", "0.00091"]  # 1.25 million triangles, with noise and holes
SOAKS = {
    "sphere_1kHz": (SPHERE, 1000, 20.0),
    "sphere_10kHz": (SPHERE, 10000, 5.0),
    "scan_1kHz": (SCAN, 1000, 2.0),
    "scan_10kHz": (SCAN, 10000, 2.0),
}
RUNS = 3
APART_S = 5.0
SHORT_MINUTES = 0.1
RESULTS = pathlib.Path(__file__).parent / "results" / "soak"


def worst_repeated_cpu_ns(times):
    return max(map(min, *times))


def ours_in_all(times, rate_Hz):
    """A late tick counts as ours only if it computed for more than a quarter of the period."""
    quarter_ns = 0.25e9 / rate_Hz
    return sum(shortest_ns > quarter_ns for shortest_ns in map(min, *times))


def soak(palpate, counter, scene, rate_Hz, minutes, folder):
    environment = dict(os.environ, LD_PRELOAD=str(pathlib.Path(counter).resolve()))
    done = subprocess.run(
        [palpate, "soak", scene, "--minutes", str(minutes), "--rate", str(rate_Hz), "--out", folder,
         "--cpu-times"],
        env=environment, capture_output=True, text=True, check=True)
    print(done.stdout, done.stderr, sep="", flush=True)
    counts = re.search(r"haptic thread: (\d+) allocations, (\d+) releases, (\d+) locks", done.stderr)
    run = json.loads(pathlib.Path(folder, "soak.json").read_text())
    times = array.array("I", pathlib.Path(folder, "cpu_ns.u32").read_bytes())
    run["allocations"], run["releases"], run["locks"] = map(int, counts.groups())
    return run, times


def measure(name, programs, folder, is_short):
    palpate, write_mesh, counter = programs
    mesh, rate_Hz, minutes = SOAKS[name]
    scene = os.path.join(folder, mesh[0] + ".glb")
    subprocess.run([write_mesh, scene, *mesh], check=True)
    length = SHORT_MINUTES if is_short else minutes
    outs = [os.path.join(folder, str(run)) for run in range(RUNS)]
    with concurrent.futures.ThreadPoolExecutor(RUNS) as pool:
        jobs = []
        for out in outs:
            jobs.append(pool.submit(soak, palpate, counter, scene, rate_Hz, length, out))
            time.sleep(APART_S)
        runs, times = zip(*(job.result() for job in jobs))
    result = {"minutes": length, "worst_repeated_cpu_ns": worst_repeated_cpu_ns(times),
              "ours_in_all": ours_in_all(times, rate_Hz), "runs": runs}
    share = 1e-9 * result["worst_repeated_cpu_ns"] * rate_Hz
    print(f"{name}: worst CPU time of a tick in all runs {result['worst_repeated_cpu_ns']} ns, "
          f"{100 * share:.2f} % of the period; late in all because of their computing: "
          f"{result['ours_in_all']}\n", flush=True)
    for run in runs:
        del run["first_late_ticks"]
        for times in run["tick_times"].values():
            if isinstance(times, dict):
                times.pop("buckets", None)
    return result


def main():
    programs = sys.argv[1:4]
    names = [name for name in sys.argv[4:] if name != "--short"] or list(SOAKS)
    is_short = "--short" in sys.argv
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            result = measure(name, programs, folder, is_short)
            if is_short:
                continue
            RESULTS.mkdir(parents=True, exist_ok=True)
            (RESULTS / f"{name}.json").write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
