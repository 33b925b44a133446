"""A Rerun stream that tracks its position in the run: every row has the global step and stage."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from vdoor.history.records import RunRecords
from vdoor.method.search.generation import Generation
from vdoor.record import Record, Spec, specs, tables
from vdoor.viz.marks.kinds import reduced

LARGEST_SIDE_PX = 16_384
"""Maximum size of a texture; larger rasters are reduced."""
SCRUBBED = ("sample", "corner", "generation", "drive")
"""Timelines besides `step` and `stage`.

Data that does not change along one of them is logged at its 0, so that it is visible there as well.
"""
THRESHOLD_DEG = 155.0
"""Of recordings whose settings do not say."""


class Scene:
    """Drawing surface for the records of one run, one after the other."""

    def __init__(self, stream: rr.RecordingStream, *, prefix: str = "") -> None:
        self.stream = stream
        self.prefix = prefix
        """Prefix of the name of every entity."""
        self.step = 0
        self.stage = 0
        self.topics: list[str] = []
        """Topics of the records so far; the index of a topic is its stage."""
        self.run = RunRecords()
        """The records so far: later drawings need earlier ones."""
        self.threshold_deg = THRESHOLD_DEG
        """Angle below which samples are candidates."""

    def begin(self, step: int, topic: str) -> None:
        """Start the next record."""
        self.step = step
        if topic not in self.topics:
            self.topics.append(topic)
        self.stage = self.topics.index(topic)
        self.stream.reset_time()
        self.at()
        self.log("state/stage", rr.StateChange(state=topic))

    def remember(self, record: Record) -> None:
        """Keep a record for later drawings; a second one of a stage takes the place of the first."""
        self.run.steps.setdefault(record.topic, self.step)
        if isinstance(record, Generation):
            self.at(generation=record.number)
            self.run.search.add(record)
        else:
            self.run.records[record.topic] = record

    def at(self, **places: int) -> None:
        """Set the time of the following logs: the step, and a position on the named timelines."""
        self.stream.set_time("step", sequence=self.step)
        self.stream.set_time("stage", sequence=self.stage)
        for timeline in SCRUBBED:
            self.stream.set_time(timeline, sequence=places.get(timeline, 0))

    def log(self, entity: str, *what: Any) -> None:
        """Log at the current time."""
        self.stream.log(self.prefix + entity, what[0], *what[1:])

    def keep(self, entity: str, what: Any) -> None:
        """Log static data, valid at all times."""
        self.stream.log(self.prefix + entity, what, static=True)

    def columns(self, entity: str, timeline: str, places: NDArray[Any], columns: Iterable[Any]) -> None:
        """Log one row for each position on a timeline, all at this step."""
        zeros = np.zeros(len(places), np.int64)
        sequences = dict.fromkeys(SCRUBBED, zeros) | {
            "step": zeros + self.step,
            "stage": zeros + self.stage,
            timeline: places,
        }
        indexes = [rr.TimeColumn(name, sequence=sequence) for name, sequence in sequences.items()]
        self.stream.send_columns(self.prefix + entity, indexes=indexes, columns=columns)

    def raster(self, entity: str, classes: NDArray[Any], *, order: float = 0.0, opacity: float = 1.0) -> None:
        """Log a raster of class numbers (h, w), reduced if it is larger than a texture can be."""
        reduce_by = -(-max(classes.shape) // LARGEST_SIDE_PX)
        if reduce_by > 1:
            classes = reduced(classes, reduce_by)
            self.log(entity, rr.Transform3D(scale=(reduce_by, reduce_by, 1)))  # so that points still match it
            self.log_text(f"{entity} is drawn at 1 : {reduce_by}, the largest picture is {LARGEST_SIDE_PX} cells wide")
        self.log(entity, rr.SegmentationImage(classes, draw_order=order, opacity=opacity))

    def log_text(self, text: str) -> None:
        """Write a line to the text log."""
        self.log("log", rr.TextLog(text))


def classes(names: Mapping[int, tuple[str, Sequence[int]]]) -> rr.AnnotationContext:
    """Names and colours of class numbers."""
    return rr.AnnotationContext(
        [rr.AnnotationInfo(id=key, label=label, color=colour) for key, (label, colour) in names.items()]
    )


def pixels(cells: NDArray[Any]) -> NDArray[np.float64]:
    """Cells (k, 2), as row, col, as x, y of a picture; integer rows and columns are cell centres."""
    return np.asarray(cells, np.float64)[:, ::-1] + 0.5


def strips(start: NDArray[Any], end: NDArray[Any]) -> NDArray[np.float32]:
    """Segments (k, 2, 2) between cells, as x, y of a picture in float32."""
    return np.stack([pixels(start), pixels(end)], axis=1).astype(np.float32)


Columns = dict[str, Any]
DECIMALS = 3


def table(scene: Scene, record: Record, name: str, *, without: Sequence[str] = ()) -> None:
    """Log a table of a record, one row per position on the timeline `corner` or `row`, without some fields.

    A viewer makes a column as wide as its name: names of columns with text are long.
    """
    columns: Columns = {}
    for field in (field for field in tables(type(record))[name] if field not in without):
        values, spec = getattr(record, field), specs(type(record))[field][0]
        if not len(values):
            return
        columns |= columns_of(field, values, spec=spec)
    timeline = name if name == "corner" else "row"
    rows = np.arange(len(values))
    scene.columns(f"tables/{record.topic}", timeline, rows, rr.AnyValues.columns(**columns))


def columns_of(field: str, values: NDArray[Any], *, spec: Spec) -> Columns:
    """Columns of one field: words for codes, degrees for angles, vectors as text, numbers rounded."""
    if spec.words:
        return {f"{field}_in_words": np.array(spec.words)[values].tolist()}
    if spec.unit == "rad":
        return {field.replace("_rad", "_deg"): rounded(np.degrees(values))}
    if values.ndim == 1:
        return {field: rounded(values)}
    parts = "x_y" if spec.unit == "m" else "row_col"
    return {
        f"{field}_{parts}": [", ".join(f"{part:g}" for part in row) for row in np.atleast_2d(rounded(values)).tolist()]
    }


def rounded(values: NDArray[Any]) -> NDArray[Any]:
    """Numbers of a table as people read them; exact ones are in the .mcap."""
    return np.round(values, DECIMALS) if values.dtype.kind == "f" else values
