"""Runs that are killed, that race for the same outputs, or whose disk fills: nothing half under a final name.

A sample runs in CI; all of it: ``STRESS=1 pytest tests/stress/test_kills_races_full_disks.py -n 0``.
"""

from __future__ import annotations

import contextlib
import hashlib
import itertools
import json
import multiprocessing
import os
import resource
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from unittest import mock

import finished_maps
import pytest
from PIL import Image
from project import HOME, VDOOR
from stress import count

from vdoor.api import run_info, run_prepared
from vdoor.cli import main
from vdoor.emit import Recorder
from vdoor.errors import VdoorError
from vdoor.evaluate.division import MapChoice, read_division
from vdoor.outputs import Outputs, opened
from vdoor.pipeline import RECORDS, emitted, preset_named
from vdoor.record import Record
from vdoor.recording.check import check
from vdoor.recording.mcap import read_recording
from vdoor.recording.recover import recover
from vdoor.results import writing
from vdoor.results.reading import read_finished

KILLS, RACES, SIZES = count(6, 300), count(3, 100), count(2, 100)
pytestmark = pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")
FORK = multiprocessing.get_context("fork")
MAP = HOME / "recordings" / "flat.yaml"


def in_a_process(work: Callable[[], None]) -> int:
    """Do some work in a process of its own; give its exit code, less than zero for a signal."""
    child = FORK.Process(target=work)
    child.start()
    child.join(60)
    assert child.exitcode is not None, "still running after a minute"
    return child.exitcode


class KillerSink:
    """A sink behind all others that kills the process at a record."""

    def __init__(self, step: int) -> None:
        self._step = step

    def write(self, step: int, record: Record) -> None:
        del record
        if step == self._step:
            os.kill(os.getpid(), signal.SIGKILL)

    def close(self) -> None:
        pass


def recorded_until(folder: Path, step: int) -> None:
    grid, pipeline = finished_maps.grid("one room"), preset_named("paper")
    with opened(Outputs(mcap=folder / "a.mcap"), run_info(grid, "paper", pipeline, 0)) as run:
        run_prepared(grid, pipeline, emit=Recorder([*run.sinks, KillerSink(step)]))


def test_every_stage_before_a_kill_comes_back(tmp_path: Path) -> None:
    whole = tmp_path / "whole"
    whole.mkdir()
    recorded_until(whole, -1)
    topics = [record.topic for _, record in read_recording(whole / "a.mcap", types=RECORDS)]
    for number in range(KILLS):
        folder = tmp_path / str(number)
        folder.mkdir()
        step = number * len(topics) // KILLS  # placed by stage, from the first to the last
        assert in_a_process(lambda at=folder, step=step: recorded_until(at, step)) == -signal.SIGKILL
        assert [path.name for path in folder.iterdir()] == ["a.mcap.partial"]
        found = recover(folder / "a.mcap.partial", folder / "a.mcap", types=RECORDS, emits=emitted)
        assert sum(found.records.values()) == step + 1
        back = [record.topic for _, record in read_recording(folder / "a.mcap", types=RECORDS)]
        assert back == topics[: step + 1]
        shutil.rmtree(folder)


@pytest.mark.parametrize("renamed", range(5))
def test_a_result_is_never_made_of_two(renamed: int, tmp_path: Path) -> None:
    folder = finished_maps.result("one room", tmp_path / "r")
    before = read_finished(folder).topology
    replaced = Path.replace

    def replace(number: Iterator[int]) -> Callable[[Path, Path], Path]:
        def counted(one: Path, other: Path) -> Path:
            if next(number) == renamed:
                os.kill(os.getpid(), signal.SIGKILL)
            return replaced(one, other)

        return counted

    def work() -> None:
        with mock.patch.object(Path, "replace", replace(itertools.count())):
            finished_maps.result("flat", folder)

    assert in_a_process(work) == (-signal.SIGKILL if renamed < len(writing.NAMES) else 0)
    found = read_finished(folder, provenance=True).topology
    assert len(found.rooms) == (len(before.rooms) if renamed == 0 else len(finished_maps.topology("flat").rooms))


