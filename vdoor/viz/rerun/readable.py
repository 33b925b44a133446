"""Whether a file is a Rerun recording that a viewer can load."""

from __future__ import annotations

import warnings
from pathlib import Path

from rerun.chunk import RrdReader

from vdoor.errors import VdoorError

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
