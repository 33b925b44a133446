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
        (("why", "."), "why: wanted one of --at, --door, --edge, --candidate, found 0: ."),
        (("why", "x.mcap", "--at", "99,99"), "found 99,99 m, cell 494,-488: x.mcap"),
        (("why", "res", "--door", "1"), "found a result folder; `vdoor run MAP --mcap FILE` writes what this command"),
        (("shot", "res", "-o", "p"), "found a result folder; `vdoor run MAP --mcap FILE` writes one: res"),
        (("export", "x.png", "--to", "svg"), "found a PNG image; `vdoor run MAP --out FOLDER` makes a folder: x.png"),
        (("export", "x.mcap", "--to", "nav2"), "did you mean 'nav2-route'?"),
        (("valetudo", "res"), "valetudo: wanted one of --clean, --segments, --keep-in, found 0: res"),
        (("batch", "report"), "found none; `vdoor batch report DIR` takes the folder of a batch"),
        (("sweep", "bias=1"), "did you mean cost.bias=1?"),
        (("run", FLAT, "--save", "y.mcap"), "--save: wanted a file name ending in .rrd; --mcap writes MCAP: y.mcap"),
        (
            ("run", FLAT, "--mcap", "y.rrd"),
            "--mcap: wanted a file name ending in .mcap; --save writes Rerun recordings",
        ),
        (("cover", FLAT, "--save", "y.mcap"), "--save: wanted a file name ending in .rrd; --mcap writes MCAP: y.mcap"),
        (("route", FLAT, "1", "4", "--mcap", "y.rrd"), "--mcap: wanted a file name ending in .mcap"),
        (
            ("why", "x.rrd", "--at", "1,1"),
            "found a Rerun recording; `vdoor run MAP --mcap FILE` writes",
        ),
        (
            ("info", "x.png"),
            "wanted an MCAP file, found a PNG image; `vdoor run MAP --mcap FILE` writes what this",
        ),
        (("info", "."), "wanted an MCAP file, found a folder: ."),
        (("run", "maps"), "found a folder; `vdoor batch` runs all maps in it: maps"),
        (("run", FLAT, "b.png"), "run: wanted one map, found 2; `vdoor batch` runs many"),
        (("run", FLAT, "--preset", "papr"), "preset: no preset 'papr'; did you mean 'paper'?"),
        (("run", FLAT, "--set", "pair_m=2"), "did you mean doors.pair_m=2?"),
        (("run", FLAT, "--set", "doors.pairm=2"), "did you mean 'pair_m'?"),
        (("run", FLAT, "--set", "dors.pair_m=2"), "did you mean 'doors'?"),
        (("export", "x.mcap", "--to", "geojso"), "did you mean 'geojson'?"),
        (("show", "x.mcap", "--stage", "dors"), "did you mean 'doors'?"),
        (("shot", "x.mcap", "--stage", "dors", "-o", "p"), "did you mean 'doors'?"),
        (("show", "x.mcap", "--stage", "serch"), "did you mean 'Search'?"),
        (("show", "x.mcap", "--stage", "coverage"), "--stage: coverage was not recorded, the last one is map: x.mcap"),
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
    (tmp_path / "res").mkdir()
    (tmp_path / "res" / "map.json").write_text("{}")
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


def test_a_stage_has_one_name_in_show_and_shot(tmp_path: Path, command: commands.Command) -> None:
    path = project.HOME / "recordings" / "golden" / "plain.mcap"
    shown = [command("show", path, "--stage", name).out for name in ("generation", "Search", "search", "initial_map")]
    assert shown[0].splitlines()[1].startswith("generation  ")
    assert shown[1] == shown[2] != shown[3]
    assert shown[1].startswith(shown[0])
    for name in ("generation", "Search", "initial_map", "initial map"):
        command("shot", path, "--stage", name, "--size", "200x200", "-o", tmp_path / name)
    pictures = [[path.name for path in (tmp_path / name).iterdir()] for name in ("generation", "Search")]
    assert pictures[0] == pictures[1] == [pictures[0][0]]
    assert "search" in pictures[0][0]
    assert [path.name for path in (tmp_path / "initial_map").iterdir()] == [
        path.name for path in (tmp_path / "initial map").iterdir()
    ]


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


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("exprot",), "no such command 'exprot'; did you mean 'export'?"),
        (("run", "m.yaml", "--forc"), "run: no such option: --forc"),
        (("run",), "run: missing argument 'MAP'; see `vdoor run --help`"),
        (("run", "m.yaml", "--seed", "x"), "run: invalid value for '--seed': "),
        (("rooms", "a", "b"), "rooms: got unexpected extra argument"),
        (("why", "a.mcap", "--at"), "option '--at' requires an argument; see `vdoor --help`"),
    ],
)
def test_words_that_make_no_command_are_told_in_one_line(
    words: tuple[str, ...], says: str, command: commands.Command
) -> None:
    done = command(*words)
    assert (done.code, done.out) == (2, "")
    assert commands.one_line(done).startswith(f"vdoor: {says}")


def test_the_command_alone_shows_its_help(command: commands.Command) -> None:
    done = command()
    assert done.code == 2
    assert "Run and look:" in done.err + done.out


@pytest.mark.parametrize(
    ("typed", "offered"),
    [
        ("vdoor exp", "export"),
        ("vdoor run --pres", "--preset"),
        ("vdoor run --preset pa", "paper"),
        ("vdoor export x --to nav", "nav2-route"),
        ("vdoor show x --stage can", "candidates"),
        ("vdoor shot x --stage Sea", "Search"),
    ],
)
def test_the_shell_completes_commands_options_and_names(typed: str, offered: str, command: commands.Command) -> None:
    asked = {"_VDOOR_COMPLETE": "complete_bash", "COMP_WORDS": typed, "COMP_CWORD": str(typed.count(" "))}
    assert command(env=asked).out.split() == [offered]
