"""The MCAP file: what was written comes back, others read it, equal runs give equal bytes, damage is named."""

from __future__ import annotations

import dataclasses
import io
import signal
import struct
import tracemalloc
from pathlib import Path
from typing import Annotated, ClassVar

import mcap.writer
import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image
from random_records import RECORDS, random_record
from rosbags.highlevel import AnyReader

from vdoor.emit import Recorder, RunInfo
from vdoor.errors import RecordingError
from vdoor.frame import Frame
from vdoor.grid import OccupancyGrid, Source
from vdoor.interrupts import held_signals
from vdoor.method.search.generation import Generation
from vdoor.record import Record, Spec, equal
from vdoor.recording import about
from vdoor.recording import mcap as recorded
from vdoor.recording.mcap import McapSink, read_recording
from vdoor.topology import TopologicalMap

SOURCE = Source(files=(("flat.yaml", b"image: flat.pgm\n"), ("flat.pgm", b"P5 1 1 255 \x00")), options={"free": 0.196})
INFO = RunInfo(version="0.1.0", preset="paper", seed=7, settings={"simplify": {"cell_m": 0.2}}, source=SOURCE)


def run(seed: int = 0) -> list[Record]:
    """One record of each type, and a second generation."""
    rng = np.random.default_rng(seed)
    sizes = {"height": 9, "width": 7}
    return [random_record(record, rng, sizes=sizes) for record in (*RECORDS[:-1], Generation, RECORDS[-1])]


def write(path: Path, records: list[Record], info: RunInfo = INFO) -> Path:
    sink = McapSink(path, info)
    for step, record in enumerate(records):
        sink.write(step, record)
    sink.close()
    return path


def read(path: Path) -> list[Record]:
    return [record for _, record in read_recording(path, types=RECORDS)]


def refused(path: Path) -> str:
    with pytest.raises(RecordingError) as caught:
        read(path)
    assert str(caught.value).endswith(str(path))
    return str(caught.value)


def test_a_recording_gives_back_all_that_was_written(tmp_path: Path) -> None:
    records = run()
    recording = read_recording(write(tmp_path / "run.mcap", records), types=RECORDS)
    assert recording.info == INFO
    steps, back = zip(*recording, strict=True)
    assert steps == tuple(range(len(records)))
    assert all(equal(*pair) for pair in zip(back, records, strict=True))
    assert isinstance(back[0], OccupancyGrid)
    assert back[0].source == SOURCE


def test_the_same_run_gives_the_same_bytes(tmp_path: Path) -> None:
    one, two = (write(tmp_path / name, run()).read_bytes() for name in ("one.mcap", "two.mcap"))
    assert one == two
    assert one != write(tmp_path / "other.mcap", run(1)).read_bytes()


def test_an_independent_reader_reads_every_message(tmp_path: Path) -> None:
    records = run()
    with AnyReader([write(tmp_path / "run.mcap", records)]) as reader:
        found = {topic: connections.msgtype for topic, connections in reader.topics.items()}
        messages = [(c.topic, t, reader.deserialize(data, c.msgtype)) for c, t, data in reader.messages()]
    assert found["/vdoor/input/cells"] == "nav_msgs/msg/OccupancyGrid"
    assert found["/vdoor/map/labels"] == "sensor_msgs/msg/Image"
    assert found["/vdoor/corners/corner"] == "sensor_msgs/msg/PointCloud2"
    assert found["/vdoor/generation/values"] == "std_msgs/msg/Float64MultiArray"
    assert found["/vdoor/generation/removed"] == "std_msgs/msg/UInt8MultiArray"
    logs = [message for topic, _, message in messages if topic == "/rosout"]
    assert [log.msg.partition(":")[0] for log in logs] == [type(record).__name__ for record in records]
    assert {time for _, time, _ in messages} == {recorded.time_ns(step) for step in range(len(records))}


