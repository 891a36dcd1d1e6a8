#!/usr/bin/env python3
"""Checks that the texts name only what exists.

usage: named_test.py PROJECT

In every text, a link must lead to a file, and to a heading of the first four levels in it, by the name that
GitHub gives to the heading. STUBS, which lead people with old links to the site, may be linked only from the
changelog and from each other. In every page of docs, a path in back quotes must exist that begins with a
folder of the project. In docs/inside, CONTRIBUTING.md, tests/README.md and the README of each room, all code
in back quotes must exist:

    geometry/mesh, gltf/*.h     a folder or file: in the root, beside the text, or, if the name begins with no
                                folder of the root, at the end of some path
    proxy_test                  a source of a test, or a test program; in "`a_test` (in `b_test`)" and
                                "`a_test` in `b_test`", the program b_test must contain a_test
    Suite.*, Suite.Name         a suite of tests
    name, Class::name, name()   an identifier of a source, if it has an underscore, a capital letter or ()
"""

import fnmatch
import os
import pathlib
import re
import sys

FOLDERS = ("geometry", "io", "haptics", "engine", "models", "tests", "benchmarks", "docs")
STUBS = ("MANUAL.md", "ARCHITECTURE.md", "GLOSSARY.md", "benchmarks/RESULTS.md")
CODE = {".h", ".cpp", ".inl", ".in", ".py", ".ts", ".mjs", ".sh", ".json", ".txt"}
# What only Palpate's own files end in; `trials.csv` or `run.json` may be a file of a user.
OWN = (".h", ".cpp", ".inl", ".in", ".py", ".ts", ".mjs", ".dict")
FOREIGN = {"CGAL/Filtered_predicate.h", "CGAL/FPU.h", "CGAL/Mpzf.h",
           "drag.h"}  # the example of an effect
FOREIGN_NAMES = {"DragEffect"}


def files_of(project):
    """All files of the project, as paths relative to it."""
    found = [path.relative_to(project) for path in project.iterdir() if path.is_file()]
    for folder in FOLDERS:
        found += [path.relative_to(project) for path in (project / folder).rglob("*")
                  if path.is_file() and "node_modules" not in path.parts and "__pycache__" not in path.parts]
    return [path.as_posix() for path in found]


def prose(text):
    """The text with its blocks of code left empty."""
    return re.sub(r"^[ \t]*```.*?^[ \t]*```", lambda block: "\n" * block[0].count("\n"), text, flags=re.M | re.S)


def shown(title):
    """The text of a heading: without marks, and with the texts of links only."""
    title = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", title.strip())
    return re.sub(r"\*+|(?<!\w)_+|_+(?!\w)|`", "", re.sub(r"\\(\W)", r"\1", title))


def anchors(text):
    """The names of the headings, as GitHub and MyST give them: the second of two equal ones ends in -1."""
    found = []
    for title in re.findall(r"^#{1,4} (.*)$", prose(text), re.M):
        slug = re.sub(r"[^\w -]", "", shown(title).lower()).replace(" ", "-")
        name, number = slug, 0
        while name in found:
            number += 1
            name = f"{slug}-{number}"
        found.append(name)
    return found


