#!/usr/bin/env python3
"""`experiment export`: a folder of Psych-DS from made trials of people, and its refusals.

export_command_test.py PALPATE

Skipped (exit code 77) without the Python module jsonschema.
"""

import csv
import json
import math
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
from collections import defaultdict

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[1] / "helpers"))
from needs import need  # noqa: E402

try:
    import jsonschema
except ImportError:
    need(False, "the Python module jsonschema: apt-get install python3-jsonschema")

MADE = HERE.parent / "python" / "r"  # 12 made people
SCHEMA = json.loads((HERE / "psych_ds_1.5.0.schema.json").read_text())
RECOMMENDED = SCHEMA["x_recommended"]
PLAN = '{"palpate_plan": 1, "name": "paper-live",\n "seed": 7}\n'
# Four texts of 1 MiB are permitted: more than a plan may have.
TEXTS = json.dumps({"information": "Read <this>.", "consent": "\n" * (1 << 20)}) + "\n"
IDENTITY = ("participant", "block", "haptic", "rotation", "object", "attempt", "pilot")


def check(condition, message):
    if not condition:
        sys.exit(message)


def rows_of(path):
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def files_in(folder):
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())


class Experiment:
    """A folder as `experiment live` leaves it."""

    def __init__(self, palpate, folder):
        self.palpate, self.work = palpate, folder
        self.path = folder / "live"
        self.path.mkdir()
        shutil.copy(MADE / "people.csv", self.path / "trials.csv")
        shutil.copy(MADE / "questionnaires.csv", self.path)
        (self.path / "plan.json").write_text(PLAN)
        (self.path / "texts.json").write_text(TEXTS)
        for name in ("01", "12", "99"):  # nobody has rows of the last one
            of = self.path / "participants" / name
            (of / "recordings").mkdir(parents=True)
            (of / "journal.txt").write_text(f"journal of {name}\n")
            (of / "recordings" / "1-1.palpate").write_bytes(b"SQLite\0" + name.encode())
            (of / "recordings" / "1-2.palpate.part").write_bytes(b"")
        (self.path / "participants" / "12" / "about.json").write_text(
            '{"hand": "right", "age": "30, or \\"31\\""}')

    def export(self, *arguments):
        return subprocess.run([self.palpate, "experiment", "export", *arguments], cwd=self.work,
                              capture_output=True, text=True, encoding="utf-8", timeout=120)

    def exported(self, name, *arguments):
        done = self.export("live", "--out", name, *arguments)
        check(done.returncode == 0, f"{arguments}: {done.stderr}")
        check(done.stdout.startswith("343 rows of 12 participants\n"), done.stdout)
        return self.work / name

    def expect_refused(self, arguments, message):
        before = files_in(self.work)
        done = self.export(*arguments)
        check(done.returncode == 2, f"{arguments}: exit code {done.returncode}: {done.stderr}")
        check(done.stdout == "" and done.stderr.count("\n") == 1, f"{arguments}: {done}")
        check(message in done.stderr, f"{arguments}: {done.stderr}")
        check(files_in(self.work) == before, f"{arguments}: files have changed")


def check_rules_of_files(folder, files):
    """No file is empty; JSON is UTF-8, and none stands in for dataset_description.json below it; the
    keywords in names are official ones; README and CHANGES are there once."""
    check(all((folder / file).stat().st_size > 0 for file in files), "a file is empty")
    for file in files:
        if file.endswith(".json"):
            json.loads((folder / file).read_bytes().decode("utf-8"))
    sidecars = [file for file in files if re.search(r"^data/.*(file_metadata|_data)\.json$", file)]
    check(sidecars == [], f"other columns are described by {sidecars}")
    for file in files:
        if file.endswith("_data.csv"):
            parts = file.rsplit("/")[-1].removesuffix("_data.csv").split("_")
            unknown = {part.split("-")[0] for part in parts} - set(RECOMMENDED["keywords_of_file_names"])
            check(unknown == set(), f"{file}: {unknown}")
    for stem in ("README", "CHANGES"):
        check(len([file for file in files if file.startswith(f"{stem}.")]) == 1, stem)


def check_recommended(folder, files, description):
    """What the standard recommends, and an export leaves to whoever publishes it: its README says so."""
    absent = {pattern for pattern in RECOMMENDED["files"]
              if not any(re.search(pattern, file) for file in files)}
    has_recordings = "data/recordings/subject-01/1-1.palpate" in files
    check(absent == {"^analysis/", "^results/"} | (set() if has_recordings else {"^\\.psychds-ignore$"}),
          f"{absent}")
    fields = set(RECOMMENDED["fields"]) - set(description)
    check(fields == set(RECOMMENDED["fields"]) - {"keywords"}, f"{fields}")
    readme = (folder / "README.md").read_text(encoding="utf-8")
    check(all(name in readme for name in (*fields, "`analysis`", "`results`")), readme)


