"""The Rerun recording, read back with Rerun's own programs and seen through its headless viewer."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Annotated, ClassVar
from urllib.parse import urlsplit

import numpy as np
import pytest
from numpy.typing import NDArray
from project import FLAT
from rerun.chunk import RrdReader

import vdoor
from vdoor.emit import Recorder, RunInfo
from vdoor.pipeline import RECORDS
from vdoor.record import Record, Spec, equal
from vdoor.recording.mcap import McapSink
from vdoor.topology import TopologicalMap
from vdoor.viz.marks.boundary import OCCUPIED
from vdoor.viz.marks.table import MARKS
from vdoor.viz.rerun.draw import BESIDE, ENTITIES
from vdoor.viz.rerun.program import HOST, listening
from vdoor.viz.rerun.shot import NO_RENDERER, headless, shots_in, steady
from vdoor.viz.rerun.sink import RerunSink

RERUN = Path(sys.executable).parent / "rerun"

TABS = ("Overview", "Simplified", "Path", "Curvature", "Corners", "Doors", "Initial map", "Search", "Rooms")


def info(grid: vdoor.OccupancyGrid) -> RunInfo:
    return RunInfo(version="test", preset="paper", seed=0, settings={}, source=grid.source)


def rerun(*words: str | Path) -> subprocess.CompletedProcess[str]:
    env = os.environ | {"CI": "1"}
    return subprocess.run([RERUN, *map(str, words)], capture_output=True, text=True, timeout=120, check=False, env=env)


def record_flat(folder: Path) -> tuple[list[Record], TopologicalMap]:
    grid = vdoor.read_map(FLAT)
    records: list[Record] = []

    class Keep:
        def write(self, _: int, record: Record) -> None:
            records.append(record)

        def close(self) -> None:
            pass

    sinks = [RerunSink.to_file(folder / "flat.rrd", info(grid)), McapSink(folder / "flat.mcap", info(grid)), Keep()]
    topology = vdoor.run(grid, "paper", emit=Recorder(sinks))
    for sink in sinks:
        sink.close()
    return records, topology


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[Record], TopologicalMap]:
    folder = tmp_path_factory.mktemp("rerun")
    return folder, *record_flat(folder)


def rows(path: Path, entity: str) -> int:
    return sum(chunk.to_record_batch().num_rows for chunk in RrdReader(path).stream().filter(content=entity))


def test_file_is_whole(made: tuple[Path, list[Record], TopologicalMap]) -> None:
    done = rerun("rrd", "verify", made[0] / "flat.rrd")
    assert done.returncode == 0, done.stderr


def test_two_runs_are_equal_and_so_is_a_run_without_listeners(
    made: tuple[Path, list[Record], TopologicalMap], tmp_path: Path
) -> None:
    folder, records, topology = made
    again, _ = record_flat(tmp_path)
    assert all(equal(one, other) for one, other in zip(records, again, strict=True))
    done = rerun("rrd", "compare", "--unordered", folder / "flat.rrd", tmp_path / "flat.rrd")
    assert done.returncode == 0, done.stdout + done.stderr
    assert equal(topology, vdoor.run(vdoor.read_map(FLAT), "paper"))


def test_another_seed_is_told_apart(made: tuple[Path, list[Record], TopologicalMap], tmp_path: Path) -> None:
    grid = vdoor.read_map(FLAT)
    sink = RerunSink.to_file(tmp_path / "other.rrd", info(grid))
    vdoor.run(grid, "paper", seed=1, emit=Recorder([sink]))
    sink.close()
    assert rerun("rrd", "compare", "--unordered", made[0] / "flat.rrd", tmp_path / "other.rrd").returncode != 0


def test_every_stage_has_its_rows(made: tuple[Path, list[Record], TopologicalMap]) -> None:
    folder, records, _ = made
    by_topic = {record.topic: record for record in records}
    generations = sum(record.topic == "generation" for record in records)
    samples = len(by_topic["path"].cell)  # type: ignore[attr-defined]  # a BoundaryPath
    expected = {
        "/state/stage": len(records),
        "/map/walker": samples + 1,
        "/map/vectors": samples + 1,
        "/charts/curvature/walker": samples + 1,
        "/charts/cost/curves/best": sum(count & (count - 1) == 0 for count in range(1, generations + 1)) + 1,
        **{f"/says/{tab.lower().replace(' ', '_')}": 1 for tab in TABS},
        "/tables/corners": len(by_topic["corners"].cell),  # type: ignore[attr-defined]  # Corners
        "/tables/doors": len(by_topic["doors"].start),  # type: ignore[attr-defined]  # VirtualDoors
        "/plots/search/best": generations + 1,
        "/map/search/kept": generations,
        "/rooms/doors": 1,
        "/graph/final": 1,
        "/description": 1,
    }
    assert {entity: rows(folder / "flat.rrd", entity) for entity in expected} == expected


def test_rows_carry_the_global_step(made: tuple[Path, list[Record], TopologicalMap]) -> None:
    folder, records, _ = made
    chunks = RrdReader(folder / "flat.rrd").stream().filter(content="/plots/search/best")
    steps = [step for chunk in chunks for step in chunk_steps(chunk)]
    assert sorted(steps) == [step for step, record in enumerate(records) if record.topic == "generation"]


def chunk_steps(chunk: object) -> list[int]:
    batch = chunk.to_record_batch()  # type: ignore[attr-defined]  # a chunk of the reader
    return batch.column("step").to_pylist() if "step" in batch.schema.names else []


def test_the_viewer_opens_with_the_result_shows_every_tab_without_an_error_and_goes(
    made: tuple[Path, list[Record], TopologicalMap],
) -> None:
    """The one test that starts a viewer: it takes as long as all others here."""
    folder, records, _ = made
    try:
        with headless(folder / "flat.rrd", (320, 240)) as client:
            port = urlsplit(client.url).port
            steady(client)
            step = client.get_state().recordings[0].current_time
            pictures = list(shots_in(client))
    except vdoor.VdoorError as error:
        if str(error) != NO_RENDERER:
            raise
        pytest.skip(NO_RENDERER)
    assert step == len(records) - 1
    assert {picture.tab: picture.problems for picture in pictures} == dict.fromkeys(TABS, ())
    assert len({picture.png for picture in pictures}) == len(TABS)
    until = time.monotonic() + 10
    while port and listening(HOST, port) and time.monotonic() < until:
        time.sleep(0.05)  # it takes a moment to go
    assert port
    assert not listening(HOST, port)


def test_rerun_reads_grid_points_and_scalars_from_the_mcap(
    made: tuple[Path, list[Record], TopologicalMap], tmp_path: Path
) -> None:
    done = rerun("mcap", "convert", made[0] / "flat.mcap", "-o", tmp_path / "converted.rrd")
    assert done.returncode == 0, done.stderr
    columns: dict[str, set[str]] = {}
    for chunk in RrdReader(tmp_path / "converted.rrd").stream():
        columns.setdefault(str(chunk.entity_path), set()).update(chunk.to_record_batch().schema.names)
    assert any("GridMap" in name for name in columns["/vdoor/simplified/cells"])
    assert any("Points3D" in name for name in columns["/vdoor/corners/corner"])
    assert any("Scalars" in name for name in columns["/vdoor/generation/values"])


def test_a_record_nobody_has_drawn_for_is_still_shown(tmp_path: Path) -> None:
    class Heat(Record):
        topic: ClassVar[str] = "heat"

        warmth: Annotated[NDArray[np.int32], Spec("labels", "height width")]
        degrees: Annotated[NDArray[np.float64], Spec("column", "spot")]

    path = tmp_path / "heat.rrd"
    sink = RerunSink.to_file(path, info(vdoor.read_map(FLAT)))
    sink.write(0, Heat(warmth=np.eye(4, dtype=np.int32), degrees=np.array([1.0, 2.0])))
    sink.close()
    assert rows(path, "/other/heat/warmth") == 1 + 1  # the cells, and their colours
    assert rows(path, "/tables/heat") == 2


def test_switched_off_rerun_is_an_error_and_no_empty_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RERUN", "off")
    with pytest.raises(vdoor.VdoorError, match="RERUN=off"):
        RerunSink.to_file(tmp_path / "x.rrd", info(vdoor.read_map(FLAT)))
    assert not list(tmp_path.iterdir())


def test_connecting_to_nobody_is_an_error() -> None:
    with pytest.raises(vdoor.VdoorError, match="found none"):
        RerunSink.connect("127.0.0.1:1", info(vdoor.read_map(FLAT)))


def test_records_all_have_a_picture() -> None:
    assert set(ENTITIES) == set(MARKS)
    assert set(ENTITIES) | set(BESIDE) == set(RECORDS)


def test_a_raster_too_large_for_a_texture_keeps_its_walls_and_its_place(tmp_path: Path) -> None:
    cells = np.zeros((3, 20_000), np.int8)
    cells[1, 7_001] = 100
    grid = vdoor.OccupancyGrid.from_array(cells, 0.05)
    sink = RerunSink.to_file(tmp_path / "wide.rrd", info(grid))
    sink.write(0, grid)
    sink.close()
    rows = [
        row
        for chunk in RrdReader(tmp_path / "wide.rrd").stream().filter(content="/input/map")
        for row in chunk.to_record_batch().to_pylist()
    ]
    (pixels,) = (row["SegmentationImage:buffer"] for row in rows if row.get("SegmentationImage:buffer"))
    picture = np.asarray(pixels[0], np.uint8).reshape(2, 10_000)
    assert np.argwhere(picture == OCCUPIED).tolist() == [[0, 3_500]]
    (scale,) = (row["Transform3D:scale"] for row in rows if row.get("Transform3D:scale"))
    assert list(scale[0]) == [2, 2, 1]


def test_a_file_holds_nothing_of_the_clock(made: tuple[Path, list[Record], TopologicalMap]) -> None:
    chunks = RrdReader(made[0] / "flat.rrd").stream()
    names = {name for chunk in chunks for name in chunk.to_record_batch().schema.names}
    assert {"step", "stage", "sample", "corner", "generation"} <= names
    assert not {"log_time", "log_tick"} & names


def test_a_full_disk_is_an_error_that_names_the_file() -> None:
    full = Path("/dev/full")
    if not full.exists():
        pytest.skip("there is no /dev/full here")
    with pytest.raises(vdoor.VdoorError, match=r"No space left on device.*: /dev/full"):
        RerunSink.to_file(full, info(vdoor.read_map(FLAT)))
