"""Comparison of two records of one type, field by field, each within the tolerance of its spec."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from vdoor.frame import Frame
from vdoor.record import COLUMNS, RASTERS, Record, Spec, specs, tables

Scalar: TypeAlias = float | int | str
Value: TypeAlias = Scalar | tuple[Scalar, ...]


@dataclass(frozen=True)
class Places:
    """Positions of a table's elements: cells (k, 2) as row, col, and the same positions (k, 2) as x, y in metres."""

    cells: NDArray[np.float64]
    points_m: NDArray[np.float64]


@dataclass(frozen=True)
class Worst:
    """The element of a field that differs most (for names, the first that differs), and its position."""

    index: tuple[int, ...]
    expected: Value
    found: Value
    _: dataclasses.KW_ONLY
    difference: float | None = None
    """In `unit`; infinite between a number and a nan, None between names."""
    unit: str = ""
    cell: tuple[float, ...] | None = None
    """Row and column in the record's frame."""
    place_m: tuple[float, ...] | None = None


@dataclass(frozen=True, kw_only=True)
class Difference:
    """One field that differs between two records, or one table (``corner rows``) with different numbers of rows."""

    field: str
    count: int
    """Number of elements that differ; a row of a column is one element."""
    total: int
    worst: Worst


@dataclass(frozen=True)
class _Field:
    """One field of two records."""

    name: str
    spec: Spec
    expected: Record
    found: Record
    elsewhere: Mapping[str, Places]

    @property
    def values(self) -> tuple[NDArray[Any], NDArray[Any]]:
        """Values of the field in both records, as arrays."""
        one, other = getattr(self.expected, self.name), getattr(self.found, self.name)
        if self.spec.kind == "text":  # no texts are compared as empty texts
            rows = max(len(one), len(other))
            one, other = (np.array(texts or ("",) * rows, np.str_) for texts in (one, other))
        return np.asarray(one), np.asarray(other)


def differences(
    expected: Record, found: Record, *, elsewhere: Mapping[str, Places] | None = None
) -> Iterator[Difference]:
    """Fields that differ by more than their tolerance, in the records' order; equal infinities and nans are equal.

    `elsewhere` holds the positions of the elements of other records' tables, for the bits that refer to them.
    """
    yield from _frame_differences(getattr(expected, "frame", None), getattr(found, "frame", None))
    compared: set[str] = set()
    for name, (spec, _) in specs(type(expected)).items():
        field = _Field(name, spec, expected, found, elsewhere or {})
        one, other = field.values
        if one.shape == other.shape:
            yield from _differing(field)
        elif spec.kind in RASTERS:
            sizes = tuple(" x ".join(map(str, shape)) for shape in (one.shape, other.shape))
            most = max(one.size, other.size)
            yield Difference(field=name, count=most, total=most, worst=Worst((), sizes[0], sizes[1]))
        elif spec.axes[0] not in compared:
            compared.add(spec.axes[0])
            yield _row_difference(field)


def unequal(expected: NDArray[Any], found: NDArray[Any], tolerance: float) -> NDArray[np.bool_]:
    """Mask of the elements of two arrays of one shape that differ by more than `tolerance`; 0 means bit for bit."""
    if expected.dtype.kind != "f":
        return np.asarray(expected != found)
    neither = np.isnan(expected) & np.isnan(found)
    if tolerance == 0:
        return np.asarray(((expected != found) | (np.signbit(expected) != np.signbit(found))) & ~neither)
    return np.asarray(distance(expected, found) > tolerance)


def distance(expected: NDArray[Any], found: NDArray[Any]) -> NDArray[np.float64]:
    """Absolute difference of two arrays, elementwise: 0 for equal infinities and for two nans; never nan."""
    one, other = expected.astype(np.float64), found.astype(np.float64)
    with np.errstate(invalid="ignore", over="ignore"):
        apart = np.abs(one - other)
    same = (one == other) | (np.isnan(one) & np.isnan(other))
    return np.where(same, 0.0, np.where(np.isnan(apart), np.inf, apart))


