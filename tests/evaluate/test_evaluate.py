"""`vdoor evaluate` as its users meet it: results and references as files, real processes."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import call
from PIL import Image
from project import HOME
from rerun.chunk import RrdReader

from vdoor.errors import VdoorError
from vdoor.evaluate import MapChoice, evaluate_case, matched

MAPS = HOME / "recordings"
CELL_M = 0.05


def told(*words: str | Path, code: int = 0) -> Any:
    return json.loads(call("evaluate", *words, "--json", code=code).stdout)


def drawn(folder: Path, *, furnished: bool = False) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    """Two rooms of 60 x 40 cells and a doorway of 18 between them, shut by furniture if there is any."""
    folder.mkdir(exist_ok=True)
    grey = np.zeros((44, 126), np.uint8)
    grey[2:42, 2:62] = grey[2:42, 64:124] = 254
    grey[10:28, 62:64] = 254
    if furnished:
        grey[8:30, 50:58] = grey[10:28, 62:64] = 0
    labels = np.zeros(grey.shape, np.uint16)
    labels[2:42, 2:62], labels[2:42, 64:124] = 1, 2
    labels[10:28, 62], labels[10:28, 63] = 1, 2
    blobs = np.where(labels > 0, 255, 0).astype(np.uint8)
    blobs[:, 62:64] = 128
    Image.fromarray(grey).save(folder / "flat.png")
    Image.fromarray(blobs).save(folder / "flat_gt_segmentation.png")
    labels[grey == 0] = 0
    return grey, labels


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Results of two example maps, in one folder."""
    folder = tmp_path_factory.mktemp("results")
    for name in ("flat", "fine"):
        call("run", MAPS / f"{name}.yaml", "--preset", "paper", "--out", folder / name, "-q")
    return folder


def test_true_labels_of_a_synthetic_map_are_perfect() -> None:
    for kind in ("png", "json"):
        words = (MAPS / "fine_truth.png", "--map", MAPS / "fine.yaml", "--reference", MAPS / f"fine_truth.{kind}")
        figures = told(*words)["summary"]
        assert (figures["rooms_true"], figures["doors_true"]) == (4, 3)
        for name in ("room_recall", "room_precision", "iou", "iou_sym", "mcc", "door_f1", "narrow_recall"):
            assert figures[name] == pytest.approx(1), (kind, name)


def test_a_folder_of_results_is_matched_by_name(results: Path) -> None:
    document = told(results, "--reference", MAPS)
    assert [entry["name"] for entry in document["maps"]] == ["fine", "flat"]
    assert [Path(entry["reference"]).name for entry in document["maps"]] == ["fine_truth.json", "flat_truth.json"]
    assert document["without_reference"] == []
    assert document["without_result"] == ["furnished", "turned"]
    for figure in ("iou", "door_f1"):
        alone = [
            told(results / name, "--reference", MAPS / f"{name}_truth.json")["summary"] for name in ("flat", "fine")
        ]
        assert document["summary"][figure] == pytest.approx(sum(one[figure] for one in alone) / 2)


def test_doors_of_a_result_are_those_that_its_map_json_names(results: Path) -> None:
    document = told(results / "fine", "--reference", MAPS / "fine_truth.png")
    found = sorted(
        (door["x_m"], door["y_m"]) for fate in ("hits", "false") for door in document["maps"][0]["doors"][fate]
    )
    doors = json.loads((results / "fine" / "map.json").read_text())["doors"]
    named = sorted(np.mean([door["start_m"], door["end_m"]], axis=0).tolist() for door in doors)
    assert np.array(found) == pytest.approx(np.array(named), abs=0.2)  # one working cell


def test_the_table_has_a_line_a_map_their_mean_and_all_doors_together(results: Path) -> None:
    lines = call("evaluate", results, "--reference", MAPS, "-q").stdout.splitlines()
    assert [line.split()[0] for line in lines] == ["map", "fine", "flat", "mean", "all"]
    assert {len(line) for line in lines} == {len(lines[0])}


