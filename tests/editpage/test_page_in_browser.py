"""The page to edit on in a real browser, by clicks, lines and keys."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import finished_maps
import pytest
from accessibility import serious_findings
from browser import Browser, browser
from edited_flat import at

from vdoor.editing.edits import read_edits
from vdoor.editpage.server import Server
from vdoor.editpage.session import Session

SAID, NOTE = "group('said').textContent", "group('place-note').hidden ? '' : group('place-note').textContent"


@pytest.fixture(scope="module")
def window(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    with browser(tmp_path_factory.mktemp("profile")) as started:
        started.call("Emulation.setDeviceMetricsOverride", width=1400, height=1300, deviceScaleFactor=1, mobile=False)
        yield started


class Page:
    """The page of a result, and what a hand does on it."""

    def __init__(self, window: Browser, server: Server) -> None:
        self.window, self.server = window, server
        self.folder = server.session.result

    def choose(self, tool: str) -> None:
        x, y = self.window.place(f"[name=tool][value={tool}]")
        self.window.click(x, y)

    def press(self, selector: str) -> None:
        self.window.click(*self.window.place(selector))
        self.wait()

    def room(self, number: int) -> tuple[float, float]:
        x, y = self.window.place(f"#room-{number}")
        return x, y + 25

    def wait(self) -> None:
        self.window.settle()
        self.window.wait("!asking")
        self.window.settle()

    def says(self, text: str) -> None:
        """Wait until the page says that something was done, in words that begin so."""
        self.window.wait(f"!asking && ({SAID}).startsWith({json.dumps(text)})")
        self.window.settle()

    def notes(self, text: str) -> None:
        """Wait until a note beside a place begins so."""
        self.window.wait(f"!asking && ({NOTE}).startsWith({json.dumps(text)})")

    def run(self, script: str) -> Any:
        return self.window.run(script)

    def edits(self) -> list[str]:
        file = self.folder / "edits.toml"
        return [str(edit) for edit in read_edits(file)] if file.exists() else []


@pytest.fixture
def page(window: Browser, tmp_path: Path) -> Iterator[Page]:
    """The page of the flat; its script must not complain, and it asks for nothing but its own server."""
    session = Session(finished_maps.result("flat", tmp_path / "r"))
    with session.opened(), Server(session) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        window.requests.clear()
        window.problems.clear()
        window.go(server.url)
        yield Page(window, server)
        assert not window.problems
        assert all(each.startswith((server.url, "data:")) for each in window.requests)
        window.go("about:blank")
        server.shutdown()


def test_rooms_and_doors_are_edited_by_hand(page: Page) -> None:
    window = page.window
    page.choose("rename")
    window.click(*page.room(1))
    window.write("Kitchen <b>&")
    page.says("room 1 is now named Kitchen <b>&")
    assert page.edits() == [f"name {at(1)} Kitchen <b>&"]
    assert "Kitchen <b>&" in page.run("group('names').textContent")
    page.choose("merge")
    window.click(*page.room(1))
    window.click(*page.room(2))
    page.wait()
    assert page.run("data.rooms.map(room => room.id)") == [1, 3, 4, 5]
    assert page.run("tip.hidden")  # it told of room 2
    page.choose("split")
    x, y = page.room(3)
    window.drag((x, y - 60), (x, y + 20))
    page.says("room 3 is now rooms 3 (")
    page.choose("remove-door")
    last = page.run("data.doors.find(door => door.kind === 'added').id")
    window.click(*window.place(f"#door-{last} .line"))
    page.says("door removed: room 6 is now part of room 3")
    assert [edit.split()[0] for edit in page.edits()] == ["name", "merge", "split", "remove-door"]
    page.press("#undo")
    page.press("#undo")
    page.press("#redo")
    assert [edit.split()[0] for edit in page.edits()] == ["name", "merge", "split"]
    assert page.run("document.querySelectorAll('#rooms path').length") == 5
    assert page.run("[...document.querySelectorAll('#edit-list li')].length") == 3


def test_a_door_is_added_by_two_clicks(page: Page) -> None:
    page.choose("add-door")
    x, y = page.room(4)
    height = page.run("document.getElementById('room-4').getBoundingClientRect().height")
    for place in ((x - 40, y - 25 - height / 2), (x - 40, y - 25 + height / 2)):
        page.window.click(*place)
        page.says("Now click" if place[1] < y - 25 else "room 4 is now rooms 4 (")
    assert [edit.split()[0] for edit in page.edits()] == ["add-door"]


def test_what_cannot_be_done_is_said_beside_the_place(page: Page) -> None:
    page.choose("merge")
    page.window.click(*page.room(1))
    x, y = page.room(4)
    page.window.click(x, y)
    page.notes("These rooms have no door between them, so they cannot become one.")
    box = page.run("(box => [box.x, box.y])(group('place-note').getBoundingClientRect())")
    assert box == pytest.approx([x + 12, y + 12], abs=1)
    page.choose("add-door")
    page.window.drag((x, y), (x + 8, y))
    page.notes("This line does not part the room")
    page.choose("remove-door")
    page.window.click(x, y)
    page.notes("Click on a door.")
    assert page.edits() == []


def test_a_reload_in_the_middle_loses_nothing(page: Page) -> None:
    page.choose("rename")
    page.window.click(*page.room(2))
    page.window.call("Input.insertText", text="half a na")
    page.window.run("zoom(1 / 1.5)")
    view = page.run("view")
    page.window.go(page.server.url)
    assert page.run("[tool, fieldsOf()[0].value, fieldsOf()[1].value]") == ["rename", "2", "half a na"]
    assert page.run("view") == pytest.approx(view)
    page.window.run("fieldsOf()[1].focus()")
    page.window.write("me")
    page.wait()
    assert page.edits() == [f"name {at(2)} half a name"]
    page.window.go(page.server.url)
    assert not page.run("group('undo').disabled")
    page.press("#undo")
    assert page.edits() == []


def test_all_can_be_done_by_keys(page: Page) -> None:
    page.window.run("document.querySelector('[name=tool][value=merge]').focus()")
    page.window.run("document.querySelector('[name=tool][value=merge]').click()")
    assert page.run("fieldsOf().map(field => field.value)") == ["1", "2"]
    page.window.run("document.querySelector('#edit-form button').click()")
    page.says("rooms 1 and 2 are now room 1")
    page.window.run("document.activeElement.blur()")
    held = {"key": "z", "code": "KeyZ", "windowsVirtualKeyCode": 90, "modifiers": 2}
    page.window.call("Input.dispatchKeyEvent", type="rawKeyDown", **held)
    page.window.call("Input.dispatchKeyEvent", type="keyUp", **held)
    page.says("Undone: rooms 1 and 2")
    assert page.edits() == []


def test_edits_of_the_commands_are_shown_when_one_comes_back(page: Page) -> None:
    page.server.session.do("rename", ["1", "Hall"], seen=page.server.session.state()["edit"]["version"])
    page.window.run("refresh()")
    assert "Hall" in page.run("group('room-table').textContent")


def test_a_server_that_is_gone_is_said(page: Page) -> None:
    offline = {"latency": 0, "downloadThroughput": -1, "uploadThroughput": -1}
    page.window.call("Network.emulateNetworkConditions", offline=True, **offline)
    page.choose("rename")
    page.window.click(*page.room(1))
    page.window.write("Kitchen")
    page.notes("The page's server does not answer.")
    page.window.call("Network.emulateNetworkConditions", offline=False, **offline)
    page.window.problems.clear()  # the browser says the same
    page.press("#edit-form button")
    page.says("room 1 is now named Kitchen")


def test_page_has_no_serious_findings(page: Page) -> None:
    for tool in ("look", "rename", "merge"):
        page.choose(tool)
        assert serious_findings(page.window) == []
