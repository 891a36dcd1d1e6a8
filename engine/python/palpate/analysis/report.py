"""What a command of palpate.analysis makes."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass
class Report:
    """Files by name, the text for a terminal, and warnings of one line each."""

    files: dict[str, str]
    text: str = ""
    warnings: list[str] = field(default_factory=list)
