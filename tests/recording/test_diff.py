"""Comparisons: what differs is found, named with its place, and nothing else is."""

from __future__ import annotations

import dataclasses
import weakref
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, ClassVar

import numpy as np
import pytest
from commands import Command
from numpy.typing import NDArray
from random_records import RECORDS, random_record
from small_recording import altered, small, small_run, write

from vdoor.frame import Frame
from vdoor.method.search.generation import Generation
from vdoor.record import Record, Spec, equal, specs
from vdoor.recording.compare import Difference, differences, distance, unequal
from vdoor.recording.diff import Pair, compare, settings_that_differ


def only(one: Record, other: Record) -> Difference:
    (found,) = differences(one, other)
    return found


@pytest.mark.parametrize("kind", RECORDS)
def test_a_record_equals_itself_infinities_and_nans_included(kind: type[Record]) -> None:
    for seed in range(20):
        one, same = (random_record(kind, np.random.default_rng(seed)) for _ in range(2))
        assert not list(differences(one, same))


@pytest.mark.parametrize("kind", RECORDS)
def test_whatever_array_is_changed_is_the_one_that_differs(kind: type[Record]) -> None:
    rng = np.random.default_rng(0)
    sizes = dict.fromkeys((axis for spec, _ in specs(kind).values() for axis in spec.axes if not axis.isdigit()), 5)
    record = random_record(kind, rng, sizes=sizes)
    for name, (spec, dtype) in specs(kind).items():
        if dtype is None:
            continue
        values = np.array(getattr(record, name))
        index = tuple(int(rng.integers(length)) for length in values.shape)
        was = values[index]
        values[index] = not was if dtype == np.bool_ else 1 if np.isfinite(was) and abs(was) < 0.5 else 0
        other = dataclasses.replace(record, **{name: values})  # type: ignore[type-var]  # a dataclass
        assert not equal(record, other)
        found = only(record, other)
        assert (found.field, found.count) == (name, 1)
        assert found.worst.index == (index if spec.kind in ("occupancy", "codes", "labels") else index[:1])


class Walls(Record):
    """A record with a bit of everything that has a place."""

    topic: ClassVar[str] = "walls"

    cell: Annotated[NDArray[np.int32], Spec("cell", "corner 2")]
    angle_rad: Annotated[NDArray[np.float64], Spec("column", "corner", unit="rad", tolerance=1e-9)]
    exact: Annotated[NDArray[np.float64], Spec("column", "corner")]
    kind: Annotated[NDArray[np.uint8], Spec("code", "corner", words=("wall", "tip"))]
    end_m: Annotated[NDArray[np.float64], Spec("column", "line 2", unit="m", tolerance=1e-9)]
    raster: Annotated[NDArray[np.int8], Spec("occupancy", "height width")]
    frame: Frame


FRAME = Frame(4, 6, 0.5, x_m=1.0, y_m=2.0)
WALLS = Walls(
    cell=np.array([[0, 0], [1, 2], [3, 5]], np.int32),
    angle_rad=np.array([0.0, np.inf, np.nan]),
    exact=np.array([0.0, np.inf, np.nan]),
    kind=np.array([0, 1, 0], np.uint8),
    end_m=np.array([[1.25, 3.75], [2.25, 3.25]]),
    raster=np.zeros((4, 6), np.int8),
    frame=FRAME,
)


def test_the_worst_element_comes_with_values_unit_and_place() -> None:
    found = only(WALLS, dataclasses.replace(WALLS, angle_rad=np.array([1e-6, np.inf, np.nan])))
    assert (found.field, found.count, found.total) == ("angle_rad", 1, 3)
    assert found.worst.index == (0,)
    assert (found.worst.expected, found.worst.found, found.worst.difference) == (0.0, 1e-6, 1e-6)
    assert (found.worst.unit, found.worst.cell, found.worst.place_m) == ("rad", (0.0, 0.0), (1.25, 3.75))


