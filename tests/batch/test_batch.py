"""`vdoor batch`: results of many maps are those of single runs, whatever happens to one of them."""

from __future__ import annotations

import io
import json
import shutil
import subprocess
import time
from pathlib import Path
from typing import Any

import finished_maps
import numpy as np
import pytest
from commands import Command, call, one_line
from project import VDOOR
from pyarrow import parquet

from vdoor.batch.job import MEASURED, Recipe, done, rows_of
from vdoor.batch.sources import Item
from vdoor.batch.store import StoreError
from vdoor.batch.table import table_of
from vdoor.config import DEFAULT_PRESET
from vdoor.engines import Limits, dask, processes
from vdoor.engines.loopback import loopback_cluster
from vdoor.errors import VdoorError
from vdoor.synth import PRESETS, synthesize, write_synthetic

OPTIONS = ("--preset", "paper", "--resolution", "0.2")
READ = {"resolution_m": 0.2}


def maps(folder: Path, count: int) -> list[Path]:
    """Houses of two rooms with a door, each in another row, as .npy."""
    folder.mkdir()
    paths = [folder / f"house{number}.npy" for number in range(count)]
    for number, path in enumerate(paths):
        np.save(path, finished_maps.house(2, (1, number, 4)))
    return paths


def recipe(out: Path, **changed: Any) -> Recipe:
    return Recipe(batch=out, preset="paper", options=READ, **changed)


