#!/usr/bin/env python3
"""Takes the C++ programs out of the README, as they stand.

usage: readme_programs.py README OUT.cpp...

A ```cpp block that begins with #include begins a program, and those after it go on with it. The
first program becomes the first file, and so on; there must be as many files as programs. A compiler
names the README and its lines.
"""

import pathlib
import re
import sys

BLOCK = re.compile(r"^```cpp\n(.*?)^```$", re.M | re.S)


def programs(readme):
    """The programs of a README, as texts."""
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
            raise ValueError(f"{readme.name}:{line}: the first block of C++ begins no program; "
                             "begin it with its #include lines")
    return found


def main():
    readme, outputs = pathlib.Path(sys.argv[1]), sys.argv[2:]
    try:
        found = programs(readme)
    except ValueError as error:
        return str(error)
    if len(found) != len(outputs):
        return (f"{readme.name}: has {len(found)} programs in C++, but {len(outputs)} are expected; "
                "put the number right in tests/CMakeLists.txt")
    for text, output in zip(found, outputs):
        pathlib.Path(output).write_text(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
