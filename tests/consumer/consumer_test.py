#!/usr/bin/env python3
"""Checks what a project gets that has Palpate below it: the libraries, and nothing else.

usage: consumer_test.py CMAKE PROJECT [--build]

Configures tests/consumer in a folder that goes again. What is looked for and what can be built must
be what NEEDED and LIBRARIES say, and options must stay with whom they are of. Compiles the README's
programs with warnings as errors; with --build all of it, and runs them.
"""

import json
import pathlib
import re
import subprocess
import sys
import tempfile

import readme_programs

LIBRARIES = {"palpate_geometry", "palpate_io", "palpate_haptics", "palpate_engine"}
NEEDED = {"Threads", "Eigen3", "OpenMesh", "nlohmann_json", "draco", "meshoptimizer", "embree", "TBB",
          "TINYGLTF_INCLUDE_DIR", "SPNG_INCLUDE_DIR", "SPNG_LIBRARY", "TURBOJPEG_INCLUDE_DIR",
          "TURBOJPEG_LIBRARY"}
FINDS = {"find_package", "find_program", "find_library", "find_path", "find_file",
         "pkg_check_modules"}
HANDED_ON = {"-ffp-contract=off"}  # to whoever includes our headers


def run(*command, folder=None):
    """Output of a command; a fault, with the end of what it said, if it fails."""
    done = subprocess.run([str(word) for word in command], cwd=folder, text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if done.returncode:
        sys.exit("\n".join(done.stdout.splitlines()[-40:] +
                           [f"{' '.join(map(str, command))}: failed with {done.returncode}"]))
    return done.stdout


def configure(cmake, project, build, programs):
    """The calls of CMake in the project's own CMakeLists.txt files, each as file, line, name, words."""
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
        if file.is_relative_to(project):  # not one that CMake makes to try a compiler
            yield file.relative_to(project), call["line"], call["cmd"].lower(), call["args"]


def check_finds(calls):
    """Faults of what is looked for."""
    found = set()
    for file, line, name, words in calls:
        if name in FINDS:
            found.add(words[0])
            if words[0] not in NEEDED:
                yield (f"{file}:{line}: looks for {words[0]} below another project, where no library "
                       "needs it; do so on top only (PROJECT_IS_TOP_LEVEL)")
    for name in sorted(NEEDED - found):
        yield f"consumer_test.py: NEEDED names {name}, which is not looked for; take it out"


def check_targets(build, own):
    """Faults of what can be built."""
    reply = build / ".cmake/api/v1/reply"
    model = json.loads(next(reply.glob("codemodel-v2-*.json")).read_text())
    targets = {target["name"]: json.loads((reply / target["jsonFile"]).read_text())
               for target in model["configurations"][0]["targets"]}
    for name in sorted(targets.keys() - LIBRARIES - own):
        yield (f"CMakeLists.txt: {name} is built below another project; build it on top only "
               "(PROJECT_IS_TOP_LEVEL)")
    for name in sorted((LIBRARIES | own) - targets.keys()):
        yield f"CMakeLists.txt: {name} is not built below another project"
    if "BUILD_TESTING:" in (build / "CMakeCache.txt").read_text():
        yield "CMakeLists.txt: asks for CTest below another project; do so on top only"


def check_options(build, project):
    """Faults of the options of the compiler; each kind of source has those that are its own."""
    seen = set()
    for entry in json.loads((build / "compile_commands.json").read_text()):
        source = pathlib.Path(entry["file"])
        options = {word for word in entry["command"].split() if re.match(r"-(std|[fmW])", word)}
        if source.name == "bystander.cpp":
            kind, expected = "bystander", {"-std=gnu++17"}  # as it asserts
        elif source.is_relative_to(build) and source.name.startswith("readme_"):
            kind, expected = "program", {"-std=gnu++20", "-Wall", "-Wextra", "-Werror"} | HANDED_ON
        elif source.is_relative_to(project):
            kind, expected = "library", None
            for option in {"-std=c++20", "-Wall", "-Wshadow"} | HANDED_ON:
                if option not in options:
                    yield f"{source.relative_to(project)}: is compiled without {option}"
        else:
            continue  # a precompiled header
        seen.add(kind)
        standard = {word for word in expected or () if word.startswith("-std")}
        if expected and options not in (expected, expected - standard):  # it may be the default
            yield (f"tests/consumer: a {kind} is compiled with {' '.join(sorted(options))}, not with "
                   f"{' '.join(sorted(expected))}; what is of our sources alone must not be handed on")
    for kind in sorted({"bystander", "program", "library"} - seen):
        yield f"consumer_test.py: no {kind} is among the compile commands"


def main():
    cmake, project = sys.argv[1], pathlib.Path(sys.argv[2]).resolve()
    with tempfile.TemporaryDirectory() as folder:
        build = pathlib.Path(folder).resolve()
        programs = []
        for number, text in enumerate(readme_programs.programs(project / "README.md"), 1):
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
