#!/usr/bin/env python3
"""README.md, the pages of docs and the figures follow the results that they are made from.

update_results_test.py UPDATE_RESULTS.py PROJECT_DIR

Works on a copy of the committed results, with invented rows of accuracy.
"""

import contextlib
import importlib
import io
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "helpers"))
from needs import need  # noqa: E402


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
    """The project's documents, results and drawn figures in a folder of their own."""

    def __init__(self, script, project, folder):
        self.script = script
        self.root = folder
        shutil.copytree(project / "benchmarks/results", folder / "benchmarks/results")
        shutil.copytree(project / "docs", folder / "docs")
        for name in ("README.md", "haptics/proxy/groove.svg", "haptics/proxy/work.h",
                     "engine/session/run_setting.cpp"):
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(project / name, folder / name)
        self.readme = folder / "README.md"
        self.study = folder / "docs/study"
        self.tables = self.study / "results-ticks.md"
        results = folder / "benchmarks/results"
        self.objects = results / "paper_objects/objects.json"
        self.a4_figure = results / "paper_objects/a4.svg"
        self.path = next(results.glob("*.json"))
        self.document = json.loads(self.path.read_text())
        self.committed = self.path.read_text()
        self.document["benchmarks"] = [
            run for run in self.document["benchmarks"]
            if not run["name"].startswith(("accuracy_", "scan_", "worst_"))]
        self.without_rows = list(self.document["benchmarks"])
        self.figure = self.path.parent / self.path.stem / "accuracy.svg"

    def put(self, more):
        self.document["benchmarks"] = self.without_rows + more
        self.path.write_text(json.dumps(self.document))

    def block(self, name):
        """The text of a block of the study."""
        begin = f"measured:{name}:begin -->\n"
        text = next(text for path in sorted(self.study.glob("*.md")) if begin in (text := path.read_text()))
        return text.split(begin)[1].split("\n<!-- measured:")[0]

    def pages(self):
        return {path: path.read_text() for path in (self.readme, *self.study.glob("*.md"))}

    def run(self, *options):
        """As run_program, but without a process for each call."""
        said = io.StringIO()
        sys.argv = [str(self.script), "--root", str(self.root), *options]
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            code = importlib.import_module("update_results").main()
        return code, said.getvalue()

    def run_program(self, *options):
        done = subprocess.run([sys.executable, self.script, "--root", self.root, *options],
                              capture_output=True, text=True)
        return done.returncode, done.stdout + done.stderr


def expect(condition, statement):
    if not condition:
        sys.exit(f"false: {statement}")


def expect_refused(copy, statement, word):
    code, output = copy.run("--check")
    expect(code == 1 and word in output, f"{statement} ({code}: {output})")


def check_accuracy(copy):
    """The table and the figure of the invented rows; the figure's text, for later changes."""
    copy.put(rows())
    expect_refused(copy, "--check reports a missing figure", "accuracy.svg")
    expect(not copy.figure.exists(), "--check draws nothing")
    expect(copy.run()[0] == 0 and copy.run("--check")[0] == 0, "--check accepts fresh documents")
    text, figure = copy.block("accuracy"), copy.figure.read_text()
    expect("| mesh resolution: mean edge | penetration depth, tick | 15 mm: 750 um, 182 ns | "
           "3.75 mm: 46.9 um, 220 ns | 469 um: 732 nm, 292 ns |" in text,
           "the table has the first level, the default and the last level")
    expect("| 1: 100 um, 134 ns | 16: 0, 670 ns |" in text, "an error of 0 is 0")
    expect("servo" not in text, "the table leaves out a failed level")
    shown = re.search(r"!\[[^]]{10,}\]\(([^)]*accuracy\.svg)\)", text)
    expect(shown and (copy.study / shown[1]).resolve() == copy.figure.resolve(),
           "the page shows the figure, with an alternative text")
    for part in ("penetration depth (µm)", "tick (ns)", "sphere proxy", "default",
                 "mesh resolution: mean edge"):
        expect(f">{part}<" in figure, f"the figure has the text {part}")
    expect(not re.search(r"\bnan\b|\binf\b|http(?!://www\.w3\.org/)", figure, re.IGNORECASE),
           "the figure has finite numbers only and refers to no other file")
    expect(not re.search(r"(fill|stroke)(=['\"]|: )(black|#000000|rgb\()", figure)
           and not re.search(r"<rect[^>]*#ffffff", figure, re.IGNORECASE),
           "the figure has no ground of its own and no black lines or letters")

    figures = importlib.import_module("result_figures")
    source = figures.DRAWN.search(figure)[1]
    other = figures.DRAWN.sub("", figure).replace("<path ", "<path data-other='1' ")
    copy.figure.write_text(other + figures.mark(source, other))
    expect(copy.run("--check")[0] == 0, "--check accepts a figure of another matplotlib version")
    changed = rows()
    changed[1]["error_high"] *= 1.5  # not in the table
    copy.put(changed)
    expect_refused(copy, "--check reports a figure of other data", "accuracy.svg")
    copy.put([row("no_such_knob", "m", "l", 1.0, 1.0, 1.0)])
    expect_refused(copy, "an error names a knob without units", "no_such_knob")


