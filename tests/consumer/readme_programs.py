#!/usr/bin/env python3
"""Extracts the C++ programs of a page without changes.

usage: readme_programs.py PAGE.md OUT.cpp...

A ```cpp block that begins with #include starts a program; the following blocks continue it. The
programs are written to the files in this order; the numbers of programs and files must be equal.
Messages of the compiler refer to the lines of the page.
"""

import pathlib
import re
import sys

PAGES = ("README.md", "docs/start/program.md")  # in the project, each with one program
BLOCK = re.compile(r"^```cpp\n(.*?)^```$", re.M | re.S)


def programs(readme):
    """The programs of a page, as texts."""
    text = readme.read_text()
    found = []
    for block in BLOCK.finditer(text):
        line = text.count("\n", 0, block.start(1)) + 1
        piece = f'#line {line} "{readme.name}"\n{block[1]}'
        if block[1].startswith("#include"):
            found.append(piece)
        elif found:
            found[-1] += piece
        else:
            raise ValueError(f"{readme.name}:{line}: the first block of C++ does not start a program; "
                             "begin the block with #include lines")
    return found


def main():
    readme, outputs = pathlib.Path(sys.argv[1]), sys.argv[2:]
    try:
        found = programs(readme)
    except ValueError as error:
        return str(error)
    if len(found) != len(outputs):
        return (f"{readme.name}: contains {len(found)} programs in C++, but {len(outputs)} are "
                "expected; correct the number in tests/CMakeLists.txt")
    for text, output in zip(found, outputs):
        pathlib.Path(output).write_text(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
