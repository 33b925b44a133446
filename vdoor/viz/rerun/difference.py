"""Two runs drawn over each other, with their differences marked."""

from __future__ import annotations

import contextlib
from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from vdoor.emit import RunInfo
from vdoor.frame import Frame
from vdoor.grid import OccupancyGrid
from vdoor.partial import Partial
from vdoor.record import COLUMNS, RASTERS, Record, specs
from vdoor.recording.compare import Difference, places, unequal
from vdoor.recording.diff import Pair
from vdoor.viz.rerun import style
from vdoor.viz.rerun.blueprint import COSTS
from vdoor.viz.rerun.chart import view_of_chart
from vdoor.viz.rerun.draw import draw_record
from vdoor.viz.rerun.pump import Pump
from vdoor.viz.rerun.scene import Scene, classes, pixels
from vdoor.viz.rerun.sink import FLUSH_S, errors_at, new_stream

EXPECTED, FOUND = "recorded", "again"
TABS = ("Differences", "Stages", "Search")
MARK: style.Colour = (230, 0, 200)
DESCRIPTION = """# Two runs, compared

Both runs are drawn under their own names, `recorded` and `again`; differences are marked in **magenta** over the map of
the first. One step of the timeline is one record of both. The log lists the differences, stage by stage; those after
the first stage that differs follow from it.
"""


class DifferenceSink:
    """Draws each pair of records that it is called with; the file gets its final name when closed."""

    def __init__(self, path: Path, info: RunInfo, *, limit_deg: float = 155.0) -> None:
        self.path = path
        self._step = 0
        self._partial = Partial(path)
        with errors_at(path):
            stream, self._pump = new_stream(info), Pump(self._partial.stream())
            stream.save(self._pump.address, default_blueprint=blueprint())
        self._marks = Scene(stream)
        self._scenes = {name: Scene(stream, prefix=f"{name}/") for name in (EXPECTED, FOUND)}
        for scene in self._scenes.values():
            scene.threshold_deg = limit_deg
        self._marks.keep("description", rr.TextDocument(DESCRIPTION, media_type="text/markdown"))

    def __call__(self, pair: Pair) -> None:
        """Draw one pair; differing rows of a table are marked at their position in the first run."""
        with errors_at(self.path):
            for name, record in ((EXPECTED, pair.expected), (FOUND, pair.found)):
                if record is not None:
                    self._scenes[name].begin(self._step, record.topic)
                    draw_record(self._scenes[name], record)
            self._marks.begin(self._step, pair.topic)
            if pair.expected is None or pair.found is None:
                self._marks.log_text(f"{pair.topic} {pair.rank} is in one run only")
            else:
                self._mark(pair.expected, pair.found, pair.differences)
        self._step += 1

    def close(self) -> None:
        """Finish the file."""
        with errors_at(self.path):
            self._marks.stream.flush(timeout_sec=FLUSH_S)
            self._marks.stream.disconnect()
            self._pump.close()
        self._partial.give_name()

    def abandon(self) -> None:
        """Discard the file: half a comparison is misleading."""
        self._marks.stream.disconnect()
        with contextlib.suppress(OSError):  # a second error, or closed already
            self._pump.close()
        self._partial.remove()

    def _mark(self, expected: Record, found: Record, differences: tuple[Difference, ...]) -> None:
        """Log each difference, and mark its position if it has one."""
        fields = specs(type(expected))
        for difference in differences:
            worst = difference.worst
            self._marks.log_text(
                f"{expected.topic}.{difference.field}: {difference.count} of {difference.total} differ, "
                f"{worst.expected} and {worst.found}"
            )
            spec = fields[difference.field][0] if difference.field in fields else None
            one, other = (getattr(record, difference.field, None) for record in (expected, found))
            if spec is None or not isinstance(one, np.ndarray) or not isinstance(other, np.ndarray):
                continue
            if one.shape != other.shape:
                continue
            mask = unequal(one, other, spec.tolerance)
            entity = f"difference/{frame_of(expected)}/{expected.topic}/{difference.field}"
            if spec.kind in RASTERS:
                self._marks.keep(entity, classes({0: ("equal", style.CLEAR), 1: ("differs", MARK)}))
                self._marks.raster(entity, mask.astype(np.uint8), order=300.0)
            elif spec.kind in COLUMNS and (at := places(expected, spec.axes[0])) is not None:
                rows = mask.reshape(len(mask), -1).any(axis=1)
                points = rr.Points2D(pixels(at.cells[rows]), colors=MARK, radii=-4.0, draw_order=301.0)
                self._marks.log(entity, points)


def frame_of(record: Record) -> str:
    """Name of a record's frame: that of the input or that of the working grid."""
    at_input = isinstance(record, OccupancyGrid) or record.topic == "map"
    return "input" if at_input and isinstance(getattr(record, "frame", None), Frame) else "working"


def blueprint() -> rrb.Blueprint:
    """Tabs with the marked map beside the log, both runs side by side, and both costs."""
    marked = _view("Differences at the working resolution", f"{EXPECTED}/map/simplified", "difference/working/**")
    rooms = _view(
        "Differences in the result", f"{EXPECTED}/input/map", f"{EXPECTED}/rooms/doors", "difference/input/**"
    )
    texts = rrb.Tabs(
        rrb.TextLogView(origin="log", name="Differences"),
        rrb.TextDocumentView(origin="description", name="Read me"),
        active_tab=0,
    )
    both = [
        _view(
            f"{name}: corners and doors",
            *(f"{name}/map/{part}" for part in ("simplified", "corners/**", "doors/proposed")),
        )
        for name in (EXPECTED, FOUND)
    ]
    results = [_view(f"{name}: rooms", f"{name}/input/map", f"{name}/rooms/**") for name in (EXPECTED, FOUND)]
    costs = [view_of_chart(f"{name}/charts/cost", f"{name}: {COSTS}") for name in (EXPECTED, FOUND)]
    return rrb.Blueprint(
        rrb.Tabs(
            rrb.Horizontal(rrb.Vertical(marked, rooms), texts, column_shares=[2, 1], name=TABS[0]),
            rrb.Grid(*both, *results, grid_columns=2, name=TABS[1]),
            rrb.Horizontal(*costs, name=TABS[2]),
        ),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed", timeline="step", play_state="following"),
        auto_views=False,
        auto_layout=False,
    )


def _view(name: str, *contents: str) -> rrb.Spatial2DView:
    return rrb.Spatial2DView(name=name, origin="/", contents=[f"+ /{path}" for path in contents])
