"""The command, called in this process: what it writes, and the exit code that the shell would see."""

from __future__ import annotations

import contextlib
import io
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple
from unittest import mock

from project import VDOOR

import vdoor.cli

SAYS_SIZE = {"COLUMNS", "LINES", "NO_COLOR", "FORCE_COLOR"}


def environment() -> dict[str, str]:
    """The environment without what would speak for the terminal."""
    return {name: text for name, text in os.environ.items() if name not in SAYS_SIZE}


class Done(NamedTuple):
    returncode: int
    stdout: str
    stderr: str

    @property
    def code(self) -> int:
        return self.returncode

    @property
    def out(self) -> str:
        return self.stdout

    @property
    def err(self) -> str:
        return self.stderr

    @property
    def json(self) -> Any:
        return json.loads(self.stdout)


class Command:
    """The command: an error that it does not catch fails the test."""

    def __call__(self, *words: str | Path, env: dict[str, str] | None = None, cwd: Path | None = None) -> Done:
        with _streams() as (out, err), _place(words, env or {}, cwd):
            code = _exit_code()
        return Done(code, _text(out), _text(err))


def call(*words: str | Path, code: int = 0, env: dict[str, str] | None = None) -> Done:
    """Call the command and claim its exit code."""
    done = Command()(*words, env=env)
    assert done.returncode == code, done.stderr
    return done


def process(*words: str | Path, code: int = 0, env: dict[str, str] | None = None) -> subprocess.CompletedProcess[str]:
    """Run the command in a process of its own and claim its exit code."""
    done = subprocess.run(
        [VDOOR, *map(str, words)],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        env=os.environ | (env or {}),
    )
    assert done.returncode == code, done.stderr
    assert "Traceback" not in done.stderr
    return done


def one_line(done: Done | subprocess.CompletedProcess[str]) -> str:
    lines = done.stderr.splitlines()
    assert len(lines) == 1, done.stderr
    return str(lines[0])


@contextlib.contextmanager
def _streams() -> Iterator[tuple[io.TextIOWrapper, io.TextIOWrapper]]:
    """Streams as a pipe has them, whose bytes can be written too."""
    out, err = (io.TextIOWrapper(io.BytesIO(), "utf-8", errors) for errors in ("strict", "backslashreplace"))
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        yield out, err


@contextlib.contextmanager
def _place(words: tuple[str | Path, ...], env: dict[str, str], cwd: Path | None) -> Iterator[None]:
    with (
        mock.patch.object(sys, "argv", ["vdoor", *map(str, words)]),
        mock.patch.dict(os.environ, environment() | env, clear=True),
        contextlib.chdir(cwd or Path.cwd()),
    ):
        yield


def _exit_code() -> int:
    try:
        vdoor.cli.main()
    except SystemExit as stopped:
        return stopped.code if isinstance(stopped.code, int) else int(stopped.code is not None)
    return 0


def _text(stream: io.TextIOWrapper) -> str:
    stream.flush()
    raw: Any = stream.buffer
    return str(raw.getvalue().decode())