def test_rooms_drawn_as_blobs_and_labels_say_the_same(tmp_path: Path) -> None:
    _, labels = drawn(tmp_path)
    np.save(tmp_path / "found.npy", labels.astype(np.int64))
    Image.fromarray(labels).save(tmp_path / "true.png")
    words = (tmp_path / "found.npy", "--map", tmp_path / "flat.png", "--resolution", "0.05")
    blobs = told(*words, "--reference", tmp_path / "flat_gt_segmentation.png")
    same = told(*words, "--reference", tmp_path / "true.png")
    assert blobs["maps"][0]["doors"]["hits"] == same["maps"][0]["doors"]["hits"]
    assert same["summary"]["iou"] == 1
    assert blobs["summary"]["iou"] == pytest.approx(2400 / 2418)
    # Lower left corner at (0, 0): the doorway's middle is 63 cells right and 19 of 44 down.
    (hit,) = same["maps"][0]["doors"]["hits"]
    assert hit == pytest.approx({"x_m": 63 * CELL_M, "y_m": 25 * CELL_M, "width_m": 18 * CELL_M})


def test_marked_doors_and_what_nobody_is_sure_of(tmp_path: Path) -> None:
    _, labels = drawn(tmp_path)
    labels[2:42, 92:124] = np.where(labels[2:42, 92:124] > 0, 3, 0)  # a room too many, parted in the open
    np.save(tmp_path / "flat.npy", labels)
    door = {"x1": 62.5, "y1": 10, "x2": 62.5, "y2": 27}
    opening = {"x1": 91.5, "y1": 2, "x2": 91.5, "y2": 41}
    words = (tmp_path / "flat.npy", "--map", tmp_path / "flat.png", "--resolution", "0.05", "--reference")
    for name, truth in {
        "plain": {"doors": [door]},
        "unsure": {"doors": [door], "ignore": [opening]},
        "several": {"flat": {"doors": [door], "ignore": [opening]}, "other": {"doors": []}},
    }.items():
        (tmp_path / f"{name}.json").write_text(json.dumps(truth))
    plain, unsure, several = (told(*words, tmp_path / f"{name}.json") for name in ("plain", "unsure", "several"))
    assert "iou" not in plain["summary"]
    assert (plain["summary"]["door_precision"], plain["summary"]["door_recall"]) == (0.5, 1)
    assert (unsure["summary"]["door_precision"], unsure["summary"]["pooled_door_f1"]) == (1, 1)
    assert len(unsure["maps"][0]["doors"]["excused"]) == 1
    assert several["summary"] == unsure["summary"]
    assert several["without_result"] == ["other"]


def test_the_name_of_the_map_a_result_was_made_of_finds_its_reference(results: Path, tmp_path: Path) -> None:
    shutil.copytree(results / "fine", tmp_path / "out")
    (tmp_path / "several.json").write_text(json.dumps({"fine": {"doors": []}, "other": {"doors": []}}))
    document = told(tmp_path / "out", "--reference", tmp_path / "several.json")
    assert [entry["name"] for entry in document["maps"]] == ["out"]


def test_a_furnished_map_takes_the_reference_and_the_bare_map_of_its_layout(tmp_path: Path) -> None:
    drawn(tmp_path / "maps")
    _, labels = drawn(tmp_path / "furnished", furnished=True)
    shutil.copy(tmp_path / "furnished" / "flat.png", tmp_path / "maps" / "flat_furnished.png")
    (tmp_path / "found").mkdir()
    np.save(tmp_path / "found" / "flat_furnished.npy", labels)
    maps = ("--map", tmp_path / "maps", "--bare-map", tmp_path / "maps", "--resolution", "0.05")
    document = told(tmp_path / "found", "--reference", tmp_path / "maps", *maps)
    assert Path(document["maps"][0]["reference"]).name == "flat_gt_segmentation.png"
    assert document["summary"]["room_recall"] == pytest.approx((1 + (2400 - 22 * 8) / 2400) / 2)
    assert [door["width_m"] for door in document["maps"][0]["doors"]["missed"]] == [0.9]
    assert (
        told(tmp_path / "found", "--reference", tmp_path / "maps", *maps[:2], *maps[4:])["summary"]["doors_true"] == 0
    )


def test_the_longest_name_that_fits_serves(tmp_path: Path) -> None:
    reference, result = tmp_path / "true.json", tmp_path / "found"
    result.mkdir()
    for name in ("lab", "lab_b", "lab_b_furnished", "lab_boat", "hall"):
        (result / f"{name}.npy").touch()
    reference.write_text(json.dumps({name: {"doors": []} for name in ("lab", "lab_b", "shop")}))
    found = matched(result, reference)
    served = {case.name: case.key for case in found.cases}
    assert served == {"lab": "lab", "lab_b": "lab_b", "lab_b_furnished": "lab_b", "lab_boat": "lab"}
    assert (found.without_reference, found.without_result) == (["hall"], ["shop"])


