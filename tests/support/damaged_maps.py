"""Maps that are damaged, and what reading them gives: a grid, or one line that names the file."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from vdoor.errors import MapError, MapWarning
from vdoor.formats import read_source
from vdoor.grid import OccupancyGrid, Source


def refused(source: Source, match: str, **limits: int) -> None:
    """Claim that reading fails with one line that begins with `match` and ends with the name of a file."""
    with pytest.raises(MapError) as caught:
        read_source(source, **limits)
    text = str(caught.value)
    assert match in text
    assert "\n" not in text
    assert text.endswith(tuple(name for name, _ in source.files) or ("",))


def corrupted(data: bytes, rng: np.random.Generator) -> bytes:
    """A copy with up to eight bits flipped, cut short every third time."""
    damaged = np.frombuffer(data, np.uint8).copy()
    at = rng.integers(len(damaged), size=rng.integers(9))
    damaged[at] ^= np.uint8(1) << rng.integers(8, size=len(at)).astype(np.uint8)
    return damaged[: rng.integers(len(damaged)) if rng.integers(3) == 0 else None].tobytes()


def outcome(source: Source) -> type:
    """What reading gave; anything but a sound grid or an error of one line fails."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MapWarning)
        try:
            grid = read_source(source, max_cells=100_000)
        except MapError as error:
            return MapError if "\n" not in str(error) else str
    return OccupancyGrid if grid.cells.min() >= -1 and grid.cells.max() <= 100 else int
