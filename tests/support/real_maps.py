"""Maps of real places, for tests that read them where they lie beside the checkout; none is part of the project."""

from __future__ import annotations

from pathlib import Path

import pytest
from project import HOME

BENCH = HOME.parent / "shared" / "bench"


def real_maps(*patterns: str) -> list[Path]:
    """Files of these patterns that hold a map; the test is skipped where there are none."""
    found = sorted(path for pattern in patterns for path in BENCH.glob(pattern) if path.name != "truth.json")
    if not found:
        pytest.skip(f"no {', '.join(patterns)} in {BENCH}")
    return found
