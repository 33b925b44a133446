"""The report: what its page holds."""

from __future__ import annotations

import base64
import html
import io
import json
import re
from pathlib import Path
from typing import Annotated, Any, ClassVar

import finished_maps
import numpy as np
import pytest
import small_recording
from numpy.typing import NDArray
from PIL import Image
from report_pages import STAGES, driven, provenance_of, told
from shapely import Polygon

from vdoor.api import prepared, run_info, run_prepared
from vdoor.errors import RecordingError, VdoorError
from vdoor.export import Export, read_finished, to_report
from vdoor.frame import Frame
from vdoor.goldens import drawing
from vdoor.grid import FREE, OccupancyGrid
from vdoor.history.provenance import Provenance
from vdoor.method.search.generation import Generation
from vdoor.method.simplify import SimplifiedGrid
from vdoor.pipeline import PRESETS
from vdoor.record import Record, Spec


def small_provenance() -> tuple[Provenance, Any]:
    """A whole small run, and the map it ends with."""
    info, records = small_recording.small_run()
    provenance = Provenance.of(info)
    for step, record in enumerate(records):
        provenance.run.write(step, record)
    return provenance, records[-1]


def scored_run() -> tuple[Provenance, Any]:
    """A run on two rooms that scores its doors."""
    grid = drawing(small_recording.MAP)()
    pipeline = prepared(PRESETS["default"], grid).pipeline
    provenance = Provenance.of(run_info(grid, "default", pipeline, 0))
    return provenance, run_prepared(grid, pipeline, emit=provenance.run)


def rings(path: str) -> list[NDArray[np.float64]]:
    """Points (k, 2) of the rings of a path."""
    return [
        np.array([point.split() for point in ring.removesuffix("Z").split("L")], float) for ring in path.split("M")[1:]
    ]


def picture(layer: Any) -> NDArray[np.uint8]:
    """Colours (h, w, 4) of a layer's picture."""
    head, _, data = layer["picture"]["href"].partition(",")
    assert head == "data:image/png;base64"
    return np.asarray(Image.open(io.BytesIO(base64.b64decode(data))).convert("RGBA"))


@pytest.mark.parametrize("name", finished_maps.NAMES)
def test_rooms_and_doors_are_those_of_the_map(name: str) -> None:
    topology = finished_maps.topology(name)
    page = told(to_report(topology))
    assert [room["id"] for room in page["rooms"]] == [room.id for room in topology.rooms]
    for room, line in zip(topology.rooms, page["rooms"], strict=True):
        outer, *holes = rings(line["d"])
        assert Polygon(outer, holes).area == pytest.approx(np.count_nonzero(topology.labels == room.id), rel=1e-4)
        col, row = (int(value) for value in line["at"])
        assert topology.labels[row, col] == room.id
    for door, line in zip(topology.doors, page["doors"], strict=True):
        assert (line["id"], tuple(line["rooms"]), line["kind"]) == (door.id, door.rooms, door.kind)
        length_m = np.hypot(*np.ptp(rings(line["d"])[0], axis=0)) * topology.frame.resolution_m
        assert length_m == pytest.approx(door.length_m, abs=1e-3)
    x_m, y_m, *axes = page["world_m"]
    col, row = page["rooms"][0]["at"]
    place_m = np.array([x_m, y_m]) + np.array(axes).reshape(2, 2).T @ (col, row)
    assert place_m == pytest.approx(topology.rooms[0].centre_m, abs=1e-3)


def test_every_stage_has_a_layer() -> None:
    provenance, topology = small_provenance()
    page = told(to_report(topology, provenance))
    assert [layer["id"] for layer in page["layers"]] == STAGES.split()[:-1]  # nothing is left out
    assert page["curve"]["number"] == [0, 1, 2, 3]
    assert page["curve"]["best"] == [round(provenance.run.search[number].best_cost, 6) for number in range(4)]
    assert {(stage, name): value for stage, name, value in page["settings"]}["search", "generations"] == "3"
    assert ["generation", "number", "3"] in page["numbers"]


def test_pictures_lie_on_the_cells_they_show() -> None:
    grid = finished_maps.grid("slit")
    provenance = provenance_of("slit")
    provenance.run.write(0, grid)
    coarse = OccupancyGrid.from_array(grid.cells[::2, ::2], 2 * grid.frame.resolution_m)
    reason = np.zeros(coarse.cells.shape, np.uint8)
    reason[3, 5] = 1
    provenance.run.write(1, SimplifiedGrid(cells=coarse.cells, reason=reason, factor=2, frame=coarse.frame))
    page = told(to_report(finished_maps.topology("slit"), provenance))
    layers = {layer["id"]: layer for layer in page["layers"]}
    height, width = grid.cells.shape
    whole = {"x": 0.0, "y": 0.0, "width": width, "height": height}
    for name, of in (("input", grid), ("simplified", coarse)):
        assert whole.items() <= layers[name]["picture"].items()
        light = picture(layers[name])[:, :, 0] > 200
        assert np.array_equal(light, of.free)
    assert np.argwhere(picture(layers["changed"])[:, :, 3]).tolist() == [[3, 5]]
    assert layers["changed"]["key"] == [["#c480c8", "unreachable, now unknown (1)"]]


