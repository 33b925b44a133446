"""Every type of record becomes messages and comes back bit for bit; what is no such message is refused by name."""

from __future__ import annotations

import struct
import tracemalloc
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_records import RECORDS, random_record

from vdoor.errors import RecordingError
from vdoor.frame import Frame
from vdoor.grid import OccupancyGrid
from vdoor.method.corners import Corners
from vdoor.method.scoring.features import FEATURES
from vdoor.method.scoring.score import DoorScores
from vdoor.method.search.generation import Generation
from vdoor.method.simplify import REASONS, SimplifiedGrid
from vdoor.record import Record, equal, specs
from vdoor.recording import codec, ros
from vdoor.recording.columns import told
from vdoor.topology import TopologicalMap

TIME_NS = 1_577_836_800_000_000_000
GRID = OccupancyGrid.from_array(np.array([[0, 100, -1], [0, 0, 50]], np.int8), 0.05, x_m=1.0, y_m=2.0)


def messages(record: Record) -> dict[str, bytes]:
    """CDR bytes of a record by the names of its parts."""
    return {topic.rpartition("/")[2]: bytes(data) for topic, _, data in codec.encode(record, time_ns=TIME_NS)}


def unpacked(record: Record, part: str) -> Any:
    return ros.unpack(messages(record)[part], codec.parts(type(record))[part].message)


def refused(record: Record, part: str, **changed: Any) -> str:
    """What decoding says about a record with some fields of one message changed."""
    message = unpacked(record, part)
    for name, value in changed.items():
        setattr(message, name, value)
    with pytest.raises(RecordingError) as caught:
        codec.decode(type(record), messages(record) | {part: ros.pack(message)})
    return str(caught.value)


@pytest.mark.parametrize("record", RECORDS, ids=lambda record: record.__name__)
@settings(max_examples=30, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32))
def test_every_record_survives_encode_and_decode_bit_for_bit(record: type[Record], seed: int) -> None:
    drawn = random_record(record, np.random.default_rng(seed))
    assert equal(codec.decode(record, messages(drawn)), drawn)


@pytest.mark.parametrize("record", RECORDS, ids=lambda record: record.__name__)
def test_a_record_with_nothing_in_it_survives(record: type[Record]) -> None:
    sizes = dict.fromkeys([axis for spec, _ in specs(record).values() for axis in spec.axes], 0)
    drawn = random_record(record, np.random.default_rng(0), sizes=sizes)
    assert equal(codec.decode(record, messages(drawn)), drawn)


def test_grid_is_right_side_up_in_the_message() -> None:
    message = unpacked(GRID, "cells")
    assert (message.info.width, message.info.height) == (3, 2)
    assert message.data.tolist() == [0, 0, 50, 0, 100, -1]


def test_grid_is_posed_by_the_frame() -> None:
    turned = OccupancyGrid.from_array(GRID.cells, 0.05, x_m=1.0, y_m=2.0, yaw_rad=np.pi / 3)
    origin = unpacked(turned, "cells").info.origin
    assert (origin.position.x, origin.position.y) == (1.0, 2.0)
    assert (origin.orientation.z, origin.orientation.w) == pytest.approx((0.5, np.sqrt(0.75)))


def test_points_lie_at_the_centres_of_their_cells() -> None:
    corners = Corners(
        cell=np.array([[0, 2], [3, 0]], np.int32),
        sample=np.array([7, 8], np.int32),
        quarter=np.zeros((2, 2), np.int32),
        angle_rad=np.array([1.0, np.inf]),
        convex=np.array([True, False]),
        frame=Frame(4, 4, 0.5, 10.0, 20.0),
    )
    message = unpacked(corners, "corner")
    assert [field.name for field in message.fields][:5] == ["x", "y", "z", "cell_0", "cell_1"]
    points = np.lib.stride_tricks.as_strided(message.data.view(np.float32), (2, 3), (message.point_step, 4))
    assert points.tolist() == [[11.25, 21.75, 0.0], [10.25, 20.25, 0.0]]


