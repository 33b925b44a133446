"""Edits: what people change about rooms and doors, each a line of text or a table of `edits.toml`.

======================  ==============================================================================================
``name X,Y NAME``       the room there is called NAME
``number X,Y ID``       the room there has that id; a room that had it takes the one that this room had
``merge X,Y X,Y``       the two rooms become one, which keeps the id and name of the first; they must touch
``split X,Y X,Y``       the room that most of this line lies in is cut along it, the line going on to its walls (and
                        behind obstacles of half a metre, if that parts nothing); the largest part keeps id and name,
                        others get new ids
``add-door X,Y X,Y``    the same with a line that goes on for half a metre at most: a door from jamb to jamb
``remove-door X,Y``     the rooms that the door there joins become one, which keeps the larger one's id and name
``closed-door X,Y``     the wall there is a door that was shut: it is opened before the search, and is a door after it
======================  ==============================================================================================

X,Y are metres in the map frame. Edits say places and no ids, so that they hold when the map is made again; a place that
lies in no room means the nearest room within half a metre.
"""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from vdoor.editing.places import Point, parse_place, place_text
from vdoor.errors import SettingError, VdoorError
from vdoor.files import write_whole
from vdoor.record import TEXT

MOST_ID = 65_535
"""What a label image can hold."""
HEADER = "# Edits of rooms and doors, done one after the other: vdoor run MAP --edits THIS_FILE\n"


class Form(NamedTuple):
    """What an edit of one kind says: the keys of its places in a file, and of its name or number."""

    places: tuple[str, ...]
    word: str = ""

    @property
    def usage(self) -> str:
        """What follows the kind in a line."""
        return " ".join(["X,Y"] * len(self.places) + ([self.word.upper()] if self.word else []))


FORMS = {
    "name": Form(("at",), "name"),
    "number": Form(("at",), "id"),
    "merge": Form(("at", "with")),
    "split": Form(("from", "to")),
    "add-door": Form(("from", "to")),
    "remove-door": Form(("at",)),
    "closed-door": Form(("at",)),
}


@dataclass(frozen=True)
class Edit:
    """One edit; `SettingError` where it cannot be one."""

    kind: str
    places_m: tuple[Point, ...]
    name: str = ""
    id: int = 0

    def __post_init__(self) -> None:
        """Check what can be checked without a map."""
        if self.kind == "name" and not (self.name.strip() and TEXT.fullmatch(self.name)):
            raise SettingError(f"edit: wanted a name of 1 to 100 characters in a line, found {self.name!r}")
        if self.kind == "number" and not 1 <= self.id <= MOST_ID:
            raise SettingError(f"edit: wanted a room id of 1 to {MOST_ID}, found {self.id}")

    def __str__(self) -> str:
        """The edit as a line."""
        word = {"name": self.name, "number": str(self.id)}.get(self.kind)
        return " ".join([self.kind, *map(place_text, self.places_m), *([word] if word else [])])

    @property
    def shapes(self) -> bool:
        """Whether it changes where rooms and doors are, and not only what rooms are called."""
        return not FORMS[self.kind].word

    def moved(self, by_m: Point) -> Edit:
        """The same elsewhere."""
        places = tuple((x_m + by_m[0], y_m + by_m[1]) for x_m, y_m in self.places_m)
        return Edit(self.kind, places, self.name, self.id)


def parse(line: str) -> Edit:
    """The edit that a line says; `SettingError` where it says none."""
    kind, _, rest = line.strip().partition(" ")
    if kind not in FORMS:
        raise SettingError(f"edit: wanted one of {', '.join(FORMS)}, found {line!r}")
    form = FORMS[kind]
    count = len(form.places)
    words = rest.split(maxsplit=count) if form.word else rest.split()
    if len(words) != count + bool(form.word):
        raise SettingError(f"edit: wanted {kind} {form.usage}, found {line!r}")
    places = tuple(parse_place(word, what=f"edit: {kind}") for word in words[:count])
    return _edit(kind, places, words[-1] if form.word else "")


