"""Recordings made to do harm: nothing outside is read or written, lies cost no memory, and errors are one line."""

from __future__ import annotations

import dataclasses
import json
import struct
import tracemalloc
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import Command
from recordings_by_hand import Message, by_hand, messages_of
from small_recording import small, small_run, write

from vdoor.emit import RunInfo
from vdoor.grid import Source
from vdoor.recording import about, ros

HUGE = 2**31
YAML = "image: {}\nresolution: 0.2\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"


@contextmanager
def little_memory(most: int = 20_000_000) -> Iterator[None]:
    tracemalloc.start()
    try:
        yield
        assert tracemalloc.get_traced_memory()[1] < most
    finally:
        tracemalloc.stop()


def every_command(command: Command, path: Path, whole: Path) -> dict[str, int]:
    """Give the exit codes of all commands on a file; each fails in one line, at most, and prints no control codes."""
    fixed = path.with_name("fixed.mcap")
    command("diff", whole, whole)  # what is imported once does not count
    codes = {}
    for name, *words in (
        ("verify", path),
        ("info", path),
        ("check", path),
        ("recover", path, "-o", fixed, "--force"),
        ("diff", path, whole),
        ("diff", whole, path),
    ):
        with little_memory():
            done = command(name, *words)
        codes[name] = done.code
        assert done.code in (0, 1, 2)
        assert len(done.err.splitlines()) <= 1
        assert done.code != 2 or done.err.startswith("vdoor: ")
        assert "\x1b" not in done.out + done.err
    return codes


