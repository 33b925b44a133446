"""The pictures of the site, drawn from recordings of runs on an example map, the same bytes each time."""

# ruff: noqa: INP001  # part of the site, not of a package
from __future__ import annotations

import functools
import json
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import blocks
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from vdoor import export
from vdoor.history import History
from vdoor.pipeline import RECORDS
from vdoor.record import specs
from vdoor.recording.mcap import read_recording
from vdoor.viz.charts import drawing, rgb, to_png
from vdoor.viz.rerun import style

MAP = Path("recordings/furnished.yaml")
WIDE_IN = 7.2
COLUMN_IN = 1.8
"""Of the key below a picture."""
MARGIN = 1
UNKNOWN = (255, 255, 255)
FREE = (232, 232, 226)
OCCUPIED = (38, 40, 46)
ATOM = (206, 208, 214)
CLOSE_UP = 13
"""Cells across, of the picture of f and b."""
PLOT_M = 25.0
"""Of the path, in the plot of angles: all of it would be a blur."""
NAMEPLATE = {"boxstyle": "round", "facecolor": "white", "edgecolor": "none", "alpha": 0.7}
Cells = NDArray[Any]


def drawn(name: str) -> bytes:
    """One picture as a PNG; `PICTURES` has the names."""
    return PICTURES[name]()


@functools.cache
def _runs() -> tuple[History, History]:
    """The example map by the presets `default` and `paper`, as their recordings have it."""
    with tempfile.TemporaryDirectory() as folder:
        blocks.ready(Path(folder))
        both = []
        for preset in ("default", "paper"):
            line = f"vdoor run {MAP} --preset {preset} --mcap {preset}.mcap --out {preset} --quiet"
            blocks.run(blocks.Step("sh", line, 0, 0), Path(folder))
            both.append(History.read(read_recording(Path(folder) / f"{preset}.mcap", types=RECORDS)))
        return both[0], both[1]


class Plan:
    """A map to draw on; places are cells (k, 2) as row, col, whole numbers their middles."""

    def __init__(self, axes: Axes, cells: Cells, window: tuple[float, float, float, float]) -> None:
        top, bottom, left, right = window
        axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal")
        axes.set_axis_off()
        self.axes = axes
        self.meanings: list[Line2D] = []
        known = np.where(cells < 0, 0, np.where(cells < 50, 1, 2))  # noqa: PLR2004  # half occupied
        axes.imshow(np.array([UNKNOWN, FREE, OCCUPIED], np.uint8)[known], interpolation="nearest")

    def over(self, where: Cells, colour: Sequence[int], meaning: str = "") -> None:
        """Cells (h, w) in a colour."""
        layer = np.zeros((*where.shape, 4), np.uint8)
        layer[where] = (*colour[:3], 255)
        self.axes.imshow(layer, interpolation="nearest")
        self._mean(meaning, colour, marker="s", linestyle="none")

    def dots(self, places: Cells, colour: Sequence[int], meaning: str = "", *, size: float = 5.0) -> None:
        """A dot at each place."""
        self.axes.scatter(places[:, 1], places[:, 0], s=size**2, color=rgb(colour), linewidths=0, zorder=4)
        self._mean(meaning, colour, marker="o", linestyle="none")

    def lines(
        self, start: Cells, end: Cells, colour: Sequence[int], meaning: str = "", *, wide: float = 2.0, over: float = 3
    ) -> None:
        """A line from each start to its end."""
        columns, rows = (np.stack([start[:, axis], end[:, axis]]) for axis in (1, 0))
        self.axes.plot(columns, rows, color=rgb(colour), linewidth=wide, solid_capstyle="round", zorder=over)
        self._mean(meaning, colour, linewidth=2)

    def arrow(self, start: Cells, by: Cells, colour: Sequence[int], meaning: str = "") -> None:
        """An arrow from a place by a vector."""
        look = {"arrowstyle": "-|>", "color": rgb(colour), "linewidth": 2.0, "shrinkA": 0, "shrinkB": 0}
        row, col = start + by
        self.axes.annotate("", (col, row), (start[1], start[0]), arrowprops=look, zorder=5)
        self._mean(meaning, colour, linewidth=2)

    def text(self, place: Cells, words: str, **look: Any) -> None:
        """Words with their middle at a place."""
        self.axes.text(place[1], place[0], words, ha="center", va="center", zorder=6, **look)

    def _mean(self, meaning: str, colour: Sequence[int], **look: Any) -> None:
        if meaning and meaning not in [one.get_label() for one in self.meanings]:
            self.meanings.append(Line2D([], [], color=rgb(colour), label=meaning, markersize=7, **look))


