"""The command where the Rerun viewer was not installed."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from project import HOME

WITHOUT = "import sys; sys.modules['rerun'] = None; from vdoor.cli import main; main()"


def test_maps_are_run_and_recorded_and_a_viewer_is_missed_in_one_line(tmp_path: Path) -> None:
    words = ["run", HOME / "recordings" / "flat.yaml", "-q", "--mcap", tmp_path / "out.mcap"]
    report = f"report={tmp_path / 'report.html'}"
    for more, code in ((["--save", tmp_path / "out.rrd"], 2), (["--export", report], 0)):
        done = subprocess.run(
            [sys.executable, "-c", WITHOUT, *map(str, [*words, *more])], capture_output=True, text=True, check=False
        )
        assert done.returncode == code, done.stderr
        wanted = (
            "vdoor: rerun: wanted the package rerun-sdk==0.41.*, found none; `pip install rerun-sdk==0.41.*` adds it"
        )
        assert done.stderr.splitlines() == ([wanted] if code else [])
    assert {path.name for path in tmp_path.iterdir()} == {"out.mcap", "report.html"}
