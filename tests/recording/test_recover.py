"""`vdoor recover`: every stage that is whole comes back, what is lost is said, and nothing is called a success."""

from __future__ import annotations

import dataclasses
import os
import resource
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from commands import Command
from project import HOME, VDOOR
from recordings_by_hand import spans
from small_recording import read, small, small_run

from vdoor.files import partial_name
from vdoor.grid import Source
from vdoor.pipeline import RECORDS, emitted
from vdoor.record import Record, equal
from vdoor.recording import about
from vdoor.recording.check import check
from vdoor.recording.mcap import read_recording
from vdoor.recording.recover import Recovery, recover
from vdoor.recording.salvage import SIZE_AT
from vdoor.recording.scan import Budget, scan

HERE = HOME / "tests" / "support"


def recovered(path: Path) -> tuple[Recovery, dict[int, Record]]:
    """Give what came back of a file, by step: it is what was recorded, in a file that is whole but for the missing."""
    out = path.with_name("fixed.mcap")
    found = recover(path, out, types=RECORDS, emits=emitted)
    if not found.records:
        assert not out.exists()
        return found, {}
    health = check(out, types=RECORDS, emits=emitted)
    assert (health.damage, health.missing, health.records) == ((), found.missing, found.records)
    back = dict(read_recording(out, types=RECORDS))
    assert all(equal(record, small_run()[1][step]) for step, record in back.items())
    out.unlink()
    assert not list(path.parent.glob("*.partial"))
    return found, back


def test_a_whole_recording_comes_back_byte_by_byte(tmp_path: Path, command: Command) -> None:
    path = small(tmp_path / "small.mcap")
    done = command("recover", path, "-o", tmp_path / "fixed.mcap")
    assert (done.code, done.out.splitlines()[-1]) == (0, "nothing was lost")
    assert (tmp_path / "fixed.mcap").read_bytes() == path.read_bytes()


def test_of_80_flipped_bits_each_costs_at_most_the_stage_it_is_in(tmp_path: Path) -> None:
    path = small(tmp_path / "small.mcap")
    whole, chunks = path.read_bytes(), spans(path)
    rng = np.random.default_rng(0)
    steps = set(range(len(small_run()[1])))
    for _ in range(80):
        at, bit = int(rng.integers(len(whole))), 1 << int(rng.integers(8))
        damaged = bytearray(whole)
        damaged[at] ^= bit
        path.write_bytes(damaged)
        _, back = recovered(path)
        hit: set[int] = set().union(*(inside for begin, end, inside in chunks if begin <= at < end))
        assert steps - back.keys() <= hit, at


