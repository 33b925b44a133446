"""The index of a batch: a CSV for programs, and a page with a picture of each map for people."""

from __future__ import annotations

import base64
import csv
import html
import io
import os
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from vdoor.batch.job import Outcome
from vdoor.evaluate.label_files import read_labels
from vdoor.partial import write_whole
from vdoor.results.writing import png

SIDE = 240
"""Longest side of a picture, in pixels."""
COLUMNS = ("map", "rooms", "doors", "area_m2", "folder", "error")
STYLE = "body{font:15px sans-serif;margin:2em}table{border-collapse:collapse}td,th{padding:.4em 1em;text-align:left}"


def write_index(out: Path, outcomes: Sequence[Outcome]) -> list[Path]:
    """Write index.csv and index.html into `out`, in the order of the maps' names; returns both.

    The CSV holds no times, so that equal batches give equal files.
    """
    rows = [_row(out, outcome) for outcome in sorted(outcomes, key=lambda outcome: str(outcome.map_file))]
    return [
        write_whole(out / "index.csv", _csv(rows).encode()),
        write_whole(out / "index.html", _page(out, rows).encode()),
    ]


def _row(out: Path, outcome: Outcome) -> tuple[str, ...]:
    folder = os.path.relpath(outcome.folder, out)
    numbers = (str(outcome.rooms), str(outcome.doors), f"{outcome.area_m2:.2f}")
    return (str(outcome.map_file), *(("", "", "") if outcome.error else numbers), folder, outcome.error)


def _csv(rows: Iterable[Sequence[str]]) -> str:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([COLUMNS, *rows])
    return text.getvalue()


def _page(out: Path, rows: Sequence[Sequence[str]]) -> str:
    """A table with a picture of each result, all in one file."""
    heads = "".join(f"<th>{html.escape(name)}</th>" for name in ("", *COLUMNS))
    lines = ("".join(f"<td>{html.escape(cell)}</td>" for cell in row) for row in rows)
    body = "\n".join(
        f"<tr><td>{'' if row[-1] else _picture(out / row[-2])}</td>{line}</tr>"
        for row, line in zip(rows, lines, strict=True)
    )
    head = f'<!doctype html><meta charset="utf-8"><title>vdoor batch</title><style>{STYLE}</style>'
    return f"{head}\n<table><tr>{heads}</tr>\n{body}\n</table>\n"


def _picture(folder: Path) -> str:
    """The rooms of a result as a small picture."""
    labels = read_labels(folder / "rooms.png")
    every = -(-max(labels.shape) // SIDE)
    small = labels[::every, ::every].astype(np.uint32)
    shade = np.where(small > 0, 90 + small * 67 % 150, 0).astype(np.uint8)
    data = base64.b64encode(png(shade)).decode()
    return f'<img alt="rooms" src="data:image/png;base64,{data}">'
