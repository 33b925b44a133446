"""What is no map is refused in one line; what is damaged gives a grid or that line, and nothing else."""

from __future__ import annotations

import io
import os
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from damaged_maps import corrupted, outcome, refused
from PIL import Image

from vdoor.errors import MapError
from vdoor.formats import read_map, read_source
from vdoor.grid import OccupancyGrid, Source

YAML = (
    b"image: map.pgm\nresolution: 0.05\norigin: [1.0, 2.0, 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
)
PGM = b"P5\n# small\n4 3\n255\n" + bytes([0, 205, 254, 254, 0, 0, 205, 254, 254, 254, 254, 0])


def numbered(value: object) -> str | None:
    """Test ids for binary data: the message, not the bytes."""
    return "data" if isinstance(value, bytes) else None


def one(name: str, data: bytes, **options: Any) -> Source:
    return Source(((name, data),), {"resolution_m": 0.05} | options)


def with_yaml(yaml: bytes, image: bytes = PGM) -> Source:
    return Source((("map.yaml", yaml), ("map.pgm", image)))


def array(cells: Any, **save: Any) -> bytes:
    stream = io.BytesIO()
    np.save(stream, cells, **save)
    return stream.getvalue()


def image(mode: str, kind: str, size: tuple[int, int] = (4, 3), **save: Any) -> bytes:
    stream = io.BytesIO()
    greys = np.random.default_rng(0).integers(256, size=size[::-1], dtype=np.uint8)
    Image.fromarray(greys).convert(mode).save(stream, kind, **save)
    return stream.getvalue()


# --- files


def test_a_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(MapError, match=r"^file: wanted a map, found none: .*none\.pgm$"):
        read_map(tmp_path / "none.pgm")
    with pytest.raises(MapError, match=r"found a folder without .* files: "):
        read_map(tmp_path)
    with pytest.raises(MapError, match=r"found "):
        read_map("a\0b.pgm")
    with pytest.raises(MapError, match=r"found "):
        read_map("a" * 5000 + ".pgm")


def test_a_pipe_is_not_opened(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "map.pgm")
    with pytest.raises(MapError, match="file: wanted a map"):
        read_map(tmp_path / "map.pgm")


def test_a_file_too_large_for_its_cells_is_not_opened(tmp_path: Path) -> None:
    with (tmp_path / "map.pgm").open("wb") as file:
        file.truncate(1 << 24)
    with pytest.raises(MapError, match=r"found none of at most \d+ bytes"):
        read_map(tmp_path / "map.pgm", max_cells=1000)


def test_an_image_that_is_not_there_is_named(tmp_path: Path) -> None:
    (tmp_path / "map.yaml").write_bytes(YAML)
    with pytest.raises(MapError, match=rf"found none: {tmp_path}/map\.pgm$"):
        read_map(tmp_path / "map.yaml")


def test_errors_end_with_the_whole_path(tmp_path: Path) -> None:
    (tmp_path / "map.yaml").write_bytes(YAML)
    (tmp_path / "map.pgm").write_bytes(PGM[:-1])
    with pytest.raises(MapError, match=rf"wanted 12, found 11: {tmp_path}/map\.pgm$"):
        read_map(tmp_path / "map.yaml")
    (tmp_path / "map.yaml").write_bytes(YAML[:15])
    with pytest.raises(MapError, match=rf"wanted the key resolution, found none: {tmp_path}/map\.yaml$"):
        read_map(tmp_path / "map.yaml")


def test_a_source_reads_nothing_from_disk(tmp_path: Path) -> None:
    (tmp_path / "map.pgm").write_bytes(PGM)
    outside = YAML.replace(b"map.pgm", str(tmp_path / "map.pgm").encode())
    with pytest.raises(MapError, match=r"found no such file: map\.pgm"):
        read_source(Source((("map.yaml", outside),)))


@pytest.mark.parametrize("name", ["map.yaml", "map.pgm", "map.png", "map.npy"])
def test_an_empty_file_is_no_map(name: str) -> None:
    refused(one(name, b""), "found an empty file")


def test_an_unknown_suffix_is_told_the_known_ones() -> None:
    refused(one("map.doc", PGM), "wanted a file ending in .yaml, .yml, .pgm")
    refused(one("map", PGM), "found no suffix")
    refused(Source(), "wanted at least one")


# --- options


@pytest.mark.parametrize("value", [0, -0.05, float("nan"), float("inf"), 1e9, 1e-9, "0.05", True])
def test_a_resolution_no_map_can_have(value: Any) -> None:
    refused(one("map.pgm", PGM, resolution_m=value), "resolution: wanted 0.0001 to 100 m per cell")


@pytest.mark.parametrize("value", [-1, 256, 2.5, "205", "None", True])
def test_an_unknown_value_that_is_no_grey(value: Any) -> None:
    refused(one("map.pgm", PGM, unknown_value=value), "unknown value: wanted a whole number from 0 to 255")


def test_an_array_knows_its_unknown_cells() -> None:
    refused(one("map.npy", array(np.zeros((1, 1), np.int8)), unknown_value=3), "unknown value: wanted none")