def _edit(kind: str, places_m: tuple[Point, ...], word: str) -> Edit:
    if kind == "name":
        return Edit(kind, places_m, name=word.strip())
    if kind == "number":
        if not re.fullmatch("[0-9]{1,9}", word):
            raise SettingError(f"edit: wanted a room id of 1 to {MOST_ID}, found {word!r}")
        return Edit(kind, places_m, id=int(word))
    return Edit(kind, places_m)


def read_edits(path: Path) -> list[Edit]:
    """The edits of a TOML file in their order; `SettingError` for the first that is none, the path last."""
    return [*_read(path)[1]]


def append_edits(path: Path, edits: Sequence[Edit]) -> None:
    """Write edits at the end of a file, made if it is missing; what stands there stays as it is."""
    text = _read(path)[0] if path.exists() else HEADER
    text += "" if text.endswith("\n") or not text else "\n"
    text += "".join(f"\n{to_toml(edit)}" for edit in edits)
    _parsed(text, path)
    write_whole(path, text.encode())


def to_toml(edit: Edit) -> str:
    """One edit as a table of a TOML file."""
    form = FORMS[edit.kind]
    lines = ["[[edit]]", f'do = "{edit.kind}"']
    for key, place in zip(form.places, edit.places_m, strict=True):
        lines.append(f"{key} = [{place_text(place).replace(',', ', ')}]")
    if form.word:
        lines.append(f"{form.word} = {json.dumps(getattr(edit, form.word), ensure_ascii=False)}")
    return "\n".join(lines) + "\n"


def _read(path: Path) -> tuple[str, list[Edit]]:
    """The text of a file and its edits."""
    try:
        text = path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise SettingError(f"edits file: wanted TOML, found: {error}: {path}") from error
    except (OSError, ValueError) as error:
        raise SettingError(f"edits file: {getattr(error, 'strerror', None) or error}: {path}") from error
    return text, _parsed(text, path)


def _parsed(text: str, path: Path) -> list[Edit]:
    try:
        document = tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # of which one is a number of thousands of digits
        raise SettingError(f"edits file: wanted TOML, found: {error}: {path}") from error
    tables = document.pop("edit", [])
    if document or not isinstance(tables, list):
        found = f"{next(iter(document))!r}" if document else "another edit"
        raise SettingError(f"edits file: wanted tables [[edit]] and nothing else, found {found}: {path}")
    return [*_edits(tables, path)]


def _edits(tables: Iterable[Any], path: Path) -> Iterable[Edit]:
    for number, table in enumerate(tables, start=1):
        try:
            yield _from_table(table)
        except VdoorError as error:
            text = str(error).removeprefix("edit: ")
            raise SettingError(f"edits file: edit {number}: {text}: {path}") from error


def _from_table(table: Any) -> Edit:
    kind = table.get("do") if isinstance(table, Mapping) else None
    if not isinstance(kind, str) or kind not in FORMS:
        raise SettingError(f"wanted do = one of {', '.join(FORMS)}, found {kind!r}")
    form = FORMS[kind]
    wanted = ["do", *form.places, *([form.word] if form.word else [])]
    if sorted(table) != sorted(wanted):
        raise SettingError(f"wanted the keys {', '.join(wanted)}, found {', '.join(table)}")
    places = tuple(_place(table[key], key) for key in form.places)
    word = table[form.word] if form.word else ""
    if type(word) is not (int if kind == "number" else str):
        raise SettingError(f"{form.word}: wanted {'a whole number' if kind == 'number' else 'text'}, found {word!r}")
    return _edit(kind, places, str(word))


def _place(value: Any, key: str) -> Point:
    pair = 2
    if not isinstance(value, list) or len(value) != pair or any(type(part) not in (int, float) for part in value):
        raise SettingError(f"{key}: wanted [X, Y] in metres, found {value!r}")
    return parse_place(f"{value[0]},{value[1]}", what=key)
