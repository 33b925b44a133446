"""Maps are read cell for cell as Nav2 reads them."""

from __future__ import annotations

import struct
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from vdoor.errors import MapError, MapWarning
from vdoor.formats import READERS, read_map, read_source
from vdoor.frame import Frame
from vdoor.record import equal

HEADER = {
    "image": "map.pgm",
    "resolution": "0.05",
    "origin": "[0.0, 0.0, 0.0]",
    "negate": "0",
    "occupied_thresh": "0.65",
    "free_thresh": "0.196",
}


def write_yaml(folder: Path, **changes: str) -> Path:
    path = folder / "map.yaml"
    path.write_text("".join(f"{key}: {value}\n" for key, value in (HEADER | changes).items()))
    return path


def write_pgm(folder: Path, rows: Any, *, maxval: int = 255, name: str = "map.pgm") -> Path:
    samples = np.asarray(rows)
    path = folder / name
    header = f"P5\n# made for a test\n{samples.shape[1]} {samples.shape[0]}\n{maxval}\n".encode()
    path.write_bytes(header + samples.astype(">u2" if maxval > 255 else np.uint8).tobytes())
    return path


def cells_of(folder: Path, rows: Any, *, maxval: int = 255, **changes: str) -> Any:
    write_pgm(folder, rows, maxval=maxval)
    return read_map(write_yaml(folder, **changes)).cells.tolist()


def image_cells(folder: Path, image: Image.Image, name: str, **save: Any) -> Any:
    image.save(folder / name, **save)
    return read_map(folder / name, resolution_m=0.05).cells.tolist()


# --- trinary, scale, raw


def float32(value: float) -> float:
    return float(struct.unpack("f", struct.pack("f", value))[0])


def trinary(grey: int, *, negate: bool, occupied: float, free: float) -> int:
    """Nav2's rule written out again, one grey at a time, every step rounded to float32."""
    shade = float32(grey / 255)
    darkness = shade if negate else float32(1 - shade)
    if darkness <= float32(free):
        return 0
    return 100 if darkness >= float32(occupied) else -1


@pytest.mark.parametrize("negate", [False, True])
@pytest.mark.parametrize(("occupied", "free"), [(0.65, 0.196), (0.65, 0.1), (0.6, 0.2), (0.8, 0.4), (1.0, 0.0)])
def test_trinary_is_the_rule_in_float32_at_all_256_greys(
    tmp_path: Path, negate: bool, occupied: float, free: float
) -> None:
    rows = np.arange(256).reshape(16, 16)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MapWarning)
        found = cells_of(tmp_path, rows, negate=str(int(negate)), occupied_thresh=str(occupied), free_thresh=str(free))
    wanted = [trinary(grey, negate=negate, occupied=occupied, free=free) for grey in range(256)]
    assert np.ravel(found).tolist() == wanted


def test_a_darkness_equal_to_a_threshold_meets_it(tmp_path: Path) -> None:
    # 51 / 255 is 0.2 and 153 / 255 is 0.6 in float32; with > and <, or in double, they would be unknown.
    assert cells_of(tmp_path, [[51, 52, 152, 153]], negate="1", occupied_thresh="0.6", free_thresh="0.2") == [
        [0, -1, -1, 100]
    ]


def test_the_usual_three_greys(tmp_path: Path) -> None:
    assert cells_of(tmp_path, [[0, 205, 254], [89, 90, 206]]) == [[100, -1, 0], [100, -1, 0]]


def test_scale_spreads_what_lies_between_the_thresholds(tmp_path: Path) -> None:
    # 100 (1 - grey / 255 - 0.196) / 0.454: 99.3, 73.4, 47.5, 4.3
    rows = [[0, 89, 90, 120, 150, 200, 206, 255]]
    assert cells_of(tmp_path, rows, mode="Scale") == [[100, 100, 99, 73, 48, 4, 0, 0]]
    assert cells_of(tmp_path, [[255, 165, 55, 0]], mode="scale", negate="1") == [[100, 99, 4, 0]]


def test_raw_takes_the_grey_as_occupancy_and_ignores_negate(tmp_path: Path) -> None:
    for negate in ("0", "1"):
        assert cells_of(tmp_path, [[0, 1, 100, 101, 205, 255]], mode="raw", negate=negate) == [[0, 1, 100, -1, -1, -1]]


def test_raw_takes_samples_as_stored_where_the_largest_is_not_255(tmp_path: Path) -> None:
    assert cells_of(tmp_path, [[0, 50, 100, 255]], maxval=100, mode="raw") == [[0, 50, 100, -1]]


@pytest.mark.parametrize(("word", "swapped"), [("0", False), ("1", True), ("2", True), ("false", False),
                                               ("True", True), ("no", False), ("ON", True)])  # fmt: skip
