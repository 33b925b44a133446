"""What fuzzing found, each as the smallest input that shows it: one clear error, and nothing else on stderr."""

from __future__ import annotations

import io
import re
import sqlite3
from pathlib import Path

import numpy as np
import pytest
from commands import Command, one_line
from PIL import Image

from vdoor.errors import MapError
from vdoor.formats import images, read_map
from vdoor.formats.unpacking import PackedError, unpack_zstd

TOPICS = "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT)"


def test_a_zstandard_header_without_its_size_is_damage() -> None:
    with pytest.raises(PackedError, match="wanted it intact, found it damaged"):
        unpack_zstd(b"\x28\xb5\x2f\xfd\xff", 100)


def database(path: Path, *statements: str) -> Path:
    with sqlite3.connect(path) as bag:
        for statement in statements:
            bag.execute(statement)
    bag.close()
    return path


def test_text_that_is_none_in_a_database_is_damage(tmp_path: Path) -> None:
    insert = "INSERT INTO topics VALUES (1, CAST(x'6df161' AS TEXT), 'nav_msgs/msg/OccupancyGrid', 'cdr')"
    with pytest.raises(MapError, match="found text that is not UTF-8"):
        read_map(database(tmp_path / "a.db3", TOPICS, insert))


def test_an_error_of_a_database_is_one_line(tmp_path: Path) -> None:
    path = database(tmp_path / "a.db3", TOPICS.replace("name TEXT", "name\n\nTEXT"))
    path.write_bytes(path.read_bytes().replace(b"INTEGER PRIMARY KEY", b"INTEGER PRIMARY `Y\n"))
    with pytest.raises(MapError, match="found a damaged one") as caught:
        read_map(path)
    assert len(str(caught.value).splitlines()) == 1


def test_a_damaged_tiff_is_silent(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    greys = np.random.default_rng(0).integers(0, 255, (40, 40), np.uint8)
    stream = io.BytesIO()
    Image.fromarray(greys).save(stream, format="TIFF", compression="tiff_deflate")
    data = bytearray(stream.getvalue())
    middle = len(data) // 2
    data[middle - 100 : middle + 100] = bytes(200)
    (tmp_path / "a.tiff").write_bytes(data)
    with pytest.raises(MapError, match="found a damaged one"):
        read_map(tmp_path / "a.tiff", resolution_m=0.05)
    assert capfd.readouterr().err == ""


def test_brightness_is_that_of_graphicsmagick() -> None:
    colours = np.random.default_rng(1).integers(0, 256, (30, 20, 4), np.uint8)
    colours[:15, :, 1] = colours[:15, :, 2] = colours[:15, :, 0]
    luma, spread = images._luma(colours)
    for row, col in np.ndindex(luma.shape):
        red, green, blue, _ = (int(value) for value in colours[row, col])
        assert luma[row, col] == (306 * red + 601 * green + 117 * blue) // 1024
        assert spread[row, col] == max(red, green, blue) - min(red, green, blue)
    assert np.array_equal(images._luma(colours[:15])[0], colours[:15, :, 0])


def test_a_limit_beyond_all_memory_is_refused(tmp_path: Path, command: Command) -> None:
    (tmp_path / "a.pgm").write_bytes(b"P5 6 6 255\n" + b"\xfe" * 36)
    done = command("run", tmp_path / "a.pgm", "--max-cells", "1" + "0" * 400)
    assert done.code == 2
    assert "--max-cells" in done.err


def test_a_packed_recording_is_named(tmp_path: Path, command: Command) -> None:
    (tmp_path / "a.mcap.zstd").write_bytes(b"\x28\xb5\x2f\xfd\x00")
    done = command("info", tmp_path / "a.mcap.zstd")
    assert done.code == 2
    assert re.search(r"found a file packed with zstd \(unzstd unpacks it\)", one_line(done))
