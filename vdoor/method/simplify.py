"""Section II.A: the grid without cells that the robot cannot reach, and without juts."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray

from vdoor.config import Within
from vdoor.errors import MapError, SettingError
from vdoor.frame import Frame
from vdoor.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from vdoor.method.parts import large_parts, long_pieces, remaining, sides_of, sills, wide_parts
from vdoor.method.spaces import SHORTEST_DASH, Spaces, furniture, in_line
from vdoor.raster.morphology import in_bands, opened, square, with_neighbours
from vdoor.raster.runs import Runs, parts_of_mask
from vdoor.record import Record, Spec

Mask = NDArray[np.bool_]

ROBOT_REACH_M = 0.5
"""Largest distance between the robot's position and the nearest free cell."""
THIN_LONG_M = 1.0
"""Largest length of a thin unknown line that becomes free."""
SILL_LONG_M = 0.4
"""Least length of a sill: a door that a robot fits through."""
SURE_SHARE = 0.7
"""Smallest share of free cells around a thin unknown cell that becomes free."""
CHANNEL_LONG_M = 0.4
"""A channel is longer than this."""
DASH_THICK_M, DASH_LONG_M = 0.3, 0.25
"""Largest thickness of a wall drawn in dashes, and smallest length of one of two dashes in line."""
SPACE_M2 = 0.2
"""Smallest area of a space that counts as separate; a corner behind a bin is less."""
EPSILON = 1e-9
AROUND = ((0, 0), (0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1), (2, 2))
REASONS = ("as it was", "unreachable", "jut", "notch", "island", "thin unknown", "slit", "sill")


class SimplifiedGrid(Record):
    """The grid at the working resolution: free cells are reachable, and cells that do not touch them are unknown."""

    topic: ClassVar[str] = "simplified"

    cells: Annotated[NDArray[np.int8], Spec("occupancy", "height width")]
    reason: Annotated[NDArray[np.uint8], Spec("codes", "height width", words=REASONS)]
    """Why a cell differs from the resampled input."""
    factor: Annotated[int, Spec("count")]
    """Number of input cells along one side of a working cell."""
    frame: Frame