@pytest.mark.parametrize(("greatest", "encoding"), [(65_535, "16UC1"), (65_536, "32SC1")])
def test_labels_take_16_bits_where_they_fit(greatest: int, encoding: str) -> None:
    drawn = random_record(TopologicalMap, np.random.default_rng(0), sizes={"height": 1, "width": 2})
    labels = np.array([[0, greatest]], np.int32)
    assert unpacked(replace(drawn, labels=labels), "labels").encoding == encoding


def test_a_grid_that_lies_about_its_size_is_refused_without_room_for_it() -> None:
    info = unpacked(GRID, "cells").info
    info.width, info.height = 2**16, 2**15
    tracemalloc.start()
    assert "OccupancyGrid.cells: wanted 32768 x 65536 = 2147483648 elements, found 6" in refused(
        GRID, "cells", info=info
    )
    data = bytearray(messages(GRID)["cells"])
    data[-10:-6] = struct.pack("<I", 2**31)
    with pytest.raises(RecordingError, match=r"OccupancyGrid\.cells: wanted a nav_msgs/msg/OccupancyGrid message"):
        codec.decode(OccupancyGrid, messages(GRID) | {"cells": data})
    assert tracemalloc.get_traced_memory()[1] < 1_000_000
    tracemalloc.stop()


def test_a_table_that_lies_about_its_size_is_refused() -> None:
    corners = random_record(Corners, np.random.default_rng(0), sizes={"corner": 3})
    step = unpacked(corners, "corner").point_step
    assert "Corners.corner: wanted one row of points" in refused(corners, "corner", width=2**31, row_step=2**31)
    assert "Corners.corner: wanted one row of points" in refused(corners, "corner", width=4, row_step=4 * step)
    assert "Corners.corner: wanted one row of points" in refused(corners, "corner", height=0)


def test_an_image_that_lies_about_its_size_is_refused() -> None:
    simplified = random_record(SimplifiedGrid, np.random.default_rng(0), sizes={"height": 2, "width": 3})
    assert "SimplifiedGrid.reason: wanted 9 x 3 = 27 elements, found 6" in refused(simplified, "reason", height=9)
    assert "SimplifiedGrid.reason: wanted 4 bytes a row, found 3" in refused(simplified, "reason", width=4)


def test_rasters_of_another_size_than_the_frame_are_refused() -> None:
    one, other = (
        random_record(SimplifiedGrid, np.random.default_rng(0), sizes={"height": h, "width": 2}) for h in (2, 3)
    )
    with pytest.raises(RecordingError, match=r"SimplifiedGrid\.cells: wanted the frame's 2 x 2 cells, found 3 x 2"):
        codec.decode(SimplifiedGrid, messages(one) | {"cells": messages(other)["cells"]})


def test_columns_that_are_not_the_records_are_refused_by_name() -> None:
    corners = random_record(Corners, np.random.default_rng(0), sizes={"corner": 3})
    fields = unpacked(corners, "corner").fields
    assert "Corners.corner: wanted a column convex, found x, y" in refused(corners, "corner", fields=fields[:-1])
    fields[-1].name = "concave"
    assert "Corners.corner: wanted a column convex" in refused(corners, "corner", fields=fields)
    more = unpacked(corners, "corner").fields
    more.append(fields[-1])
    assert "found concave as well" in refused(corners, "corner", fields=more)
    other = unpacked(corners, "corner").fields
    other[-2].datatype = 7
    assert "Corners.corner.angle_rad: wanted FLOAT64" in refused(corners, "corner", fields=other)


