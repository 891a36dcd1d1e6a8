#!/usr/bin/env python3
"""Follows five recipes of CONTRIBUTING.md in a copy of the project, builds the copy once, and runs them.

usage: recipes_test.py PROJECT BUILD CMAKE NINJA [FOLDER]

Adds an effect, a driver, a strategy, a command and a setting. The new files lie in tests/recipes;
RECIPES has what is inserted into existing files. Each recipe's sentence "Also edit: ..." must name the
existing files that its addition changes, and no others: parts between semicolons are required, a part with
"if" is allowed, and of files joined by "or", one is required.

The copy is configured in a fresh folder and compiled without optimisation. Only rooms in which a source
includes a changed file are compiled; the program gets the other libraries from BUILD, where the target
palpate must be built. FOLDER is kept, for work on this test; otherwise the folder is a temporary one.
"""

import base64
import csv
import json
import math
import pathlib
import random
import re
import resource
import shlex
import shutil
import signal
import sqlite3
import struct
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent / "helpers"))
from needs import need_terminals  # noqa: E402

# What the copy needs of the project.
COPIED = ("geometry", "io", "haptics", "engine", "models", "benchmarks", "tests", "docs", "CMakeLists.txt",
          "CONTRIBUTING.md", "LICENSE", "NOTICES.md", "README.md")
SOURCES = (".h", ".cpp", ".inl", ".in")

MEANING = "part of the force of `mask` that `eased` commands"
SCHEMA = '''        "conveyorForce": {
          "description": "force along the surface, towards the scene's x axis.",
          "type": "number",
          "unit": "N",
          "minimum": 0,
          "maximum": 20
        },
'''
# Per recipe: the folder with its new files, and what each existing file gets: a text of the file, and what
# replaces it.
RECIPES = {
    "An effect": ("an_effect", {
        "haptics/CMakeLists.txt": [(';gravity"', ';gravity;conveyor"')],
        "engine/scene/palpate_extras.schema.json": [
            ('        "creaseAngle": {\n', SCHEMA + '        "creaseAngle": {\n')],
    }),
    "A driver": ("a_driver", {
        "engine/drivers/drivers.cpp": [
            ('#include "engine/drivers/hapi_driver.h"\n',
             '#include "engine/drivers/hapi_driver.h"\n#include "engine/drivers/rail_driver.h"\n'),
            ("&kHapiDriver}", "&kHapiDriver, &kRailDriver}")],
        "engine/drivers/CMakeLists.txt": [("  hapi_driver.cpp\n", "  hapi_driver.cpp\n  rail_driver.cpp\n")],
    }),
    "A strategy": ("a_strategy", {
        "haptics/strategies/strategy.cpp": [
            ('#include "haptics/strategies/control_display.h"\n',
             '#include "haptics/strategies/control_display.h"\n#include "haptics/strategies/eased.h"\n'),
            ("&kControlDisplayStrategy}", "&kControlDisplayStrategy, &kEasedStrategy}")],
    }),
    "A command": ("a_command", {
        "engine/cli/all_commands.h": [
            ("std::unique_ptr<Command> make_devices_command();\n",
             "std::unique_ptr<Command> make_devices_command();\n"
             "std::unique_ptr<Command> make_faces_command();\n"),
            ("  commands.push_back(make_devices_command());\n",
             "  commands.push_back(make_devices_command());\n"
             "  commands.push_back(make_faces_command());\n")],
        "engine/cli/CMakeLists.txt": [("  experiment_power.cpp\n", "  experiment_power.cpp\n  faces_command.cpp\n")],
    }),
    "A setting of a run": (None, {
        "haptics/strategies/haptic_settings.h": [
            ("  AnticipationSettings anticipation;  // of a4-anticipate\n",
             "  AnticipationSettings anticipation;  // of a4-anticipate\n  double eased_share = 0.5;  // of eased\n")],
        "engine/session/run_setting.cpp": [
            ("    setting(CHOICE(a4.table1, ",
             f'    setting(HAPTIC(eased_share), "--eased-share", kTouch, {{0.0, 1.0}}, "{MEANING}", "", "",\n'
             '            {"eased_share"}, {"eased_share"}),\n    setting(CHOICE(a4.table1, ')],
        "docs/reference/settings.md": [
            ("| `--table1` |", f"| `--eased-share` | {MEANING} | 0 to 1; default: `0.5` | `eased_share` |\n| `--table1` |")],
    }),
}

