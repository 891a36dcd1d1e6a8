"""Errors as the program prints them, and text from files made safe for one line."""

from __future__ import annotations

import re

# Control and bidirectional characters, and those that are drawn as nothing, so that two different
# names could look alike (geometry/base/printable.h).
_CONTROL = re.compile(
    "[\x00-\x1f\x7f-\x9f\xad\u034f\u061c\u115f\u1160\u17b4\u17b5\u180e\u200b-\u200f"
    "\u2028-\u202e\u2060-\u206f\u3164\ufeff\uffa0\U000e0000-\U000e00ff]")
_BROKEN = re.compile("[\ud800-\udfff\ufffe\uffff]")  # a byte that is not UTF-8, a noncharacter


def printable(text: str) -> str:
    """Return the text with a space for each control, bidirectional or invisible character, and "?"
    for each byte of what is not valid UTF-8."""
    if text.isascii() and text.isprintable():
        return text
    text = _BROKEN.sub(lambda c: "?" if c[0] <= "\udfff" else "???", text)
    return _CONTROL.sub(" ", text)


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