def test_many_entries_of_one_column_are_told_by_the_first_and_the_last() -> None:
    names = ["x", "middle_0", "middle_1", *(f"feature_{k}" for k in range(39)), "rival_a", "a1", "a2", "a3", "a4", "a5"]
    assert told(names) == "x, middle_0, middle_1, feature_0 to feature_38, rival_a, a1, a2, a3, a4, a5"
    scores = random_record(DoorScores, np.random.default_rng(0), sizes={"scored": 2})
    fields = [field for field in unpacked(scores, "scored").fields if field.name != "feature_39"]
    said = refused(scores, "scored", fields=fields)
    assert "wanted a column feature_39, found x, y, z, " in said
    assert f"feature_0 to feature_38, feature_40 to feature_{len(FEATURES) - 1}, sure" in said


def test_values_that_no_stage_gives_are_refused() -> None:
    assert "OccupancyGrid.cells: wanted values to 100, found 101" in refused(
        GRID, "cells", data=np.array([101, 0, 0, 0, 0, 0], np.int8)
    )
    simplified = random_record(SimplifiedGrid, np.random.default_rng(0), sizes={"height": 1, "width": 1})
    assert f"SimplifiedGrid.reason: wanted values to {len(REASONS) - 1}, found {len(REASONS)}" in refused(
        simplified, "reason", data=np.array([len(REASONS)], np.uint8)
    )
    assert "wanted 8UC1 little endian, found 'rgb8'" in refused(simplified, "reason", encoding="rgb8")
    generation = random_record(Generation, np.random.default_rng(0), sizes={"edge": 1})
    assert "Generation.removed: wanted values to 1, found 2" in refused(
        generation, "removed", data=np.array([2], np.uint8)
    )


def test_flags_of_another_table_are_refused() -> None:
    generation = random_record(Generation, np.random.default_rng(0), sizes={"edge": 2})
    layout = unpacked(generation, "removed").layout
    layout.dim[0].label = "door"
    assert "wanted 2 flags along edge, found [('door', 2)]" in refused(generation, "removed", layout=layout)
    assert "wanted 1 flags along edge" in refused(generation, "removed", data=np.zeros(1, np.uint8))


def test_numbers_that_are_not_the_records_are_refused_by_name() -> None:
    generation = random_record(Generation, np.random.default_rng(0))
    data = unpacked(generation, "values").data.copy()
    data[0] = 0.5
    assert "Generation.values.number: wanted a whole number, found 0.5" in refused(generation, "values", data=data)
    layout = unpacked(generation, "values").layout
    layout.dim[0].label = "rank"
    assert "Generation.values: wanted number, evaluations" in refused(generation, "values", layout=layout)
    assert "a raster" in refused(GRID, "values", data=np.array([2.0, 3.0, -1.0, 0.0, 0.0, 0.0]))


def test_an_integer_that_a_float_does_not_hold_is_refused_when_written() -> None:
    drawn = random_record(Generation, np.random.default_rng(0))
    with pytest.raises(RecordingError, match=r"Generation\.values\.number: wanted at most 2\^53"):
        messages(replace(drawn, number=2**53 + 1))


def test_a_part_that_is_missing_or_unknown_is_named() -> None:
    parts = messages(GRID)
    with pytest.raises(RecordingError, match="OccupancyGrid: wanted the parts cells, values, found values"):
        codec.decode(OccupancyGrid, {"values": parts["values"]})
    with pytest.raises(RecordingError, match="found cells, values, rooms"):
        codec.decode(OccupancyGrid, parts | {"rooms": parts["values"]})


@settings(max_examples=30, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32))
def test_damaged_messages_are_refused_or_are_records_still(seed: int) -> None:
    rng = np.random.default_rng(seed)
    record = RECORDS[rng.integers(len(RECORDS))]
    parts = messages(random_record(record, rng))
    name = str(rng.choice(list(parts)))
    data = bytearray(parts[name])
    data[rng.integers(len(data))] ^= 1 << int(rng.integers(8))
    cut = int(rng.integers(len(data))) if rng.random() < 0.5 else len(data)
    try:
        codec.decode(record, parts | {name: bytes(data[:cut])})
    except RecordingError as error:
        assert str(error).startswith(record.__name__)  # noqa: PT017  # most damage to a message is no error