def check_rows(copy):
    copy.put(rows() + [timed("scan_point/500k", 100.0), timed("worst_moving_bodies/256", 5e3)])
    expect(copy.run()[0] == 0, "scans and slow inputs are accepted")
    expect("| point proxy | 0.10 / 0.20 / 0.30 / 0.40 |" in copy.block("scans"),
           "the table shows a measured scan")
    expect("| moving nodes that close in on the proxy | 256 nodes | 20.0 | - |"
           in copy.block("worst"), "the table shows the longest time and a dash if not measured")
    expect("256" not in copy.block("ticks").splitlines()[0], "256 nodes are no size of the sphere")


def check_work(copy):
    path = next((copy.root / "benchmarks/results/work").glob("*.csv"))
    committed = path.read_text()
    lines = committed.splitlines(keepends=True)
    cells = lines[2].split(",")

    def put(column, value):
        path.write_text("".join(lines[:2] + [",".join(
            value if i == column else cell for i, cell in enumerate(cells))] + lines[3:]))

    put(4, "501.0")
    expect_refused(copy, "a tick of more than half a millisecond is refused", "at most 500")
    put(6, "99.5\n")
    expect_refused(copy, "a file that states another price is named", "work.h")
    path.write_text(committed)
    page = copy.study / "people.md"
    page.write_text(page.read_text() + "\nA unit takes at\nmost 24 ns.\n")
    expect_refused(copy, "a page that states another price is named", "people.md")
    page.write_text(page.read_text().replace("most 24 ns", "most 23 ns"))
    expect(copy.run("--check")[0] == 0, "any page may state the price")
    path.write_text(committed.replace("unit_ns", "other"))
    expect_refused(copy, "a broken result of work_prices is named", path.name)
    path.write_text(committed)
    expect(copy.run()[0] == 0, "the committed prices are accepted")


