"""The report: what its page holds, and how it behaves in a real browser."""

from __future__ import annotations

import base64
import html
import io
import json
import re
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, ClassVar

import finished_maps
import numpy as np
import pytest
import small_recording
from browser import Browser, browser
from numpy.typing import NDArray
from PIL import Image
from project import HOME, VDOOR
from shapely import Polygon

import vdoor
from vdoor.emit import RunInfo
from vdoor.errors import RecordingError, VdoorError
from vdoor.export import Export, read_finished, to_report
from vdoor.frame import Frame
from vdoor.grid import OccupancyGrid, Source
from vdoor.history.provenance import Provenance
from vdoor.method.search.generation import Generation
from vdoor.method.simplify import SimplifiedGrid
from vdoor.record import Record, Spec

HOSTILE = "</script><script>document.title='caught'</script><img src=x onerror=alert(1)>&amp;\u202e'\"`${1}.pgm"
STAGES = "input simplified changed path curvature candidates corners doors rejected initial_map search left-out"


def told(page: str) -> Any:
    """What a page holds."""
    (text,) = re.findall(r'<script type="application/json" id="data">(.*?)</script>', page, re.DOTALL)
    return json.loads(text)


def provenance_of(name: str, **about: Any) -> Provenance:
    """An example's run as it is known before any record."""
    info = RunInfo(version="0.1.0", preset="paper", seed=0, settings={}, source=finished_maps.grid(name).source)
    return Provenance.of(RunInfo(**{**vars(info), **about}))


def small_provenance() -> tuple[Provenance, Any]:
    """A whole small run, and the map it ends with."""
    info, records = small_recording.small_run()
    provenance = Provenance.of(info)
    for step, record in enumerate(records):
        provenance.run.write(step, record)
    return provenance, records[-1]


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
        assert Polygon(outer, holes).area == pytest.approx(np.count_nonzero(topology.labels == room.id))
        col, row = (int(value) for value in line["at"])
        assert topology.labels[row, col] == room.id
    for door, line in zip(topology.doors, page["doors"], strict=True):
        assert (line["id"], tuple(line["rooms"]), line["kind"]) == (door.id, door.rooms, door.kind)
        length_m = np.hypot(*np.ptp(rings(line["d"])[0], axis=0)) * topology.frame.resolution_m
        assert length_m == pytest.approx(door.length_m, abs=1e-3)
    x_m, y_m, *axes = page["world_m"]
    col, row = page["rooms"][0]["at"]
    place_m = np.array([x_m, y_m]) + np.array(axes).reshape(2, 2).T @ (col, row)
    assert place_m == pytest.approx(topology.rooms[0].centre_m)


def test_every_stage_has_a_layer() -> None:
    provenance, topology = small_provenance()
    page = told(to_report(topology, provenance))
    assert [layer["id"] for layer in page["layers"]] == STAGES.split()[:-1]  # nothing is left out
    assert page["curve"]["number"] == [0, 1, 2, 3]
    assert page["curve"]["best"] == [provenance.run.search[number].best_cost for number in range(4)]
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
    assert layers["changed"]["key"] == [["#c480c8", "unreachable (1)"]]


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


def test_page_names_nothing_outside_itself() -> None:
    provenance, topology = small_provenance()
    page = to_report(topology, provenance)
    assert not re.search(r"""(src|href|action|url|@import)\s*[=(]\s*["']?(?!data:|told|each)[\w./]""", page)
    assert set(re.findall(r"https?://[^\s\"']*", page)) == {"http://www.w3.org/2000/svg"}
    assert "default-src &#x27;none&#x27;" in html.escape(page)


# In a browser


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("report") / "flat.html"
    words = [VDOOR, "run", HOME / "recordings" / "flat.yaml", "--preset", "paper", "--export", f"report={path}"]
    subprocess.run(words, check=True, capture_output=True, timeout=120)
    return path


