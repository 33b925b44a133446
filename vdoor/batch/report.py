"""The page of a batch: what came out, how long it took, what failed and why, and the worst by F1 with pictures."""

from __future__ import annotations

import base64
import html
import posixpath
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.compute as pc

from vdoor.batch.table import read_tables
from vdoor.errors import VdoorError
from vdoor.evaluate.label_files import read_labels
from vdoor.partial import write_whole
from vdoor.results.writing import png

PAGE = "index.html"
SIDE = 240
"""Longest side of a picture, in pixels."""
SHOWN, PICTURES, BARS = 20, 24, 20
"""Rows of a list, pictures, and bars of a distribution."""
DISTRIBUTIONS = {
    "cpu_s": "CPU time of the method, s",
    "wall_s": "time with reading and writing, s",
    "peak_mb": "peak memory, MB",
    "area_m2": "area of all rooms, m2",
    "rooms": "rooms",
    "doors": "doors",
    "door_f1": "door F1",
    "iou_sym": "room IoU, symmetric",
}
"""Column and title of each distribution."""
STYLE = """
body{font:15px sans-serif;margin:2em;max-width:70em}table{border-collapse:collapse;margin:1em 0}
td,th{padding:.2em .8em;text-align:left;border-bottom:1px solid #ddd}td.n{text-align:right}
.all{display:flex;flex-wrap:wrap;gap:1.5em}figure{margin:0;width:15em}figcaption{overflow-wrap:anywhere;font-size:85%}
.bars{display:flex;align-items:flex-end;height:6em;gap:1px}.bars i{flex:1;background:#4878a8;min-height:1px}
.ends{display:flex;justify-content:space-between;font-size:85%}
"""


def write_report(out: Path) -> Path:
    """Write index.html into a batch's folder, from its table; raises `VdoorError` if there is none."""
    table = read_tables(out)
    parts = [_summary(table), *_failures(table), *_distributions(table), *_slowest(table), *_gallery(out, table)]
    head = f'<!doctype html><meta charset="utf-8"><title>vdoor batch</title><style>{STYLE}</style>'
    return write_whole(out / PAGE, "\n".join([head, *parts, ""]).encode())


def _summary(table: Any) -> str:
    failed = table.num_rows - _whole(table).num_rows
    cpu_s = pc.sum(table["cpu_s"]).as_py() or 0.0
    return f"<h1>{table.num_rows:,} maps</h1><p>{failed:,} failed; {cpu_s:,.0f} s of CPU for the method.</p>"


def _whole(table: Any) -> Any:
    """The rows that have a result."""
    return table.filter(pc.is_null(table["error"]))


def _failures(table: Any) -> Iterator[str]:
    """Failures by kind and text, with one map each."""
    failed = table.filter(pc.is_valid(table["error"])).select(["error_kind", "error", "map"]).to_pylist()
    if not failed:
        return
    kinds = Counter((row["error_kind"], _general(row["error"])) for row in failed)
    examples = {(row["error_kind"], _general(row["error"])): row["map"] for row in reversed(failed)}
    rows = [(str(count), kind, text, examples[kind, text]) for (kind, text), count in kinds.most_common(SHOWN)]
    yield "<h2>Failures by kind</h2>"
    yield _listed(("maps", "kind", "error", "one of them"), rows)


def _general(error: str) -> str:
    """The text of an error without the path at its end and without numbers."""
    return re.sub(r"\d+(\.\d+)?", "N", re.sub(r": [^ ]*/[^ ]*$", "", error))[:200]


def _distributions(table: Any) -> Iterator[str]:
    yield "<h2>Distributions</h2><div class=all>"
    for name, title in DISTRIBUTIONS.items():
        values = table[name].drop_null().to_numpy().astype(np.float64)
        if len(values):
            yield _distribution(title, values)
    yield "</div>"


def _distribution(title: str, values: np.ndarray) -> str:
    """Bars over the values' range, cut at the 99th percentile, whose last bar has what is beyond."""
    low, high = float(values.min()), float(np.percentile(values, 99))
    counts, _ = np.histogram(np.minimum(values, high), bins=BARS, range=(low, max(high, low + 1e-9)))
    bars = "".join(f'<i style="height:{count / counts.max():.1%}"></i>' for count in counts.tolist())
    middle = f"median {np.median(values):.4g}, mean {values.mean():.4g}, most {values.max():.4g}"
    ends = f"<span>{low:.4g}</span><span>{high:.4g}</span>"
    return (
        f"<figure><b>{html.escape(title)}</b><div class=bars>{bars}</div><div class=ends>{ends}</div>"
        f"<figcaption>{middle}</figcaption></figure>"
    )


def _slowest(table: Any) -> Iterator[str]:
    rows = table.filter(pc.is_valid(table["cpu_s"])).sort_by([("cpu_s", "descending")]).slice(0, SHOWN).to_pylist()
    if not rows:
        return
    yield "<h2>Slowest</h2>"
    shown = [
        (
            f"{row['cpu_s']:.2f}",
            f"{row['peak_mb'] or 0:.0f}",
            f"{row['width']} x {row['height']}",
            _longest(row),
            row["map"],
        )
        for row in rows
    ]
    yield _listed(("CPU s", "MB", "cells", "longest stage", "map"), shown)


def _longest(row: Any) -> str:
    stage, seconds = max(row["stages_s"] or [("", 0.0)], key=lambda one: one[1])
    return f"{stage} {seconds:.2f} s"


def _gallery(out: Path, table: Any) -> Iterator[str]:
    """Pictures of the worst maps by F1; where no map has a reference, of the first."""
    measured = table.filter(pc.is_valid(table["door_f1"]))
    worst = measured.sort_by([("door_f1", "ascending"), ("map", "ascending")])
    rows = (worst if measured.num_rows else _whole(table)).slice(0, PICTURES).to_pylist()
    if not rows:
        return
    yield f"<h2>{'Worst by door F1' if measured.num_rows else 'Maps'}</h2><div class=all>"
    for row in rows:
        f1 = "" if row["door_f1"] is None else f"F1 {row['door_f1']:.3f}, "
        said = f"{f1}{row['rooms']} rooms, {row['doors']} doors: {posixpath.basename(row['map'])}"
        yield f"<figure>{_picture(out / row['folder'])}<figcaption>{html.escape(said)}</figcaption></figure>"
    yield "</div>"


def _listed(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    head = "".join(f"<th>{html.escape(name)}</th>" for name in heads)
    lines = ("".join(f"<td>{html.escape(cell)}</td>" for cell in row) for row in rows)
    return f"<table><tr>{head}</tr>\n" + "\n".join(f"<tr>{line}</tr>" for line in lines) + "\n</table>"


def _picture(folder: Path) -> str:
    """The rooms of a result as a small picture; a word where the result is gone."""
    try:
        labels = read_labels(folder / "rooms.png")
    except VdoorError:
        return "<p>no result there any more</p>"
    every = -(-max(labels.shape) // SIDE)
    small = labels[::every, ::every].astype(np.uint32)
    shade = np.where(small > 0, 90 + small * 67 % 150, 0).astype(np.uint8)
    data = base64.b64encode(png(shade)).decode()
    return f'<img alt="rooms" src="data:image/png;base64,{data}">'
