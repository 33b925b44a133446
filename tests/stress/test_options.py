"""Any text as the value of any option gives a result or a refusal, never a traceback.

A sample runs in CI; all of it: ``STRESS=1 pytest tests/stress/test_options.py -n 0``.
"""

from __future__ import annotations

import random
import re
from pathlib import Path

import click
import finished_maps
import pytest
import typer.main
from commands import Command, Done
from small_recording import small
from stress import Findings, count, limited

from vdoor.cli import app
from vdoor.cli.commands import COMMANDS

VALUES = count(60, None)
"""How many of the options with a text; None: all of them, over 10,000."""
TEXTS = (
    "",
    " ",
    "-",
    "--",
    "0",
    "-1",
    "1e999",
    "nan",
    "-inf",
    "9" * 5000,
    "1" + "0" * 400,
    "²",
    "٣",
    "é",
    "\x1b[2J",
    "\n",
    "a\nb",
    "\udcff",
    "[" * 3000,
    "{",
    '"',
    "'",
    "=",
    "a=b",
    "a.b=c",
    "simplify.cell_m=" + "9" * 5000,
    "search.seed=[[[",
    "1,1",
    "nan,1",
    "1e400,1",
    ",",
    "1,",
    "..",
    "/proc",
    "/dev/zero",
    "/dev/null/x",
    "a..b:80",
    "localhost:99999",
    "http://[",
    "x" * 300,
    "svg=",
    "=x",
    "svg=/nope/x.svg",
    "1x1",
    "0x0",
    "99999999x1",
    "1e-308",
    "True",
    "none",
    "-0.0",
    "%s%n",
    "../..",
    "cost.bias=1..0:0",
    "cost.bias=0..1:1e-300",
    "seed=0..99999999",
    "room_f1=nan",
    "Doors",
)
NEVER = {"--serve", "--spawn", "--help", "--version", "--connect", "--rrd", "--rerun", "--jobs", "--cluster"}
"""Options that wait for somebody, or start others."""
LONG = {
    "bench",
    "cover-bench",
    "route-bench",
    "search-study",
    "paper",
    "golden",
    "batch",
    "sweep",
    "robust",
    "ablate",
    "train",
    "shot",
    "view",
    "step",
}
"""Commands that do much or wait; they are called with a file that is none."""


def options() -> list[tuple[str, str]]:
    """All options with a value, each with its command."""
    group = typer.main.get_command(app)
    found = []
    for name, _, _ in COMMANDS:
        command = group.get_command(click.Context(group), name)  # type: ignore[attr-defined]  # a group
        for parameter in command.params:
            flags = [flag for flag in parameter.opts if flag.startswith("--")]
            if flags and not getattr(parameter, "is_flag", False) and flags[0] not in NEVER:
                found.append((name, flags[0]))
    return found


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("options")
    small(folder / "a.mcap")
    finished_maps.result("one room", folder / "r")
    (folder / "map.pgm").write_bytes(b"P5 6 6 255\n" + b"\xfe" * 36)
    return folder


def arguments(name: str, rng: random.Random) -> list[str]:
    """Words that the command needs beside an option; a text in place of a point or room as well."""
    text = rng.choice(TEXTS)
    wanted = {
        "run": ["map.pgm"],
        "why": ["a.mcap"],
        "replay": ["a.mcap"],
        "verify": ["a.mcap"],
        "diff": ["a.mcap", "a.mcap"],
        "info": ["a.mcap"],
        "check": ["a.mcap"],
        "show": ["a.mcap"],
        "recover": ["a.mcap"],
        "export": ["r"],
        "rooms": ["r"],
        "valetudo": ["r"],
        "room-at": [text, "r"],
        "route": ["r", text, "1"],
        "cover": ["r"],
        "order": ["r"],
        "rename": ["r", text, text],
        "split": ["r", text, "1,1"],
        "merge": ["r", text, "1"],
        "door": ["add", "r", text, text],
        "evaluate": ["r"],
        "synth": ["new"],
    }
    return wanted.get(name, [] if name == "config" else ["none.such"])


def claim_plain(done: Done) -> None:
    """Claim that a command gave a result, or a refusal in one line."""
    assert done.code in (0, 1, 2), done.err
    assert "\x1b" not in done.err
    assert done.code != 2 or re.search(r"^(vdoor|Usage): ", done.err, re.MULTILINE), done.err
    lines = [line for line in done.err.splitlines() if line.startswith("vdoor: ") and "note: " not in line]
    assert done.code != 2 or len(lines) <= 1, done.err


def values(known: list[tuple[str, str]], rng: random.Random) -> list[tuple[str, str, str]]:
    """Each option with each text and with some drawn ones, in an order of their own: command, option, text."""
    drawn = ["".join(rng.choices('\t",0=é€', k=9)) for _ in range(10)]
    found = [(name, option, text) for name, option in known for text in (*TEXTS, *drawn)]
    rng.shuffle(found)
    return found[:VALUES]


def test_any_text_as_an_option(home: Path, command: Command) -> None:
    known, rng, findings = options(), random.Random(1), Findings()  # noqa: S311  # no secret
    assert len(known) > 60
    for name, option, text in values(known, rng):
        words = [*arguments(name, rng), f"{option}={text}"]
        if name in LONG:
            words = [f"{option}={text}", "none.such"]
        with findings.of([name, *(word[:80] for word in words)]), limited():
            claim_plain(command(name, *words, cwd=home))
    findings.claim_none()