def test_a_chunk_that_claims_too_much_swallows_none_that_follow(tmp_path: Path) -> None:
    path = small(tmp_path / "small.mcap")
    whole, (begin, _, inside) = path.read_bytes(), spans(path)[6]
    steps = set(range(len(small_run()[1])))
    for bit in range(16):
        damaged = bytearray(whole)
        damaged[begin + SIZE_AT + bit // 8] ^= 1 << bit % 8
        path.write_bytes(damaged)
        assert steps - recovered(path)[1].keys() <= inside, bit


def test_two_damaged_places_cost_two_stages_and_bits_between_records_none(tmp_path: Path) -> None:
    path = small(tmp_path / "small.mcap")
    whole, chunks = bytearray(path.read_bytes()), spans(path)
    for begin, end, _ in (chunks[0], chunks[4]):
        whole[(begin + end) // 2 + 20] ^= 1
    whole[chunks[7][0]] ^= 64  # kind of a record
    whole[chunks[8][0] + 2] ^= 64  # its length
    path.write_bytes(whole)
    found, back = recovered(path)
    assert set(range(len(small_run()[1]))) - back.keys() == {0, 4}
    assert found.missing == ("input: no record", "candidates: no record")
    assert any("bytes that do not form a complete record" in text for text in found.damage)


def test_bytes_that_look_like_a_chunk_hide_none_that_is_one(tmp_path: Path) -> None:
    path = small(tmp_path / "small.mcap")
    whole, chunks = bytearray(path.read_bytes()), spans(path)
    begin, end, _ = chunks[4]
    whole[begin + 3] ^= 64  # no length to go by,
    decoy = b"\x04\x00\x00\x00zstd"
    for at in ((begin + end) // 2, end - 20):
        whole[at : at + len(decoy)] = decoy
    path.write_bytes(whole)
    assert set(range(len(small_run()[1]))) - recovered(path)[1].keys() == {4}


def test_a_file_cut_anywhere_gives_every_stage_before_the_cut(tmp_path: Path, command: Command) -> None:
    path = small(tmp_path / "small.mcap")
    whole, chunks = path.read_bytes(), spans(path)
    for percent in range(0, 100, 5):
        size = len(whole) * percent // 100
        path.write_bytes(whole[:size])
        complete = {step for _, end, inside in chunks if end <= size for step in inside}
        _, back = recovered(path)
        assert back.keys() == complete
        out = tmp_path / "out.mcap"
        done = command("recover", path, "-o", out)
        assert (done.code, out.exists()) == ((0, True) if complete else (1, False))
        if complete:
            assert "lost: " in done.out or size > chunks[-1][1]
            out.unlink()
        else:
            assert done.err == f"vdoor: recover: no record could be read, no file was written: {path}\n"


def test_without_its_settings_a_run_keeps_its_stages(tmp_path: Path, command: Command) -> None:
    path = small(tmp_path / "small.mcap")
    path.write_bytes(path.read_bytes().replace(b'"cell_m": 0.2', b'"cell_m": 0.3', 1))
    found, back = recovered(path)
    assert found.damage == ("preset, settings, seed and source files of the run",)
    assert len(back) == len(small_run()[1])
    command("recover", path, "-o", tmp_path / "fixed.mcap")
    assert read_recording(tmp_path / "fixed.mcap", types=RECORDS).info == about.LOST
    done = command("verify", tmp_path / "fixed.mcap")
    assert (done.code, "seed: wanted 0 or more, found -1" in done.err) == (2, True)


def attachment_end(path: Path) -> int:
    return next(end for _, end, record in scan(path, Budget.of(path)) if type(record).__name__ == "Attachment")


def test_without_its_map_file_a_run_can_still_be_verified(tmp_path: Path, command: Command) -> None:
    path = small(tmp_path / "small.mcap")
    whole, end = bytearray(path.read_bytes()), attachment_end(path)
    whole[end - 10] ^= 1
    path.write_bytes(whole)
    found, back = recovered(path)
    assert found.damage == ("source files: map.pgm",)
    assert len(back) == len(small_run()[1])
    command("recover", path, "-o", tmp_path / "fixed.mcap")
    run = read_recording(tmp_path / "fixed.mcap", types=RECORDS).info
    assert run == dataclasses.replace(small_run()[0], source=Source(options=run.source.options))
    assert command("verify", tmp_path / "fixed.mcap").code == 0


def test_what_is_no_recording_gives_no_file(tmp_path: Path, command: Command) -> None:
    for content in (b"", b"text", bytes(1000), os.urandom(5000)):
        (tmp_path / "text.mcap").write_bytes(content)
        assert command("recover", tmp_path / "text.mcap", "-o", tmp_path / "fixed.mcap").code == 1
    assert [path.name for path in tmp_path.iterdir()] == ["text.mcap"]


def test_a_file_that_is_there_is_overwritten_only_by_force_even_by_itself(tmp_path: Path, command: Command) -> None:
    path = small(tmp_path / "small.mcap")
    whole = path.read_bytes()
    path.write_bytes(whole[:-30])
    done = command("recover", path, "-o", path)
    assert (done.code, done.err) == (2, f"vdoor: output: already exists, --force overwrites it: {path}\n")
    assert command("recover", path, "-o", path, "--force").code == 0
    assert path.read_bytes() == whole


KILLED = """
import os, signal, sys
from pathlib import Path
import numpy as np
from small_recording import PIPELINE, small_run
from vdoor.emit import Recorder
from vdoor.files import partial_name
from vdoor.recording.mcap import McapSink

info, records = small_run()
recorder = Recorder([McapSink(partial_name(Path(sys.argv[1])), info)])

def emit(record):
    recorder(record)
    if recorder.step > int(sys.argv[2]):
        os.kill(os.getpid(), signal.SIGKILL)
    return record

PIPELINE(records[0], np.random.default_rng(info.seed), emit)
"""


def test_a_run_that_is_killed_leaves_every_stage_it_finished(tmp_path: Path, command: Command) -> None:
    info, records = small_run()
    for step in (0, len(records) // 2, len(records) - 2):
        path = tmp_path / f"killed{step}.mcap"
        done = subprocess.run([sys.executable, "-c", KILLED, path, str(step)], cwd=HERE, check=False)
        assert done.returncode == -signal.SIGKILL
        partial = partial_name(path)
        before = partial.read_bytes()
        assert not path.exists()
        assert command("check", partial).code == 1
        assert command("recover", partial, "-o", path).code == 0
        assert partial.read_bytes() == before
        assert read_recording(path, types=RECORDS).info == info
        back = read(path)
        assert len(back) == step + 1
        assert all(equal(*pair) for pair in zip(back, records, strict=False))
        assert check(path, types=RECORDS, emits=emitted).ended_in == records[step].topic


def limited() -> None:
    resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, 10_000))


def test_a_full_disk_is_named_and_leaves_no_half_file(tmp_path: Path) -> None:
    path = small(tmp_path / "small.mcap")
    image = tmp_path / "map.pgm"
    image.write_bytes(small_run()[0].source.files[0][1])
    full = ["--resolution", "0.2", "--preset", "paper", "-q"]
    for words in (
        ["recover", path, "-o", tmp_path / "new.mcap"],
        ["run", image, *full, "--mcap", tmp_path / "new.mcap"],
    ):
        done = subprocess.run(
            [VDOOR, *map(str, words)],
            preexec_fn=limited,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 2
        assert done.stderr.startswith("vdoor: recording: cannot be written (File too large): ")
        assert len(done.stderr.splitlines()) == 1
        assert {entry.name for entry in tmp_path.iterdir()} == {"small.mcap", "map.pgm"}


def test_a_folder_that_cannot_be_written_to_is_named(tmp_path: Path, command: Command) -> None:
    folder = tmp_path / "closed"
    folder.mkdir(mode=0o500)
    if os.access(folder, os.W_OK):  # the superuser may write anywhere but here
        folder = Path("/sys/kernel")
    if not folder.is_dir():
        pytest.skip("no folder here that the superuser may not write to")
    path = small(tmp_path / "small.mcap")
    done = command("recover", path, "-o", folder / "new.mcap")
    assert (done.code, done.out) == (2, "")
    assert done.err.startswith("vdoor: output: cannot be written (")
    assert not (folder / "new.mcap").exists()
    assert command("golden", folder).code == 2


def test_what_is_behind_the_end_is_left_alone(tmp_path: Path) -> None:
    _, records = small_run()
    path = small(tmp_path / "small.mcap")
    whole = path.read_bytes()
    path.write_bytes(whole + whole)
    found, back = recovered(path)
    assert len(back) == len(records)
    assert found.missing == ()
