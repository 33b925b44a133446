"""Pages of the report: what they hold, and runs to show."""

from __future__ import annotations

import dataclasses
import json
import re
from typing import Any

import finished_maps

from vdoor.api import run_info, run_prepared
from vdoor.emit import RunInfo
from vdoor.history.provenance import Provenance
from vdoor.navigate.cover_floor import CoverFloor
from vdoor.navigate.find_route import FindRoute
from vdoor.pipeline import PRESETS

HOSTILE = "</script><script>document.title='caught'</script><img src=x onerror=alert(1)>&amp;\u202e'\"`${1}.pgm"
STAGES = "input simplified changed path curvature candidates corners doors rejected initial_map search left-out"


def told(page: str) -> Any:
    """What a page holds."""
    (text,) = re.findall(r'<script type="application/json" id="data">(.*?)</script>', page, re.DOTALL)
    return json.loads(text)


def provenance_of(name: str, **about: Any) -> Provenance:
    """An example's run as it is known before any record."""
    info = RunInfo(version="0.1.0", preset="paper", seed=0, settings={}, source=finished_maps.grid(name).source)
    return Provenance.of(RunInfo(**{**vars(info), **about}))


def driven() -> tuple[Provenance, Any]:
    """A run with a route and a covering path."""
    grid = finished_maps.grid("flat")
    tasks = {"route": FindRoute(start="1", goal="5"), "cover": CoverFloor(unit="room", rooms=("1",))}
    pipeline = dataclasses.replace(PRESETS["paper"], **tasks)
    provenance = Provenance.of(run_info(grid, "paper", pipeline, 0))
    return provenance, run_prepared(grid, pipeline, emit=provenance.run)
