"""The table of a batch: a row a map, as Parquet for programs, and as CSV without what differs from run to run."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import pyarrow as pa
from pyarrow import parquet

from vdoor.batch.job import MEASURED, Row
from vdoor.errors import VdoorError
from vdoor.partial import write_whole

FIGURES = (
    "door_f1", "door_precision", "door_recall", "door_f1_1m", "narrow_recall", "iou", "iou_sym", "mcc", "room_recall",
    "room_precision",
)  # fmt: skip
"""Measures of `vdoor evaluate`, where a map has a reference."""
COUNTS = ("rooms_true", "rooms_found", "doors_true", "doors_found")
KINDS: Mapping[str, Any] = {
    **dict.fromkeys(("map", "key", "folder", "error_kind", "error", "reference", "host"), pa.string()),
    **dict.fromkeys(("height", "width", "rooms", "doors", *COUNTS), pa.int64()),
    "stages_s": pa.map_(pa.string(), pa.float64()),
}
COLUMNS = (
    "map", "key", "folder", "error_kind", "error", "height", "width", "resolution_m", "rooms", "doors", "area_m2",
    "reference", *FIGURES, *COUNTS, *MEASURED,
)  # fmt: skip
SCHEMA = pa.schema([(name, KINDS.get(name, pa.float64())) for name in COLUMNS])
"""Any column but map may be empty; times in seconds of CPU, but wall_s."""
PIECE = 10_000
"""Rows that are kept as Python objects at a time."""
TABLE, SHEET = "table.parquet", "index.csv"


def table_of(rows: Iterable[Row]) -> Any:
    """The rows as a pyarrow table, sorted by map, so that the order in which they came does not matter."""
    pieces = [pa.Table.from_pylist(piece, schema=SCHEMA) for piece in _pieces(rows)]
    table = pa.concat_tables(pieces) if pieces else SCHEMA.empty_table()
    return table.sort_by([("map", "ascending"), ("key", "ascending"), ("reference", "ascending")])


def _pieces(rows: Iterable[Row]) -> Iterator[list[Row]]:
    piece: list[Row] = []
    for row in rows:
        texts = {name: _storable(value) for name, value in row.items() if isinstance(value, str)}
        piece.append({**row, **texts, "stages_s": list(row.get("stages_s", {}).items())})
        if len(piece) == PIECE:
            yield piece
            piece = []
    if piece:
        yield piece


def _storable(text: str) -> str:
    """A text in which bytes of a file's name that are not UTF-8 are replaced."""
    return text.encode(errors="surrogateescape").decode(errors="replace")


def write_tables(out: Path, table: Any) -> list[Path]:
    """Write table.parquet and index.csv into `out`; equal batches give equal CSV bytes."""
    data = io.BytesIO()
    parquet.write_table(table, data)
    sheet = io.StringIO()
    same = table.drop_columns(list(MEASURED))
    lines = csv.writer(sheet, lineterminator="\n")
    lines.writerow(same.column_names)
    for batch in same.to_batches(max_chunksize=PIECE):
        lines.writerows(zip(*(column.to_pylist() for column in batch.columns), strict=True))
    return [write_whole(out / TABLE, data.getvalue()), write_whole(out / SHEET, sheet.getvalue().encode())]


def read_tables(out: Path) -> Any:
    """The table of a batch; raises `VdoorError` if there is none."""
    path = out / TABLE
    try:
        table = parquet.read_table(pa.BufferReader(path.read_bytes()))  # a path is taken as UTF-8
    except (OSError, pa.ArrowException) as error:
        raise VdoorError(f"batch: wanted a batch's folder with {TABLE}, found none that can be read: {out}") from error
    missing = [name for name in COLUMNS if name not in table.column_names]
    if missing:
        raise VdoorError(f"batch: wanted the columns of a batch, found none named {missing[0]}: {path}")
    return table.select(COLUMNS)