def check_markers(copy):
    for document in (copy.readme, copy.tables):
        text = document.read_text()
        name = re.search(r"measured:(\w+):begin", text)[1]
        begin, end = f"<!-- measured:{name}:begin -->", f"<!-- measured:{name}:end -->"
        for broken, statement in (
                (text.replace(begin, ""), "a missing begin"), (text.replace(end, ""), "a missing end"),
                (text + begin, "a repeated begin"),
                (text.replace(begin, "?").replace(end, begin).replace("?", end), "a swapped pair"),
                (text.replace(f":{name}:", ":no_such_block:"), "an unknown block")):
            document.write_text(broken)
            expect_refused(copy, f"--check reports {statement}", document.name)
            expect(copy.run()[0] == 1 and document.read_text() == broken,
                   f"{statement} leaves the document as it is")
        for changed in (re.sub(r"(measured:\w+:begin -->\n[^\d]*)\d", r"\g<1>x", text, count=1),):
            document.write_text(changed)
            expect_refused(copy, "--check reports a changed figure in a block", document.name)
        document.write_text("By hand.\n" + text)
        expect(copy.run("--check")[0] == 0, "text outside the blocks is free")
        document.write_text(text)
    for path, text in copy.pages().items():
        for name in re.findall(r"measured:(\w+):begin", text):
            begin = f"<!-- measured:{name}:begin -->"
            before, after = text.split(begin)
            path.write_text(before + begin + re.sub(r"\d", lambda m: str(9 - int(m[0])), after, count=1))
            expect_refused(copy, f"--check reports a digit of the block {name}", path.name)
            path.write_text(text)
    guest = copy.root / "docs/concepts/a4.md"
    committed = guest.read_text()
    guest.write_text(committed + "\n<!-- measured:a4:begin -->\n<!-- measured:a4:end -->\n")
    expect_refused(copy, "--check reads the blocks of every page", guest.name)
    expect(copy.run()[0] == 0 and "46.2 to 18.8 deg" in guest.read_text(), "any page may show a block")
    guest.write_text(committed)


def check_pictures(copy):
    for figure in (copy.a4_figure, copy.root / "haptics/proxy/groove.svg"):
        figure.write_text(figure.read_text().replace("<path", "<path class='x'", 1))
        expect_refused(copy, f"--check reports a changed {figure.name}", figure.name)
        figure.unlink()
        expect_refused(copy, f"--check reports a missing {figure.name}", figure.name)
        # Other versions of matplotlib give other bytes.
        expect(copy.run()[0] == 0 and "<path" in figure.read_text() and copy.run("--check")[0] == 0,
               f"{figure.name} is drawn again")
    committed = copy.objects.read_text()
    objects = json.loads(committed)
    objects["star"][1]["losses_of_contact"] = 4321
    copy.objects.write_text(json.dumps(objects))
    expect_refused(copy, "--check reports documents of other results", "differs")
    expect(copy.run()[0] == 0, "other results are accepted")
    for document in (copy.readme, copy.study / "results-objects.md", copy.a4_figure):
        expect("4321" in document.read_text(), f"{document.name} shows the other result")
    copy.objects.write_text(committed)
    expect(copy.run()[0] == 0, "the committed results are accepted again")


def check_experiment(copy):
    path = copy.root / "benchmarks/results/experiment/people2005.json"
    committed = path.read_text()
    result = json.loads(committed)
    for row in result["means"]:
        row["mean"] *= 10
    for row in result["findings"]:
        row["verdict"] = "disagrees" if row["finding"] == "MANOVA, Object" else "agrees"
    path.write_text(json.dumps(result))
    expect_refused(copy, "--check reports another result of the experiment", "experiment.md")
    expect(copy.run()[0] == 0, "another result of the experiment is accepted")
    mean_s = next(row["mean"] for row in result["means"]
                  if (row["following"], row["outcome"], row["haptic"], row["rotation"]) ==
                  ("delayed", "total time", "NoH", "all"))
    expect("| total time, s | ten people (paper) | 29.0 | 27.5 | 25.0 |\n"
           f"| total time, s | `people2005` | {mean_s:.1f} |" in copy.block("experiment"),
           "the page has the mean of NoH")
    expect("| MANOVA, Object | an effect | **disagrees** | agrees |" in copy.block("findings")
           and "- `people2005` disagrees with 1 of the paper's 17 findings;" in copy.block("findings"),
           "the page names a finding with which one simulation disagrees")
    result["means"] = [row for row in result["means"] if row["outcome"] != "losses of contact"]
    path.write_text(json.dumps(result))
    expect_refused(copy, "an incomplete result is named", "people2005.json")
    path.write_text(committed)
    expect(copy.run()[0] == 0, "the committed experiment is accepted")