def test_free_from_decides_what_is_measured(tmp_path: Path) -> None:
    grey, labels = drawn(tmp_path)
    grey[2:22, 2:62] = 230
    Image.fromarray(grey).save(tmp_path / "flat.png")
    found = np.where((grey == 230) & (labels == 1), 0, labels)
    np.save(tmp_path / "found.npy", found)
    np.save(tmp_path / "true.npy", labels)
    words = (tmp_path / "found.npy", "--map", tmp_path / "flat.png", "--resolution", "0.05")
    reference = ("--reference", tmp_path / "true.npy")
    assert told(*words, *reference)["summary"]["iou"] < 0.9
    assert told(*words, *reference, "--free-from", "250")["summary"]["iou"] == 1


def test_thresholds_decide_the_exit_code(results: Path) -> None:
    words = (results / "fine", "--reference", MAPS)
    assert call("evaluate", *words, "--min", "iou=0.9", "--min", "door_f1=1").stderr == ""
    done = call("evaluate", *words, "--min", "iou=0.9", "--min", "mcc=1.5", code=1)
    assert done.stderr.startswith("vdoor: mcc: wanted at least 1.5, found 0.")
    for wrong in ("speed=3", "iou", "iou=much"):
        assert "--min: " in call("evaluate", *words, "--min", wrong, code=2).stderr


def test_equal_names_without_a_result_are_said(results: Path) -> None:
    assert "furnished has no result" in call("evaluate", results, "--reference", MAPS).stderr
    assert call("evaluate", results, "--reference", MAPS, "-q").stderr == ""


def test_a_picture_shows_doors_and_rooms(results: Path, tmp_path: Path) -> None:
    path = tmp_path / "seen.rrd"
    call("evaluate", results, "--reference", MAPS, "--save", path, "-q")
    assert [entry.name for entry in tmp_path.iterdir()] == ["seen.rrd"]
    rows = {
        entity: sum(chunk.to_record_batch().num_rows for chunk in RrdReader(path).stream().filter(content=entity))
        for entity in ("/evaluation/doors/hits", "/evaluation/found/rooms", "/figures")
    }
    assert rows == {"/evaluation/doors/hits": 2, "/evaluation/found/rooms": 3, "/figures": 2}
    assert "already exists" in call("evaluate", results, "--reference", MAPS, "--save", path, code=2).stderr


def test_equal_evaluations_draw_equal_recordings(results: Path, tmp_path: Path) -> None:
    for name in ("one.rrd", "other.rrd"):
        call("evaluate", results / "fine", "--reference", MAPS, "--save", tmp_path / name)
    rerun = Path(sys.executable).parent / "rerun"
    words: list[str | Path] = [rerun, "rrd", "compare", "--unordered", tmp_path / "one.rrd", tmp_path / "other.rrd"]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def evaluated(result: Path, reference: Path, maps: MapChoice) -> None:
    for case in matched(result, reference).cases:
        evaluate_case(case, maps)


def written(path: Path, content: object) -> Path:
    if isinstance(content, bytes):
        path.write_bytes(content)
    elif isinstance(content, np.ndarray):
        np.save(path, content)
    else:
        path.write_text(json.dumps(content))
    return path


WRONG_REFERENCES: list[tuple[str, object, str]] = [
    ("small.npy", np.ones((4, 4), np.int32), "wanted 126 x 44 cells like the map, found 4 x 4 cells"),
    ("real.npy", np.ones((44, 126)), "integers in 2 dimensions"),
    ("deep.npy", np.ones((4, 4, 4), int), "integers in 2 dimensions"),
    ("cut.npy", b"\x93NUMPY\x01\x00v\x00{'descr': '<i4', 'fortran_order': False", "damaged"),
    ("text.npy", b"hello", "damaged"),
    ("cut.png", b"\x89PNG\r\n\x1a\n", "image: wanted"),
    ("cut.json", b'{"doors": [', "JSON: wanted a complete file"),
    ("list.json", [1, 2], "JSON: wanted an object, found a list"),
    ("empty.json", {}, "wanted doors, or maps with doors, found none"),
    ("word.json", {"doors": "many"}, "wanted a list of doors, found a str"),
    ("short.json", {"doors": [{"x1": 1, "y1": 2, "x2": 3}]}, r"doors[0]: wanted numbers x1, y1, x2, y2"),
    ("nan.json", b'{"doors": [{"x1": NaN, "y1": 2, "x2": 3, "y2": 4}]}', r"doors[0]: wanted numbers"),
    ("ignore.json", {"doors": [], "ignore": [7]}, r"ignore[0]: wanted numbers"),
    ("size.json", {"schema": 1, "size": {"width": 3, "height": 4}}, "wanted 126 x 44 cells like the map"),
    ("cell.json", {"schema": 1, "size": {"width": 126, "height": 44}}, "wanted 0.05 m per cell like the map, found"),
    (
        "ends.json",
        {"schema": 1, "size": {"width": 126, "height": 44}, "resolution_m": 0.05, "doors": [{}]},
        "wanted doors with start_cell",
    ),
    ("nobody.json", {"kitchen": {"doors": []}, "hall": {"doors": []}}, "wanted one for found, found kitchen, hall"),
]