def check_types_of_schema_org(value):
    """Each object states a type."""
    if isinstance(value, dict):
        check("@type" in value, f"no type: {value}")
        value = list(value.values())
    for part in value if isinstance(value, list) else []:
        check_types_of_schema_org(part)


def check_psych_ds(folder):
    """The rules of Psych-DS: errors by the schema and here, and what it recommends."""
    description = json.loads((folder / "dataset_description.json").read_bytes().decode("utf-8"))
    files = files_in(folder)
    jsonschema.validate({"files": files, "dataset_description": description}, SCHEMA)
    check(description["schemaVersion"] == "1.5.0", description["schemaVersion"])
    check_rules_of_files(folder, files)
    check_recommended(folder, files, description)
    check_types_of_schema_org(description)
    names = [variable["name"] for variable in description["variableMeasured"]]
    check(len(set(names)) == len(names), "a variable is there twice")
    used = set()
    for file in files:
        if not file.endswith("_data.csv"):
            continue
        with open(folder / file, encoding="utf-8", newline="") as lines:
            header, *rows = csv.reader(lines, strict=True)
        check(len(set(header)) == len(header) and header and rows, f"{file}: {header}")
        check({len(row) for row in rows} == {len(header)}, f"{file}: rows of other lengths")
        check("row_id" not in header, f"{file} has row_id, whose values must be unique")
        check(all(header), f"{file}: a column without a name")
        check(set(header) <= set(names), f"{file}: not described: {set(header) - set(names)}")
        used |= set(header)
    check(used == set(names), f"described, but in no file: {set(names) - used}")
    return description


def check_schema_can_fail(folder):
    description = json.loads((folder / "dataset_description.json").read_text())
    files = files_in(folder)
    for wrong in ({"files": ["dataset_description.json"]}, {"files": [*files, "data/subject_data.csv"]},
                  {"files": [*files, "data/subject-1_data.txt"]}, {"files": [*files, "README.rst"]},
                  {"files": [*files, "data/dataset_description.json"]},
                  {"files": [file for file in files if file != "dataset_description.json"]},
                  *({"dataset_description": {key: value for key, value in description.items() if key != lost}}
                    for lost in ("@context", "@type", "name", "description", "variableMeasured")),
                  {"dataset_description": {**description, "@context": "https://example.org/"}},
                  {"dataset_description": {**description, "author": "Ann"}},
                  {"dataset_description": {**description, "@type": "Data"}},
                  {"dataset_description": {**description, "variableMeasured": [{"name": "x"}]}}):
        document = {"files": files, "dataset_description": description, **wrong}
        try:
            jsonschema.validate(document, SCHEMA)
        except jsonschema.ValidationError:
            continue
        sys.exit(f"the schema permits {wrong}")


def counted_trials(rows):
    """The attempt at each trial that counts: the last one that is done, or the last one."""
    attempts = defaultdict(list)
    for row in rows:
        if row["block"] != "0" and row["pilot"] == "0":
            attempts[tuple(row[name] for name in IDENTITY[:5])].append(row)
    return [max([row for row in tried if row["status"] == "done"] or tried, key=lambda row: int(row["attempt"]))
            for tried in attempts.values()]


def number(row, name):
    return float(row[name]) if row["status"] == "done" and row[name] not in ("", "NA") else None


def depth_dm(row):
    if "mean_penetration_dm" in row:
        return number(row, "mean_penetration_dm")
    depth_m = number(row, "mean_penetration_m")
    return None if depth_m is None else 10 * depth_m


OUTCOMES = {
    "total time": lambda row: number(row, "total_time_s"),
    "losses of contact": lambda row: number(row, "losses_of_contact"),
    "mean penetration": depth_dm,
    "mean contact angle": lambda row: number(row, "mean_contact_angle_deg"),
    "losses of contact per second": lambda row: (
        None if row["status"] != "done" else number(row, "losses_of_contact") / number(row, "total_time_s")),
    "total time, timeouts as the limit": lambda row: (
        120.0 if row["status"] == "timeout" else number(row, "total_time_s"))}
HAPTIC, ROTATION = ("NoH", "UaH", "H"), ("NoR", "R")


def mean(values):
    return math.fsum(values) / len(values) if values and None not in values else None


