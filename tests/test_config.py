"""Settings: out and back again, and errors that say what was wanted."""

from __future__ import annotations

import dataclasses
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from maps import law

from vdoor.config import all_settings_of, parse_assignments, read_toml, settings_of, to_toml, with_settings
from vdoor.errors import SettingError
from vdoor.method.scoring.score import NoScores, ScoreDoors
from vdoor.method.search.certificate import NoProof
from vdoor.method.search.optimisers import AnnealingSearch, ExhaustiveSearch, GeneticSearch
from vdoor.method.simplify import SimplifyGrid
from vdoor.pipeline import METHODS, PRESETS, Pipeline

CHOICES = METHODS


def changed(*assignments: str, pipeline: Pipeline | None = None) -> Pipeline:
    return with_settings(pipeline or Pipeline(), parse_assignments(assignments), CHOICES)


@pytest.mark.parametrize("preset", PRESETS)
def test_settings_go_out_as_toml_and_come_back(preset: str, tmp_path: Path) -> None:
    pipeline = PRESETS[preset]
    path = tmp_path / "settings.toml"
    path.write_text(to_toml(pipeline, CHOICES), encoding="utf-8")
    other = dataclasses.replace(pipeline, simplify=SimplifyGrid(cell_m=0.07, passes=9))
    if isinstance(pipeline, Pipeline):
        other = PRESETS["default" if preset == "paper" else "paper"]
    assert with_settings(other, read_toml(path), CHOICES) == pipeline
    assert with_settings(other, settings_of(pipeline, CHOICES), CHOICES) == pipeline


def test_every_setting_is_in_the_file_with_its_meaning_above_it() -> None:
    text = to_toml(Pipeline(), CHOICES)
    tables = all_settings_of(Pipeline(), CHOICES)
    assert tomllib.loads(text) == {name: table for name, table in tables.items() if table}
    assert "# Longest door, between the centres of its end cells. (0 to 20)\nmax_length_m = 1.2\n" in text
    assert '# One of genetic, exhaustive, annealing, memetic\nmethod = "genetic"\n' in text


def test_a_stage_that_is_left_out_is_in_the_file_by_its_method_alone() -> None:
    tables = tomllib.loads(to_toml(Pipeline(), CHOICES))
    assert (tables["score"], tables["certify"]) == ({"method": "none"}, {"method": "none"})
    back = with_settings(PRESETS["default"], {name: tables[name] for name in ("score", "certify")}, CHOICES)
    assert isinstance(PRESETS["default"], Pipeline)
    assert isinstance(PRESETS["default"].score, ScoreDoors)
    assert (back.score, back.certify, back.doors) == (NoScores(), NoProof(), PRESETS["default"].doors)


@settings(law, max_examples=25)
@given(
    cell_m=st.floats(0, 10),
    robot_m=st.lists(st.floats(-1e6, 1e6), min_size=2, max_size=2),
    passes=st.integers(0, 100),
    method=st.sampled_from(sorted(METHODS["search"])),
)
def test_values_survive_the_round_trip_to_the_last_bit(
    cell_m: float, robot_m: list[float], passes: int, method: str
) -> None:
    tables = {"simplify": {"cell_m": cell_m, "robot_m": robot_m, "passes": passes}, "search": {"method": method}}
    pipeline = with_settings(Pipeline(), tables, CHOICES)
    assert with_settings(Pipeline(), tomllib.loads(to_toml(pipeline, CHOICES)), CHOICES) == pipeline
    assert (pipeline.simplify.cell_m, pipeline.simplify.robot_m) == (cell_m, tuple(robot_m))


def test_a_file_may_name_some_settings_and_leaves_the_others() -> None:
    pipeline = changed("doors.max_length_m=2", "simplify.robot_m=[1, 2.5]", "simplify.passes=0")
    assert pipeline.doors.max_length_m == 2.0
    assert isinstance(pipeline.doors.max_length_m, float)
    assert pipeline.simplify.robot_m == (1.0, 2.5)
    assert pipeline.simplify.cell_m == Pipeline().simplify.cell_m
    assert pipeline.corners is Pipeline().corners or pipeline.corners == Pipeline().corners


def test_the_search_is_chosen_by_its_method_and_keeps_settings_of_the_same_method() -> None:
    assert changed("search.method=annealing").search == AnnealingSearch()
    assert changed('search.method="exhaustive"', "search.most_edges=3").search == ExhaustiveSearch(most_edges=3)
    small = Pipeline(search=GeneticSearch(population=7))
    assert changed("search.method=genetic", "search.generations=2", pipeline=small).search == GeneticSearch(
        population=7, generations=2
    )
    assert changed("search.generations=2", "search.method=genetic", pipeline=small).search == GeneticSearch(
        population=7, generations=2
    )


