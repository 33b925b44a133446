"""The `rerun` program as a child process, bound to this machine, and the files that it can load."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
import warnings
from pathlib import Path

from rerun.chunk import RrdReader

from vdoor.errors import VdoorError

HOST = "127.0.0.1"
END_S = 5.0


def start(*words: str | Path, quiet: bool = True) -> subprocess.Popen[bytes]:
    """Start the program that was installed with the library, in a process group of its own."""
    output = subprocess.DEVNULL if quiet else None
    return subprocess.Popen(  # noqa: S603  # our own program
        [Path(sys.executable).with_name("rerun"), "--bind", HOST, *words],
        stdout=output,
        stderr=output,
        env=os.environ | {"CI": "1"},  # no analytics
        start_new_session=True,
    )


def end(process: subprocess.Popen[bytes]) -> None:
    """End the program and the viewer it started: the program is a script that only waits for that one."""
    for number in (signal.SIGTERM, signal.SIGKILL):
        try:
            os.killpg(process.pid, number)
            process.wait(timeout=END_S)
        except ProcessLookupError:
            return
        except subprocess.TimeoutExpired:
            continue


def wait_until_listening(process: subprocess.Popen[bytes], port: int, patience_s: float) -> bool:
    """Whether the program takes connections before it ends or time is up."""
    until = time.monotonic() + patience_s
    while not listening(HOST, port):
        if process.poll() is not None or time.monotonic() > until:
            return False
        time.sleep(0.1)
    return True


def listening(host: str, port: int) -> bool:
    """Whether somebody takes connections there."""
    try:
        with socket.create_connection((host, port), timeout=2.0):
            return True
    except OSError:
        return False


def free_port() -> int:
    """A port nobody listens on."""
    with socket.socket() as probe:
        probe.bind((HOST, 0))
        return int(probe.getsockname()[1])


MAGIC = b"RRF"
"""How all versions of the format begin."""


def refuse_unreadable(path: Path) -> None:
    """VdoorError where a file is no Rerun recording, or one that was cut short: a viewer would wait for the rest."""
    with path.open("rb") as stream:
        if stream.read(len(MAGIC)) != MAGIC:
            raise VdoorError(f"recording: wanted a Rerun recording, found another file: {path}")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # files without a footer can be drawn
            whole = any(True for _ in RrdReader(path).stream())
    except (RuntimeError, ValueError, OSError):
        whole = False
    if not whole:
        raise VdoorError(
            "recording: wanted a whole Rerun recording, found a damaged one or one that was cut short; "
            f"`rerun rrd merge --continue-on-error -o FIXED.rrd BROKEN.rrd` may save what is left: {path}"
        )
