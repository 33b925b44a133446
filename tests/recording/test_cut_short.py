"""A recording that is cut short gives back every stage before the cut; the map's files take little of it."""

from __future__ import annotations

import struct
import subprocess
import tracemalloc
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import zstandard
from commands import Command, call, one_line
from project import HOME, VDOOR
from recordings_by_hand import by_hand, messages_of, spans
from small_recording import read, small, small_run, write

import vdoor
from vdoor.config import DEFAULT_PRESET, settings_of
from vdoor.emit import Recorder, RunInfo
from vdoor.errors import RecordingError
from vdoor.grid import Source
from vdoor.pipeline import METHODS, PRESETS, RECORDS, emitted
from vdoor.record import equal
from vdoor.recording import about
from vdoor.recording.about import ENDING, PACKED, PLAIN, Attached, files_of
from vdoor.recording.check import check
from vdoor.recording.mcap import McapSink, read_recording
from vdoor.recording.recover import recover
from vdoor.recording.scan import Budget, scan

FINE = HOME / "recordings" / "fine.yaml"
EVERY = 509
"""Bytes between cuts; beside these the ends of what comes back are tried."""


@pytest.fixture(scope="module")
def fine(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run on a map whose image is larger than all that is found in it."""
    grid, path = vdoor.read_map(FINE), tmp_path_factory.mktemp("fine") / "fine.mcap"
    settings = settings_of(PRESETS[DEFAULT_PRESET], METHODS)
    sink = McapSink(path, RunInfo(version="0", preset=DEFAULT_PRESET, seed=0, settings=settings, source=grid.source))
    vdoor.run(grid, emit=Recorder([sink]))
    sink.close()
    return path


def ends(path: Path) -> dict[str, list[int]]:
    """Where each kind of record of the file's own level ends."""
    found: dict[str, list[int]] = {}
    for _, end, record in scan(path, Budget.of(path)):
        found.setdefault(type(record).__name__, []).append(end)
    return found


def cuts(path: Path, every: int) -> list[int]:
    found = ends(path)
    at_ends = [end + off for kind in ("Metadata", "Attachment", "Chunk") for end in found[kind] for off in (-1, 0, 1)]
    size = path.stat().st_size
    return sorted({cut for cut in (*range(0, size, every), *at_ends) if cut < size})


def test_every_stage_comes_back_from_a_cut_anywhere_behind_it(tmp_path: Path) -> None:
    path, out = small(tmp_path / "small.mcap"), tmp_path / "fixed.mcap"
    whole, chunks, (info, records) = path.read_bytes(), spans(path), small_run()
    known_from, files_from = ends(path)["Metadata"][0], ends(path)["Attachment"][-1]
    for cut in cuts(path, EVERY):
        path.write_bytes(whole[:cut])
        complete = {step for _, end, inside in chunks if end <= cut for step in inside}
        recover(path, out, types=RECORDS, emits=emitted)
        assert out.exists() == bool(complete), cut
        assert sum(check(path, types=RECORDS, emits=emitted).records.values()) == len(complete), cut
        if not complete:
            continue
        back = read_recording(out, types=RECORDS)
        assert all(equal(record, records[step]) for step, record in back), cut
        assert {step for step, _ in back} == complete, cut
        assert cut >= known_from
        assert (back.info.settings, back.info.seed) == (info.settings, info.seed)
        assert back.info.source.files == (info.source.files if cut >= files_from else ()), cut
        out.unlink()


def test_no_part_of_the_map_stands_before_the_first_stage(fine: Path, tmp_path: Path) -> None:
    found, size = ends(fine), fine.stat().st_size
    image = FINE.with_suffix(".pgm").stat().st_size
    assert found["Chunk"][0] < found["Attachment"][0] < found["Chunk"][1]
    assert found["Chunk"][0] < size / 20
    assert found["Attachment"][-1] - found["Chunk"][0] < image / 20
    assert size < 2 * image
    path = tmp_path / "cut.mcap"
    path.write_bytes(fine.read_bytes()[: size // 20])
    assert recover(path, tmp_path / "fixed.mcap", types=RECORDS, emits=emitted).records["input"] == 1


def test_stages_come_back_from_every_twentieth_of_a_large_map(fine: Path, tmp_path: Path) -> None:
    whole, chunks = fine.read_bytes(), spans(fine)
    path, counts = tmp_path / "cut.mcap", []
    for twentieth in range(1, 21):
        cut = len(whole) * twentieth // 20 - 1
        path.write_bytes(whole[:cut])
        found = recover(path, tmp_path / "fixed.mcap", types=RECORDS, emits=emitted)
        counts.append(sum(found.records.values()))
        assert counts[-1] == len({step for _, end, inside in chunks if end <= cut for step in inside})
    assert counts[0] > 0
    assert counts[12] > 7  # of 60 %, where once all was lost


def test_what_is_cut_short_is_told_drawn_and_recovered(fine: Path, tmp_path: Path) -> None:
    """As its user meets it."""
    path, fixed = tmp_path / "cut.mcap.partial", tmp_path / "fixed.mcap"
    path.write_bytes(fine.read_bytes()[: fine.stat().st_size * 6 // 10])
    told = call("check", path, code=1).stdout
    assert "stage     door_scores       1\n" in told
    assert "damage    recording: wanted a complete MCAP file, found it cut short\n" in told
    drawn = call("replay", path, "--save", tmp_path / "cut.rrd")
    count = int(drawn.stdout.split()[0])
    assert count > 7
    assert one_line(drawn) == (
        f"vdoor: note: only the intact part was drawn, {count} records; "
        f"recording: wanted a complete MCAP file, found it cut short: {path}"
    )
    assert (tmp_path / "cut.rrd").stat().st_size > 10_000
    done = call("recover", path, "-o", fixed)
    assert sum(int(line.split()[-1]) for line in done.stdout.splitlines() if "lost" not in line) == count
    assert len(read(fixed)) == count
    rerun = [VDOOR.with_name("rerun"), "rrd", "verify", tmp_path / "cut.rrd"]
    assert subprocess.run(rerun, env={"CI": "1"}, capture_output=True, check=False).returncode == 0


def test_a_cut_in_the_maps_files_leaves_the_map(fine: Path, tmp_path: Path, command: Command) -> None:
    path = tmp_path / "cut.mcap"
    path.write_bytes(fine.read_bytes()[: ends(fine)["Attachment"][0] + 30])
    told = command("info", path)
    assert "stage     input             1\n" in told.out
    assert "missing   source files: fine.yaml, fine.pgm before the damage\n" in told.out
    assert command("verify", path).code == 2
    assert command("run", path).code == 2
    recovered = command("recover", path, "-o", tmp_path / "fixed.mcap")
    assert (recovered.code, "lost: source files: fine.yaml, fine.pgm\n" in recovered.out) == (0, True)
    (grid,) = read(tmp_path / "fixed.mcap")
    assert equal(grid, vdoor.read_map(FINE))


def test_a_damaged_recording_is_not_taken_for_a_map_without_its_files(fine: Path, tmp_path: Path) -> None:
    whole, at = bytearray(fine.read_bytes()), spans(fine)[0][0]
    whole[at + 1 + 7] = 1  # the first chunk's length is beyond all ends; the index behind still finds it
    (tmp_path / "damaged.mcap").write_bytes(whole)
    done = call("run", tmp_path / "damaged.mcap", code=2)
    assert "recording: damaged, cannot read its source files: fine.yaml, fine.pgm" in one_line(done)


# --- the map's files


def test_recordings_of_before_are_read_and_come_back_in_the_new_layout(tmp_path: Path, command: Command) -> None:
    """Their files lie before the first record, and as they are."""
    info, records = small_run()
    old = by_hand(tmp_path / "old.mcap", messages_of(records))
    assert ends(old)["Attachment"][-1] < ends(old)["Chunk"][0]
    assert info.source.files[0][1] in old.read_bytes()
    assert read_recording(old, types=RECORDS).info == info
    assert command("verify", old).code == 0
    assert command("recover", old, "-o", tmp_path / "new.mcap").code == 0
    assert (tmp_path / "new.mcap").read_bytes() == small(tmp_path / "small.mcap").read_bytes()


def test_a_run_without_a_record_keeps_its_files(tmp_path: Path) -> None:
    info, _ = small_run()
    assert read_recording(write(tmp_path / "none.mcap", []), types=RECORDS).info == info


FILES: dict[str, tuple[tuple[str, bytes], ...]] = {
    "none": (),
    "empty": (("map.pgm", b""),),
    "twice": (("map.yaml", b"image: map.pgm"), ("map.yaml", b"image: map.pgm")),
    "ends alike": (("map.pgm.zst", b"not packed"), (".zst", b"")),
    "packed already": (("map.png", np.random.default_rng(0).bytes(5000)),),
    "large": (("map.pgm", bytes(10_000_000)),),
}


@pytest.mark.parametrize("name", FILES)
def test_files_come_back_as_they_were(name: str, tmp_path: Path) -> None:
    info, records = small_run()
    source = Source(files=FILES[name])
    path = tmp_path / "files.mcap"
    write(path, records[:1], RunInfo(version="0", preset="paper", seed=0, settings=info.settings, source=source))
    assert read_recording(path, types=RECORDS).info.source == source
    assert path.stat().st_size < 30_000


def test_what_is_too_large_to_unpack_is_stored_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(about, "UNPACKED_TO", 1000)
    files = [("a", bytes(600)), ("b", bytes(600)), ("c", bytes(400)), ("d", b"1")]
    stored = list(about.attached(files))
    assert [(one.name, one.media_type) for one in stored] == [
        ("a.zst", PACKED), ("b", PLAIN), ("c.zst", PACKED), ("d", PLAIN),
    ]  # fmt: skip
    assert files_of(stored) == files
    monkeypatch.setattr(about, "UNPACKED_TO", 999)
    with pytest.raises(RecordingError, match=r"attachment c\.zst: wanted at most 399 bytes unpacked, .* claims 400"):
        files_of(stored)


def packed(size: int) -> bytes:
    return zstandard.ZstdCompressor().compress(bytes(size))


def claiming(size: int) -> bytes:
    """A file that says it is of another size than it is."""
    whole = packed(100_000)
    assert whole.count(struct.pack("<I", 100_000)) == 1
    return whole.replace(struct.pack("<I", 100_000), struct.pack("<I", size))


SPOILT: dict[str, tuple[Callable[[], bytes], str]] = {
    "bomb": (lambda: claiming(2**31), "wanted at most 268435456 bytes unpacked, found one that claims 2147483648"),
    "liar": (lambda: claiming(99_999), "wanted bytes compressed with zstd, found others"),
    "silent": (lambda: zstandard.ZstdCompressor(write_content_size=False).compress(bytes(9)), "unknown size"),
    "cut": (lambda: packed(100_000)[:-3], "wanted bytes compressed with zstd, found others"),
    "more behind": (lambda: packed(9) + packed(9), "wanted bytes compressed with zstd, found others"),
    "not packed": (lambda: b"P5 1 1 255 \xfe", "wanted bytes compressed with zstd, found others"),
    "nothing": (lambda: b"", "wanted bytes compressed with zstd, found others"),
}


@pytest.mark.parametrize("name", SPOILT)
def test_packed_bytes_that_are_none_are_refused_without_room_for_them(name: str) -> None:
    make, message = SPOILT[name]
    data = make()
    tracemalloc.start()
    with pytest.raises(RecordingError, match=f"attachment map.pgm.zst: .*{message}"):
        files_of([Attached("map.pgm" + ENDING, PACKED, data)])
    assert tracemalloc.get_traced_memory()[1] < 1_000_000
    tracemalloc.stop()


def test_a_recording_with_a_bomb_is_refused_in_one_line_and_its_stages_come_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: Command
) -> None:
    _, records = small_run()
    bomb = Attached("map.pgm.zst", PACKED, claiming(2**31))
    with monkeypatch.context() as patch:
        patch.setattr("vdoor.recording.mcap.attached", lambda _: [bomb])
        path = small(tmp_path / "bomb.mcap")
    for words in (("verify", path), ("info", path), ("run", path), ("show", path)):
        done = command(*words)
        assert (done.code, len(done.err.splitlines())) == (2, 1)
        assert "attachment map.pgm.zst: wanted at most 268435456 bytes" in done.err + done.out
    done = command("recover", path, "-o", tmp_path / "fixed.mcap")
    assert (done.code, done.out.splitlines()[-1]) == (0, "lost: source files: map.pgm")
    assert len(read(tmp_path / "fixed.mcap")) == len(records)
