"""The command as its users meet it: real processes, their files, streams and exit codes."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest
import yaml
from commands import call, one_line
from PIL import Image
from project import FLAT, HOME, VDOOR

import vdoor
from vdoor.pipeline import PRESETS, RECORDS, Pipeline
from vdoor.recording.mcap import read_recording
from vdoor.topology import TopologicalMap

PAPER = Pipeline().records


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("results")
    call("run", FLAT, "--preset", "paper", "--mcap", folder / "flat.mcap", "--out", folder / "flat")
    return folder


def test_result_folder_holds_the_map_that_python_returns(results: Path) -> None:
    topology = vdoor.run(vdoor.read_map(FLAT), "paper", seed=0)
    folder = results / "flat"
    assert np.array_equal(np.asarray(Image.open(folder / "rooms.png")), topology.labels)
    document = json.loads((folder / "map.json").read_text())
    assert [room["id"] for room in document["rooms"]] == [room.id for room in topology.rooms]
    assert [(door["id"], door["rooms"]) for door in document["doors"]] == [
        (door.id, list(door.rooms)) for door in topology.doors
    ]
    assert document["size"] == {"width": topology.frame.width, "height": topology.frame.height}
    assert document["settings"]["simplify"]["cell_m"] == 0.2
    assert set(document["timings_s"]) == {record.topic for record in PAPER}


def test_grid_png_reads_back_as_the_map(results: Path) -> None:
    grid = vdoor.read_map(FLAT)
    again = vdoor.read_map(results / "flat" / "grid.png", resolution_m=0.2)
    assert np.array_equal(again.cells, grid.cells)
    about = yaml.safe_load((results / "flat" / "rooms.yaml").read_text())
    assert about["image"] == "rooms.png"
    assert about["resolution"] == grid.frame.resolution_m


def test_recording_holds_every_stage_and_the_result(results: Path) -> None:
    recording = read_recording(results / "flat.mcap", types=RECORDS)
    records = [record for _, record in recording]
    assert [type(record) for record in records if record.topic != "generation"] == [
        record for record in PAPER if record.topic != "generation"
    ]
    assert isinstance(records[-1], TopologicalMap)
    assert np.array_equal(records[-1].labels, np.asarray(Image.open(results / "flat" / "rooms.png")))


def test_equal_runs_give_equal_mcap_bytes_and_map_files(results: Path, tmp_path: Path) -> None:
    call("run", FLAT, "--preset", "paper", "--mcap", tmp_path / "flat.mcap", "--out", tmp_path / "flat")
    assert (tmp_path / "flat.mcap").read_bytes() == (results / "flat.mcap").read_bytes()
    for name in ("rooms.png", "rooms.yaml", "grid.png"):
        assert (tmp_path / "flat" / name).read_bytes() == (results / "flat" / name).read_bytes()
    assert not list(tmp_path.glob("**/*.partial"))


def test_json_on_stdout_is_map_json(results: Path) -> None:
    printed = json.loads(call("run", FLAT, "--preset", "paper", "--json", "-q").stdout)
    written = json.loads((results / "flat" / "map.json").read_text())
    del written["files"]  # the digests of the files beside it
    assert printed | {"timings_s": 0} == written | {"timings_s": 0}


def test_existing_files_are_kept_without_force(results: Path) -> None:
    before = (results / "flat.mcap").read_bytes()
    assert "--force" in one_line(call("run", FLAT, "--mcap", results / "flat.mcap", code=2))
    assert "map.json" not in one_line(call("run", FLAT, "--out", results / "flat", code=2))
    assert (results / "flat.mcap").read_bytes() == before


def test_what_an_interrupted_run_saved_is_kept_without_force(tmp_path: Path) -> None:
    saved = tmp_path / "flat.mcap.partial"
    saved.write_text("saved")
    assert saved.name in one_line(call("run", FLAT, "--mcap", tmp_path / "flat.mcap", code=2))
    assert saved.read_text() == "saved"


def test_serving_leaves_whole_files_and_ends_with_ctrl_c(tmp_path: Path) -> None:
    words = ["run", FLAT, "--serve", "--save", tmp_path / "flat.rrd", "--mcap", tmp_path / "flat.mcap", "-q"]
    with subprocess.Popen(
        [VDOOR, *map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stderr is not None
        said = process.stderr.readline()
        names = sorted(path.name for path in tmp_path.iterdir())
        process.send_signal(signal.SIGINT)
        printed, _ = process.communicate(timeout=60)
    assert said.startswith("vdoor: open http://127.0.0.1:")
    assert names == ["flat.mcap", "flat.rrd"]
    assert process.returncode == 0
    assert printed.startswith("5 rooms, 4 doors")


def test_a_reader_that_goes_away_does_not_cost_the_files(tmp_path: Path) -> None:
    words = [VDOOR, "run", FLAT, "--mcap", tmp_path / "flat.mcap"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        process.stdout.close()
        process.wait(timeout=60)
    assert [path.name for path in tmp_path.iterdir()] == ["flat.mcap"]


def test_force_overwrites(tmp_path: Path) -> None:
    target = tmp_path / "flat.mcap"
    target.write_text("old")
    call("run", FLAT, "--mcap", target, "--force")
    assert sum(1 for _ in read_recording(target, types=RECORDS)) > len(PRESETS["default"].records)


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["run", "missing.yaml"], "missing.yaml"),
        (["run", FLAT, "--preset", "papper"], "papper"),
        (["run", FLAT, "--set", "simplify.cell=1"], "cell_m"),
        (["run", FLAT, "--set", "simplify.cell_m=-1"], "0 to 10"),
        (["run", FLAT, "--set", "nonsense"], "stage.field=value"),
        (["run", FLAT, "--config", "missing.toml"], "missing.toml"),
        (["run", FLAT, "--resolution", "0.05"], "0.05"),
        (["run", FLAT, "--robot", "1"], "X,Y"),
        (["run", FLAT, "--robot", "500,500"], "500,500"),
        (["run", FLAT, "-q", "--set", "search.method=exhaustive", "--set", "search.most_edges=1"], "annealing"),
        (["run", FLAT, "--mcap", "missing/folder/out.mcap"], "missing/folder"),
        (["run", FLAT, "--save", "missing/folder/out.rrd"], "missing/folder"),
        (["run", FLAT, "--mcap", "same", "--save", "same"], "twice"),
        (["run", FLAT, "--save", ""], "file name"),
        (["run", FLAT, "--save", "x" * 300], "invalid file name"),
        (["run", FLAT, "--mcap", FLAT, "--force"], "input"),
        (["run", FLAT, "--mcap", "/dev/null", "--force"], "device"),
        (["run", FLAT, "--connect", "http://[::1"], "HOST:PORT"),
        (["synth"], "STEM"),
        (["synth", "x", "--kind", "castle"], "castle"),
    ],
)
def test_wrong_use_is_one_line_and_exit_code_2(words: list[str | Path], says: str) -> None:
    assert says in one_line(call(*words, code=2))


def test_map_without_free_cells_is_refused_by_name_and_leaves_no_file(tmp_path: Path) -> None:
    image = tmp_path / "wall.png"
    Image.fromarray(np.zeros((9, 9), np.uint8)).save(image)
    words = ["run", image, "--resolution", "0.05", "--mcap", tmp_path / "o.mcap", "--out", tmp_path / "o"]
    line = one_line(call(*words, code=2))
    assert "no free cell" in line
    assert [path.name for path in tmp_path.iterdir()] == ["wall.png"]


def test_map_whose_name_is_no_text_can_be_recorded(tmp_path: Path) -> None:
    image = Path(os.fsdecode(os.fsencode(tmp_path) + b"/bad\xff.pgm"))
    image.write_bytes((HOME / "recordings" / "flat.pgm").read_bytes())
    call("run", image, "--resolution", "0.2", "--mcap", tmp_path / "o.mcap", "--save", tmp_path / "o.rrd")
    assert sum(1 for _ in read_recording(tmp_path / "o.mcap", types=RECORDS)) > len(PRESETS["default"].records)


def test_result_folder_that_cannot_be_made_is_refused_before_the_run(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    done = call("run", FLAT, "--mcap", tmp_path / "o.mcap", "--out", tmp_path / "file" / "result", code=2)
    assert "output folder" in one_line(done)
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_notes_go_to_stderr_and_quiet_silences_them(tmp_path: Path) -> None:
    image = tmp_path / "room.png"
    grey = np.zeros((20, 20), np.uint8)
    grey[2:-2, 2:-2] = 254
    Image.fromarray(grey).save(image)
    assert "0.05 m" in one_line(call("run", image))
    assert call("run", image, "-q").stderr == ""
    assert call("run", image, "-q").stdout.startswith("1 room, 0 doors")


def test_robot_in_cells_and_in_metres_is_the_same_place(tmp_path: Path) -> None:
    image = tmp_path / "two.png"
    grey = np.zeros((30, 60), np.uint8)
    grey[2:-2, 2:20] = 254
    grey[2:-2, 24:-2] = 254
    Image.fromarray(grey).save(image)
    for words in (["--robot", "1.0,1.5"], ["--robot", "9,15", "--cells"]):
        document = json.loads(call("run", image, "--resolution", "0.1", "-q", "--json", *words).stdout)
        assert document["settings"]["simplify"]["robot_m"] == pytest.approx([1.0, 1.5], abs=0.06)
        assert len(document["rooms"]) == 2  # the place says where the robot is, not what there is


def test_printed_settings_read_back(tmp_path: Path) -> None:
    settings = tmp_path / "my.toml"
    settings.write_text(call("config", "--preset", "paper", "--set", "doors.max_length_m=1").stdout)
    again = call("config", "--config", settings).stdout
    assert "max_length_m = 1.0" in again
    assert again == settings.read_text()


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_interrupted_run_names_a_readable_partial_file(tmp_path: Path, number: signal.Signals) -> None:
    target = tmp_path / "long.mcap"
    picture = tmp_path / "long.rrd"
    words = [
        "run",
        FLAT,
        "--preset",
        "paper",
        "--set",
        "search.generations=1000000",
        "--mcap",
        target,
        "--save",
        picture,
    ]
    process = subprocess.Popen([VDOOR, *map(str, words)], stderr=subprocess.PIPE, text=True)
    partial = target.with_name("long.mcap.partial")
    deadline = time.monotonic() + 60
    while not (partial.exists() and partial.stat().st_size > 30_000):
        assert time.monotonic() < deadline
        time.sleep(0.05)
    process.send_signal(number)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 128 + number
    assert str(partial) in said
    assert "Traceback" not in said
    assert sorted(path.name for path in tmp_path.iterdir()) == ["long.mcap.partial", "long.rrd.partial"]
    rerun = [VDOOR.with_name("rerun"), "rrd", "verify", f"{picture}.partial"]
    assert subprocess.run(rerun, env=os.environ | {"CI": "1"}, check=False).returncode == 0
    topics = [record.topic for _, record in read_recording(partial, types=RECORDS)]
    assert topics[:8] == [record.topic for record in PAPER[:8]]
    assert topics[-1] == "generation"


def test_help_of_every_command_has_an_example() -> None:
    for command in ("run", "config", "synth", "bench", "search-study"):
        assert f"Example: vdoor {command}" in call(command, "--help").stdout
    assert call("--version").stdout == f"vdoor {vdoor.__version__}\n"


def test_bench_and_search_study_print_figures() -> None:
    report = json.loads(call("bench", "--preset", "paper", "--json", "--tile", "2").stdout)
    assert report["reference_s"] > 0
    assert report["cells"][0] > 2 * 100
    assert set(report["stages_s"]) == {record.topic for record in PAPER}
    text = call("search-study", "--graphs", "4", "--seeds", "3").stdout
    assert "of searches reach the optimum" in text


def test_a_recording_that_is_read_is_never_overwritten_even_with_force(results: Path, tmp_path: Path) -> None:
    one, other = tmp_path / "one.mcap", tmp_path / "other.mcap"
    for path in (one, other):
        path.write_bytes((results / "flat.mcap").read_bytes())
    for words in (
        ["replay", one, "--save", one],
        ["verify", one, "--save", one],
        ["verify", one, "--junit", one],
        ["diff", one, other, "--save", other],
    ):
        assert "input" in one_line(call(*words, "--force", code=2))
    assert one.read_bytes() == other.read_bytes() == (results / "flat.mcap").read_bytes()
