"""What the command says of a file of another kind, of a misspelt word, and of a number in place of a point."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import commands
import finished_maps
import project
import pytest
import small_recording
from PIL import Image

import vdoor
from vdoor.cli.commands import COMMANDS

FLAT = project.HOME / "recordings" / "flat.yaml"


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("run", FLAT, "--save", "y.mcap"), "--save: wanted a file name ending in .rrd; --mcap writes MCAP: y.mcap"),
        (
            ("run", FLAT, "--mcap", "y.rrd"),
            "--mcap: wanted a file name ending in .mcap; --save writes Rerun recordings",
        ),
        (("cover", FLAT, "--save", "y.mcap"), "--save: wanted a file name ending in .rrd; --mcap writes MCAP: y.mcap"),
        (("route", FLAT, "1", "4", "--mcap", "y.rrd"), "--mcap: wanted a file name ending in .mcap"),
        (("why", "x.rrd", "--at", "1,1"), "wanted an MCAP file, found a Rerun recording; `vdoor run --mcap` writes"),
        (("info", "x.png"), "wanted an MCAP file, found a PNG image: x.png"),
        (("info", "."), "wanted an MCAP file, found a folder: ."),
        (("run", "maps"), "found a folder; `vdoor batch` runs all maps in it: maps"),
        (("run", FLAT, "b.png"), "run: wanted one map, found 2; `vdoor batch` runs many"),
        (("run", FLAT, "--preset", "papr"), "preset: no preset 'papr'; did you mean 'paper'?"),
        (("run", FLAT, "--set", "pair_m=2"), "did you mean doors.pair_m=2?"),
        (("run", FLAT, "--set", "doors.pairm=2"), "did you mean 'pair_m'?"),
        (("run", FLAT, "--set", "dors.pair_m=2"), "did you mean 'doors'?"),
        (("export", "x.mcap", "--to", "geojso"), "did you mean 'geojson'?"),
        (("show", "x.mcap", "--stage", "dors"), "did you mean 'doors'?"),
        (("shot", "x.mcap", "--stage", "dors", "-o", "p"), "did you mean 'Doors'?"),
        (("why", "x.mcap"), "why: wanted one of --at, --door, --edge, --candidate, found 0"),
        (("why", "x.mcap", "--door", "9"), "--door: wanted one of the map's 0 doors, found 9: x.mcap"),
        (("why", "x.mcap", "--edge", "99"), "--edge: wanted 0 to "),
    ],
)
def test_wrong_use_says_what_it_is_and_what_to_do(
    words: tuple[str | Path, ...],
    says: str,
    tmp_path: Path,
    command: commands.Command,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    small_recording.small(tmp_path / "x.mcap")
    (tmp_path / "x.rrd").write_bytes(b"RRF2" + bytes(60))
    Image.new("L", (4, 4)).save(tmp_path / "x.png")
    (tmp_path / "maps").mkdir()
    before = {path.name for path in tmp_path.iterdir()}
    done = command(*words)
    assert (done.code, done.out) == (2, "")
    (line,) = done.err.splitlines()
    assert says in line
    assert {path.name for path in tmp_path.iterdir()} == before


def test_why_takes_the_number_of_a_door_an_edge_or_a_candidate(command: commands.Command) -> None:
    path = project.HOME / "recordings" / "golden" / "plain.mcap"
    run = small_recording.read(path)
    topology = next(record for record in run if isinstance(record, vdoor.TopologicalMap))
    door = topology.door(2)
    answer = command("why", path, "--door", "2", "--json").json
    middle_m = [(a + b) / 2 for a, b in zip(door.start_m, door.end_m, strict=True)]
    assert answer["place"]["point_m"] == pytest.approx(middle_m)
    assert 2 in answer["doors"][0]["final_door"]
    nearest = command("why", path, "--edge", "3", "--json").json["doors"]
    assert any((fate["edge"], fate["away_m"]) == (3, 0) for fate in nearest)
    nearest = command("why", path, "--candidate", "5", "--json").json["doors"]
    assert any((fate["door"], fate["away_m"]) == (5, 0) for fate in nearest)


def test_a_map_is_one_line() -> None:
    assert repr(finished_maps.topology("flat")) == "TopologicalMap(5 rooms, 4 doors, 48.2 m2, 53 x 46 cells of 0.2 m)"
    assert repr(finished_maps.grid("flat")) == "OccupancyGrid(cells 46 x 53)"


def test_the_package_is_a_command() -> None:
    words = [sys.executable, "-m", "vdoor", "--help"]
    done = subprocess.run(words, capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout.startswith("Usage: vdoor [OPTIONS] COMMAND")


def test_help_lists_every_command_in_a_group(command: commands.Command) -> None:
    lines = command("--help").out.splitlines()
    headings = [line for line in lines if line.endswith(":") and not line.startswith(" ")]
    assert headings[-7:] == ["Run and look:", "Debug:", "Drive:", "Edit:", "Export:", "Measure:", "The paper:"]
    listed = {line.split()[0] for line in lines if line.startswith("  ") and line[2:3].isalpha()}
    assert {name for name, *_ in COMMANDS} <= listed


def test_a_misspelt_command_is_answered_with_the_right_one(command: commands.Command) -> None:
    assert "'export'" in command("exprot").err
