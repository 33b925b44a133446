"""Files of other programs are told from damaged recordings, and small files cannot cause much work."""

from __future__ import annotations

import sqlite3
import struct
import tracemalloc
import zlib
from pathlib import Path

import mcap.writer
import numpy as np
import pytest
import zstandard
from bags import bare_mcap, grid_message
from commands import Command, one_line
from small_recording import small, small_run

from vdoor.recording import about
from vdoor.recording.scan import HEADER, MAGIC

COMMANDS = ("info", "check", "recover")
CELLS = np.zeros((4, 5), np.int8)


def words(command: str, path: Path) -> tuple[str | Path, ...]:
    return (command, path, "-o", path.with_name("fixed.mcap")) if command == "recover" else (command, path)


def refused(command: Command, name: str, path: Path) -> str:
    done = command(*words(name, path))
    assert (done.code, done.out) == (2, "")
    assert not path.with_name("fixed.mcap").exists()
    return one_line(done)


@pytest.mark.parametrize("name", COMMANDS)
def test_a_bag_is_none_of_ours_whole_or_cut(name: str, tmp_path: Path, command: Command) -> None:
    path = bare_mcap(tmp_path / "bag.mcap", [("/scan/map", 1, grid_message(CELLS)), ("/other", 2, grid_message(CELLS))])
    line = refused(command, name, path)
    assert "found one of another program, with /other, /scan/map (`vdoor run` reads the map in a bag)" in line
    data = path.read_bytes()
    path.write_bytes(data[: len(data) * 3 // 5])
    assert "found one of another program" in refused(command, name, path)


@pytest.mark.parametrize("name", COMMANDS)
def test_a_database_is_no_recording(name: str, tmp_path: Path, command: Command) -> None:
    path = tmp_path / "bag.db3"
    with sqlite3.connect(path) as bag:
        bag.execute("CREATE TABLE topics (id)")
    bag.close()
    assert "wanted an MCAP file, found an SQLite file, such as a .db3 bag" in refused(command, name, path)


def test_a_recording_without_its_metadata_is_still_ours(tmp_path: Path, command: Command) -> None:
    path = small(tmp_path / "a.mcap")
    data = path.read_bytes()
    at = data.index(b"vdoor")
    path.write_bytes(data[: at - 3] + b"\xff" + data[at - 2 :])
    assert "preset, settings, seed" in command("recover", path, "-o", tmp_path / "fixed.mcap").out


def recording_with(path: Path, chunks: list[bytes]) -> Path:
    """Give a recording that begins like ours and then has these chunks."""
    with path.open("wb") as stream:
        writer = mcap.writer.Writer(stream)
        writer.start("ros2")
        writer.add_metadata("vdoor", about.to_text(small_run()[0]))
        for name, data in small_run()[0].source.files:
            writer.add_attachment(0, 0, name, "", data)
        writer.finish()  # type: ignore[no-untyped-call]
    data = path.read_bytes()
    at = data.index(HEADER.pack(15, 4))  # the end of the data section
    path.write_bytes(data[:at] + b"".join(map(packed_chunk, chunks)) + HEADER.pack(15, 4) + bytes(4) + data[at + 13 :])
    return path


def packed_chunk(content: bytes) -> bytes:
    packed = zstandard.compress(content)
    head = struct.pack("<QQQI", 0, 0, len(content), zlib.crc32(content)) + struct.pack("<I", 4) + b"zstd"
    body = head + struct.pack("<Q", len(packed)) + packed
    return HEADER.pack(6, len(body)) + body


MESSAGE = HEADER.pack(5, 22) + bytes(22)


@pytest.mark.parametrize("name", COMMANDS)
def test_empty_messages_without_end_are_too_many(name: str, tmp_path: Path, command: Command) -> None:
    path = recording_with(tmp_path / "many.mcap", [MESSAGE * 250_000])
    assert path.stat().st_size < 20_000
    done = command(*words(name, path))
    assert "wanted a number of records that fits the file's size, found far more" in done.out + done.err


@pytest.mark.parametrize("name", COMMANDS)
def test_chunks_that_unpack_to_too_much_are_refused(
    name: str, tmp_path: Path, command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("vdoor.recording.scan.UNPACKED", 2**20)
    path = recording_with(tmp_path / "big.mcap", [HEADER.pack(5, 2**20) + bytes(2**20)] * 4)
    done = command(*words(name, path))
    assert "wanted a total size that fits the file's size, found far more once unpacked" in done.out + done.err


@pytest.mark.parametrize("name", COMMANDS)
def test_zeros_are_read_no_further_than_the_first(name: str, tmp_path: Path, command: Command) -> None:
    path = tmp_path / "zeros.mcap"
    path.write_bytes(MAGIC + bytes(30_000_000))
    tracemalloc.start()
    done = command(*words(name, path))
    assert tracemalloc.get_traced_memory()[1] < 20_000_000
    tracemalloc.stop()
    assert done.code in (1, 2)
    assert "wanted a record at byte 8, found none" in done.out + done.err or name == "recover"


def test_beginnings_of_chunks_without_end_are_too_many(
    tmp_path: Path, command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("vdoor.recording.scan.UNPACKED", 2**20)
    chunk = packed_chunk(b"x" * 100)
    hole = chunk[:45] + struct.pack("<Q", 1_000_000) + chunk[53:]  # each claims the megabyte behind it
    path = tmp_path / "quadratic.mcap"
    path.write_bytes(MAGIC + hole * (2_000_000 // len(hole)))
    assert "found far more once unpacked" in refused(command, "recover", path)
