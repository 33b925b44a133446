"""Corrupted files of every format give a result or one clear line, within ten seconds and a gigabyte.

A sample runs in CI; all of it: ``STRESS=1 pytest tests/stress/test_corruptions.py -n 0``.
"""

from __future__ import annotations

import resource
import shutil
import warnings
from collections.abc import Callable
from pathlib import Path

import finished_maps
import pytest
from small_recording import small
from stress import Findings, corrupted, count, limited
from whole_maps import MAPS

from vdoor.editing.edits import read_edits
from vdoor.errors import MapWarning, VdoorError
from vdoor.formats import read_map
from vdoor.pipeline import RECORDS, emitted
from vdoor.recording.check import check
from vdoor.recording.mcap import read_recording
from vdoor.recording.recover import recover
from vdoor.results import reading

CASES = count(200, 10_000)
OF_RECORDINGS = count(20, 10_000)
"""Each of these reads all stages."""
OTHERS: dict[str, Callable[[Path], object]] = {
    "check": lambda path: check(path, types=RECORDS, emits=emitted),
    "read": lambda path: list(read_recording(path, types=RECORDS)),
    "recover": lambda path: recover(path, path.with_name("out.mcap"), types=RECORDS, emits=emitted),
}


def survives(path: Path, read: Callable[[Path], object]) -> str:
    """Read a file; give the error's text, which is one line that ends with a path."""
    try:
        with limited(), warnings.catch_warnings():
            warnings.simplefilter("ignore", MapWarning)
            read(path)
    except VdoorError as error:
        text = str(error)
    else:
        return ""
    assert len(text.splitlines()) == 1
    assert str(path.parent) in text
    return text


def peak_kb() -> int:
    """The most memory that this process has had."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def try_all(path: Path, whole: bytes, read: Callable[[Path], object], cases: int = CASES) -> None:
    """Claim that corruptions survive, within a gigabyte, and that some are refused and some are not."""
    before_kb = peak_kb()  # of the tests that this process ran before
    path.write_bytes(whole)
    assert survives(path, read) == ""
    refused, findings = 0, Findings()
    for seed in range(cases):
        path.write_bytes(corrupted(whole, seed))
        with findings.of(f"seed {seed}"):
            refused += bool(survives(path, read))
    findings.claim_none()
    assert refused > 0
    assert peak_kb() < before_kb + 1_000_000


@pytest.mark.parametrize("name", MAPS)
def test_corrupted_maps(name: str, tmp_path: Path) -> None:
    whole = MAPS[name](tmp_path)
    (tmp_path / "beside.pgm").write_bytes(MAPS["map.pgm"](tmp_path))
    try_all(tmp_path / name, whole, read_map)


@pytest.mark.parametrize("name", OTHERS)
def test_corrupted_recordings(name: str, tmp_path: Path) -> None:
    whole = small(tmp_path / "whole.mcap").read_bytes()
    path = tmp_path / "a.mcap"
    path.write_bytes(whole)
    OTHERS[name](path)
    before_kb, findings = peak_kb(), Findings()
    for seed in range(OF_RECORDINGS):
        path.write_bytes(corrupted(whole, seed))
        with findings.of(f"seed {seed}"):
            survives(path, OTHERS[name])
    findings.claim_none()
    assert peak_kb() < before_kb + 1_000_000


def test_corrupted_edits(tmp_path: Path) -> None:
    whole = b'[[edit]]\ndo = "name"\nat = [1.0, 2.0]\nname = "Hall"\n\n[[edit]]\ndo = "number"\nat = [1, 2]\nid = 3\n'
    try_all(tmp_path / "edits.toml", whole, read_edits)


@pytest.mark.parametrize("name", ["map.json", "rooms.png", "grid.png"])
def test_corrupted_results(name: str, tmp_path: Path) -> None:
    folder = finished_maps.result("one room", tmp_path / "r")
    whole = (folder / name).read_bytes()

    def read(path: Path) -> object:
        shutil.copy(path, folder / name)
        return reading.read_finished(folder, provenance=True)

    try_all(tmp_path / name, whole, read, OF_RECORDINGS)
