"""Archives of the oracle: the same files give the same bytes."""

from __future__ import annotations

import io
import json
import lzma
import tarfile
from pathlib import Path
from typing import Any


def _order(name: str) -> tuple[str, str]:
    """Files of one kind are neighbours, so that their common texts are packed once."""
    case, _, file = name.partition("/")
    return file, case


def pack(path: Path, files: dict[str, bytes]) -> None:
    """files: "CASE/FILE" and its content."""
    raw = io.BytesIO()
    with tarfile.open(fileobj=raw, mode="w", format=tarfile.USTAR_FORMAT) as archive:
        for name in sorted(files, key=_order):
            member = tarfile.TarInfo(name)
            member.size = len(files[name])
            archive.addfile(member, io.BytesIO(files[name]))
    path.parent.mkdir(parents=True, exist_ok=True)
    filters = [{"id": lzma.FILTER_LZMA2, "preset": 9 | lzma.PRESET_EXTREME, "dict_size": 1 << 26}]
    path.write_bytes(lzma.compress(raw.getvalue(), filters=filters))


def write_index(path: Path, index: dict[str, Any]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps(dict(sorted(index.items())), indent=1, ensure_ascii=False)
    path.write_text(text + "\n", encoding="utf-8")