failures = []


def expect(holds, message):
    if not holds:
        failures.append(message)
        print(f"FAILED: {message}", flush=True)


def list_faults(contributing, title, files, changed):
    """How the files that an addition has changed differ from those that its recipe names. files: all files."""
    found = re.search(rf"^\*\*{re.escape(title)}\.\*\*(.*?)(?:\n\n|\Z)", contributing, re.M | re.S)
    if not found:
        return [f"CONTRIBUTING.md: there is no recipe \"{title}\""]
    recipe = " ".join(found[1].split())
    if "Also edit: " not in recipe:
        return [f"CONTRIBUTING.md: the recipe \"{title}\" has no \"Also edit: \""]
    sentence = re.split(r"\.\s+(?=[A-Z])|\.$", recipe.split("Also edit: ")[1])[0]
    faults, allowed = [], set()
    for part in sentence.split(";"):
        named = {name for name in re.findall(r"`([^`]+)`", part) if name in files}
        if not named:
            faults.append(f"CONTRIBUTING.md: the recipe \"{title}\" names no existing file in \"{part.strip()}\"")
        allowed |= named
        if re.search(r"\bif\b", part):
            continue
        for names in [named] if "` or `" in part else [{name} for name in sorted(named)]:
            if len(names & changed) != 1:
                faults.append(f"\"{title}\": its recipe names {' or '.join(sorted(names))}; the addition edits "
                              f"{len(names & changed)} of them")
    return faults + [f"\"{title}\": the addition edits {name}, which its recipe does not name"
                     for name in sorted(changed - allowed)]


def texts_of(folder):
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in sorted(folder.rglob("*"))
            if path.is_file()}


def make_copy(project, copy):
    if copy.exists():
        shutil.rmtree(copy)
    for name in COPIED:
        if (project / name).is_dir():
            shutil.copytree(project / name, copy / name,
                            ignore=shutil.ignore_patterns("node_modules", "__pycache__", "results"))
        else:
            shutil.copy2(project / name, copy / name)


def follow(project, copy, title, before):
    """Makes the addition of a recipe. Returns the files of the copy after it."""
    folder, insertions = RECIPES[title]
    if folder:
        shutil.copytree(project / "tests/recipes" / folder, copy, dirs_exist_ok=True)
    for name, replacements in insertions.items():
        text = (copy / name).read_text()
        for old, new in replacements:
            if text.count(old) != 1:
                sys.exit(f"{name}: has {text.count(old)} times what \"{title}\" replaces; expected it once (adapt "
                         f"RECIPES)\n{old}")
            text = text.replace(old, new)
        (copy / name).write_text(text)
    after = texts_of(copy)
    changed = {name for name in before if before[name] != after.get(name)}
    for fault in list_faults((project / "CONTRIBUTING.md").read_text(), title, before, changed):
        expect(False, fault)
    new = set(after) - set(before)
    print(f"{title}: {len(new)} new, edits {', '.join(sorted(changed))}", flush=True)
    return after


