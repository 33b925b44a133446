"""The steps of an editing page on disk."""

from __future__ import annotations

import itertools
import json
from pathlib import Path

import pytest

from vdoor.errors import VdoorError
from vdoor.results.steps import ELSEWHERE, MOST_STEPS, StepsOnDisk

NAMES = ("a", "b", "c")


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Two of the three files; the third one is made by the first step."""
    (tmp_path / "a").write_bytes(b"a0")
    (tmp_path / "b").write_bytes(b"b0")
    return tmp_path


def test_every_step_can_be_brought_back_to_the_last_byte(folder: Path) -> None:
    disk = StepsOnDisk(folder, NAMES)
    seen = [contents(folder)]
    for number in (1, 2, 3):
        disk.do(disk.current(), f"step {number}", {"b": b"b%d" % number, "c": b"c%d" % number})
        seen.append(contents(folder))
    assert seen[3] == {"a": b"a0", "b": b"b3", "c": b"c3"}
    for before in reversed(seen[:-1]):
        StepsOnDisk(folder, NAMES).go(disk.current(), -1)  # another object each time: all of it is on disk
        assert contents(folder) == before
    for after in seen[1:]:
        assert disk.go(disk.current(), 1).now.said
        assert contents(folder) == after
    with pytest.raises(VdoorError, match="nothing to redo"):
        disk.go(disk.current(), 1)


def test_a_new_step_takes_the_place_of_those_undone_and_their_contents_are_dropped(folder: Path) -> None:
    disk = StepsOnDisk(folder, NAMES)
    disk.do(disk.current(), "one", {"c": b"one"})
    disk.go(disk.current(), -1)
    steps = disk.do(disk.current(), "two", {"c": b"two"})
    assert ([step.said for step in steps.steps][1:], steps.redoes) == (["two"], "")
    assert len(contents(folder / "undo")) == len({"a0", "b0", "two", "steps.json"})
    for number in range(MOST_STEPS):
        steps = disk.do(steps, str(number), {"c": b"%d" % number})
    assert (len(steps.steps), steps.at) == (MOST_STEPS, MOST_STEPS - 1)


@pytest.mark.parametrize("way", ["do", "undo"])
def test_what_a_killed_page_had_begun_is_finished(way: str, folder: Path) -> None:
    disk = StepsOnDisk(folder, NAMES)
    before = contents(folder)
    disk.do(disk.current(), "one", {"a": b"a1", "b": b"b1", "c": b"c1"})
    after = contents(folder)
    if way == "undo":
        disk.go(disk.current(), -1)
        before, after = after, before
    table = json.loads((folder / "undo" / "steps.json").read_text())
    for old in itertools.product([False, True], repeat=3):  # whichever files were written before it was killed
        (folder / "undo" / "steps.json").write_text(json.dumps(table | {"written": False}))
        for name, is_old in zip(NAMES, old, strict=True):
            content = (before if is_old else after).get(name)
            (folder / name).unlink(missing_ok=True)
            if content is not None:
                (folder / name).write_bytes(content)
        assert disk.current().written
        assert contents(folder) == after


def test_a_change_made_elsewhere_is_a_step_and_can_be_undone(folder: Path) -> None:
    disk = StepsOnDisk(folder, NAMES)
    disk.do(disk.current(), "one", {"b": b"b1"})
    (folder / "b").write_bytes(b"by hand")
    assert disk.current().undoes == ELSEWHERE
    disk.go(disk.current(), -1)
    assert (folder / "b").read_bytes() == b"b1"
    # Even if a page was killed: what no step knows is not overwritten.
    table = json.loads((folder / "undo" / "steps.json").read_text())
    (folder / "undo" / "steps.json").write_text(json.dumps(table | {"written": False}))
    (folder / "b").write_bytes(b"by hand again")
    assert disk.current().undoes == ELSEWHERE
    assert (folder / "b").read_bytes() == b"by hand again"


def test_only_one_page_has_the_steps_open(folder: Path) -> None:
    with StepsOnDisk(folder, NAMES).only_here(), pytest.raises(VdoorError, match="open in another page"):
        StepsOnDisk(folder, NAMES).only_here().__enter__()
    with StepsOnDisk(folder, NAMES).only_here():
        pass


@pytest.mark.parametrize(
    "text", ["{", "[]", "{}", '{"steps": [], "at": 0, "written": true}', "BAD PATH", "BAD AT", "[" * 100_000]
)
def test_other_lists_of_steps_are_refused(text: str, folder: Path) -> None:
    disk = StepsOnDisk(folder, NAMES)
    disk.current()
    place = folder / "undo" / "steps.json"
    table = json.loads(place.read_text())
    if text == "BAD PATH":
        table["steps"][0]["files"]["a"] = "../../secret"
        text = json.dumps(table | {"written": False})
    elif text == "BAD AT":
        text = json.dumps(table | {"at": 7})
    place.write_text(text)
    before = contents(folder)
    with pytest.raises(VdoorError, match="without the folder a new list begins"):
        disk.current()
    assert contents(folder) == before


def test_a_spoilt_content_is_refused(folder: Path) -> None:
    disk = StepsOnDisk(folder, NAMES)
    steps = disk.do(disk.current(), "one", {"a": b"a1"})
    (folder / "undo" / str(steps.steps[0].files["a"])).write_bytes(b"spoilt")
    with pytest.raises(VdoorError, match="wanted the content that was stored"):
        disk.go(steps, -1)
    assert (folder / "a").read_bytes() == b"a1"