# --- YAML


@pytest.mark.parametrize("key", ["image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh"])
def test_every_required_key_is_missed(key: str) -> None:
    lines = [line for line in YAML.splitlines(keepends=True) if not line.startswith(key.encode())]
    refused(with_yaml(b"".join(lines)), f"YAML: wanted the key {key}, found none")


@pytest.mark.parametrize(
    ("line", "match"),
    [
        ("image: ", "image: wanted the path of an image"),
        ("image: [a, b]", "image: wanted the path of an image, found a list of 2"),
        ("resolution: fine", "resolution: wanted a number, found 'fine'"),
        ("resolution: 0", "resolution: wanted 0.0001 to 100 m per cell, found 0.0"),
        ("resolution: nan", "resolution: wanted 0.0001 to 100 m per cell, found nan"),
        ("resolution: .inf", "resolution: wanted 0.0001 to 100 m per cell, found inf"),
        ("resolution: 1e400", "resolution: wanted"),
        ("resolution: {a: 1}", "resolution: wanted a number, found a table of 1"),
        ("origin: [0, 0]", "origin: wanted [x, y, yaw], found a list of 2"),
        ("origin: 0", "origin: wanted [x, y, yaw], found '0'"),
        ("origin: [.inf, 0, 0]", "origin: wanted a finite number"),
        ("origin: [0, nan, 0]", "origin: wanted a finite number"),
        ("origin: [0, 0, inf]", "origin: wanted a finite number"),
        ("origin: [0, 0, [0]]", "origin: wanted a number, found a list of 1"),
        ("negate: perhaps", "negate: wanted 0, 1, true or false, found 'perhaps'"),
        ("negate: []", "negate: wanted 0, 1, true or false"),
        ("occupied_thresh: 65", "occupied_thresh: wanted 0 to 1, found '65'"),
        ("free_thresh: -0.1", "free_thresh: wanted 0 to 1, found '-0.1'"),
        ("free_thresh: nan", "free_thresh: wanted a finite number"),
        ("mode: colour", "mode: wanted trinary, scale or raw, found 'colour'"),
        ("mode: ", "mode: wanted trinary, scale or raw"),
    ],
)
def test_every_value_that_cannot_be(line: str, match: str) -> None:
    key = line.split(":", maxsplit=1)[0].encode()
    kept = [old for old in YAML.splitlines(keepends=True) if not old.startswith(key)]
    refused(with_yaml(b"".join(kept) + line.encode()), match)


LAUGHS = b"a0: &a0 [x, x]\n" + b"".join(b"a%d: &a%d [*a%d, *a%d]\n" % (n, n, n - 1, n - 1) for n in range(1, 60))


@pytest.mark.parametrize(
    ("yaml", "match"),
    [
        (b"#" * 70_000, "YAML: wanted at most 65536 bytes, found 70000"),
        (b"[" * 60_000, "YAML: wanted a map_server file"),
        (b"{a: " * 12_000, "YAML: wanted a map_server file"),
        (LAUGHS + YAML.replace(b"map.pgm", b"*a59"), "image: wanted the path of an image, found a list of 2"),
        (LAUGHS + b"<<: [" + b"*a9, " * 1000 + b"]\n" + YAML.replace(b"0.05", b"*a59"), "resolution: wanted a number"),
        (b"&a [*a]", "found unconstructable recursive node"),
        (b"a: b: c", "YAML, line 1: wanted a map_server file, found 'mapping values"),
        (b"\xff\xfe\x00", "YAML: wanted a map_server file"),
        (b'a: "\\UFFFFFFFF"', "YAML: wanted a map_server file"),
        (b'a: "\\U00110000"', "YAML: wanted a map_server file"),
        (b"just a text", "YAML: wanted a table of keys, found 'just a text'"),
        (b"--- 1\n--- 2\n", "wanted a map_server file"),
    ],
    ids=numbered,
)
def test_hostile_yaml_is_one_line(yaml: bytes, match: str) -> None:
    refused(with_yaml(yaml), match)


def test_tags_make_no_objects() -> None:
    refused(with_yaml(YAML.replace(b"0.05", b"!!python/object/apply:os.getpid []")), "resolution: wanted a number")


# --- images