def files(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


def test_names_of_attachments_write_nothing_anywhere(tmp_path: Path, command: Command) -> None:
    info, records = small_run()
    home = tmp_path / "a" / "b" / "c"
    home.mkdir(parents=True)
    whole = small(home / "whole.mcap")
    data = info.source.files[0][1]
    names = ("../../escaped.pgm", str(tmp_path / "absolute.pgm"), "..\\..\\windows.pgm", "\x1b[2J.pgm", "", "x\0y.pgm")
    for first in (names, names[::-1]):
        source = Source(files=tuple((name, data) for name in first))
        path = write(home / "hostile.mcap", records, dataclasses.replace(info, source=source))
        codes = every_command(command, path, whole)
        assert (codes["check"], codes["recover"], codes["info"]) == (0, 0, 0)
        assert files(tmp_path) <= {f"a/b/c/{name}.mcap" for name in ("whole", "hostile", "fixed")}


def test_a_yaml_that_names_files_outside_reads_none_of_them(
    tmp_path: Path, command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    info, records = small_run()
    home = tmp_path / "home"
    home.mkdir()
    monkeypatch.chdir(home)
    secret = tmp_path / "secret.pgm"
    secret.write_bytes(info.source.files[0][1])
    (home / "secret.pgm").write_bytes(info.source.files[0][1])
    for image in ("../secret.pgm", str(secret), "secret.pgm", "/dev/zero"):
        source = Source(files=(("map.yaml", YAML.format(image).encode()),))
        path = write(home / "hostile.mcap", records, dataclasses.replace(info, source=source))
        done = command("verify", path)
        assert (done.code, "wanted a map, found no such file" in done.err) == (2, True)
        both = Source(files=(*source.files, (Path(image).name, b"P5\n2 2\n255\n\xfe\xfe\xfe\xfe")))
        path = write(home / "hostile.mcap", records, dataclasses.replace(info, source=both))
        assert "input differs first" in command("verify", path).out


RUNS: dict[str, dict[str, Any]] = {
    "unknown preset": {"preset": "\x1b[2Jx"},
    "negative seed": {"seed": -5},
    "stage that is none": {"settings": {"\x1b[2J": {}}},
    "setting that is none": {"settings": {"doors": {"\x1b[2J": 1}}},
    "table for a number": {"settings": {"doors": {"max_length_m": {"a": [1]}}}},
    "text for a table": {"settings": {"doors": "all"}},
    "no number": {"settings": {"doors": {"max_length_m": float("nan")}}},
    "far out of range": {"settings": {"simplify": {"cell_m": 1e300}}},
    "method that is none": {"settings": {"search": {"method": ["genetic"]}}},
    "options": {"source": Source(files=small_run()[0].source.files, options={"resolution_m": 1e300})},
}


@pytest.mark.parametrize("name", RUNS)
def test_settings_that_cannot_be_are_refused(name: str, tmp_path: Path, command: Command) -> None:
    info, records = small_run()
    whole = small(tmp_path / "whole.mcap")
    path = write(tmp_path / "hostile.mcap", records, dataclasses.replace(info, **RUNS[name]))
    codes = every_command(command, path, whole)
    assert codes == {"verify": 2, "info": 0, "check": 0, "recover": 0, "diff": 1}


TEXTS: dict[str, dict[str, str]] = {
    "deep": {"settings": "[" * 100_000},
    "no table": {"settings": "[]"},
    "no list": {"source_files": '{"a": 1}'},
    "no seed": {"seed": "9" * 10_000},
    "control codes": {"schema": "\x1b[2J", "version": "\x1b[2J"},
    "nothing": {},
}


@pytest.mark.parametrize("name", TEXTS)
def test_metadata_that_is_none_is_refused(name: str, tmp_path: Path, command: Command) -> None:
    info, records = small_run()
    texts = about.to_text(info) | TEXTS[name] if TEXTS[name] else {"schema": about.SCHEMA}
    texts[about.CHECKSUM] = about._checksum(texts)
    path = by_hand(tmp_path / "hostile.mcap", messages_of(records), texts=texts, source=info.source)
    codes = every_command(command, path, small(tmp_path / "whole.mcap"))
    assert codes == {"verify": 2, "info": 2, "check": 1, "recover": 2, "diff": 2}


def with_field(name: str, value: Any) -> Callable[[Message], Message]:
    """Give what sets a field of a message, ``info.width`` as well."""

    def change(message: Message) -> Message:
        topic, kind, data = message
        decoded = part = ros.unpack(data, kind)
        *way, last = name.split(".")
        for step in way:
            part = getattr(part, step)
        object.__setattr__(part, last, value)
        return topic, kind, bytes(ros.pack(decoded))

    return change


def with_value(label: str, value: float) -> Callable[[Message], Message]:
    """Give what sets a number of a record."""

    def change(message: Message) -> Message:
        topic, kind, data = message
        decoded = ros.unpack(data, kind)
        decoded.data = np.array(decoded.data)
        decoded.data[[dim.label for dim in decoded.layout.dim].index(label)] = value
        return topic, kind, bytes(ros.pack(decoded))

    return change


def with_length(message: Message) -> Message:
    """Let the array at the end of a message claim 2^31 elements."""
    topic, kind, data = message
    array = ros.unpack(data, kind).data
    at = len(data) - array.nbytes - 4 - (1 if kind.endswith("PointCloud2") else 0)
    assert struct.unpack_from("<I", data, at)[0] == array.size
    return topic, kind, data[:at] + struct.pack("<I", HUGE) + data[at + 4 :]


LIES: dict[str, tuple[str, Callable[[Message], Message]]] = {
    "a grid of 2^31 cells": ("input/cells", with_field("info.width", HUGE)),
    "a grid of 2^62 cells": (
        "simplified/cells",
        lambda m: with_field("info.width", HUGE)(with_field("info.height", HUGE)(m)),
    ),
    "a grid of bytes that are not there": ("input/cells", with_length),
    "a frame of 2^31 columns": ("input/values", with_value("width", HUGE)),
    "a frame of 2^31 rows without a raster": ("corners/values", with_value("height", HUGE)),
    "a frame of no rows": ("corners/values", with_value("height", -HUGE)),
    "a frame far away": ("corners/values", with_value("x_m", 1e300)),
    "a frame of nan": ("corners/values", with_value("yaw_rad", float("nan"))),
    "cells of 10^300 metres": ("corners/values", with_value("resolution_m", 1e300)),
    "a count that is none": ("generation/values", with_value("number", 1e300)),
    "an image of 2^31 columns": ("map/labels", with_field("width", HUGE)),
    "an image of 2^31 rows": ("map/labels", with_field("height", HUGE)),
    "an image of words that are none": ("simplified/reason", with_field("data", np.full(128, 250, np.uint8))),
    "a table of 2^31 rows": ("path/sample", with_field("width", HUGE)),
    "a table of bytes that are not there": ("path/sample", with_length),
    "points of 2^31 bytes": ("path/sample", with_field("point_step", HUGE)),
    "bits of bytes that are not there": ("generation/removed", with_length),
    "a message that is none": ("corners/corner", lambda message: (*message[:2], b"\x00\x01\x00\x00\xff")),
    "a message of nothing": ("corners/corner", lambda message: (*message[:2], b"")),
}


@pytest.mark.parametrize("name", LIES)
def test_sizes_that_lie_are_refused_without_room_for_them(name: str, tmp_path: Path, command: Command) -> None:
    place, lie = LIES[name]
    messages = messages_of(small_run()[1])
    at = next(i for i, (_, message) in enumerate(messages) if message[0] == f"/vdoor/{place}")
    changed = [*messages[:at], (messages[at][0], lie(messages[at][1])), *messages[at + 1 :]]
    whole = small(tmp_path / "whole.mcap")
    codes = every_command(command, by_hand(tmp_path / "hostile.mcap", changed), whole)
    if name == "a frame of 2^31 rows without a raster":  # a frame is only a number there, and a wrong one
        assert (codes["verify"], codes["diff"], codes["recover"]) == (1, 1, 0)
    else:
        assert codes == {"verify": 2, "info": 0, "check": 1, "recover": 0, "diff": 2}
        assert command("check", tmp_path / "fixed.mcap").code == 1


def test_a_file_made_by_hand_of_true_messages_verifies(tmp_path: Path, command: Command) -> None:
    whole, hand = small(tmp_path / "whole.mcap"), by_hand(tmp_path / "hand.mcap", messages_of(small_run()[1]))
    assert every_command(command, hand, whole)["verify"] == 0


def test_rows_that_point_nowhere_harm_nobody(tmp_path: Path, command: Command) -> None:
    _, records = small_run()
    low, high = np.iinfo(np.int32).min, np.iinfo(np.int32).max
    whole = small(tmp_path / "whole.mcap")
    for value in (low, -1, high):
        wild = [
            dataclasses.replace(  # type: ignore[type-var]  # a dataclass
                record,
                **{
                    name: np.full_like(array, value)
                    for name, array in vars(record).items()
                    if isinstance(array, np.ndarray) and array.dtype == np.int32
                },
            )
            for record in records
        ]
        codes = every_command(command, write(tmp_path / "hostile.mcap", wild), whole)
        assert codes == {"verify": 1, "info": 0, "check": 0, "recover": 0, "diff": 1}


def test_what_a_file_says_of_itself_reaches_no_terminal_as_it_is(tmp_path: Path, command: Command) -> None:
    info, records = small_run()
    wild: RunInfo = dataclasses.replace(
        info, version="\x1b[2J\x9b", settings={**info.settings, "\x1b]0;x\x07": {"a": 1}}
    )
    path = write(tmp_path / "hostile.mcap", records, wild)
    for words in (("info", path), ("info", path, "--json"), ("diff", path, small(tmp_path / "whole.mcap"))):
        said = command(*words).out
        assert not {"\x1b", "\x07", "\x9b"} & set(said)
    assert json.loads(command("info", path, "--json").out)["version"] == "\x1b[2J\x9b"
    messages = [
        (step, ("/\x1b[2J" if i == 3 else topic, *rest))
        for i, (step, (topic, *rest)) in enumerate(messages_of(records))
    ]
    every_command(command, by_hand(tmp_path / "topic.mcap", messages), path)  # type: ignore[arg-type]  # a message
