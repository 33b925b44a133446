"""Records as ROS 2 messages and back, bit for bit, derived from their specs alone.

A record of topic ``corners`` becomes one message on each ``/vdoor/corners/<part>``. Its parts are every raster and
every run of bits by its field's name, every table by the table's name, and ``values`` with all numbers and texts and
the frame.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Protocol, TypeVar, get_type_hints

import numpy as np

from vdoor.errors import RecordingError
from vdoor.record import RASTERS, SCALARS, Record, Spec, specs, tables
from vdoor.recording import ros
from vdoor.recording.columns import Bits, Table, Values
from vdoor.recording.rasters import LABELS, Grid, Picture, codes

PREFIX = "/vdoor"
VALUES = "values"
_PARTS: dict[type[Record], dict[str, Part]] = {}
R = TypeVar("R", bound=Record)


class Part(Protocol):
    """One message of a record."""

    @property
    def message(self) -> str:
        """Its ROS type."""
        ...

    def encode(self, record: Record, time_ns: int) -> Any:
        """Message of a record."""
        ...

    def decode(self, message: Any) -> Mapping[str, Any]:
        """Fields that were in a message; `RecordingError` where it does not fit the record's specs."""
        ...


def parts(record: type[Record]) -> Mapping[str, Part]:
    """Messages that a type of record becomes, by the last word of their topic."""
    if record not in _PARTS:
        _PARTS[record] = _parts(record)
    return _PARTS[record]


def encode(record: Record, *, time_ns: int) -> Iterator[tuple[str, str, memoryview]]:
    """Topic, ROS type and CDR bytes of each message of a record, stamped with `time_ns`."""
    for name, part in parts(type(record)).items():
        yield f"{PREFIX}/{record.topic}/{name}", part.message, ros.pack(part.encode(record, time_ns))


def decode(record: type[R], messages: Mapping[str, bytes | memoryview]) -> R:
    """Record whose messages are given as CDR bytes by the names of its parts.

    Raises `RecordingError`, naming the place, where a part is missing, unknown or not what the record's specs say;
    nothing is allocated on the word of a size that the bytes do not bear out.
    """
    known = parts(record)
    if messages.keys() != known.keys():
        raise RecordingError(
            f"{record.__name__}: wanted the parts {', '.join(known)}, found {', '.join(messages) or 'none'}"
        )
    fields: dict[str, Any] = {}
    for name, part in known.items():
        try:
            message = ros.unpack(messages[name], part.message)
        except RecordingError as error:
            raise RecordingError(f"{record.__name__}.{name}: {error}") from error
        fields |= part.decode(message)
    _check_frame(record, fields)
    return record(**fields)


def _parts(record: type[Record]) -> dict[str, Part]:
    found: dict[str, Part] = {}
    for name, (spec, dtype) in specs(record).items():
        place = f"{record.__name__}.{name}"
        if spec.kind in RASTERS:
            found[name] = _raster(place, name, spec=spec, dtype=dtype)
        elif spec.kind == "bits":
            found[name] = Bits(place, name, spec.axes[0])
    for table in tables(record):
        assert table not in found, f"{record.__name__}: {table} is the name of a field and of a table"
        found[table] = Table(f"{record.__name__}.{table}", record, table)
    scalars = {name: spec.kind for name, (spec, _) in specs(record).items() if spec.kind in SCALARS}
    types: dict[str, type] = {name: int if kind == "count" else float for name, kind in scalars.items()}
    texts = tuple(name for name, (spec, _) in specs(record).items() if spec.kind == "text")
    has_frame = "frame" in get_type_hints(record)
    if types or has_frame or texts:
        found[VALUES] = Values(f"{record.__name__}.{VALUES}", types, has_frame, texts)
    return found


def _raster(place: str, field: str, *, spec: Spec, dtype: np.dtype[Any] | None) -> Part:
    assert dtype is not None
    if spec.kind == "occupancy":
        return Grid(place, field)
    return Picture(place, field, dtype, codes(spec.words) if spec.kind == "codes" else LABELS)


def _check_frame(record: type[Record], fields: Mapping[str, Any]) -> None:
    """Raise `RecordingError` where a raster is not of the size that the record's frame gives."""
    for name, (spec, _) in specs(record).items():
        if spec.kind not in RASTERS or "frame" not in fields:
            continue
        wanted = (fields["frame"].height, fields["frame"].width)
        if fields[name].shape != wanted:
            found = " x ".join(map(str, fields[name].shape))
            raise RecordingError(
                f"{record.__name__}.{name}: wanted the frame's {wanted[0]} x {wanted[1]} cells, found {found}"
            )
