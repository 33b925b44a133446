"""`vdoor check` and `vdoor info`: damage and lies are found, wherever they are; what is whole is called whole."""

from __future__ import annotations

import dataclasses
import zlib
from pathlib import Path

import mcap.records
import mcap.writer
import numpy as np
import pytest
from commands import Command
from random_records import random_record
from small_recording import PIPELINE, small, small_run, write

from vdoor.method.search.generation import Generation
from vdoor.pipeline import RECORDS, emitted
from vdoor.record import equal
from vdoor.recording import about
from vdoor.recording.check import check
from vdoor.recording.mcap import McapSink, read_recording

STAGES = [record.topic for record in PIPELINE.records]


def test_a_whole_recording_is_called_whole(tmp_path: Path, command: Command) -> None:
    path = small(tmp_path / "small.mcap")
    health = check(path, types=RECORDS, emits=emitted)
    assert health.whole
    assert (health.damage, health.missing, health.ended_in) == ((), (), "map")
    assert health.records == dict.fromkeys(STAGES, 1) | {"generation": 4}
    assert command("check", path).code == 0
    assert command("check", path).out.splitlines()[-1].startswith("whole")


def flips(size: int, count: int) -> list[tuple[int, int]]:
    rng = np.random.default_rng(0)
    return [(int(rng.integers(size)), 1 << int(rng.integers(8))) for _ in range(count)]


def test_80_flipped_bits_are_all_found(tmp_path: Path) -> None:
    path = small(tmp_path / "small.mcap")
    whole = path.read_bytes()
    missed = 0
    for at, bit in flips(len(whole), 80):
        damaged = bytearray(whole)
        damaged[at] ^= bit
        path.write_bytes(damaged)
        missed += check(path, types=RECORDS, emits=emitted).whole
    assert missed == 0


