"""Tables, bits and numbers as messages: a PointCloud2 a table, a MultiArray for the rest."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, get_type_hints

import numpy as np
from numpy.typing import NDArray

from vdoor.errors import RecordingError
from vdoor.frame import Frame
from vdoor.record import Record, specs, tables
from vdoor.recording import ros
from vdoor.recording.rasters import check_range, frame_of

UINT8, INT32, FLOAT32, FLOAT64 = 2, 5, 7, 8
STORED = {np.dtype(bool): "u1", np.dtype("u1"): "u1", np.dtype("i4"): "<i4", np.dtype("f8"): "<f8"}
POINT_FIELD = {np.dtype("u1"): UINT8, np.dtype("<i4"): INT32, np.dtype("<f4"): FLOAT32, np.dtype("<f8"): FLOAT64}
POINT_FIELD_NAME = {UINT8: "UINT8", INT32: "INT32", FLOAT32: "FLOAT32", FLOAT64: "FLOAT64"}
VIEWERS = ("x", "y", "z")
FRAME: dict[str, type] = {field.name: get_type_hints(Frame)[field.name] for field in dataclasses.fields(Frame)}
FAR = 1e18
"""Sizes and places up to here leave all points of a map within the float32 that viewers are given."""
WHOLE_TO = 2**53
"""Integers up to here are exact as float64."""
MOST_TOLD = 4
"""Entries of one column that are told one by one."""


@dataclass(frozen=True)
class Table:
    """All columns of one table as a PointCloud2: x, y, z for viewers, then every column exactly."""

    place: str
    record: type[Record]
    table: str

    message: ClassVar[str] = "sensor_msgs/msg/PointCloud2"

    @cached_property
    def columns(self) -> tuple[str, ...]:
        """Names of the record's fields in this table."""
        return tables(self.record)[self.table]

    @cached_property
    def layout(self) -> np.dtype[Any]:
        """One row of the table; a column of pairs has one entry here and two in the message."""
        rows: list[Any] = [(name, "<f4") for name in VIEWERS]
        for name in self.columns:
            spec, dtype = specs(self.record)[name]
            assert dtype is not None
            rows.append((name, STORED[dtype], tuple(int(axis) for axis in spec.axes[1:])))
        return np.dtype(rows, align=True)  # readers in C++ expect every double on its own boundary

    @cached_property
    def fields(self) -> dict[str, tuple[int, int]]:
        """Offset and type of each entry of the message by its name: `cell` of shape ``k 2`` is cell_0 and cell_1."""
        found: dict[str, tuple[int, int]] = {}
        for name in self.layout.names or ():
            dtype, offset = self.layout[name], self.layout.fields[name][1]  # type: ignore[index]  # it has fields
            for i in range(int(np.prod(dtype.shape, dtype=int))):
                entry = f"{name}_{i}" if dtype.shape else name
                assert entry not in found, f"{self.place}: two columns called {entry}"
                found[entry] = (offset + i * dtype.base.itemsize, POINT_FIELD[dtype.base])
        return found

    def encode(self, record: Record, time_ns: int) -> Any:
        """Message whose points lie at the centre of the table's cells, or at 0 where it has none."""
        rows = np.zeros(len(getattr(record, self.columns[0])), self.layout)
        for name in self.columns:
            rows[name] = getattr(record, name)
        cell = next((name for name in self.columns if specs(self.record)[name][0].kind == "cell"), None)
        if cell is not None:
            points_m = frame_of(record).world_from_cell(rows[cell])
            rows["x"], rows["y"] = points_m.T
        fields = [
            ros.make("sensor_msgs/msg/PointField", name=name, offset=offset, datatype=datatype, count=1)
            for name, (offset, datatype) in self.fields.items()
        ]
        return ros.make(
            self.message,
            header=ros.header(time_ns),
            height=1,
            width=rows.size,
            fields=fields,
            is_bigendian=False,
            point_step=rows.itemsize,
            row_step=rows.nbytes,
            data=rows.view(np.uint8),
            is_dense=True,
        )

    def decode(self, message: Any) -> dict[str, NDArray[Any]]:
        """Columns by name; `RecordingError` where names, types or sizes are not those of the record."""
        self._check_fields({field.name: (field.offset, field.datatype) for field in message.fields})
        wanted = (1, self.layout.itemsize, message.width * self.layout.itemsize, message.data.size)
        if (message.height, message.point_step, message.row_step, message.row_step) != wanted or message.is_bigendian:
            found = f"{message.height} x {message.width} of {message.point_step} bytes in {message.data.size}"
            raise RecordingError(
                f"{self.place}: wanted one row of points of {self.layout.itemsize} bytes, little endian, found {found}"
            )
        rows = message.data.view(self.layout)
        return {name: self._column(name, rows[name]) for name in self.columns}

    def _check_fields(self, found: dict[str, tuple[int, int]]) -> None:
        for name, (offset, datatype) in self.fields.items():
            if name not in found:
                raise RecordingError(f"{self.place}: wanted a column {name}, found {told(found) or 'none'}")
            if found[name] != (offset, datatype):
                types = [POINT_FIELD_NAME.get(kind, f"type {kind}") for kind in (datatype, found[name][1])]
                raise RecordingError(
                    f"{self.place}.{name}: wanted {types[0]} at byte {offset}, found {types[1]} at {found[name][0]}"
                )
        for name in found:
            if name not in self.fields:
                raise RecordingError(f"{self.place}: wanted columns {told(self.fields)}, found {name} as well")

    def _column(self, name: str, values: NDArray[Any]) -> NDArray[Any]:
        spec, dtype = specs(self.record)[name]
        if dtype == np.bool_ or spec.words:
            check_range(f"{self.place}.{name}", values, 0, len(spec.words) - 1 if spec.words else 1)
        return np.ascontiguousarray(values, dtype=dtype)


