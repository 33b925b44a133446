"""Standard streams that are full, closed or of another encoding, and Ctrl-C while the command starts."""

from __future__ import annotations

import contextlib
import io
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import TextIO
from unittest import mock

import finished_maps
import pytest
from commands import Command, one_line
from project import VDOOR
from small_recording import small

from vdoor.cli import main
from vdoor.cli.commands import COMMANDS

FULL = "standard output: cannot be read or written (No space left on device)"
WORDS = ("info", "rooms", "config", "--help")


def words(name: str, folder: Path) -> list[str | Path]:
    return {
        "info": ["info", small(folder / "a.mcap")],
        "rooms": ["rooms", finished_maps.result("one room", folder)],
    }.get(name, [name])


@pytest.mark.parametrize("name", WORDS)
def test_a_full_stdout_is_one_line(name: str, tmp_path: Path) -> None:
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [VDOOR, *words(name, tmp_path)], check=False, stdout=full, stderr=subprocess.PIPE, text=True, timeout=60
        )
    assert done.returncode == 2
    assert done.stderr == f"vdoor: {FULL}\n"


def printing(folder: Path) -> list[list[str | Path]]:
    """Give calls of every command that print: its help, and results of those that are quick."""
    recording, result = small(folder / "a.mcap"), finished_maps.result("one room", folder / "r")
    return [
        *([name, "--help"] for name, _, _ in COMMANDS),
        *([name, recording] for name in ("info", "check", "show")),
        ["why", recording, "--at", "1.2,0.8"],
        ["diff", recording, recording],
        *([name, result] for name in ("rooms", "order", "cover")),
        ["room-at", result, "1,1"],
        ["export", result, "--to", "geojson"],
    ]


def test_a_full_stdout_is_one_line_in_every_command(tmp_path: Path) -> None:
    for words in printing(tmp_path):
        with Path("/dev/full").open("w") as full, contextlib.redirect_stderr(io.StringIO()) as err:
            code = code_of(words, full)
        assert (code, err.getvalue()) == (2, f"vdoor: {FULL}\n"), words


def test_a_stdout_without_the_letters_is_no_error(tmp_path: Path, command: Command) -> None:
    calls = printing(tmp_path)
    assert command("rename", tmp_path / "r", "1", "Küche ☕").code == 0
    for words in calls:
        out = io.TextIOWrapper(io.BytesIO(), "ascii")
        assert code_of(words, out) == 0, words


def code_of(words: list[str | Path], out: TextIO) -> int:
    """Call the command with another standard output; give its exit code."""
    with contextlib.redirect_stdout(out), mock.patch.object(sys, "argv", ["vdoor", *map(str, words)]):
        try:
            main()
        except SystemExit as stopped:
            return int(stopped.code or 0)
    return 0


def test_closed_streams_do_not_matter(tmp_path: Path) -> None:
    result = finished_maps.result("one room", tmp_path / "r")
    for text, code in (
        (f"{VDOOR} rooms {result} 2>&-", 0),
        (f"{VDOOR} rooms nowhere 2>&-", 2),
        (f"{VDOOR} rooms {result} >&-", 0),
    ):
        done = subprocess.run(["sh", "-c", text], check=False, capture_output=True, text=True, timeout=60)
        assert (done.returncode, done.stderr) == (code, "")


def test_a_terminal_without_the_letter_shows_its_number(tmp_path: Path, command: Command) -> None:
    result = finished_maps.result("one room", tmp_path / "r")
    assert command("rename", result, "1", "Küche").code == 0
    for name in ("rooms", "export"):
        more = ["--to", "geojson"] if name == "export" else []
        done = subprocess.run(
            [VDOOR, name, result, *more], check=False, capture_output=True, timeout=60,
            env=os.environ | {"PYTHONIOENCODING": "ascii"},
        )  # fmt: skip
        assert (done.returncode, done.stderr) == (0, b"")
        assert b"K\\xfcche" in done.stdout or b"K\\u00fcche" in done.stdout


def test_ctrl_c_while_the_command_is_imported_is_silent() -> None:
    # The import that takes longest is held up, so that the signal surely comes within it.
    slow = "import sys, os, signal; sys.meta_path.insert(0, type('F', (), {'find_spec': staticmethod("
    slow += "lambda name, *_: os.kill(os.getpid(), signal.SIGINT) if name == 'typer' else None)})); "
    slow += "from vdoor.__main__ import main; main()"
    done = subprocess.run([sys.executable, "-c", slow], check=False, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr, done.stdout) == (-signal.SIGINT, "", "")


def test_devices_are_refused_as_settings_and_edits(tmp_path: Path, command: Command) -> None:
    os.mkfifo(tmp_path / "pipe")
    result = finished_maps.result("one room", tmp_path / "r")
    (result / "edits.toml").symlink_to("/dev/zero")
    image = tmp_path / "map.pgm"
    image.write_bytes(b"P5 30 30 255\n" + b"\xfe" * 900)
    for text in (
        ("config", "--config", tmp_path / "pipe"),
        ("config", "--config", "/dev/zero"),
        ("run", image, "-q", "--edits", tmp_path / "pipe"),
        ("rename", result, "1", "Hall"),
    ):
        done = command(*text)
        assert done.code == 2
        assert "found a device or pipe" in one_line(done)
