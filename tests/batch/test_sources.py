"""Which maps a batch has: folders, globs, lists, manifests and URLs name the same maps in the same way."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from pathlib import Path

import finished_maps
import fsspec
import numpy as np
import pyarrow as pa
import pytest
from commands import process
from pyarrow import csv, parquet

from vdoor.batch.job import Recipe, done
from vdoor.batch.sources import Item, items_of, maps_among
from vdoor.errors import VdoorError
from vdoor.experiments.cases import map_files
from vdoor.goldens import MAPS
from vdoor.results.writing import map_server_yaml


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A map as YAML with its image and a truth, and another as .npy."""
    grid = MAPS["one-room"].make()
    name, data = grid.source.files[0]
    (tmp_path / name).write_bytes(data)
    (tmp_path / "map.yaml").write_bytes(map_server_yaml(grid, name, mode="trinary"))
    np.save(tmp_path / "map_truth.npy", grid.free.astype(np.int32))
    np.save(tmp_path / "other.npy", finished_maps.house(2, (1, 2, 4)))
    (tmp_path / "notes.md").write_text("no map")
    return tmp_path


def names(sources: list[str]) -> list[str]:
    return [Path(item.map).name for item in items_of(sources)]


def test_names_that_are_maps() -> None:
    found = ["a/m.pgm", "a/m.yaml", "a/m_truth.png", "a/m_truth.json", "a/n.png", "a/read.me", "b/m.pgm"]
    assert maps_among(found) == ["a/m.yaml", "a/n.png", "b/m.pgm"]


def test_folders_globs_lists_and_urls_find_the_same_maps(folder: Path) -> None:
    wanted = ["map.yaml", "other.npy"]
    (folder / "list.txt").write_text("# maps\nmap.yaml\n\nother.npy\n")
    assert names([str(folder)]) == wanted
    assert names([f"{folder}/*.*"]) == wanted
    assert names([str(folder / "list.txt")]) == wanted
    assert names([f"file://{folder}"]) == wanted
    assert names([f"file://{folder}/*.npy"]) == ["other.npy"]
    assert names([str(folder), str(folder / "map.yaml")]) == wanted


def test_a_truth_beside_a_map_is_its_reference(folder: Path) -> None:
    (folder / "other_truth.json").write_text("{}")
    assert [Path(item.reference).name for item in items_of([str(folder)])] == ["", "other_truth.json"]


def test_a_manifest_says_more_of_each_map(folder: Path) -> None:
    table = pa.table({
        "map": ["map.yaml", "other.npy"], "resolution_m": [None, 0.2], "robot_x_m": [None, 0.5],
        "robot_y_m": [None, 0.7], "reference": [None, "other.npy"], "site": ["a", "b"],
    })  # fmt: skip
    parquet.write_table(table, folder / "all.parquet")
    csv.write_csv(table, folder / "all.csv")
    wanted = [
        Item(f"{folder}/map.yaml"),
        Item(f"{folder}/other.npy", f"{folder}/other.npy", resolution_m=0.2, robot_x_m=0.5, robot_y_m=0.7),
    ]
    assert items_of([str(folder / "all.parquet")]) == wanted
    assert items_of([str(folder / "all.csv")]) == wanted


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("file\nm.npy\n", "wanted a column map, found file"),
        ("map,resolution_m\nm.npy,fine\n", "wanted numbers for m.npy, found others"),
        ("map,robot_x_m\nm.npy,1\n", "wanted both robot_x_m and robot_y_m"),
        ("map,reference\n,x\n", "wanted a map in every row"),
        ("", "wanted a table, found a damaged one"),
    ],
)
def test_a_bad_manifest_is_named(text: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "all.csv").write_text(text)
    with pytest.raises(VdoorError, match=rf"{said}.*all\.csv$"):
        items_of([str(tmp_path / "all.csv")])