def run(*command, folder=None):
    done = subprocess.run([str(word) for word in command], cwd=folder, text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if done.returncode:
        sys.exit("\n".join(done.stdout.splitlines()[-60:] +
                           [f"{' '.join(map(str, command))}: failed with {done.returncode}"]))
    return done.stdout


def changed_sources(copy, fresh, changed):
    """The sources and headers of the copy that are changed, or include a changed file, also indirectly."""
    generated = fresh / "effects/palpate_effects"  # its header includes those of the effects
    files = {path for name in COPIED if (copy / name).is_dir() for path in (copy / name).rglob("*")
             if path.suffix in SOURCES} | set(generated.glob("*.h"))
    users = {}
    for path in files:
        for name in re.findall(r'^#include "([^"]+)"', path.read_text(), re.M):
            for folder in (copy, copy / "haptics/include", path.parent, generated):
                if (folder / name) in files:
                    users.setdefault(folder / name, set()).add(path)
                    break
    reached, new = set(), {copy / name for name in changed if name.endswith(SOURCES)}
    while new:
        reached |= new
        new = {user for path in new for user in users.get(path, ())} - reached
    return reached


def build_program(project, build, cmake, ninja, folder, changed):
    """Compiles and links the program of the copy. Returns its path."""
    copy, fresh = folder / "copy", folder / "build"
    if fresh.exists():
        shutil.rmtree(fresh)
    # Clang takes half of the time of GCC without optimisation; the libraries of BUILD fit to both.
    compiler = shutil.which("clang++")
    run(cmake, "-S", copy, "-B", fresh, "-G", "Ninja", *([f"-DCMAKE_CXX_COMPILER={compiler}"] if compiler else []),
        f"-DCMAKE_MAKE_PROGRAM={ninja}", "-DCMAKE_BUILD_TYPE=Debug", "-DCMAKE_CXX_FLAGS_DEBUG=-O0 -DNDEBUG",
        "-DCMAKE_CXX_COMPILER_LAUNCHER=", "-DPALPATE_PCH=ON", "-DCMAKE_UNITY_BUILD=ON",
        "-DCMAKE_UNITY_BUILD_BATCH_SIZE=0", "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON", "-DBUILD_TESTING=OFF",
        "-DPALPATE_VIEWER=OFF",
        # Options that single sources are without would keep these out of the large units.
        *(f"-DPALPATE_HAS_{option}=OFF" for option in (
            "fstack_protector_strong", "fcf_protection_full", "mbranch_protection_standard")))
    run(sys.executable, project / "tests/rooms_test.py", copy, fresh / "rooms.txt")
    reached = changed_sources(copy, fresh, changed)
    objects, compiled = {}, {}
    for entry in json.loads((fresh / "compile_commands.json").read_text()):
        output = re.search(r" -o (\S+)", entry["command"])[1]
        target = re.search(r"/CMakeFiles/(palpate_\w+)\.dir/", output)
        if not target or "cmake_pch" in entry["file"]:
            continue
        source = pathlib.Path(entry["file"])
        is_unit = "/Unity/" in entry["file"]
        sources = {pathlib.Path(name) for name in re.findall(r'^#include "([^"]+)"', source.read_text(), re.M)
                   } if is_unit else {source}
        is_reached = bool(reached & sources)
        objects.setdefault(target[1], []).append((output, is_reached or is_unit))
        if is_reached:
            compiled.setdefault(target[1], set()).update(sources)
    *_, link = run(ninja, "-C", fresh, "--quiet", "-t", "commands", "palpate").splitlines()
    words = []
    for word in shlex.split(link):
        library = re.search(r"lib(palpate_\w+)\.a$", word)
        if library and library[1] in compiled:
            for name, is_compiled in objects.pop(library[1], ()):
                if not is_compiled:  # a unit of its own, which BUILD has alone as well
                    run("ar", "x", build / word, pathlib.Path(name).name, folder=fresh)
                    name = pathlib.Path(name).name
                words.append(name)
        elif library and not (build / word).exists():
            sys.exit(f"{build / word} is missing; expected a build of the target palpate")
        else:
            words.append(str(build / word) if library else word)
    run(ninja, "-C", fresh, "-j2", *(word for word in words if "CMakeFiles/" in word and word.endswith(".o")))
    run("sh", "-c", " ".join(word if word in ("&&", ":") else shlex.quote(word) for word in words), folder=fresh)
    shutil.copy2(build / "palpate-guard", fresh / "palpate-guard")
    compiled = {target: sources for target, sources in compiled.items()
                if any(f"/{target}.dir/" in word for word in words)}
    print(f"compiled {sum(map(len, compiled.values()))} sources of {len(compiled)} libraries: "
          f"{', '.join(sorted(compiled))}", flush=True)
    return fresh / "palpate"


def cpu_s():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


# --- The five additions in use ---


class Program:
    def __init__(self, path, folder):
        self.path, self.folder = path, folder

    def start(self, *arguments):
        return subprocess.Popen([str(word) for word in (self.path, *arguments)], text=True, cwd=self.folder,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE)

    def run(self, *arguments, codes=(0,)):
        done = subprocess.run([str(word) for word in (self.path, *arguments)], text=True, cwd=self.folder,
                              capture_output=True, timeout=300)
        expect(done.returncode in codes, f"palpate {' '.join(map(str, arguments))}: ended with {done.returncode}; "
                                         f"expected {codes}\n{done.stdout}{done.stderr}")
        return done.stdout

    def refuses(self, expected, *arguments):
        done = subprocess.run([str(word) for word in (self.path, *arguments)], text=True, cwd=self.folder,
                              capture_output=True, timeout=300)
        expect(done.returncode == 2 and expected in done.stderr,
               f"palpate {' '.join(map(str, arguments))}: ended with {done.returncode} and \"{done.stderr.strip()}\"; "
               f"expected 2 and \"{expected}\"")

    def help(self, *command):
        return " ".join(self.run(*command, "--help").split())


def rows_of(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def vector(row, name):
    return [float(row[f"{name}_{axis}"]) for axis in "xyz"]


def turned(q, v):
    """The vector v, turned by the unit quaternion q (x y z w)."""
    *u, w = q
    cross = lambda a, b: [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    t = [2.0 * c for c in cross(u, v)]
    return [v[i] + w * t[i] + cross(u, t)[i] for i in range(3)]


HALF_M = 0.02


def write_box(path, q, extras):
    """A cube about the origin, turned by q, of a material with these extras."""
    corners = [[HALF_M if k >> axis & 1 else -HALF_M for axis in range(3)] for k in range(8)]
    faces = [0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5]
    data = struct.pack("<24f", *sum(corners, [])) + struct.pack("<36H", *faces)
    path.write_text(json.dumps({
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "scene": 0,
        "nodes": [{"mesh": 0, "rotation": q}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "materials": [{"name": "belt", "extras": {"palpate": extras}}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3",
                       "min": [-HALF_M] * 3, "max": [HALF_M] * 3},
                      {"bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 96},
                        {"buffer": 0, "byteOffset": 96, "byteLength": 72}],
        "buffers": [{"byteLength": 168, "uri": "data:application/octet-stream;base64," +
                     base64.b64encode(data).decode()}]}))


def replay(program, scene, path, *options):
    """The rows of the trace of a path through a scene."""
    program.run("replay", scene, "--trajectory", path, "--out", "trace.csv", "--damping", 0, *options)
    return rows_of(program.folder / "trace.csv")


def check_effect(program, scenes, path, q):
    """With the effect, the force in contact is longer by f (x - (x.n) n)."""
    force_N = 1.5
    write_box(scenes / "belt.gltf", q, {"stiffness": 400, "conveyorForce": force_N})
    write_box(scenes / "still.gltf", q, {"stiffness": 400})
    moving = replay(program, scenes / "belt.gltf", path)
    still = replay(program, scenes / "still.gltf", path)
    touching = 0
    for a, b in zip(moving, still, strict=True):
        n = vector(a, "normal")
        is_active = "conveyor" in a["effects"].split("+")
        expect(is_active == (a["contact"] == "1"), f"tick {a['tick']}: effects {a['effects']}, contact {a['contact']}")
        expect(vector(a, "proxy") == vector(b, "proxy"), f"tick {a['tick']}: the proxy is another one")
        touching += is_active
        for i, (with_N, without_N) in enumerate(zip(vector(a, "full_force"), vector(b, "full_force"))):
            expected_N = is_active * force_N * ((i == 0) - n[0] * n[i])
            # Each of ten roundings at most of the largest number.
            largest_N = max(abs(with_N), abs(without_N), force_N)
            expect(abs(with_N - without_N - expected_N) <= 10 * 2.0 ** -53 * largest_N,
                   f"tick {a['tick']}: the effect adds {with_N - without_N} N; expected {expected_N} N")
    expect(20 < touching < len(moving), f"{touching} of {len(moving)} ticks are in contact; expected a part of them")
    program.refuses("from 0 to 20", "replay", scenes / "belt.gltf", "--trajectory", path, "--material",
                    "belt.conveyorForce=21")
    # The error lists all keys; the schema must have the same.
    done = subprocess.run([str(program.path), "info", str(scenes / "belt.gltf"), "--material", "belt.none=1"],
                          capture_output=True, text=True)
    keys = re.search(r"use one of the keys ([\w, ]+)", done.stderr)
    schema = json.loads((program.path.parent.parent / "copy/engine/scene/palpate_extras.schema.json").read_text())
    expect(keys and set(keys[1].split(", ")) == set(schema["$defs"]["material"]["properties"]),
           f"the schema has other keys than the program: {done.stderr}")


def check_driver(program, scene):
    listed = program.run("devices")
    for part in ("\nrail  ", "\n      travel ", "0.05 to 1 (0.2)", "100 to 2000 (1000)"):
        expect(part in listed, f"palpate devices lacks {part!r}:\n{listed}")
    run_it = ("run", scene, "--seconds", 2, "--json", "--without-realtime", "--out", "on_rail", "--device")
    program.refuses("travel: is 3; expected a number from 0.05 to 1", *run_it, "rail:port=/dev/null,travel=3")
    program.refuses('rate: is "5000"; expected a whole number from 100 to 2000', *run_it,
                    "rail:port=/dev/null,rate=5000")
    program.refuses("port: is missing", *run_it, "rail")
    simulation = program.start("devices", "--simulate", "rail")
    try:
        place = simulation.stdout.readline()
        port = re.search(r"a simulated rail at (\S+)", place)
        if not port:
            return expect(False, f"palpate devices --simulate rail: prints {place!r}")
        # 3: a trip, which is right on a machine that is too busy to tick.
        printed = json.loads(program.run(*run_it, f"rail:port={port[1]},peak=1", codes=(0, 3)))
    finally:
        simulation.send_signal(signal.SIGINT)
        summary = simulation.communicate()[0]
    expect(printed["device"]["name"] == "rail", f"the run names the device {printed['device']}")
    commands = int(re.match(r"(\d+) commands", summary)[1])
    expect(commands > 0, f"the simulated rail got {summary}")
    trace = [row for row in rows_of(program.folder / "on_rail/trace-off.csv") if not row["faults"]]
    places_m = [vector(row, "device") for row in trace]
    expect(len({x for x, *_ in places_m}) > 1 and all(abs(x) <= 0.01 and y == 0.0 for x, y, _ in places_m),
           f"the rail moves by at most 0.01 m along x; the trace has {places_m[:5]}")


def check_strategy_and_setting(program, scenes, path, q):
    """The strategy commands the share of what `mask` commands."""
    write_box(scenes / "box.gltf", q, {})
    box, share = scenes / "box.gltf", 0.25
    for command in ("run", "replay", "compare"):
        expect(re.search(r"\bor eased\b|,cd,eased\b", program.help(command)), f"{command} --help lacks eased")
    expect(f"--eased-share NUMBER=0.5 {MEANING}" in program.help("replay"), "replay --help lacks --eased-share")
    motor = ("--actuators", 1)
    masked = replay(program, box, path, *motor, "--strategy", "mask")
    eased = replay(program, box, path, *motor, "--strategy", "eased", "--eased-share", share)
    pushes = 0
    for a, b in zip(masked, eased, strict=True):
        pushes += any(vector(a, "force"))
        expect([share * x for x in vector(a, "force")] == vector(b, "force"),  # a power of two: exact
               f"tick {a['tick']}: mask commands {vector(a, 'force')}, eased {vector(b, 'force')}")
    expect(pushes > 20, f"mask pushes in {pushes} ticks; expected more than 20")
    program.refuses('--eased-share: is "1.5"; expected a finite number from 0 to 1', "replay", box, "--trajectory",
                    path, "--eased-share", 1.5)


def meta_of(path):
    return dict(sqlite3.connect(path).execute("SELECT key, value FROM meta"))


def check_recording(program, models):
    star = models / "star.glb"
    flags = ("--virtual", "--seconds", 2, "--out", "recorded", "--record")
    program.run("run", star, *flags, "eased.palpate", "--strategy", "eased", "--eased-share", 0.25, codes=(0, 3))
    program.run("run", star, *flags, "mask.palpate", "--strategy", "mask", codes=(0, 3))
    recorded = sorted(program.folder.rglob("*.palpate"))
    eased, masked = (next(p for p in recorded if name in p.name) for name in ("eased", "mask"))
    meta = meta_of(eased)
    expect(meta.get("strategy") == "eased" and meta.get("eased_share") == 0.25,
           f"the recording has strategy {meta.get('strategy')} and eased_share {meta.get('eased_share')}")
    expect("eased_share" not in meta_of(masked), "a recording with the default has the key eased_share")
    expect("eased" in program.run("recording", "info", eased), "recording info does not name the strategy")
    program.run("replay", eased)
    # The replay takes the share from the recording: with another one, bits differ.
    with sqlite3.connect(eased) as changed:
        changed.execute("UPDATE meta SET value = 0.75 WHERE key = 'eased_share'")
    program.run("replay", eased, codes=(1,))


def check_plan(program, models):
    """A plan has the setting and the strategy; each tick of its trial shows both."""
    plan = {"palpate_plan": 1, "name": "eased", "seed": 5, "participants": 1, "blocks": 1, "practice_blocks": 0,
            "strategies": ["mask", "eased"],
            "device": {"sensors": 2, "actuators": 1, "rate_Hz": 1000, "stiffness_N_per_m": 1000,
                       "damping_Ns_per_m": 2, "eased_share": 0.25},
            "display_Hz": 40, "sphere_radius_m": 0.006, "limit_s": 3, "objects": {"O1": str(models / "star.glb")},
            "operator": "people2005", "followings": ["delayed"]}
    (program.folder / "plan.json").write_text(json.dumps(plan))
    program.run("experiment", "run", "plan.json", "--out", "trials", "--jobs", 1, "--traces")
    text = (program.folder / "trials/trials.csv").read_text()
    expect("eased" in text, f"trials.csv does not name the strategy:\n{text}")
    traces = list((program.folder / "trials/traces").rglob("*.csv"))
    pushes = {0.25: 0, 1.0: 0}
    for row in sum(map(rows_of, traces), []):
        force_N, full_N = float(row["force_x"]), float(row["full_force_x"])
        for share in pushes:
            pushes[share] += full_N != 0.0 and force_N == share * full_N
    expect(len(traces) == 2 and min(pushes.values()) > 20,
           f"{len(traces)} traces; ticks with the share of eased and of mask: {pushes}")
    plan["device"]["eased_share"] = 1.5
    (program.folder / "plan.json").write_text(json.dumps(plan))
    program.refuses("eased_share: is 1.5; expected a number from 0 to 1", "experiment", "run", "plan.json", "--out",
                    "none")


def check_command(program, models):
    expect("faces count the triangles of a scene" in program.help(), "the help lacks the command faces")
    expect("count the triangles of a scene" in program.help("faces"), "faces --help lacks what it does")
    for model in (models / "star.glb", models / "torus.glb"):
        printed = program.run("faces", model)
        data = model.read_bytes()
        gltf = json.loads(data[20:20 + struct.unpack("<I", data[12:16])[0]])
        triangles = sum(gltf["accessors"][primitive["indices"]]["count"] // 3 for node in gltf["nodes"]
                        if "mesh" in node for primitive in gltf["meshes"][node["mesh"]]["primitives"])
        expect(printed == f"{triangles} triangles\n", f"faces {model.name}: {printed!r}; expected {triangles}")


def main():
    if len(sys.argv) < 5:
        sys.exit(__doc__)
    project, build = (pathlib.Path(word).resolve() for word in sys.argv[1:3])
    cmake, ninja = sys.argv[3:5]
    need_terminals()  # of the added driver
    seed = random.randrange(2 ** 32)
    print(f"seed {seed}")
    random.seed(seed)
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(sys.argv[5] if len(sys.argv) > 5 else temporary).resolve()
        folder.mkdir(parents=True, exist_ok=True)
        copy = folder / "copy"
        make_copy(project, copy)
        before = original = texts_of(copy)
        for title in RECIPES:
            before = follow(project, copy, title, before)
        if failures:
            sys.exit(1)
        changed = {name for name in before if before[name] != original.get(name)}
        begin_s = cpu_s()
        path = build_program(project, build, cmake, ninja, folder, changed)
        built_s = cpu_s()
        scenes = folder / "scenes"
        shutil.rmtree(scenes, ignore_errors=True)
        scenes.mkdir()
        program = Program(path, scenes)
        q = [random.gauss(0.0, 1.0) for _ in range(4)]
        q = [x / math.hypot(*q) for x in q]
        # Towards the top of the box, into it by up to 4 mm while the hand moves sideways, and out.
        with open(scenes / "path.txt", "w") as file:
            for tick in range(200):
                depth_m = 0.004 * math.sin(math.pi * (tick - 50) / 100)
                point = [0.005 * math.sin(0.05 * tick), 0.003 * math.cos(0.07 * tick), HALF_M - depth_m]
                file.write(" ".join(f"{x:.17g}" for x in turned(q, point)) + "\n")
        check_effect(program, scenes, scenes / "path.txt", q)
        check_driver(program, scenes / "still.gltf")
        check_strategy_and_setting(program, scenes, scenes / "path.txt", q)
        check_recording(program, copy / "models")
        check_plan(program, copy / "models")
        check_command(program, copy / "models")
        print(f"CPU: {built_s - begin_s:.0f} s to build, {cpu_s() - built_s:.0f} s to run")
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
