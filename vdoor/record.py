"""The single description of a stage's output.

A `Record` is a frozen dataclass whose fields carry a `Spec`. Everything done with a stage's output (check, store, draw,
replay, compare, make test data) is derived from these specs and written nowhere else.

The first name in a spec's shape is the table a column belongs to: all columns of shape ``corner`` or ``corner 2``
have one row per corner.
"""

from __future__ import annotations

import dataclasses
import re
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal, dataclass_transform, get_args, get_origin, get_type_hints

import numpy as np

from vdoor.errors import RecordingError

Kind = Literal["occupancy", "codes", "labels", "column", "cell", "code", "bits", "number", "count", "text"]
RASTERS: tuple[Kind, ...] = ("occupancy", "codes", "labels")
COLUMNS: tuple[Kind, ...] = ("column", "cell", "code")
SCALARS: tuple[Kind, ...] = ("number", "count")
TEXT = re.compile("[\x20-\x7e\xa0-\u2027\u202f-\u2065\u206a-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]{0,100}")
"""One line in any language: no control characters, line breaks, or characters that change the text direction."""


@dataclass(frozen=True)
class Spec:
    """The properties of a field that its type does not express.

    kind
        occupancy   raster of int8: -1 unknown, 0 free to 100 occupied
        codes       raster of uint8, an index into `words`
        labels      raster of int32, 0 = none
        column      one row (or short vector) per element of the table that `shape` begins with
        cell        a column of (row, col) in the record's frame: the positions of the table's elements
        code        a column of uint8, an index into `words`
        bits        one flag per element of a table in another record
        number, count  a float, an int
        text        a tuple with one line of text per element of a table, or an empty one
    shape
        names of the axes; axes with the same name have the same length within a record, a digit is a fixed length
    tolerance
        how much two runs on different machines may differ, in `unit`; 0 means bit for bit
    of
        a table of any record, given by one of its columns, as in `doors.start`. The values of a column are row numbers
        of that table; cells and bits have one row per row of it
    or_none
        whether a column of row numbers may contain -1 for none
    """

    kind: Kind
    shape: str = ""
    unit: str = ""
    words: tuple[str, ...] = ()
    tolerance: float = 0.0
    of: str = ""
    or_none: bool = False

    @property
    def axes(self) -> tuple[str, ...]:
        """The names of the axes, outermost first."""
        return tuple(self.shape.split())


@dataclass_transform(frozen_default=True, kw_only_default=True, eq_default=False)
class Record:
    """Base class of all records: checked when created, then frozen, with read-only arrays."""

    topic: ClassVar[str]

    def __init_subclass__(cls) -> None:
        """Make every subclass a frozen, keyword-only dataclass, compared by identity (see `equal`)."""
        dataclass(frozen=True, kw_only=True, eq=False, repr=False)(cls)

    def __post_init__(self) -> None:
        """Check types and shapes against the specs and freeze the arrays."""
        lengths: dict[str, int] = {}
        for name, (spec, dtype) in specs(type(self)).items():
            value = getattr(self, name)
            if spec.kind == "text" and value:
                self._check_texts(name, value, lengths.setdefault(spec.shape, len(value)))
            if dtype is None:
                continue
            if not isinstance(value, np.ndarray) or value.dtype != dtype or value.ndim != len(spec.axes):
                found = f"{value.dtype} {value.shape}" if isinstance(value, np.ndarray) else type(value).__name__
                raise RecordingError(f"{type(self).__name__}.{name}: wanted {dtype} ({spec.shape}), found {found}")
            for axis, length in zip(spec.axes, value.shape, strict=True):
                wanted = int(axis) if axis.isdigit() else lengths.setdefault(axis, length)
                if length != wanted:
                    raise RecordingError(f"{type(self).__name__}.{name}: wanted {wanted} along {axis}, found {length}")
            frozen = value.view()
            frozen.flags.writeable = False
            object.__setattr__(self, name, frozen)

    def __repr__(self) -> str:
        """One line: the record's name and the sizes of its rasters and tables."""
        return f"{type(self).__name__}({sizes(self)})"

    def _check_texts(self, name: str, texts: tuple[str, ...], wanted: int) -> None:
        """Raise `RecordingError` if the texts are not single lines, or their number is wrong."""
        if not isinstance(texts, tuple) or not all(isinstance(text, str) and TEXT.fullmatch(text) for text in texts):
            raise RecordingError(f"{type(self).__name__}.{name}: wanted lines of at most 100 characters, found others")
        if len(texts) != wanted:
            raise RecordingError(f"{type(self).__name__}.{name}: wanted {wanted} texts or none, found {len(texts)}")


