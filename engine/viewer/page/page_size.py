#!/usr/bin/env python3
"""Prints the size of a page after compression. Fails if it is too large.

page_size.py FILE...
"""

import gzip
import pathlib
import sys

MOST_BYTES = 250_000


def main():
    sizes = {path: len(gzip.compress(pathlib.Path(path).read_bytes())) for path in sys.argv[1:]}
    total = sum(sizes.values())
    print(f"{pathlib.Path(sys.argv[1]).name} with its files: {total} bytes after compression, of at most {MOST_BYTES}")
    if total <= MOST_BYTES:
        return 0
    for path, size in sizes.items():
        print(f"{path}: {size} bytes")
    return 1


if __name__ == "__main__":
    sys.exit(main())
