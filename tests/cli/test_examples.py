"""The example in the help of every command runs, in a folder that has what it names."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import pytest
from commands import call
from project import HOME

from vdoor.cli.commands import COMMANDS

sys.path.insert(0, str(HOME / "docs"))
import blocks  # runs the commands of pages in the same way

LONG = (
    "batch",
    "verify",
    "ablate",
    "robust",
    "sweep",
    "train",
    "bench",
    "cover-bench",
    "route-bench",
    "fleet-bench",
    "edit",
)
"""These take long or wait for someone, and have tests of their own: their examples are parsed."""
EXAMPLES = [(name, line) for name, _, example in COMMANDS for line in example.split("; ")]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A map, its recordings, and its result with a kitchen and a hall."""
    made = blocks.ready(tmp_path_factory.mktemp("examples"))
    outputs = ("--mcap", made / "out.mcap", "--save", made / "out.rrd", "--out", made / "result")
    call("run", made / "map.yaml", "-q", *outputs)
    for name in ("before.mcap", "after.mcap"):
        shutil.copy(made / "out.mcap", made / name)
    whole = (made / "out.mcap").read_bytes()
    (made / "cut.mcap.partial").write_bytes(whole[: len(whole) * 3 // 4])
    for room, name in (("5", "Kitchen"), ("2", "Hall")):
        call("rename", made / "result", room, name)
    return made


@pytest.mark.parametrize(("name", "line"), EXAMPLES, ids=[line[:40] for _, line in EXAMPLES])
def test_example_runs(name: str, line: str, folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    here = shutil.copytree(folder, tmp_path / "here")
    if name in LONG:
        monkeypatch.setattr(blocks, "NOT_RUN", {**blocks.NOT_RUN, line: "takes long"})
    if "my.toml" in line:
        (here / "my.toml").write_text(call("config").stdout)
    blocks.run(blocks.Step("inline", line, 0, 0), here)


def test_help_shows_the_example() -> None:
    for name in ("rooms", "nav2", "room-at"):
        (example,) = [example for own, _, example in COMMANDS if own == name]
        assert f"Example: {example}" in " ".join(call(name, "--help").stdout.split())
