"""Files given to commands as recordings: what is none is refused at once, and what is one is never written over."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from commands import Command
from small_recording import altered, small, write

from vdoor.outputs import Outputs, opened
from vdoor.pipeline import RECORDS
from vdoor.recording.mcap import read_recording

READERS = (
    ("verify",),
    ("info",),
    ("check",),
    ("show",),
    ("why", "--at", "1,1"),
    ("view",),
    ("shot", "-o", "pictures"),
    ("replay", "--save", "out.rrd"),
    ("recover", "-o", "fixed.mcap"),
    ("export", "--to", "svg"),
    ("run",),
)
"""Commands that read a recording."""


@pytest.fixture
def command(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Command:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    return Command()


@pytest.fixture(scope="module")
def picture(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """A small Rerun recording."""
    folder = tmp_path_factory.mktemp("picture")
    recording = read_recording(small(folder / "small.mcap"), types=RECORDS)
    with opened(Outputs(save=folder / "small.rrd"), recording.info) as drawing:
        for step, record in list(recording)[:4]:
            drawing.sinks[0].write(step, record)
    return (folder / "small.rrd").read_bytes()


def refused(command: Command, *words: str | Path) -> str:
    """The one line that a command refuses with."""
    done = command(*words)
    assert done.code == 2
    (said,) = done.err.splitlines()
    return said


NOISE = np.random.default_rng(1).bytes(5000)
SPOILT: dict[str, Callable[[bytes], bytes]] = {
    "empty": lambda _: b"",
    "other": lambda _: NOISE,
    "header alone": lambda whole: whole[:16],
    "other behind the header": lambda whole: whole[:4] + NOISE,
    "cut short": lambda whole: whole[: len(whole) // 2],
    "without its last bytes": lambda whole: whole[:-100],
    "damaged": lambda whole: whole[:20000] + NOISE[:1000] + whole[21000:],
}


@pytest.mark.parametrize("name", SPOILT)
@pytest.mark.parametrize("words", [("view",), ("shot", "-o", "pictures")], ids=" ".join)
def test_a_viewer_is_not_started_for_what_it_cannot_load(
    name: str, words: tuple[str, ...], picture: bytes, tmp_path: Path, command: Command
) -> None:
    path = tmp_path / "spoilt.rrd"
    path.write_bytes(SPOILT[name](picture))
    said = refused(command, words[0], path, *words[1:])
    assert said.startswith("vdoor: recording: wanted a ")
    assert said.endswith(str(path))
    assert not (tmp_path / "pictures").exists()


def test_without_a_screen_whole_recordings_are_told_of_the_other_ways(
    picture: bytes, tmp_path: Path, command: Command
) -> None:
    (tmp_path / "whole.rrd").write_bytes(picture)
    small(tmp_path / "whole.mcap")
    for name in ("whole.rrd", "whole.mcap"):
        assert "no screen" in refused(command, "view", name)


@pytest.mark.parametrize("name", ["missing.mcap", "missing.rrd", "folder.mcap", "stray.mcap"])
def test_without_a_screen_the_file_is_what_is_told_of_first(name: str, tmp_path: Path, command: Command) -> None:
    (tmp_path / "folder.mcap").mkdir()
    (tmp_path / "stray.mcap").write_text("nothing of the kind")
    assert refused(command, "view", name).startswith("vdoor: recording: wanted an ")


@pytest.mark.parametrize("words", READERS, ids=" ".join)
def test_a_pipe_is_refused_and_not_waited_for(words: tuple[str, ...], tmp_path: Path, command: Command) -> None:
    os.mkfifo(tmp_path / "pipe.mcap")
    said = refused(command, words[0], "pipe.mcap", *words[1:])
    assert said.endswith("found a device or pipe: pipe.mcap")


def test_a_pipe_is_refused_by_diff_on_either_side(tmp_path: Path, command: Command) -> None:
    small(tmp_path / "small.mcap")
    os.mkfifo(tmp_path / "pipe.mcap")
    for pair in (("pipe.mcap", "small.mcap"), ("small.mcap", "pipe.mcap")):
        assert "device or pipe" in refused(command, "diff", *pair)


@pytest.mark.parametrize("words", [("verify",), ("diff", "whole.mcap")], ids=" ".join)
def test_a_comparison_that_fails_leaves_no_file(words: tuple[str, ...], tmp_path: Path, command: Command) -> None:
    whole = small(tmp_path / "whole.mcap")
    (tmp_path / "cut.mcap").write_bytes(whole.read_bytes()[:-9000])
    assert command(*words, "cut.mcap", "--save", "out.rrd").code == 2
    assert sorted(path.name for path in tmp_path.iterdir()) == ["cut.mcap", "whole.mcap"]


def test_a_comparison_that_finds_differences_keeps_its_file(tmp_path: Path, command: Command) -> None:
    write(tmp_path / "other.mcap", altered("path", "arc_m", 3, lambda arc_m: arc_m + 1.0))
    assert command("verify", "other.mcap", "--save", "out.rrd").code == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["other.mcap", "out.rrd"]


@pytest.mark.parametrize(
    "words",
    [
        ("replay", "REC", "--save", "REC"),
        ("replay", "REC", "--save", "OUT"),
        ("verify", "REC", "--save", "OUT"),
        ("verify", "REC", "--junit", "OUT"),
        ("diff", "whole.mcap", "REC", "--save", "OUT"),
        ("export", "REC", "--to", "json", "-o", "OUT"),
    ],
    ids=" ".join,
)
def test_what_is_read_is_never_written_over(words: tuple[str, ...], tmp_path: Path, command: Command) -> None:
    """Neither under its own name, nor as the file that an output is until it is whole."""
    before = small(tmp_path / "whole.mcap").read_bytes()
    shutil.copy(tmp_path / "whole.mcap", tmp_path / "out.mcap.partial")
    names = {"REC": "out.mcap.partial", "OUT": "out.mcap"}
    said = refused(command, *(names.get(word, word) for word in words), "--force")
    assert "a different name from the input's" in said
    assert (tmp_path / "out.mcap.partial").read_bytes() == before
