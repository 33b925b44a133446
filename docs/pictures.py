"""All pictures of the README, the site and the tests, drawn from recordings by what draws those of `vdoor shot`.

The site draws its own when it is built. `python docs/pictures.py` writes those that are kept in the repository; the
tests draw them again and compare.
"""

# ruff: noqa: INP001  # part of the site, not of a package
from __future__ import annotations

import functools
import json
import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import blocks
import numpy as np

from vdoor import export
from vdoor.grid import OCCUPIED_FROM
from vdoor.history import History
from vdoor.method.boundary import BoundaryPath
from vdoor.pipeline import RECORDS
from vdoor.recording.mcap import read_recording
from vdoor.viz.marks import boundary, doors, maps, plots
from vdoor.viz.marks.kinds import Arrows, Cells, Chart, Dots, Lines, Mark, Places, segments
from vdoor.viz.picture.pictures import picture_of, pictures
from vdoor.viz.picture.plan import Window
from vdoor.viz.picture.views import Plan, View
from vdoor.viz.rerun import style

HOME = Path(__file__).parent.parent
MAP, FIRST_MAP = Path("recordings/furnished.yaml"), Path("recordings/flat.yaml")
SIZE = (800, 760)
"""Largest width and height of a picture of the site."""
OVERVIEW, OVERVIEW_SIZE = "recordings/overview.png", (1200, 760)
REFERENCES = "tests/viz/picture/references"
REFERENCE_SIZE = (560, 420)
GOLDEN = "default-home"
"""The recording whose pictures are compared in the tests."""
CLOSE_UP = 13
"""Cells across, of the picture of f and b."""


def drawn(name: str) -> bytes:
    """One picture of the site as a PNG; `PICTURES` has the names."""
    panel, window = PICTURES[name]()
    return picture_of(View("", "", [panel]), window, SIZE)


def kept() -> Iterator[tuple[str, bytes]]:
    """Path in the repository and PNG of each picture that is kept there."""
    yield OVERVIEW, next(pictures(run_of(FIRST_MAP, "default"), tabs=["Overview"], size=OVERVIEW_SIZE)).png
    run = History.read(read_recording(HOME / f"recordings/golden/{GOLDEN}.mcap", types=RECORDS))
    for picture in pictures(run, size=REFERENCE_SIZE):
        yield f"{REFERENCES}/{picture.number}_{picture.tab.lower().replace(' ', '_')}.png", picture.png


@functools.cache
def run_of(path: Path, preset: str) -> History:
    """An example map by a preset, as its recording has it."""
    with tempfile.TemporaryDirectory() as folder:
        blocks.ready(Path(folder))
        blocks.run(blocks.Step("sh", f"vdoor run {path} --preset {preset} --mcap run.mcap --quiet", 0, 0), Path(folder))
        return History.read(read_recording(Path(folder) / "run.mcap", types=RECORDS))


Drawn = tuple[Plan | Chart, Window]


def plan(make: Callable[[History], Iterator[Mark]], *, on_ground: bool = False) -> Drawn:
    """Marks of the example map, over the working grid or alone."""
    run = run_of(MAP, "default")
    below = boundary.ground(run) if on_ground else ()
    return Plan("", [*below, *make(run)]), window_of(run)


def window_of(run: History) -> Window:
    """The part of the map that is seen."""
    return Window.around(run.input.frame, run.input.free)


def _vectors() -> Drawn:
    """Close up, at a convex corner: the samples that f and b reach to, and the angle between."""
    run = run_of(MAP, "default")
    path, found = run.path, run.curvature
    reach = found.k_forward + found.k_backward
    corner = max(run.corners.sample[run.corners.convex].tolist(), key=lambda sample: (reach[sample], -sample))
    here = path.half[corner] / 2 - 0.5
    marks = [*boundary.ground(run), *boundary.boundary(run), _samples(path), *_arrows(run, corner, here)]
    angle = f"angle {np.degrees(found.angle_rad[corner]):.0f}°"
    dot = Dots(name="angle", frame=path.frame, cell=here[None], colour=style.CONVEX, meaning=angle, wide_px=14)
    seen = Window.around(run.input.frame, run.input.free)
    size_m = CLOSE_UP * run.input.frame.resolution_m
    x, y = seen.points(here[None], path.frame)[0]
    return Plan("", [*marks, dot]), Window(run.input.frame, x - size_m / 2, y - size_m / 2, size_m, size_m)


