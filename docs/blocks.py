"""Runs the commands and code blocks of a page as its reader would: in order, in one folder.

The tests run every page this way, and the site takes from here what commands print (see `hooks.py`).

Run are ``sh`` and ``python`` blocks, and commands of vdoor within the text. A line of shell may be a pipe, end in
``> FILE``, or say with ``# exit code 1`` what it ends with. Blocks of any other language are read, and not run.
"""

# ruff: noqa: INP001  # part of the site, not of a package
from __future__ import annotations

import contextlib
import io
import itertools
import json
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import typer
from PIL import Image

import vdoor.cli

HOME = Path(__file__).parent.parent
FLAT = HOME / "recordings" / "flat.yaml"

NOT_RUN = {
    "vdoor view": "needs a screen",
    "vdoor step": "needs a terminal",
    "vdoor shot": "takes seconds, and a Vulkan driver of an .rrd",
    "vdoor run map.yaml --spawn": "needs a screen",
    "vdoor run map.yaml --serve": "ends when its reader ends it",
    "vdoor run map.yaml --connect": "needs a viewer that runs",
    "vdoor run - ": "needs a robot at the other end of a pipe",
    "vdoor run --": "names an option, and no map",
    "vdoor golden": "writes the repository's own recordings",
    "vdoor paper": "takes minutes",
    "vdoor search-study": "takes minutes",
    "vdoor sweep --": "takes minutes",
    "vdoor train --homes 800": "takes an hour",
    "vdoor fleet-bench": "measures for minutes",
    "python3 -m venv": "sets up what runs this",
    ".venv/bin/": "of a fresh clone",
    "pip install": "sets up what runs this",
    "git ": "changes the repository",
}
"""How commands begin that are only parsed, and why they are not run."""
SINKS = ("-o", "--out", "--save", "--mcap", "--png", "--export", "--junit", ">")
"""What a file that a command makes stands behind."""
FENCE = re.compile(r"^( *)```(\w*)[^\n]*\n(.*?)^\1```$", re.DOTALL | re.MULTILINE)
INLINE = re.compile(r"`(vdoor [a-z-]+ [^`\n]+)`")
OUTPUT = re.compile(r"<!-- output(?: (\d+)-(\d+))? -->")


class PageError(AssertionError):
    """A command that did not end as the page says."""


class Step(NamedTuple):
    """Something of a page that runs, and where it stands."""

    kind: str
    """The block's language, ``inline``, or ``output`` where the page wants what the command before printed."""
    text: str
    start: int
    end: int


def steps(page: str) -> list[Step]:
    """What there is to run on a page, in its order."""
    found = [Step(block[2], _dedented(block[3], len(block[1])), *block.span()) for block in FENCE.finditer(page)]
    prose = FENCE.sub(lambda block: " " * len(block[0]), page)
    found += [Step("inline", part[1].replace(r"\|", "|"), *part.span()) for part in INLINE.finditer(prose)]
    found += [Step("output", "-".join(filter(None, mark.groups())), *mark.span()) for mark in OUTPUT.finditer(prose)]
    return sorted(found, key=lambda step: step.start)


def _dedented(text: str, columns: int) -> str:
    return "".join(line[columns:] if line[:columns].isspace() else line for line in text.splitlines(keepends=True))


def run(step: Step, folder: Path) -> str:
    """Run one step in a folder; what its last command printed. `PageError` where it does not end as it says."""
    with contextlib.chdir(folder):
        if step.kind == "python":
            with contextlib.redirect_stdout(io.StringIO()) as printed:
                exec(compile(step.text, "block", "exec"), {"__name__": "block"})  # noqa: S102  # the page's own words
            return printed.getvalue()
        if step.kind in ("sh", "inline"):
            lines = step.text.replace("\\\n", " ").splitlines()
            each = [_run_line(line, repeated=step.kind == "inline") for line in lines if line.strip()]
            return each[-1] if each else ""
    return ""


def _run_line(line: str, *, repeated: bool) -> str:
    """Run a line of shell. One from a text may have run before: what it made is then taken away."""
    code, comment = _code_and_comment(line)
    wanted = int(said[1]) if (said := re.search(r"exit code (\d)", comment)) else 0
    printed = ""
    for part in filter(None, map(str.strip, code.split("&&"))):
        if any(f"{part} ".startswith(begin) for begin in NOT_RUN):
            _parse(part)
            continue
        text, _, target = part.partition(" > ")
        if repeated:
            _take_away(shlex.split(part))
        data, ended = b"", 0
        for command in text.split(" | "):
            data, ended = _run_command(shlex.split(command), data)
        if ended != wanted:
            raise PageError(f"wanted exit code {wanted}, found {ended}: {line}")
        if target:
            Path(target.strip()).write_bytes(data)
        else:
            printed += data.decode()
    return printed


