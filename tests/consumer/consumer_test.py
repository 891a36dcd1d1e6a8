#!/usr/bin/env python3
"""Checks that a project with Palpate as a subproject gets only Palpate's libraries.

usage: consumer_test.py CMAKE PROJECT [--build]

Configures tests/consumer in a temporary folder. CMake must search only for the packages in NEEDED and
offer only the targets in LIBRARIES, and compiler options must not leak from one project to the other.
Compiles the programs of the README and of the site with warnings as errors. With --build, builds everything and runs the
programs.
"""

import json
import pathlib
import re
import subprocess
import sys
import tempfile

import readme_programs

LIBRARIES = {f"palpate_{room}" for room in (
    "base", "exact", "mesh", "index", "io", "gltf", "a4", "proxy", "effects", "strategies", "haptics",
    "report", "scene", "devices", "session", "rig", "simulation")}
NEEDED = {"Threads", "Eigen3", "OpenMesh", "nlohmann_json", "draco", "meshoptimizer", "embree", "TBB",
          "TINYGLTF_INCLUDE_DIR", "SPNG_INCLUDE_DIR", "SPNG_LIBRARY", "TURBOJPEG_INCLUDE_DIR",
          "TURBOJPEG_LIBRARY"}
FINDS = {"find_package", "find_program", "find_library", "find_path", "find_file",
         "pkg_check_modules"}
PASSED_ON = {"-ffp-contract=off"}  # to targets that include Palpate's headers


def run(*command, folder=None):
    """Runs a command and returns its output. If it fails, exits with the last lines of the output."""
    done = subprocess.run([str(word) for word in command], cwd=folder, text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if done.returncode:
        sys.exit("\n".join(done.stdout.splitlines()[-40:] +
                           [f"{' '.join(map(str, command))}: failed with {done.returncode}"]))
    return done.stdout


def configure(cmake, project, build, programs):
    """The CMake calls in the project's own CMakeLists.txt files, each as file, line, name, words."""
    query = build / ".cmake/api/v1/query/codemodel-v2"
    query.parent.mkdir(parents=True)
    query.touch()
    trace = build / "trace.json"
    run(cmake, "-S", project / "tests/consumer", "-B", build, "-G", "Ninja",
        "-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON", f"-DPALPATE={project}",
        f"-DPROGRAMS={';'.join(map(str, programs))}",
        "--trace-expand", "--trace-format=json-v1", "--trace-source=CMakeLists.txt",
        f"--trace-redirect={trace}")
    for line in trace.read_text().splitlines():
        call = json.loads(line)
        if "cmd" not in call:
            continue
        file = pathlib.Path(call["file"])
        if file.is_relative_to(project):  # not a file that CMake makes to test the compiler
            yield file.relative_to(project), call["line"], call["cmd"].lower(), call["args"]


def check_finds(calls):
    """Faults of the packages that CMake searches for."""
    found = set()
    for file, line, name, words in calls:
        if name in FINDS:
            found.add(words[0])
            if words[0] not in NEEDED:
                yield (f"{file}:{line}: searches for {words[0]} in a subproject, where no library "
                       "needs it; search only if PROJECT_IS_TOP_LEVEL")
    for name in sorted(NEEDED - found):
        yield f"consumer_test.py: NEEDED contains {name}, which CMake does not search for; remove it"


def check_targets(build, own):
    """Faults of the targets."""
    reply = build / ".cmake/api/v1/reply"
    model = json.loads(next(reply.glob("codemodel-v2-*.json")).read_text())
    targets = {target["name"]: json.loads((reply / target["jsonFile"]).read_text())
               for target in model["configurations"][0]["targets"]}
    for name in sorted(targets.keys() - LIBRARIES - own):
        yield (f"CMakeLists.txt: {name} is built in a subproject; build it only if "
               "PROJECT_IS_TOP_LEVEL")
    for name in sorted((LIBRARIES | own) - targets.keys()):
        yield f"CMakeLists.txt: {name} is not built in a subproject; build it there"
    if "BUILD_TESTING:" in (build / "CMakeCache.txt").read_text():
        yield ("CMakeLists.txt: includes CTest in a subproject; include it only if "
               "PROJECT_IS_TOP_LEVEL")


def check_options(build, project):
    """Faults of the compiler options. Each kind of source must have its own options."""
    seen = set()
    for entry in json.loads((build / "compile_commands.json").read_text()):
        source = pathlib.Path(entry["file"])
        options = {word for word in entry["command"].split() if re.match(r"-(std|[fmW])", word)}
        if source.name == "bystander.cpp":
            kind, expected = "bystander", {"-std=gnu++17"}  # bystander.cpp asserts it
        elif source.is_relative_to(build) and source.name.startswith("readme_"):
            kind, expected = "program", {"-std=gnu++20", "-Wall", "-Wextra", "-Werror"} | PASSED_ON
        elif source.is_relative_to(project):
            kind, expected = "library", None
            for option in {"-std=c++20", "-Wall", "-Wshadow"} | PASSED_ON:
                if option not in options:
                    yield f"{source.relative_to(project)}: is compiled without {option}"
        else:
            continue  # a precompiled header
        seen.add(kind)
        standard = {word for word in expected or () if word.startswith("-std")}
        if expected and options not in (expected, expected - standard):  # the default may be equal
            yield (f"tests/consumer: a {kind} is compiled with {' '.join(sorted(options))}, not with "
                   f"{' '.join(sorted(expected))}; keep options of Palpate's sources private")
    for kind in sorted({"bystander", "program", "library"} - seen):
        yield f"consumer_test.py: the compile commands contain no {kind}"


def main():
    cmake, project = sys.argv[1], pathlib.Path(sys.argv[2]).resolve()
    with tempfile.TemporaryDirectory() as folder:
        build = pathlib.Path(folder).resolve()
        programs = []
        texts = [text for page in readme_programs.PAGES for text in readme_programs.programs(project / page)]
        for number, text in enumerate(texts, 1):
            programs.append(build / f"readme_{number}.cpp")
            programs[-1].write_text(text)
        names = [program.stem for program in programs]
        objects = {f"{name}_object" for name in names}
        faults = [*check_finds(configure(cmake, project, build, programs)),
                  *check_targets(build, {"bystander", *names, *objects}),
                  *check_options(build, project)]
        for fault in faults:
            print(fault)
        if faults:
            return 1
        if sys.argv[3:] == ["--build"]:
            run(cmake, "--build", build)
            for name in names:
                print(run(build / name, folder=project), end="")
        else:
            run(cmake, "--build", build, "--target", "bystander", *sorted(objects))
    return 0


if __name__ == "__main__":
    sys.exit(main())