def _plan(draw: Callable[[Plan, History], None]) -> bytes:
    """The map with what a stage found on it, and below it what the colours mean."""
    run, _ = _runs()
    window = _window(run.simplified.cells)
    top, bottom, left, right = window
    with drawing(WIDE_IN, WIDE_IN * (bottom - top) / (right - left) + 0.4) as figure:
        plan = Plan(figure.subplots(), run.simplified.cells, window)
        draw(plan, run)
        _key(figure, plan.meanings)
        return to_png(figure)


def _key(figure: Figure, meanings: list[Line2D]) -> None:
    if meanings:
        columns = int(figure.get_figwidth() / COLUMN_IN)
        figure.legend(handles=meanings, loc="outside lower center", ncols=columns, fontsize=10)


def _window(cells: Cells, margin: float = MARGIN) -> tuple[float, float, float, float]:
    """Top, bottom, left and right of what is known."""
    rows, columns = np.nonzero(cells >= 0)
    return (
        rows.min() - 0.5 - margin,
        rows.max() + 0.5 + margin,
        columns.min() - 0.5 - margin,
        columns.max() + 0.5 + margin,
    )


def _words(record: Any, field: str) -> tuple[str, ...]:
    return specs(type(record))[field][0].words


def _input(plan: Plan, run: History) -> None:
    cells = run.input.cells
    for where, colour, meaning in (
        (cells < 0, UNKNOWN, ""),
        ((cells >= 0) & (cells < 50), FREE, "free"),  # noqa: PLR2004  # half occupied
        (cells >= 50, OCCUPIED, "occupied"),  # noqa: PLR2004
    ):
        plan.over(where, colour, meaning)


def _simplified(plan: Plan, run: History) -> None:
    found = run.simplified
    for number, name in enumerate(_words(found, "reason")):
        if number and (found.reason == number).any():
            plan.over(found.reason == number, style.OF_REASON[name], name)


def _boundary(plan: Plan, run: History, *, faint: bool = False) -> None:
    path = run.path
    for ring in np.split(path.cell, path.first[1:]):
        after = np.roll(ring, -1, axis=0)
        plan.lines(ring, after, style.BOUNDARY, "" if faint else "path", wide=1.2 if faint else 2.0, over=2)


def _path(plan: Plan, run: History) -> None:
    _boundary(plan, run)
    path = run.path
    plan.dots(path.cell, style.BOUNDARY, "sample", size=4)
    for sample in range(4, len(path.cell), 12):
        here, ahead = path.free_cell[sample], path.free_cell[(sample + 1) % len(path.cell)]
        if 0 < np.abs(ahead - here).sum() <= 2:  # noqa: PLR2004  # a step on
            plan.arrow(here - (ahead - here) * 0.6, (ahead - here) * 1.4, style.WALKER, "walker, wall on the left")


def _candidates(plan: Plan, run: History) -> None:
    _boundary(plan, run, faint=True)
    _by_kind(plan, run.candidates.cell, run.candidates.convex)


def _corners(plan: Plan, run: History) -> None:
    _boundary(plan, run, faint=True)
    _by_kind(plan, run.corners.quarter / 4 - 0.5, run.corners.convex, size=8.0)


def _by_kind(plan: Plan, places: Cells, convex: Cells, *, size: float = 6.0) -> None:
    for chosen, colour, meaning in ((~convex, style.CONCAVE, "concave"), (convex, style.CONVEX, "convex")):
        plan.dots(places[chosen], colour, f"{meaning} ({chosen.sum()})", size=size)


def _doors(plan: Plan, run: History) -> None:
    found = run.doors
    for number, verdict in enumerate(_words(found, "verdict")):
        chosen = found.verdict == number
        if verdict in ("no gap", "duplicate") or not chosen.any():
            continue
        colour, wide = (style.DOOR, 2.2) if number == 0 else (style.REJECTED[verdict], 0.9)
        meaning = f"{verdict} ({chosen.sum()})"
        plan.lines(found.start[chosen], found.end[chosen], colour, meaning, wide=wide, over=5 - min(number, 1))
    convex = run.corners.convex
    plan.dots(run.corners.cell[convex], style.CONVEX, "convex corner", size=6)


