"""The page as HTML: its styles, scripts and data in one file, and a policy that allows nothing else."""

from __future__ import annotations

import base64
import hashlib
import html
import json
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources
from importlib.resources.abc import Traversable
from string import Template
from typing import Any

from vdoor.errors import VdoorError
from vdoor.rounding import rounded

PAGE = resources.files("vdoor.export.report") / "page"
STYLES = ("base.css", "map.css", "tables.css", "dark.css", "print.css")
SCRIPTS = (
    "elements.js",
    "rooms.js",
    "layers.js",
    "zoom.js",
    "pointer.js",
    "tables.js",
    "left_out.js",
    "door_life.js",
    "search.js",
    "drive.js",
    "start.js",
)
"""The scripts of the page, in this order one script."""


@dataclass(frozen=True)
class Addition:
    """What a page has besides the report: files of its own."""

    place: Traversable
    styles: tuple[str, ...]
    scripts: tuple[str, ...]
    tools: str
    """File of the elements that stand above the map."""
    connect: str = "'self'"
    """Where the page may send requests, in the words of a content security policy."""


def document(title: str, data: Mapping[str, Any], addition: Addition | None = None) -> str:
    """The page; raises `VdoorError` for data that JSON does not have, such as NaN."""
    css, js = _joined(PAGE, STYLES), _joined(PAGE, SCRIPTS)
    if addition is not None:
        css += _joined(addition.place, addition.styles)
        js += _joined(addition.place, addition.scripts)
    return Template(_text(PAGE, "page.html")).substitute(
        title=html.escape(title),
        css=css,
        js=js,
        # Content security policy: no other script or style runs, whatever texts the page contains.
        css_digest=_digest(css),
        js_digest=_digest(js),
        connect=addition.connect if addition else "'none'",
        tools=_text(addition.place, addition.tools) if addition else "",
        data=as_json(data).replace("<", "\\u003c"),  # otherwise text could end its script element
    )


def as_json(data: Mapping[str, Any]) -> str:
    """Data of the page; raises `VdoorError` for numbers that are not finite."""
    try:
        return json.dumps(rounded(data, decimals={}), separators=(",", ":"), allow_nan=False)
    except ValueError as error:  # a recording can hold any number
        raise VdoorError(f"report: wanted finite numbers, found others ({error})") from error


def _joined(place: Traversable, names: tuple[str, ...]) -> str:
    return "\n".join(_text(place, name) for name in names)


def _text(place: Traversable, name: str) -> str:
    return (place / name).read_text("utf-8")


def _digest(text: str) -> str:
    """Digest of a text in the format of a content security policy."""
    return f"sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}"