def _samples(path: BoundaryPath) -> Dots:
    cells = path.half / 2 - 0.5
    return Dots(name="samples", frame=path.frame, cell=cells, colour=style.BOUNDARY, meaning="sample", wide_px=16)


def _arrows(run: History, corner: int, here: Places) -> Iterator[Arrows]:
    found = run.curvature
    ahead, back = found.k_forward[corner], found.k_backward[corner]
    for name, vector, colour, meaning in (
        ("f", found.forward, style.FORWARD, f"f, to {ahead} samples ahead"),
        ("b", found.backward, style.BACKWARD, f"b, to {back} samples back"),
    ):
        by = vector[[corner]] / 2
        yield Arrows(
            name=name, frame=found.frame, cell=here[None], vector=by, colour=colour, meaning=meaning, wide_px=3
        )


def _curvature() -> Drawn:
    run = run_of(MAP, "default")
    return plots.angle_chart(run, run.pipeline.candidates.angle_deg), window_of(run)


def _search() -> Drawn:
    run = run_of(MAP, "paper")
    return plots.cost_chart(run), window_of(run)


def _final(run: History) -> Iterator[Mark]:
    yield from boundary.input_map(run)
    yield from maps.final_map(run)


def _route(run: History) -> Iterator[Mark]:
    """The route graph, as the export has it."""
    yield from boundary.input_map(run)
    features = json.loads(export.to_nav2_route(run.topology))["features"]
    at = {
        one["properties"]["id"]: one["geometry"]["coordinates"]
        for one in features
        if one["geometry"]["type"] == "Point"
    }
    edges = [one["properties"] for one in features if "startid" in one["properties"]]
    frame = run.input.frame
    ends = [frame.cell_from_world(np.array([at[one[end]] for one in edges])) for end in ("startid", "endid")]
    yield Lines(name="edges", frame=frame, strips=segments(*ends), colour=style.DOOR, meaning="edge", wide_px=3)
    rooms = {room.id for room in run.topology.rooms}
    for name, own, colour, wide_px in (("room", True, style.NODE, 14), ("door or place", False, style.EDGE_MIDDLE, 9)):
        cells = frame.cell_from_world(np.array([place for number, place in at.items() if (number in rooms) == own]))
        yield Dots(name=name, frame=frame, cell=cells, colour=colour, meaning=name, wide_px=wide_px)


def _keepout(run: History) -> Iterator[Mark]:
    mask = export.to_keepout(run.topology, rooms=[2])
    codes = np.where(run.input.cells >= OCCUPIED_FROM, 2, (mask.cells == 0) + 0).astype(np.uint8)
    colours = {1: (style.BETWEEN, "closed to the robot"), 0: (style.FREE, "room 2, open"), 2: (style.OCCUPIED, "walls")}
    yield Cells(name="mask", frame=run.input.frame, codes=codes, colours=colours)


PICTURES: dict[str, Callable[[], Drawn]] = {
    "input": lambda: plan(boundary.input_map),
    "simplified": lambda: plan(boundary.simplified),
    "path": lambda: plan(boundary.walk, on_ground=True),
    "vectors": _vectors,
    "curvature": _curvature,
    "candidates": lambda: plan(boundary.candidates, on_ground=True),
    "corners": lambda: plan(boundary.corners, on_ground=True),
    "doors": lambda: plan(doors.doors, on_ground=True),
    "scores": lambda: plan(doors.scores, on_ground=True),
    "initial_map": lambda: plan(maps.initial_map, on_ground=True),
    "search": _search,
    "map": lambda: plan(_final),
    "route": lambda: plan(_route),
    "keepout": lambda: plan(_keepout),
}
"""What draws each picture of the site, by its name in pages."""


def main(paths: Sequence[tuple[str, bytes]]) -> None:
    """Write the pictures that are kept in the repository, in place of those that are there."""
    for old in (HOME / REFERENCES).glob("*.png"):
        old.unlink()
    (HOME / REFERENCES).mkdir(parents=True, exist_ok=True)
    for path, png in paths:
        (HOME / path).write_bytes(png)
        print(path, len(png))  # noqa: T201  # a command


if __name__ == "__main__":
    main([*kept()])