def _scores(plan: Plan, run: History) -> None:
    doors, scores = run.doors, run.scores
    judgements = _words(scores, "judgement")
    start, end = doors.start[scores.door], doors.end[scores.door]
    for number, name in enumerate(judgements):
        chosen = scores.judgement == number
        if name in style.JUDGED and chosen.any():
            plan.lines(start[chosen], end[chosen], style.JUDGED[name], f"{name} ({chosen.sum()})", wide=0.9)
    likely = np.flatnonzero(scores.judgement == judgements.index("likely"))
    for row in likely.tolist():
        meaning = "likely, sure" if scores.log_odds[row] > 0 else "likely, doubtful"
        plan.lines(start[[row]], end[[row]], style.odds(scores.log_odds[row]), meaning, wide=3.0, over=4)
    pairs = np.stack([scores.rival_a, scores.rival_b], axis=1)
    middle = (start + end) / 2
    plan.lines(middle[pairs[:, 0]], middle[pairs[:, 1]], style.CONFLICTS, f"conflict ({len(pairs)})", wide=1.5, over=5)
    plan.dots(middle[np.unique(pairs)], style.CONFLICTS, size=4)


def _initial_map(plan: Plan, run: History) -> None:
    found = run.initial
    regions = len(found.area_m2)
    for region in range(1, regions + 1):
        plan.over(found.piece == region, style.room(region))
    plan.over(found.piece > regions, ATOM, f"atoms of door cells ({len(found.atom_area_m2)})")
    middle = (found.start + found.end) / 2
    plan.lines(middle[found.border_edge], found.centre[found.border_region], style.LINK, "borders", wide=1.0)
    plan.lines(found.start, found.end, style.DOOR, f"virtual door ({len(found.door)})")
    plan.dots(found.centre, style.NODE, f"node: region ({regions})", size=8)
    plan.dots(middle, style.EDGE_MIDDLE, f"edge: door ({len(found.door)})")


def _map(plan: Plan, run: History) -> None:
    found, frame = run.topology, run.input.frame
    plan.over(run.input.cells >= 50, OCCUPIED)  # noqa: PLR2004  # the map as it was read
    for room in found.rooms:
        plan.over(found.labels == room.id, style.room(room.id))
    start, end = (frame.cell_from_world(ends) for ends in (found.start_m, found.end_m))
    middle = (start + end) / 2
    centres = {room.id: np.array(frame.cell_from_world(np.array([room.centre_m]))[0]) for room in found.rooms}
    for rooms in (found.room_a, found.room_b):
        plan.lines(middle, np.array([centres[room] for room in rooms.tolist()]), style.LINK, wide=1.2)
    plan.lines(start, end, style.KEPT, "door", wide=3.5)
    plan.dots(np.array([*centres.values()]), style.NODE, "room", size=9)
    for room in found.rooms:
        plan.text(centres[room.id] + [2.2, 0], f"{room.id}: {room.area_m2:.1f} m²", fontsize=11, bbox=NAMEPLATE)


def _vectors() -> bytes:
    """Close up, at a convex corner: the samples that f and b reach to, and the angle between."""
    run, _ = _runs()
    path, found = run.path, run.curvature
    reach = found.k_forward + found.k_backward
    corner = max(run.corners.sample[run.corners.convex].tolist(), key=lambda sample: (reach[sample], -sample))
    here = path.half[corner] / 2 - 0.5
    top, left = here - [CLOSE_UP / 2, CLOSE_UP / 2]
    with drawing(WIDE_IN * 0.75, WIDE_IN * 0.75 + 0.5) as figure:
        plan = Plan(figure.subplots(), run.simplified.cells, (top, top + CLOSE_UP, left, left + CLOSE_UP))
        _boundary(plan, run)
        plan.dots(path.cell, style.BOUNDARY, "sample", size=6)
        plan.arrow(here, found.forward[corner] / 2, style.FORWARD, f"f, to {found.k_forward[corner]} samples ahead")
        plan.arrow(here, found.backward[corner] / 2, style.BACKWARD, f"b, to {found.k_backward[corner]} samples back")
        plan.dots(here[None], style.CONVEX, f"angle {np.degrees(found.angle_rad[corner]):.0f}°", size=10)
        _key(figure, plan.meanings)
        return to_png(figure)


