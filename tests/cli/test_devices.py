"""Pipes and devices in the place of every kind of file that is read: refused at once, in one line."""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
from collections.abc import Iterator
from pathlib import Path
from types import FrameType

import finished_maps
import pytest
from commands import Command, one_line

HANGS_S = 20


class HangsError(BaseException):
    """Not an `Exception`, which a reader might take for one of its own."""


@contextlib.contextmanager
def at_once() -> Iterator[None]:
    """Claim that a block does not wait, as for a pipe into which nobody writes."""

    def stop(number: int, _: FrameType | None) -> None:
        raise HangsError(number)

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(HANGS_S)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


@pytest.fixture(params=["pipe", "/dev/zero"])
def device(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    if request.param == "pipe":
        os.mkfifo(tmp_path / "pipe")
    return tmp_path / request.param


def test_as_a_map_a_recording_or_a_result(device: Path, tmp_path: Path, command: Command) -> None:
    image = tmp_path / "map.pgm"
    image.write_bytes(b"P5 30 30 255\n" + b"\xfe" * 900)
    (tmp_path / "map.yaml").write_text(
        "image: image.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.2\n"
    )
    for name in ("image.pgm", "maps.txt", "maps.csv"):
        (tmp_path / name).symlink_to(device)
    (tmp_path / "bag").mkdir()
    (tmp_path / "bag" / "a.mcap").symlink_to(device)
    names = ("run", "info", "check", "show", "replay", "view", "step", "rooms", "cover", "order", "valetudo", "edit")
    calls: list[list[str | Path]] = [
        *([name, device] for name in names),
        ["run", tmp_path / "map.yaml"],
        ["run", tmp_path / "bag"],
        *(["run", "-q", image, option, device] for option in ("--edits", "--config", "--match")),
        ["run", "-q", image, "--set", f"score.model={device}"],
        ["recover", device, "-o", tmp_path / "o.mcap"],
        ["nav2", device, "--out", tmp_path / "o"],
        ["evaluate", device, "--reference", image],
        *(["batch", tmp_path / name, "--out", tmp_path / "o"] for name in ("maps.txt", "maps.csv")),
    ]
    for words in calls:
        with at_once():
            done = command(*words)
        assert (done.code, done.out) == (2, ""), words
        assert one_line(done)


def test_as_a_file_of_a_result(device: Path, tmp_path: Path, command: Command) -> None:
    whole = finished_maps.result("one room", tmp_path / "whole")
    for name in ("map.json", "rooms.png", "grid.png", "edits.toml"):
        folder = tmp_path / name
        shutil.copytree(whole, folder)
        (folder / name).unlink(missing_ok=True)
        (folder / name).symlink_to(device)
        words = ["rename", folder, "1", "Hall"] if name == "edits.toml" else ["export", folder, "--to", "report"]
        with at_once():
            done = command(*words, *([] if name == "edits.toml" else ["-o", tmp_path / "report.html"]))
        assert done.code == 2, name
        assert one_line(done)