def means_of_participants(values, objects):
    """{(haptic, rotation): {participant: mean}} of those who have all conditions. values: (row, number)."""
    found = {}
    levels = {"both": [([h], [r]) for h in HAPTIC for r in ROTATION],
              "haptic": [([h], ROTATION) for h in HAPTIC], "rotation": [(HAPTIC, [r]) for r in ROTATION],
              "UaH": [(["UaH"], [r]) for r in ROTATION]}
    cells = defaultdict(list)
    for row, value in values:
        if value is not None:
            cells[row["participant"], row["haptic"], row["rotation"], row["object"]].append(value)
    people = {key[0] for key in cells}
    for kind, sides in levels.items():
        table = {person: [mean([mean([mean(cells.get((person, h, r, o), [])) for o in objects])
                                for h in hs for r in rs]) for hs, rs in sides] for person in people}
        whole = [row for row in table.values() if None not in row]
        for place, (hs, rs) in enumerate(sides):
            name = (hs[0] if len(hs) == 1 else "all", rs[0] if len(rs) == 1 else "all")
            found[kind, *name] = [row[place] for row in whole]
    return found


def means_of(rows):
    """{(of, outcome, haptic, rotation, object): (count, mean)}, as `experiment analyse` names them."""
    counted, found = counted_trials(rows), {}
    objects = sorted({row["object"] for row in counted})
    for outcome, value_of in OUTCOMES.items():
        values = [(row, value_of(row)) for row in counted]
        for h, r, o in [*((h, r, "all") for h in ("all", *HAPTIC) for r in ("all", *ROTATION)),
                        *(("all", "all", o) for o in objects)]:
            of = [value for row, value in values if value is not None and h in ("all", row["haptic"])
                  and r in ("all", row["rotation"]) and o in ("all", row["object"])]
            found["trials", outcome, h, r, o] = (len(of), mean(of))
        for (kind, h, r), of in means_of_participants(values, objects).items():
            if kind != "UaH":
                found["participants", outcome, h, r, "all"] = (len(of), mean(of))
            elif outcome == "mean contact angle":
                found["participants, UaH", outcome, h, r, "all"] = (len(of), mean(of))
    return found


def means_of_r(folder):
    """The same by R; None: R is not installed."""
    if shutil.which("Rscript") is None:
        return None
    done = subprocess.run(["Rscript", "--vanilla", HERE / "export_means.R", folder], check=True,
                          capture_output=True, text=True, encoding="utf-8", timeout=120)
    lines = [line.split(";") for line in done.stdout.splitlines()]
    return {tuple(names): (int(count), float(value)) for *names, count, value in lines}


def check_means(folder, rows):
    """Python, and R where it is installed, read every mean of `experiment analyse` from the data files.
    people_agreement_test.py shows that the expected ones, which R computed of the source, are its own."""
    table = json.loads((MADE / "people.json").read_text())["tables"]["means"]
    expected = {tuple(row[name] for name in ("of", "outcome", "haptic", "rotation", "object")):
                (row["n"], row["mean"]) for row in table}
    found = {"Python": means_of(rows), "R": means_of_r(folder)}
    for reader, means in found.items():
        if means is None:
            continue
        check(set(means) == set(expected), f"{reader}: other means: {set(means) ^ set(expected)}")
        for key, (count, value) in expected.items():
            # The expected ones have 12 digits.
            is_same = means[key][0] == count and math.isclose(means[key][1], value, rel_tol=1e-11)
            check(is_same, f"{reader}, {key}: {means[key]}; expected {(count, value)}")
    print(f"{len(expected)} means: read by {' and '.join(name for name in found if found[name])}")


def check_rows(experiment, folder):
    """Each row is there once, in the file of its participant, and every mean is that of the source."""
    source = rows_of(experiment.path / "trials.csv")
    found = []
    for participant in range(1, 13):
        rows = rows_of(folder / f"data/subject-{participant:02}_task-contour_data.csv")
        check({row["participant"] for row in rows} == {str(participant)}, "another participant's row")
        found += rows
    key = lambda row: tuple(row[name] for name in IDENTITY)  # noqa: E731
    by_key = {key(row): row for row in found}
    check(len(found) == len(by_key) == len(source) == 343, "rows are lost or there twice")
    for row in source:
        same = by_key[key(row)]
        for name, value in row.items():
            is_same = same[name] == value or float(same[name]) == float(value)
            check(is_same, f"{key(row)}, {name}: {same[name]}; expected {value}")

    check_means(folder, found)
    answers = [row for participant in range(1, 13) for row in
               rows_of(folder / f"data/subject-{participant:02}_task-questionnaire_data.csv")]
    order = lambda row: sorted(row.items())  # noqa: E731
    expected = rows_of(experiment.path / "questionnaires.csv")
    check(sorted(answers, key=order) == sorted(expected, key=order), "answers differ")


