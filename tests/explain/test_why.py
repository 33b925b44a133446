"""`vdoor why`: on maps small enough to know each answer by hand, and as laws over a whole apartment."""

from __future__ import annotations

import dataclasses
import json
import math
from pathlib import Path

import numpy as np
import pytest
from commands import call
from maps import CELL_M, drawn
from terminals import history, recorded
from two_rooms import DOOR_M, PROVEN, TWO_ROOMS

from vdoor.errors import RecordingError, SettingError
from vdoor.explain import explain
from vdoor.explain.corners import sample_fate
from vdoor.explain.doors import door_fate
from vdoor.explain.text import to_lines
from vdoor.history import History
from vdoor.history.records import ConvergenceHistory
from vdoor.method.corners import Corners, cosine, gaps_m
from vdoor.method.doors import VERDICTS, VirtualDoors
from vdoor.method.search.costs import MapCost
from vdoor.method.search.generation import Generation
from vdoor.method.search.incremental import FlipState
from vdoor.method.simplify import SimplifiedGrid, SimplifyGrid
from vdoor.pipeline import RECORDS, Pipeline
from vdoor.record import Record
from vdoor.recording.mcap import McapSink, read_recording
from vdoor.synth import PRESETS, synthesize


def cost_of(areas_m2: list[float]) -> float:
    """Eq. 7 with doors along the axes only, by hand."""
    cost = MapCost()
    deviation_m2 = math.sqrt(sum((area - cost.room_m2) ** 2 for area in areas_m2) / len(areas_m2))
    return cost.small_weight * sum(area < cost.room_m2 for area in areas_m2) + cost.area_weight_per_m2 * deviation_m2