def test_negate_is_a_number_or_a_word(tmp_path: Path, word: str, swapped: bool) -> None:
    assert cells_of(tmp_path, [[0, 255]], negate=word) == ([[0, 100]] if swapped else [[100, 0]])


def test_where_thresholds_overlap_free_wins_with_a_warning(tmp_path: Path) -> None:
    with pytest.warns(MapWarning, match=r"free_thresh 0\.7 is not below occupied_thresh 0\.5"):
        found = cells_of(tmp_path, [[0, 102, 255]], occupied_thresh="0.5", free_thresh="0.7")
    assert found == [[100, 0, 0]]


# --- PGM


def test_sixteen_bits_are_divided_by_257(tmp_path: Path) -> None:
    rows = [[0, 89 * 257, 90 * 257, 206 * 257 - 1, 206 * 257, 65535]]
    assert cells_of(tmp_path, rows, maxval=65535) == [[100, 100, -1, -1, 0, 0]]


def test_any_largest_value_means_white(tmp_path: Path) -> None:
    assert cells_of(tmp_path, [[0, 7, 15]], maxval=15) == [[100, -1, 0]]
    assert cells_of(tmp_path, [[0, 500, 1000]], maxval=1000) == [[100, -1, 0]]


@pytest.mark.parametrize(
    "text",
    [
        b"P2\n3 2\n255\n0 205 254\n89 90 206\n",
        b"P2 # plain\n# size\n3 #wide\n2\n255\n0 205 254 89 90 206",
        b"P2\r\n3 2\r\n255\r\n0\r\n205\t254 089 00090\n# last\n206 7 7",
        b"P5\n# CREATOR: map_saver 0.05 m/pix\n3 2\n255\n\x00\xcd\xfe\x59\x5a\xce",
        b"P5 3 # wide\n2 255#none\n\x00\xcd\xfe\x59\x5a\xce\n",
        b"P5\n3 2\n65535\n\x00\x00\xcd\xcd\xfe\xfe\x59\x59\x5a\x5a\xce\xce",
    ],
)
def test_plain_and_binary_with_comments_anywhere(tmp_path: Path, text: bytes) -> None:
    (tmp_path / "map.pgm").write_bytes(text)
    grid = read_map(tmp_path / "map.pgm", resolution_m=0.1)
    assert grid.cells.tolist() == [[100, -1, 0], [100, -1, 0]]


def test_a_binary_pgm_may_begin_with_white_space_or_a_hash(tmp_path: Path) -> None:
    (tmp_path / "map.pgm").write_bytes(b"P5\n3 1\n100\n\x0a\x23\x20")
    assert read_map(write_yaml(tmp_path, mode="raw")).cells.tolist() == [[10, 35, 32]]


# --- images on their own


@pytest.mark.filterwarnings("ignore:greys")  # every grey there is
def test_a_plain_image_is_free_from_grey_206_on(tmp_path: Path) -> None:
    path = write_pgm(tmp_path, np.arange(256).reshape(16, 16))
    cells = read_map(path, resolution_m=0.05).cells.ravel()
    assert np.flatnonzero(cells == 0).tolist() == list(range(206, 256))
    assert np.flatnonzero(cells == 100).tolist() == list(range(90))


@pytest.mark.parametrize("suffix", ["png", "bmp", "tif", "tiff", "PNG"])
def test_every_image_format_gives_the_same_cells(tmp_path: Path, suffix: str) -> None:
    image = Image.fromarray(np.array([[0, 205, 254], [89, 90, 206]], np.uint8))
    assert image_cells(tmp_path, image, f"map.{suffix}") == [[100, -1, 0], [100, -1, 0]]


def test_the_content_tells_the_image_format(tmp_path: Path) -> None:
    Image.new("L", (2, 1), 255).save(tmp_path / "map.png")
    (tmp_path / "map.png").rename(tmp_path / "map.pgm")
    assert read_map(tmp_path / "map.pgm", resolution_m=0.05).cells.tolist() == [[0, 0]]


def test_colour_is_read_by_luma(tmp_path: Path) -> None:
    colours = np.array([[[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 0], [205, 205, 205]]], np.uint8)
    # luma 76, 149, 29, 225, 205
    assert image_cells(tmp_path, Image.fromarray(colours), "map.png") == [[100, -1, 100, 0, -1]]


@pytest.mark.filterwarnings("ignore:greys")  # every grey there is
def test_every_grey_written_as_colour_stays_that_grey(tmp_path: Path) -> None:
    greys = np.arange(256, dtype=np.uint8).reshape(16, 16)
    colour = Image.fromarray(np.repeat(greys[..., None], 3, axis=2))
    assert image_cells(tmp_path, colour, "colour.png") == image_cells(tmp_path, Image.fromarray(greys), "grey.png")


