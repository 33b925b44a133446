"""Memory is compared with what a map needs before any of it is taken."""

from __future__ import annotations

from pathlib import Path

from vdoor.errors import MapError

INPUT_BYTES, WORKING_BYTES = 15, 10
"""Bytes per cell of the input and of the working grid that a run needs at its peak. Measured: 20 in all with `default`
(a hundred million cells), 13 with `paper` (four million); these are about a quarter more."""
MB = 1_000_000


def needed_bytes(cells: int, factor: int) -> int:
    """The memory that a run takes for a map of so many cells, of which `factor` times `factor` are a working cell."""
    return INPUT_BYTES * cells + WORKING_BYTES * cells // factor**2


def available_bytes(meminfo: Path = Path("/proc/meminfo")) -> int | None:
    """The memory that programs may still take, as Linux estimates it; None where it does not say."""
    try:
        lines = meminfo.read_text().splitlines()
        return next(int(line.split()[1]) * 1024 for line in lines if line.startswith("MemAvailable:"))
    except (OSError, StopIteration, ValueError, IndexError):
        return None


def refuse_too_large(cells: int, factor: int, available: int | None) -> None:
    """Raise MapError if a map needs more memory than is available, with the setting that helps."""
    needed = needed_bytes(cells, factor)
    if available is not None and needed > available:
        helps = f"simplify.cell_m over {factor} cells of the map, or a part of the map, needs less"
        raise MapError(f"memory: wanted {needed / MB:.0f} MB, found {available / MB:.0f} MB free; {helps}")