@pytest.mark.parametrize(
    ("data", "match"),
    [
        (b"P5\n4 3\n255\n" + bytes(11), "PGM samples: wanted 12, found 11"),
        (b"P5\n4 3\n256\n" + bytes(23), "PGM samples: wanted 12, found 11"),
        (b"P2\n4 3\n255\n1 2 3", "PGM samples: wanted 12, found 3"),
        (b"P2\n2 1\n255\n1 -2", "wanted whole numbers of at most 5 digits"),
        (b"P2\n2 1\n255\n1 123456", "wanted whole numbers of at most 5 digits"),
        (b"P2\n2 1\n255\n1 300", "PGM samples: wanted at most 255, found 300"),
        (b"P5\n0 3\n255\n", "size: wanted at least one cell, found 0 x 3"),
        (b"P5\n4 3\n0\n" + bytes(12), "PGM header: wanted a largest value of 1 to 65535, found 0"),
        (b"P5\n4 3\n65536\n" + bytes(24), "found 65536"),
        (b"P5\n4\n", "PGM header: wanted width, height and largest value"),
        (b"P5" + b" \n" * 20_000 + b"x", "PGM header"),
        (b"P5\n99999999 99999999\n255\n", "size: wanted at most 100000000 cells"),
        (b"P6\n1 1\n255\n123", "image: wanted PGM, PNG, BMP or TIFF, found something else"),
        (b"hello", "image: wanted PGM, PNG, BMP or TIFF, found something else"),
        (image("L", "JPEG"), "image: wanted PGM, PNG, BMP or TIFF, found something else"),
        (image("L", "PNG", (40, 30))[:600], "image: wanted a complete file, found a damaged one"),
        (image("L", "BMP")[:-5], "image: wanted a complete file, found a damaged one"),
        (image("F", "TIFF"), "image: wanted 1 to 16 bits per sample"),
    ],
    ids=numbered,
)
def test_what_is_no_image_is_refused(data: bytes, match: str) -> None:
    refused(one("map.png", data), match)
    refused(with_yaml(YAML, data), match)


@pytest.mark.filterwarnings("ignore:greys")  # the samples are noise
@pytest.mark.parametrize("kind", ["PNG", "BMP", "TIFF"])
def test_cells_are_counted_before_anything_is_decoded(kind: str) -> None:
    data = image("L", kind, (100, 100))
    refused(one("map.png", data), "size: wanted at most 9999 cells, found 100 x 100", max_cells=9999)
    assert read_source(one("map.png", data), max_cells=10_000).cells.shape == (100, 100)
    # Only the header is left of it: the size is still what is complained of.
    if kind != "TIFF":
        refused(one("map.png", data[:54]), "size: wanted at most 9999 cells", max_cells=9999)


@pytest.mark.parametrize("side", [10_000, 20_000])
def test_decompression_bombs_are_refused_without_a_warning_of_pillows(side: int) -> None:
    data = bytearray(image("L", "BMP", (10, 10)))
    data[18:26] = np.array([side, side + 1], "<i4").tobytes()
    refused(one("map.bmp", bytes(data)), "wanted")


# --- arrays


@pytest.mark.parametrize(
    ("data", "match"),
    [
        (array(np.zeros((2, 2), np.uint8)), "wanted int8 in 2 dimensions, found uint8 in 2"),
        (array(np.zeros((2, 2))), "found float64 in 2"),
        (array(np.zeros(4, np.int8)), "found int8 in 1"),
        (array(np.zeros((0, 3), np.int8)), "size: wanted at least one cell, found 3 x 0"),
        (array(np.full((2, 2), 101, np.int8)), "array: wanted values of -1 to 100, found 101 to 101"),
        (array(np.full((2, 2), -2, np.int8)), "found -2 to -2"),
        (array(np.array([[None]]), allow_pickle=True), "wanted int8 in 2 dimensions, found object in 2"),
        (array(np.zeros((2, 2), np.int8))[:-1], "array: wanted 4 cells, found 3"),
        (array(np.zeros((2, 2), np.int8)).replace(b"(2, 2)", b"(-1,2)"), "size: wanted at least one cell"),
        (array(np.zeros((2, 2), np.int8)).replace(b"(2, 2), }  ", b"(2, 10**9)}"), "array: wanted a .npy file"),
        (array(np.zeros((2, 2), np.int8)).replace(b"(2, 2), }       ", b"(2, 100000000),}"), "size: wanted at most"),
        (pickle.dumps([1]), "array: wanted a .npy file of version 1 or 2"),
        (b"\x93NUMPY", "array: wanted a .npy file of version 1 or 2"),
    ],
    ids=numbered,
)
def test_what_is_no_array_of_occupancy_is_refused(data: bytes, match: str) -> None:
    refused(one("map.npy", data), match)


# --- damage


SAMPLES = {
    "map.pgm": PGM,
    "plain.pgm": b"P2\n4 3\n255\n0 205 254 254\n0 0 205 254\n254 254 254 0\n",
    "map.png": image("L", "PNG"),
    "colour.png": image("RGBA", "PNG"),
    "palette.png": image("P", "PNG", transparency=3),
    "map.bmp": image("P", "BMP"),
    "map.tif": image("L", "TIFF"),
    "packed.tif": image("L", "TIFF", compression="tiff_lzw"),
    "map.yaml": YAML,
    "map.npy": array(np.zeros((3, 4), np.int8)),
}


@pytest.mark.parametrize("name", SAMPLES)
def test_damage_gives_a_grid_or_one_line(name: str) -> None:
    rng = np.random.default_rng(len(SAMPLES[name]))
    outcomes: set[type] = set()
    for _ in range(200):
        files = [(name, corrupted(SAMPLES[name], rng))] + ([("map.pgm", PGM)] if name == "map.yaml" else [])
        source = Source(tuple(files), {} if name == "map.yaml" else {"resolution_m": 0.05})
        outcomes.add(outcome(source))
    assert outcomes == {MapError, OccupancyGrid}