def files(folder: Path) -> dict[str, bytes]:
    """All files below a folder, by their path in it."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def same(table: Any) -> list[dict[str, Any]]:
    """The rows of a table without what differs from run to run."""
    rows: list[dict[str, Any]] = table.drop_columns(list(MEASURED)).to_pylist()
    return rows


def test_a_batch_is_its_single_runs_and_a_bad_map_stops_nothing(tmp_path: Path) -> None:
    paths = maps(tmp_path / "maps", 3)
    (tmp_path / "maps" / "bad.npy").write_bytes(b"no map")
    out = tmp_path / "all"
    words = ("batch", tmp_path / "maps", "--out", out, "-j", "2", *OPTIONS)
    told = call(*words, code=1)
    assert len(told.stdout.splitlines()) == 4
    assert "1 of 4 maps failed" in told.stderr
    call("run", paths[1], "--out", tmp_path / "one", *OPTIONS)
    rows = {Path(row["map"]).name: row for row in parquet.read_table(out / "table.parquet").to_pylist()}
    assert {name: (row["rooms"], row["error_kind"]) for name, row in rows.items()} == {
        "bad.npy": (None, "MapError"),
        **{path.name: (2, None) for path in paths},
    }
    assert all(row["cpu_s"] > 0 and row["peak_mb"] > 20 for name, row in rows.items() if name != "bad.npy")
    made, alone = files(out / rows["house1.npy"]["folder"]), files(tmp_path / "one")
    times = {name: json.loads(text.pop("map.json")) for name, text in (("batch", made), ("run", alone))}
    assert made == alone
    assert times["batch"].pop("timings_s") == {}
    assert times["run"].pop("timings_s")
    assert times["batch"] == times["run"]
    assert (out / "index.html").read_text().count("<img") == 3
    before, sheet = files(out / "results") | files(out / "rows"), (out / "index.csv").read_bytes()
    stamps = {path: path.stat().st_mtime_ns for path in out.glob("results/*/*/map.json")}
    shutil.rmtree(out / rows["house2.npy"]["folder"])
    call(*words, code=1)
    again = {path for path in stamps if path.stat().st_mtime_ns != stamps[path]}
    assert [path.parent.name.partition("-")[0] for path in again] == ["house2"]
    assert {name for name, text in (files(out / "results") | files(out / "rows")).items() if before[name] != text} <= {
        name for name in before if "house2" in name and name.startswith(rows["house2.npy"]["key"][:2])
    }
    assert (out / "index.csv").read_bytes() == sheet
    call(*words, "--seed", "1", code=1)
    assert len([*out.glob("results/*/*/map.json")]) == 6


def test_order_and_engine_do_not_matter(tmp_path: Path) -> None:
    items = [Item(str(path)) for path in maps(tmp_path / "maps", 5)]
    rows = {name: recipe(tmp_path / name) for name in ("one", "two", "cluster")}
    tables = {
        "one": table_of(rows_of(items, rows["one"], processes, Limits(workers=1))),
        "two": table_of(rows_of(items[::-1], rows["two"], processes, Limits(workers=2))),
    }
    with loopback_cluster(tmp_path) as there:
        found = rows_of(items, rows["cluster"], dask, Limits(scheduler=there.address))
        tables["cluster"] = table_of(found)
    wanted = same(tables["one"])
    assert [row["rooms"] for row in wanted] == [2] * 5
    assert all(same(table) == wanted for table in tables.values())
    results = [files(tmp_path / name / "results") for name in rows]
    assert results[0] == results[1] == results[2]
    assert len(results[0]) == 4 * 5


def test_a_batch_that_was_killed_goes_on(tmp_path: Path) -> None:
    count = 12
    paths, out = maps(tmp_path / "maps", count), tmp_path / "out"
    words = [VDOOR, "batch", *paths, "--out", out, "-j", "1", *OPTIONS]
    with subprocess.Popen(list(map(str, words)), stdout=subprocess.PIPE, stderr=subprocess.PIPE) as first:
        assert first.stdout is not None
        first.stdout.readline()
        first.kill()
    time.sleep(0.5)
    whole = {path: path.stat().st_mtime_ns for path in out.glob("results/*/*/map.json")}
    assert 1 <= len(whole) < count
    assert not (out / "table.parquet").exists()
    call(*words[1:])
    assert {path: path.stat().st_mtime_ns for path in whole} == whole
    assert [row["rooms"] for row in parquet.read_table(out / "table.parquet").to_pylist()] == [2] * count


def test_a_full_disk_stops_the_batch_and_leaves_nothing_that_counts(tmp_path: Path) -> None:
    items = [Item(str(path)) for path in maps(tmp_path / "maps", 2)]
    disk = tmp_path / "disk"
    disk.mkdir()
    if subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=8k", "none", disk], check=False, capture_output=True
    ).returncode:
        pytest.skip("no small disk: mounting one takes root")
    try:
        assert done(items[0], recipe(disk))["error_kind"] == StoreError.__name__
        with pytest.raises(VdoorError, match=r"cannot be written \(No space left on device\).*same command goes on$"):
            list(rows_of(items, recipe(disk), processes, Limits()))
        assert [*disk.glob("results/*/*")] == []
        assert [*disk.glob("partial/*")] == []
        subprocess.run(["mount", "-o", "remount,size=4M", disk], check=True)
        assert [row["rooms"] for row in rows_of(items, recipe(disk), processes, Limits())] == [2, 2]
    finally:
        subprocess.run(["umount", disk], check=True)


def test_a_map_with_a_truth_is_measured_and_the_report_shows_the_worst(tmp_path: Path, command: Command) -> None:
    for seed in (1, 5):
        made = synthesize(PRESETS["home"], np.random.default_rng(seed))
        write_synthetic(made, tmp_path / "maps" / f"home{seed}", seed=seed)
    out = tmp_path / "out"
    rows = [done(item, Recipe(batch=out)) for item in map(Item, sorted(map(str, (tmp_path / "maps").glob("*.yaml"))))]
    assert "door_f1" not in rows[0]
    call("batch", tmp_path / "maps", "--out", out, "-j", "1")
    found = parquet.read_table(out / "table.parquet").to_pylist()
    told = command("evaluate", out, "--reference", tmp_path / "maps", "--json").json
    assert {Path(row["map"]).stem: row["door_f1"] for row in found} == {
        one["name"].partition("-")[0]: one["figures"]["door_f1"] for one in told["maps"]
    }
    assert found[0]["cpu_s"] == rows[0]["cpu_s"]
    page = (out / "index.html").read_text()
    assert "Worst by door F1" in page
    (out / "index.html").unlink()
    assert command("batch", "report", out).code == 0
    assert (out / "index.html").read_text() == page


def test_wrong_use_is_one_line(tmp_path: Path, command: Command) -> None:
    (path,) = maps(tmp_path / "maps", 1)
    for words, said in {
        (path,): "batch: wanted --out DIR, found none",
        (path, "--out", tmp_path, "--engine", "dusk"): "--engine: no engine 'dusk'; did you mean 'dask'?",
        (path, "--out", tmp_path, "--engine", "dask"): "wanted --scheduler with it",
        ("report", tmp_path): "wanted a batch's folder with table.parquet, found none",
        (tmp_path, "--out", tmp_path): "batch: wanted maps, found none",
    }.items():
        told = command("batch", *words)
        assert told.code == 2
        assert said in one_line(told)


def test_a_worker_of_another_version_is_refused(tmp_path: Path) -> None:
    row = done(Item("m.npy"), recipe(tmp_path, version="0.0.0"))
    assert row["error"].startswith("worker: wanted vdoor 0.0.0 as where the batch runs, found ")
    assert Recipe(batch=tmp_path).preset == DEFAULT_PRESET


def test_names_that_are_no_utf_8_are_told_with_a_mark(tmp_path: Path, command: Command) -> None:
    (bad,) = maps(tmp_path / "maps", 1)
    bad = bad.rename(bad.with_name("h\udcff.npy"))
    out = tmp_path / "b\udcff"
    done = command("batch", bad, "--out", out, "-j", "1", *OPTIONS)
    assert done.code == 0, done.err
    assert parquet.read_table(io.BytesIO((out / "table.parquet").read_bytes()))["map"].to_pylist()[0].endswith("h�.npy")
