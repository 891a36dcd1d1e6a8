#!/usr/bin/env python3
"""Every block of code in a page has a language, or has command lines; what can be read is read.

usage: code_blocks_test.py PROJECT

In README.md, CONTRIBUTING.md and docs: a block without a language begins with a command line. JSON parses and
Python compiles as they stand. C++ belongs to a program that the tests compile (PROGRAMS); CMake names only
targets of the project. A program in README.md has at most MOST_LINES lines.
"""

import json
import pathlib
import re
import sys
import textwrap

PROGRAMS = ("README.md", "docs/start/program.md")  # tests/consumer/readme_programs.py
MOST_LINES = 30
SHELLS = ("", "sh")
UNREAD = ("text", "nginx", "glsl", "ini", "xml")
FENCE = re.compile(r"^([ \t]*)(`{3,}|~{3,})[ \t]*([^\n`]*)\n(.*?)^\1\2[ \t]*$", re.M | re.S)
# The first word of a command line, or a variable before it.
COMMAND = re.compile(r"(\$ )?(\./|[A-Z_]+=\S+ |palpate\b|git\b|cmake\b|ninja\b|ctest\b|docs/|tests/|benchmarks/|"
                     r"export\b|sudo\b|apt-get\b|ssh\b|cd\b|for\b|python3\b|sbatch\b|#)")


def blocks(text):
    """The blocks of a text: line, language, body."""
    for match in FENCE.finditer(text):
        yield text.count("\n", 0, match.start()) + 1, match[3].strip(), textwrap.dedent(match[4])


def fault(file, language, body, targets):
    """What is wrong with a block, or None."""
    if language.startswith("{"):
        return None if re.match(r"\{(toctree|include)\}", language) else f"has the directive {language}"
    if language in SHELLS:
        first = next((line.strip() for line in body.splitlines() if line.strip()), "")
        return None if COMMAND.match(first) else f"has no language and no command line: {first!r}; use text"
    if language in UNREAD:
        return None
    if language == "json":
        try:
            json.loads(body)
        except ValueError as error:
            return f"is no JSON: {error}"
        return None
    if language == "python":
        try:
            compile(body, file, "exec")
        except SyntaxError as error:
            return f"is no Python: {error}"
        return None
    if language == "cpp":
        if file not in PROGRAMS:
            return "is C++ that no test compiles; use text, or put it into a program"
        if file == "README.md" and body.count("\n") > MOST_LINES:
            return f"has {body.count(chr(10))} lines; expected at most {MOST_LINES}"
        return None
    if language == "cmake":
        missing = [name for name in re.findall(r"palpate::\w+", body) if name not in targets]
        return f"names {', '.join(missing)}, which is no target" if missing else None
    return f"has the language {language}, of which this test knows nothing"


def check(project):
    targets = re.findall(r"palpate::\w+", "".join(
        path.read_text(encoding="utf-8") for path in project.glob("**/CMakeLists.txt")
        if "build" not in path.relative_to(project).parts))
    files = [project / "README.md", project / "CONTRIBUTING.md", *sorted((project / "docs").rglob("*.md"))]
    counts = {}
    faults = []
    for path in files:
        file = path.relative_to(project).as_posix()
        text = path.read_text(encoding="utf-8")
        for line, language, body in blocks(text):
            counts[language.split()[0] if language else "commands"] = counts.get(
                language.split()[0] if language else "commands", 0) + 1
            found = fault(file, language, body, targets)
            if found:
                faults.append(f"{file}:{line}: {found}")
        rest = FENCE.sub("", text)
        if re.search(r"^[ \t]*(```|~~~)", rest, re.M):
            faults.append(f"{file}: a block has no end")
    return faults, counts


def main():
    faults, counts = check(pathlib.Path(sys.argv[1]).resolve())
    for found in faults:
        print(found)
    print(", ".join(f"{count} {language}" for language, count in sorted(counts.items())))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
