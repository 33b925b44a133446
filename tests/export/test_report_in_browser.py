"""The report in a real browser."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Iterator
from pathlib import Path

import finished_maps
import numpy as np
import pytest
from accessibility import serious_findings
from browser import Browser, browser
from project import HOME, VDOOR
from report_pages import HOSTILE, STAGES, driven, provenance_of, told

import vdoor
from vdoor.export import Export, read_finished, to_report
from vdoor.grid import Source


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
    opened.run("document.querySelector('#layers [data-layer=search]').click()")
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


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_page_has_no_serious_findings(scheme: str, opened: Browser) -> None:
    opened.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
    opened.run("document.querySelectorAll('#layers input:not(:checked)').forEach(box => box.click())")
    paper = opened.run("getComputedStyle(document.body).backgroundColor")
    assert serious_findings(opened) == []
    opened.call("Emulation.setEmulatedMedia", features=[])
    assert (paper == "rgb(255, 255, 255)") == (scheme == "light")


def test_paper_has_what_is_seen_and_nothing_to_press(opened: Browser) -> None:
    shown = "selector => [...document.querySelectorAll(selector)].filter(each => each.checkVisibility()).length"
    controls, switches = "#zoom button, #layers input, #generation, #life-number", "#layers .layer"
    assert opened.run(f"({shown})('{controls}')") > 3
    on = opened.run("document.querySelectorAll('#layers input:checked').length")
    opened.call("Emulation.setEmulatedMedia", media="print")
    assert opened.run(f"({shown})('{controls}')") == 0
    assert opened.run(f"({shown})('{switches}')") == on
    assert opened.run(f"({shown})('#frame, #room-table')") == 2
    opened.call("Emulation.setEmulatedMedia", media="")


def test_click_on_a_door_tells_its_life(opened: Browser) -> None:
    opened.run("document.querySelector('#layers [data-layer=rooms]').click()")
    for door in finished_maps.topology("flat").doors[:2]:
        opened.click(*opened.place(f"#door-{door.id} .line"))
        head = opened.run("document.getElementById('life-heading').textContent")
        assert head.endswith(f", door {door.id} of the map")
        assert opened.run("document.querySelector('#life-lines li:last-child').textContent").startswith(
            f"final map: door {door.id} between rooms"
        )
    opened.run("[...document.querySelectorAll('#door-table button')].at(-1).click()")
    last = len(finished_maps.topology("flat").doors)
    assert opened.run("document.getElementById('life-heading').textContent").endswith(f", door {last} of the map")
    assert opened.run("document.activeElement.id") == "life-number"


def test_slider_drives_along_the_path_and_shows_what_is_swept(window: Browser, tmp_path: Path) -> None:
    provenance, topology = driven()
    path = tmp_path / "driven.html"
    path.write_text(to_report(topology, provenance), "utf-8")
    window.problems.clear()
    window.open(path)
    for layer, unit in (("route", "m"), ("coverage", "s")):
        slider, where = f"document.getElementById('drive-{layer}')", f"#shapes [data-layer={layer}] .robot"
        for share in (0.0, 0.5, 1.0):
            window.run(f"{slider}.value = {share} * {slider}.max; {slider}.dispatchEvent(new Event('input'))")
            drive = window.run(f"data.drives.find(drive => drive.layer === '{layer}')")
            x, y = (float(window.run(f"document.querySelector('{where}').getAttribute('c{axis}')")) for axis in "xy")
            expected = [
                np.interp(share * drive["at"][-1], drive["at"], column) for column in zip(*drive["points"], strict=True)
            ]
            assert (x, y) == pytest.approx(expected, abs=0.01)
        assert f"{drive['along_m'][-1]:.1f} m" in window.run(f"{slider}.getAttribute('aria-valuetext')")
        assert unit == drive["unit"]
    swept = "document.querySelector('#passed-coverage .passed').getTotalLength()"
    whole = window.run(swept)
    window.run(f"{slider}.value = 0.25 * {slider}.max; {slider}.dispatchEvent(new Event('input'))")
    assert window.run(swept) < 0.5 * whole
    assert not window.problems


def test_a_label_that_would_cover_another_is_left_out(opened: Browser) -> None:
    shown = "labels.filter(({text}) => text.style.display === '').length"
    before = opened.run(shown)
    opened.run("labels.push(...labels.map(label => ({...label, text: label.text.cloneNode(true)}))); fitLabels()")
    assert opened.run(shown) == before >= len(finished_maps.topology("flat").rooms)


def test_long_tables_show_their_rest_when_it_is_wanted(opened: Browser) -> None:
    """Thousands of rows are slow to open, to check, and to walk through by keyboard."""
    opened.run("data.rooms = Array.from({length: 250}, (_, row) => ({...data.rooms[0], id: row + 1})); fillRooms()")
    rows, rest = "group('room-table').tBodies[0].rows.length", "document.querySelector('#room-table .rest')"
    assert (opened.run(rows), opened.run(f"{rest}.textContent")) == (100, "Show all 250")
    opened.run(f"{rest}.click()")
    assert (opened.run(rows), opened.run(rest)) == (250, None)
    assert opened.run("document.activeElement.getAttribute('aria-label')") == "Show room 101 on the map"
    opened.run("fillRooms()")  # after an edit
    assert opened.run(rows) == 250
    opened.run("whole.clear(); fillRooms(); dispatchEvent(new Event('beforeprint'))")
    assert opened.run(rows) == 250


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