@np.errstate(over="ignore", invalid="ignore")  # damaged records may hold anything
def places(record: Record, table: str) -> Places | None:
    """Positions of a table's elements, from its column of cells or else of points in metres; None if it has neither."""
    frame = getattr(record, "frame", None)
    if not isinstance(frame, Frame):
        return None
    columns = [(name, specs(type(record))[name][0]) for name in tables(type(record)).get(table, ())]
    for name, spec in columns:
        if spec.kind == "cell":
            cells = getattr(record, name).astype(np.float64)
            return Places(cells, frame.world_from_cell(cells))
    for name, spec in columns:
        if spec.unit == "m" and spec.axes[1:] == ("2",):
            return Places(frame.cell_from_world(getattr(record, name)), getattr(record, name))
    return None


def _frame_differences(expected: Frame | None, found: Frame | None) -> Iterator[Difference]:
    if expected is None or found is None:
        return
    for field in dataclasses.fields(Frame):
        one, other = getattr(expected, field.name), getattr(found, field.name)
        if one != other:
            unit = {"m": "m", "rad": "rad"}.get(field.name.rpartition("_")[2], "cells")
            worst = Worst((), one, other, difference=abs(one - other), unit=unit)
            yield Difference(field=f"frame.{field.name}", count=1, total=1, worst=worst)


def _differing(field: _Field) -> Iterator[Difference]:
    """Difference of a field with the same shape in both records, if any."""
    spec, (one, other) = field.spec, field.values
    apart = unequal(one, other, spec.tolerance)
    if not apart.any():
        return
    elements = apart.reshape(len(apart), -1).any(axis=1) if spec.kind in COLUMNS else apart
    indices = np.argwhere(elements)
    is_name = bool(spec.words) or spec.kind in ("labels", "text") or one.dtype == np.bool_
    at, size = 0, None
    if not is_name:
        where = tuple(indices.T)
        sizes = distance(one[where], other[where]).reshape(len(indices), -1).max(axis=1)
        at = int(np.argmax(sizes))
        size = float(sizes[at])
    index = tuple(indices[at].tolist())
    values = (_value(one[index], spec), _value(other[index], spec))
    unit = "" if is_name else spec.unit or ("cells" if spec.kind == "cell" else "")
    worst = Worst(index, *values, difference=size, unit=unit, **_where(field.expected, field, index))
    yield Difference(field=field.name, count=len(indices), total=elements.size, worst=worst)


def _row_difference(field: _Field) -> Difference:
    """Difference of a table (or array of bits) with more rows in one record, and the first row that differs."""
    table, kind = field.spec.axes[0], type(field.expected)
    rows, now = (len(values) for values in field.values)
    first = common = min(rows, now)
    for column in tables(kind).get(table, ()) if field.spec.kind in COLUMNS else (field.name,):
        one, other = getattr(field.expected, column)[:common], getattr(field.found, column)[:common]
        differing = np.argwhere(unequal(one, other, specs(kind)[column][0].tolerance))
        first = min(first, int(differing[0, 0]) if len(differing) else common)
    longer = field.expected if rows > now else field.found
    apart = abs(rows - now)
    worst = Worst((first,), rows, now, difference=float(apart), unit="rows", **_where(longer, field, (first,)))
    return Difference(field=f"{table} rows", count=apart, total=max(rows, now), worst=worst)


@np.errstate(over="ignore", invalid="ignore")  # as above
def _where(record: Record, field: _Field, index: tuple[int, ...]) -> dict[str, Any]:
    """Cell and point of an element, as fields of `Worst`; empty if it has no position on the map."""
    spec, frame = field.spec, getattr(record, "frame", None)
    if spec.kind in RASTERS and frame is not None:
        return {"cell": index, "place_m": tuple(frame.world_from_cell(np.array([index]))[0].tolist())}
    if spec.kind in RASTERS or not spec.axes:
        return {}
    known = field.elsewhere.get(spec.axes[0]) if spec.kind == "bits" else places(record, spec.axes[0])
    if known is None or index[0] >= len(known.cells):
        return {}
    cell, point_m = known.cells[index[0]], known.points_m[index[0]]
    return {"cell": tuple(cell.round(3).tolist()), "place_m": tuple(point_m.tolist())}


def _value(value: Any, spec: Spec) -> Value:
    """One element as a plain number, a word (for codes) or a tuple (for vectors)."""
    plain: Any = np.asarray(value).tolist()
    if isinstance(plain, list):
        return tuple(plain)
    found: Value = spec.words[plain] if spec.words else plain
    return found
