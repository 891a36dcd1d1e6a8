#!/usr/bin/env python3
"""Checks that every source lies in a room and includes only files that its room may include.

usage: rooms_test.py PROJECT

ARCHITECTURE.md defines the rooms in a table `| room | holds | may include |`. A room is a folder with
its files, without its subfolders. `X+` means X and every room that X may include. Sources below
tests/ and benchmarks/ may include every room. The test fails on an include that the table does not
permit, a file that belongs to no room, an include of a missing file, a room without files, and a
cycle in the table.
"""

import pathlib
import re
import sys

SOURCES = {".h", ".cpp", ".inl", ".in"}
FOLDERS = ("geometry", "io", "haptics", "engine", "models")
PUBLIC = "palpate"  # FOLDER/include/palpate is included as <palpate/...> or "palpate/..."
FREE = ("tests", "benchmarks")  # may include every room
GENERATED = {"compiled_effects.h"}  # by CMake, from the list of effects
INCLUDE = re.compile(r'\s*#\s*include\s*(?:"([^"]+)"|<(palpate/[^>]+)>)')


class Table:
    """The rooms of ARCHITECTURE.md, each with the rooms that it may include."""

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
            self.faults.append("ARCHITECTURE.md: has no table `| room | holds | may include |`")
        for room, names in self.direct.items():
            for name, _ in names:
                if name not in self.direct:
                    self.faults.append(f"ARCHITECTURE.md: {room} may include {name}, which is not a room")
        if not self.faults:
            self._find_cycles()
        self.permitted = {} if self.faults else {r: self._reach(r) for r in self.direct}

    def _find_cycles(self):
        done = set()

        def visit(room, path):
            if room in path:
                cycle = path[path.index(room):] + [room]
                self.faults.append("ARCHITECTURE.md: the table has a cycle: " + " -> ".join(cycle))
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
            if path.suffix in SOURCES and path.is_file():
                yield path.relative_to(project)


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
        yield f"{path}: belongs to no room of ARCHITECTURE.md"
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


def check(project):
    """All faults of a project, one line each."""
    table = Table((project / "ARCHITECTURE.md").read_text())
    if table.faults:
        return table.faults
    faults = []
    used = set()
    for path in sources(project):
        used.add(path.parent.as_posix())
        faults += check_file(project, path, table)
    faults += [f"ARCHITECTURE.md: {room} has no source" for room in table.direct
               if room not in used]
    return faults


def main():
    faults = check(pathlib.Path(sys.argv[1]))
    for fault in faults:
        print(fault)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