@dataclass(frozen=True, kw_only=True)
class SimplifyGrid:
    """Resample, keep what the robot can reach, drop small islands, flatten juts and notches."""

    cell_m: Annotated[float, Within(0, 10)] = 0.20
    """Working resolution, rounded to a whole multiple of the map's cell size; 0 = the map's own."""
    robot_m: tuple[float, ...] = ()
    """Position of the robot (x, y in the map frame); if empty, the largest free component is reachable."""
    jut_m: Annotated[float, Within(0, 1)] = 0.15
    """Longest run of cells that counts as a jut or notch; at least one cell."""
    passes: Annotated[int, Within(0, 100)] = 3
    """Maximum number of flattening passes."""
    max_island_m: Annotated[float, Within(0, 100)] = 0.0
    """Free-standing obstacles whose bounding box is at most this long are removed; 0 keeps all (paper)."""
    thin_unknown_m: Annotated[float, Within(0, 1)] = 0.0
    """Unknown lines up to this thick with free space around them become free; 0 keeps them (paper)."""
    slit_m: Annotated[float, Within(0, 1)] = 0.0
    """Free space up to this wide is closed: hollow walls, cracks in walls, single rays; 0 keeps it (paper)."""
    channel_m: Annotated[float, Within(0, 1)] = 0.0
    """Free space up to this wide and over 0.4 m long is closed, since no robot fits through; 0 keeps it (paper)."""
    gap_m: Annotated[float, Within(0, 1)] = 0.0
    """Gaps up to this wide are closed, since no robot fits through. Islands and thin unknown lines are then removed
    only if that connects no spaces that are separate with such gaps closed. Less than a cell: no gap is closed, and all
    of them are removed (paper)."""
    around_m: Annotated[float, Within(0, 10)] = 1.0
    """The spaces on two sides of an obstacle are separate if no way leads around it within this distance."""
    least_part_m2: Annotated[float, Within(0, 1e6)] = 0.0
    """Free parts of at least this area that fit a square of 0.5 m are kept beside the robot's, as rooms behind doors
    that were shut; 0 keeps only one (paper)."""
    sill_m: Annotated[float, Within(0, 1)] = 0.0
    """Unknown strips up to this thick between two such parts become free, since robots often do not see the floor of a
    doorway; 0 keeps them (paper)."""

    def __post_init__(self) -> None:
        """Raise SettingError for a position that is not x and y."""
        if len(self.robot_m) not in (0, 2):
            raise SettingError(f"simplify.robot_m: wanted x and y, or none, found {list(self.robot_m)}")

    def factor(self, frame: Frame) -> int:
        """The number of input cells along one side of a working cell."""
        return max(1, round(self.cell_m / frame.resolution_m))

    def __call__(self, grid: OccupancyGrid) -> SimplifiedGrid:
        """The simplified grid; raises MapError if no cell is free, or none is near the robot's position."""
        factor = self.factor(grid.frame)
        frame = working_frame(grid.frame, factor)
        before = resampled(grid, factor)
        reason = np.zeros(before.shape, np.uint8)

        known_free = before == FREE
        thin = np.zeros_like(known_free)
        if self.thin_unknown_m > 0:
            thin = thin_unknown(
                before, *(max(1, round(size / frame.resolution_m)) for size in (self.thin_unknown_m, THIN_LONG_M))
            )
        sill = self._sills(before, known_free, frame)
        thin &= ~sill
        free = self._reachable(known_free | thin | sill, frame, wall=before == OCCUPIED)
        mark(reason, (known_free | thin) & ~free, "unreachable")
        mark(reason, sill & free, "sill")
        free = self._without_furniture(free, thin & free, reason, frame)
        if gap := cells_in(self.gap_m, frame):
            free = self._closed(free, Spaces.of(free, gap).gap, reason, frame)
        free = self._without_slits(free, reason, frame)
        run = max(1, round(self.jut_m / frame.resolution_m))
        for name, changed in zip(("jut", "notch"), flatten(free, run, self.passes), strict=True):
            mark(reason, changed, name)

        wall = touches(free) & ((before == OCCUPIED) | (reason == REASONS.index("notch")))
        mark(reason, (before == OCCUPIED) & ~free & ~wall, "unreachable")
        cells = np.full(before.shape, UNKNOWN, np.int8)
        np.putmask(cells, free, FREE)
        np.putmask(cells, wall, OCCUPIED)
        mark(reason, cells == before, "as it was")
        return SimplifiedGrid(cells=cells, reason=reason, factor=factor, frame=frame)

    def _without_furniture(self, free: Mask, thin: Mask, reason: NDArray[np.uint8], frame: Frame) -> Mask:
        """The free cells, including `thin` unknown ones, with small islands removed, except pieces of walls."""
        islands = np.zeros_like(free)
        gap = cells_in(self.gap_m, frame)
        if self.max_island_m > 0:
            line = np.zeros_like(free)
            if gap:
                thick, long = cells_in(DASH_THICK_M, frame), cells_in(DASH_LONG_M, frame)
                line = in_line(free, wide=gap, thick=thick, least=max(long, SHORTEST_DASH + 1))
            islands = small_islands(free & ~line, max(1, round(self.max_island_m / frame.resolution_m))) & ~free
            del line
        if gap:
            known = free & ~thin
            goes = furniture(
                known,
                islands | thin,
                gap=gap,
                around=cells_in(self.around_m, frame),
                least=SPACE_M2 / frame.resolution_m**2,
            )
            # Space behind a thin line that is kept is no longer reachable.
            free = self._reachable(known | goes, frame, before=free)
            mark(reason, known & ~free, "unreachable")
            islands, thin = islands & free, thin & free
        mark(reason, thin, "thin unknown")
        mark(reason, islands, "island")
        return free | islands

    def _without_slits(self, free: Mask, reason: NDArray[np.uint8], frame: Frame) -> Mask:
        """The free cells that remain reachable with slits and channels closed."""
        slit, channel = (cells_in(width_m, frame) for width_m in (self.slit_m, self.channel_m))
        narrow = narrower(free, slit) | long_pieces(narrower(free, channel), CHANNEL_LONG_M / frame.resolution_m)
        return self._closed(free, narrow, reason, frame)

    def _closed(self, free: Mask, narrow: Mask, reason: NDArray[np.uint8], frame: Frame) -> Mask:
        """The free cells that remain reachable without the narrow ones; all of them if all are narrow."""
        wide = free & ~narrow
        if not (narrow.any() and wide.any()):
            return free
        kept = self._reachable(wide, frame, before=free)
        mark(reason, narrow, "slit")
        mark(reason, wide & ~kept, "unreachable")
        return kept

    def _reachable(self, free: Mask, frame: Frame, *, wall: Mask | None = None, before: Mask | None = None) -> Mask:
        """The 4-connected component of `free` with the robot, or else the largest, and other rooms.

        Rooms are found with the cells of walls. Of what was kept `before`, no part goes as a whole, and what is cut off
        from it must be wide to be a room.
        """
        parts = parts_of_mask(free)
        if parts.most == 0:
            raise MapError(
                f"the map has no free cell at {frame.resolution_m:g} m per cell, so there is nothing to divide"
            )
        kept = np.zeros(parts.most + 1, np.bool_)
        if self.least_part_m2 > 0:
            if wall is not None:
                kept |= large_parts(parts, free, wall, *self._least(frame))
            if before is not None:
                kept |= remaining(parts, before) | wide_parts(parts, free, *self._least(frame))
        kept[self._own_part(parts, frame)] = True
        return parts.chosen(kept).mask()

    def _least(self, frame: Frame) -> tuple[float, float]:
        """The least number of cells of a part of the free space, and the size of a cell in metres."""
        return self.least_part_m2 / frame.resolution_m**2, frame.resolution_m

    def _sills(self, before: NDArray[np.int8], free: Mask, frame: Frame) -> Mask:
        """The sills between large parts of the free space."""
        thick = cells_in(self.sill_m, frame)
        if not (thick and self.least_part_m2 > 0):
            return np.zeros_like(free)
        parts = parts_of_mask(free)
        rooms = parts.chosen(large_parts(parts, free, before == OCCUPIED, *self._least(frame)))
        return sills(before == UNKNOWN, rooms, thick, SILL_LONG_M / frame.resolution_m)

    def _own_part(self, parts: Runs, frame: Frame) -> int:
        """The label of the robot's part of the free space; of the largest if its position is not known."""
        if not self.robot_m:
            return int(1 + np.argmax(parts.cells(parts.most)))
        place = frame.cell_from_world(np.array([self.robot_m]))[0]
        reach = ROBOT_REACH_M / frame.resolution_m
        first = np.clip(np.floor(place - reach), 0, parts.shape).astype(np.intp)
        after = np.clip(np.ceil(place + reach) + 1, 0, parts.shape).astype(np.intp)
        labels = parts.inside(tuple(map(slice, first.tolist(), after.tolist()))).image()
        cells = np.argwhere(labels)
        nearest = min(cells.tolist(), key=lambda cell: math.dist(first + cell, place), default=None)
        if nearest is None or math.dist(first + nearest, place) * frame.resolution_m > ROBOT_REACH_M:
            x_m, y_m = self.robot_m
            raise MapError(f"robot at {x_m:g},{y_m:g}: wanted a free cell within {ROBOT_REACH_M} m, found none")
        return int(labels[tuple(nearest)])