def test_the_worst_of_several_is_the_largest_and_a_number_beside_none_is_infinitely_far() -> None:
    found = only(WALLS, dataclasses.replace(WALLS, cell=WALLS.cell + np.array([[0, 1], [3, 0], [0, 2]], np.int32)))
    assert (found.count, found.worst.index, found.worst.difference, found.worst.unit) == (3, (1,), 3.0, "cells")
    assert (found.worst.expected, found.worst.found) == ((1, 2), (4, 2))
    found = only(WALLS, dataclasses.replace(WALLS, angle_rad=np.array([5.0, np.inf, 0.0])))
    assert (found.count, found.worst.index, found.worst.difference) == (2, (2,), np.inf)


def test_rasters_words_and_metres_have_places_too() -> None:
    raster = np.array(WALLS.raster)
    raster[3, 5] = 100
    assert only(WALLS, dataclasses.replace(WALLS, raster=raster)).worst.place_m == (3.75, 2.25)
    worst = only(WALLS, dataclasses.replace(WALLS, kind=np.array([0, 0, 0], np.uint8))).worst
    assert (worst.expected, worst.found, worst.difference, worst.place_m) == ("tip", "wall", None, (2.25, 3.25))
    ends = WALLS.end_m + np.array([[0, 0], [0, 0.5]])
    assert only(WALLS, dataclasses.replace(WALLS, end_m=ends)).worst.cell == (1.0, 2.0)


def test_tolerance_is_a_bound_and_none_means_bit_for_bit() -> None:
    assert not list(differences(WALLS, dataclasses.replace(WALLS, angle_rad=np.array([1e-9, np.inf, np.nan]))))
    assert only(WALLS, dataclasses.replace(WALLS, exact=np.array([5e-324, np.inf, np.nan]))).field == "exact"
    assert only(WALLS, dataclasses.replace(WALLS, exact=np.array([-0.0, np.inf, np.nan]))).field == "exact"
    far = np.array([1.7e308, -np.inf, np.inf])
    assert unequal(far, -far, 1e-9).all()
    assert distance(far, far).tolist() == [0.0, 0.0, 0.0]


def test_more_rows_are_one_difference_where_the_tables_part() -> None:
    more = {name: np.insert(getattr(WALLS, name), 1, getattr(WALLS, name)[0], axis=0)
            for name in ("cell", "angle_rad", "exact", "kind")}  # fmt: skip
    found = only(WALLS, dataclasses.replace(WALLS, **more))
    assert (found.field, found.count, found.worst.index) == ("corner rows", 1, (1,))
    assert (found.worst.expected, found.worst.found, found.worst.cell) == (3, 4, (0.0, 0.0))
    none = dataclasses.replace(WALLS, end_m=np.zeros((0, 2)))
    assert only(WALLS, none).worst.place_m == (1.25, 3.75)


def test_frames_and_sizes_of_rasters_are_compared() -> None:
    moved = dataclasses.replace(FRAME, x_m=1.0 + 1e-12)
    assert only(WALLS, dataclasses.replace(WALLS, frame=moved)).field == "frame.x_m"
    wide = dataclasses.replace(FRAME, width=7)
    found = list(differences(WALLS, dataclasses.replace(WALLS, frame=wide, raster=np.zeros((4, 7), np.int8))))
    assert [difference.field for difference in found] == ["frame.width", "raster"]
    assert (found[1].worst.expected, found[1].worst.found) == ("4 x 6", "4 x 7")


def test_bits_lie_where_the_table_of_another_record_has_them() -> None:
    records = altered("generation", "removed", 0, lambda bit: not bit)
    stage = next(stage for stage in compare(small_run()[1], records, types=RECORDS).stages if not stage.equal)
    assert stage.first is not None
    (found,) = stage.first.differences
    initial: Any = next(record for record in records if record.topic == "initial_map")
    assert found.worst.cell == tuple(map(float, initial.start[0]))