def _code_and_comment(line: str) -> tuple[str, str]:
    code, _, comment = line.partition(" #") if not line.startswith("#") else ("", "", line)
    return code.strip(), comment


def _take_away(words: list[str]) -> None:
    for option, value in itertools.pairwise(words):
        path = Path(value.rpartition("=")[2])
        if option in SINKS and path.exists():
            shutil.rmtree(path) if path.is_dir() else path.unlink()


def _run_command(words: list[str], data: bytes) -> tuple[bytes, int]:
    """Stdout and exit code of one command that is given `data` on stdin."""
    if words[0] != "vdoor":
        done = subprocess.run(words, input=data, capture_output=True, check=False, timeout=60)  # noqa: S603  # the page's
        return done.stdout, done.returncode
    printed, said, code = io.StringIO(), io.StringIO(), 0
    old = sys.argv, sys.stdin
    sys.argv, sys.stdin = words, io.TextIOWrapper(io.BytesIO(data))
    try:
        with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(said):
            vdoor.cli.main()
    except SystemExit as stopped:
        code = int(stopped.code or 0)
    finally:
        sys.argv, sys.stdin = old
    if code > 1:
        raise PageError(f"{shlex.join(words)}: {said.getvalue()}")
    return printed.getvalue().encode(), code


def _parse(text: str) -> None:
    """Parse a command of vdoor that is not run: its name, options and arguments are such that it could be."""
    words = shlex.split(text)
    if words[0] != "vdoor":
        return
    group: Any = typer.main.get_command(vdoor.cli.app)
    try:
        with group.make_context("vdoor", words[1:]) as context:
            name, command, rest = group.resolve_command(context, words[1:])
            options = {name for parameter in command.get_params(context) for name in parameter.opts}
            if len(rest) == 1 and rest[0] in options:  # named, not used
                return
            command.make_context(name, rest, parent=context).close()
    except Exception as error:
        raise PageError(f"{text}: {error}") from error


def ready(folder: Path) -> Path:
    """Put into a folder what pages name and do not make: the example maps, one of them as `map.yaml`, a robot's map."""
    shutil.copytree(FLAT.parent, folder / "recordings", ignore=shutil.ignore_patterns("paper"))
    for own, name in (("flat.pgm", "flat.pgm"), ("flat.yaml", "map.yaml"), ("flat.yaml", "new.yaml")):
        shutil.copy(FLAT.with_name(own), folder / name)
    shutil.copy(FLAT.with_name("flat_truth.png"), folder / "truth.png")
    for kind in ("maps", "truth"):
        (folder / kind).mkdir()
    for name in ("flat", "furnished"):
        for ending in (".pgm", ".yaml"):
            shutil.copy(FLAT.with_name(name + ending), folder / "maps")
        for ending in ("_truth.json", "_truth.png"):
            shutil.copy(FLAT.with_name(name + ending), folder / "truth")
    (folder / "home.json").write_text(json.dumps(robot_map()))
    return folder


def robot_map() -> dict[str, Any]:
    """The flat as a robot vacuum would have it in Valetudo's format: its true rooms are the segments."""
    finer = 4  # of 20 cm cells
    cells = np.asarray(Image.open(FLAT.with_suffix(".pgm"))).repeat(finer, axis=0).repeat(finer, axis=1)
    rooms = np.asarray(Image.open(FLAT.with_name("flat_truth.png"))).repeat(finer, axis=0).repeat(finer, axis=1)
    free = cells == cells.max()
    layers = [_layer("wall", cells == 0, {}), _layer("floor", free & (rooms == 0), {})]
    layers += [
        _layer("segment", free & (rooms == number), {"segmentId": str(number), "name": f"Room {number}"})
        for number in range(1, int(rooms.max()) + 1)
    ]
    at = np.argwhere(free & (rooms == rooms.max()))[0] * 5 + 2
    return {
        "__class": "ValetudoMap",
        "metaData": {"version": 2},
        "size": {"x": 5 * cells.shape[1], "y": 5 * cells.shape[0]},
        "pixelSize": 5,
        "layers": layers,
        "entities": [
            {"__class": "PointMapEntity", "type": "robot_position", "points": at[::-1].tolist(), "metaData": {}}
        ],
    }


def _layer(kind: str, mask: np.ndarray[tuple[int, int], np.dtype[np.bool_]], about: dict[str, str]) -> dict[str, Any]:
    """A layer of Valetudo's format: runs of cells as x, y and length."""
    return {"__class": "MapLayer", "type": kind, "metaData": about, "compressedPixels": [*_runs(mask)]}


def _runs(mask: np.ndarray[tuple[int, int], np.dtype[np.bool_]]) -> Iterator[int]:
    for y, row in enumerate(mask):
        edges = np.flatnonzero(np.diff(row.astype(np.int8), prepend=0, append=0)).tolist()
        for left, right in zip(edges[::2], edges[1::2], strict=True):
            yield from (left, y, right - left)
