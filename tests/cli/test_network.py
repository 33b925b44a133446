"""No command connects, or looks a name up, outside this machine: every call of the system is traced."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import finished_maps
import pytest
from project import FLAT
from small_recording import small

CALLS = """
import io, signal, sys
from vdoor.cli import main

class Out(io.StringIO):
    def write(self, text):
        if "http://127.0.0.1" in text:  # the address of a page, which is served until Ctrl-C
            signal.setitimer(signal.ITIMER_REAL, 0.5)
        return super().write(text)

signal.signal(signal.SIGALRM, lambda *_: signal.raise_signal(signal.SIGINT))
sys.stdout = Out()
for text in sys.argv[1:]:
    words = text.split("|")
    sys.argv = ["vdoor", *words]
    try:
        main()
        code = 0
    except SystemExit as stopped:
        code = int(stopped.code or 0)
    print("code", code, text, file=sys.stderr)
"""
HERE = re.compile(r'inet_addr\("127\.|inet_pton\(AF_INET6, "::1"|AF_INET6?, sin6?_port=htons\(0\)')


def test_newer_commands_stay_on_this_machine(tmp_path: Path) -> None:
    if shutil.which("strace") is None:
        pytest.skip("strace is not there, so calls cannot be traced")
    recording, result = small(tmp_path / "a.mcap"), finished_maps.result("flat", tmp_path / "r")
    calls = [
        f"edit|{result}",
        f"batch|{FLAT}|--out|{tmp_path}/b|-j|1|--preset|paper",
        f"nav2|{result}|--out|{tmp_path}/n",
        f"cover|{result}|--export|csv={tmp_path}/c.csv",
        f"replay|{recording}|--save|{tmp_path}/a.rrd",
    ]
    log = tmp_path / "log"
    done = subprocess.run(
        ["strace", "-f", "--seccomp-bpf", "-qq", "-e", "trace=connect,sendto,sendmmsg,sendmsg,bind", "-o", log,
         sys.executable, "-c", CALLS, *calls],
        check=True, capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    assert re.findall("^code ([0-9]+)", done.stderr, re.MULTILINE) == ["0"] * len(calls), done.stderr
    traced = [line for line in log.read_text().splitlines() if "AF_INET" in line]
    assert [line for line in traced if "htons" in line]  # the page's own port, so the trace sees something
    assert not [line for line in traced if not HERE.search(line)]