def test_the_robots_place_of_a_manifest_is_the_setting(folder: Path, tmp_path: Path) -> None:
    recipe = Recipe(batch=tmp_path / "out", preset="paper")
    item = Item(str(folder / "other.npy"), resolution_m=0.2, robot_x_m=-50.0, robot_y_m=0.0)
    assert done(item, recipe)["error"].startswith("robot at -50,0: wanted a free cell")


@pytest.mark.parametrize("scheme", ["file", "memory"])
def test_a_map_at_a_url_is_the_map_here(scheme: str, folder: Path, tmp_path: Path) -> None:
    root = f"{scheme}://{tmp_path}/there"
    for path in folder.glob("map.*"):
        with (
            fsspec.open(f"{root}/{path.name}", "wb", auto_mkdir=True)
            if scheme == "file"
            else fsspec.open(f"{root}/{path.name}", "wb") as file
        ):
            file.write(path.read_bytes())
    (item,) = items_of([root])
    rows = [done(one, Recipe(batch=tmp_path / "out", preset="paper")) for one in (item, Item(str(folder / "map.yaml")))]
    assert rows[0]["key"] == rows[1]["key"]
    assert rows[0]["rooms"] == 1
    assert done(Item(f"{root}/none.npy"), Recipe(batch=tmp_path / "out"))["error"].endswith(f"{root}/none.npy")


def test_maps_on_a_server_that_speaks_s3(folder: Path, tmp_path: Path) -> None:
    pytest.importorskip("moto", reason="no server that speaks S3: the package moto is missing")
    pytest.importorskip("s3fs")
    with socket.create_server(("127.0.0.1", 0)) as free:
        address = f"http://127.0.0.1:{free.getsockname()[1]}"
    host, port = address.removeprefix("http://").split(":")
    words = [sys.executable, "-m", "moto.server", "-H", host, "-p", port]
    with subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as server:
        try:
            put(f"{address}/maps", b"")
            for path in folder.glob("map.*"):
                put(f"{address}/maps/site/{path.name}", path.read_bytes())
            keys = {"AWS_ENDPOINT_URL": address, "AWS_ACCESS_KEY_ID": "any", "AWS_SECRET_ACCESS_KEY": "any"}
            asked = ("batch", "s3://maps/site", "--out", tmp_path / "out", "-j", "1", "--preset", "paper")
            told = process(*asked, env=keys | {"AWS_DEFAULT_REGION": "us-east-1"})
        finally:
            server.kill()
    assert told.stdout.split()[:2] == ["1", "rooms"]
    (row,) = parquet.read_table(tmp_path / "out" / "table.parquet").to_pylist()
    assert row["map"] == "s3://maps/site/map.yaml"
    assert row["key"] == done(Item(str(folder / "map.yaml")), Recipe(batch=tmp_path / "here", preset="paper"))["key"]


def put(url: str, data: bytes) -> None:
    """Give a server a bucket or an object; wait for it to start."""
    plain = {"Content-Type": "application/octet-stream"}  # as a form, which urllib says, the server never answers
    request = urllib.request.Request(url, data=data, method="PUT", headers=plain)  # noqa: S310  # on loopback
    for _ in range(100):
        try:
            urllib.request.urlopen(request, timeout=20).close()  # noqa: S310
        except ConnectionError:
            time.sleep(0.1)
        except urllib.error.URLError as error:
            if not isinstance(error.reason, ConnectionError):
                raise
            time.sleep(0.1)
        else:
            return
    raise AssertionError(f"no server: {url}")


def test_a_pipe_as_a_list_or_manifest_is_refused_at_once(tmp_path: Path) -> None:
    for name in ("list.txt", "all.csv"):
        os.mkfifo(tmp_path / name)
        with pytest.raises(VdoorError, match=rf"wanted a list of maps, found a device or pipe.*{name}$"):
            items_of([str(tmp_path / name)])


def test_every_command_finds_the_same_maps_in_a_folder(folder: Path) -> None:
    for name in ("truth.json", "map_gt_segmentation.png"):
        (folder / name).write_bytes(b"")
    assert [path.name for path in map_files(folder)] == names([str(folder)]) == ["map.yaml", "other.npy"]