def test_a_palette_is_looked_up(tmp_path: Path) -> None:
    image = Image.fromarray(np.array([[0, 1, 2]], np.uint8)).convert("P")
    image.putpalette([254, 254, 254, 0, 0, 0, 205, 205, 205])
    assert image_cells(tmp_path, image, "map.png") == [[0, 100, -1]]
    assert image_cells(tmp_path, image, "keyed.png", transparency=0) == [[-1, 100, -1]]


def test_one_bit_is_black_and_white(tmp_path: Path) -> None:
    assert image_cells(tmp_path, Image.fromarray(np.array([[True, False]])), "map.png") == [[0, 100]]


@pytest.mark.parametrize("suffix", ["png", "tif"])
def test_sixteen_bit_grey_keeps_its_upper_half(tmp_path: Path, suffix: str) -> None:
    image = Image.fromarray(np.array([[0, 205 * 257, 206 * 257, 65535]], np.uint16))
    assert image_cells(tmp_path, image, f"map.{suffix}") == [[100, -1, 0, 0]]


def test_a_sixteen_bit_transparent_key_is_unknown(tmp_path: Path) -> None:
    image = Image.fromarray(np.array([[0, 65000, 65535]], np.uint16))
    assert image_cells(tmp_path, image, "map.png", transparency=65000) == [[100, -1, 0]]


@pytest.mark.parametrize("channels", [2, 4])
def test_what_is_not_opaque_is_unknown(tmp_path: Path, channels: int) -> None:
    pixels = np.array([[0, 255, 0, 255]], np.uint8)[..., None].repeat(channels, axis=2)
    pixels[..., -1] = [255, 255, 254, 0]
    image = Image.fromarray(pixels)
    assert image_cells(tmp_path, image, "map.png") == [[100, 0, -1, -1]]
    for mode, wanted in {"trinary": [100, 0, -1, -1], "scale": [100, 0, -1, -1], "raw": [0, -1, 0, -1]}.items():
        assert read_map(write_yaml(tmp_path, image="map.png", mode=mode)).cells.tolist() == [wanted]


# --- arrays


def test_an_array_is_taken_as_it_is(tmp_path: Path) -> None:
    cells = np.array([[-1, 0, 100], [50, 1, 99]], np.int8)
    for name, array in {"rows": cells, "columns": np.asfortranarray(cells)}.items():
        np.save(tmp_path / f"{name}.npy", array)
        grid = read_map(tmp_path / f"{name}.npy", resolution_m=0.2)
        assert grid.cells.tolist() == cells.tolist()
        assert grid.frame == Frame(2, 3, 0.2)


# --- resolution, origin, unknown


def test_the_frame_is_the_yamls(tmp_path: Path) -> None:
    write_pgm(tmp_path, [[0, 255, 255], [0, 0, 0]])
    grid = read_map(write_yaml(tmp_path, resolution="5e-2", origin="[-010.5, 2, 0]"))
    assert grid.frame == Frame(2, 3, 0.05, -10.5, 2.0, 0.0)
    # row 0 is the top: the map's lower left cell is the last row's first
    assert np.allclose(grid.frame.world_from_cell(np.array([[1, 0]])), [[-10.475, 2.025]])


def test_a_turned_map_keeps_its_yaw_with_a_warning(tmp_path: Path) -> None:
    write_pgm(tmp_path, [[0]])
    with pytest.warns(MapWarning, match=r"rotated by 3\.14 rad.*map\.yaml$"):
        assert read_map(write_yaml(tmp_path, origin="[25.9, 48.5, 3.14]")).frame.yaw_rad == 3.14


@pytest.mark.parametrize("word", ["nan", ".nan", ".NaN", "NAN"])
def test_a_yaw_of_nan_is_read_as_0_with_a_warning(tmp_path: Path, word: str) -> None:
    write_pgm(tmp_path, [[0]])
    with pytest.warns(MapWarning, match="yaw is nan, using 0"):
        assert read_map(write_yaml(tmp_path, origin=f"[0, 0, {word}]")).frame.yaw_rad == 0.0


def test_without_any_resolution_it_is_5_cm_with_a_warning(tmp_path: Path) -> None:
    np.save(tmp_path / "map.npy", np.zeros((1, 1), np.int8))
    for path in (write_pgm(tmp_path, [[255]]), tmp_path / "map.npy"):
        with pytest.warns(MapWarning, match=r"0\.05 m per cell \(--resolution") as caught:
            assert read_map(path).frame.resolution_m == 0.05
        assert caught[0].filename == __file__