@pytest.mark.parametrize(("name", "content", "message"), WRONG_REFERENCES, ids=[name for name, *_ in WRONG_REFERENCES])
def test_wrong_references_are_one_line_that_ends_in_their_path(
    name: str, content: object, message: str, tmp_path: Path
) -> None:
    _, labels = drawn(tmp_path)
    np.save(tmp_path / "found.npy", labels)
    reference = written(tmp_path / name, content)
    maps = MapChoice(path=tmp_path / "flat.png", resolution_m=CELL_M)
    with pytest.raises(VdoorError) as raised:
        evaluated(tmp_path / "found.npy", reference, maps)
    assert message in str(raised.value)
    assert str(raised.value).endswith(f": {reference}")
    assert "\n" not in str(raised.value)


def test_wrong_results_are_one_line(results: Path, tmp_path: Path) -> None:
    _, labels = drawn(tmp_path)
    found, truth = tmp_path / "found.npy", tmp_path / "flat_gt_segmentation.png"
    np.save(found, labels)
    Image.fromarray(labels.astype(np.uint8)).save(tmp_path / "eight.png")
    shutil.copytree(results / "fine", tmp_path / "broken")
    (tmp_path / "broken" / "map.json").write_text("{}")
    (tmp_path / "empty").mkdir()
    flat, empty = MapChoice(path=tmp_path / "flat.png", resolution_m=CELL_M), MapChoice(path=tmp_path / "empty")
    own, coarse = MapChoice(), MapChoice(resolution_m=0.1)
    other, yaml = MapChoice(path=MAPS / "fine.yaml"), MapChoice(path=MAPS / "fine.yaml", free_from=250)
    for result, reference, maps, message in (
        (found, truth, own, "--map: wanted the map"),
        (tmp_path / "none.npy", truth, flat, "wanted a .npy, found none"),
        (tmp_path / "none.png", truth, flat, "found none"),
        (tmp_path / "eight.png", truth, flat, "wanted a 16-bit grey PNG, found an 8-bit one"),
        (found, truth, empty, "wanted one named found"),
        (found, truth, other, "labels: wanted"),
        (tmp_path / "empty", truth, own, "result: wanted rooms.png, or results"),
        (results / "fine", tmp_path / "empty", own, "reference: wanted label images or JSON"),
        (results / "fine", tmp_path / "gone.png", own, "found none"),
        (results / "fine", MAPS / "flat_truth.json", own, "cells like the map, found"),
        (tmp_path / "broken", MAPS / "fine_truth.png", own, "result: wanted resolution_m and origin"),
        (results / "fine", MAPS, coarse, "wanted 0.1 m per cell as requested, found 0.05"),
        (results / "fine", MAPS, yaml, "--free-from: wanted a map that is a plain image"),
    ):
        with pytest.raises(VdoorError, match=re.escape(message)) as raised:
            evaluated(result, reference, maps)
        assert "\n" not in str(raised.value)


def test_wrong_use_is_one_line_on_stderr_and_exit_code_2(results: Path, tmp_path: Path) -> None:
    for words, message in (
        ((results / "fine", "--reference", MAPS, "--free-from", "250"), "--free-from: wanted --map"),
        ((results / "fine", "--reference", tmp_path / "gone.json"), "found none"),
        ((results / "fine", "--reference", MAPS, "--save", tmp_path / "no" / "x.rrd"), "cannot be written"),
    ):
        done = call("evaluate", *words, "-q", code=2)
        assert len(done.stderr.splitlines()) == 1, done.stderr
        assert message in done.stderr
