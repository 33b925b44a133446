"""Where things of the project lie."""

from __future__ import annotations

import sys
from pathlib import Path

HOME = Path(__file__).parents[2]
RECORDINGS = HOME / "recordings"
FLAT = RECORDINGS / "flat.yaml"
GOLDEN = RECORDINGS / "golden"
PAGES = (HOME / "README.md", HOME / "CONTRIBUTING.md", *sorted((HOME / "docs").glob("*.md")))
VDOOR = Path(sys.executable).parent / "vdoor"
