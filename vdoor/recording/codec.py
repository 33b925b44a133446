"""Records as ROS 2 messages and back, bit for bit, derived from their specs alone.

A record of topic ``corners`` becomes one message on each ``/vdoor/corners/<part>``. Its parts are each raster and
each array of bits, named after the field, each table, named after the table, and ``values`` with all numbers, texts
and the frame.
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
        """ROS type of the message."""
        ...

    def encode(self, record: Record, time_ns: int) -> Any:
        """Message that holds this part of a record."""
        ...

    def decode(self, message: Any) -> Mapping[str, Any]:
        """Field values from a message; `RecordingError` if it does not fit the record's specs."""
        ...


def parts(record: type[Record]) -> Mapping[str, Part]:
    """Parts of a record type, by the last word of their topic."""
    if record not in _PARTS:
        _PARTS[record] = _parts(record)
    return _PARTS[record]


def encode(record: Record, *, time_ns: int) -> Iterator[tuple[str, str, memoryview]]:
    """Topic, ROS type and CDR bytes of each message of a record, stamped with `time_ns`."""
    for name, part in parts(type(record)).items():
        yield f"{PREFIX}/{record.topic}/{name}", part.message, ros.pack(part.encode(record, time_ns))


def decode(record: type[R], messages: Mapping[str, bytes | memoryview]) -> R:
    """Record from its messages, given as CDR bytes by part name.

    Raises `RecordingError` with the place in the record if a part is missing, unknown or does not fit the record's
    specs. Sizes are checked against the number of bytes before anything is allocated.
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
    """Raise `RecordingError` if a raster does not have the size of the record's frame."""
    for name, (spec, _) in specs(record).items():
        if spec.kind not in RASTERS or "frame" not in fields:
            continue
        wanted = (fields["frame"].height, fields["frame"].width)
        if fields[name].shape != wanted:
            found = " x ".join(map(str, fields[name].shape))
            raise RecordingError(
                f"{record.__name__}.{name}: wanted the frame's {wanted[0]} x {wanted[1]} cells, found {found}"
            )
