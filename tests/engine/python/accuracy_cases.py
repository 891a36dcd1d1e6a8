"""What `palpate accuracy` measured in three cases, and the pages that C++ made of them.

star: all knobs and a scene. gallery: five knobs, a scene with surfaces of their own, an exact
encoder and a stated delay. sample: made-up knobs, one of them with hostile
texts.
"""

from __future__ import annotations

import functools
import json
import pathlib
import sys
import tarfile
from typing import Any

_ARCHIVE = pathlib.Path(__file__).with_name("oracle") / "accuracy_pages.tar.xz"


@functools.cache
def _files() -> dict[str, str]:
    with tarfile.open(_ARCHIVE) as archive:
        return {member.name: archive.extractfile(member).read().decode() for member in archive}


def facts(case: str) -> Any:
    """The content of accuracy.json, with the members that came after the pages of C++."""
    content = json.loads(_files()[f"{case}/accuracy.json"])
    content["advice"]["busy"] = ""
    for knob in content["knobs"]:
        knob["undecided"] = None
    return content


def old_page(case: str) -> list[str]:
    """The lines of the page that C++ made."""
    return _files()[f"{case}/page.txt"].splitlines()


def put(case: str, folder: pathlib.Path, content: Any = None) -> pathlib.Path:
    """Write the files that the page is made from; content: instead of accuracy.json."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "stiffness.svg").write_text(_files()[f"{case}/stiffness.svg"], encoding="utf-8")
    text = json.dumps(facts(case) if content is None else content, ensure_ascii=False)
    (folder / "accuracy.json").write_text(text, encoding="utf-8")
    return folder


if __name__ == "__main__":  # the page of the sample in a folder, for the test in a browser
    sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "engine/python"))
    from palpate.analysis.__main__ import main

    results = put("sample", pathlib.Path(sys.argv[1]))
    sys.exit(main(["accuracy", str(results), "--out", str(results)]))
