"""Figure 6: the doors that several methods find on the same maps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vdoor.grid import OccupancyGrid
from vdoor.paper.pictures_.plan import Plan, key, window_of
from vdoor.viz.charts import drawing, to_png
from vdoor.viz.rerun import style

Lines = NDArray[np.float64]

REAL: style.Colour = (20, 150, 70)
MATCHED: style.Colour = (36, 92, 230)
WRONG: style.Colour = (214, 50, 60)
PX = 3.6


@dataclass(frozen=True, eq=False)
class Compared:
    """One map and what was found on it; lines are ends (k, 2, 2) as x, y in metres of the map frame."""

    name: str
    grid: OccupancyGrid
    real_m: Lines
    found: Mapping[str, tuple[Lines, NDArray[np.bool_]]]
    """By the method's name: its doors, and which of them (k,) are real ones."""


def comparison(maps: Sequence[Compared]) -> bytes:
    """A row a map, a column a method, as a PNG."""
    sizes = [(bottom - top + 1, right - left + 1) for top, bottom, left, right in (_window(one) for one in maps)]
    tall, wide = (np.array(sizes) * PX / 72).T
    columns = 1 + len(maps[0].found)
    with drawing(columns * (wide.max() + 0.15), tall.sum() + 0.3 * len(maps) + 0.4) as figure:
        axes = figure.subplots(len(maps), columns, squeeze=False, height_ratios=tall)
        for row, one in zip(axes, maps, strict=True):
            _draw(Plan(row[0], f"{one.name}: real doors", _window(one), px=PX), one, (one.real_m, None))
            for place, (name, found) in zip(row[1:], one.found.items(), strict=True):
                _draw(Plan(place, f"{name}: {int(found[1].sum())} of {len(found[1])}", _window(one), px=PX), one, found)
        meanings = (("-", REAL, "real door"), ("-", MATCHED, "found, a real one"), ("-", WRONG, "found, no real one"))
        key(axes[0, 0], meanings, columns=3)
        return to_png(figure)


def _window(one: Compared) -> tuple[int, int, int, int]:
    """What is known, without the blots outside: the longest runs of walls say where the home ends."""
    cells = one.grid.cells
    rows, columns = (np.flatnonzero((cells >= 0).sum(axis=axis) > cells.shape[axis] / 4) for axis in (1, 0))
    top, bottom, left, right = int(rows[0]), int(rows[-1]), int(columns[0]), int(columns[-1])
    known = window_of(cells, 0)
    return max(top - 1, known[0]), min(bottom + 1, known[1]), max(left - 1, known[2]), min(right + 1, known[3])


def _draw(plan: Plan, one: Compared, found: tuple[Lines, NDArray[np.bool_] | None]) -> None:
    lines, real = found
    plan.cells(one.grid.cells)
    ends = one.grid.frame.cell_from_world(lines.reshape(-1, 2)).reshape(-1, 2, 2)
    groups = ((np.ones(len(ends), np.bool_), REAL),) if real is None else ((real, MATCHED), (~real, WRONG))
    for chosen, colour in groups:
        plan.lines(ends[chosen, 0], ends[chosen, 1], colour, wide=3.0)
