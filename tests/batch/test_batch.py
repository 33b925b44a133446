"""`vdoor batch`: results of many maps are those of single runs, whatever happens to one of them."""

from __future__ import annotations

import csv
import json
import shutil
import subprocess
import sys
import time
from pathlib import Path

import finished_maps
import numpy as np
import pytest
from killed_jobs import die_at_first

from vdoor.batch.engine import jobs_of, outcomes
from vdoor.batch.job import Job
from vdoor.errors import VdoorError

VDOOR = Path(sys.executable).parent / "vdoor"


def maps(folder: Path, count: int) -> list[Path]:
    """Houses of two rooms with a door, each in another row, as .npy."""
    folder.mkdir()
    paths = [folder / f"house{number}.npy" for number in range(count)]
    for number, path in enumerate(paths):
        np.save(path, finished_maps.house(2, (1, number, 4)))
    return paths


def files(folder: Path) -> dict[str, bytes]:
    """The files of a result; map.json without its times."""
    found = {path.name: path.read_bytes() for path in folder.iterdir()}
    return found | {"map.json": json.dumps(json.loads(found["map.json"]) | {"timings_s": 0}).encode()}


def call(*words: str | Path, code: int = 0) -> subprocess.CompletedProcess[str]:
    done = subprocess.run([VDOOR, *map(str, words)], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == code, done.stderr
    return done


def test_a_batch_is_its_single_runs_and_a_bad_map_stops_nothing(tmp_path: Path) -> None:
    paths = maps(tmp_path / "maps", 3)
    (tmp_path / "maps" / "bad.npy").write_bytes(b"no map")
    options = ("--preset", "paper", "--resolution", "0.2")
    words = ("batch", tmp_path / "maps", "--out", tmp_path / "all", "-j", "2", *options)
    told = call(*words, code=1)
    assert len(told.stdout.splitlines()) == 4
    assert "1 of 4 maps failed" in told.stderr
    assert "Traceback" not in told.stderr
    call("run", paths[1], "--out", tmp_path / "one", *options)
    assert files(tmp_path / "all" / "house1") == files(tmp_path / "one")
    with (tmp_path / "all" / "index.csv").open() as stream:
        rows = {Path(row["map"]).name: row for row in csv.DictReader(stream)}
    assert {name: (row["rooms"], bool(row["error"])) for name, row in rows.items()} == {
        "bad.npy": ("", True),
        **{path.name: ("2", False) for path in paths},
    }
    assert (tmp_path / "all" / "index.html").read_text().count("<img") == 3
    times = {path: path.stat().st_mtime_ns for path in (tmp_path / "all").glob("house*/map.json")}
    index = (tmp_path / "all" / "index.csv").read_bytes()
    shutil.rmtree(tmp_path / "all" / "house2")
    call(*words, code=1)
    after = {path: path.stat().st_mtime_ns for path in times}
    assert {path.parent.name for path in times if times[path] != after[path]} == {"house2"}
    assert (tmp_path / "all" / "index.csv").read_bytes() == index
    assert "made with other settings" in call(*words, "--seed", "1", code=1).stdout


def test_a_process_that_is_killed_costs_its_own_map_alone(tmp_path: Path) -> None:
    pairs = jobs_of(maps(tmp_path / "maps", 2), tmp_path / "out")
    jobs = [Job(map_file=path, folder=folder, preset="paper", options={"resolution_m": 0.2}) for path, folder in pairs]
    found = {outcome.map_file.stem: outcome for outcome in outcomes(jobs, 1, die_at_first)}
    assert found["house0"].error == "its process ended with code -9"
    assert (found["house1"].rooms, found["house1"].error) == (2, "")


def test_a_batch_that_was_killed_goes_on(tmp_path: Path) -> None:
    count = 6
    paths, out = maps(tmp_path / "maps", count), tmp_path / "out"
    words = [VDOOR, "batch", *paths, "--out", out, "-j", "1", "--preset", "paper", "--resolution", "0.2"]
    with subprocess.Popen(list(map(str, words)), stdout=subprocess.PIPE, stderr=subprocess.PIPE) as first:
        assert first.stdout is not None
        first.stdout.readline()
        first.kill()
    time.sleep(1)
    whole = {path: path.stat().st_mtime_ns for path in out.glob("*/map.json")}
    assert 1 <= len(whole) < count
    call(*words[1:])
    assert {path: path.stat().st_mtime_ns for path in whole} == whole
    assert len([*out.glob("*/map.json")]) == count


def test_two_maps_of_one_name_and_a_folder_without_maps_are_refused(tmp_path: Path) -> None:
    with pytest.raises(VdoorError, match="wanted a name for each map"):
        jobs_of([Path("a/m.yaml"), Path("b/m.yaml")], tmp_path)
    with pytest.raises(VdoorError, match="wanted maps, found none"):
        jobs_of([tmp_path], tmp_path)