def check_contours(copy):
    path = copy.root / "benchmarks/results/contour_angles.csv"
    committed = path.read_text()
    changed = re.sub(r"(?m)^(star,45,forward,27),[^,]*", r"\1,87.65", committed)
    changed = re.sub(r"(?m)^(lock,0,nearest,27),[^,]*", r"\1,0.36", changed)
    path.write_text(changed)
    expect_refused(copy, "--check reports other angles of the hand without delay", "differs")
    expect(copy.run()[0] == 0, "other angles of the hand without delay are accepted")
    rules = copy.block("rules")
    expect("| 0.4 to " in rules and " to 87.7 deg |" in rules,
           "the page has the ranges over objects and starts")
    expect("| lock | 0.4 / " in copy.block("contours"), "the table has the mean of a start")
    path.write_text("".join(line for line in committed.splitlines(keepends=True)
                            if not line.startswith("lock,45,forward,20")))
    expect_refused(copy, "a missing case is named", "contour_angles.csv")
    path.write_text(committed)
    expect(copy.run()[0] == 0, "the committed angles are accepted")


def check_comparison(copy):
    path = copy.root / "benchmarks/results/compare/people2005.json"
    committed = path.read_text()
    result = json.loads(committed)
    for row in result["means"]:
        if row["measure"] == "total time":
            row["mean"] = 0.5
    path.write_text(json.dumps(result))
    expect_refused(copy, "--check reports other means that no figure has", "comparisons.md")
    for row in result["means"]:
        row.update(mean=0.5, standing="best" if row["strategy"] == "mask" else "")
    result["a4_losses"] = [dict(result["a4_losses"][0], measure="total time", strategy=name, role=role)
                           for name, role in (("full", "reference"), ("cd", "technique"))]
    next(row for row in result["strategies"] if row["strategy"] == "cd")["done"] = 0
    path.write_text(json.dumps(result))
    expect_refused(copy, "--check reports another comparison", "strategies.svg")
    expect(copy.run()[0] == 0, "another comparison is accepted")
    text = copy.block("compare")
    expect("| `mask` | **0.5 deg** | **500.0 mm** |" in text and "| `a4` | 0.5 deg | 500.0 mm |" in text,
           "the page has the means, and the best technique in bold")
    expect("| `cd` (*) |" in text, "the page marks a strategy that completed too few trials")
    expect(copy.block("a4_losses").splitlines()[2:] == ["| total time | 0.5 s | `cd` 0.5 s |"],
           "the page states where A4 loses")
    result["means"] = [row for row in result["means"] if row["measure"] != "penetration"]
    path.write_text(json.dumps(result))
    expect_refused(copy, "an incomplete comparison is named", "people2005.json")
    path.write_text(committed)
    expect(copy.run()[0] == 0, "the committed comparison is accepted")


def check_budgets(copy):
    path = copy.root / "benchmarks/results/compare/a4_passive.json"
    committed = path.read_text()
    result = json.loads(committed)
    depths = {"mask": 9e-3, "a4": 4e-3, "a4-passive:5": 5e-3}
    for row in result["means"]:
        if row["measure"] == "penetration":
            row["mean"] = depths.get(row["strategy"], 8e-3)
    path.write_text(json.dumps(result))
    expect_refused(copy, "--check reports other budgets", "differs")
    expect(copy.run()[0] == 0, "other budgets are accepted")
    text = copy.block("a4_passive")
    for row in ("| `mask` | 9.00 mm | 0 % |", "| `a4-passive:5` | 5.00 mm | 80 % |",
                "| `a4-passive:10` | 8.00 mm | 20 % |", "| `a4` | 4.00 mm | 100 % |"):
        expect(row in text, f"the page has the gain of each budget: {row}")
    for row in result["presses"]:
        if row["pause_s"] == 2.0:
            row["depth_m"] = depths.get(row["strategy"], 8e-3)
    path.write_text(json.dumps(result))
    expect(copy.run()[0] == 0 and "| `a4-passive:5` | 5.00 mm | 80 % |" in copy.block("presses"),
           "the page has the gain of presses")
    result["means"] = [row for row in result["means"] if row["strategy"] != "a4"]
    path.write_text(json.dumps(result))
    expect_refused(copy, "a measurement without a4 is named", "a4_passive.json")
    path.write_text(committed)
    expect(copy.run()[0] == 0, "the committed budgets are accepted")


