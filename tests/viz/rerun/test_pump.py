"""What Rerun writes reaches the file; a full disk is an error and not a wait without end."""

from __future__ import annotations

import io
import shutil
import subprocess
from pathlib import Path

import pytest
from project import VDOOR
from small_recording import small, small_run

from vdoor.errors import VdoorError
from vdoor.viz.rerun.program import HOST, offline
from vdoor.viz.rerun.pump import Pump
from vdoor.viz.rerun.sink import RerunSink


def test_bytes_arrive_in_order_and_at_once(tmp_path: Path) -> None:
    path = tmp_path / "a"
    pump = Pump(path.open("wb"))
    with Path(pump.address).open("wb", buffering=0) as stream:
        stream.writelines(bytes([number % 256]) * 1000 for number in range(300))
        pump.flush()
        assert path.stat().st_size == 300_000
        stream.write(b"end")
    pump.close()
    assert path.read_bytes() == b"".join(bytes([number % 256]) * 1000 for number in range(300)) + b"end"


def test_a_full_disk_is_said_and_does_not_block() -> None:
    pump = Pump(Path("/dev/full").open("wb", buffering=0))  # noqa: SIM115  # closed by the pump
    with Path(pump.address).open("wb", buffering=0) as stream:
        stream.writelines(bytes(100_000) for _ in range(100))  # far more than a pipe holds
        with pytest.raises(OSError, match="No space left"):
            pump.flush()
    with pytest.raises(OSError, match="No space left"):
        pump.close()


def test_a_recording_on_a_full_disk_is_one_error(tmp_path: Path) -> None:
    info, records = small_run()
    with pytest.raises(VdoorError, match=r"cannot be written \(No space left"):
        RerunSink.to_file(Path("/dev/full"), info)
    sink = RerunSink.to_file(tmp_path / "a.rrd", info, io.BytesIO())
    for step, record in enumerate(records):
        sink.write(step, record)
    sink.close()


def test_the_viewer_has_no_way_out(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("https_proxy", "http://proxy.example:3128")
    environment = offline()
    for name in ("HTTP_PROXY", "HTTPS_PROXY", "ALL_PROXY", "http_proxy", "https_proxy", "all_proxy"):
        assert environment[name] == f"http://{HOST}:9"
    if shutil.which("strace") is None:
        pytest.skip("strace is not there, so calls cannot be traced")
    log, vdoor = tmp_path / "log", VDOOR
    subprocess.run(
        [
            *["strace", "-f", "-qq", "-e", "trace=connect,sendto,sendmmsg", "-o"],
            log,
            vdoor,
            "info",
            small(tmp_path / "a.mcap"),
        ],
        check=True,
        capture_output=True,
    )
    assert not [line for line in log.read_text().splitlines() if "AF_INET" in line]