def test_flips_lead_to_the_choice_of_every_generation() -> None:
    provenance, topology = small_provenance()
    curve = told(to_report(topology, provenance))["curve"]
    removed: set[int] = set()
    for number, flips in enumerate(curve["flips"]):
        removed ^= set(flips)
        assert removed == set(np.flatnonzero(provenance.run.search[number].removed).tolist())


def test_a_long_search_is_thinned_out_but_for_what_it_found() -> None:
    provenance, topology = small_provenance()
    last = provenance.run.search[-1]
    better = {1, 7, 1234, 4321}
    cost = 9.0
    for number in range(4, 5000):
        cost -= number in better
        fields = {**vars(last), "number": number, "best_cost": cost, "worst_cost": float("inf")}
        provenance.run.write(number, Generation(**fields))
    curve = told(to_report(topology, provenance))["curve"]
    assert 1000 <= len(curve["number"]) <= 1010
    assert {7, 1234, 4321, 0, 4999} <= set(curve["number"])
    assert curve["worst"][-1] is None


class Strange(Record):
    """A record that nobody has drawn for."""

    topic: ClassVar[str] = "strange_record"

    heat: Annotated[NDArray[np.int32], Spec("labels", "height width")]
    place: Annotated[NDArray[np.int32], Spec("cell", "spot 2")]
    kind: Annotated[NDArray[np.uint8], Spec("code", "spot", words=("<b>warm</b>", "cold"))]
    size: Annotated[NDArray[np.float64], Spec("column", "spot", unit="m")]
    many: Annotated[NDArray[np.float64], Spec("column", "spot 3")]
    share: Annotated[float, Spec("number", unit="%")]
    frame: Frame


class Bare(Record):
    """A record without a frame."""

    topic: ClassVar[str] = "bare"

    gap: Annotated[float, Spec("number")]


def test_records_nobody_has_drawn_for_are_drawn_by_their_specs() -> None:
    provenance, topology = small_provenance()
    frame = topology.frame
    heat = np.zeros((frame.height, frame.width), np.int32)
    heat[2, 3] = 700
    place = np.array([[2, 3], [4, 5]], np.int32)
    kind, size, many = np.array([0, 1], np.uint8), np.array([0.5, np.nan]), np.zeros((2, 3))
    strange = Strange(heat=heat, place=place, kind=kind, size=size, many=many, share=12.5, frame=frame)
    provenance.run.write(98, strange)
    provenance.run.write(99, Bare(gap=float("inf")))
    page = told(to_report(topology, provenance))
    layers = {layer["id"]: layer for layer in page["layers"]}
    assert np.argwhere(picture(layers["strange_record-heat"])[:, :, 3]).tolist() == [[2, 3]]
    spots = layers["strange_record-spot"]["shapes"]
    assert [spot["tip"] for spot in spots] == [
        "spot 0: kind <b>warm</b>, size 0.5 m",
        "spot 1: kind cold, size nan m",
    ]
    assert [spot["d"] for spot in spots] == ["M3.5 2.5h0", "M5.5 4.5h0"]
    assert ["strange_record", "share", "12.5 %"] in page["numbers"]
    assert ["bare", "gap", "inf"] in page["numbers"]


def test_records_that_do_not_fit_together_are_refused() -> None:
    provenance, topology = small_provenance()
    with pytest.raises(RecordingError, match="second"):
        provenance.run.write(99, next(iter(provenance.records)))
    wide, _ = small_provenance()
    wide.run.search.__init__()  # type: ignore[misc]  # a search over another number of doors
    wide.run.write(99, Generation(**{**vars(provenance.run.search[0]), "removed": np.zeros(77, np.bool_)}))
    with pytest.raises(RecordingError, match="found 77"):
        to_report(topology, wide)


def test_result_folder_tells_of_map_rooms_doors_and_settings(tmp_path: Path) -> None:
    folder = finished_maps.result("pillars", tmp_path / "result")
    page = to_report(finished_maps.topology("pillars"), read_finished(folder, provenance=True).provenance)
    assert [layer["id"] for layer in told(page)["layers"]] == ["input"]
    assert np.array_equal(picture(told(page)["layers"][0])[:, :, 0] > 200, finished_maps.grid("pillars").free)
    assert told(page)["curve"] is None
    assert ["preset", "paper"] in told(page)["facts"]


@pytest.mark.parametrize(
    ("key", "value"),
    [("settings", 5), ("source", {}), ("source", {"files": [5]}), ("settings", None), ("seed", ...), ("vdoor", ...)],
)
def test_a_spoilt_map_json_is_refused_by_its_folder(key: str, value: object, tmp_path: Path) -> None:
    folder = finished_maps.result("one room", tmp_path / "result")
    document = json.loads((folder / "map.json").read_text())
    document[key] = value
    if value is ...:
        del document[key]
    (folder / "map.json").write_text(json.dumps(document))
    with pytest.raises(VdoorError, match=f"{folder}$"):
        read_finished(folder, provenance=True)


