#!/usr/bin/env python3
"""Checks that every source lies in a room and includes only files that its room may include.

usage: rooms_test.py PROJECT [LIBRARIES]

docs/inside/index.md defines the rooms in a table `| room | holds | may include |`. A room is a folder with
its files, without its subfolders. `X+` means X and every room that X may include. Sources below
tests/ and benchmarks/ may include every room. The test fails on an include that the table does not
permit, a file that belongs to no room, an include of a missing file, a room without files, a cycle in
the table, and a room of more than MOST_FILES files without a README.md of at most MOST_LINES lines.

LIBRARIES is the file rooms.txt of the build. It has a line `TARGET FOLDER LINKED...` for the library of
each room. The test fails on a library that links the library of a room which its own room may not
include, and on a room with .cpp files but no library.
"""

import pathlib
import re
import sys

TEXT = "docs/inside/index.md"
SOURCES = {".h", ".cpp", ".inl", ".in"}
FOLDERS = ("geometry", "io", "haptics", "engine", "models")
PUBLIC = "palpate"  # FOLDER/include/palpate is included as <palpate/...> or "palpate/..."
FREE = ("tests", "benchmarks")  # may include every room
MOST_FILES = 10
MOST_LINES = 30
WITHOUT_LIBRARY = {"engine/guard"}  # a program
ADDITIONS = pathlib.PurePosixPath("tests/recipes")  # sources of rooms of a copy, which recipes_test.py checks
GENERATED = {"compiled_effects.h"}  # by CMake, from the list of effects
INCLUDE = re.compile(r'\s*#\s*include\s*(?:"([^"]+)"|<(palpate/[^>]+)>)')


class Table:
    """The rooms of docs/inside/index.md, each with the rooms that it may include."""

    def __init__(self, text):
        self.direct = {}
        self.faults = []
        rows = iter(text.splitlines())
        for line in rows:
            if re.match(r"\|\s*room\s*\|\s*holds\s*\|\s*may include\s*\|", line):
                break
        next(rows, None)  # the separator below the heading
        for line in rows:
            if not line.startswith("|"):
                break
            room, _, permitted = (cell.strip() for cell in line.strip()[1:-1].split("|"))
            names = re.findall(r"`([^`]+)`(\+?)", permitted)
            self.direct[room.strip("`")] = names
        if not self.direct:
            self.faults.append(f"{TEXT}: has no table `| room | holds | may include |`")
        for room, names in self.direct.items():
            for name, _ in names:
                if name not in self.direct:
                    self.faults.append(f"{TEXT}: {room} may include {name}, which is not a room")
        if not self.faults:
            self._find_cycles()
        self.permitted = {} if self.faults else {r: self._reach(r) for r in self.direct}

    def _find_cycles(self):
        done = set()

        def visit(room, path):
            if room in path:
                cycle = path[path.index(room):] + [room]
                self.faults.append(f"{TEXT}: the table has a cycle: " + " -> ".join(cycle))
                return
            if room in done:
                return
            for name, _ in self.direct[room]:
                visit(name, path + [room])
            done.add(room)

        for room in self.direct:
            visit(room, [])

    def _reach(self, room):
        """All rooms that a room may include, with the room itself."""
        rooms = {room}
        for name, closed in self.direct[room]:
            rooms |= self._reach(name) if closed else {name}
        return rooms


def sources(project):
    """The paths of all sources, relative to the project."""
    for folder in (*FOLDERS, *FREE):
        for path in sorted((project / folder).rglob("*")):
            name = path.relative_to(project)
            if path.suffix in SOURCES and path.is_file() and ADDITIONS not in name.parents:
                yield name


def public_header(project, included):
    """The path of a public header in the project, from its path as users include it."""
    for folder in FOLDERS:
        place = pathlib.PurePosixPath(folder) / "include" / included
        if (project / place).is_file():
            return place
    return included


def check_file(project, path, table):
    """The faults of one source."""
    is_free = path.parts[0] in FREE
    room = path.parent.as_posix()
    if not is_free and room not in table.permitted:
        yield f"{path}: belongs to no room of {TEXT}"
        return
    text = (project / path).read_text()
    for number, line in enumerate(text.splitlines(), 1):
        match = INCLUDE.match(line)
        if not match or match[1] in GENERATED:
            continue
        included = pathlib.PurePosixPath(match[1] or match[2])
        if included.parts[0] == PUBLIC:
            included = public_header(project, included)
        if not (project / included).is_file():
            yield f'{path}:{number}: includes "{included}", which does not exist in the project\'s root'
        elif not is_free and included.parent.as_posix() not in table.permitted[room]:
            yield (f"{path}:{number}: {room} may not include {included.parent.as_posix()} "
                   f'("{included}")')


def check_readme(project, room, files):
    """The faults of a room's README."""
    readme = project / room / "README.md"
    if not readme.is_file():
        if files > MOST_FILES:
            yield (f"{room}: has {files} sources and no README.md; expected one in each room with "
                   f"more than {MOST_FILES}")
        return
    lines = len(readme.read_text().splitlines())
    if lines > MOST_LINES:
        yield f"{room}/README.md: has {lines} lines; expected at most {MOST_LINES}"


def check_libraries(project, table, text):
    """The faults of the libraries that rooms.txt lists."""
    room_of = {}
    linked = {}
    for line in text.splitlines():
        target, room, *names = line.split()
        room_of[target] = room
        linked[target] = names
    for target, names in linked.items():
        for name in names:
            other = room_of.get(name)
            if other and other not in table.permitted.get(room_of[target], ()):
                yield f"{target}: {room_of[target]} may not link {other} ({name})"
    for room in table.direct:
        has_code = any((project / room).glob("*.cpp"))
        if has_code and room not in WITHOUT_LIBRARY and room not in room_of.values():
            yield f"{room}: has .cpp files and no library of its own (palpate_room)"


def check(project, libraries=None):
    """All faults of a project, one line each."""
    table = Table((project / TEXT).read_text())
    if table.faults:
        return table.faults
    faults = []
    used = {}
    for path in sources(project):
        room = path.parent.as_posix()
        used[room] = used.get(room, 0) + 1
        faults += check_file(project, path, table)
    faults += [f"{TEXT}: {room} has no source" for room in table.direct
               if room not in used]
    for room in table.direct:
        faults += check_readme(project, room, used.get(room, 0))
    if libraries is not None:
        faults += check_libraries(project, table, libraries)
    return faults


def main():
    libraries = pathlib.Path(sys.argv[2]).read_text() if len(sys.argv) > 2 else None
    faults = check(pathlib.Path(sys.argv[1]), libraries)
    for fault in faults:
        print(fault)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