def specs(record: type[Record]) -> dict[str, tuple[Spec, np.dtype[Any] | None]]:
    """The fields of a record that carry a `Spec`, in order, with their dtype (None for plain numbers and texts)."""
    if record not in _SPECS:
        _SPECS[record] = _read_specs(record)
    return _SPECS[record]


_SPECS: dict[type[Record], dict[str, tuple[Spec, np.dtype[Any] | None]]] = {}


def _read_specs(record: type[Record]) -> dict[str, tuple[Spec, np.dtype[Any] | None]]:
    hints = get_type_hints(record, include_extras=True)
    found: dict[str, tuple[Spec, np.dtype[Any] | None]] = {}
    for field in dataclasses.fields(record):  # type: ignore[arg-type]  # made a dataclass by __init_subclass__
        hint = hints[field.name]
        if get_origin(hint) is not Annotated:
            continue
        base, spec = get_args(hint)[:2]
        plain = spec.kind == "text" or spec.kind in SCALARS
        found[field.name] = (spec, None if plain else np.dtype(get_args(get_args(base)[1])[0]))
    return found


def tables(record: type[Record]) -> dict[str, tuple[str, ...]]:
    """The tables of a record: the name of a row (``corner``) -> the fields that are its columns."""
    found: dict[str, list[str]] = {}
    for name, (spec, _) in specs(record).items():
        if spec.kind in COLUMNS:
            found.setdefault(spec.axes[0], []).append(name)
    return {table: tuple(columns) for table, columns in found.items()}


def equal(one: Record, other: Record) -> bool:
    """Whether two records have the same type and are equal bit for bit (equal infinities and nans are equal)."""
    if type(one) is not type(other) or getattr(one, "frame", None) != getattr(other, "frame", None):
        return False
    for name, (_, dtype) in specs(type(one)).items():
        a, b = getattr(one, name), getattr(other, name)
        if dtype is None:
            if a != b and not (a != a and b != b):  # noqa: PLR0124  # nan equals nan here
                return False
        elif a.shape != b.shape or a.tobytes() != b.tobytes():
            return False
    return True


def sizes(record: Record) -> str:
    """One line on a record: the sizes of its rasters and tables, and its numbers."""
    kind = type(record)
    found = [
        f"{name} {' x '.join(map(str, getattr(record, name).shape))}"
        for name, (spec, _) in specs(kind).items()
        if spec.kind in RASTERS
    ]
    found += [f"{table} {len(getattr(record, columns[0]))}" for table, columns in tables(kind).items()]
    found += [f"{name} {getattr(record, name):.6g}" for name, (spec, _) in specs(kind).items() if spec.kind in SCALARS]
    return ", ".join(found)


def texts_of(record: Record, column: str) -> list[str]:
    """The values of one column as readable text: words for codes, numbers to four digits."""
    values = np.asarray(getattr(record, column))
    spec = specs(type(record))[column][0]
    if spec.words:
        return [spec.words[code] for code in values.tolist()]
    rows = values.reshape(len(values), values.size // max(len(values), 1)).tolist()
    return [",".join(f"{value:.4g}" if isinstance(value, float) else str(value) for value in row) for row in rows]