def check_description(description):
    variables = {variable["name"]: variable for variable in description["variableMeasured"]}
    check(description["name"] == "paper-live", description["name"])
    time = variables["total_time_s"]
    check((time["unitText"], time["minValue"]) == ("s", 0) and "maxValue" not in time, f"{time}")
    levels = [level["name"] for level in variables["status"]["valueReference"]]
    check(levels == ["done", "timeout", "fault", "aborted", "skipped"], f"{levels}")
    density = variables["css_px_per_mm"]
    check(density["unitText"] == "1/mm" and "above 0" in density["description"], f"{density}")
    check(variables["value"]["maxValue"] == 100, f"{variables['value']}")
    check("age" not in variables, "age is described without a request")


def check_what_is_requested(experiment, plain):
    """What tells more about people is there on request only."""
    files = files_in(plain)
    check(not any("recordings" in file or "journal" in file or "about" in file for file in files), f"{files}")
    check((plain / "materials/plan.json").read_text() == PLAN, "another plan")
    check((plain / "materials/texts.json").read_text() == TEXTS, "other texts")
    everything = experiment.exported("everything", "--with", "recordings,notes,about")
    check_psych_ds(everything)
    more = sorted(set(files_in(everything)) - set(files))
    check(more == [".psychds-ignore", "data/recordings/subject-01/1-1.palpate",
                   "data/recordings/subject-12/1-1.palpate", "data/task-about_data.csv",
                   "documentation/journals/subject-01.txt", "documentation/journals/subject-12.txt"], f"{more}")
    check(rows_of(everything / "data/task-about_data.csv") == [
        {"participant": "12", "age": '30, or "31"', "gender": "", "hand": "right", "experience": ""}],
        "other answers")
    copied = (everything / "data/recordings/subject-12/1-1.palpate").read_bytes()
    check(copied == b"SQLite\x0012", "another recording")


def check_refusals(experiment):
    path = experiment.path
    experiment.expect_refused(["live", "--out", "dataset"], "dataset: exists already; expected a new")
    experiment.expect_refused(["live", "--out", "live/new"], "live/new: is inside of the folder")
    experiment.expect_refused(["nowhere", "--out", "new"], "nowhere/trials.csv")
    experiment.expect_refused(["live"], "--out")
    experiment.expect_refused(["live", "--out", "new", "--with", "names"], "names")
    about = path / "participants" / "12" / "about.json"
    text = about.read_text()
    about.write_text('{"address": "here"}')
    experiment.expect_refused(["live", "--out", "new", "--with", "about"], "about.json: /address")
    about.write_text(text)
    trials = (path / "trials.csv").read_text()
    (path / "trials.csv").write_text(trials.replace("\n3,", "\nAnn,"))
    experiment.expect_refused(["live", "--out", "new"], 'column participant: is "Ann"; expected a number')
    (path / "trials.csv").write_text(trials.replace("done", "ended", 1))
    experiment.expect_refused(["live", "--out", "new"], "line 2, column status")
    (path / "trials.csv").write_text(trials)
    answers = (path / "questionnaires.csv").read_text()
    (path / "questionnaires.csv").write_text(answers + "1,1,H,R,real,9\n")
    experiment.expect_refused(["live", "--out", "new"], "questionnaires.csv: line")
    (path / "questionnaires.csv").write_text(answers)
    (path / "plan.json").write_text('{"seed": 7}')
    experiment.expect_refused(["live", "--out", "new"], "plan.json: /name: is missing")
    (path / "plan.json").write_text(PLAN)


def main():
    palpate = str(pathlib.Path(sys.argv[1]).resolve())
    with tempfile.TemporaryDirectory() as folder:
        experiment = Experiment(palpate, pathlib.Path(folder))
        plain = experiment.exported("dataset")
        check_description(check_psych_ds(plain))
        check_schema_can_fail(plain)
        check_rows(experiment, plain)
        check_what_is_requested(experiment, plain)
        check_refusals(experiment)
        again = experiment.exported("deeper/again")
        check({file: (again / file).read_bytes() for file in files_in(again)}
              == {file: (plain / file).read_bytes() for file in files_in(plain)}, "bytes differ")
    print("an export is a folder of Psych-DS with every row, and nothing more than was asked for")


if __name__ == "__main__":
    main()