@pytest.mark.parametrize("name", ["rooms.png", "grid.png"])
def test_a_file_of_another_run_is_refused(name: str, tmp_path: Path) -> None:
    folder, other = (finished_maps.result(drawing, tmp_path / drawing) for drawing in ("one room", "flat"))
    (folder / name).write_bytes((other / name).read_bytes())
    with pytest.raises(VdoorError, match=f"wanted .*, found .*{folder}"):
        read_finished(folder, provenance=True)
    shutil.copy(finished_maps.result("one room", tmp_path / "again") / name, folder / name)
    image = Image.open(folder / name)
    image.putpixel((0, 0), 1 if name == "rooms.png" else 254)
    image.save(folder / name)  # of the same size, and read as it is without the checksums
    with pytest.raises(VdoorError, match=f"{name}: wanted the file that map.json was written with, found another"):
        read_finished(folder, provenance=True)
    with pytest.raises(VdoorError, match=f"{name}: wanted the file that map.json was written with, found another"):
        read_division("one room", folder, MapChoice())


def command_of(words: list[str]) -> Callable[[], None]:
    def work() -> None:
        with (Path(os.devnull)).open("w") as nowhere, contextlib.redirect_stdout(nowhere):
            sys.argv = ["vdoor", *words]
            main()

    return work


@pytest.mark.parametrize("writers", [2, 8])
@pytest.mark.parametrize("force", [False, True])
def test_one_of_several_writers_wins(writers: int, tmp_path: Path, *, force: bool) -> None:
    for number in range(max(1, RACES // 4)):
        folder = tmp_path / str(number)
        folder.mkdir()
        outputs = ["--mcap", f"{folder}/a.mcap", "--out", f"{folder}/o", "--export", f"svg={folder}/s.svg"]
        words = ["run", str(MAP), "-q", "--preset", "paper", *outputs, *(["--force"] if force else [])]
        children = [FORK.Process(target=command_of([*words, "--seed", str(seed)])) for seed in range(writers)]
        for child in children:
            child.start()
        for child in children:
            child.join(120)
        codes = sorted(child.exitcode if child.exitcode is not None else 99 for child in children)
        assert set(codes) <= {0, 2}
        assert codes[0] == 0
        assert force or codes.count(0) == 1
        assert check(folder / "a.mcap", types=RECORDS, emits=emitted).whole
        info = read_recording(folder / "a.mcap", types=RECORDS).info
        assert json.loads((folder / "o" / "map.json").read_text())["seed"] == info.seed  # one run's, all of it
        read_finished(folder / "o", provenance=True)
        assert not list(folder.rglob("*.partial"))
        shutil.rmtree(folder)


@contextlib.contextmanager
def small_disk(place: Path, size: int) -> Iterator[dict[str, int]]:
    """A file system of a size, if one may be mounted; else a limit for the size of a file."""
    place.mkdir(exist_ok=True)
    mounted = not subprocess.run(
        ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(place)], check=False, capture_output=True
    ).returncode
    try:
        yield {} if mounted else {"fsize": size}
    finally:
        if mounted:
            subprocess.run(["umount", str(place)], check=True)


def digests(folder: Path) -> dict[str, str]:
    files = (path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def test_a_full_disk_leaves_what_was_there(tmp_path: Path) -> None:
    disk = tmp_path / "disk"
    outputs = ["--mcap", f"{disk}/a.mcap", "--save", f"{disk}/a.rrd", "--out", f"{disk}/o"]
    words = [VDOOR, "run", MAP, "-q", "--preset", "paper", *outputs, "--force"]
    codes = set()
    for number in range(SIZES):
        size = 100_000 + 10_000 * (number if SIZES > 2 else number * 60)
        with small_disk(disk, size) as limits:
            for name in ("a.mcap", "a.rrd"):
                (disk / name).write_text("older")
            finished_maps.result("one room", disk / "o")
            before = digests(disk)
            limit = (lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))) if limits else None  # noqa: B023
            done = subprocess.run(words, check=False, capture_output=True, text=True, timeout=120, preexec_fn=limit)
            codes.add(done.returncode)
            if done.returncode:
                assert done.returncode == 2
                assert len(done.stderr.splitlines()) == 1, done.stderr
                assert digests(disk) == before
            else:
                assert check(disk / "a.mcap", types=RECORDS, emits=emitted).whole
                assert not list(disk.rglob("*.partial"))
            for path in disk.iterdir():
                shutil.rmtree(path) if path.is_dir() else path.unlink()
    assert 2 in codes
