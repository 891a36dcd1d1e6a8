"""Pages: HTML documents that need no other file, no network and no script.

A template extends `page.html.j2` and uses the macros of `parts.html.j2`. It holds no arithmetic: it
gets texts and rows. Everything that is not `Markup` is escaped, so that a name from a file is
always shown as text.
"""

from __future__ import annotations

import functools
import pathlib
from typing import Any

import jinja2
from markupsafe import Markup

from palpate.analysis import errors, numbers

_TEMPLATES = pathlib.Path(__file__).parent / "templates"


def _shown(value: Any) -> Any:
    """What a page shows of a value: text without control characters, "-" for None and NaN."""
    if isinstance(value, Markup):
        return value
    if value is None or (isinstance(value, float) and value != value):
        return "-"
    return errors.printable(value) if isinstance(value, str) else value


@functools.cache
def _environment() -> jinja2.Environment:
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(_TEMPLATES),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        finalize=_shown,
    )
    environment.filters["number"] = numbers.number_or_dash
    environment.filters["p"] = numbers.p_text
    return environment


def page(template: str, **content: Any) -> str:
    """Render a template of the folder `templates` as a whole document (UTF-8)."""
    style = Markup((_TEMPLATES / "style.css").read_text(encoding="utf-8"))
    return _environment().get_template(template).render(style=style, **content)