def test_a_resolution_must_agree_with_the_yaml(tmp_path: Path) -> None:
    write_pgm(tmp_path, [[255]])
    path = write_yaml(tmp_path, resolution="0.0500000")
    assert read_map(path, resolution_m=0.05).frame.resolution_m == 0.05
    with pytest.raises(MapError, match=r"wanted 0\.1 m per cell as requested, found 0\.05 m: .*map\.yaml$"):
        read_map(path, resolution_m=0.1)


def test_unknown_cells_read_as_free_are_warned_of_and_can_be_kept_unknown(tmp_path: Path) -> None:
    write_pgm(tmp_path, [[0, 205, 205, 204, 254]])
    path = write_yaml(tmp_path, free_thresh="0.25")
    with pytest.warns(MapWarning, match=r"205.* is read as free in 2 cells .*--unknown-value 205"):
        assert read_map(path).cells.tolist() == [[100, 0, 0, 0, 0]]
    assert read_map(path, unknown_value=205).cells.tolist() == [[100, -1, -1, 0, 0]]


@pytest.mark.parametrize(("edited", "unknown"), [(0, True), (1, True), (2, False)])
def test_grey_205_of_a_saved_map_is_unknown_whatever_its_threshold(tmp_path: Path, edited: int, unknown: bool) -> None:
    write_pgm(tmp_path, [[0, 205, 205, *[254] * (7 - edited), *[128] * edited]])
    path = write_yaml(tmp_path, free_thresh="0.25")
    read_as = "unknown in 2 cells despite free_thresh 0.25 .*--unknown-value none" if unknown else "free in 2 cells"
    with pytest.warns(MapWarning, match=f"205.* is read as {read_as}") as notes:
        assert read_map(path).cells[0, 1:3].tolist() == [-1 if unknown else 0] * 2
    assert len(notes) == 1


def test_the_threshold_decides_if_the_user_says_so_and_in_scale_mode(tmp_path: Path) -> None:
    write_pgm(tmp_path, [[0, 205, 254]])
    with pytest.warns(MapWarning, match="is read as free in 1 cells"):
        assert read_map(write_yaml(tmp_path, free_thresh="0.25"), unknown_value="none").cells.tolist() == [[100, 0, 0]]
    with pytest.warns(MapWarning, match="is read as free in 1 cells in mode scale"):
        assert read_map(write_yaml(tmp_path, free_thresh="0.25", mode="scale")).cells.tolist() == [[100, 0, 0]]


def test_scale_rounds_grey_205_down_to_free_and_is_warned_of(tmp_path: Path) -> None:
    with pytest.warns(MapWarning, match="is read as free in 1 cells in mode scale with free_thresh 0.196"):
        assert cells_of(tmp_path, [[205]], mode="scale") == [[0]]


def test_the_unknown_value_beats_occupied_and_raw(tmp_path: Path) -> None:
    path = write_pgm(tmp_path, [[0, 50, 254]])
    assert read_map(path, resolution_m=0.05, unknown_value=50).cells.tolist() == [[100, -1, 0]]
    assert read_map(write_yaml(tmp_path, mode="raw"), unknown_value=50).cells.tolist() == [[0, -1, -1]]


# --- files


def test_the_image_is_found_relative_to_the_yaml_or_absolutely(tmp_path: Path) -> None:
    maps, images = tmp_path / "maps", tmp_path / "images"
    maps.mkdir()
    images.mkdir()
    image = write_pgm(images, [[0, 255]])
    for named in ("../images/map.pgm", str(image)):
        grid = read_map(write_yaml(maps, image=named))
        assert grid.cells.tolist() == [[100, 0]]
        assert [name for name, _ in grid.source.files] == ["map.yaml", "map.pgm"]


@pytest.mark.parametrize("name", ["map.yaml", "map.pgm", "map.npy"])
def test_a_source_alone_gives_the_same_grid_again(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    write_pgm(tmp_path, [[0, 205, 254]])
    write_yaml(tmp_path, image=str(tmp_path / "map.pgm"), free_thresh="0.25")
    np.save(tmp_path / "map.npy", np.array([[0, 100]], np.int8))
    options: dict[str, Any] = {"resolution_m": 0.05} | ({} if name == "map.npy" else {"unknown_value": 205})
    grid = read_map(path, **options)
    assert grid.source.options == options
    for file in tmp_path.iterdir():
        file.unlink()
    again = read_source(grid.source)
    assert equal(grid, again)
    assert again.source == grid.source


def test_every_suffix_has_one_reader() -> None:
    suffixes = [suffix for reader in READERS for suffix in reader.suffixes]
    assert len(suffixes) == len(set(suffixes))