def check_calm_chart(copy):
    path = copy.root / "benchmarks/results/calm_chart/calm_chart.csv"
    committed = path.read_text()
    for outcome, words in (("swings", "1 **broken**"), ("returns energy", "1 **broken**"), ("tripped", "1 let go")):
        path.write_text(committed.replace(",stable,none,", f",{outcome},none,", 1))
        expect_refused(copy, f"--check reports a contact that ended as: {outcome}", "differs")
        expect(copy.run()[0] == 0, "other contacts are accepted")
        for page in (copy.readme, copy.root / "docs/concepts/safety.md"):
            expect(words.replace(" ", "\N{NO-BREAK SPACE}") in page.read_text(),
                   f"{page.name} counts a contact that ended as: {outcome}")
        path.write_text(committed)
        expect(copy.run()[0] == 0, "the committed contacts are accepted")
    path.write_text("\n".join(line for line in committed.splitlines() if ",refused," not in line) + "\n")
    expect(copy.run()[0] == 0, "contacts of which none was refused are accepted")
    cells = re.findall("\\| (\\d+)\N{NO-BREAK SPACE}of\N{NO-BREAK SPACE}(\\d+) ", copy.readme.read_text())
    expect(len(cells) == 12 and all(at_rest == count for at_rest, count in cells),
           "without refused contacts, all came to rest")
    path.write_text(committed.replace("outcome", "end", 1))
    expect_refused(copy, "a table without outcomes is named", "calm_chart")
    path.write_text(committed)
    expect(copy.run()[0] == 0, "the committed contacts are accepted again")


def check_two_machines(copy):
    other = copy.path.with_name("other.json")
    document = json.loads(copy.committed)
    document["context"]["cpu"] = "Another CPU"
    document["context"]["date"] = "2001-01-01T00:00:00+00:00"
    other.write_text(json.dumps(document))
    expect(copy.run()[0] == 0, "results of two machines are accepted")
    expect(copy.block("ticks").count("| sliding |") == 2 and "**Another CPU**" in copy.block("ticks"),
           "the page shows both machines by name")
    expect("Another CPU" not in copy.readme.read_text() and "Another CPU" not in copy.block("speed"),
           "the README shows the newest result")


def main():
    script, project = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
    sys.dont_write_bytecode = True
    sys.path.insert(0, str(script.parent))
    figures = importlib.import_module("result_figures")
    try:
        figures.interpreter()
    except figures.BadInput as error:
        need(False, f"a Python with packages: {error}")
    with tempfile.TemporaryDirectory() as name:
        copy = Copy(script, project, pathlib.Path(name))
        expect(copy.run_program("--check")[0] == 0, "the committed documents match the committed results")
        copy.put([])
        code, output = copy.run()
        expect(code == 0, f"the script runs: {output}")
        without = copy.pages()
        expect(copy.block("accuracy") == "Not measured." and not copy.figure.exists(),
               "without rows of accuracy the table and the figure are left out")
        expect(copy.run("--check")[0] == 0, "--check accepts documents without rows of accuracy")
        check_accuracy(copy)
        check_rows(copy)
        copy.put([])
        expect_refused(copy, "--check reports a figure without data", "accuracy.svg")
        expect(copy.run()[0] == 0 and not copy.figure.exists(), "a figure without data is removed")
        expect(copy.pages() == without, "a table without data is removed")
        copy.path.write_text(copy.committed)
        expect(copy.run()[0] == 0, "the committed results are accepted")
        check_markers(copy)
        check_pictures(copy)
        check_experiment(copy)
        check_contours(copy)
        check_work(copy)
        check_comparison(copy)
        check_budgets(copy)
        check_calm_chart(copy)
        check_two_machines(copy)
    print("the documents follow their results")
    return 0


if __name__ == "__main__":
    sys.exit(main())