@pytest.fixture(scope="module")
def two_rooms(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorded(tmp_path_factory.mktemp("two"), drawn(TWO_ROOMS), PROVEN)


@pytest.fixture(scope="module")
def apartment(tmp_path_factory: pytest.TempPathFactory) -> History:
    made = synthesize(PRESETS["paper"], np.random.default_rng(3))
    return history(recorded(tmp_path_factory.mktemp("apartment"), made.grid))


def test_a_door_is_told_with_its_numbers_rooms_and_cost(two_rooms: Path) -> None:
    answer = explain(history(two_rooms), DOOR_M)
    door = answer.doors[0]
    assert (door.kind, door.verdict, door.fate, door.away_m) == ("pair", "proposed", "door", 0.0)
    assert (door.length_m, door.width_m, door.tilt_deg) == pytest.approx((5 * CELL_M, 4 * CELL_M, 0))
    assert door.gap_m is not None
    assert door.gap_m > door.least_gap_m == pytest.approx(1.5 * 5 * CELL_M)
    assert (door.edge, door.regions, door.idle) == (0, (0, 1), False)
    assert (door.final_door, door.final_rooms) == ((1,), ((1, 2),))
    room_m2, sill_m2 = 9 * 12 * CELL_M**2, 4 * CELL_M**2
    assert door.search is not None
    assert not door.search.removed
    assert door.search.cost == pytest.approx(cost_of([room_m2, room_m2]))
    assert door.search.cost_flipped == pytest.approx(cost_of([2 * room_m2 + sill_m2]))
    jambs = answer.corners[:2]
    assert all((jamb.convex, jamb.doors) == (True, (0,)) for jamb in jambs)
    assert [jamb.away_m for jamb in jambs] == pytest.approx([2.5 * CELL_M] * 2)


def test_a_gap_too_wide_is_told_by_the_distance_of_its_jambs(tmp_path: Path) -> None:
    rows = TWO_ROOMS.split()
    rows[3:10] = [rows[5]] * 7
    wide = "\n".join(rows)
    run = history(recorded(tmp_path, drawn(wide), PROVEN))
    answer = explain(run, DOOR_M)
    jamb = answer.corners[0]
    assert jamb.nearest_convex_m == pytest.approx(8 * CELL_M)
    assert (jamb.convex, jamb.doors) == (True, ())
    assert answer.doors == ()
    assert "1.60 m away" in "\n".join(to_lines(answer))


def test_what_stands_in_a_doorway_is_named_by_its_cell(tmp_path: Path) -> None:
    rows = TWO_ROOMS.split()
    rows[6] = rows[6][:10] + "#" + rows[6][11:]
    run = history(recorded(tmp_path, drawn("\n".join(rows)), PROVEN))
    jambs = {(4, 10), (9, 10)}
    ends = zip(run.doors.start.tolist(), run.doors.end.tolist(), strict=True)
    across = [door for door, pair in enumerate(ends) if {tuple(cell) for cell in pair} == jambs]
    assert [door_fate(run, door).fate for door in across] == ["blocked"]
    assert door_fate(run, across[0]).blocked_at == (10, 6)


@pytest.mark.parametrize(
    ("change", "cell", "says"),
    [
        ((1, 4, "#"), (4, 1), ("free", "jut")),
        ((0, 4, "."), (4, 0), ("occupied", "notch")),
        ((0, 0, "#"), (4, 4), ("free", "as it was")),
    ],
)
def test_simplification_is_told_at_the_cell(
    tmp_path: Path, change: tuple[int, int, str], cell: tuple[int, int], says: tuple[str, str]
) -> None:
    rows = ["?" * 21, *TWO_ROOMS.split()]
    row, col, sign = change
    rows[row + 1] = rows[row + 1][:col] + sign + rows[row + 1][col + 1 :]
    run = history(recorded(tmp_path, drawn("\n".join(rows)), PROVEN))
    x_m, y_m = run.input.frame.world_from_cell(np.array([[cell[1] + 1, cell[0]]]))[0].tolist()
    place = explain(run, (x_m, y_m)).place
    assert place.working_col_row == (cell[0], cell[1] + 1)
    assert (place.state, place.reason) == says


@pytest.mark.parametrize("kind", ["paper", "paper-5cm"])
def test_every_candidate_is_a_peak_or_suppressed_by_a_sharper_one_of_its_kind(tmp_path: Path, kind: str) -> None:
    furnished = dataclasses.replace(PRESETS[kind], furniture=True)
    pipeline = Pipeline(simplify=SimplifyGrid(cell_m=0.0))
    run = history(recorded(tmp_path, synthesize(furnished, np.random.default_rng(0)).grid, pipeline, until=Corners))
    path = run.path
    fates = [sample_fate(run, int(sample)) for sample in run.candidates.sample]
    assert {fate.decision for fate in fates} == {"corner", "plateau", "suppressed"}
    assert sorted(fate.corner for fate in fates if fate.decision == "corner") == list(range(len(run.corners.sample)))
    sharpness, convex = cosine(run.curvature), dict(zip(run.candidates.sample, run.candidates.convex, strict=True))
    for fate in fates:
        if fate.decision == "suppressed":
            gap_m = gaps_m(path, np.array([fate.sample], np.int32), np.array([fate.rival], np.int32))[0]
            assert sharpness[fate.rival] > sharpness[fate.sample]
            assert convex[fate.rival] == convex[fate.sample]
            assert fate.rival_gap_m == gap_m <= fate.window_m + 1e-9
        elif fate.decision == "plateau":
            middle = run.corners.sample[fate.corner]
            assert sharpness[middle] == sharpness[fate.sample]


def test_samples_that_are_no_candidates_are_straight(apartment: History) -> None:
    others = np.setdiff1d(np.arange(len(apartment.path.cell)), apartment.candidates.sample)
    assert all(sample_fate(apartment, int(sample)).decision == "straight" for sample in others)
    assert all(sample_fate(apartment, int(sample)).angle_deg >= 155 - 1e-9 for sample in others)


def test_fates_of_all_doors_add_up_to_what_each_stage_recorded(apartment: History) -> None:
    run = apartment
    fates = [door_fate(run, door) for door in range(len(run.doors.verdict))]
    for code, verdict in enumerate(VERDICTS[1:], start=1):
        assert sum(fate.fate == verdict for fate in fates) == (run.doors.verdict == code).sum()
    removed = run.search[-1].removed
    kept = set(np.flatnonzero(~removed).tolist())
    in_map = set(run.topology.edge.tolist()) - {-1}
    assert {fate.edge for fate in fates if fate.fate == "removed"} == set(np.flatnonzero(removed).tolist())
    assert {fate.edge for fate in fates if fate.fate == "door"} == in_map
    assert {fate.edge for fate in fates if fate.separates_nothing} == kept - in_map
    assert {fate.edge for fate in fates if fate.fate == "separates nothing"} == kept - in_map
    assert kept - in_map, "this apartment shall have doors that separate nothing"
    assert [fate.door for fate in fates if fate.idle] == run.initial.idle_door.tolist()


def test_cost_of_a_flip_is_what_annealing_reckons(apartment: History) -> None:
    removed = np.flatnonzero(apartment.search[-1].removed).tolist()
    for edge, door in enumerate(apartment.initial.door.tolist()):
        search = door_fate(apartment, door).search
        assert search is not None
        assert search.cost == FlipState(apartment.problem, removed).cost
        assert search.cost_flipped == FlipState(apartment.problem, set(removed) ^ {edge}).cost


def test_last_change_is_the_generation_from_which_on_the_best_string_keeps_the_bit(two_rooms: Path) -> None:
    run = history(two_rooms)
    course = ConvergenceHistory()
    for number, bit in enumerate([True, False, False, True, False, False]):
        course.add(dataclasses.replace(run.search[0], number=number, removed=np.array([bit])))
    search = door_fate(dataclasses.replace(run, search=course), 0).search
    assert search is not None
    assert (search.last_change, search.changes, search.last_generation, search.removed) == (4, 3, 5, False)
    never = ConvergenceHistory()
    never.add(dataclasses.replace(run.search[0], number=0, removed=np.array([True])))
    search = door_fate(dataclasses.replace(run, search=never), 0).search
    assert search is not None
    assert (search.last_change, search.changes, search.removed) == (0, 0, True)


def test_course_gives_back_every_generation(apartment: History) -> None:
    rng = np.random.default_rng(0)
    made, course = [], ConvergenceHistory()
    for number in range(20):
        one = dataclasses.replace(
            apartment.search[0], number=number, removed=rng.random(13) < 0.5, mean_cost=rng.random()
        )
        made.append(one)
        course.add(one)
    assert len(course) == 20
    for one, again in zip(made, course, strict=True):
        assert (one.number, one.mean_cost, type(again.number)) == (again.number, again.mean_cost, int)
        assert np.array_equal(one.removed, again.removed)
    for edge in range(13):
        assert course.choices(edge).tolist() == [bool(one.removed[edge]) for one in made]
    with pytest.raises(RecordingError, match="13"):
        course.add(dataclasses.replace(made[0], removed=np.zeros(12, np.bool_)))


@pytest.mark.parametrize("last", [None, Corners, VirtualDoors, Generation])
def test_recording_that_ends_early_is_told_as_far_as_it_goes(tmp_path: Path, last: type[Record] | None) -> None:
    run = history(recorded(tmp_path, drawn(TWO_ROOMS), PROVEN, until=last))
    answer = explain(run, DOOR_M)
    text = "\n".join(to_lines(answer))
    assert ("the results of later stages are unknown" in text) == (last is not None)
    assert bool(run.damage) == (last is not None)
    assert bool(answer.doors) == (last is not Corners)
    if last is VirtualDoors:
        assert answer.doors[0].fate == "open"
    if last is Generation:
        assert answer.doors[0].search is not None


def test_point_off_the_map_is_refused_by_name(two_rooms: Path) -> None:
    with pytest.raises(SettingError, match="on the map"):
        explain(history(two_rooms), (-0.3, 1.0))


def test_records_that_do_not_fit_together_are_refused(two_rooms: Path, tmp_path: Path) -> None:
    path = tmp_path / "unfit.mcap"
    recording = read_recording(two_rooms, types=RECORDS)
    sink = McapSink(path, recording.info)
    for step, record in recording:
        if isinstance(record, Corners):
            record = dataclasses.replace(record, sample=record.sample + 10_000)  # noqa: PLW2901  # that is the point
        sink.write(step, record)
    sink.close()
    error = call("why", path, "--at", "2,1", code=2).stderr
    assert "corners.sample: wanted rows of path.cell" in error
    assert len(error.splitlines()) == 1


def test_command_tells_the_same_in_metres_in_cells_and_as_json(two_rooms: Path) -> None:
    text = call("why", two_rooms, "--at", "2.1,1.5").stdout
    assert call("why", two_rooms, "--at", "10,6", "--cells").stdout == text
    assert "final map: door 1 between rooms 1 and 2" in text
    answer = json.loads(call("why", two_rooms, "--at", "2.1,1.5", "--json").stdout)
    assert answer["doors"][0]["fate"] == "door"
    assert answer["doors"][0]["final_rooms"] == [[1, 2]]
    assert answer["place"]["col_row"] == [10, 6]


@pytest.mark.parametrize("at", ["1", "1,2,3", "a,b", "nan,1", "99,99", "1e308,1"])
def test_wrong_places_are_one_line_and_exit_code_2(two_rooms: Path, at: str) -> None:
    (said,) = call("why", two_rooms, "--at", at, code=2).stderr.splitlines()
    assert said.startswith("vdoor: --at: wanted")


def test_no_recording_is_one_line_and_exit_code_2(tmp_path: Path) -> None:
    stray = tmp_path / "stray.mcap"
    stray.write_text("nothing of the kind")
    for path in (stray, tmp_path / "missing.mcap"):
        for command, *options in (["why", "--at", "1,1"], ["show"], ["step"]):
            error = call(command, path, *options, code=2).stderr
            assert len(error.splitlines()) == 1
            assert error.rstrip().endswith(str(path))


def test_a_stage_that_was_not_recorded_is_named_with_the_file(tmp_path: Path) -> None:
    path = recorded(tmp_path, drawn(TWO_ROOMS), PROVEN, until=SimplifiedGrid)
    with pytest.raises(RecordingError, match=f"^stage doors: not recorded, the last one is simplified: {path}$"):
        _ = history(path).doors