def told(names: Iterable[str]) -> str:
    """Names of a message's entries; of the many of a long vector the first and the last: feature_0 to feature_38."""

    def vector(numbered: tuple[int, str]) -> tuple[str, int]:
        at, name = numbered
        stem, _, number = name.rpartition("_")
        return (stem, at - int(number)) if number.isdecimal() else (name, 0)

    parts = []
    for _, group in itertools.groupby(enumerate(names), vector):
        own = [name for _, name in group]
        parts += own if len(own) <= MOST_TOLD else [f"{own[0]} to {own[-1]}"]
    return ", ".join(parts)


@dataclass(frozen=True)
class Bits:
    """Flags about the rows of another record's table, as a UInt8MultiArray."""

    place: str
    field: str
    axis: str

    message: ClassVar[str] = "std_msgs/msg/UInt8MultiArray"

    def encode(self, record: Record, time_ns: int) -> Any:  # noqa: ARG002  # this message has no header
        """Message, its one dimension named after the other table."""
        bits = np.ascontiguousarray(getattr(record, self.field)).view(np.uint8)
        return ros.make(self.message, layout=_layout([(self.axis, bits.size)]), data=bits)

    def decode(self, message: Any) -> dict[str, NDArray[np.bool_]]:
        """Bits by their field's name; `RecordingError` where the message does not hold flags of that axis."""
        found = [(dim.label, dim.size) for dim in message.layout.dim]
        if found != [(self.axis, message.data.size)]:
            raise RecordingError(f"{self.place}: wanted {message.data.size} flags along {self.axis}, found {found}")
        check_range(self.place, message.data, 0, 1)
        return {self.field: message.data.astype(np.bool_)}


@dataclass(frozen=True)
class Values:
    """All numbers and counts of a record and its frame, as a Float64MultiArray with their names as labels.

    Texts follow as labels ``field=text`` without a value, one for each; where a record has none, nothing tells of them.
    """

    place: str
    types: dict[str, type]
    has_frame: bool
    texts: tuple[str, ...] = ()

    message: ClassVar[str] = "std_msgs/msg/Float64MultiArray"

    def encode(self, record: Record, time_ns: int) -> Any:  # noqa: ARG002  # this message has no header
        """Message; `RecordingError` for an integer that a float64 does not hold."""
        values = {name: getattr(record, name) for name in self.types}
        if self.has_frame:
            values |= dataclasses.asdict(frame_of(record))
        for name, value in values.items():
            if isinstance(value, int) and abs(value) > WHOLE_TO:
                raise RecordingError(f"{self.place}.{name}: wanted at most 2^53, found {value}")
        data = np.array([float(value) for value in values.values()], dtype=np.float64)
        texts = [(f"{name}={text}", 0) for name in self.texts for text in getattr(record, name)]
        return ros.make(self.message, layout=_layout([*((name, 1) for name in values), *texts]), data=data)

    def decode(self, message: Any) -> dict[str, Any]:
        """Numbers by name, and `frame`; `RecordingError` where names or types are not those of the record."""
        wanted = self.types | (FRAME if self.has_frame else {})
        names = [dim.label for dim in message.layout.dim]
        names, more = names[: len(wanted)], names[len(wanted) :]
        if names != list(wanted) or message.data.size != len(names):
            found = ", ".join([*names, *more])
            raise RecordingError(f"{self.place}: wanted {', '.join(wanted)}, found {message.data.size} values: {found}")
        texts = self._texts_of(more)
        values = dict(zip(names, message.data.tolist(), strict=True))
        for name in names:
            if wanted[name] is int:
                values[name] = _whole(f"{self.place}.{name}", values[name])
        if not self.has_frame:
            return values | texts
        frame = {name: values.pop(name) for name in FRAME}
        near = all(abs(value) <= FAR for value in frame.values())  # which no nan is
        if not (near and frame["resolution_m"] > 0 <= min(frame["height"], frame["width"])):
            raise RecordingError(f"{self.place}: wanted the size and pose of a raster, found {frame}")
        return values | texts | {"frame": Frame(**frame)}

    def _texts_of(self, labels: list[str]) -> dict[str, Any]:
        """Texts by the name of their field, from labels; `RecordingError` for a label of no such field."""
        found: dict[str, tuple[str, ...]] = dict.fromkeys(self.texts, ())
        for label in labels:
            name, _, text = label.partition("=")
            if name not in found:
                raise RecordingError(
                    f"{self.place}: wanted texts of {', '.join(self.texts) or 'no field'}, found {label!r}"
                )
            found[name] += (text,)
        return found


def _whole(place: str, value: float) -> int:
    if not (value.is_integer() and abs(value) <= WHOLE_TO):
        raise RecordingError(f"{place}: wanted a whole number, found {value}")
    return int(value)


def _layout(dims: list[tuple[str, int]]) -> Any:
    dim = [ros.make("std_msgs/msg/MultiArrayDimension", label=name, size=size, stride=size) for name, size in dims]
    return ros.make("std_msgs/msg/MultiArrayLayout", dim=dim, data_offset=0)