def _curvature() -> bytes:
    """The angle along the path, and the threshold below which a sample is a candidate."""
    run, _ = _runs()
    path, found, candidates = run.path, run.curvature, run.candidates
    angle_deg = np.degrees(found.angle_rad)
    with drawing(WIDE_IN, 3.2) as figure:
        axes = figure.subplots()
        axes.plot(path.arc_m, angle_deg, color=rgb(style.BETWEEN), linewidth=1.0)
        for convex, colour, meaning in ((False, style.CONCAVE, "concave"), (True, style.CONVEX, "convex")):
            chosen = candidates.sample[candidates.convex == convex]
            axes.plot(path.arc_m[chosen], angle_deg[chosen], "o", color=rgb(colour), markersize=4, label=meaning)
        axes.axhline(155, color=rgb(style.THRESHOLD), linewidth=1.2, label="155°")
        axes.set(xlabel="along the path, m", ylabel="angle between f and b, degrees", xlim=(0, PLOT_M))
        figure.legend(loc="outside lower center", ncols=3, fontsize=10)
        return to_png(figure)


def _search() -> bytes:
    """Cost of the population, generation by generation, by the paper's search."""
    _, run = _runs()
    number = [one.number for one in run.search]
    with drawing(WIDE_IN, 3.2) as figure:
        axes = figure.subplots()
        for name, colour in (("worst", style.WORST), ("mean", style.MEAN), ("best", style.BEST)):
            costs = [getattr(one, f"{name}_cost") for one in run.search]
            axes.plot(number, costs, color=rgb(colour), linewidth=1.8, label=name)
        axes.set(xlabel="generation", ylabel="cost (eq. 7)", xlim=(0, number[-1]))
        axes.legend(fontsize=10)
        return to_png(figure)


def _route(plan: Plan, run: History) -> None:
    plan.over(run.input.cells >= 50, OCCUPIED)  # noqa: PLR2004  # the map as it was read
    features = json.loads(export.to_nav2_route(run.topology))["features"]
    at = {
        one["properties"]["id"]: np.array(one["geometry"]["coordinates"], np.float64)
        for one in features
        if one["geometry"]["type"] == "Point"
    }
    edges = [one["properties"] for one in features if "startid" in one["properties"]]
    ends = [run.input.frame.cell_from_world(np.array([at[one[end]] for one in edges])) for end in ("startid", "endid")]
    plan.lines(ends[0], ends[1], style.DOOR, "edge")
    rooms = {room.id for room in run.topology.rooms}
    for chosen, colour, meaning, size in (
        (True, style.NODE, "room", 9),
        (False, style.EDGE_MIDDLE, "door or place", 6),
    ):
        places = np.array([place for number, place in at.items() if (number in rooms) == chosen])
        plan.dots(run.input.frame.cell_from_world(places), colour, meaning, size=size)


def _keepout(plan: Plan, run: History) -> None:
    mask = export.to_keepout(run.topology, rooms=[2])
    plan.over(mask.cells == 0, OCCUPIED, "closed to the robot")
    plan.over(mask.cells > 0, FREE, "room 2, open")
    plan.lines(np.zeros((0, 2)), np.zeros((0, 2)), style.DOOR)


PICTURES: dict[str, Callable[[], bytes]] = {
    "input": lambda: _plan(_input),
    "simplified": lambda: _plan(_simplified),
    "path": lambda: _plan(_path),
    "vectors": _vectors,
    "curvature": _curvature,
    "candidates": lambda: _plan(_candidates),
    "corners": lambda: _plan(_corners),
    "doors": lambda: _plan(_doors),
    "scores": lambda: _plan(_scores),
    "initial_map": lambda: _plan(_initial_map),
    "search": _search,
    "map": lambda: _plan(_map),
    "route": lambda: _plan(_route),
    "keepout": lambda: _plan(_keepout),
}
"""What draws each picture, by its name in pages."""
