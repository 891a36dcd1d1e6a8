"""The chart of stiffness zones: the panels of `stiffness.svg`, which the program draws."""

from __future__ import annotations

import pathlib
from xml.etree import ElementTree

from markupsafe import Markup

from palpate.analysis.errors import InputError

_SVG = "http://www.w3.org/2000/svg"
_TAGS = frozenset(f"{{{_SVG}}}{name}" for name in ("svg", "path", "polygon", "text", "circle"))
_OTHER_PLACE = ("x", "y", "width", "height")  # of a panel within the picture


def _is_drawing(panel: ElementTree.Element) -> bool:
    """Whether it has shapes and texts only: a page takes in nothing that could run or load."""
    return all(part.tag in _TAGS and not any(
        name.startswith("on") or "href" in name or "url(" in value
        for name, value in part.attrib.items()) for part in panel.iter())


def panels(path: pathlib.Path) -> list[Markup]:
    """The panels of the picture, the legend last, as elements of a page of class `zones`."""
    try:
        root = ElementTree.fromstring(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(str(path), "", f"cannot be read: {error.strerror}") from None
    except (ElementTree.ParseError, ValueError):
        raise InputError(str(path), "", "is not the chart that `palpate accuracy` draws") from None
    found = root.findall(f"{{{_SVG}}}svg")
    if not found or not all(_is_drawing(panel) for panel in found):
        raise InputError(str(path), "", "is not the chart that `palpate accuracy` draws")
    ElementTree.register_namespace("", _SVG)
    elements = []
    for n, panel in enumerate(found, 1):
        for name in _OTHER_PLACE:
            panel.attrib.pop(name, None)
        panel.set("class", "zones" if n < len(found) else "zones legend")
        panel.set("role", "img")
        panel.tail = None
        elements.append(Markup(ElementTree.tostring(panel, encoding="unicode")))
    return elements
