#!/usr/bin/env python3
"""Writes the C++ source that embeds the page of `palpate view`.

embed_page.py OUTPUT.cpp [FOLDER]

FOLDER has the bundled files. Without it, the source embeds no file. Fails if the page is larger than
MOST_BYTES after compression. The same files give the same bytes.
"""

import gzip
import pathlib
import sys

MOST_BYTES = 250_000
FILES = {  # name: path in a request, content type
    "index.html": ("/", "text/html; charset=utf-8"),
    "page.js": ("/page.js", "text/javascript; charset=utf-8"),
    "page.css": ("/page.css", "text/css; charset=utf-8"),
    "icon.svg": ("/icon.svg", "image/svg+xml"),
}
LICENCES = "licences.txt"
BYTES_A_LINE = 64

HEAD = """// Written by embed_page.py.

#include "engine/viewer/page_files.h"

namespace palpate {
namespace {

using namespace std::string_view_literals;

"""


def literal(data):
    """A string literal: three octal digits a byte, because a digit may follow an escape."""
    lines = []
    for begin in range(0, len(data), BYTES_A_LINE):
        part = data[begin:begin + BYTES_A_LINE]
        text = "".join(chr(b) if 32 <= b < 127 and chr(b) not in '"\\?' else f"\\{b:03o}" for b in part)
        lines.append(f'    "{text}"')
    return "\n".join(lines) if lines else '    ""'


def source(files, licences):
    """files: (path, content type, bytes, compressed bytes)."""
    text = HEAD
    for i, (_, _, data, packed) in enumerate(files):
        for name, content in ((f"kBytes{i}", data), (f"kGzip{i}", packed)):
            text += f"constexpr std::string_view {name} =\n{literal(content)}sv;\n"
    text += f"constexpr std::string_view kLicences =\n{literal(licences)}sv;\n"
    if files:
        rows = "".join(f'    {{"{path}", "{kind}", kBytes{i}, kGzip{i}}},\n'
                       for i, (path, kind, _, _) in enumerate(files))
        text += f"constexpr PageFile kFiles[] = {{\n{rows}}};\n"
    span = "kFiles" if files else "{}"
    return text + (
        "\n}  // namespace\n\n"
        f"std::span<const PageFile> embedded_page_files() noexcept {{ return {span}; }}\n"
        "std::string_view page_licences() noexcept { return kLicences; }\n\n"
        "}  // namespace palpate\n")


def main():
    output = pathlib.Path(sys.argv[1])
    if len(sys.argv) < 3:
        output.write_text(source([], b""))
        return 0
    folder = pathlib.Path(sys.argv[2])
    files = []
    for name, (path, kind) in FILES.items():
        data = (folder / name).read_bytes()
        files.append((path, kind, data, gzip.compress(data, 9, mtime=0)))
    total = sum(len(packed) for *_, packed in files)
    if total > MOST_BYTES:
        print(f"{folder}: the page has {total} bytes after compression; expected at most {MOST_BYTES}")
        return 1
    output.write_text(source(files, (folder / LICENCES).read_bytes()))
    return 0


if __name__ == "__main__":
    sys.exit(main())