def mark(reason: NDArray[np.uint8], where: Mask, why: str) -> None:
    """Set the reason of some cells."""
    np.putmask(reason, where, REASONS.index(why))


def cells_in(length_m: float, frame: Frame) -> int:
    """The number of whole cells in a length."""
    return int(length_m / frame.resolution_m + EPSILON)


def working_frame(frame: Frame, factor: int) -> Frame:
    """The frame of a raster of cells `factor` times as large with the same upper left corner."""
    height, width = -(-frame.height // factor), -(-frame.width // factor)
    corner_m = frame.world_from_cell(np.array([[height * factor - 0.5, -0.5]]))[0]
    return Frame(height, width, frame.resolution_m * factor, float(corner_m[0]), float(corner_m[1]), frame.yaw_rad)


def resampled(grid: OccupancyGrid, factor: int) -> NDArray[np.int8]:
    """The working cells: occupied if any of their input cells is, else free if any is, else unknown.

    Occupied if any is keeps all walls closed; a majority rule would close a third of the narrow doors as well.
    """
    occupied, free = grid.occupied, grid.free
    if factor > 1:
        occupied, free = (any_of_block(mask, factor) for mask in (occupied, free))
    cells = np.full(occupied.shape, UNKNOWN, np.int8)
    np.putmask(cells, free, FREE)
    np.putmask(cells, occupied, OCCUPIED)
    return cells


def any_of_block(mask: Mask, side: int) -> Mask:
    """Whether any cell is set in each block of `side` x `side` cells, those at the lower and right edges cut off."""
    height, width = (-(-length // side) for length in mask.shape)
    found = np.zeros((height, width), np.bool_)
    for down, right in np.ndindex(side, side):
        part = mask[down::side, right::side]
        found[: part.shape[0], : part.shape[1]] |= part
    return found


def thin_unknown(cells: NDArray[np.int8], thick: int, longest: int) -> Mask:
    """Unknown cells in lines at most `thick` cells thick and `longest` cells long, with nearly all neighbours free.

    Longer lines are walls that were drawn or seen in part.
    """
    unknown = cells == UNKNOWN
    thin = unknown & ~opened(unknown, square(thick + 1), outside=True)
    row, col = np.nonzero(thin)
    around = np.pad(cells, 1, constant_values=UNKNOWN)
    near = np.stack([around[row + down, col + right] for down, right in AROUND])
    free = (near == FREE).sum(axis=0)
    cleared = np.zeros(cells.shape, np.bool_)
    enough = free >= SURE_SHARE * near.shape[0]
    cleared[row[enough], col[enough]] = True
    return cleared & ~long_pieces(cleared, longest, connectivity=2)


def small_islands(free: Mask, size: int) -> Mask:
    """The cells of 8-connected obstacles that are surrounded by free space and fit into a box of `size` cells."""
    obstacles = parts_of_mask(np.pad(~free, 1, constant_values=True), 2)
    small = sides_of(obstacles) <= size
    small[[0, obstacles.label[0]]] = False
    return obstacles.chosen(small).mask()[1:-1, 1:-1]


def narrower(free: Mask, thick: int) -> Mask:
    """The free cells that are in no free square with sides of more than `thick` cells."""
    return in_bands(lambda some: some & ~opened(some, square(thick + 1)), free, 2 * thick)


def touches(free: Mask) -> Mask:
    """The cells that are not free but have a free cell among their eight neighbours."""
    return with_neighbours(free) & ~free


def flatten(free: Mask, run: int, passes: int) -> tuple[Mask, Mask]:
    """Flatten juts and notches of `free` in place; returns the cells that became free, and those no longer free.

    A jut is a run of at most `run` cells, one cell deep, on a wall that extends at least one cell past both ends. A
    notch is the same with free and obstacle swapped. All four directions are evaluated on the same state, so that the
    result rotates and mirrors with the map.
    """
    state = np.pad(free, 2)
    start = state.copy()
    near = np.flatnonzero(np.diff(state, axis=0, append=False) | np.diff(state, axis=1, append=False))
    near = spread(near, state, 1)
    for _ in range(passes):
        changed = np.concatenate([runs(state, near, run, value) for value in (False, True)])
        if not len(changed):
            break
        state.reshape(-1)[changed] ^= True
        near = spread(changed, state, run + 2)
    free[:] = state[2:-2, 2:-2]
    return (state & ~start)[2:-2, 2:-2], (start & ~state)[2:-2, 2:-2]


def spread(index: NDArray[np.intp], state: Mask, reach: int) -> NDArray[np.intp]:
    """The flat indices within a square of `reach` cells around any in `index`, without the padding."""
    mask = np.zeros(state.size, np.bool_)
    step = np.arange(-reach, reach + 1)
    for offset in (step[:, None] * state.shape[1] + step).ravel():
        mask[np.clip(index + offset, 0, state.size - 1)] = True
    inner = np.zeros(state.shape, np.bool_)
    inner[2:-2, 2:-2] = True
    return np.flatnonzero(mask & inner.ravel())


def runs(state: Mask, near: NDArray[np.intp], longest: int, value: bool) -> NDArray[np.intp]:
    """The flat indices of cells in runs of `value` up to `longest` cells long, one cell deep, on a base of `value`."""
    flat = state.reshape(-1)
    found = []
    width = state.shape[1]
    for along, up in ((1, -width), (1, width), (width, -1), (width, 1)):
        # first cells of runs: the cell before and the cells on the tip side differ, the base extends before the run
        at = near[flat[near] == value]
        for offset, wanted in (
            (-along, not value),
            (up, not value),
            (up - along, not value),
            (-up, value),
            (-up - along, value),
        ):
            at = at[flat[at + offset] == wanted]
        for length in range(1, longest + 1):
            end = at + length * along  # one past the run
            closed = flat[end] != value
            closed &= (flat[end + up] != value) & (flat[end - up] == value)
            found += [at[closed] + step * along for step in range(length)]
            goes_on = (flat[end] == value) & (flat[end + up] != value) & (flat[end - up] == value)
            at = at[goes_on]
    return np.concatenate(found)
