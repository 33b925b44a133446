"""The `rerun` program as a child process that only listens locally, and a check of the files that it can load."""

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
CLOSED = f"http://{HOST}:9"
"""The port of a service (discard) that only connects to nothing."""


def start(*words: str | Path, quiet: bool = True) -> subprocess.Popen[bytes]:
    """Start the program installed with the library, in its own process group."""
    output = subprocess.DEVNULL if quiet else None
    return subprocess.Popen(  # noqa: S603  # our own program
        [Path(sys.executable).with_name("rerun"), "--bind", HOST, *words],
        stdout=output,
        stderr=output,
        env=offline(),
        start_new_session=True,
    )


def offline() -> dict[str, str]:
    """The environment for a viewer that asks nobody for anything: no analytics, and no way out but a closed port.

    Its check for a newer version goes through a proxy, which then need not look the host's name up.
    """
    proxies = dict.fromkeys(("HTTP_PROXY", "HTTPS_PROXY", "ALL_PROXY"), CLOSED)
    local = {"NO_PROXY": f"localhost,{HOST}"}
    ours = {"CI": "1"} | proxies | local
    others = {name: value for name, value in os.environ.items() if name.upper() not in ours}
    return others | ours | {name.lower(): value for name, value in (proxies | local).items()}


def end(process: subprocess.Popen[bytes]) -> None:
    """End the program and the viewer that it started: the program is a script that only waits for the viewer."""
    for number in (signal.SIGTERM, signal.SIGKILL):
        try:
            os.killpg(process.pid, number)
            process.wait(timeout=END_S)
        except ProcessLookupError:
            return
        except subprocess.TimeoutExpired:
            continue


def wait_until_listening(process: subprocess.Popen[bytes], port: int, patience_s: float) -> bool:
    """Whether the program accepts connections before it exits or the time is up."""
    until = time.monotonic() + patience_s
    while not listening(HOST, port):
        if process.poll() is not None or time.monotonic() > until:
            return False
        time.sleep(0.1)
    return True


def listening(host: str, port: int) -> bool:
    """Whether connections to a port are accepted."""
    try:
        with socket.create_connection((host, port), timeout=2.0):
            return True
    except OSError:
        return False


def free_port() -> int:
    """A port that is not in use."""
    with socket.socket() as probe:
        probe.bind((HOST, 0))
        return int(probe.getsockname()[1])


MAGIC = b"RRF"
"""First bytes of a file, in all versions of the format."""


def refuse_unreadable(path: Path) -> None:
    """Raise `VdoorError` unless a file is a complete Rerun recording: a viewer would wait for the rest of it."""
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
            "recording: wanted a complete Rerun recording, found a damaged one or one cut short; "
            f"`rerun rrd merge --continue-on-error -o FIXED.rrd BROKEN.rrd` may save what is left: {path}"
        )