def test_a_file_cut_anywhere_is_found_and_the_stage_it_ended_in_named(tmp_path: Path, command: Command) -> None:
    path = small(tmp_path / "small.mcap")
    whole = path.read_bytes()
    ended_in = []
    for percent in range(0, 100, 5):
        path.write_bytes(whole[: len(whole) * percent // 100])
        done = command("check", path)
        assert (done.code, done.err) == (1, "")
        ended_in.append(done.out.partition("ends in   ")[2].splitlines()[0])
    order = ["no stage", *STAGES]
    assert [order.index(stage) for stage in ended_in] == sorted(order.index(stage) for stage in ended_in)
    assert ended_in[0] == "no stage"
    assert ended_in[-1] == "map"


def test_a_run_that_ended_early_is_not_whole(tmp_path: Path) -> None:
    _, records = small_run()
    health = check(write(tmp_path / "short.mcap", records[:6]), types=RECORDS, emits=emitted)
    assert not health.whole
    assert (health.damage, health.ended_in) == ((), "corners")
    assert health.missing == tuple(f"{topic}: no record" for topic in ("doors", "initial_map", "generation", "map"))


def test_stages_and_generations_left_out_are_named(tmp_path: Path) -> None:
    path = tmp_path / "gaps.mcap"
    info, records = small_run()
    sink = McapSink(path, info)
    for step, record in enumerate(records):
        if record.topic != "corners" and step != 9:
            sink.write(step, record)
    sink.close()
    assert check(path, types=RECORDS, emits=emitted).missing == (
        "corners: no record",
        "1 record between step 8 and step 10 (generation)",
    )


def test_stages_out_of_order_are_named(tmp_path: Path) -> None:
    _, records = small_run()
    health = check(
        write(tmp_path / "mixed.mcap", [*records[:2], records[3], records[2], *records[4:]]),
        types=RECORDS,
        emits=emitted,
    )
    assert health.damage == ("step 3: wanted path before curvature, found it after",)


Change = tuple[str, str, object]
LIES: dict[str, Change] = {
    "summary: wanted Statistics records that fit the data": ("Statistics", "message_count", 7),
    "summary: wanted ChunkIndex records that fit the data": ("ChunkIndex", "message_end_time", 7),
    "summary: wanted AttachmentIndex records that fit the data": ("AttachmentIndex", "data_size", 7),
    "summary: wanted MetadataIndex records that fit the data": ("MetadataIndex", "offset", 7),
    "summary: wanted Channel records that fit the data": ("Channel", "topic", "/else"),
    "summary: wanted Schema records that fit the data": ("Schema", "name", "else/msg/Else"),
    "footer: wanted the checksum of the summary, found another": ("Footer", "summary_crc", 7),
    "footer: wanted a summary from byte": ("Footer", "summary_start", 7),
    "wanted a chunk with the times of its messages": ("Chunk", "message_start_time", 7),
    "wanted an index of the messages before it": ("MessageIndex", "records", [(7, 7)]),
}


@pytest.mark.parametrize("said", LIES)
def test_a_file_that_lies_with_all_checksums_right_is_found_out(
    said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kind, field, value = LIES[said]
    record = getattr(mcap.records, kind)

    def lying(self: object, stream: object) -> None:
        if kind in ("Channel", "Schema"):  # in the summary alone: what the data says is what counts
            written.append(self)
            if sum(other is self for other in written) == 1:
                honest(self, stream)
                return
        honest(dataclasses.replace(self, **{field: value}), stream)  # type: ignore[type-var]  # a dataclass

    written: list[object] = []
    honest = record.write
    with monkeypatch.context() as patch:
        patch.setattr(record, "write", lying)
        path = small(tmp_path / "small.mcap")
    health = check(path, types=RECORDS, emits=emitted)
    assert any(said in problem for problem in health.damage), health.damage
    assert health.records["map"] == 1
    assert all(
        equal(*pair) for pair in zip((r for _, r in read_recording(path, types=RECORDS)), small_run()[1], strict=True)
    )


def test_a_file_without_checksums_or_with_more_behind_it_is_not_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patch:
        patch.setattr(zlib, "crc32", lambda *_: 0)
        path = small(tmp_path / "small.mcap")
    assert any(
        "wanted a checksum, found none" in problem for problem in check(path, types=RECORDS, emits=emitted).damage
    )
    path = small(tmp_path / "small.mcap")
    path.write_bytes(path.read_bytes() + b"more")
    assert "wanted nothing after byte" in check(path, types=RECORDS, emits=emitted).damage[0]


def test_another_version_opens_and_another_schema_or_field_is_refused_by_name(
    tmp_path: Path, command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    info, records = small_run()
    later = write(tmp_path / "later.mcap", records, dataclasses.replace(info, version="9.9"))
    assert command("check", later).code == 0
    assert "version   vdoor 9.9" in command("info", later).out
    done = command("verify", later)
    assert (done.code, done.err) == (0, f"vdoor: note: written by vdoor '9.9', this is 0.1.0: {later}\n")
    with monkeypatch.context() as patch:
        patch.setattr(about, "SCHEMA", "2")
        schema = write(tmp_path / "schema.mcap", records, dataclasses.replace(info, version="9.9"))
    said = "recording schema: wanted 1, found 2 (written by vdoor 9.9); read it with that version, or record it again"
    for name in ("verify", "info", "diff"):
        done = command(name, schema, *([later] if name == "diff" else []))
        assert (done.code, done.err) == (2, f"vdoor: {said}: {schema}\n")
    assert command("check", schema).code == 1
    done = command("recover", schema, "-o", tmp_path / "fixed.mcap")
    assert (done.code, done.err) == (2, f"vdoor: {said}: {schema}\n")


class Corners(Generation):
    """A record of today's topic with the fields of another."""

    topic = "corners"


def test_a_changed_field_is_refused_by_name(tmp_path: Path, command: Command) -> None:
    info, records = small_run()
    other = random_record(Corners, np.random.default_rng(0))
    path = write(tmp_path / "field.mcap", [*records[:5], other], dataclasses.replace(info, version="9.9"))
    done = command("verify", path)
    assert done.code == 2
    assert "topic /vdoor/corners/removed: unknown, wanted /vdoor/corners/(corner|values)" in done.err
    assert "(written by vdoor 9.9); read it with that version, or record it again" in done.err


def test_info_says_what_a_run_was(tmp_path: Path, command: Command) -> None:
    info, records = small_run()
    path = write(tmp_path / "small.mcap", records)
    lines = dict(line.split(maxsplit=1) for line in command("info", path).out.splitlines())
    assert lines["version"] == "vdoor 0.1.0"
    assert lines["map"] == "map.pgm (140 bytes), resolution_m 0.2, unknown_value 205"
    assert lines["sha256"] == about.digest(info.source)
    assert (lines["preset"], lines["seed"]) == ("paper", "5")
    changed = [line for line in command("info", path).out.splitlines() if line.startswith("setting")]
    assert changed == [
        "setting   search.population: preset 50, here 8",
        "setting   search.generations: preset 50, here 3",
    ]
    told = command("info", path, "--json").json
    assert told["whole"] is True
    assert told["records"]["generation"] == 4
    assert told["settings"] == info.settings


def test_what_is_no_recording_is_named(tmp_path: Path, command: Command) -> None:
    text = tmp_path / "text.mcap"
    text.write_text("Not a recording.")
    assert command("info", text) == (2, "", f"vdoor: recording: wanted an MCAP file, found another file: {text}\n")
    assert command("check", text).code == 1
    absent = tmp_path / "absent.mcap"
    for words in (("check", absent), ("info", absent), ("recover", absent, "-o", tmp_path / "x.mcap")):
        done = command(*words)
        assert (done.code, done.out) == (2, "")
        assert done.err == f"vdoor: recording: cannot be read (No such file or directory): {absent}\n"
    assert command("check", tmp_path).code == 2
