"""Maps that need more memory than there is are refused in one line."""

from __future__ import annotations

from pathlib import Path

import pytest

from vdoor.errors import MapError
from vdoor.memory import available_bytes, needed_bytes, refuse_too_large


def test_a_map_is_refused_exactly_when_it_needs_more_than_there_is() -> None:
    needed = needed_bytes(100_000_000, 1)
    assert needed == 2_500_000_000
    refuse_too_large(100_000_000, 1, needed)
    refuse_too_large(100_000_000, 1, None)
    refuse_too_large(100_000_000, 4, needed - 1)
    with pytest.raises(MapError, match=r"^memory: wanted 2500 MB, found 2499 MB free; simplify.cell_m over 1 cells"):
        refuse_too_large(100_000_000, 1, needed - MB)


MB = 1_000_000


def test_free_memory_is_what_linux_says(tmp_path: Path) -> None:
    said = tmp_path / "meminfo"
    said.write_text("MemTotal: 16 kB\nMemFree: 1 kB\nMemAvailable:    8 kB\n")
    assert available_bytes(said) == 8192
    said.write_text("MemTotal: 16 kB\n")
    assert available_bytes(said) is None
    assert available_bytes(tmp_path / "none") is None