def test_viewers_get_the_final_map_as_markers_and_picture(tmp_path: Path) -> None:
    grid = OccupancyGrid.from_array(np.array([[0, 0, 100, 0], [-1, 0, 0, 0]], np.int8), 0.5)
    door = {"start_m": np.array([[1.25, 0.0]]), "end_m": np.array([[1.25, 1.0]])}
    drawn = random_record(
        TopologicalMap, np.random.default_rng(0), sizes={"height": 2, "width": 4, "door": 1, "room": 2}
    )
    rooms = {
        "labels": np.array([[1, 1, 0, 2], [0, 1, 0, 2]], np.int32),
        "centre": np.array([[0, 0], [0, 3]], np.int32),
        "room_a": np.array([1], np.int32),
        "room_b": np.array([2], np.int32),
        "name": ("", "Küche"),
        "frame": grid.frame,
    }
    final = dataclasses.replace(drawn, **door, **rooms)
    with AnyReader([write(tmp_path / "run.mcap", [grid, final])]) as reader:
        messages = {c.topic: reader.deserialize(data, c.msgtype) for c, _, data in reader.messages()}
    _, doors, links, centres, *labels = messages["/vdoor/markers"].markers
    assert [(p.x, p.y) for p in doors.points] == [(1.25, 0.0), (1.25, 1.0)]
    assert [(p.x, p.y) for p in links.points] == [(1.25, 0.5), (0.25, 0.75), (1.25, 0.5), (1.75, 0.75)]
    assert [(p.x, p.y) for p in centres.points] == [(0.25, 0.75), (1.75, 0.75)]
    assert [label.text for label in labels] == ["1", "Küche"]
    picture = Image.open(io.BytesIO(messages["/vdoor/map/picture"].data.tobytes())).convert("RGB")
    seen = np.asarray(picture)
    assert seen[0, 2].tolist() == [0, 0, 0]
    assert seen[1, 0].tolist() == [205, 205, 205]
    assert seen[1, 2].tolist() == [254, 254, 254]
    assert (
        len(np.unique(seen[rooms["labels"] == 1], axis=0)) == len(np.unique(seen[rooms["labels"] > 0], axis=0)) - 1 == 1
    )


def until_error(path: Path) -> tuple[list[Record], str]:
    """Give the records of a file until reading fails, and what the failure says."""
    back: list[Record] = []
    try:
        for _, record in read_recording(path, types=RECORDS):
            back.append(record)  # a list() would lose what came before the failure
    except RecordingError as error:
        return back, str(error)
    return back, ""


def test_what_was_written_survives_a_kill(tmp_path: Path) -> None:
    records = run()
    sink = McapSink(tmp_path / "run.mcap", INFO)
    for step, record in enumerate(records):
        sink.write(step, record)
        killed = tmp_path / "killed.mcap"
        killed.write_bytes((tmp_path / "run.mcap").read_bytes())
        back, error = until_error(killed)
        assert "cut short" in error
        assert len(back) == step + 1
        assert all(equal(*pair) for pair in zip(back, records, strict=False))
    sink.close()