@pytest.mark.parametrize(
    ("assignment", "message"),
    [
        ("door.max_length_m=1", "settings: no stage 'door'; did you mean 'doors'?"),
        ("xyz.a=1", "settings: no stage 'xyz'; wanted one of simplify, trace, "),
        ("doors.max_lenght_m=1", "settings: doors: no setting 'max_lenght_m'; did you mean 'max_length_m'?"),
        ("merge.anything=1", "settings: merge: no setting 'anything'; wanted one of "),
        ("search.method=genetics", "settings: search: no method 'genetics'; did you mean 'genetic'?"),
        ("search.method=3", "settings: search: no method '3'; wanted one of genetic, exhaustive, annealing"),
        ("search.evaluations=3", "settings: search: no setting 'evaluations'; did you mean 'generations'?"),
        ("doors.max_length_m=long", "settings: doors.max_length_m: wanted a finite number, found 'long'"),
        ("doors.max_length_m=nan", "settings: doors.max_length_m: wanted a finite number, found nan"),
        ("doors.max_length_m=inf", "settings: doors.max_length_m: wanted a finite number, found inf"),
        ("doors.max_length_m=true", "settings: doors.max_length_m: wanted a finite number, found True"),
        ("doors.max_length_m=21", "settings: doors.max_length_m: wanted 0 to 20, found 21"),
        ("doors.max_length_m=-0.1", "settings: doors.max_length_m: wanted 0 to 20, found -0.1"),
        ("doors.max_length_m=", "settings: doors.max_length_m: wanted a finite number, found ''"),
        ("simplify.passes=2.5", "settings: simplify.passes: wanted a whole number, found 2.5"),
        ("simplify.passes=false", "settings: simplify.passes: wanted a whole number, found False"),
        ("simplify.robot_m=3", "settings: simplify.robot_m: wanted a list of finite numbers, found 3"),
        ('simplify.robot_m=["a", 1]', "settings: simplify.robot_m: wanted a list of finite numbers, found ['a', 1]"),
        ("search.population=1", "settings: search.population: wanted 2 to 100000, found 1"),
    ],
)
def test_a_wrong_setting_is_named_with_what_was_wanted(assignment: str, message: str) -> None:
    with pytest.raises(SettingError) as error:
        changed(assignment)
    assert str(error.value).startswith(message)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("robot", ["[1]", "[1, 2, 3]", "[nan, 1]", "[inf, 1]", "[true, 1]"])
def test_a_place_is_two_finite_numbers_or_none(robot: str) -> None:
    with pytest.raises(SettingError, match=r"simplify\.robot_m: wanted "):
        changed(f"simplify.robot_m={robot}")


@pytest.mark.parametrize("assignment", ["", "doors", "doors=1", "max_length_m=1", ".x=1", "doors.=1", "=1", "doors.x"])
def test_what_is_no_assignment_is_refused(assignment: str) -> None:
    with pytest.raises(SettingError, match=r"--set: wanted stage\.field=value, found"):
        parse_assignments([assignment])


def test_assignments_are_read_as_toml_and_the_last_one_wins() -> None:
    found = parse_assignments(["a.b=1", "a.c = [1, 2]", "a.d=word", 'a.e="1"', "a.b=2.5", "f.g=true", "f.h=a=b"])
    assert found == {"a": {"b": 2.5, "c": [1, 2], "d": "word", "e": "1"}, "f": {"g": True, "h": "a=b"}}


@pytest.mark.parametrize("value", [3, "text", [1]])
def test_a_stage_must_be_a_table(value: Any) -> None:
    with pytest.raises(SettingError, match=r"my\.toml: doors: wanted a table of settings, found"):
        with_settings(Pipeline(), {"doors": value}, CHOICES, place="my.toml")


def test_a_file_that_is_no_toml_is_named_last(tmp_path: Path) -> None:
    for content in (b"[doors\n", b"\xff\xfe"):
        path = tmp_path / "broken.toml"
        path.write_bytes(content)
        with pytest.raises(SettingError, match=r"settings file: wanted TOML, found: .*broken\.toml$"):
            read_toml(path)
    with pytest.raises(SettingError, match=r"file: wanted settings as TOML, found none: .*missing\.toml$"):
        read_toml(tmp_path / "missing.toml")


def test_a_stage_may_be_any_dataclass() -> None:
    @dataclass(frozen=True)
    class Stage:
        name: str = "a"
        on: bool = False

    @dataclass(frozen=True)
    class Whole:
        stage: Stage = Stage()

    assert with_settings(Whole(), {"stage": {"name": "b", "on": True}}, {}) == Whole(Stage("b", on=True))
    with pytest.raises(SettingError, match=r"settings: stage\.name: wanted a string, found 1"):
        with_settings(Whole(), {"stage": {"name": 1}}, {})
    with pytest.raises(SettingError, match=r"settings: stage\.on: wanted true or false, found 1"):
        with_settings(Whole(), {"stage": {"on": 1}}, {})