def test_a_map_of_another_size_is_refused(tmp_path: Path) -> None:
    folder = finished_maps.result("one room", tmp_path / "result")
    Image.fromarray(np.zeros((3, 4), np.uint8)).save(folder / "grid.png")
    with pytest.raises(VdoorError, match=f"found another: {folder}$"):
        read_finished(folder, provenance=True)
    document = json.loads((folder / "map.json").read_text())
    del document["files"]  # as written by a version without checksums
    (folder / "map.json").write_text(json.dumps(document))
    with pytest.raises(VdoorError, match=f"found 4 x 3: {folder}$"):
        read_finished(folder, provenance=True)
    (folder / "grid.png").unlink()
    with pytest.raises(VdoorError, match=r"grid\.png"):
        read_finished(folder, provenance=True)


@pytest.mark.parametrize("value", [float("nan"), "\ud800", "\x1b[2J", {"deep": [{}]}, "</script>"])
def test_any_setting_can_be_told(value: object, tmp_path: Path) -> None:
    folder = finished_maps.result("one room", tmp_path / "result")
    document = json.loads((folder / "map.json").read_text())
    document |= {"settings": {"a": {"b": value}, "c": value}, "preset": value}
    document["source"]["files"] = [{"name": value, "sha256": "0"}]
    (folder / "map.json").write_text(json.dumps(document))
    out = tmp_path / "page.html"
    for path in Export.parse(f"report={out}").write(read_finished(folder, provenance=True)):
        page = path.read_text()
    assert len(told(page)["settings"]) == 2
    assert "\x1b" not in page


def test_doors_tell_their_score_and_their_life() -> None:
    provenance, topology = scored_run()
    page = told(to_report(topology, provenance))
    kept = {door["candidate"] for door in page["doors"]}
    run = provenance.run
    assert kept == set(run.initial.door[topology.edge[topology.edge >= 0]].tolist())
    for door in page["doors"]:
        score, *reasons = door["why"]
        row = run.scores.door.tolist().index(door["candidate"])
        assert score.startswith(f"score {run.scores.log_odds[row]:+.1f}: ")
        assert [line.partition(":")[0] for line in reasons] == ["for", "against"]
        life = page["lives"][str(door["candidate"])]
        assert life[2:3] == ["proposed"]
        one, other = door["rooms"]
        assert life[-1] == f"final map: door {door['id']} between rooms {one} and {other}"
    assert len(page["lives"]) == len(run.doors.verdict)
    rejected = [shape for layer in page["layers"] if layer["id"] == "rejected" for shape in layer["shapes"]]
    assert all(page["lives"][str(shape["door"])][-1].startswith("rejected, ") for shape in rejected)


def test_what_was_left_out_is_listed_with_the_reason() -> None:
    grid = finished_maps.grid("slit")
    cells = grid.cells.copy()
    cells[-2:] = cells[:2] = FREE  # ground outside, seen over the walls; there is no door to it
    outside = OccupancyGrid.from_array(cells, grid.frame.resolution_m)
    for preset, why in (("paper", "the robot cannot get there"), ("default", "and it is too narrow")):
        provenance = provenance_of("slit")
        pipeline = prepared(PRESETS[preset], outside).pipeline
        provenance = Provenance.of(run_info(outside, preset, pipeline, 0))
        topology = run_prepared(outside, pipeline, emit=provenance.run)
        page = told(to_report(topology, provenance))
        assert [place["area_m2"] for place in page["left_out"]] == [2 * cells.shape[1] * grid.frame.resolution_m**2] * 2
        assert all(why in place["why"] for place in page["left_out"])
        lost = next(layer for layer in page["layers"] if layer["id"] == "left-out")
        assert np.array_equal(picture(lost)[:, :, 3] > 0, outside.free & (topology.labels == 0))


def test_drives_follow_the_recorded_paths() -> None:
    provenance, topology = driven()
    page = told(to_report(topology, provenance))
    route, coverage = page["drives"]
    for drive, record in ((route, provenance.run.records["route"]), (coverage, provenance.run.records["coverage"])):
        apart = np.hypot(*np.diff(drive["points"], axis=0).T) * topology.frame.resolution_m
        assert np.cumsum(apart) == pytest.approx(record.along_m[1:], abs=0.01)
    assert (route["unit"], coverage["unit"]) == ("m", "s")
    assert coverage["at"] == pytest.approx(provenance.run.records["coverage"].at_s, abs=1e-3)
    assert (coverage["swept"][-1], coverage["rooms"][-1], coverage["tool_m"]) == (1.0, 1, 0.3)
    assert np.all(np.diff(coverage["swept"]) >= 0)


def test_page_names_nothing_outside_itself() -> None:
    provenance, topology = small_provenance()
    page = to_report(topology, provenance)
    assert not re.search(r"""(src|href|action|url|@import)\s*[=(]\s*["']?(?!data:|told|each)[\w./]""", page)
    assert set(re.findall(r"https?://[^\s\"']*", page)) == {"http://www.w3.org/2000/svg"}
    assert "default-src &#x27;none&#x27;" in html.escape(page)
