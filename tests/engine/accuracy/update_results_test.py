#!/usr/bin/env python3
"""The README's table and figure of what accuracy costs follow the results that they are made from.

update_readme_test.py UPDATE_README.py RESULTS_DIR

Works on a copy of the committed results, with rows of accuracy that are made up.
"""

import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

SKIPPED = 77


def row(knob, method, level_name, level, error, time, **more):
    return {"name": f"accuracy_{knob}/{method}/{level_name}/iterations:1/manual_time",
            "error": error, "error_low": 0.8 * error, "error_high": 1.25 * error, "time": time,
            "time_low": 0.9 * time, "time_high": 1.1 * time, "level": level, "iterations": 2.0,
            **more}


def rows():
    made = [row("mesh_depth", method, str(n), 0.06 / 2 ** n, (0.06 / 2 ** n) ** 2 / 0.3,
                cost * 1.1 ** n, is_default=float(method == "point-proxy" and n == 4))
            for method, cost in (("point-proxy", 150.0), ("sphere-proxy", 420.0))
            for n in range(2, 8)]
    made += [row("solver_iterations", "steps", str(2 ** n), 2 ** n, 0.0 if n > 3 else 1e-4 / 4 ** n,
                 134.0 * (n + 1), is_default=float(n == 4)) for n in range(7)]
    made.append(row("servo_rate", "bounce", "250-hz", 0.004, 0.5, 75.0, failures=21.0))
    return made


def timed(name, first_ns):
    times = {key: (n + 1) * first_ns
             for n, key in enumerate(("p50_ns", "p99_ns", "p999_ns", "max_ns"))}
    return {"name": name + "/iterations:6/manual_time", "clock_ns": 20.0, **times}


class Copy:
    """Results and a README of their own."""

    def __init__(self, script, results, folder):
        self.script = script
        self.readme = folder / "README.md"
        self.readme.write_text("before\n<!-- measured:begin -->\n<!-- measured:end -->\nafter\n")
        self.results = folder / "its results"
        shutil.copytree(results, self.results)
        self.path = next(self.results.glob("*.json"))
        self.document = json.loads(self.path.read_text())
        self.document["benchmarks"] = [
            run for run in self.document["benchmarks"]
            if not run["name"].startswith(("accuracy_", "scan_", "worst_"))]
        self.bare = list(self.document["benchmarks"])
        self.figure = self.results / self.path.stem / "accuracy.svg"

    def put(self, more):
        self.document["benchmarks"] = self.bare + more
        self.path.write_text(json.dumps(self.document))

    def run(self, *options):
        done = subprocess.run([sys.executable, self.script, "--readme", self.readme, "--results",
                               self.results, *options], capture_output=True, text=True)
        return done.returncode, done.stdout + done.stderr


def expect(condition, what):
    if not condition:
        sys.exit(f"not so: {what}")


def check_texts(text, figure):
    expect("| mesh: mean edge | depth, tick | 15 mm: 750 um, 182 ns | 3.75 mm: 46.9 um, 220 ns | "
           "469 um: 732 nm, 292 ns |" in text, "the table has coarsest, default and finest")
    expect("| most steps of the solver | distance to converged, tick | 1: 100 um, 134 ns | 16: 0, 670 ns |" in text,
           "an error of 0 is 0")
    expect("servo" not in text, "a level that failed is not in the table")
    expect(re.search(r"!\[[^]]{10,}\]\(its results/[^)]*accuracy\.svg\)", text),
           "the figure is shown, with a text for those who do not see it")
    for part in ("depth (um)", "tick (ns)", "sphere proxy", "default", "mesh: mean edge"):
        expect(f">{part}<" in figure, f"the figure says {part}")
    expect(not re.search(r"\bnan\b|\binf\b|http(?!://www\.w3\.org/)", figure, re.IGNORECASE),
           "all in the figure is a number, and nothing is elsewhere")


def main():
    if not shutil.which("gnuplot"):
        print("skipped: gnuplot is not installed")
        return SKIPPED
    with tempfile.TemporaryDirectory() as name:
        copy = Copy(sys.argv[1], sys.argv[2], pathlib.Path(name))
        copy.put([])
        code, said = copy.run()
        expect(code == 0, f"it runs: {said}")
        without = copy.readme.read_text()
        expect("accuracy costs" not in without and not copy.figure.exists(),
               "without rows there is neither table nor figure")
        expect(copy.run("--check")[0] == 0, "without rows all is well")

        copy.put(rows())
        expect(copy.run("--check")[0] == 1, "a figure that is missing is noticed")
        expect(not copy.figure.exists(), "--check draws nothing")
        expect(copy.run()[0] == 0 and copy.run("--check")[0] == 0, "what was made passes")
        text, figure = copy.readme.read_text(), copy.figure.read_text()
        check_texts(text, figure)
        expect(text.replace("\r", "").startswith(without.split("<!-- measured:end")[0].rstrip()),
               "the other tables are as they were")

        # As another version of gnuplot would draw it, and then of other data.
        copy.figure.write_text(figure.replace("<path ", "<path data-other='1' "))
        expect(copy.run("--check")[0] == 0, "who drew it does not matter")
        changed = rows()
        changed[1]["error_high"] *= 1.5  # of no table
        copy.put(changed)
        code, said = copy.run("--check")
        expect(code == 1 and "accuracy.svg" in said, "a figure of other data is noticed")

        copy.put([row("no_such_knob", "m", "l", 1.0, 1.0, 1.0)])
        code, said = copy.run("--check")
        expect(code == 1 and "no_such_knob" in said, "a knob without units is named")
        copy.put(rows() + [timed("scan_point/500k", 100.0), timed("worst_moving_bodies/256", 5e3),
                           timed("worst_moving_bodies_magnets/256", 1e6)])
        expect(copy.run()[0] == 0, "scans and worst inputs are rows like others")
        text = copy.readme.read_text()
        expect("| point | 0.10 / 0.20 / 0.30 / 0.40 |" in text, "a scan that was measured is shown")
        expect("| nodes that close in on the hand | 256 | 20.0 | - | 4000 | - |" in text,
               "of a worst input the worst tick is shown, and what was not measured is not")
        expect("| 256 |" not in text.split("| ratio of medians")[0], "it is no size of the sphere")

        copy.put([])
        expect(copy.run("--check")[0] == 1, "a figure of nothing is noticed")
        expect(copy.run()[0] == 0 and not copy.figure.exists(), "and removed")
        expect(copy.readme.read_text() == without, "and the table with it")
    print("the README follows its results")
    return 0


if __name__ == "__main__":
    sys.exit(main())