class Project:
    def __init__(self, root):
        self.root = root
        self.files = files_of(root)
        self.folders = {parent.as_posix() for file in self.files for parent in pathlib.PurePath(file).parents}
        texts = {file: (root / file).read_text(encoding="utf-8", errors="replace") for file in self.files
                 if pathlib.PurePath(file).suffix in CODE or "/" not in file and not file.endswith(".md")}
        self.identifiers = set()
        for text in texts.values():
            self.identifiers.update(re.findall(r"\w+", text))
        lists = texts["tests/CMakeLists.txt"] + texts["benchmarks/CMakeLists.txt"]
        self.programs = {}  # to the names of their sources
        for call in re.findall(r"(?:palpate_test|add_executable)\(\s*([^)]+)", lists):
            name, *words = call.split()
            self.programs[name] = {pathlib.PurePath(word).stem for word in words}
        tests = {file: text for file, text in texts.items() if file.startswith("tests/")}
        self.test_sources = {pathlib.PurePath(file).stem for file in tests}
        self.suites = set(re.findall(
            r"(?:palpate_script\(|add_test\(NAME |palpate_page_program\(\w+ \S+ )(\w+)\b", lists))
        for text in tests.values():
            self.suites.update(re.findall(r"\bTEST(?:_F|_P)?\(\s*(\w+)", text))
            self.suites.update(re.findall(r"INSTANTIATE_TEST_SUITE_P\(\s*(\w+)", text))

    def has_path(self, name, beside):
        pattern = name.rstrip("/")
        if any(fnmatch.fnmatchcase(path, start + pattern) for start in ("", beside + "/")
               for path in (*self.files, *self.folders)):
            return True
        if pattern.split("/")[0] in FOLDERS:
            return False
        return any(fnmatch.fnmatchcase(path, "*/" + pattern) for path in self.files)

    def fault(self, token, beside):
        """What is wrong with a token in back quotes, or None."""
        if token in FOREIGN or token in FOREIGN_NAMES:
            return None
        if re.fullmatch(r"[\w.*/-]+", token) and (
                token.endswith(OWN) or "/" in token and token.split("/")[0] in FOLDERS):
            stem = pathlib.PurePath(token).name
            if token.endswith("_test") and stem in self.test_sources:
                return None
            return None if self.has_path(token, beside) else "there is no such file or folder"
        if re.fullmatch(r"\w+_test", token):
            known = token in self.programs or token in self.test_sources or token in self.identifiers
            return None if known else "there is no such test or program"
        if match := re.fullmatch(r"([A-Z]\w+)\.(\*|[A-Z]\w+)", token):
            return None if match[1] in self.suites else "there is no such suite of tests"
        if re.fullmatch(r"\w+(::\w+)*(\(\))?", token) and re.search(r"[A-Z_(:]", token):
            missing = [name for name in re.findall(r"\w+", token) if name not in self.identifiers
                       and not any(known.startswith(name + "_") for known in self.identifiers)]
            return f"no source has {' or '.join(missing)}" if missing else None
        return None


def check_links(project, file, text):
    may_link_stubs = file in STUBS or file == "CHANGELOG.md"
    for number, line in enumerate(re.sub(r"`[^`\n]*`", "", prose(text)).splitlines(), 1):
        for target, anchor in re.findall(r"\]\((?!https?:|mailto:)([^)#\s]*)(?:#([^)\s]+))?\)", line):
            path = (project.root / file).parent / target if target else project.root / file
            name = os.path.relpath(path, project.root)
            if name in STUBS and not may_link_stubs:
                yield f"{file}:{number}: links {target}, which only leads on; link the page"
            elif not path.exists():
                yield f"{file}:{number}: links {target}, which does not exist"
            elif anchor and anchor not in anchors(path.read_text(encoding="utf-8")):
                yield f"{file}:{number}: links {target}#{anchor}, which is no heading there"


def check_paths(project, file, text):
    """Paths in back quotes in a page for users: those that begin with a folder of the project."""
    text = prose(text)
    for match in re.finditer(r"`([\w.*/-]+)`", text):
        if "/" in match[1] and match[1].split("/")[0] in FOLDERS and not project.has_path(match[1], ""):
            yield (f"{file}:{text.count(chr(10), 0, match.start()) + 1}: `{match[1]}`: there is no such file or "
                   "folder")


def check_names(project, file, text):
    beside = pathlib.PurePath(file).parent.as_posix()
    text = prose(text)
    for match in re.finditer(r"`([^`]+)`", text):
        fault = project.fault(match[1], beside)
        if fault:
            yield f"{file}:{text.count(chr(10), 0, match.start()) + 1}: `{match[1]}`: {fault}"
    for sources, program in re.findall(r"((?:`\w+_test`(?:,| and)?\s+)+)\(?in\s+`(\w+_test)`", text):
        source = re.findall(r"\w+_test", sources)[-1]  # the ones before it may stand for themselves
        if source not in project.programs.get(program, ()):
            yield f"{file}: `{source}` in `{program}`: the program does not contain this source"


def check(root):
    """All faults of a project, one line each."""
    project = Project(root)
    faults = []
    for file in project.files:
        if not file.endswith(".md"):
            continue
        text = (root / file).read_text(encoding="utf-8")
        faults += check_links(project, file, text)
        is_of_a_room = file.endswith("/README.md") and not file.startswith(("tests/", "docs/"))
        if file in ("CONTRIBUTING.md", "tests/README.md") or file.startswith("docs/inside/") or is_of_a_room:
            faults += check_names(project, file, text)
        elif file.startswith("docs/"):
            faults += check_paths(project, file, text)
    return faults


def main():
    faults = check(pathlib.Path(sys.argv[1]))
    for fault in faults:
        print(fault)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
