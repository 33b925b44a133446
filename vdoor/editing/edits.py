"""Edits: changes to rooms and doors, each a line of text or a table of `edits.toml`.

======================  ==============================================================================================
``name X,Y NAME``       give the room there the name NAME
``number X,Y ID``       give the room there that id; a room that already has it gets this room's id instead
``merge X,Y X,Y``       merge the second room into the first, which keeps its id and name; the rooms must touch
``split X,Y X,Y``       cut the room that contains most of this line along it; the line is extended to the walls and, if
                        that does not separate the room, across obstacles up to half a metre wide; the largest part
                        keeps the id and name, the others get new ids
``add-door X,Y X,Y``    the same, with the line extended by at most half a metre: a door from jamb to jamb
``remove-door X,Y``     merge the rooms that the door there joins; the largest one's id and name are kept
``closed-door X,Y``     the wall there is a door that was closed: open it before the search, and keep it as a door
======================  ==============================================================================================

X,Y are in metres in the map frame. Edits refer to positions, not ids, so that they remain valid when the map is made
again. A position in no room refers to the nearest room within half a metre.
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
from vdoor.files import read_regular
from vdoor.partial import write_whole
from vdoor.record import TEXT

MOST_ID = 65_535
"""Highest id that a 16-bit label image can store."""
MOST_BYTES = 1 << 24
"""Largest size of a file of edits."""
HEADER = "# Edits of rooms and doors, applied in order: vdoor run MAP --edits THIS_FILE\n"


class Form(NamedTuple):
    """The arguments of one kind of edit: the keys, in a file, of its positions and of its name or id."""

    places: tuple[str, ...]
    word: str = ""

    @property
    def usage(self) -> str:
        """The arguments as they follow the kind in a line of text."""
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
    """One edit; raises `SettingError` for an invalid name or id."""

    kind: str
    places_m: tuple[Point, ...]
    name: str = ""
    id: int = 0

    def __post_init__(self) -> None:
        """Check the name and the id."""
        if self.kind == "name" and not (self.name.strip() and TEXT.fullmatch(self.name)):
            raise SettingError(f"edit: wanted a name of one line and 1 to 100 characters, found {self.name!r}")
        if self.kind == "number" and not 1 <= self.id <= MOST_ID:
            raise SettingError(f"edit: wanted a room id of 1 to {MOST_ID}, found {self.id}")

    def __str__(self) -> str:
        """The edit as a line of text."""
        word = {"name": self.name, "number": str(self.id)}.get(self.kind)
        return " ".join([self.kind, *map(place_text, self.places_m), *([word] if word else [])])

    @property
    def shapes(self) -> bool:
        """Whether the edit changes the shapes of rooms or doors, rather than names or ids."""
        return not FORMS[self.kind].word

    def moved(self, by_m: Point) -> Edit:
        """The edit with its positions shifted."""
        places = tuple((x_m + by_m[0], y_m + by_m[1]) for x_m, y_m in self.places_m)
        return Edit(self.kind, places, self.name, self.id)


def parse(line: str) -> Edit:
    """The edit in a line of text; raises `SettingError` if it is invalid."""
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
    """The edits in a TOML file, in order; raises `SettingError` for the first invalid one, with the path last."""
    return [*_read(path)[1]]


def append_edits(path: Path, edits: Sequence[Edit]) -> None:
    """Append edits to a TOML file, created if missing; its existing text is kept."""
    write_whole(path, appended(path, edits))


def appended(path: Path, edits: Sequence[Edit], *, keep: bool = True) -> bytes:
    """The content of a TOML file with edits appended to its existing text, or, without `keep`, of a new file."""
    text = _read(path)[0] if keep and path.exists() else HEADER
    text += "" if text.endswith("\n") or not text else "\n"
    text += "".join(f"\n{to_toml(edit)}" for edit in edits)
    _parsed(text, path)
    return text.encode()


def to_toml(edit: Edit) -> str:
    """An edit as a table of a TOML file."""
    form = FORMS[edit.kind]
    lines = ["[[edit]]", f'do = "{edit.kind}"']
    for key, place in zip(form.places, edit.places_m, strict=True):
        lines.append(f"{key} = [{place_text(place).replace(',', ', ')}]")
    if form.word:
        lines.append(f"{form.word} = {json.dumps(getattr(edit, form.word), ensure_ascii=False)}")
    return "\n".join(lines) + "\n"


def _read(path: Path) -> tuple[str, list[Edit]]:
    """The text of a TOML file, and its edits."""
    data = read_regular(path, "edits as TOML", limit=MOST_BYTES, error=SettingError)
    try:
        text = data.decode()
    except UnicodeDecodeError as error:
        raise SettingError(f"edits file: wanted TOML, found: {error}: {path}") from error
    return text, _parsed(text, path)


def _parsed(text: str, path: Path) -> list[Edit]:
    try:
        document = tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # ValueError: also for a number with thousands of digits
        raise SettingError(f"edits file: wanted TOML, found: {error}: {path}") from error
    tables = document.pop("edit", [])
    if document or not isinstance(tables, list):
        found = f"{next(iter(document))!r}" if document else f"edit = {tables!r:.60}"
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
        type_name = "a whole number" if kind == "number" else "a string"
        raise SettingError(f"{form.word}: wanted {type_name}, found {word!r}")
    return _edit(kind, places, str(word))


def _place(value: Any, key: str) -> Point:
    pair = 2
    if not isinstance(value, list) or len(value) != pair or any(type(part) not in (int, float) for part in value):
        raise SettingError(f"{key}: wanted [X, Y] in metres, found {value!r}")
    return parse_place(f"{value[0]},{value[1]}", what=key)
