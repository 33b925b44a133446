"""Small maps for tests: drawn as text, drawn at random, and moved about."""

from __future__ import annotations

import dataclasses
import textwrap
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from hypothesis import settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from vdoor.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from vdoor.method.boundary import BoundaryPath
from vdoor.method.corners import Candidates, Corners
from vdoor.method.curvature import Curvature
from vdoor.method.doors import VirtualDoors
from vdoor.method.initial_map import InitialMap
from vdoor.method.simplify import SimplifiedGrid, SimplifyGrid
from vdoor.pipeline import Pipeline

Cells = NDArray[np.int8]
CELL_M = 0.2
STATES = {".": FREE, "#": OCCUPIED, "?": UNKNOWN}
law = settings(max_examples=30, deadline=None, derandomize=True)
long_law = settings(law, max_examples=90)


def cells_drawn(text: str) -> Cells:
    """Cells (h, w) of a drawing: ``.`` free, ``#`` occupied, ``?`` unknown."""
    return np.array([[STATES[sign] for sign in line] for line in textwrap.dedent(text).split()], np.int8)


def drawn(text: str, cell_m: float = CELL_M) -> OccupancyGrid:
    """The map of a drawing."""
    return OccupancyGrid.from_array(cells_drawn(text), cell_m)


def text_of(cells: Cells) -> str:
    """The drawing of cells (h, w), a line a row."""
    signs = {state: sign for sign, state in STATES.items()}
    return "\n".join("".join(signs[state] for state in row) for row in cells.tolist())


@dataclass(frozen=True)
class Stages:
    """What the stages before the search return."""

    simplified: SimplifiedGrid
    path: BoundaryPath
    curvature: Curvature
    candidates: Candidates
    corners: Corners
    doors: VirtualDoors
    initial: InitialMap


def stages(grid: OccupancyGrid, pipeline: Pipeline | None = None) -> Stages:
    """The records before the search, by the paper's settings unless told otherwise."""
    stage = pipeline or Pipeline()
    simplified = stage.simplify(grid)
    path = stage.trace(simplified)
    curvature = stage.curvature(path)
    candidates = stage.candidates(path, curvature)
    corners = stage.corners(path, curvature, candidates)
    doors = stage.doors(simplified, path, corners)
    initial = stage.divide(simplified, path, corners, doors)
    return Stages(simplified, path, curvature, candidates, corners, doors, initial)


def simplifying(**changes: Any) -> Pipeline:
    """The paper's pipeline with other settings of its first stage."""
    return Pipeline(simplify=SimplifyGrid(**changes))


def with_search(pipeline: Pipeline, search: Any) -> Pipeline:
    """The pipeline with another optimiser."""
    return dataclasses.replace(pipeline, search=search)


@dataclass(frozen=True)
class Move:
    """Something done to a map that must change nothing but coordinates."""

    name: str
    cells: Callable[[Cells], Cells]
    """What it does to the input's cells (h, w)."""
    points: Callable[[NDArray[Any], tuple[int, int]], NDArray[Any]]
    """Where it takes points (k, 2) as row, col in a map of (h, w); 0, 0 is the map's upper left corner."""
    finer: int = 1
    """How many times as fine the cells become."""


def _turned(points: NDArray[Any], shape: tuple[int, int]) -> NDArray[Any]:
    return np.stack([shape[1] - points[:, 1], points[:, 0]], axis=1)


def _mirrored(points: NDArray[Any], shape: tuple[int, int]) -> NDArray[Any]:
    return np.stack([points[:, 0], shape[1] - points[:, 1]], axis=1)


def _shifted(cells: Cells) -> Cells:
    return np.pad(cells, ((3, 2), (5, 0)), constant_values=UNKNOWN)


MOVES = (
    Move("shift", _shifted, lambda points, _: points + np.array([3, 5])),
    Move("quarter turn", np.rot90, _turned),
    Move("half turn", lambda cells: np.rot90(cells, 2), lambda points, shape: np.array(shape) - points),
    Move("mirror", np.fliplr, _mirrored),
    Move("transpose", np.transpose, lambda points, _: points[:, ::-1]),
    Move("double", lambda cells: cells.repeat(2, axis=0).repeat(2, axis=1), lambda points, _: points, finer=2),
)


def moved(cells: Cells, move: Move) -> OccupancyGrid:
    """The moved map."""
    return OccupancyGrid.from_array(move.cells(cells), CELL_M / move.finer)


@st.composite
def small_maps(draw: st.DrawFn, *, most: int = 22, framed: bool = False) -> Cells:
    """Cells (h, w) of orthogonal walls one or two cells thick, with gaps and specks, with or without an outer wall."""
    height, width = draw(st.integers(6, most)), draw(st.integers(6, most))
    cells = np.full((height, width), FREE, np.int8)
    for _ in range(draw(st.integers(1, 4))):
        _build_wall(draw, cells if draw(st.booleans()) else cells.T)
    for _ in range(draw(st.integers(0, 6))):
        place = draw(st.integers(0, height - 1)), draw(st.integers(0, width - 1))
        cells[place] = draw(st.sampled_from([OCCUPIED, OCCUPIED, FREE, UNKNOWN]))
    if framed or draw(st.booleans()):
        cells = np.pad(cells, 1, constant_values=OCCUPIED)
    row, col = draw(st.integers(0, 1)), draw(st.integers(0, 1))
    cells[1 + 4 * row : 5 + 4 * row, 1 + 4 * col : 5 + 4 * col] = FREE  # there is a free cell at any resolution
    return cells


def _build_wall(draw: st.DrawFn, cells: Cells) -> None:
    """Build one wall along the rows of `cells`, with a gap or two in it."""
    height, width = cells.shape
    row, thick = draw(st.integers(0, height - 1)), draw(st.integers(1, 2))
    begin, end = draw(st.integers(0, width // 3)), draw(st.integers(2 * width // 3, width))
    cells[row : row + thick, begin:end] = OCCUPIED
    for _ in range(draw(st.integers(1, 2))):
        gap, wide = draw(st.integers(begin, end)), draw(st.integers(1, 6))
        cells[row : row + thick, gap : gap + wide] = FREE
