#!/usr/bin/env python3
"""The sweep that ships, complete: it has the committed results and takes at most ten minutes.

shipped_sweep_test.py PALPATE PROJECT_DIR

The ten minutes are those of two cores: twenty minutes of computing time, however busy the machine is.
"""

import json
import pathlib
import resource
import sys
import tempfile
import time

MOST_CPU_S = 2 * 600


def main():
    palpate, project = (pathlib.Path(path).resolve() for path in sys.argv[1:3])
    sys.dont_write_bytecode = True
    sys.path.insert(0, str(project / "benchmarks"))
    import measure_sweep
    start = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        result = measure_sweep.measure(palpate, pathlib.Path(folder))
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu_s = used.ru_utime + used.ru_stime
    print(f"{time.monotonic() - start:.0f} s, {cpu_s:.0f} s of computing time")
    committed = json.loads((project / "benchmarks/results/sweep/sweep.json").read_text())
    if json.loads(measure_sweep.text_of(result)) != committed:
        sys.exit("the results differ from benchmarks/results/sweep/sweep.json; run "
                 "benchmarks/measure_sweep.py")
    if cpu_s > MOST_CPU_S:
        sys.exit(f"the sweep takes {cpu_s:.0f} s of computing time; expected at most {MOST_CPU_S} s")


main()
