"""Errors as the program prints them, and text from files made safe for one line."""

from __future__ import annotations

import unicodedata

# Characters that are drawn as nothing, so that two different names could look alike.
_INVISIBLE = frozenset([0x00AD, 0x034F, 0x061C, 0x115F, 0x1160, 0x17B4, 0x17B5, 0x180E, 0x3164,
                        0xFEFF, 0xFFA0, *range(0x180B, 0x180E), *range(0x200B, 0x2010),
                        *range(0x2028, 0x202F), *range(0x2060, 0x2070), *range(0xE0000, 0xE0080)])
_NOT_TEXT = ("Cc", "Cs", "Zl", "Zp")


def printable(text: str) -> str:
    """Return the text with a space for each control, bidirectional or invisible character."""
    if text.isascii() and text.isprintable():
        return text
    return "".join(
        " " if ord(c) in _INVISIBLE or unicodedata.category(c) in _NOT_TEXT else c for c in text
    )


class InputError(Exception):
    """Bad input: the program prints it as one line and ends with 2.

    path: the file, as the user named it. element: the line, column or option. problem: what was
    found and what was expected. hint: what the user can do. All but the problem may be empty.
    """

    def __init__(self, path: str, element: str, problem: str, hint: str = "") -> None:
        super().__init__(path, element, problem, hint)
        self.path, self.element, self.problem, self.hint = path, element, problem, hint

    def __str__(self) -> str:
        line = ": ".join(part for part in (self.path, self.element, self.problem) if part)
        return printable(line + (f" ({self.hint})" if self.hint else ""))