def test_a_cut_file_gives_every_record_before_the_cut(tmp_path: Path) -> None:
    records = run()
    whole = write(tmp_path / "run.mcap", records).read_bytes()
    counts = []
    for length in range(0, len(whole), len(whole) // 40):
        (tmp_path / "cut.mcap").write_bytes(whole[:length])
        back, error = until_error(tmp_path / "cut.mcap")
        assert "cut short" in error
        assert all(equal(*pair) for pair in zip(back, records, strict=False))
        counts.append(len(back))
    assert counts == sorted(counts)
    assert counts[-1] == len(records)


def test_a_flipped_bit_is_found_or_changes_nothing(tmp_path: Path) -> None:
    records = run()
    whole = write(tmp_path / "run.mcap", records).read_bytes()
    rng = np.random.default_rng(0)
    for _ in range(100):
        damaged = bytearray(whole)
        damaged[rng.integers(len(whole))] ^= 1 << int(rng.integers(8))
        (tmp_path / "run.mcap").write_bytes(damaged)
        back, error = until_error(tmp_path / "run.mcap")
        assert all(equal(*pair) for pair in zip(back, records, strict=False))
        assert error or len(back) == len(records)


def test_damage_to_a_source_file_is_found_before_anything_is_read(tmp_path: Path) -> None:
    path = write(tmp_path / "run.mcap", run())
    path.write_bytes(path.read_bytes().replace(b"image: flat.pgm", b"image: f1at.pgm"))
    with pytest.raises(RecordingError, match=r"attachments: wanted flat\.yaml, flat\.pgm as recorded"):
        read_recording(path, types=RECORDS)


def test_damage_to_the_settings_is_found_before_anything_is_read(tmp_path: Path) -> None:
    path = write(tmp_path / "run.mcap", run())
    path.write_bytes(path.read_bytes().replace(b'"cell_m": 0.2', b'"cell_m": 0.3', 1))
    with pytest.raises(RecordingError, match="metadata: wanted texts with the recorded checksum, found them damaged"):
        read_recording(path, types=RECORDS)


def test_names_of_source_files_touch_no_other_file(tmp_path: Path) -> None:
    files = (("../../escaped.pgm", b"1"), (str(tmp_path / "absolute.pgm"), b"2"))
    path = write(tmp_path / "run.mcap", run(), dataclasses.replace(INFO, source=Source(files=files)))
    assert read_recording(path, types=RECORDS).info.source.files == files
    assert [entry.name for entry in tmp_path.iterdir()] == ["run.mcap"]


def test_what_is_no_recording_is_named(tmp_path: Path) -> None:
    assert "cannot be read (No such file" in refused(tmp_path / "absent.mcap")
    (tmp_path / "empty.mcap").touch()
    assert "cut short" in refused(tmp_path / "empty.mcap")
    (tmp_path / "text.mcap").write_text("Not a recording at all.")
    assert "wanted an MCAP file, found another file" in refused(tmp_path / "text.mcap")
    foreign = mcap.writer.Writer(str(tmp_path / "foreign.mcap"))
    foreign.start()
    foreign.finish()
    assert "wanted metadata named vdoor, found none" in refused(tmp_path / "foreign.mcap")


def test_another_schema_is_refused_and_another_version_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    later = dataclasses.replace(INFO, version="9.9")
    assert read_recording(write(tmp_path / "later.mcap", run(), later), types=RECORDS).info.version == "9.9"
    with monkeypatch.context() as patch:
        patch.setattr(about, "SCHEMA", "2")
        write(tmp_path / "schema.mcap", run(), later)
    assert "recording schema: wanted 1, found 2 (written by vdoor 9.9)" in refused(tmp_path / "schema.mcap")


class Corners(Record):
    """A record as an older version may have had it."""

    topic: ClassVar[str] = "corners"

    cell: Annotated[NDArray[np.int32], Spec("cell", "corner 2")]
    bend_deg: Annotated[NDArray[np.float64], Spec("column", "corner")]
    frame: Frame


class Walls(Record):
    """A record that is not known."""

    topic: ClassVar[str] = "walls"

    number: Annotated[int, Spec("count")]


def test_records_and_fields_that_are_not_known_are_named(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    path = write(tmp_path / "corners.mcap", [random_record(Corners, rng)])
    assert "Corners.corner: wanted a column sample, found x, y, z, cell_0, cell_1, bend_deg" in refused(path)
    assert "(written by vdoor 0.1.0); read it with that version, or record it again" in refused(path)
    path = write(tmp_path / "walls.mcap", [Walls(number=1)])
    assert "topic /vdoor/walls/values: unknown, wanted /vdoor/input/(cells|values), " in refused(path)


def written_by_hand(path: Path, *messages: tuple[str, str, int], data: bytes = b"") -> Path:
    """Give a recording with messages of given topic, type and log time, all with the same bytes."""
    with path.open("wb") as stream:
        writer = mcap.writer.Writer(stream)
        writer.start("ros2")
        writer.add_metadata("vdoor", about.to_text(dataclasses.replace(INFO, source=Source())))
        for topic, name, time_ns in messages:
            schema = writer.register_schema(name, "ros2msg", b"")
            channel = writer.register_channel(topic, "cdr", schema)
            writer.add_message(channel, time_ns, data, time_ns)
        writer.finish()
    return path


GRID_TYPE = "nav_msgs/msg/OccupancyGrid"


def test_messages_out_of_place_are_named(tmp_path: Path) -> None:
    def said(*messages: tuple[str, str, int]) -> str:
        return refused(written_by_hand(tmp_path / "hand.mcap", *messages))

    start_ns = recorded.time_ns(0)
    assert "wanted one message per part, found none or two of values" in said(
        ("/vdoor/input/cells", GRID_TYPE, start_ns)
    )
    assert "wanted nav_msgs/msg/OccupancyGrid in cdr, found std_msgs/msg/String" in said(
        ("/vdoor/input/cells", "std_msgs/msg/String", start_ns)
    )
    assert "wanted the log time of a step" in said(("/vdoor/input/cells", GRID_TYPE, start_ns + 1))
    twice = said(("/vdoor/input/cells", GRID_TYPE, start_ns), ("/vdoor/input/cells", GRID_TYPE, start_ns))
    assert "step 0 (input): wanted one message per part" in twice


def test_steps_out_of_order_are_named(tmp_path: Path) -> None:
    sink = McapSink(tmp_path / "run.mcap", INFO)
    for step, record in zip((1, 0), run(), strict=False):
        sink.write(step, record)
    sink.close()
    assert "wanted a step after 1, found 0" in refused(tmp_path / "run.mcap")


def test_a_chunk_that_claims_too_much_is_refused_without_room_for_it(tmp_path: Path) -> None:
    whole = written_by_hand(tmp_path / "hand.mcap", ("/vdoor/input/cells", GRID_TYPE, recorded.time_ns(0))).read_bytes()
    at = whole.index(b"\x04\x00\x00\x00zstd") - 12
    (tmp_path / "hand.mcap").write_bytes(whole[:at] + struct.pack("<Q", 2**40) + whole[at + 8 :])
    tracemalloc.start()
    assert "found one that claims 1099511627776" in refused(tmp_path / "hand.mcap")
    assert tracemalloc.get_traced_memory()[1] < 5_000_000
    tracemalloc.stop()


def test_a_record_that_claims_too_much_is_refused_without_room_for_it(tmp_path: Path) -> None:
    whole = write(tmp_path / "run.mcap", run()).read_bytes()
    name = whole.index(b"\x04\x00\x00\x00zstd")
    for at in (name - 36, name + 8):  # length of the chunk's record, and of the bytes in it
        for length in (2**31, 2**63 - 1, 2**64 - 1):
            (tmp_path / "run.mcap").write_bytes(whole[:at] + struct.pack("<Q", length) + whole[at + 8 :])
            tracemalloc.start()
            refused(tmp_path / "run.mcap")
            assert tracemalloc.get_traced_memory()[1] < 5_000_000
            tracemalloc.stop()


def test_a_file_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"cannot be written \(No such file.*run\.mcap$"):
        McapSink(tmp_path / "nowhere" / "run.mcap", INFO)
    full = Path("/dev/full")
    if not full.exists():
        pytest.skip("there is no /dev/full here")
    with pytest.raises(RecordingError, match=r"cannot be written \(No space left on device\): /dev/full"):
        McapSink(full, INFO)


def test_a_signal_waits_until_the_record_is_whole() -> None:
    done = []
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored where tests run in the background
    try:
        with pytest.raises(KeyboardInterrupt), held_signals():  # noqa: PT012  # what follows the signal is the claim
            signal.raise_signal(signal.SIGINT)
            done.append("the rest")
    finally:
        signal.signal(signal.SIGINT, before)
    assert done == ["the rest"]


class Listener:
    """A sink that is sent a signal with its first record."""

    def __init__(self, *, signalled: bool) -> None:
        self.steps: list[int] = []
        self._signalled = signalled

    def write(self, step: int, record: Record) -> None:
        if self._signalled:
            signal.raise_signal(signal.SIGTERM)
        self.steps.append(step)
        assert record.topic

    def close(self) -> None:
        """Nothing to finish."""


def test_after_a_signal_all_sinks_have_the_same_records() -> None:
    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    sinks = [Listener(signalled=True), Listener(signalled=False)]
    before = signal.signal(signal.SIGTERM, stop)
    try:
        with pytest.raises(KeyboardInterrupt):
            Recorder(sinks)(run()[0])
    finally:
        signal.signal(signal.SIGTERM, before)
    assert [sink.steps for sink in sinks] == [[0], [0]]
