"""Golden recordings: small maps of known kinds, recorded once so that any change of a result is noticed."""

from __future__ import annotations

import tempfile
import textwrap
from collections.abc import Callable, Iterator
from operator import itemgetter
from pathlib import Path
from typing import NamedTuple

import numpy as np

from vdoor.api import run_info
from vdoor.config import replaced
from vdoor.emit import Recorder
from vdoor.errors import RecordingError, printable
from vdoor.files import make_folder, partial_name
from vdoor.formats import read_map, read_source
from vdoor.grid import OccupancyGrid, Source
from vdoor.pipeline import RECORDS, preset_named
from vdoor.recording.diff import compare, runs_that_differ
from vdoor.recording.diff_report import lines, setting_line
from vdoor.recording.mcap import McapSink, read_recording
from vdoor.synth import PRESETS, synthesize, write_synthetic

SEED = 0
NAMES = ("before", "now")
GREYS = {".": 254, "#": 0, "?": 205}
CELL_M = 0.2

ISLANDS = """
    ##########################
    #............#...........#
    #............#...........#
    #...##.......#....#......#
    #...##...................#
    #.........#..............#
    #............#......###..#
    #...#........#......###..#
    #............#...........#
    ##########################
"""
CROSSING = """
    ????#...#????
    ????#...#????
    ????#...#????
    #####...#####
    .............
    .............
    .............
    #####...#####
    ????#...#????
    ????#...#????
    ????#...#????
"""
ONE_ROOM = """
    ############
    #..........#
    #..........#
    #..........#
    #..........#
    #..........#
    #..........#
    ############
"""


def drawing(text: str) -> Callable[[], OccupancyGrid]:
    """A function that makes the map of a text drawing: ``.`` free, ``#`` occupied, ``?`` unknown."""

    def make() -> OccupancyGrid:
        rows = textwrap.dedent(text).split()
        pixels = bytes(GREYS[sign] for row in rows for sign in row)
        pgm = f"P5\n{len(rows[0])} {len(rows)}\n255\n".encode() + pixels
        return read_source(Source(files=(("map.pgm", pgm),), options={"resolution_m": CELL_M, "unknown_value": 205}))

    return make


def synthetic(seed: int, kind: str = "paper", **settings: float | bool) -> Callable[[], OccupancyGrid]:
    """A function that makes a synthetic map of a kind (by default `paper`, an apartment) with changed settings."""

    def make() -> OccupancyGrid:
        drawn = replaced(PRESETS[kind], settings, "golden map")
        with tempfile.TemporaryDirectory() as folder:
            write_synthetic(synthesize(drawn, np.random.default_rng(seed)), Path(folder) / "map", seed=seed)
            return read_map(Path(folder) / "map.yaml")

    return make


class Golden(NamedTuple):
    """A golden map: the function that makes it, and the preset it is recorded with."""

    make: Callable[[], OccupancyGrid]
    preset: str = "paper"


MAPS: dict[str, Golden] = {
    "plain": Golden(synthetic(1, speckles=0.0, juts_per_room=0.0, wall_noise=0.0, windows=0.0)),
    "furnished": Golden(synthetic(2, furniture=True)),
    "noisy": Golden(synthetic(3, speckles=60.0, juts_per_room=4.0, wall_noise=0.2, windows=4.0)),
    "rotated": Golden(synthetic(4, rotation_deg=30.0, cell_m=0.1)),
    "crossing": Golden(drawing(CROSSING)),
    "islands": Golden(drawing(ISLANDS)),
    "one-room": Golden(drawing(ONE_ROOM)),
    "default-home": Golden(synthetic(5, "home"), "default"),
    "default-turned": Golden(synthetic(4, rotation_deg=30.0, cell_m=0.1), "default"),
}
"""The golden recordings by name."""


def remade(folder: Path) -> Iterator[str]:
    """Lines of text on what differs from the old recordings, as all golden maps are recorded again in `folder`."""
    make_folder(folder)
    for name, (make, preset) in MAPS.items():
        path = folder / f"{name}.mcap"
        partial = record(make(), partial_name(path), preset)
        yield from _changes(name, path, partial)
        partial.replace(path)


def record(grid: OccupancyGrid, path: Path, preset: str) -> Path:
    """The recording of a run of a preset on a grid; removed again if the run fails."""
    pipeline = preset_named(preset)
    try:
        sink = McapSink(path, run_info(grid, preset, pipeline, SEED))
        pipeline(grid, np.random.default_rng(SEED), Recorder([sink]))
        sink.close()
    except BaseException:
        path.unlink(missing_ok=True)
        raise
    return path


def _changes(name: str, old: Path, new: Path) -> Iterator[str]:
    """Lines of text on what differs between the old recording and the new one."""
    size = f"{new.stat().st_size / 1000:.0f} kB"
    if not old.exists():
        yield f"{name}: new, {size}"
        return
    if old.read_bytes() == new.read_bytes():
        yield f"{name}: unchanged, {size}"
        return
    try:
        runs = [read_recording(path, types=RECORDS) for path in (old, new)]
        settings = runs_that_differ(runs[0].info, runs[1].info)
        report = compare(*(map(itemgetter(1), run) for run in runs), types=RECORDS)
    except RecordingError as error:
        yield printable(f"{name}: replaced, {size}; the old one cannot be compared: {error}")
        return
    found = [*(setting_line(setting, NAMES) for setting in settings), *lines(report, NAMES)]
    yield f"{name}: changed, {size}" if found else f"{name}: same records, different bytes, {size}"
    yield from (f"  {line}" for line in found)