@pytest.fixture(scope="module")
def window(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    with browser(tmp_path_factory.mktemp("profile")) as started:
        yield started


@pytest.fixture
def opened(page: Path, window: Browser) -> Iterator[Browser]:
    """The report of the example map; it must not complain or ask for anything by the end of the test."""
    window.requests.clear()
    window.problems.clear()
    window.open(page)
    yield window
    assert not window.problems
    assert {address for address in window.requests if not address.startswith("data:")} == {page.absolute().as_uri()}


def view(window: Browser) -> list[float]:
    text: str = window.run("document.getElementById('drawing').getAttribute('viewBox')")
    return [float(value) for value in text.split()]


def test_tables_and_drawing_show_all_rooms_and_doors(opened: Browser) -> None:
    topology = finished_maps.topology("flat")
    rows = (
        "[...document.querySelectorAll('#{}-table tbody tr')].map(row => [...row.cells].map(cell => cell.textContent))"
    )
    rooms, doors = opened.run(rows.format("room")), opened.run(rows.format("door"))
    assert [row[:2] for row in rooms] == [[str(room.id), f"{room.area_m2:.2f}"] for room in topology.rooms]
    assert [row[:3] for row in doors] == [
        [str(door.id), "{} and {}".format(*door.rooms), f"{door.width_m:.2f}"] for door in topology.doors
    ]
    assert opened.run("document.querySelectorAll('#rooms path').length") == len(topology.rooms)
    assert opened.run("document.querySelectorAll('#doors .line').length") == len(topology.doors)
    shown = "[...document.querySelectorAll('#names text')].filter(text => text.style.display === '').length"
    assert opened.run(shown) >= len(topology.rooms)
    assert opened.run("document.title").startswith("flat.yaml")


def test_pointer_over_a_room_or_door_tells_its_size(opened: Browser) -> None:
    topology = finished_maps.topology("flat")
    tip = "document.getElementById('tip').hidden ? '' : document.getElementById('tip').textContent"
    assert opened.run(tip) == ""
    x, y = opened.place("#room-4")
    opened.mouse("Moved", x, y + 30)
    area_m2 = topology.rooms[3].area_m2
    assert opened.run(tip).startswith(f"Room 4: {area_m2:.1f} m²")
    assert opened.run("document.querySelector('#room-table .hot th').textContent") == "4"
    place = opened.run("document.getElementById('where').textContent")
    x_m, y_m = (float(value) for value in re.findall(r"[xy] (-?[\d.]+) m", place))
    row, col = np.floor(topology.frame.cell_from_world(np.array([[x_m, y_m]]))[0] + 0.5).astype(int)
    assert topology.labels[row, col] == 4
    for door in topology.doors:
        opened.mouse("Moved", *opened.place(f"#door-{door.id} .line"))
        assert opened.run(tip).startswith(f"Door {door.id}: {door.width_m:.2f} m wide")
    opened.mouse("Moved", 3, 3)
    assert opened.run(tip) == ""


def test_wheel_keys_and_buttons_zoom_and_the_pointer_drags(opened: Browser) -> None:
    whole = view(opened)
    x, y = opened.place("#room-3")
    opened.mouse("Wheel", x, y, deltaX=0, deltaY=-300)
    nearer = view(opened)
    assert nearer[2] < whole[2]
    # What was under the pointer stays there.
    assert opened.place("#room-3") == pytest.approx((x, y), abs=1.5)
    opened.mouse("Pressed", x, y, button="left", clickCount=1)
    opened.mouse("Moved", x + 40, y - 25, button="left", buttons=1)
    opened.mouse("Released", x + 40, y - 25, button="left", clickCount=1)
    assert opened.place("#room-3") == pytest.approx((x + 40, y - 25), abs=1.5)
    opened.run("document.getElementById('frame').focus()")
    opened.key("0")
    assert view(opened) == whole
    opened.key("+")
    assert view(opened)[2] == pytest.approx(whole[2] / 1.5)
    opened.key("ArrowRight")
    assert view(opened)[0] > whole[0]
    opened.run("document.getElementById('whole').click()")
    assert view(opened) == whole
    opened.run("for (let i = 0; i < 60; i++) zoom(1 / 1.5)")
    assert max(view(opened)[2:]) == pytest.approx(4)
    opened.run("for (let i = 0; i < 60; i++) zoom(1.5)")
    assert max(view(opened)[2:]) == pytest.approx(2 * max(whole[2:]))


def test_button_of_a_row_shows_its_room_on_the_map(opened: Browser) -> None:
    opened.run("document.querySelector('#room-table tbody tr:nth-child(5) button').click()")
    opened.settle()
    left, top, width, height = view(opened)
    box = opened.run("(box => [box.x, box.y, box.width, box.height])(document.getElementById('room-5').getBBox())")
    assert left < box[0]
    assert top < box[1]
    assert box[0] + box[2] < left + width
    assert box[1] + box[3] < top + height
    assert opened.run("document.getElementById('room-5').classList.contains('hot')")


def test_switch_of_each_layer_shows_and_hides_it(opened: Browser) -> None:
    names = opened.run("[...document.querySelectorAll('#layers input')].map(box => box.dataset.layer)")
    assert names == [*STAGES.split(), "rooms", "final-doors", "names"]
    on = opened.run("[...document.querySelectorAll('#layers input:checked')].map(box => box.dataset.layer)")
    assert on == ["input", "rooms", "final-doors", "names"]
    for name in names:
        opened.run("document.querySelectorAll('#layers input:checked').forEach(box => box.click())")
        opened.settle()
        bare = opened.picture("#frame")
        opened.run(f"document.querySelector('#layers [data-layer={name}]').click()")
        opened.settle()
        assert opened.picture("#frame") != bare, name


def test_slider_shows_what_each_generation_kept(page: Path, opened: Browser) -> None:
    curve = told(page.read_text())["curve"]
    colours = told(page.read_text())["colours"]
    strokes = (
        "[...document.querySelectorAll('#shapes [data-layer=search] .line')].map(line => line.getAttribute('stroke'))"
    )
    removed: set[int] = set()
    for row, flips in enumerate(curve["flips"]):
        removed ^= set(flips)
        if row % 10 == 0:
            slide = f"generation.value = {row}; generation.dispatchEvent(new Event('input'))"
            opened.run(f"(generation => {{ {slide} }})(document.getElementById('generation'))")
            assert opened.run(strokes) == [colours[edge in removed] for edge in range(curve["edges"])]
            assert f"{curve['edges'] - len(removed)} of" in opened.run("document.getElementById('chosen').textContent")


def test_everything_to_press_has_a_name(opened: Browser) -> None:
    nodes = opened.call("Accessibility.getFullAXTree")["nodes"]
    pressed = [node for node in nodes if node["role"]["value"] in ("button", "checkbox", "slider", "table", "image")]
    assert {"button", "checkbox", "slider", "table"} <= {node["role"]["value"] for node in pressed}
    assert [node for node in pressed if not node["name"]["value"].strip()] == []
    assert {"Show room 1 on the map", "Zoom in"} <= {node["name"]["value"] for node in pressed}
    assert opened.run("document.documentElement.lang") == "en"


@pytest.mark.parametrize("width", [360, 800, 1900])
def test_page_fits_narrow_and_wide_windows(width: int, opened: Browser) -> None:
    opened.call("Emulation.setDeviceMetricsOverride", width=width, height=800, deviceScaleFactor=1, mobile=False)
    opened.settle()
    assert opened.run("document.documentElement.scrollWidth") <= width
    frame = opened.run("document.getElementById('frame').getBoundingClientRect().width")
    assert frame >= 0.55 * width
    opened.call("Emulation.clearDeviceMetricsOverride")


def test_hostile_names_stay_text(window: Browser, tmp_path: Path) -> None:
    source = Source(((HOSTILE, b""),), {})
    provenance = provenance_of("flat", preset=HOSTILE, settings={HOSTILE: {HOSTILE: HOSTILE}}, source=source)
    provenance.run.write(0, finished_maps.grid("flat"))
    topology, name = finished_maps.topology("flat"), HOSTILE.replace("\u202e", "")
    x_m, y_m = topology.room(1).centre_m
    topology = vdoor.edited(topology, [f"name {x_m:.3f},{y_m:.3f} {name}"])
    path = tmp_path / "hostile.html"
    path.write_text(to_report(topology, provenance), "utf-8")
    window.requests.clear()
    window.problems.clear()
    window.open(path)
    assert not window.problems
    assert window.run("document.images.length + document.querySelectorAll('b, iframe').length") == 0
    assert window.run("document.title").startswith(HOSTILE[:40])
    assert window.run("document.querySelector('h1').textContent") == HOSTILE
    assert HOSTILE in window.run("document.getElementById('setting-table').textContent")
    assert name in window.run("document.getElementById('room-table').textContent")
    assert name in window.run("document.getElementById('names').textContent")
    assert window.run("document.querySelectorAll('script').length") == 2


def test_scripts_of_others_are_not_run(window: Browser, page: Path, tmp_path: Path) -> None:
    # Even if text came through as an element, the page's policy knows only its own script.
    path = tmp_path / "spoilt.html"
    spoilt = page.read_text().replace(
        "<main>", "<main><script>document.title = 'caught'</script><img src=x onerror=a()>"
    )
    path.write_text(spoilt)
    window.problems.clear()
    window.open(path)
    assert window.run("document.title").startswith("flat.yaml")
    assert any("Content Security Policy" in problem for problem in window.problems)


@pytest.mark.parametrize("name", ["one room", "pillars"])
def test_result_folders_and_maps_without_doors_open_too(name: str, window: Browser, tmp_path: Path) -> None:
    path = tmp_path / "page.html"
    folder = finished_maps.result(name, tmp_path / "result")
    Export.parse(f"report={path}").write(read_finished(folder, provenance=True))
    window.requests.clear()
    window.problems.clear()
    window.open(path)
    assert not window.problems
    assert window.run("document.getElementById('search').hidden")
    assert window.run("document.querySelectorAll('#layers input').length") == 4
    empty = window.run("document.body.innerText.includes('This map has no doors.')")
    assert empty == (not finished_maps.topology(name).doors)