def test_a_generation_more_pairs_the_others_and_the_end() -> None:
    _, records = small_run()
    last = max(i for i, record in enumerate(records) if isinstance(record, Generation))
    more = [*records[: last + 1], records[last], *records[last + 1 :]]
    for one, other, counts in ((records, more, (4, 5)), (more, records, (5, 4))):
        report = compare(one, other, types=RECORDS)
        assert [stage.topic for stage in report.stages if not stage.equal] == ["generation"]
        assert report.first is not None
        assert (report.first.expected, report.first.found, report.first.differing) == (*counts, 1)
        assert report.first.first is not None
        assert (report.first.first.rank, report.first.first.differences) == (4, ())


def test_a_missing_stage_differs_wherever_it_is() -> None:
    _, records = small_run()
    for left_out in (record for record in records if not isinstance(record, Generation)):
        fewer = [record for record in records if record is not left_out]
        for one, other in ((records, fewer), (fewer, records)):
            report = compare(one, other, types=RECORDS)
            assert [stage.topic for stage in report.stages if not stage.equal] == [left_out.topic]


def test_only_one_record_of_each_run_is_held_at_a_time() -> None:
    alive: weakref.WeakSet[Record] = weakref.WeakSet()
    most = 0

    def many() -> Iterator[Record]:
        nonlocal most
        rng = np.random.default_rng(0)
        for _ in range(50):
            record = random_record(Generation, rng, sizes={"edge": 10})
            alive.add(record)
            most = max(most, len(alive))
            yield record
            del record

    report = compare(many(), many(), types=RECORDS)
    assert report.equal
    assert most <= 4  # one of each in the comparison, one of each in the making


def test_a_listener_hears_every_pair_with_both_records() -> None:
    heard: list[Pair] = []
    records = altered("path", "arc_m", 3, lambda arc_m: arc_m + 1e-6)
    compare(small_run()[1], records, types=RECORDS, listen=heard.append)
    assert [(pair.topic, pair.rank) for pair in heard][-3:] == [("generation", 2), ("generation", 3), ("map", 0)]
    assert [pair.topic for pair in heard if pair.differs] == ["path"]
    assert all(pair.found is record for pair, record in zip(heard, records, strict=True))


def test_settings_that_differ_are_named_one_by_one() -> None:
    one = {"search": {"method": "genetic", "population": 50}, "seed": 1}
    other = {"search": {"method": "annealing", "steps": 9}, "seed": 1}
    found = [(setting.name, setting.expected, setting.found) for setting in settings_that_differ(one, other)]
    assert found == [
        ("search.method", "genetic", "annealing"),
        ("search.population", 50, None),
        ("search.steps", None, 9),
    ]


def test_diff_says_settings_first_then_the_first_stage_in_full_then_counts(tmp_path: Path, command: Command) -> None:
    info, _ = small_run()
    one = small(tmp_path / "one.mcap")
    records = altered("path", "arc_m", 3, lambda arc_m: arc_m + 1e-6)
    records[3] = dataclasses.replace(records[3], angle_rad=records[3].angle_rad + 1)  # type: ignore[attr-defined,type-var]  # curvature
    settings = {**info.settings, "doors": {**info.settings["doors"], "max_length_m": 1.0}}
    other = write(tmp_path / "other.mcap", records, dataclasses.replace(info, settings=settings))
    done = command("diff", one, other)
    setting, first, worst, later = done.out.splitlines()
    assert setting == "doors.max_length_m: A 1.2, B 1.0"
    assert first == "path differs first: 1 element"
    assert worst.startswith("  arc_m: 1 of 44 differ, worst at 3 (cell ")
    assert worst.endswith("e-06 m apart")
    assert later == "curvature differs too: 44 elements"
    assert done.code == 1
    assert command("diff", one, one) == (0, "equal\n", "")
    told = command("diff", one, other, "--json").json
    assert told["settings"] == [{"name": "doors.max_length_m", "expected": 1.2, "found": 1.0}]
    assert command("diff", one, tmp_path / "none.mcap").code == 2
