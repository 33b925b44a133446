"""A small real run and its recording, and the command called within the test."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from vdoor.config import settings_of
from vdoor.emit import RunInfo
from vdoor.goldens import drawing
from vdoor.method.search.optimisers import GeneticSearch
from vdoor.pipeline import METHODS, RECORDS, Pipeline
from vdoor.record import Record
from vdoor.recording.mcap import McapSink, read_recording

MAP = """
    ################
    #......#.......#
    #......#.......#
    #..............#
    #..............#
    #......#.......#
    #......#.......#
    ################
"""
PIPELINE = Pipeline(search=GeneticSearch(population=8, generations=3))


@functools.cache
def small_run() -> tuple[RunInfo, tuple[Record, ...]]:
    """Give what a run on two rooms was, and its records: one a stage, and four generations."""
    grid = drawing(MAP)()
    settings = settings_of(PIPELINE, METHODS)
    records: list[Record] = []

    def emit(record: Any, /) -> Any:
        records.append(record)
        return record

    PIPELINE(grid, np.random.default_rng(5), emit)
    return RunInfo(version="0.1.0", preset="paper", seed=5, settings=settings, source=grid.source), tuple(records)


def write(path: Path, records: Sequence[Record], info: RunInfo | None = None) -> Path:
    sink = McapSink(path, info or small_run()[0])
    for step, record in enumerate(records):
        sink.write(step, record)
    sink.close()
    return path


def small(path: Path) -> Path:
    return write(path, small_run()[1])


def altered(topic: str, field: str, index: Any, change: Any) -> list[Record]:
    """Give the records of the small run with one element of the first record of a stage changed."""
    records = list(small_run()[1])
    at = next(i for i, record in enumerate(records) if record.topic == topic)
    values = np.array(getattr(records[at], field))
    values[index] = change(values[index])
    records[at] = dataclasses.replace(records[at], **{field: values})  # type: ignore[type-var]  # a dataclass
    return records


def read(path: Path) -> list[Record]:
    return [record for _, record in read_recording(path, types=RECORDS)]
