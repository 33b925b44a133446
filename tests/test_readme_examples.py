"""Every example in the README runs: Python blocks, command lines, and commands within the text."""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import pytest
import recorded
import vacuum

HOME = Path(__file__).parent.parent
VDOOR = Path(sys.executable).parent / "vdoor"
README = (HOME / "README.md").read_text()
SKIPPED = {
    "vdoor ablate": "takes minutes; see test_trials.py",
    "vdoor robust": "takes minutes; see test_trials.py",
    "vdoor sweep": "takes minutes",
    "vdoor paper": "takes minutes",
    "vdoor search-study": "takes minutes",
    "vdoor bench": "measures time, for seconds",
    "vdoor train": "takes minutes; see test_train.py",
    "vdoor shot": "needs a Vulkan driver; see test_rerun.py",
    "vdoor view": "needs a screen",
    "vdoor step": "needs a terminal; see test_step.py",
    "vdoor run - ": "needs a robot at the other end of a pipe; see test_maps_in.py",
    "vdoor run --": "names an option, and no map",
}
"""How commands begin that are not run here, and why."""
SINKS = ("-o", "--out", "--save", "--mcap", "--export", "--junit")
"""Options whose file the command makes, so that it must not be there before."""


def commands(text: str) -> list[str]:
    """Command lines of shell blocks and commands in backticks, as far as they have arguments."""
    shell = [line for block in re.findall(r"```sh\n(.*?)```", text, re.DOTALL) for line in block.splitlines()]
    prose = re.sub(r"```.*?```", "", text, flags=re.DOTALL)
    parts = [part for line in shell for part in re.split(r"&&|;", line)] + re.findall(r"`([^`\n]+)`", prose)
    found = [part.strip().removeprefix(".venv/bin/").replace(r"\|", "|") for part in parts]
    return list(dict.fromkeys(part for part in found if re.match(r"vdoor [a-z-]+ \S", part)))


def reason_to_skip(command: str) -> str | None:
    return next((reason for begin, reason in SKIPPED.items() if f"{command} ".startswith(begin)), None)


@pytest.fixture(scope="module")
def ready(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with everything the examples name: the flat as a map, what was made of it, a robot's map, the truth."""
    folder = tmp_path_factory.mktemp("readme")
    shutil.copytree(HOME / "recordings", folder / "recordings")
    for own, name in (("flat.pgm", "flat.pgm"), ("flat.yaml", "map.yaml"), ("flat_truth.png", "truth.png")):
        shutil.copy(HOME / "recordings" / own, folder / name)
    shutil.copy(folder / "map.yaml", folder / "new.yaml")
    (folder / "goldens").mkdir()
    rows = ("".join(sign * 10 for sign in row) for row in vacuum.rows_of(vacuum.FLAT) for _ in range(10))
    vacuum.write_home(folder / "home.json", vacuum.home("\n".join(rows)))
    for words in (
        ("map.yaml", "--out", "result", "--save", "out.rrd", "--mcap", "out.mcap"),
        ("home.json", "--out", "home"),
    ):
        subprocess.run([VDOOR, "run", *words, "--quiet"], cwd=folder, check=True, timeout=120)
    subprocess.run([VDOOR, "rename", "result", "1", "Hall"], cwd=folder, check=True, timeout=120, capture_output=True)
    for name in ("a.mcap", "b.mcap", "old.mcap", "new.mcap"):
        shutil.copy(folder / "out.mcap", folder / name)
    (folder / "broken.mcap").write_bytes((folder / "out.mcap").read_bytes()[:-5000])
    return folder


@pytest.fixture
def folder(ready: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The test's own copy of it, where the test runs."""
    monkeypatch.chdir(shutil.copytree(ready, tmp_path / "copy"))
    return tmp_path / "copy"


def made_by(folder: Path, words: list[str]) -> list[Path]:
    """The files and folders that a command makes."""
    return [folder / value.rpartition("=")[2] for option, value in pairwise(words) if option in SINKS]


@pytest.mark.parametrize("command", commands(README))
def test_command_runs(
    command: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    if reason := reason_to_skip(command):
        pytest.skip(reason)
    words = shlex.split(command, comments=True)[1:]
    if "home.json" in words:  # as a reference it serves what was made of it
        shutil.copytree(folder / "home", folder / "result", dirs_exist_ok=True)
    made = made_by(folder, words)
    for path in made:
        shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)
    done = recorded.Command(monkeypatch, capsys)(*words)
    assert done.code == 0, done.err
    assert all(path.exists() for path in made)


@pytest.mark.parametrize("block", re.findall(r"```python\n(.*?)```", README, re.DOTALL))
@pytest.mark.usefixtures("folder")
def test_python_block_runs(block: str) -> None:
    exec(block, {})  # noqa: S102  # the README's own words
