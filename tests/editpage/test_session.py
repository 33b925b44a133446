"""Edits on the page: the same as by the commands, to the last byte."""

from __future__ import annotations

from pathlib import Path

import finished_maps
import pytest
from commands import Command
from edited_flat import at

from vdoor.editpage.session import FILES, Session, StaleError
from vdoor.errors import VdoorError
from vdoor.results.writing import NAMES

EDITS = (
    (("rename", "1", "Kitchen"), ("rename", "1", "Kitchen")),
    (("rename", at(4), "Küche 2"), ("rename", at(4), "Küche 2")),
    (("merge", "1", "2"), ("merge", "1", "2")),
    (("split", "7.3,4.3", "7.3,4.5"), ("split", "7.3,4.3", "7.3,4.5")),
    (("door remove", "2"), ("remove-door", "2")),
    (("door add", "2.9,1.5", "2.9,4.3"), ("add-door", "2.9,1.5", "2.9,4.3")),
)
"""The words of a command, the result behind the first, and what the page sends."""


def contents(folder: Path) -> dict[str, bytes]:
    return {name: (folder / name).read_bytes() for name in FILES if (folder / name).exists()}


@pytest.fixture
def session(tmp_path: Path) -> Session:
    return Session(finished_maps.result("flat", tmp_path / "page"))


def do(session: Session, *words: str) -> str:
    action, *rest = words
    return str(session.do(action, rest, seen=session.state()["edit"]["version"])["said"])


def test_page_and_commands_write_the_same_bytes(session: Session, tmp_path: Path, command: Command) -> None:
    other = finished_maps.result("flat", tmp_path / "command")
    seen = [contents(session.result)]
    for (name, *words), sent in EDITS:
        done = command(*name.split(), other, *words)
        assert done.out == do(session, *sent) + "\n"
        assert contents(session.result) == contents(other)
        seen.append(contents(session.result))
    assert len({tuple(files.items()) for files in seen}) == len(EDITS) + 1
    for way, states in ((-1, reversed(seen[:-1])), (1, seen[1:])):
        for state in states:
            session.go(way, seen=session.state()["edit"]["version"])
            assert contents(session.result) == state


def test_what_the_page_shows_follows_each_edit(session: Session) -> None:
    do(session, "rename", "1", "Kitchen")
    do(session, "merge", "1", "2")
    state = session.state()
    assert [(room["id"], room["name"]) for room in state["rooms"]] == [(1, "Kitchen"), (3, ""), (4, ""), (5, "")]
    assert (len(state["doors"]), dict(state["facts"])["rooms"]) == (3, "4")
    assert state["edit"]["undo"].startswith("rooms 1 and 2 are now room 1")
    assert (state["edit"]["count"], state["edit"]["redo"]) == (2, "")


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("merge", "1", "4"), "These rooms have no door between them, so they cannot become one."),
        (("split", "-9,1", "-9,2"), "There is no room at this place."),
        (("add-door", "2,2", "2.1,2.1"), "This line does not part the room"),
        (("remove-door", "2,2"), "door: no door there"),
        (("merge", "1", "1"), "merge: wanted two rooms, found room 1 twice"),
        (("rename", "1", " "), "edit: wanted a name of one line"),
        (("split", "a", "1,1"), "place: wanted X,Y, found 'a'"),
        (("paint", "1"), "wanted one of rename, split"),
        (("merge", "1"), "wanted one of rename, split"),
    ],
)
def test_what_cannot_be_done_is_one_sentence_and_changes_nothing(
    words: tuple[str, ...], says: str, session: Session
) -> None:
    before = contents(session.result)
    with pytest.raises(VdoorError) as refused:
        do(session, *words)
    sentence = session.sentence(refused.value)
    assert sentence.startswith(says)
    assert str(session.result) not in sentence
    assert contents(session.result) == before


def test_a_page_that_has_seen_another_state_is_told(session: Session, command: Command) -> None:
    seen = session.state()["edit"]["version"]
    command("rename", session.result, "1", "Hall")
    before = contents(session.result)
    with pytest.raises(StaleError):
        session.do("rename", ["1", "Kitchen"], seen=seen)
    assert contents(session.result) == before
    assert session.state()["rooms"][0]["name"] == "Hall"
    session.go(-1, seen=session.state()["edit"]["version"])
    assert session.state()["rooms"][0]["name"] == ""


def test_edit_that_is_done_already_is_no_step(session: Session) -> None:
    do(session, "rename", "1", "Kitchen")
    before = contents(session.result)
    assert do(session, "rename", "1", "Kitchen") == "Nothing to change."
    assert contents(session.result) == before
    assert session.state()["edit"]["count"] == 1


def test_another_map_in_the_folder_is_a_step_with_all_its_files(session: Session) -> None:
    do(session, "rename", "1", "Kitchen")
    before = contents(session.result)
    finished_maps.result("one room", session.result)  # as `vdoor run --out --force` does
    state = session.state()
    assert ([room["name"] for room in state["rooms"]], dict(state["facts"])["rooms"]) == ([""], "1")
    session.go(-1, seen=state["edit"]["version"])
    assert contents(session.result) == before
    again = session.state()
    assert (again["rooms"][0]["name"], again["edit"]["grid"] == state["edit"]["grid"]) == ("Kitchen", False)
    assert set(before) == {*NAMES, "edits.toml"}
